//! The hardware tracer: the device's own acceleration structures, for `shaders/include/tracer_hardware.glsl`.

use std::sync::Arc;

use super::Named;
use crate::bvh::gpu::rows;
use crate::bvh::hardware::HardwareLayout;
use crate::bvh::{TwoLevelBvh, hardware};
use crate::vulkan::{
    BottomLevel, Buffer, Device, Frame, PlacedStructure, TopLevel, TriangleRun, VulkanError,
};

/// A bottom level for each mesh, one top level, and the shader's tables.
pub(super) struct HardwareTracer {
    // Dropped before the bottom levels, to which it refers.
    top: TopLevel,
    /// None for a mesh without a triangle that could be hit.
    bottom: Vec<Option<BottomLevel>>,
    triangles: Buffer,
    runs: Buffer,
    /// How often static and dynamic instances had moved when the top level was last built; none before that.
    built: Option<[u32; 2]>,
}

impl HardwareTracer {
    /// Builds the bottom levels, one after the other, and waits for them.
    pub fn new(
        device: &Arc<Device>,
        bvh: &TwoLevelBvh,
        layout: &HardwareLayout,
    ) -> Result<Self, VulkanError> {
        let triangles = Buffer::with_data(device, "bvh_triangles", &layout.triangles)?.with_texels()?;
        let bottom = layout
            .meshes
            .iter()
            .map(|mesh| {
                let run = |(run, opaque): (hardware::Run, bool)| TriangleRun {
                    first: run.first,
                    count: run.count,
                    opaque,
                };
                let runs: Vec<_> = mesh.present().map(run).collect();
                (!runs.is_empty())
                    .then(|| BottomLevel::build(device, "bvh_bottom_level", &triangles, &runs))
                    .transpose()
            })
            .collect::<Result<Vec<_>, _>>()?;
        // A run without triangles is not built, so the one after it takes its number.
        let first_triangles = |mesh: &hardware::MeshRuns| {
            let mut present = mesh.present().map(|(run, _)| run.first);
            [present.next().unwrap_or_default(), present.next().unwrap_or_default()]
        };
        let runs: Vec<u32> = layout.meshes.iter().flat_map(first_triangles).collect();
        let top = TopLevel::new(device, "bvh_top_level", bvh.most_placed())?;
        let bottom_bytes: u64 = bottom.iter().flatten().map(BottomLevel::size).sum();
        log::info!(
            "acceleration structures: {bottom_bytes} bytes at the bottom (triangles: {}), {} on top (instances: {})",
            layout.triangles.len(),
            top.size(),
            bvh.most_placed()
        );
        Ok(Self { top, bottom, triangles, runs: Buffer::with_data(device, "bvh_runs", &runs)?, built: None })
    }

    /// Builds the top level again if an instance has moved.
    pub fn update(&mut self, frame: &mut Frame<'_>, bvh: &TwoLevelBvh) -> Result<(), VulkanError> {
        let builds = Some([bvh.static_builds(), bvh.dynamic_builds()]);
        if self.built == builds {
            return Ok(());
        }
        self.built = builds;
        let placed: Vec<PlacedStructure> = bvh
            .placed_meshes()
            .filter_map(|placed| {
                let structure = self.bottom[placed.mesh].as_ref()?;
                let rows = rows(&placed.transform).map(|row| row.to_array());
                Some(PlacedStructure::new(structure, rows, placed.instance, placed.mesh as u32))
            })
            .collect();
        let uploaded = frame.upload(&placed)?;
        self.top.build(frame, "bvh_update", &uploaded, placed.len());
        Ok(())
    }

    /// Part of the scene set.
    pub fn resources(&self) -> [Named<'_>; 3] {
        [
            ("bvh_top_level", (&self.top).into()),
            ("bvh_triangles", (&self.triangles).into()),
            ("bvh_runs", (&self.runs).into()),
        ]
    }
}
