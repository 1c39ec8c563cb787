//! Recording one pass: bind by name, push constants, dispatch or draw.

use std::collections::BTreeMap;

use ash::vk;
use bytemuck::Pod;

use super::access::{Access, Barrier};
use super::descriptors::write_descriptors;
use super::draw::extent2d;
use super::frame::Recorder;
use super::layout::{Layout, PASS_SET};
use super::reflect::BindingKind;
use super::{
    BufferSlice, ComputePipeline, DrawList, GraphicsPipeline, Image, Sampler, SharedSet, Targets, TopLevel,
    VulkanError,
};

/// A resource to bind.
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// A buffer or a range of one.
    Buffer(BufferSlice<'a>),
    /// A whole image.
    Image(&'a Image),
    /// A whole image with the sampler that it is read by.
    Sampled(&'a Image, &'a Sampler),
    /// An acceleration structure.
    TopLevel(&'a TopLevel),
}

impl<'a> From<&'a Image> for Resource<'a> {
    fn from(image: &'a Image) -> Self {
        Self::Image(image)
    }
}

impl<'a> From<(&'a Image, &'a Sampler)> for Resource<'a> {
    fn from((image, sampler): (&'a Image, &'a Sampler)) -> Self {
        Self::Sampled(image, sampler)
    }
}

impl<'a> From<&'a TopLevel> for Resource<'a> {
    fn from(structure: &'a TopLevel) -> Self {
        Self::TopLevel(structure)
    }
}

impl<'a, T> From<T> for Resource<'a>
where
    BufferSlice<'a>: From<T>,
{
    fn from(buffer: T) -> Self {
        Self::Buffer(buffer.into())
    }
}

impl Resource<'_> {
    /// Whether a descriptor of this kind can refer to it.
    pub(super) fn is_of(&self, kind: BindingKind) -> bool {
        match (kind, self) {
            (BindingKind::TexelBuffer, Self::Buffer(slice)) => slice.buffer.texels != vk::BufferView::null(),
            (
                BindingKind::UniformBuffer | BindingKind::ReadOnlyStorageBuffer | BindingKind::StorageBuffer,
                Self::Buffer(_),
            )
            | (BindingKind::SampledImage | BindingKind::StorageImage, Self::Image(_))
            | (BindingKind::CombinedImageSampler, Self::Sampled(..))
            | (BindingKind::AccelerationStructure, Self::TopLevel(_)) => true,
            _ => false,
        }
    }
}

struct Bound<'a> {
    resource: Resource<'a>,
    write: bool,
}

/// A pass being recorded. The final call returns errors in the bindings.
pub struct Pass<'f> {
    pub(super) recorder: Recorder<'f>,
    pub(super) name: &'static str,
    /// The pipeline variants; one for compute.
    pub(super) pipelines: &'f [vk::Pipeline],
    pub(super) layout: &'f Layout,
    compute: bool,
    bound: BTreeMap<&'f str, Bound<'f>>,
    shared: Option<&'f SharedSet<'f>>,
    push: Vec<u8>,
}

impl<'f> Pass<'f> {
    pub(super) fn compute(recorder: Recorder<'f>, name: &'static str, pipeline: &'f ComputePipeline) -> Self {
        Self::new(recorder, name, std::slice::from_ref(&pipeline.0.raw), &pipeline.0.layout, true)
    }

    pub(super) fn graphics(
        recorder: Recorder<'f>,
        name: &'static str,
        pipeline: &'f GraphicsPipeline,
    ) -> Self {
        Self::new(recorder, name, &pipeline.0.variants, &pipeline.0.layout, false)
    }

    fn new(
        recorder: Recorder<'f>,
        name: &'static str,
        pipelines: &'f [vk::Pipeline],
        layout: &'f Layout,
        compute: bool,
    ) -> Self {
        Self {
            recorder,
            name,
            pipelines,
            layout,
            compute,
            bound: BTreeMap::new(),
            shared: None,
            push: Vec::new(),
        }
    }

    /// Binds what the shader reads under `name`.
    #[must_use]
    pub fn read(mut self, name: &'f str, resource: impl Into<Resource<'f>>) -> Self {
        self.bound.insert(name, Bound { resource: resource.into(), write: false });
        self
    }

    /// Binds what the shader writes, or reads and writes, under `name`.
    #[must_use]
    pub fn write(mut self, name: &'f str, resource: impl Into<Resource<'f>>) -> Self {
        self.bound.insert(name, Bound { resource: resource.into(), write: true });
        self
    }

    /// Binds the set that the passes of the frame share.
    #[must_use]
    pub fn shared(mut self, set: &'f SharedSet<'f>) -> Self {
        self.shared = Some(set);
        self
    }

    /// Sets the push constants.
    #[must_use]
    pub fn push<T: Pod>(mut self, constants: &T) -> Self {
        self.push = bytemuck::bytes_of(constants).to_vec();
        self
    }

    /// Dispatches one thread for each texel of `extent`.
    pub fn dispatch_over(self, extent: [u32; 2]) -> Result<(), VulkanError> {
        self.dispatch_threads([extent[0], extent[1], 1])
    }

    /// Dispatches at least the given number of threads in each dimension.
    pub fn dispatch_threads(mut self, threads: [u32; 3]) -> Result<(), VulkanError> {
        let size = self.layout.reflection.group_size;
        let groups = [0, 1, 2].map(|axis| threads[axis].div_ceil(size[axis].max(1)));
        let limits = self.recorder.device().limits().max_compute_work_group_count;
        if let Some(axis) = (0..3).find(|&axis| groups[axis] > limits[axis]) {
            let what = format!("pass {} with {} groups", self.name, groups[axis]);
            return Err(VulkanError::Limit { what, limit: u64::from(limits[axis]) });
        }
        self.recorder.begin_scope(self.name);
        self.bind(&[])?;
        // SAFETY: pipeline, descriptors and push constants are bound and checked against the shader.
        unsafe {
            let raw = self.recorder.device().raw();
            raw.cmd_dispatch(self.recorder.commands(), groups[0], groups[1], groups[2]);
        }
        self.recorder.end_scope();
        Ok(())
    }

    /// Begins rendering to the targets and records the draws of `draw`.
    pub fn draw(
        mut self,
        targets: &Targets<'_>,
        draw: impl FnOnce(&mut DrawList<'_>),
    ) -> Result<(), VulkanError> {
        self.recorder.begin_scope(self.name);
        let colors = targets.colors().iter().map(|image| (*image, Access::ColorAttachment));
        let depth = targets.depth().map(|image| (image, Access::DepthAttachment));
        let images: Vec<(&Image, Barrier)> = colors
            .chain(depth)
            .filter_map(|(image, access)| Some((image, image.tracker.use_image(access, false)?)))
            .collect();
        self.bind(&images)?;
        let attachment = |image: &Image, layout| {
            vk::RenderingAttachmentInfo::default()
                .image_view(image.view)
                .image_layout(layout)
                .load_op(targets.load_op())
                .store_op(vk::AttachmentStoreOp::STORE)
        };
        let color = vk::ImageLayout::COLOR_ATTACHMENT_OPTIMAL;
        let colors: Vec<_> = targets.colors().iter().map(|image| attachment(image, color)).collect();
        let depth = vk::ImageLayout::DEPTH_STENCIL_ATTACHMENT_OPTIMAL;
        let depth = targets.depth().map(|image| attachment(image, depth));
        let area = vk::Rect2D { extent: extent2d(targets.extent()), ..Default::default() };
        let mut info =
            vk::RenderingInfo::default().render_area(area).layer_count(1).color_attachments(&colors);
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
        }
        let commands = self.recorder.commands();
        // SAFETY: the targets are in attachment layout and live until the frame is done.
        unsafe { self.recorder.device().raw().cmd_begin_rendering(commands, &info) };
        let mut list = DrawList { pass: &self };
        list.viewport(targets.extent());
        draw(&mut list);
        // SAFETY: ends the rendering begun above.
        unsafe { self.recorder.device().raw().cmd_end_rendering(commands) };
        self.recorder.end_scope();
        Ok(())
    }

    /// Checks the bindings, records barriers, binds pipeline, descriptors and push constants.
    fn bind(&mut self, targets: &[(&Image, Barrier)]) -> Result<(), VulkanError> {
        self.check_bindings()?;
        let mut images = targets.to_vec();
        let mut buffers = Vec::new();
        let own = self.layout.pass_bindings().map(|(name, binding)| {
            let bound = &self.bound[name];
            (bound.resource, bound.write, binding)
        });
        let shared = self
            .layout
            .shared_bindings()
            .filter_map(|(name, binding)| Some((*self.shared?.resources.get(name)?, false, binding)));
        for (resource, write, binding) in own.chain(shared) {
            let access = match (self.compute, write) {
                (true, true) => Access::ComputeWrite,
                (true, false) => Access::ComputeRead,
                (false, _) => Access::GraphicsRead,
            };
            match resource {
                Resource::Buffer(slice) => buffers.extend(slice.buffer.tracker.use_buffer(access)),
                Resource::Image(image) | Resource::Sampled(image, _) => {
                    let storage = binding.kind == BindingKind::StorageImage;
                    images.extend(image.tracker.use_image(access, storage).map(|barrier| (image, barrier)));
                }
                Resource::TopLevel(structure) => {
                    buffers.extend(structure.tracker.use_buffer(Access::ComputeTrace));
                }
            }
        }
        self.recorder.barriers(&images, &buffers);
        let set = self.recorder.descriptor_set(self.layout.sets[PASS_SET as usize], self.name)?;
        let bound: Vec<_> = self
            .layout
            .pass_bindings()
            .map(|(name, binding)| (*binding, self.bound[name].resource))
            .collect();
        write_descriptors(self.recorder.device(), set, &bound);
        let mut sets = vec![set];
        sets.extend(self.shared.filter(|_| self.layout.shares).map(|shared| shared.raw));
        let point =
            if self.compute { vk::PipelineBindPoint::COMPUTE } else { vk::PipelineBindPoint::GRAPHICS };
        let commands = self.recorder.commands();
        // SAFETY: set and layout match; the pipeline outlives the frame (its owner waits before dropping it).
        unsafe {
            let raw = self.recorder.device().raw();
            raw.cmd_bind_pipeline(commands, point, self.pipelines[0]);
            raw.cmd_bind_descriptor_sets(commands, point, self.layout.raw, PASS_SET, &sets, &[]);
            if !self.push.is_empty() {
                raw.cmd_push_constants(commands, self.layout.raw, self.layout.stages, 0, &self.push);
            }
        }
        Ok(())
    }

    fn check_bindings(&self) -> Result<(), VulkanError> {
        let wrong = |binding: &str, problem: String| VulkanError::Binding {
            pass: self.name.to_owned(),
            binding: binding.to_owned(),
            problem,
        };
        for (name, binding) in self.layout.pass_bindings() {
            let Some(bound) = self.bound.get(name) else {
                return Err(wrong(name, "is missing".to_owned()));
            };
            if !fits(binding.kind, bound) {
                let how = if bound.write { "write" } else { "read" };
                let what = match bound.resource {
                    Resource::Buffer(_) => "a buffer",
                    Resource::Image(_) | Resource::Sampled(..) => "an image",
                    Resource::TopLevel(_) => "an acceleration structure",
                };
                return Err(wrong(name, format!("is {:?}, but {what} to {how} was given", binding.kind)));
            }
        }
        for (name, _) in self.layout.shared_bindings() {
            if !self.shared.is_some_and(|shared| shared.resources.contains_key(name)) {
                return Err(wrong(name, "is missing from the scene set".to_owned()));
            }
        }
        let known: Vec<&str> = self.layout.pass_bindings().map(|(name, _)| name).collect();
        if let Some(name) = self.bound.keys().find(|name| !known.contains(*name)) {
            return Err(wrong(name, "is not in the shader".to_owned()));
        }
        let wanted = self.layout.reflection.push_size as usize;
        // Each draw pushes its own constants.
        if self.compute && self.push.len() != wanted {
            return Err(wrong("push constants", format!("have {} bytes, not {wanted}", self.push.len())));
        }
        Ok(())
    }
}

fn fits(kind: BindingKind, bound: &Bound<'_>) -> bool {
    bound.resource.is_of(kind)
        && match kind {
            BindingKind::StorageBuffer => bound.write,
            BindingKind::StorageImage => true,
            _ => !bound.write,
        }
}
