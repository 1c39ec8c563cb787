//! The animation of nodes as that of the scene.
//!
//! In: an animation of a file. Out: for what nodes place, keyframes of its motion relative to the rest pose, close enough
//! that between them the scene's interpolation does what the file's would. It repeats.

use std::collections::HashMap;

use ::gltf::Animation as FileAnimation;
use ::gltf::animation::{Interpolation, Property};
use glam::{Affine3A, Mat3A, Quat, Vec3, Vec4};

use super::nodes::{Placed, Tree, unit};
use super::source::Source;
use crate::formats::error::SceneError;
use crate::scene::{Animation, JUMP, Keyframe};

/// Longest time between two keyframes, seconds, unless a file then had more keyframes than this.
const STEP: f64 = 1.0 / 60.0;
const MAX_KEYFRAMES: f64 = 4e6;

/// Longest animation, seconds.
const MAX_TIME: f32 = 1e6;

/// One property of a node over time.
struct Track {
    interpolation: Interpolation,
    times: Vec<f32>,
    /// With tangents before and after each value for cubic splines.
    values: Vec<Vec4>,
}

/// Tracks of a node.
#[derive(Default)]
struct NodeMotion {
    translation: Option<Track>,
    rotation: Option<Track>,
    scale: Option<Track>,
}

/// The animation of a file's nodes.
pub(super) struct Motions {
    /// Translation, rotation and scale of each node at rest.
    rest: Vec<(Vec3, Quat, Vec3)>,
    nodes: HashMap<usize, NodeMotion>,
}

/// The animation that is called `choice`, or has this index; the first one without a choice.
fn chosen<'a>(
    source: &Source,
    mut animations: impl Iterator<Item = FileAnimation<'a>> + Clone,
    choice: Option<&str>,
) -> Result<Option<FileAnimation<'a>>, SceneError> {
    let Some(choice) = choice else { return Ok(animations.next()) };
    let named = animations.clone().find(|animation| animation.name() == Some(choice));
    let found = named.or_else(|| animations.clone().nth(choice.parse().ok()?));
    let name = |(index, animation): (usize, FileAnimation<'a>)| match animation.name() {
        Some(name) => format!("{index} (\"{name}\")"),
        None => index.to_string(),
    };
    found.map(Some).ok_or_else(|| {
        let known: Vec<String> = animations.enumerate().map(name).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        source.error(format!("has no animation \"{choice}\"; give the name or index of one of: {known}"))
    })
}

impl Motions {
    /// Reads the animation of this name or index, or the first one.
    pub fn read(source: &mut Source, choice: Option<&str>) -> Result<Self, SceneError> {
        let document = source.document.clone();
        let rest = |node: ::gltf::Node<'_>| {
            let (translation, rotation, scale) = node.transform().decomposed();
            (Vec3::from_array(translation), unit(Quat::from_array(rotation)), Vec3::from_array(scale))
        };
        let mut motions = Self { rest: document.nodes().map(rest).collect(), nodes: HashMap::new() };
        let Some(animation) = chosen(source, document.animations(), choice)? else { return Ok(motions) };
        if document.animations().len() > 1 && choice.is_none() {
            source.not_shown.insert("animations but the first (--animation chooses)".to_owned());
        }
        for channel in animation.channels() {
            let (target, sampler) = (channel.target(), channel.sampler());
            let property = target.property();
            let values = match property {
                Property::Translation | Property::Scale => {
                    let values = source.vectors::<3>(&sampler.output(), "translation or scale")?;
                    values.into_iter().map(|value| Vec3::from_array(value).extend(0.0)).collect()
                }
                Property::Rotation => {
                    let values = source.vectors::<4>(&sampler.output(), "rotation")?;
                    values.into_iter().map(Vec4::from_array).collect()
                }
                Property::MorphTargetWeights => {
                    source.not_shown.insert("animation of morph targets".to_owned());
                    continue;
                }
            };
            let Some(track) = track_of(source, &sampler, values)? else {
                source
                    .not_shown
                    .insert("animation without rising times from 0, and a value for each".to_owned());
                continue;
            };
            let node = motions.nodes.entry(target.node().index()).or_default();
            *match property {
                Property::Translation => &mut node.translation,
                Property::Scale => &mut node.scale,
                _ => &mut node.rotation,
            } = Some(track);
        }
        Ok(motions)
    }

    /// Which nodes move, or any above them.
    pub fn moving(&self, tree: &Tree) -> Vec<bool> {
        let mut moving = vec![false; self.rest.len()];
        for &(node, parent) in &tree.order {
            moving[node] = self.nodes.contains_key(&node) || parent.is_some_and(|parent| moving[parent]);
        }
        moving
    }

    /// The motion of what each of `placed` places, if it moves.
    pub fn animate(&self, tree: &Tree, placed: &[Placed]) -> Vec<Option<Animation>> {
        let moving = self.moving(tree);
        let count = placed.iter().filter(|place| moving[place.node]).count();
        let still = || Animation { sampled: true, repeat: true, ..Animation::default() };
        let mut animations: Vec<_> = placed.iter().map(|place| moving[place.node].then(still)).collect();
        let (mut worlds, mut turns) = (tree.transforms.clone(), tree.rotations.clone());
        let times = if count > 0 { self.times(count) } else { Vec::new() };
        for time in times {
            for &(node, parent) in tree.order.iter().filter(|(node, _)| moving[*node]) {
                let (above, turn) = parent
                    .map_or((Affine3A::IDENTITY, Quat::IDENTITY), |parent| (worlds[parent], turns[parent]));
                let (translation, rotation, scale) = self.local(node, time);
                let local = Affine3A::from_scale_rotation_translation(scale, rotation, translation);
                (worlds[node], turns[node]) = (above * local, (turn * rotation).normalize());
            }
            for (place, animation) in placed.iter().zip(&mut animations) {
                let Some(animation) = animation else { continue };
                let rotation = (turns[place.node] * tree.rotations[place.node].inverse()).normalize();
                let transform = worlds[place.node] * place.local;
                let unturned = Mat3A::from_quat(rotation.inverse()) * transform.matrix3;
                let stretch = unturned * place.transform.matrix3.inverse();
                let rigid = stretch.abs_diff_eq(Mat3A::IDENTITY, 1e-5);
                animation.keyframes.push(Keyframe {
                    time,
                    translation: (transform.translation - place.transform.translation).into(),
                    rotation,
                    stretch: if rigid { Mat3A::IDENTITY } else { stretch },
                });
            }
        }
        animations
    }

    /// Translation, rotation and scale of a node at `time`.
    fn local(&self, node: usize, time: f64) -> (Vec3, Quat, Vec3) {
        let (mut translation, mut rotation, mut scale) = self.rest[node];
        if let Some(motion) = self.nodes.get(&node) {
            if let Some(track) = &motion.translation {
                translation = track.at(time, false).truncate();
            }
            if let Some(track) = &motion.rotation {
                rotation = unit(Quat::from_vec4(track.at(time, true)));
            }
            if let Some(track) = &motion.scale {
                scale = track.at(time, false).truncate();
            }
        }
        (translation, rotation, scale)
    }

    /// Times of the keyframes of each of `count` things that move: those of all tracks, and more between them.
    fn times(&self, count: usize) -> Vec<f64> {
        let mut keys = vec![0.0];
        for motion in self.nodes.values() {
            for track in [&motion.translation, &motion.rotation, &motion.scale].into_iter().flatten() {
                let jumps = track.interpolation == Interpolation::Step;
                for time in track.times.iter().map(|time| f64::from(*time)) {
                    keys.extend((jumps && time > JUMP).then_some(time - JUMP));
                    keys.push(time);
                }
            }
        }
        keys.sort_by(f64::total_cmp);
        keys.dedup();
        let end = keys[keys.len() - 1];
        let most = MAX_KEYFRAMES / count as f64;
        if keys.len() as f64 > most {
            keys = vec![0.0, end];
        }
        let step = STEP.max(end / most);
        let mut times = vec![0.0];
        for pair in keys.windows(2) {
            let parts = ((pair[1] - pair[0]) / step).ceil().max(1.0) as usize;
            times.extend((1..=parts).map(|part| pair[0] + (pair[1] - pair[0]) * part as f64 / parts as f64));
        }
        times
    }
}

/// The track of a sampler; none without rising times from 0, and a value for each.
fn track_of(
    source: &Source,
    sampler: &::gltf::animation::Sampler<'_>,
    values: Vec<Vec4>,
) -> Result<Option<Track>, SceneError> {
    let times: Vec<f32> =
        source.vectors::<1>(&sampler.input(), "times")?.into_iter().map(|[time]| time).collect();
    let interpolation = sampler.interpolation();
    let per_key = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    let ascending = times.windows(2).all(|pair| pair[0] < pair[1]);
    let in_range = times.iter().all(|time| (0.0..=MAX_TIME).contains(time));
    let fits = !times.is_empty() && values.len() == per_key * times.len();
    Ok((fits && ascending && in_range).then_some(Track { interpolation, times, values }))
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
