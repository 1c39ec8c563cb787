//! Clusters of VPLs, which texels sample from.
//!
//! In: the VPLs of a set, sorted so that neighbours in the list are neighbours in space, those at infinity last. Out: [`CLUSTERS`]
//! runs of the list, with figures that tell about how much each run contributes to a point.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::manager::GpuVpl;
use crate::gpu_scene::to_u32;
use crate::scene::luminance;

/// Clusters of a set. Twin: shaders/estimators/vpls/clusters.glsl.
pub const CLUSTERS: usize = 64;

/// Neighbouring VPLs of a set; `VplCluster` in shaders/estimators/vpls/clusters.glsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct VplCluster {
    /// Mean world position by flux; at infinity the mean direction.
    pub position: Vec3,
    /// Root mean square of the distance from there, by flux.
    pub radius: f32,
    /// Mean normal, by flux: the shorter, the more the normals differ.
    pub normal: Vec3,
    /// Luminous flux; at infinity luminous irradiance.
    pub flux: f32,
    /// Index of its first VPL, counted from the set's first.
    pub first: u32,
    /// Number of VPLs.
    pub count: u32,
    /// 1: its VPLs lie at infinity.
    pub at_infinity: u32,
    /// Unused.
    pub pad: u32,
}

/// Divides a sorted list into clusters of sizes as equal as possible. No cluster holds both VPLs on surfaces and VPLs at infinity.
pub fn clusters_of(vpls: &[GpuVpl]) -> Vec<VplCluster> {
    let near = vpls.partition_point(|vpl| vpl.at_infinity == 0);
    let far = vpls.len() - near;
    let of_near = match (near, far) {
        (_, 0) => CLUSTERS,
        (0, _) => 0,
        _ => (near * CLUSTERS / vpls.len()).clamp(1, CLUSTERS - 1),
    };
    let bounds = |index: usize| match index.checked_sub(of_near) {
        Some(past) if far > 0 => near + past * far / (CLUSTERS - of_near),
        _ => index * near / of_near,
    };
    (0..CLUSTERS).map(|index| cluster(vpls, bounds(index)..bounds(index + 1))).collect()
}

fn cluster(vpls: &[GpuVpl], range: std::ops::Range<usize>) -> VplCluster {
    let members = &vpls[range.clone()];
    let flux: f32 = members.iter().map(|vpl| luminance(vpl.flux)).sum();
    let mean = |value: &dyn Fn(&GpuVpl) -> Vec3| -> Vec3 {
        members.iter().map(|vpl| value(vpl) * (luminance(vpl.flux) / flux)).sum()
    };
    let position = mean(&|vpl| vpl.position);
    VplCluster {
        position,
        radius: mean(&|vpl| Vec3::splat(vpl.position.distance_squared(position))).x.sqrt(),
        normal: mean(&|vpl| vpl.normal),
        flux,
        at_infinity: members.first().map_or(0, |vpl| vpl.at_infinity),
        first: to_u32(range.start),
        count: to_u32(members.len()),
        ..VplCluster::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu_scene::structs::tests::same_layout;
    use crate::vulkan::shaders;

    #[test]
    fn structs_have_the_layout_of_the_shaders() {
        same_layout!(
            shaders::VPL_SAMPLING_COMP.software,
            VplCluster,
            position,
            radius,
            normal,
            flux,
            first,
            count,
            at_infinity,
            pad
        );
    }

    #[test]
    fn vpls_at_infinity_have_clusters_of_their_own() {
        for (near, far) in [(0, 1), (1, 0), (1, 1), (1, 999), (999, 1), (700, 324), (3, 2)] {
            let vpl =
                |i: u32| GpuVpl { flux: Vec3::ONE, at_infinity: u32::from(i >= near), ..GpuVpl::default() };
            let vpls: Vec<GpuVpl> = (0..near + far).map(vpl).collect();
            let mut next = 0;
            for cluster in clusters_of(&vpls) {
                assert_eq!(cluster.first, next);
                next += cluster.count;
                let members = &vpls[cluster.first as usize..next as usize];
                assert!(members.iter().all(|vpl| vpl.at_infinity == cluster.at_infinity));
            }
            assert_eq!(next, near + far, "{near} and {far}");
        }
    }

    #[test]
    fn clusters_hold_every_vpl_once_and_all_flux() {
        for count in [0, 1, 63, 64, 65, 1000] {
            let vpl = |i: u32| GpuVpl {
                position: Vec3::new(i as f32, 1.0, 0.0),
                normal: Vec3::Y,
                flux: Vec3::splat(1.0 + (i % 3) as f32),
                ..GpuVpl::default()
            };
            let vpls: Vec<GpuVpl> = (0..count).map(vpl).collect();
            let clusters = clusters_of(&vpls);
            assert_eq!(clusters.len(), CLUSTERS);
            let mut next = 0;
            for cluster in &clusters {
                assert_eq!(cluster.first, next);
                next += cluster.count;
                assert!(cluster.count == 0 || (cluster.normal - Vec3::Y).length() < 1e-5);
                assert!(cluster.count != 1 || cluster.radius == 0.0);
            }
            assert_eq!(next, count);
            let all: f32 = vpls.iter().map(|vpl| luminance(vpl.flux)).sum();
            let held: f32 = clusters.iter().map(|cluster| cluster.flux).sum();
            assert!((all - held).abs() <= 1e-4 * all);
        }
    }
}
