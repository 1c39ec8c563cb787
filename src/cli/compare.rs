//! `glowworm compare`: error metrics of a picture or a sequence against its reference.

use std::ops::RangeInclusive;
use std::path::PathBuf;

use super::compare_report::{self, CompareReport};
use super::options::{ReportOptions, count};
use super::progress::frames_bar;
use super::{CliError, say};
use crate::metrics::{
    CompareOptions, Comparison, Encoding, Image, MetricsError, PixelError, Sequence, SequenceMetrics,
    pixel_errors,
};
use crate::output::{NumberedPath, OutputError, OutputFile};
use crate::plot::{Heatmap, PlotFile, round_limit, short};
use crate::statistics::percentile;

/// Help after the options.
const HELP: &str = "\
Two .png are compared by their sRGB values as they are, two .exr by their linear ones: MAE, RMSE and relative \
MSE. Luminance is linear in both cases: ratio of the means, relative errors of pixels and blocks, temporal \
error. FLIP of .exr is HDR-FLIP. A name with {frame} or {frame:04} stands for a sequence.";

/// Options of `compare`.
#[derive(Clone, Debug, clap::Args)]
#[command(args_override_self = true, after_help = HELP)]
pub(super) struct CompareArguments {
    /// Picture to compare: .png, .exr or .hdr.
    pub image: PathBuf,
    /// Reference: a picture of the same size and kind; for a sequence, also a single picture for all frames.
    pub reference: PathBuf,
    /// Layer of an .exr to compare, such as direct or indirect. Otherwise the first with R, G and B (or Y).
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Layer of the reference, if not that of --layer; "" for the first.
    #[arg(long, value_name = "NAME")]
    pub reference_layer: Option<String>,
    /// Exposure of an .exr in stops for PSNR and SSIM, which compare display values: clamped to 0..1 and encoded as
    /// sRGB. No other metric depends on it.
    /// [default: 0]
    #[arg(long, value_name = "EV", value_parser = parse_stops, allow_negative_numbers = true)]
    pub exposure: Option<f32>,
    /// Side in pixels of the blocks whose mean luminances are compared.
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = count::<u32>(1..=1 << 20))]
    pub blocks: u32,
    /// Also measure display luminance, Rec. 709 weights on display values: RMSE, SSIM and, for a sequence, temporal error.
    #[arg(long)]
    pub luminance: bool,
    /// Frames of a sequence to compare, such as 16-31. Otherwise all that exist, without gaps.
    #[arg(long, value_name = "FIRST-LAST", value_parser = parse_frames)]
    pub frames: Option<RangeInclusive<u64>>,
    /// Draw the error as a .png with its scale; of a sequence the last frame, or every frame if the name has a
    /// {frame}.
    #[arg(long, value_name = "FILE", help_heading = "Files")]
    pub heatmap: Option<PathBuf>,
    /// Error of the heat map: flip; relative, the relative error of luminance; absolute, the mean absolute error of
    /// the three channels.
    #[arg(long, value_name = "WHAT", default_value = "flip", requires = "heatmap", help_heading = "Files")]
    pub heatmap_of: HeatmapOf,
    /// Value of the heat map's brightest colour. Otherwise 1 for flip, else about the 99th percentile.
    #[arg(long, value_name = "VALUE", value_parser = parse_limit, requires = "heatmap", help_heading = "Files")]
    pub heatmap_limit: Option<f64>,
    /// Plot the metrics of a sequence over its frames: .svg or .png.
    #[arg(long, value_name = "FILE", help_heading = "Files")]
    pub plot: Option<PathBuf>,
    #[command(flatten)]
    pub report: ReportOptions,
}

/// Error of a heat map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum HeatmapOf {
    Flip,
    Relative,
    Absolute,
}

/// Inputs and outputs of a comparison, with checked names.
struct Job<'a> {
    arguments: &'a CompareArguments,
    image: NumberedPath,
    reference: NumberedPath,
    /// Frame 0 for a single picture.
    frames: RangeInclusive<u64>,
    heatmap: Option<NumberedPath>,
    plot: Option<PlotFile>,
    json: Option<OutputFile>,
}

/// Compares, and prints, writes and plots the result.
pub(super) fn compare(arguments: &CompareArguments) -> Result<(), CliError> {
    let job = Job::new(arguments)?;
    let report = job.run()?;
    if let Some(plot) = &job.plot {
        plot.save(&compare_report::curves(&report))?;
    }
    if let Some(json) = &job.json {
        json.save_json(&report)?;
    }
    say::print(&compare_report::table(&report))
}

impl<'a> Job<'a> {
    fn new(arguments: &'a CompareArguments) -> Result<Self, CliError> {
        let [image, reference] = [&arguments.image, &arguments.reference].map(NumberedPath::new);
        let (image, reference) = (image?, reference?);
        check_sequence_options(arguments, &image, &reference)?;
        let heatmap = arguments.heatmap.as_ref().map(NumberedPath::new).transpose()?;
        if let Some(heatmap) = &heatmap
            && heatmap.path().extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("png"))
        {
            return Err(CliError::Usage(format!("--heatmap {}: must end in .png", heatmap.path().display())));
        }
        let plot = arguments.plot.as_ref().map(PlotFile::new).transpose()?;
        let json = arguments.report.check(plot.iter().map(|plot| plot.file().path().to_owned()))?;
        let frames = match &arguments.frames {
            Some(frames) => given_frames(frames, &image, &reference)?,
            None if image.is_sequence() => all_frames(&image, &reference)?,
            None => 0..=0,
        };
        let job = Self { arguments, image, reference, frames, heatmap, plot, json };
        job.check_apart()?;
        let heatmaps = job.heatmap.iter().flat_map(|heatmap| {
            let drawn = job.frames.clone().filter(|&frame| job.is_drawn(heatmap, frame));
            drawn.map(|frame| heatmap.path_of(frame))
        });
        arguments.report.check_new(heatmaps)?;
        Ok(job)
    }

    /// Fails if an output would overwrite another output or any frame of an input.
    fn check_apart(&self) -> Result<(), CliError> {
        let check = |option: &str, file: &OutputFile, taken: &[(&str, &NumberedPath)]| match taken
            .iter()
            .find(|(_, name)| name.covers(file, 0..u64::MAX))
        {
            None => Ok(()),
            Some((taken, _)) => Err(CliError::Usage(format!(
                "{option} {}: would overwrite a file of {taken}; give it another name",
                file.path().display()
            ))),
        };
        let mut taken = vec![("IMAGE", &self.image), ("REFERENCE", &self.reference)];
        if let Some(heatmap) = &self.heatmap {
            for frame in self.frames.clone().filter(|&frame| self.is_drawn(heatmap, frame)) {
                check("--heatmap", &OutputFile::new(heatmap.path_of(frame))?, &taken)?;
            }
            taken.push(("--heatmap", heatmap));
        }
        let plot = self.plot.as_ref().map(PlotFile::file);
        plot.map_or(Ok(()), |plot| check("--plot", plot, &taken))?;
        self.json.as_ref().map_or(Ok(()), |json| check("--json", json, &taken))?;
        match (plot, &self.json) {
            (Some(plot), Some(json)) if json.is_same(plot.path()) => {
                Err(CliError::Usage("--plot and --json: give them different names".to_owned()))
            }
            _ => Ok(()),
        }
    }

    /// Whether this frame gets a heat map: every one, or the last.
    fn is_drawn(&self, heatmap: &NumberedPath, frame: u64) -> bool {
        heatmap.is_sequence() || frame == *self.frames.end()
    }

    /// Compares all frames and draws their heat maps.
    fn run(&self) -> Result<CompareReport, CliError> {
        let still = if self.reference.is_sequence() { None } else { Some(self.read_reference(0)?) };
        let options = CompareOptions {
            exposure: self.arguments.exposure.unwrap_or_default(),
            block_side: self.arguments.blocks as usize,
            luminance: self.arguments.luminance,
        };
        let mut sequence = Sequence::new(options, still.is_some());
        let progress = frames_bar(self.frames.end() - self.frames.start() + 1);
        let mut last = None;
        for frame in self.frames.clone() {
            let image = self.read_image(frame)?;
            let moving;
            let reference = match &still {
                Some(still) => still,
                None => {
                    moving = self.read_reference(frame)?;
                    &moving
                }
            };
            let comparison = sequence.push(frame, &image, reference)?;
            self.draw_heatmap(frame, &image, reference, &comparison)?;
            last = Some(comparison);
            progress.inc(1);
        }
        progress.finish_and_clear();
        let Some((metrics, last)) = sequence.finish().zip(last) else {
            return Err(MetricsError::NoFrames(self.arguments.image.clone()).into());
        };
        Ok(self.report(metrics, &last))
    }

    fn report(&self, mut metrics: SequenceMetrics, last: &Comparison) -> CompareReport {
        if !self.image.is_sequence() {
            metrics.frames.clear();
        }
        CompareReport {
            image: self.arguments.image.display().to_string(),
            reference: self.arguments.reference.display().to_string(),
            layer: self.arguments.layer.clone(),
            reference_layer: self.arguments.reference_layer.clone(),
            width: last.size[0],
            height: last.size[1],
            encoding: last.encoding,
            exposure: (last.encoding == Encoding::Linear)
                .then(|| self.arguments.exposure.unwrap_or_default()),
            flip_exposures: last.exposures,
            metrics,
        }
    }

    fn read_image(&self, frame: u64) -> Result<Image, CliError> {
        let image = Image::read(&self.image.path_of(frame), self.arguments.layer.as_deref())?;
        if self.arguments.exposure.is_some() && image.encoding() == Encoding::Display {
            return Err(CliError::Usage(format!(
                "--exposure: {} is a PNG, which has no exposure; omit the option",
                image.name()
            )));
        }
        Ok(image)
    }

    fn read_reference(&self, frame: u64) -> Result<Image, CliError> {
        let layer = self.arguments.reference_layer.as_ref().or(self.arguments.layer.as_ref());
        let layer = layer.map(String::as_str).filter(|layer| !layer.is_empty());
        Ok(Image::read(&self.reference.path_of(frame), layer)?)
    }

    fn draw_heatmap(
        &self,
        frame: u64,
        image: &Image,
        reference: &Image,
        comparison: &Comparison,
    ) -> Result<(), CliError> {
        let Some(target) = self.heatmap.as_ref().filter(|target| self.is_drawn(target, frame)) else {
            return Ok(());
        };
        let metrics = &comparison.metrics;
        let flip = if comparison.exposures.is_some() { "HDR-FLIP error" } else { "FLIP error" };
        let (kind, name, mean) = match self.arguments.heatmap_of {
            HeatmapOf::Flip => (None, flip, metrics.flip),
            HeatmapOf::Relative => {
                (Some(PixelError::Relative), "relative error of luminance", metrics.mean_relative_error)
            }
            HeatmapOf::Absolute => (Some(PixelError::Absolute), "absolute error", metrics.mae),
        };
        let errors = kind.map(|kind| pixel_errors(image, reference, kind)).transpose()?;
        let values = errors.as_ref().unwrap_or(&comparison.flip_errors);
        let limit = self.arguments.heatmap_limit.unwrap_or_else(|| match kind {
            None => 1.0,
            Some(_) => round_limit(percentile(values.iter().copied(), 0.99).unwrap_or_default().into()),
        });
        let of_frame = if self.image.is_sequence() { format!("frame {frame}: ") } else { String::new() };
        let title = format!("{of_frame}{name}, mean {}", short(mean));
        let heatmap = Heatmap { title, size: comparison.size, values, limit };
        Ok(heatmap.save(&OutputFile::new(target.path_of(frame))?)?)
    }
}

/// Fails if options or a reference for sequences are given for a single picture.
fn check_sequence_options(
    arguments: &CompareArguments,
    image: &NumberedPath,
    reference: &NumberedPath,
) -> Result<(), CliError> {
    if image.is_sequence() {
        return Ok(());
    }
    let name = image.path().display();
    let message = if reference.is_sequence() {
        format!("{name}: a single picture cannot be compared with a sequence; put {{frame}} into its name")
    } else if arguments.frames.is_some() {
        format!("--frames: {name} is a single picture; put {{frame}} into its name")
    } else if arguments.plot.is_some() {
        format!("--plot: {name} is a single picture, which makes no curve; put {{frame}} into its name")
    } else {
        return Ok(());
    };
    Err(CliError::Usage(message))
}

/// The requested frames, if all exist.
fn given_frames(
    frames: &RangeInclusive<u64>,
    image: &NumberedPath,
    reference: &NumberedPath,
) -> Result<RangeInclusive<u64>, MetricsError> {
    for path in frames.clone().flat_map(|frame| [image.path_of(frame), reference.path_of(frame)]) {
        if let Err(source) = std::fs::metadata(&path) {
            return Err(OutputError::Read { path, source }.into());
        }
    }
    Ok(frames.clone())
}

/// All frames of both sequences, if neither has gaps.
fn all_frames(image: &NumberedPath, reference: &NumberedPath) -> Result<RangeInclusive<u64>, MetricsError> {
    let on_disk = |name: &NumberedPath| {
        let frames = name.frames_on_disk();
        frames.map_err(|source| OutputError::Read { path: name.path().to_path_buf(), source })
    };
    let frames = on_disk(image)?;
    let (Some(&first), Some(&last)) = (frames.first(), frames.last()) else {
        return Err(MetricsError::NoFrames(image.path().to_path_buf()));
    };
    if let Some((missing, &next)) = (first..).zip(&frames).find(|(expected, frame)| expected != *frame) {
        return Err(MetricsError::MissingFrame {
            missing: image.path_of(missing),
            there: image.path_of(next),
        });
    }
    if reference.is_sequence() {
        let reference_frames = on_disk(reference)?;
        let lacks = |a: &[u64], b: &[u64]| b.iter().copied().find(|frame| a.binary_search(frame).is_err());
        for (a, a_frames, b, b_frames) in
            [(reference, &reference_frames, image, &frames), (image, &frames, reference, &reference_frames)]
        {
            if let Some(frame) = lacks(a_frames, b_frames) {
                return Err(MetricsError::MissingFrame {
                    missing: a.path_of(frame),
                    there: b.path_of(frame),
                });
            }
        }
    }
    Ok(first..=last)
}

/// `3-7` -> 3 to 7.
fn parse_frames(text: &str) -> Result<RangeInclusive<u64>, String> {
    let frames =
        text.split_once('-').and_then(|(first, last)| Some(first.parse().ok()?..=last.parse().ok()?));
    let most = 1_000_000;
    frames
        .filter(|frames| !frames.is_empty() && *frames.end() < most)
        .ok_or_else(|| format!("must be two numbers below {most}, the lower one first, such as 0-31"))
}

fn parse_stops(text: &str) -> Result<f32, String> {
    text.parse()
        .ok()
        .filter(|stops: &f32| stops.abs() <= 100.0)
        .ok_or_else(|| "must be stops such as -1.5".to_owned())
}

fn parse_limit(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|limit: &f64| *limit > 0.0 && limit.is_finite())
        .ok_or_else(|| "must be a number above 0 such as 0.5".to_owned())
}
