//! Motion of what each pixel sees since the frame before, on the CPU.

use glam::{Vec2, Vec3};

use super::files::FrameState;
use crate::output::{Layer, Picture};

/// As a fraction of the picture, right and down; 0 on the background. In: a picture with the layers `position` and `instance`, and where
/// everything stands now and stood then.
pub(super) fn motion(picture: &Picture, now: &FrameState, then: &FrameState) -> Vec<[f32; 2]> {
    let layer = |name: &str| picture.layers.iter().find(|layer| layer.name == name);
    let (Some(position), Some(instance)) = (layer("position"), layer("instance")) else { return Vec::new() };
    let seen = |state: &FrameState, point: Vec3| {
        let clip = state.view_projection * point.extend(1.0);
        clip.truncate().truncate() / clip.w / 2.0
    };
    let of = |pixel: usize| {
        let id = instance.channels[0].1[pixel];
        if id < 0.0 {
            return Vec2::ZERO;
        }
        let at = at(position, pixel);
        let moved = then.instances[id as usize] * now.instances[id as usize].inverse();
        seen(now, at) - seen(then, moved.transform_point3(at))
    };
    (0..picture.width * picture.height).map(|pixel| of(pixel).to_array()).collect()
}

fn at(layer: &Layer, pixel: usize) -> Vec3 {
    Vec3::from([0, 1, 2].map(|channel| layer.channels[channel].1[pixel]))
}
