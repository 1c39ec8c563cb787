//! Picture quality of a run.
//!
//! In: pictures of selected frames of a run, and the path tracer's of the same moments, with as many bounces. Out: errors of
//! each; the behaviour of the picture when all motion stops after the last frame; and how long a still picture takes from a
//! fresh start, with its error.

use super::method::Method;
use super::plan::Plan;
use super::run::{FrameQuality, Still};
use super::source::{BenchScene, FrameSource, trace};
use super::{BenchError, Control};
use crate::metrics::{CompareOptions, Comparison, Image, compare, temporal_error};
use crate::output::{Picture, automatic_exposure, tone_map};
use crate::reference::{Reference, ReferenceSettings};
use crate::settings::{Settings, ToneMap};

/// Pictures to compare in each run.
const FRAMES: u32 = 4;
/// Frames that most methods take to settle, for the remaining time.
pub(super) const LIKELY_SETTLING: u32 = 40;
/// Frames over which the temporal error is measured.
const STILL_FRAMES: usize = 8;

/// The frames to compare: evenly spaced, including the last one.
pub fn chosen_frames(frames: u32) -> Vec<u32> {
    let mut chosen: Vec<u32> = (1..=FRAMES).map(|part| (frames * part / FRAMES).max(1) - 1).collect();
    chosen.dedup();
    chosen
}

/// The path tracer's pictures of the selected frames.
pub(super) struct ReferencePictures {
    settings: ReferenceSettings,
    /// At least one.
    frames: Vec<(u32, Picture)>,
}

impl ReferencePictures {
    /// Finds the pictures for runs with `settings` in `known`, or path traces and adds them.
    pub fn of<'a>(
        known: &'a mut Vec<Self>,
        scene: &BenchScene,
        settings: &Settings,
        plan: &Plan,
        control: &mut Control<'_>,
    ) -> Result<&'a Self, BenchError> {
        let at = known.iter().position(|reference| reference.serves(settings));
        if at.is_none() {
            known.push(Self::render(scene, settings, plan, control)?);
        }
        Ok(&known[at.unwrap_or(known.len() - 1)])
    }

    /// The selected pictures of a run with `settings` in their place.
    pub fn of_run(settings: &Settings, frames: Vec<(u32, Picture)>) -> Self {
        Self { settings: reference_settings(settings), frames }
    }

    fn render(
        scene: &BenchScene,
        settings: &Settings,
        plan: &Plan,
        control: &mut Control<'_>,
    ) -> Result<Self, BenchError> {
        let tracer = reference_settings(settings);
        let mut pictures = Vec::new();
        for frame in chosen_frames(plan.frames) {
            let pose = scene.pose(frame.into(), settings);
            let reference = Reference::new(&scene.scene, &pose, &tracer);
            let film = trace(&reference, settings.size, plan.spp, control)?;
            let mut picture = film.picture();
            tone_map(&mut picture, settings.into(), film.metered());
            pictures.push((frame, picture));
        }
        Ok(Self { settings: tracer, frames: pictures })
    }

    /// Whether they apply to runs with `settings`.
    pub fn serves(&self, settings: &Settings) -> bool {
        self.settings == reference_settings(settings)
    }

    /// The last selected frame.
    pub fn last(&self) -> (u32, &Picture) {
        let (frame, picture) = &self.frames[self.frames.len() - 1];
        (*frame, picture)
    }

    /// The picture of a selected frame.
    fn picture(&self, frame: u32) -> Option<&Picture> {
        self.frames.iter().find(|(known, _)| *known == frame).map(|(_, picture)| picture)
    }

    /// The errors of the pictures of selected frames.
    pub fn errors(&self, pictures: &[(u32, Picture)]) -> Result<Vec<FrameQuality>, BenchError> {
        let pairs =
            pictures.iter().filter_map(|(frame, picture)| Some((*frame, picture, self.picture(*frame)?)));
        pairs
            .map(|(frame, picture, reference)| {
                Ok(FrameQuality::of(frame, &compare_with(picture, reference)?))
            })
            .collect()
    }
}

/// The settings of the path tracer's pictures, whose samples are independent of a run's.
pub(super) fn reference_settings(settings: &Settings) -> ReferenceSettings {
    ReferenceSettings { seed: !settings.seed, ..ReferenceSettings::like(settings) }
}

/// Compares a picture with the path tracer's, at the exposure of the latter.
pub(super) fn compare_with(picture: &Picture, reference: &Picture) -> Result<Comparison, BenchError> {
    let exposure = automatic_exposure(reference, ToneMap::None, std::iter::repeat(1.0)).log2();
    let options = CompareOptions { exposure, ..CompareOptions::default() };
    Ok(compare(&image(picture)?, &image(reference)?, &options)?)
}

fn image(picture: &Picture) -> Result<Image, BenchError> {
    Ok(Image::from_linear("picture", [picture.width, picture.height], picture.colour.clone())?)
}

/// Stops all motion at the last of `frames` frames; returns the settling frames and the temporal error after them.
pub(super) fn stop(
    scene: &BenchScene,
    source: &mut FrameSource,
    settings: &Settings,
    frames: u32,
    control: &mut Control<'_>,
) -> Result<(u32, f64), BenchError> {
    let pose = scene.pose(i64::from(frames) - 1, settings);
    source.set_settings(settings, &pose)?;
    let mut last = source.picture()?.colour;
    let mut settling_frames = 0;
    let mut still = Vec::new();
    for number in 1.. {
        source.render(&pose, control)?;
        let picture = source.picture()?;
        if picture.colour != last {
            settling_frames = number;
        }
        last = picture.colour;
        if source.rests() {
            break;
        }
    }
    for _ in 0..STILL_FRAMES {
        source.render(&pose, control)?;
        still.push(image(&source.picture()?)?);
    }
    Ok((settling_frames, temporal_error(&still)?.unwrap_or(0.0)))
}

/// The last moment of `frames` frames from a fresh start. Pipelines have been built.
pub(super) fn still(
    scene: &BenchScene,
    method: &Method,
    settings: &Settings,
    reference: &ReferencePictures,
    control: &mut Control<'_>,
) -> Result<Still, BenchError> {
    let (frame, reference) = reference.last();
    let pose = scene.pose(frame.into(), settings);
    let mut source = FrameSource::new(scene, method, settings, &pose)?;
    let mut last = Picture::default();
    let (mut frames, mut ms, mut total_ms) = (0, 0.0, 0.0);
    for number in 1.. {
        total_ms += source.render(&pose, control)?.0;
        let picture = source.picture()?;
        if picture.colour != last.colour {
            (frames, ms) = (number, total_ms);
        }
        last = picture;
        if source.rests() {
            break;
        }
    }
    Ok(Still { frames, ms, error: FrameQuality::of(frame, &compare_with(&last, reference)?) })
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
