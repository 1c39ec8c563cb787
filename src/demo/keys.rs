//! Keyframes of a light or an object, as the timeline edits them: added, moved in time, deleted.

use super::action::Action;
use super::session::{Selected, Session};
use super::transform::key_of;
use crate::formats::{AnimationEntry, InstanceEntry, LightEntry};
use crate::scene::Keyframe;

/// Times of keys are whole parts of a second, as many as this, and each has a key at most.
const PARTS: f64 = 100.0;
const STEP: f64 = 1.0 / PARTS;

/// A time that a key may have.
pub(super) fn rounded(time: f64) -> f64 {
    (time * PARTS).round().max(0.0) / PARTS
}

/// The key at `time`.
pub(super) fn key_at(animation: &AnimationEntry, time: f64) -> Option<usize> {
    animation.keyframes.iter().position(|key| (key.time - time).abs() < 0.5 * STEP)
}

/// Moves a key in time, no farther than to its neighbours; returns its new time.
pub(super) fn move_key(animation: &mut AnimationEntry, index: usize, time: f64) -> f64 {
    let of = |index: Option<usize>| Some(animation.keyframes.get(index?)?.time);
    let least = of(index.checked_sub(1)).map_or(0.0, |before| rounded(before + STEP));
    let most = of(Some(index + 1)).map_or(f64::INFINITY, |after| rounded(after - STEP));
    let time = rounded(time).min(most).max(least);
    if let Some(key) = animation.keyframes.get_mut(index) {
        key.time = time;
    }
    time
}

/// The animation without a key; none if nothing is left of it.
pub(super) fn without_key(animation: &AnimationEntry, index: usize) -> Option<AnimationEntry> {
    let mut rest = animation.clone();
    rest.keyframes.remove(index);
    (!rest.keyframes.is_empty() || rest.rotation.is_some()).then_some(rest)
}

impl Session {
    /// What moves where an entry is selected: the instance that an area light names, or else the entry itself.
    pub fn animated(&self, selected: Selected) -> Selected {
        let Selected::Light(index) = selected else { return selected };
        let light = self.document.lights().nth(index);
        let instance = light
            .and_then(|light| light.instance.as_ref())
            .and_then(|name| self.document.instances().position(|instance| instance.shown_name() == name));
        instance.map_or(selected, Selected::Instance)
    }

    /// The animation of an entry.
    pub fn animation(&self, of: Selected) -> Option<&AnimationEntry> {
        match of {
            Selected::Instance(index) => self.document.instances().nth(index)?.animation.as_ref(),
            Selected::Light(index) => self.document.lights().nth(index)?.animation.as_ref(),
        }
    }

    /// The edit that animates an entry so.
    pub fn animate(&self, of: Selected, animation: Option<AnimationEntry>) -> Option<Action> {
        Some(match of {
            Selected::Instance(index) => {
                let entry = self.document.instances().nth(index)?.clone();
                Action::EditInstance(index, Box::new(InstanceEntry { animation, ..entry }))
            }
            Selected::Light(index) => {
                let entry = self.document.lights().nth(index)?.clone();
                Action::EditLight(index, Box::new(LightEntry { animation, ..entry }))
            }
        })
    }

    /// The animation of an entry with a key at `time`, where it moves as before.
    pub fn with_key(&self, of: Selected, time: f64) -> AnimationEntry {
        let live = &self.live_scene;
        let instance = match of {
            Selected::Instance(index) => Some(index),
            Selected::Light(index) => self.document.light_instance(index),
        };
        let built = match (instance, of) {
            (Some(instance), _) => live.instances.get(instance).and_then(|known| known.animation.as_ref()),
            (None, Selected::Light(index)) => {
                let light = self.document.scene_light(index).and_then(|light| live.lights.get(light));
                light.and_then(|light| light.animation.as_ref())
            }
            (None, Selected::Instance(_)) => None,
        };
        let now = built.map_or_else(Keyframe::default, |animation| animation.key_at(time));
        let mut animation = self.animation(of).cloned().unwrap_or_default();
        let place = animation.keyframes.partition_point(|key| key.time < time);
        animation.keyframes.insert(place, key_of(time, &now));
        animation
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn animation(times: &[f64]) -> AnimationEntry {
        let key = |time: &f64| key_of(*time, &Keyframe::default());
        AnimationEntry { keyframes: times.iter().map(key).collect(), ..AnimationEntry::default() }
    }

    #[test]
    fn keys_keep_their_order() {
        let mut animation = animation(&[0.0, 2.0, 4.0]);
        for (wanted, got) in [(3.004, 3.0), (9.0, 3.99), (-1.0, 0.01)] {
            let moved = move_key(&mut animation, 1, wanted);
            assert!((moved - got).abs() < 1e-9 && (animation.keyframes[1].time - got).abs() < 1e-9);
        }
        assert!(move_key(&mut animation, 2, 50.0) == 50.0 && move_key(&mut animation, 0, -5.0) == 0.0);
        assert_eq!((key_at(&animation, 50.001), key_at(&animation, 49.0)), (Some(2), None));
    }

    #[test]
    fn the_last_key_takes_the_animation_along() {
        let two = animation(&[0.0, 2.0]);
        let one = without_key(&two, 0).unwrap();
        assert_eq!(one.keyframes, two.keyframes[1..]);
        assert_eq!(without_key(&one, 0), None);
    }
}
