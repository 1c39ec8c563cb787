//! Pictures for the report: each scene at its beginning and end, and what a moving camera does to a picture.

use serde::{Deserialize, Serialize};

use super::run::Stage;
use super::{BenchError, Control};
use crate::output::Picture;
use crate::scene::{Camera, Pose};
use crate::settings::Settings;

/// Degrees that the camera turns in a second.
const TURNING_SPEED: f32 = 30.0;
/// Seconds in which the strafing camera passes the width of what it sees at the distance that it looks at.
const STRAFING_TIME: f32 = 2.0;

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PictureKind {
    /// The first measured frame.
    Beginning,
    /// The last measured frame.
    End,
    /// The camera stands still.
    Static,
    /// It turns down.
    Turning,
    /// It moves to the right.
    Strafing,
}

impl PictureKind {
    /// Those of a moving camera, with the standing one to compare.
    pub const ARTEFACTS: [Self; 3] = [Self::Static, Self::Turning, Self::Strafing];

    /// What stands under it.
    pub fn caption(self) -> &'static str {
        match self {
            Self::Beginning => "beginning",
            Self::End => "end",
            Self::Static => "standing still",
            Self::Turning => "turning down",
            Self::Strafing => "strafing right",
        }
    }

    fn file_name(self) -> &'static str {
        match self {
            Self::Beginning => "beginning",
            Self::End => "end",
            Self::Static => "static",
            Self::Turning => "turning",
            Self::Strafing => "strafing",
        }
    }
}

/// A picture of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PictureEntry {
    /// Name of the scene.
    pub scene: String,
    /// What it shows.
    pub kind: PictureKind,
    /// Temporal sets that it was rendered with.
    pub temporal_sets: u32,
    /// Its name in the folder of pictures.
    pub file: String,
}

impl PictureEntry {
    /// That of number `index` of the scenes, whose name may not suit a file.
    pub fn new(index: usize, scene: &str, kind: PictureKind, temporal_sets: u32) -> Self {
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' };
        let name: String = scene.chars().map(plain).collect();
        let file = format!("{}-{name}-{}.png", index + 1, kind.file_name());
        Self { scene: scene.to_owned(), kind, temporal_sets, file }
    }

    /// Whether its file is one that [`Self::new`] could have named: what was read may be anybody's.
    pub fn is_sound(&self) -> bool {
        let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
        self.file.chars().all(plain) && self.file.ends_with(".png") && !self.file.starts_with('.')
    }
}

/// Renders the picture of a camera that is on the move and is now where the scene has it; nothing else moves.
pub(super) fn artefact(
    stage: &Stage,
    settings: &Settings,
    kind: PictureKind,
    control: &mut Control<'_>,
) -> Result<Picture, BenchError> {
    let rest = stage.pose(0, settings);
    let frames = artefact_frames(settings);
    let pose = |frame: u32| {
        let seconds = -((frames - 1 - frame) as f32) * settings.time_step as f32;
        let aspect = settings.size[0] as f32 / settings.size[1] as f32;
        Pose { camera: moved(&rest.camera, kind, seconds, aspect), ..rest.clone() }
    };
    let mut renderer = stage.renderer(settings, &pose(0))?;
    for frame in 0..frames {
        renderer.render(&pose(frame))?;
        renderer.finish()?;
        control.frame_done(settings)?;
    }
    Ok(renderer.read_picture(false)?)
}

/// Frames that the camera moves: every set buffer is drawn on the way twice.
pub(super) fn artefact_frames(settings: &Settings) -> u32 {
    2 * settings.temporal_sets
}

/// Where the camera is `seconds` after it has passed its own place.
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
        PictureKind::Static | PictureKind::Beginning | PictureKind::End => *camera,
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
        let entry = PictureEntry::new(0, "../a b", PictureKind::End, 4);
        assert_eq!(entry.file, "1-___a_b-end.png");
        assert!(entry.is_sound());
        for file in ["../a.png", "a.exr", ".png", "a/b.png"] {
            assert!(!PictureEntry { file: file.to_owned(), ..entry.clone() }.is_sound(), "{file}");
        }
    }
}
