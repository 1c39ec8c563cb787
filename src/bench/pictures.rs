//! Pictures for the report: the first and last frame of each scene, and artefacts of camera motion.

use super::control::work_of_frame;
use super::report::{PictureEntry, PictureKind};
use super::run::Run;
use super::source::{BenchScene, warm_up};
use super::{Bench, BenchError, Control};
use crate::output::Picture;
use crate::scene::{Camera, Pose};
use crate::settings::Settings;

/// Rotation of the camera, degrees per second.
const TURNING_SPEED: f32 = 30.0;
/// Time in which the strafing camera moves by the width of its view at the target's distance, seconds.
const STRAFING_TIME: f32 = 2.0;

impl Bench {
    /// Whether this run takes the scene's first and last picture: the representative one.
    pub(super) fn wants_ends(&self, at: usize) -> bool {
        let run = &self.report.runs[at];
        let shown = self.report.shown_run(&run.scene);
        self.folder.is_some() && run.rounds.is_empty() && shown.is_some_and(|shown| shown.is_same(run))
    }

    /// The run, whose pictures take the most frames, for missing pictures of a moving camera.
    pub(super) fn missing_artefacts<'a>(&'a self, scene: &'a str) -> Option<&'a Run> {
        let taken = |kind: PictureKind| {
            self.report.pictures.iter().any(|picture| picture.scene == scene && picture.kind == kind)
        };
        if self.folder.is_none() || PictureKind::ARTEFACTS.into_iter().all(taken) {
            return None;
        }
        let runs = || self.report.runs_of(scene).filter(|run| run.method.samples().is_none());
        runs().rev().max_by_key(|run| run.completes_in())
    }

    pub(super) fn take_artefacts(
        &mut self,
        index: usize,
        scene: &BenchScene,
        control: &mut Control<'_>,
    ) -> Result<(), BenchError> {
        let Some(run) = self.missing_artefacts(&scene.scene.name) else { return Ok(()) };
        let settings = run.settings.clone();
        let (planned, done) = self.runs();
        control.runs = [done, planned];
        for kind in PictureKind::ARTEFACTS {
            control.begin(format!("{}: the camera {}", scene.scene.name, kind.caption()));
            let picture = artefact(scene, &settings, kind, control)?;
            self.keep_picture(self.entry(index, kind, &settings), &picture)?;
        }
        self.keep()
    }

    pub(super) fn entry(&self, scene: usize, kind: PictureKind, settings: &Settings) -> PictureEntry {
        PictureEntry::new(scene, &self.report.scenes[scene].name, kind, settings)
    }

    pub(super) fn keep_picture(&mut self, entry: PictureEntry, picture: &Picture) -> Result<(), BenchError> {
        let Some(folder) = &self.folder else { return Ok(()) };
        folder.keep_picture(&entry, picture)?;
        self.report.pictures.retain(|known| known.file != entry.file);
        self.report.pictures.push(entry);
        Ok(())
    }
}

/// Renders the picture of a camera that moves through the scene's camera position; all else is stationary.
fn artefact(
    scene: &BenchScene,
    settings: &Settings,
    kind: PictureKind,
    control: &mut Control<'_>,
) -> Result<Picture, BenchError> {
    let rest = scene.pose(0, settings);
    let frames = artefact_frames(settings);
    let pose = |frame: u32| {
        let seconds = -((frames - 1 - frame) as f32) * settings.time_step as f32;
        let aspect = settings.size[0] as f32 / settings.size[1] as f32;
        Pose { camera: moved(&rest.camera, kind, seconds, aspect), ..rest.clone() }
    };
    let mut renderer = scene.renderer(settings, &pose(0))?;
    for frame in 0..frames {
        renderer.render(&pose(frame))?;
        renderer.finish()?;
        control.done(work_of_frame(settings, None))?;
    }
    Ok(renderer.read_picture(false)?)
}

/// Frames of camera motion: twice as many as the picture takes.
pub(super) fn artefact_frames(settings: &Settings) -> u32 {
    2 * warm_up(settings)
}

/// The camera `seconds` after passing its scene position.
fn moved(camera: &Camera, kind: PictureKind, seconds: f32, aspect: f32) -> Camera {
    let forward = camera.target - camera.eye;
    let right = forward.cross(camera.up).normalize_or_zero();
    match kind {
        PictureKind::Turning => {
            let turn = glam::Quat::from_axis_angle(right, -(TURNING_SPEED * seconds).to_radians());
            Camera { target: camera.eye + turn * forward, up: turn * camera.up, ..*camera }
        }
        PictureKind::Strafing => {
            let width = 2.0 * forward.length() * (camera.vertical_fov * 0.5).tan() * aspect;
            let way = right * (width * seconds / STRAFING_TIME);
            Camera { eye: camera.eye + way, target: camera.target + way, ..*camera }
        }
        _ => *camera,
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn the_camera_comes_from_above_and_from_the_left() {
        let camera = Camera::looking(Vec3::ZERO, Vec3::new(0.0, 0.0, -4.0));
        let before = |kind| moved(&camera, kind, -0.5, 1.0);
        let turning = before(PictureKind::Turning);
        assert!(turning.target.y > 0.9 && turning.eye == camera.eye, "{turning:?}");
        let strafing = before(PictureKind::Strafing);
        assert!(strafing.eye.x < -0.5 && strafing.forward() == camera.forward(), "{strafing:?}");
        for kind in PictureKind::ARTEFACTS {
            let now = moved(&camera, kind, 0.0, 1.0);
            assert!(now.eye.distance(camera.eye) + now.target.distance(camera.target) < 1e-6);
        }
    }

    #[test]
    fn files_are_plainly_named() {
        let entry = PictureEntry::new(0, "../a b", PictureKind::End, &Settings::default());
        assert_eq!(entry.file, "1-___a_b-end.png");
        assert!(entry.is_sound());
        for file in ["../a.png", "a.exr", ".png", "a/b.png"] {
            assert!(!PictureEntry { file: file.to_owned(), ..entry.clone() }.is_sound(), "{file}");
        }
    }
}
