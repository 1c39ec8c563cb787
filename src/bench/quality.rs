//! What speed costs in picture quality.
//!
//! In: pictures of chosen frames of a measured run, and converged ones of the same moments. Out: errors of each, and
//! how the picture behaves once everything stands still after the last frame. A converged picture comes from the same
//! renderer with 16 times the VPLs in a single temporal set, all of them shot for that very moment: so the error is what
//! few VPLs and sets from earlier frames cost, not what the method itself leaves out.

use serde::{Deserialize, Serialize};

use super::run::Stage;
use super::{BenchError, Control};
use crate::metrics::{CompareOptions, Image, compare, temporal_error};
use crate::output::{Picture, automatic_exposure};
use crate::renderer::Renderer;
use crate::settings::Settings;
use crate::statistics::mean;

/// Pictures that are compared in each run.
const FRAMES: u32 = 4;
/// Times as many VPLs as the run has.
const CONVERGED: u32 = 16;
/// Most VPLs that there may be.
const MOST_VPLS: u32 = 65_536;
/// Frames of the stretch over which the temporal error is taken.
const STILL_FRAMES: usize = 8;

/// How good the pictures of a run are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// The chosen frames.
    pub frames: Vec<FrameQuality>,
    /// Frames until the picture stands still after everything has come to a stop.
    pub settling_frames: u32,
    /// Mean absolute change of luminance from frame to frame after that (Schied et al. 2017), W/m^2/sr.
    pub temporal_error: f64,
}

/// How far one picture is from the converged one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameQuality {
    /// Number of the frame.
    pub frame: u32,
    /// Mean HDR-FLIP error, 0 to 1.
    pub flip: f64,
    /// Structural similarity of what would be shown at the exposure of the converged picture.
    pub ssim: f64,
    /// Mean relative error of luminance; none where the converged picture is black.
    pub relative_error: Option<f64>,
}

impl Quality {
    /// Mean of a figure over the chosen frames.
    pub fn mean(&self, figure: fn(&FrameQuality) -> f64) -> f64 {
        mean(&self.frames.iter().map(figure).collect::<Vec<_>>())
    }

    /// Mean relative error over those frames that have one.
    pub fn relative_error(&self) -> Option<f64> {
        let errors: Vec<f64> = self.frames.iter().filter_map(|frame| frame.relative_error).collect();
        (!errors.is_empty()).then(|| mean(&errors))
    }
}

/// The frames whose pictures are compared: spread over the run, the last one among them.
pub fn chosen_frames(frames: u32) -> Vec<u32> {
    let mut chosen: Vec<u32> = (1..=FRAMES).map(|part| (frames * part / FRAMES).max(1) - 1).collect();
    chosen.dedup();
    chosen
}

/// Converged pictures of the chosen frames.
pub(super) struct Converged {
    /// All that decides them: the settings but for the number of temporal sets.
    settings: Settings,
    frames: Vec<(u32, Picture)>,
}

impl Converged {
    /// Renders them for runs like that of `settings`.
    pub fn render(
        stage: &Stage,
        settings: &Settings,
        frames: u32,
        control: &mut Control<'_>,
    ) -> Result<Self, BenchError> {
        let many = converged_settings(settings);
        let mut pictures = Vec::new();
        for frame in chosen_frames(frames) {
            let pose = stage.pose(frame.into(), &many);
            let mut renderer = stage.renderer(&many, &pose)?;
            renderer.render(&pose)?;
            pictures.push((frame, renderer.read_picture(false)?));
            control.frame_done(&many)?;
        }
        Ok(Self { settings: many, frames: pictures })
    }

    /// Whether they are those for runs like that of `settings`.
    pub fn serves(&self, settings: &Settings) -> bool {
        self.settings == converged_settings(settings)
    }

    /// Compares the pictures of a run with them.
    pub fn compare(&self, pictures: &[(u32, Picture)]) -> Result<Vec<FrameQuality>, BenchError> {
        let pairs = pictures.iter().filter_map(|(frame, picture)| {
            let (_, converged) = self.frames.iter().find(|(known, _)| known == frame)?;
            Some((*frame, picture, converged))
        });
        pairs.map(|(frame, picture, converged)| compare_frame(frame, picture, converged)).collect()
    }
}

/// The settings that converged pictures are rendered with.
pub(super) fn converged_settings(settings: &Settings) -> Settings {
    Settings { temporal_sets: 1, vpls: (settings.vpls * CONVERGED).min(MOST_VPLS), ..settings.clone() }
}

fn compare_frame(frame: u32, picture: &Picture, converged: &Picture) -> Result<FrameQuality, BenchError> {
    let exposure = automatic_exposure(converged, std::iter::repeat(true)).log2();
    let options = CompareOptions { exposure, ..CompareOptions::default() };
    let metrics = compare(&image(picture)?, &image(converged)?, &options)?.metrics;
    let relative_error = Some(metrics.mean_relative_error).filter(|error| error.is_finite());
    Ok(FrameQuality { frame, flip: metrics.flip, ssim: metrics.ssim, relative_error })
}

fn image(picture: &Picture) -> Result<Image, BenchError> {
    Ok(Image::from_linear("picture", [picture.width, picture.height], picture.colour.clone())?)
}

/// Most frames that pass until nothing changes any more: all slots are shot again, then all sets drawn.
pub(super) fn longest_settling(settings: &Settings) -> u32 {
    settings.vpls.div_ceil(settings.budget) + settings.temporal_sets + 2
}

/// Everything stays where it is in the last of `frames` frames: how long the picture goes on changing, and how much
/// it changes afterwards.
pub(super) fn stop(
    stage: &Stage,
    renderer: &mut Renderer,
    settings: &Settings,
    frames: u32,
    control: &mut Control<'_>,
) -> Result<(u32, f64), BenchError> {
    let pose = stage.pose(i64::from(frames) - 1, settings);
    let mut last = renderer.read_picture(false)?.colour;
    let mut settling_frames = 0;
    let mut still = Vec::new();
    let longest = longest_settling(settings);
    for number in 1..=longest + STILL_FRAMES as u32 {
        renderer.render(&pose)?;
        let picture = renderer.read_picture(false)?;
        control.frame_done(settings)?;
        if number > longest {
            still.push(image(&picture)?);
        } else if picture.colour != last {
            settling_frames = number;
        }
        last = picture.colour;
    }
    Ok((settling_frames, temporal_error(&still)?.unwrap_or(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chosen_frames_are_spread_and_end_with_the_last() {
        assert_eq!(chosen_frames(60), [14, 29, 44, 59]);
        assert_eq!(chosen_frames(5), [0, 1, 2, 4]);
        assert_eq!(chosen_frames(2), [0, 1]);
        assert_eq!(chosen_frames(1), [0]);
    }
}
