//! Vulkan, and all of the crate's unsafe code: device, memory, pipelines, access tracking,
//! timers, presentation.
//!
//! Every object frees itself when dropped and keeps its parents alive. A [`Frame`] records passes:
//! resources are bound by their names in the shader, and a tracker in each resource plans the barriers.

#![allow(unsafe_code)]

mod acceleration;
mod access;
mod barrier;
mod descriptors;
mod device;
mod draw;
mod error;
mod frame;
mod frame_slot;
mod instance;
mod layout;
mod loss;
mod material_sets;
mod memory;
mod meter;
mod mirror;
mod pass;
mod physical;
mod pipeline;
#[cfg(feature = "window")]
mod present;
#[cfg(feature = "window")]
mod present_slot;
mod raw_device;
mod ray_query;
mod reflect;
#[cfg(feature = "shader-reload")]
mod reload;
mod sampler;
mod shared_set;
mod surface;
#[cfg(feature = "window")]
mod swapchain;
mod texels;
#[cfg(feature = "window")]
mod ui;
mod upload;

/// The compiled shaders, one constant per file.
pub mod shaders {
    /// A shader that traces rays, compiled for each tracer.
    #[derive(Clone, Copy, Debug)]
    pub struct PerTracer {
        /// With the BVH in storage buffers.
        pub software: &'static [u8],
        /// With ray queries.
        pub hardware: &'static [u8],
    }

    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));
}

pub use acceleration::{BottomLevel, PlacedStructure, TopLevel, TriangleRun};
pub use access::Access;
#[doc(no_inline)]
pub use ash::vk;
pub use device::Device;
pub use draw::{DrawList, Targets};
pub use error::VulkanError;
pub use frame::{Frame, Frames, Upload};
pub use frame_slot::FrameTimes;
pub use instance::{Instance, InstanceOptions};
pub use material_sets::MaterialSets;
pub use memory::{Buffer, BufferSlice, Image, ImageDescription};
pub use mirror::Mirror;
pub use pass::{Pass, Resource};
pub use physical::DeviceInfo;
pub use pipeline::{ComputePipeline, GraphicsDescription, GraphicsPipeline};
#[cfg(feature = "window")]
pub use present::{Presented, Presenter};
#[cfg(feature = "window")]
pub use present_slot::{Pane, Viewport};
pub use reflect::{BindingKind, Reflection};
#[cfg(feature = "shader-reload")]
pub use reload::compile_shaders;
pub use sampler::{Sampler, SamplerDescription};
pub use shared_set::SharedSet;
pub use surface::Surface;
#[cfg(feature = "window")]
pub use swapchain::PresentMode;
#[cfg(feature = "window")]
pub use ui::UiDrawing;
