//! What stands still, drawn once: where a view is drawn over and over since something in it moves, all else is copied from
//! a picture without that.

use std::collections::BTreeSet;

use super::scene_buffers::Moved;

/// What a picture of all that stands still lacks.
#[derive(Default)]
pub struct Still {
    /// Instances that have moved; none without a picture.
    loose: Option<BTreeSet<usize>>,
}

impl Still {
    /// The picture no longer shows this view.
    pub fn forget(&mut self) {
        self.loose = None;
    }

    /// Notes what moves; tells whether the picture has to be drawn, or drawn again, without that.
    pub fn must_draw(&mut self, moved: &[Moved]) -> bool {
        let drawn = self.loose.as_ref().map(BTreeSet::len);
        let loose = self.loose.get_or_insert_default();
        loose.extend(moved.iter().map(|moved| moved.instance));
        drawn != Some(loose.len())
    }

    /// Whether the picture lacks an instance.
    pub fn lacks(&self, instance: u32) -> bool {
        self.loose.as_ref().is_some_and(|loose| loose.contains(&(instance as usize)))
    }
}
