//! Acceleration structures of `VK_KHR_acceleration_structure`, for ray queries.
//!
//! In: triangles in device memory, and instance transforms. Out: a compacted [`BottomLevel`] for each mesh, and a
//! [`TopLevel`] over the instances, built within a frame.

use std::sync::Arc;

use ash::vk;
use bytemuck::{Pod, Zeroable};

use super::access::{Access, Barrier, Tracker};
use super::barrier::record_barriers;
use super::ray_query::RayQueries;
use super::{Buffer, BufferSlice, Device, Frame, Upload, VulkanError};

/// Vertex stride of the buffers that bottom levels are built from, bytes: a position and a word for shaders.
const VERTEX_STRIDE: u64 = 16;

/// A range of triangles in a vertex buffer, three vertices each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TriangleRun {
    /// First triangle.
    pub first: u32,
    /// Number of triangles.
    pub count: u32,
    /// Whether hits are confirmed without the shader (`VK_GEOMETRY_OPAQUE_BIT_KHR`).
    pub opaque: bool,
}

/// An instance of a bottom level, input of a top-level build. 64 bytes: `VkAccelerationStructureInstanceKHR`.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PlacedStructure {
    /// The rows of the 3x4 matrix from object to world space.
    pub object_to_world: [[f32; 4]; 3],
    /// Low 24 bits: the instance's custom index; high 8: its visibility mask.
    index_and_mask: u32,
    /// Low 24 bits: the instance's record offset; high 8: flags.
    record_and_flags: u32,
    /// Address of the bottom level.
    structure: u64,
}

impl PlacedStructure {
    /// `structure` at `object_to_world`; shaders read `index` and `record`, of 24 bits each.
    pub fn new(structure: &BottomLevel, object_to_world: [[f32; 4]; 3], index: u32, record: u32) -> Self {
        assert!(index >> 24 == 0 && record >> 24 == 0, "instances are counted when a top level is made");
        Self {
            object_to_world,
            index_and_mask: index | 0xff00_0000,
            record_and_flags: record,
            structure: structure.address,
        }
    }
}

/// An acceleration structure with its memory.
struct Structure {
    raw: vk::AccelerationStructureKHR,
    buffer: Buffer,
    device: Arc<Device>,
}

impl Structure {
    fn new(
        device: &Arc<Device>,
        name: &str,
        ty: vk::AccelerationStructureTypeKHR,
        size: u64,
    ) -> Result<Self, VulkanError> {
        let buffer = Buffer::for_structure(device, name, size)?;
        let info =
            vk::AccelerationStructureCreateInfoKHR::default().buffer(buffer.raw).size(buffer.size).ty(ty);
        // SAFETY: the buffer has this usage, is as large as the structure, and lives as long.
        let raw = unsafe { ray_queries(device).functions.create_acceleration_structure(&info, None) }
            .map_err(VulkanError::call("creation", format!("acceleration structure {name}")))?;
        device.set_name(raw, name);
        Ok(Self { raw, buffer, device: Arc::clone(device) })
    }
}

impl Drop for Structure {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe { ray_queries(&self.device).functions.destroy_acceleration_structure(self.raw, None) };
    }
}

/// The triangles of one mesh, compacted.
pub struct BottomLevel {
    address: u64,
    structure: Structure,
}

impl BottomLevel {
    /// Builds `runs` of `vertices` (16 bytes each, the first 12 the position) and waits for completion. Each run is a
    /// geometry, whose primitive indices start at 0.
    ///
    /// # Errors
    /// If device memory runs out or the triangles exceed the device's limit.
    pub fn build(
        device: &Arc<Device>,
        name: &str,
        vertices: &Buffer,
        runs: &[TriangleRun],
    ) -> Result<Self, VulkanError> {
        let ty = vk::AccelerationStructureTypeKHR::BOTTOM_LEVEL;
        let limit = ray_queries(device).max_triangles;
        let triangles: u64 = runs.iter().map(|run| u64::from(run.count)).sum();
        if triangles > limit {
            return Err(VulkanError::Limit { what: format!("mesh {name} of {triangles} triangles"), limit });
        }
        let start = address_of(device, vertices);
        let geometries: Vec<_> = runs.iter().map(|run| triangle_geometry(start, run)).collect();
        let counts: Vec<u32> = runs.iter().map(|run| run.count).collect();
        let flags = vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE
            | vk::BuildAccelerationStructureFlagsKHR::ALLOW_COMPACTION;
        let info = build_info(ty, flags, &geometries);
        let sizes = build_sizes(device, &info, &counts);

        // Build with the worst-case size.
        let uncompacted = Structure::new(device, name, ty, sizes.acceleration_structure_size)?;
        let scratch = Scratch::new(device, sizes.build_scratch_size)?;
        let compacted = CompactedSize::new(device)?;
        let ranges: Vec<_> = runs
            .iter()
            .map(|run| {
                vk::AccelerationStructureBuildRangeInfoKHR::default()
                    .primitive_count(run.count)
                    .primitive_offset(run.first * 3 * VERTEX_STRIDE as u32)
            })
            .collect();
        let info = info.dst_acceleration_structure(uncompacted.raw).scratch_data(scratch.address());
        device.run_once(|commands| {
            // SAFETY: the runs lie within the vertex buffer, which was filled before; structure and scratch memory are
            // as large as the device said, and all live until the wait is over.
            unsafe {
                let functions = &ray_queries(device).functions;
                functions.cmd_build_acceleration_structures(commands, &[info], &[&ranges]);
                record_barriers(device, commands, &[], &[build_barrier()]);
                compacted.record(commands, &uncompacted);
            }
        })?;

        // Copy it to a compacted structure.
        let compact = Structure::new(device, name, ty, compacted.read()?)?;
        let copy = vk::CopyAccelerationStructureInfoKHR::default()
            .src(uncompacted.raw)
            .dst(compact.raw)
            .mode(vk::CopyAccelerationStructureModeKHR::COMPACT);
        device.run_once(|commands| {
            // SAFETY: the copy is as large as the device said; both live until the wait is over.
            unsafe { ray_queries(device).functions.cmd_copy_acceleration_structure(commands, &copy) };
            record_barriers(device, commands, &[], &[build_barrier()]);
        })?;
        let info =
            vk::AccelerationStructureDeviceAddressInfoKHR::default().acceleration_structure(compact.raw);
        // SAFETY: the structure is live.
        let address =
            unsafe { ray_queries(device).functions.get_acceleration_structure_device_address(&info) };
        Ok(Self { address, structure: compact })
    }

    /// Bytes of device memory.
    pub fn size(&self) -> u64 {
        self.structure.buffer.size()
    }
}

/// A top level over instances of bottom levels, which must outlive it. Empty until the first build.
pub struct TopLevel {
    pub(super) raw: vk::AccelerationStructureKHR,
    pub(super) tracker: Tracker,
    structure: Structure,
    scratch: Scratch,
    capacity: u32,
    device: Arc<Device>,
}

const TOP_FLAGS: vk::BuildAccelerationStructureFlagsKHR =
    vk::BuildAccelerationStructureFlagsKHR::PREFER_FAST_TRACE;

impl TopLevel {
    /// Allocates memory for up to `capacity` instances, including scratch memory.
    ///
    /// # Errors
    /// If device memory runs out or the instances exceed the device's limit.
    pub fn new(device: &Arc<Device>, name: &str, capacity: usize) -> Result<Self, VulkanError> {
        let limit = ray_queries(device).max_instances.min(1 << 24);
        let too_many = || VulkanError::Limit { what: format!("{name} of {capacity} instances"), limit };
        let capacity = u32::try_from(capacity).map_err(|_| too_many())?;
        if u64::from(capacity) > limit {
            return Err(too_many());
        }
        let ty = vk::AccelerationStructureTypeKHR::TOP_LEVEL;
        let sizes = build_sizes(device, &build_info(ty, TOP_FLAGS, &[instance_geometry(0)]), &[capacity]);
        let structure = Structure::new(device, name, ty, sizes.acceleration_structure_size)?;
        Ok(Self {
            raw: structure.raw,
            tracker: Tracker::default(),
            structure,
            scratch: Scratch::new(device, sizes.build_scratch_size)?,
            capacity,
            device: Arc::clone(device),
        })
    }

    /// Bytes of device memory, including scratch memory.
    pub fn size(&self) -> u64 {
        self.structure.buffer.size() + self.scratch.buffer.size()
    }

    /// Rebuilds it over `count` uploaded [`PlacedStructure`]s, timed as pass `name`.
    ///
    /// # Panics
    /// If `count` exceeds the capacity.
    pub fn build(&self, frame: &mut Frame<'_>, name: &'static str, placed: &Upload, count: usize) {
        let count = u32::try_from(count).unwrap_or(u32::MAX);
        assert!(count <= self.capacity, "{count} instances in a top level for {}", self.capacity);
        let source = BufferSlice::from(placed);
        let start = address_of(&self.device, source.buffer) + source.offset;
        let geometries = [instance_geometry(start)];
        let info = build_info(vk::AccelerationStructureTypeKHR::TOP_LEVEL, TOP_FLAGS, &geometries)
            .dst_acceleration_structure(self.raw)
            .scratch_data(self.scratch.address());
        let range = [vk::AccelerationStructureBuildRangeInfoKHR::default().primitive_count(count)];
        let barriers = [
            self.tracker.use_buffer(Access::StructureBuild),
            self.scratch.buffer.tracker.use_buffer(Access::StructureBuild),
            source.buffer.tracker.use_buffer(Access::BuildInput),
        ];
        let mut recorder = frame.recorder();
        recorder.begin_scope(name);
        recorder.barriers(&[], &barriers.into_iter().flatten().collect::<Vec<_>>());
        // SAFETY: structure and scratch memory are large enough for the capacity; the upload holds `count` instances,
        // was written before the submission, and refers to structures that the owner keeps.
        unsafe {
            let functions = &ray_queries(&self.device).functions;
            functions.cmd_build_acceleration_structures(recorder.commands(), &[info], &[&range]);
        }
        recorder.end_scope();
    }
}

/// Scratch memory of a build.
struct Scratch {
    device_address: u64,
    buffer: Buffer,
}

impl Scratch {
    fn new(device: &Arc<Device>, size: u64) -> Result<Self, VulkanError> {
        let alignment = ray_queries(device).scratch_alignment;
        let buffer = Buffer::for_structure(device, "acceleration structure scratch", size + alignment)?;
        let device_address = address_of(device, &buffer).next_multiple_of(alignment);
        Ok(Self { device_address, buffer })
    }

    fn address(&self) -> vk::DeviceOrHostAddressKHR {
        vk::DeviceOrHostAddressKHR { device_address: self.device_address }
    }
}

/// A query of a structure's compacted size.
struct CompactedSize {
    pool: vk::QueryPool,
    device: Arc<Device>,
}

impl CompactedSize {
    const TYPE: vk::QueryType = vk::QueryType::ACCELERATION_STRUCTURE_COMPACTED_SIZE_KHR;

    fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        let info = vk::QueryPoolCreateInfo::default().query_type(Self::TYPE).query_count(1);
        // SAFETY: `info` is complete; the pool is destroyed in `drop`.
        let pool = unsafe { device.raw().create_query_pool(&info, None) }
            .map_err(VulkanError::call("creation", "query of a compacted size"))?;
        Ok(Self { pool, device: Arc::clone(device) })
    }

    fn record(&self, commands: vk::CommandBuffer, structure: &Structure) {
        // SAFETY: the structure was built with ALLOW_COMPACTION, earlier in these commands and with a barrier since.
        unsafe {
            self.device.raw().cmd_reset_query_pool(commands, self.pool, 0, 1);
            ray_queries(&self.device).functions.cmd_write_acceleration_structures_properties(
                commands,
                &[structure.raw],
                Self::TYPE,
                self.pool,
                0,
            );
        }
    }

    fn read(&self) -> Result<u64, VulkanError> {
        let mut size = [0u64];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: the query was recorded and its commands are done.
        unsafe { self.device.raw().get_query_pool_results(self.pool, 0, &mut size, flags) }
            .map_err(VulkanError::call("reading", "compacted size"))?;
        Ok(size[0])
    }
}

impl Drop for CompactedSize {
    fn drop(&mut self) {
        // SAFETY: the commands that used it are done.
        unsafe { self.device.raw().destroy_query_pool(self.pool, None) };
    }
}

fn triangle_geometry<'a>(start: u64, run: &TriangleRun) -> vk::AccelerationStructureGeometryKHR<'a> {
    let last_vertex = (run.first + run.count).saturating_mul(3).saturating_sub(1);
    let triangles = vk::AccelerationStructureGeometryTrianglesDataKHR::default()
        .vertex_format(vk::Format::R32G32B32_SFLOAT)
        .vertex_data(vk::DeviceOrHostAddressConstKHR { device_address: start })
        .vertex_stride(VERTEX_STRIDE)
        .max_vertex(last_vertex)
        .index_type(vk::IndexType::NONE_KHR);
    // Shaders multiply the transmittances of thin surfaces, each once.
    let once = vk::GeometryFlagsKHR::NO_DUPLICATE_ANY_HIT_INVOCATION;
    let flags = if run.opaque { vk::GeometryFlagsKHR::OPAQUE } else { once };
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::TRIANGLES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { triangles })
        .flags(flags)
}

fn instance_geometry<'a>(start: u64) -> vk::AccelerationStructureGeometryKHR<'a> {
    let instances = vk::AccelerationStructureGeometryInstancesDataKHR::default()
        .data(vk::DeviceOrHostAddressConstKHR { device_address: start });
    vk::AccelerationStructureGeometryKHR::default()
        .geometry_type(vk::GeometryTypeKHR::INSTANCES)
        .geometry(vk::AccelerationStructureGeometryDataKHR { instances })
}

fn build_info<'a>(
    ty: vk::AccelerationStructureTypeKHR,
    flags: vk::BuildAccelerationStructureFlagsKHR,
    geometries: &'a [vk::AccelerationStructureGeometryKHR<'a>],
) -> vk::AccelerationStructureBuildGeometryInfoKHR<'a> {
    vk::AccelerationStructureBuildGeometryInfoKHR::default()
        .ty(ty)
        .flags(flags)
        .mode(vk::BuildAccelerationStructureModeKHR::BUILD)
        .geometries(geometries)
}

fn build_sizes(
    device: &Device,
    info: &vk::AccelerationStructureBuildGeometryInfoKHR<'_>,
    counts: &[u32],
) -> vk::AccelerationStructureBuildSizesInfoKHR<'static> {
    let mut sizes = vk::AccelerationStructureBuildSizesInfoKHR::default();
    // SAFETY: there is one count for each geometry.
    unsafe {
        ray_queries(device).functions.get_acceleration_structure_build_sizes(
            vk::AccelerationStructureBuildTypeKHR::DEVICE,
            info,
            counts,
            &mut sizes,
        );
    }
    sizes
}

/// The barrier between a build or copy and any other use of the structure.
fn build_barrier() -> Barrier {
    Barrier {
        src_stage: vk::PipelineStageFlags2::ACCELERATION_STRUCTURE_BUILD_KHR,
        src_access: vk::AccessFlags2::ACCELERATION_STRUCTURE_WRITE_KHR,
        dst_stage: vk::PipelineStageFlags2::ACCELERATION_STRUCTURE_BUILD_KHR
            | vk::PipelineStageFlags2::COMPUTE_SHADER,
        dst_access: vk::AccessFlags2::ACCELERATION_STRUCTURE_READ_KHR,
        old_layout: vk::ImageLayout::UNDEFINED,
        new_layout: vk::ImageLayout::UNDEFINED,
    }
}

fn address_of(device: &Device, buffer: &Buffer) -> u64 {
    let info = vk::BufferDeviceAddressInfo::default().buffer(buffer.raw);
    // SAFETY: where the device has ray queries, every buffer is made so that it has an address.
    unsafe { device.raw().get_buffer_device_address(&info) }
}

fn ray_queries(device: &Device) -> &RayQueries {
    device.ray_queries().expect("only asked for where the device has ray queries")
}
