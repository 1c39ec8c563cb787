//! Picture quality of a run.
//!
//! In: pictures of selected frames of a run, and converged ones of the same moments. Out: errors of each, and the
//! behaviour of the picture when all motion stops after the last frame. A converged picture comes from the same
//! renderer with 16 times the VPLs in a single temporal set, all shot for that moment: so the error is that of few
//! VPLs and of temporal reuse, not the bias of the method.

use serde::{Deserialize, Serialize};

use super::run::Stage;
use super::{BenchError, Control};
use crate::metrics::{CompareOptions, Image, compare, temporal_error};
use crate::output::{Picture, automatic_exposure};
use crate::renderer::Renderer;
use crate::settings::{Settings, VplSettings};
use crate::statistics::mean;

/// Pictures to compare in each run.
const FRAMES: u32 = 4;
/// Factor on the VPLs of a converged picture.
const CONVERGED: u32 = 16;
/// Limit of VPLs.
const MOST_VPLS: u32 = 65_536;
/// Frames over which the temporal error is measured.
const STILL_FRAMES: usize = 8;

/// Quality of the pictures of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// The selected frames.
    pub frames: Vec<FrameQuality>,
    /// Frames until the picture is stationary after all motion stops.
    pub settling_frames: u32,
    /// Mean absolute change of luminance from frame to frame after that (Schied et al. 2017), W/m^2/sr.
    pub temporal_error: f64,
}

/// Error of one picture against the converged one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameQuality {
    /// Number of the frame.
    pub frame: u32,
    /// Mean HDR-FLIP error, 0 to 1.
    pub flip: f64,
    /// Structural similarity of display values at the exposure of the converged picture.
    pub ssim: f64,
    /// Mean relative error of luminance; none where the converged picture is black.
    pub relative_error: Option<f64>,
}

impl Quality {
    /// Mean of a figure over the selected frames.
    pub fn mean(&self, figure: fn(&FrameQuality) -> f64) -> f64 {
        mean(&self.frames.iter().map(figure).collect::<Vec<_>>())
    }

    /// Mean relative error over those frames that have one.
    pub fn relative_error(&self) -> Option<f64> {
        let errors: Vec<f64> = self.frames.iter().filter_map(|frame| frame.relative_error).collect();
        (!errors.is_empty()).then(|| mean(&errors))
    }
}

/// The frames to compare: evenly spaced, including the last one.
pub fn chosen_frames(frames: u32) -> Vec<u32> {
    let mut chosen: Vec<u32> = (1..=FRAMES).map(|part| (frames * part / FRAMES).max(1) - 1).collect();
    chosen.dedup();
    chosen
}

/// Converged pictures of the selected frames.
pub(super) struct Converged {
    /// Their settings, except the number of temporal sets.
    settings: Settings,
    frames: Vec<(u32, Picture)>,
}

impl Converged {
    /// Renders them for runs with `settings`.
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

    /// Whether they apply to runs with `settings`.
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
    Settings {
        vpl: VplSettings {
            temporal_sets: 1,
            slots: (settings.vpl.slots * CONVERGED).min(MOST_VPLS),
            ..settings.vpl
        },
        ..settings.clone()
    }
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

/// Upper bound of the frames until the picture is stationary: all slots are shot again, then all sets drawn.
pub(super) fn longest_settling(settings: &Settings) -> u32 {
    settings.vpl.slots.div_ceil(settings.vpl.budget) + settings.vpl.temporal_sets + 2
}

/// Stops all motion at the last of `frames` frames; returns the settling frames and the temporal error after them.
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
