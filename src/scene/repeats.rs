//! Triangles that a file repeats at the same place, thousands of times: rays would test each.
//!
//! In: a mesh. Out: the mesh with a few of each. Triangles that repeat less often stay as they are.

use std::collections::HashMap;

use super::mesh::Mesh;

/// How many equal triangles stay.
const MOST: u32 = 8;

/// How many triangles may have the same hash before they are compared, besides those that have it by chance.
const UNSUSPECTED: u32 = 64;

/// Slots of [`slot_of`].
pub(crate) const SLOTS: usize = 1 << 16;

/// A slot for a value of these bits: many in one slot are suspected to be equal, without a map of all.
pub(crate) fn slot_of(bits: impl IntoIterator<Item = u32>) -> usize {
    let mix = |hash: u64, bits: u32| (hash ^ u64::from(bits)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    (bits.into_iter().fold(0, mix) >> 48) as usize
}

impl Mesh {
    /// Removes triangles of which there are many with the same corners and material.
    pub(crate) fn drop_repeated_triangles(&mut self) {
        let key = |triangle: usize| {
            let mut corners =
                self.triangle_positions(triangle as u32).map(|p| p.to_array().map(f32::to_bits));
            corners.sort_unstable();
            (corners, self.triangle_materials[triangle])
        };
        let slot = |triangle: usize| {
            let (corners, material) = key(triangle);
            slot_of(std::iter::once(material).chain(corners.into_iter().flatten()))
        };
        let mut counts = vec![0u32; SLOTS];
        (0..self.triangles.len()).for_each(|triangle| counts[slot(triangle)] += 1);
        let limit = UNSUSPECTED + (self.triangles.len() >> 14) as u32;
        if counts.iter().all(|&count| count <= limit) {
            return;
        }
        let mut seen = HashMap::new();
        let stays = |triangle: usize| {
            let count = seen.entry(key(triangle)).or_insert(0u32);
            *count += 1;
            *count <= MOST
        };
        let kept: Vec<bool> = (0..self.triangles.len()).map(stays).collect();
        self.retain_triangles(|_, triangle| kept[triangle]);
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn a_few_of_many_equal_triangles_stay() {
        for (times, rest) in [(1, 1), (20, 20), (5000, 8)] {
            let mut mesh = Mesh::cuboid("box", Vec3::ONE, 0);
            let [a, b, c] = mesh.triangles[0];
            for i in 1..times {
                mesh.triangles.push([[a, b, c], [b, c, a], [a, c, b]][i % 3]);
                mesh.triangle_materials.push(0);
            }
            mesh.drop_repeated_triangles();
            assert_eq!(mesh.triangles.len(), 11 + rest, "{times}");
            assert_eq!(mesh.triangle_materials.len(), mesh.triangles.len());
        }
    }
}
