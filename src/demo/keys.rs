//! Keyframes of a light or an object, as the timeline edits them: added, moved in time, deleted.

use super::action::{EditAction, Selected};
use super::session::Session;
use super::transform::key_of;
use crate::formats::AnimationEntry;
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

impl Session {
    /// The edit that animates an entry so.
    pub fn animate(&self, of: Selected, animation: Option<AnimationEntry>) -> Option<EditAction> {
        let mut entry = self.entry(of)?;
        *entry.animation() = animation.filter(|all| !all.keyframes.is_empty() || all.rotation.is_some());
        Some(entry.edit())
    }

    /// The animation with a key at `time`, where it moves as before.
    pub fn with_key(&self, animation: &AnimationEntry, time: f64) -> AnimationEntry {
        let moves = self.document.animation(animation).ok();
        let now = moves.map_or_else(Keyframe::default, |animation| animation.key_at(time));
        let mut with = animation.clone();
        let place = with.keyframes.partition_point(|key| key.time < time);
        with.keyframes.insert(place, key_of(time, &now));
        with
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
}
