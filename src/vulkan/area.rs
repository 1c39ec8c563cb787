//! Rectangles of texels.

use ash::vk;

/// A rectangle of an image, in texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Area {
    /// Its first texel.
    pub offset: [u32; 2],
    /// Its width and height; nothing is in it where one of them is 0.
    pub extent: [u32; 2],
}

impl Area {
    /// All of an image of that width and height.
    pub fn whole(extent: [u32; 2]) -> Self {
        Self { offset: [0, 0], extent }
    }

    /// Whether no texel lies in it.
    pub fn is_empty(&self) -> bool {
        self.extent.contains(&0)
    }

    /// Behind the last texel.
    pub fn end(&self) -> [u32; 2] {
        [0, 1].map(|axis| self.offset[axis] + self.extent[axis])
    }

    /// The least area with both in it.
    #[must_use]
    pub fn union(self, other: Self) -> Self {
        if self.is_empty() {
            return other;
        }
        if other.is_empty() {
            return self;
        }
        let (ends, others) = (self.end(), other.end());
        Self::between(
            [0, 1].map(|axis| self.offset[axis].min(other.offset[axis])),
            [0, 1].map(|axis| ends[axis].max(others[axis])),
        )
    }

    /// Larger by so many texels on all sides, as far as the image, of the extent `within`, goes; what is empty stays empty.
    #[must_use]
    pub fn grown(self, by: u32, within: [u32; 2]) -> Self {
        if self.is_empty() {
            return self;
        }
        let end = self.end();
        Self::between(
            self.offset.map(|first| first.saturating_sub(by)),
            [0, 1].map(|axis| end[axis].saturating_add(by).min(within[axis])),
        )
    }

    /// What of it lies outside of `other`, as areas that do not overlap.
    pub fn minus(self, other: Self) -> impl Iterator<Item = Self> {
        let ([left, top], [right, bottom]) = (self.offset, self.end());
        let within = |at: [u32; 2]| [at[0].clamp(left, right), at[1].clamp(top, bottom)];
        let [first, end] = [within(other.offset), within(other.end())];
        let parts = if first[0] < end[0] && first[1] < end[1] {
            [
                Self::between([left, top], [right, first[1]]),
                Self::between([left, first[1]], [first[0], end[1]]),
                Self::between([end[0], first[1]], [right, end[1]]),
                Self::between([left, end[1]], [right, bottom]),
            ]
        } else {
            [self, Self::default(), Self::default(), Self::default()]
        };
        parts.into_iter().filter(|part| !part.is_empty())
    }

    /// Moved right and down.
    #[must_use]
    pub fn moved(self, by: [u32; 2]) -> Self {
        Self { offset: [0, 1].map(|axis| self.offset[axis] + by[axis]), ..self }
    }

    /// The part of it that lies in `other`.
    #[must_use]
    pub fn within(self, other: Self) -> Self {
        let (ends, others) = (self.end(), other.end());
        Self::between(
            [0, 1].map(|axis| self.offset[axis].max(other.offset[axis])),
            [0, 1].map(|axis| ends[axis].min(others[axis])),
        )
    }

    fn between(first: [u32; 2], end: [u32; 2]) -> Self {
        Self { offset: first, extent: [0, 1].map(|axis| end[axis].saturating_sub(first[axis])) }
    }

    pub(super) fn raw(&self) -> vk::Rect2D {
        let [x, y] = self.offset.map(|first| i32::try_from(first).unwrap_or(i32::MAX));
        let [width, height] = self.extent;
        vk::Rect2D { offset: vk::Offset2D { x, y }, extent: vk::Extent2D { width, height } }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXTENT: [u32; 2] = [7, 6];

    /// Every area within [`EXTENT`], empty ones too.
    fn all() -> impl Iterator<Item = Area> {
        let sides =
            |of: u32| (0..of).flat_map(move |first| (0..=of - first).map(move |extent| (first, extent)));
        sides(EXTENT[0]).flat_map(move |(x, width)| {
            sides(EXTENT[1]).map(move |(y, height)| Area { offset: [x, y], extent: [width, height] })
        })
    }

    fn has(area: &Area, x: u32, y: u32) -> bool {
        let end = area.end();
        (area.offset[0]..end[0]).contains(&x) && (area.offset[1]..end[1]).contains(&y)
    }

    fn texels() -> impl Iterator<Item = (u32, u32)> {
        (0..EXTENT[0]).flat_map(|x| (0..EXTENT[1]).map(move |y| (x, y)))
    }

    #[test]
    fn differences_have_every_texel_once() {
        let from = Area { offset: [1, 1], extent: [5, 4] };
        for other in all() {
            let parts: Vec<Area> = from.minus(other).collect();
            for (x, y) in texels() {
                let times = parts.iter().filter(|part| has(part, x, y)).count();
                assert_eq!(
                    times,
                    usize::from(has(&from, x, y) && !has(&other, x, y)),
                    "{other:?} at {x}, {y}"
                );
            }
        }
    }

    #[test]
    fn unions_and_intersections_have_what_they_should() {
        let one = Area { offset: [2, 1], extent: [3, 2] };
        for other in all() {
            let (union, common) = (one.union(other), one.within(other));
            for (x, y) in texels() {
                let (in_one, in_other) = (has(&one, x, y), has(&other, x, y));
                assert!(has(&union, x, y) || !(in_one || in_other), "{other:?} at {x}, {y}");
                assert_eq!(has(&common, x, y), in_one && in_other, "{other:?} at {x}, {y}");
            }
        }
        assert_eq!(one.union(Area::default()), one);
    }

    #[test]
    fn areas_grow_as_far_as_the_image_goes() {
        let area = Area { offset: [1, 4], extent: [2, 1] };
        assert_eq!(area.grown(2, EXTENT), Area { offset: [0, 2], extent: [5, 4] });
        assert!(Area::default().grown(2, EXTENT).is_empty());
    }
}
