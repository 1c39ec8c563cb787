//! The animation of nodes as that of the scene.
//!
//! In: the first animation of a file. Out: for what a chain of nodes places, keyframes of its rigid motion relative to
//! the rest pose, close enough that between them the scene's interpolation does what the file's would. It repeats.

use std::collections::HashMap;

use ::gltf::animation::{Interpolation, Property};
use glam::{Affine3A, Quat, Vec3, Vec4};

use super::nodes::Placed;
use super::source::Source;
use crate::formats::error::SceneError;
use crate::scene::{Animation, Keyframe};

/// Longest time between two keyframes, seconds, and most keyframes.
const STEP: f64 = 1.0 / 60.0;
const MAX_STEPS: f64 = 20_000.0;

/// How long before a jump the value before it is kept.
const JUMP: f64 = 1e-4;

/// Longest animation, seconds.
const MAX_TIME: f32 = 1e6;

/// One property of a node over time.
struct Track {
    interpolation: Interpolation,
    times: Vec<f32>,
    /// With tangents before and after each value for cubic splines.
    values: Vec<Vec4>,
}

/// Rest pose and tracks of a node.
#[derive(Default)]
struct NodeMotion {
    translation: Option<Track>,
    rotation: Option<Track>,
}

/// The animation of a file's nodes.
pub(super) struct Motions {
    /// Translation, rotation and scale of each node at rest.
    rest: Vec<(Vec3, Quat, Vec3)>,
    nodes: HashMap<usize, NodeMotion>,
}

impl Motions {
    /// Reads the first animation.
    pub fn read(source: &mut Source) -> Result<Self, SceneError> {
        let document = source.document.clone();
        let rest = |node: ::gltf::Node<'_>| {
            let (translation, rotation, scale) = node.transform().decomposed();
            let rotation = Quat::from_array(rotation).normalize();
            (Vec3::from_array(translation), rotation, Vec3::from_array(scale))
        };
        let mut motions = Self { rest: document.nodes().map(rest).collect(), nodes: HashMap::new() };
        let Some(animation) = document.animations().next() else { return Ok(motions) };
        if document.animations().len() > 1 {
            source.not_shown.insert("animations but the first".to_owned());
        }
        for channel in animation.channels() {
            let (target, sampler) = (channel.target(), channel.sampler());
            let values = match target.property() {
                Property::Translation => {
                    let values = source.vectors::<3>(&sampler.output(), "translation")?;
                    values.into_iter().map(|value| Vec3::from_array(value).extend(0.0)).collect()
                }
                Property::Rotation => {
                    let values = source.vectors::<4>(&sampler.output(), "rotation")?;
                    values.into_iter().map(Vec4::from_array).collect()
                }
                Property::Scale | Property::MorphTargetWeights => {
                    source.not_shown.insert("animation of scale and shape".to_owned());
                    continue;
                }
            };
            let track = track_of(source, &sampler, values)?;
            let node = motions.nodes.entry(target.node().index()).or_default();
            match target.property() {
                Property::Translation => node.translation = Some(track),
                _ => node.rotation = Some(track),
            }
        }
        Ok(motions)
    }

    /// The motion of what `placed` places, if any node above it or itself moves.
    pub fn of(&self, placed: &Placed) -> Option<Animation> {
        let moving: Vec<&NodeMotion> = placed.chain.iter().filter_map(|node| self.nodes.get(node)).collect();
        let tracks = moving.iter().flat_map(|node| [&node.translation, &node.rotation]).flatten();
        let times = times_of(tracks)?;
        let pose = |transform: Affine3A| {
            let (_, rotation, translation) = transform.to_scale_rotation_translation();
            (rotation.normalize(), translation)
        };
        let (rest_rotation, rest_position) = pose(placed.transform);
        let keyframe = |time: f64| {
            let (rotation, position) = pose(self.transform(&placed.chain, time));
            Keyframe {
                time,
                translation: position - rest_position,
                rotation: (rotation * rest_rotation.inverse()).normalize(),
            }
        };
        let keyframes = times.into_iter().map(keyframe).collect();
        Some(Animation { keyframes, rotation: None, repeat: true })
    }

    /// Node to world of the last of `chain` at `time`.
    fn transform(&self, chain: &[usize], time: f64) -> Affine3A {
        let local = |node: &usize| {
            let (mut translation, mut rotation, scale) = self.rest[*node];
            if let Some(motion) = self.nodes.get(node) {
                if let Some(track) = &motion.translation {
                    translation = track.at(time, false).truncate();
                }
                if let Some(track) = &motion.rotation {
                    rotation = Quat::from_vec4(track.at(time, true)).normalize();
                }
            }
            Affine3A::from_scale_rotation_translation(scale, rotation, translation)
        };
        chain.iter().map(local).fold(Affine3A::IDENTITY, |above, local| above * local)
    }
}

fn track_of(
    source: &Source,
    sampler: &::gltf::animation::Sampler<'_>,
    values: Vec<Vec4>,
) -> Result<Track, SceneError> {
    let times: Vec<f32> =
        source.vectors::<1>(&sampler.input(), "times")?.into_iter().map(|[time]| time).collect();
    let interpolation = sampler.interpolation();
    let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let ascending = times.windows(2).all(|pair| pair[0] < pair[1]);
    let in_range = times.iter().all(|time| (0.0..=MAX_TIME).contains(time));
    if times.is_empty() || !ascending || !in_range || values.len() != per_key * times.len() {
        let problem = "an animation needs rising times from 0, and a value for each; export the file again";
        return Err(source.error(problem));
    }
    Ok(Track { interpolation, times, values })
}

/// Times at which to set keyframes: those of all tracks, and more between them; none where nothing moves.
fn times_of<'a>(tracks: impl Iterator<Item = &'a Track>) -> Option<Vec<f64>> {
    let mut keys = vec![0.0];
    let mut any = false;
    for track in tracks {
        any = true;
        for &time in &track.times {
            let time = f64::from(time);
            if track.interpolation == Interpolation::Step && time > JUMP {
                keys.push(time - JUMP);
            }
            keys.push(time);
        }
    }
    keys.sort_by(f64::total_cmp);
    keys.dedup();
    let end = *keys.last()?;
    let step = STEP.max(end / MAX_STEPS);
    let mut times = vec![0.0];
    for pair in keys.windows(2) {
        let parts = ((pair[1] - pair[0]) / step).ceil().max(1.0) as usize;
        times.extend((1..=parts).map(|part| pair[0] + (pair[1] - pair[0]) * part as f64 / parts as f64));
    }
    any.then_some(times)
}

impl Track {
    /// The value at `time`, held before the first and after the last key; a rotation as a quaternion.
    fn at(&self, time: f64, is_rotation: bool) -> Vec4 {
        let per_key = if self.interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        // Of a spline's three values the second is the one at the key.
        let value = |key: usize| self.values[key * per_key + per_key / 2];
        let next = self.times.partition_point(|&key| f64::from(key) <= time);
        if next == 0 {
            return value(0);
        }
        if next == self.times.len() || self.interpolation == Interpolation::Step {
            return value(next - 1);
        }
        let [from, to] = [self.times[next - 1], self.times[next]].map(f64::from);
        let (span, s) = ((to - from) as f32, ((time - from) / (to - from)) as f32);
        let (a, b) = (value(next - 1), value(next));
        if self.interpolation == Interpolation::CubicSpline {
            let (leaving, arriving) = (self.values[3 * next - 1] * span, self.values[3 * next] * span);
            let (s2, s3) = (s * s, s * s * s);
            return a * (2.0 * s3 - 3.0 * s2 + 1.0)
                + leaving * (s3 - 2.0 * s2 + s)
                + b * (3.0 * s2 - 2.0 * s3)
                + arriving * (s3 - s2);
        }
        if is_rotation {
            let [a, b] = [a, b].map(|q| Quat::from_vec4(q).normalize());
            return Vec4::from(a.slerp(b, s));
        }
        a.lerp(b, s)
    }
}
