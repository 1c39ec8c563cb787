//! Compute and graphics pipelines.
//!
//! A device keeps each one that it made until it goes, so that no shader is compiled twice: not for another scene, nor for a
//! method that comes back.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

use super::layout::Layout;
#[cfg(feature = "shader-reload")]
use super::reload::newest;
use super::{Device, Reflection, VulkanError};

/// A compute pipeline with its layout. Clones, and those of the same shader and constants on one device, share it.
#[derive(Clone)]
pub struct ComputePipeline(pub(super) Arc<Compute>);

/// Handles that a [`ComputePipeline`] owns.
pub(super) struct Compute {
    pub raw: vk::Pipeline,
    pub layout: Layout,
}

/// Shader and specialisation constants.
pub(super) type ComputeKey = (&'static [u8], Vec<u32>);

/// Each shader as it was built into the program.
#[cfg(not(feature = "shader-reload"))]
fn newest(spirv: &'static [u8]) -> &'static [u8] {
    spirv
}

impl ComputePipeline {
    /// Creates a pipeline from a compiled shader. `name` is for messages and debuggers.
    pub fn new(device: &Arc<Device>, name: &str, spirv: &'static [u8]) -> Result<Self, VulkanError> {
        Self::specialised(device, name, spirv, &[])
    }

    /// [`Self::new`] with values for the shader's specialisation constants 0, 1, ...
    pub fn specialised(
        device: &Arc<Device>,
        name: &str,
        spirv: &'static [u8],
        constants: &[u32],
    ) -> Result<Self, VulkanError> {
        let spirv = newest(spirv);
        let make = || Compute::new(device, name, spirv, constants);
        device.compute_pipelines().get_or_create((spirv, constants.to_vec()), make).map(Self)
    }

    /// The shader's bindings, push constants and group size.
    pub fn reflection(&self) -> &Reflection {
        &self.0.layout.reflection
    }
}

impl Compute {
    fn new(device: &Arc<Device>, name: &str, spirv: &[u8], constants: &[u32]) -> Result<Self, VulkanError> {
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
}

impl Drop for Compute {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
        unsafe { self.layout.device.destroy_pipeline(self.raw, None) };
    }
}

/// Parameters of a [`GraphicsPipeline`].
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct GraphicsDescription {
    /// Name for messages and debuggers.
    pub name: &'static str,
    /// Compiled vertex shader.
    pub vertex: &'static [u8],
    /// Compiled fragment shader.
    pub fragment: &'static [u8],
    /// Vertex stride, bytes.
    pub vertex_stride: u32,
    /// Format and offset of each vertex attribute, by location.
    pub attributes: &'static [(vk::Format, u32)],
    /// Formats of the colour targets.
    pub colors: &'static [vk::Format],
    /// Alpha blending over the loaded target, without a depth buffer.
    pub blend: bool,
    /// Values of the shaders' specialisation constant 0, one per variant; draws select one.
    pub variants: &'static [u32],
}

/// Vertex and fragment shader with fixed state: triangles, reversed depth (greater is nearer) or
/// none. Clones, and those of the same description on one device, share it.
#[derive(Clone)]
pub struct GraphicsPipeline(pub(super) Arc<Graphics>);

/// Handles that a [`GraphicsPipeline`] owns.
pub(super) struct Graphics {
    pub variants: Vec<vk::Pipeline>,
    pub layout: Layout,
}

impl GraphicsPipeline {
    /// Creates a pipeline that renders to `colors` and, unless it blends, a 32-bit depth buffer.
    pub fn new(device: &Arc<Device>, description: &GraphicsDescription) -> Result<Self, VulkanError> {
        let [vertex, fragment] = [description.vertex, description.fragment].map(newest);
        let newest = GraphicsDescription { vertex, fragment, ..*description };
        device.graphics_pipelines().get_or_create(newest, || Graphics::new(device, &newest)).map(Self)
    }
}

impl Graphics {
    fn new(device: &Arc<Device>, description: &GraphicsDescription) -> Result<Self, VulkanError> {
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

impl Drop for Graphics {
    fn drop(&mut self) {
        for variant in &self.variants {
            // SAFETY: the owner waits for the device before dropping what a submitted frame uses.
            unsafe { self.layout.device.destroy_pipeline(*variant, None) };
        }
    }
}

fn create_graphics(
    device: &Device,
    description: &GraphicsDescription,
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
        .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
        .depth_bias_enable(true)
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
    let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&[
        vk::DynamicState::VIEWPORT,
        vk::DynamicState::SCISSOR,
        vk::DynamicState::CULL_MODE,
        vk::DynamicState::DEPTH_BIAS,
    ]);
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

/// The pipelines of a kind that a device has made, by what they were made of.
pub(super) struct PipelineCache<Key, Pipeline>(Mutex<HashMap<Key, Arc<Pipeline>>>);

impl<Key, Pipeline> Default for PipelineCache<Key, Pipeline> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<Key: Hash + Eq, Pipeline> PipelineCache<Key, Pipeline> {
    /// The pipeline of this key; `create` is called where there is none.
    fn get_or_create(
        &self,
        key: Key,
        create: impl FnOnce() -> Result<Pipeline, VulkanError>,
    ) -> Result<Arc<Pipeline>, VulkanError> {
        let lock = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = lock().get(&key).cloned();
        if let Some(pipeline) = known {
            return Ok(pipeline);
        }
        // Without the lock: other threads create other pipelines meanwhile.
        let created = Arc::new(create()?);
        Ok(Arc::clone(lock().entry(key).or_insert(created)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pipeline_is_created_once_and_kept() {
        let cache = PipelineCache::default();
        let get = |key, pipeline| *cache.get_or_create(key, || Ok(pipeline)).unwrap();
        assert_eq!([get("a", 1), get("a", 2), get("b", 3), get("a", 4)], [1, 1, 3, 1]);
    }

    #[test]
    fn a_failure_is_not_kept() {
        let cache = PipelineCache::default();
        assert!(cache.get_or_create("a", || Err(VulkanError::NoDevice(String::new()))).is_err());
        assert_eq!(*cache.get_or_create("a", || Ok(1)).unwrap(), 1);
    }
}
