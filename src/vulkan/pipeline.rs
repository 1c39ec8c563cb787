//! Compute and graphics pipelines, with layouts from shader reflection.

use std::sync::Arc;

use ash::vk;

use super::reflect::{Binding, BindingKind};
use super::{Buffer, Device, Image, Reflection, Sampler, VulkanError};

/// Descriptor set that a pass binds by name.
pub(super) const PASS_SET: u32 = 0;
/// Descriptor set that changes per draw.
const MATERIAL_SET: u32 = 1;

impl BindingKind {
    pub(super) fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            Self::UniformBuffer => vk::DescriptorType::UNIFORM_BUFFER,
            Self::StorageBuffer | Self::ReadOnlyStorageBuffer => vk::DescriptorType::STORAGE_BUFFER,
            Self::TexelBuffer => vk::DescriptorType::UNIFORM_TEXEL_BUFFER,
            Self::SampledImage => vk::DescriptorType::SAMPLED_IMAGE,
            Self::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
            Self::CombinedImageSampler => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::AccelerationStructure => vk::DescriptorType::ACCELERATION_STRUCTURE_KHR,
        }
    }
}

/// Pipeline layout, descriptor set layouts and the reflection they come from.
pub(super) struct Layout {
    pub raw: vk::PipelineLayout,
    pub sets: Vec<vk::DescriptorSetLayout>,
    pub reflection: Reflection,
    pub stages: vk::ShaderStageFlags,
    device: Arc<Device>,
}

impl Layout {
    fn new(
        device: &Arc<Device>,
        name: &str,
        reflection: Reflection,
        stages: vk::ShaderStageFlags,
    ) -> Result<Self, VulkanError> {
        let limit = device.limits().max_push_constants_size;
        if reflection.push_size > limit {
            let what = format!("pass {name} with {} bytes of push constants", reflection.push_size);
            return Err(VulkanError::Limit { what, limit: u64::from(limit) });
        }
        let mut layout = Self {
            raw: vk::PipelineLayout::null(),
            sets: Vec::new(),
            reflection,
            stages,
            device: Arc::clone(device),
        };
        for set in [PASS_SET, MATERIAL_SET] {
            let bindings: Vec<_> = layout
                .reflection
                .bindings
                .values()
                .filter(|binding| binding.set == set)
                .map(|binding| {
                    vk::DescriptorSetLayoutBinding::default()
                        .binding(binding.binding)
                        .descriptor_type(binding.kind.descriptor_type())
                        .descriptor_count(1)
                        .stage_flags(stages)
                })
                .collect();
            let info = vk::DescriptorSetLayoutCreateInfo::default().bindings(&bindings);
            // SAFETY: `info` is complete; the layout is destroyed in `drop`.
            let raw = unsafe { device.raw().create_descriptor_set_layout(&info, None) }
                .map_err(VulkanError::call("creation", format!("set layout of {name}")))?;
            layout.sets.push(raw);
        }
        let push = [vk::PushConstantRange::default().stage_flags(stages).size(layout.reflection.push_size)];
        let mut info = vk::PipelineLayoutCreateInfo::default().set_layouts(&layout.sets);
        if layout.reflection.push_size > 0 {
            info = info.push_constant_ranges(&push);
        }
        // SAFETY: the set layouts live as long as the pipeline layout.
        layout.raw = unsafe { device.raw().create_pipeline_layout(&info, None) }
            .map_err(VulkanError::call("creation", format!("layout of {name}")))?;
        Ok(layout)
    }

    /// The bindings of the pass's set.
    pub(super) fn pass_bindings(&self) -> impl Iterator<Item = (&str, &Binding)> {
        self.reflection
            .bindings
            .iter()
            .filter(|(_, binding)| binding.set == PASS_SET)
            .map(|(name, binding)| (name.as_str(), binding))
    }
}

impl Drop for Layout {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping a pipeline that a submitted frame uses.
        unsafe {
            self.device.raw().destroy_pipeline_layout(self.raw, None);
            for set in &self.sets {
                self.device.raw().destroy_descriptor_set_layout(*set, None);
            }
        }
    }
}

/// A compute pipeline with its layout.
pub struct ComputePipeline {
    pub(super) raw: vk::Pipeline,
    pub(super) layout: Layout,
}

impl ComputePipeline {
    /// Creates a pipeline from a compiled shader. `name` is for messages and debuggers.
    pub fn new(device: &Arc<Device>, name: &str, spirv: &[u8]) -> Result<Self, VulkanError> {
        Self::specialised(device, name, spirv, &[])
    }

    /// [`Self::new`] with values for the shader's specialisation constants 0, 1, ...
    pub fn specialised(
        device: &Arc<Device>,
        name: &str,
        spirv: &[u8],
        constants: &[u32],
    ) -> Result<Self, VulkanError> {
        let reflection = Reflection::new(name, spirv)?;
        let layout = Layout::new(device, name, reflection, vk::ShaderStageFlags::COMPUTE)?;
        let module = ShaderModule::new(device, name, spirv)?;
        let constants = Constants::new(constants);
        let constants = constants.info();
        let stage = module.stage(vk::ShaderStageFlags::COMPUTE).specialization_info(&constants);
        let info = vk::ComputePipelineCreateInfo::default().stage(stage).layout(layout.raw);
        // SAFETY: the module is valid SPIR-V for the layout that was read from it.
        let made = unsafe { device.raw().create_compute_pipelines(vk::PipelineCache::null(), &[info], None) };
        let raw =
            made.map_err(|(_, result)| VulkanError::call("creation", format!("pipeline {name}"))(result))?[0];
        device.set_name(raw, name);
        Ok(Self { raw, layout })
    }

    /// The shader's bindings, push constants and group size.
    pub fn reflection(&self) -> &Reflection {
        &self.layout.reflection
    }
}

impl Drop for ComputePipeline {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe { self.layout.device.raw().destroy_pipeline(self.raw, None) };
    }
}

/// Parameters of a [`GraphicsPipeline`].
pub struct GraphicsDescription<'a> {
    /// For messages and debuggers.
    pub name: &'a str,
    /// Compiled vertex shader.
    pub vertex: &'a [u8],
    /// Compiled fragment shader.
    pub fragment: &'a [u8],
    /// Vertex stride, bytes.
    pub vertex_stride: u32,
    /// Format and offset of each vertex attribute, by location.
    pub attributes: &'a [(vk::Format, u32)],
    /// Formats of the colour targets.
    pub colors: &'a [vk::Format],
    /// Alpha blending over the loaded target, without a depth buffer.
    pub blend: bool,
    /// Values of the shaders' specialisation constant 0, one per variant; draws select one.
    pub variants: &'a [u32],
}

/// Vertex and fragment shader with fixed state: triangles, no culling, reversed depth (greater is nearer) or
/// none.
pub struct GraphicsPipeline {
    pub(super) variants: Vec<vk::Pipeline>,
    pub(super) layout: Layout,
}

impl GraphicsPipeline {
    /// Creates a pipeline that renders to `colors` and, unless it blends, a 32-bit depth buffer.
    pub fn new(device: &Arc<Device>, description: &GraphicsDescription<'_>) -> Result<Self, VulkanError> {
        let name = description.name;
        let stages = vk::ShaderStageFlags::VERTEX | vk::ShaderStageFlags::FRAGMENT;
        let reflection =
            Reflection::new(name, description.vertex)?.merge(Reflection::new(name, description.fragment)?);
        let layout = Layout::new(device, name, reflection, stages)?;
        let vertex = ShaderModule::new(device, name, description.vertex)?;
        let fragment = ShaderModule::new(device, name, description.fragment)?;
        let mut pipeline = Self { variants: Vec::new(), layout };
        for variant in description.variants {
            let constants = Constants::new(std::slice::from_ref(variant));
            let constants = constants.info();
            let shaders = [
                vertex.stage(vk::ShaderStageFlags::VERTEX).specialization_info(&constants),
                fragment.stage(vk::ShaderStageFlags::FRAGMENT).specialization_info(&constants),
            ];
            let raw = create_graphics(device, description, &shaders, pipeline.layout.raw)
                .map_err(VulkanError::call("creation", format!("pipeline {name}")))?;
            device.set_name(raw, name);
            pipeline.variants.push(raw);
        }
        Ok(pipeline)
    }
}

impl Drop for GraphicsPipeline {
    fn drop(&mut self) {
        for variant in &self.variants {
            // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
            unsafe { self.layout.device.raw().destroy_pipeline(*variant, None) };
        }
    }
}

fn create_graphics(
    device: &Device,
    description: &GraphicsDescription<'_>,
    shaders: &[vk::PipelineShaderStageCreateInfo<'_>],
    layout: vk::PipelineLayout,
) -> Result<vk::Pipeline, vk::Result> {
    let attributes: Vec<_> = (0..)
        .zip(description.attributes)
        .map(|(location, &(format, offset))| vk::VertexInputAttributeDescription {
            location,
            binding: 0,
            format,
            offset,
        })
        .collect();
    let vertices = [vk::VertexInputBindingDescription {
        binding: 0,
        stride: description.vertex_stride,
        input_rate: vk::VertexInputRate::VERTEX,
    }];
    let vertices = if attributes.is_empty() { &vertices[..0] } else { &vertices };
    let input = vk::PipelineVertexInputStateCreateInfo::default()
        .vertex_binding_descriptions(vertices)
        .vertex_attribute_descriptions(&attributes);
    let assembly =
        vk::PipelineInputAssemblyStateCreateInfo::default().topology(vk::PrimitiveTopology::TRIANGLE_LIST);
    let viewport = vk::PipelineViewportStateCreateInfo::default().viewport_count(1).scissor_count(1);
    let raster = vk::PipelineRasterizationStateCreateInfo::default()
        .polygon_mode(vk::PolygonMode::FILL)
        .cull_mode(vk::CullModeFlags::NONE)
        .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
        .line_width(1.0);
    let samples =
        vk::PipelineMultisampleStateCreateInfo::default().rasterization_samples(vk::SampleCountFlags::TYPE_1);
    let depth = vk::PipelineDepthStencilStateCreateInfo::default()
        .depth_test_enable(!description.blend)
        .depth_write_enable(!description.blend)
        .depth_compare_op(vk::CompareOp::GREATER);
    let blends: Vec<_> = description
        .colors
        .iter()
        .map(|_| {
            vk::PipelineColorBlendAttachmentState::default()
                .blend_enable(description.blend)
                .src_color_blend_factor(vk::BlendFactor::SRC_ALPHA)
                .dst_color_blend_factor(vk::BlendFactor::ONE_MINUS_SRC_ALPHA)
                .dst_alpha_blend_factor(vk::BlendFactor::ONE)
                .color_write_mask(vk::ColorComponentFlags::RGBA)
        })
        .collect();
    let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&blends);
    let dynamic = vk::PipelineDynamicStateCreateInfo::default()
        .dynamic_states(&[vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR]);
    let mut rendering = vk::PipelineRenderingCreateInfo::default()
        .color_attachment_formats(description.colors)
        .depth_attachment_format(if description.blend {
            vk::Format::UNDEFINED
        } else {
            vk::Format::D32_SFLOAT
        });
    let info = vk::GraphicsPipelineCreateInfo::default()
        .stages(shaders)
        .vertex_input_state(&input)
        .input_assembly_state(&assembly)
        .viewport_state(&viewport)
        .rasterization_state(&raster)
        .multisample_state(&samples)
        .depth_stencil_state(&depth)
        .color_blend_state(&blend)
        .dynamic_state(&dynamic)
        .layout(layout)
        .push_next(&mut rendering);
    // SAFETY: every pointer in `info` outlives the call; the modules fit the layout read from them.
    unsafe { device.raw().create_graphics_pipelines(vk::PipelineCache::null(), &[info], None) }
        .map(|pipelines| pipelines[0])
        .map_err(|(_, result)| result)
}

/// Values for a shader's specialisation constants 0, 1, ...
struct Constants<'a> {
    values: &'a [u32],
    entries: Vec<vk::SpecializationMapEntry>,
}

impl<'a> Constants<'a> {
    fn new(values: &'a [u32]) -> Self {
        let entries = (0u32..)
            .zip(values)
            .map(|(constant_id, _)| vk::SpecializationMapEntry {
                constant_id,
                offset: constant_id * 4,
                size: 4,
            })
            .collect();
        Self { values, entries }
    }

    fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default().map_entries(&self.entries).data(bytemuck::cast_slice(self.values))
    }
}

struct ShaderModule {
    raw: vk::ShaderModule,
    device: Arc<Device>,
}

impl ShaderModule {
    fn new(device: &Arc<Device>, name: &str, spirv: &[u8]) -> Result<Self, VulkanError> {
        let problem = |problem: String| VulkanError::Shader { name: name.to_owned(), problem };
        let words = ash::util::read_spv(&mut std::io::Cursor::new(spirv))
            .map_err(|error| problem(error.to_string()))?;
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: `words` is SPIR-V that glslang made.
        let raw = unsafe { device.raw().create_shader_module(&info, None) }
            .map_err(VulkanError::call("creation", format!("shader {name}")))?;
        Ok(Self { raw, device: Arc::clone(device) })
    }

    fn stage<'a>(&self, stage: vk::ShaderStageFlags) -> vk::PipelineShaderStageCreateInfo<'a> {
        vk::PipelineShaderStageCreateInfo::default().stage(stage).module(self.raw).name(c"main")
    }
}

impl Drop for ShaderModule {
    fn drop(&mut self) {
        // SAFETY: pipelines keep what they need of a module.
        unsafe { self.device.raw().destroy_shader_module(self.raw, None) };
    }
}

/// One descriptor set per material: its textures.
pub struct MaterialSets {
    pool: vk::DescriptorPool,
    pub(super) sets: Vec<vk::DescriptorSet>,
    device: Arc<Device>,
}

impl MaterialSets {
    /// Creates one set for each of `images` for `pipeline`, whose set 1 has `N` combined image samplers, then a uniform block:
    /// one element of the buffer, each of which has the given size, a multiple of 256.
    pub fn new<const N: usize>(
        device: &Arc<Device>,
        pipeline: &GraphicsPipeline,
        images: &[[(&Image, &Sampler); N]],
        (data, size): (&Buffer, u64),
    ) -> Result<Self, VulkanError> {
        let count = u32::try_from(images.len()).unwrap_or(u32::MAX).max(1);
        assert!(size.is_multiple_of(256), "blocks of {size} bytes do not fit every device's alignment");
        let pool_size = |ty, each: u32| vk::DescriptorPoolSize { ty, descriptor_count: count * each };
        let sizes = [
            pool_size(vk::DescriptorType::COMBINED_IMAGE_SAMPLER, N as u32),
            pool_size(vk::DescriptorType::UNIFORM_BUFFER, 1),
        ];
        let info = vk::DescriptorPoolCreateInfo::default().max_sets(count).pool_sizes(&sizes);
        // SAFETY: `info` is complete; the pool is destroyed in `drop`.
        let pool = unsafe { device.raw().create_descriptor_pool(&info, None) }
            .map_err(VulkanError::call("creation", "material descriptors"))?;
        let mut made = Self { pool, sets: Vec::new(), device: Arc::clone(device) };
        let layout = pipeline.layout.sets[MATERIAL_SET as usize];
        for (index, textures) in (0..).zip(images) {
            let layouts = [layout];
            let info = vk::DescriptorSetAllocateInfo::default().descriptor_pool(pool).set_layouts(&layouts);
            let buffer_info =
                [vk::DescriptorBufferInfo { buffer: data.raw, offset: index * size, range: size }];
            let image_infos = textures.map(|(image, sampler)| {
                [vk::DescriptorImageInfo {
                    sampler: sampler.raw,
                    image_view: image.view,
                    image_layout: vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL,
                }]
            });
            // SAFETY: the pool was sized for these sets; images, samplers and buffer outlive their use.
            unsafe {
                let set = device
                    .raw()
                    .allocate_descriptor_sets(&info)
                    .map_err(VulkanError::call("allocation", "material descriptors"))?[0];
                let writes: [_; N] = std::array::from_fn(|binding| {
                    vk::WriteDescriptorSet::default()
                        .dst_set(set)
                        .dst_binding(binding as u32)
                        .descriptor_type(vk::DescriptorType::COMBINED_IMAGE_SAMPLER)
                        .image_info(&image_infos[binding])
                });
                let block = vk::WriteDescriptorSet::default()
                    .dst_set(set)
                    .dst_binding(N as u32)
                    .descriptor_type(vk::DescriptorType::UNIFORM_BUFFER)
                    .buffer_info(&buffer_info);
                device.raw().update_descriptor_sets(&writes, &[]);
                device.raw().update_descriptor_sets(&[block], &[]);
                made.sets.push(set);
            }
        }
        Ok(made)
    }
}

impl Drop for MaterialSets {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe { self.device.raw().destroy_descriptor_pool(self.pool, None) };
    }
}
