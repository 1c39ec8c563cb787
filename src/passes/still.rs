//! What stands still, drawn once: where a view is drawn over and over since something in it moves, all else is copied from
//! a picture without that.

use std::collections::BTreeSet;

use super::scene_buffers::Moved;
use crate::vulkan::VulkanError;

/// A picture (`T`) of all that stands still in a view.
pub struct Still<T> {
    /// None before anything moves, or without memory for it.
    picture: Option<T>,
    /// The instances that have moved since the view is as it is: those that the picture lacks.
    loose: BTreeSet<usize>,
    stale: bool,
}

impl<T> Default for Still<T> {
    /// Nothing has moved yet.
    fn default() -> Self {
        Self { picture: None, loose: BTreeSet::new(), stale: false }
    }
}

impl<T> Still<T> {
    /// The picture no longer shows this view.
    pub fn forget(&mut self) {
        self.loose.clear();
    }

    /// Notes what moves, at least one instance, and makes the first picture.
    pub fn note(&mut self, moved: &[Moved], make: impl FnOnce() -> Result<T, VulkanError>) {
        if self.picture.is_none() {
            self.picture = make().ok();
            self.loose.clear();
        }
        let known = self.loose.len();
        self.loose.extend(moved.iter().map(|moved| moved.instance));
        self.stale = self.loose.len() > known;
    }

    /// The picture; none without memory for it.
    pub fn picture(&self) -> Option<&T> {
        self.picture.as_ref()
    }

    /// Whether the picture has to be drawn, without what was noted, before it is used.
    pub fn is_stale(&self) -> bool {
        self.stale
    }

    /// Whether the picture lacks an instance.
    pub fn lacks(&self, instance: u32) -> bool {
        self.loose.contains(&(instance as usize))
    }
}
