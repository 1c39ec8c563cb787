//! Swapchains and present modes.

use std::sync::Arc;

use ash::{khr, vk};
use serde::Serialize;

use super::{Device, Surface, VulkanError};

/// All of an image of a swapchain.
pub(super) const WHOLE: vk::ImageSubresourceRange = vk::ImageSubresourceRange {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    base_mip_level: 0,
    level_count: 1,
    base_array_layer: 0,
    layer_count: 1,
};

/// When a presented image replaces the one on screen (`VkPresentModeKHR`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PresentMode {
    /// At the next vertical blank, in order: no tearing. Always available.
    #[default]
    Fifo,
    /// In order, but a late image at once: tears rather than stutters.
    FifoRelaxed,
    /// The newest image at the next vertical blank: no tearing, low latency, more work.
    Mailbox,
    /// At once: tearing, lowest latency.
    Immediate,
}

impl PresentMode {
    const ALL: [(Self, vk::PresentModeKHR); 4] = [
        (Self::Fifo, vk::PresentModeKHR::FIFO),
        (Self::FifoRelaxed, vk::PresentModeKHR::FIFO_RELAXED),
        (Self::Mailbox, vk::PresentModeKHR::MAILBOX),
        (Self::Immediate, vk::PresentModeKHR::IMMEDIATE),
    ];

    /// Label in the user interface.
    pub fn label(self) -> &'static str {
        match self {
            Self::Fifo => "fifo",
            Self::FifoRelaxed => "fifo, relaxed",
            Self::Mailbox => "mailbox",
            Self::Immediate => "immediate",
        }
    }

    /// The modes that `surface` supports on `device`.
    pub fn offered(device: &Device, surface: &Surface) -> Result<Vec<Self>, VulkanError> {
        let offered = surface.present_modes(device.physical())?;
        Ok(Self::ALL.into_iter().filter(|(_, raw)| offered.contains(raw)).map(|(mode, _)| mode).collect())
    }

    fn raw(self) -> vk::PresentModeKHR {
        Self::ALL[self as usize].1
    }
}

/// A swapchain with its views.
pub(super) struct Swapchain {
    pub functions: khr::swapchain::Device,
    pub raw: vk::SwapchainKHR,
    pub images: Vec<SwapchainImage>,
    pub extent: vk::Extent2D,
    pub format: vk::Format,
    pub mode: PresentMode,
    _surface: Arc<Surface>,
    device: Arc<Device>,
}

/// One of its images.
pub(super) struct SwapchainImage {
    pub raw: vk::Image,
    pub view: vk::ImageView,
    /// Signalled when rendering is done. One per image: reusable once the image is acquired again.
    pub drawn: vk::Semaphore,
}

impl Swapchain {
    /// Creates a swapchain of the surface's extent, or of `wanted` if the surface leaves it open; none while the
    /// window has no area, as when minimised. Retires `old`.
    pub fn new(
        device: &Arc<Device>,
        surface: &Arc<Surface>,
        wanted: [u32; 2],
        mode: PresentMode,
        old: Option<Self>,
    ) -> Result<Option<Self>, VulkanError> {
        let capabilities = surface.capabilities(device.physical())?;
        let extent = extent(&capabilities, wanted);
        if extent.width == 0 || extent.height == 0 {
            return Ok(None);
        }
        let format = format(&surface.formats(device.physical())?);
        let offered = PresentMode::offered(device, surface)?;
        let mode = if offered.contains(&mode) { mode } else { PresentMode::Fifo };
        let most = if capabilities.max_image_count == 0 { u32::MAX } else { capabilities.max_image_count };
        let alphas = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT];
        let alpha = alphas.into_iter().find(|alpha| capabilities.supported_composite_alpha.contains(*alpha));
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw())
            .min_image_count((capabilities.min_image_count + 1).min(most))
            .image_format(format.format)
            .image_color_space(format.color_space)
            .image_extent(extent)
            .image_array_layers(1)
            .image_usage(vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(alpha.unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE))
            .present_mode(mode.raw())
            .clipped(true)
            .old_swapchain(old.as_ref().map_or(vk::SwapchainKHR::null(), |old| old.raw));
        let functions = khr::swapchain::Device::new(device.instance().raw(), device.raw());
        // SAFETY: `info` is complete; the device has the extension; the old swapchain is idle (the caller waited).
        let raw = unsafe { functions.create_swapchain(&info, None) }
            .map_err(VulkanError::call("creation", "swapchain"))?;
        drop(old);
        let mut swapchain = Self {
            functions,
            raw,
            images: Vec::new(),
            extent,
            format: format.format,
            mode,
            _surface: Arc::clone(surface),
            device: Arc::clone(device),
        };
        swapchain.add_images()?;
        Ok(Some(swapchain))
    }

    fn add_images(&mut self) -> Result<(), VulkanError> {
        let error = |result| VulkanError::call("creation", "swapchain images")(result);
        // SAFETY: the infos are complete; `drop` destroys what was made.
        unsafe {
            for raw in self.functions.get_swapchain_images(self.raw).map_err(error)? {
                let info = vk::ImageViewCreateInfo::default()
                    .image(raw)
                    .view_type(vk::ImageViewType::TYPE_2D)
                    .format(self.format)
                    .subresource_range(WHOLE);
                let device = self.device.raw();
                let view = device.create_image_view(&info, None).map_err(error)?;
                let drawn =
                    device.create_semaphore(&vk::SemaphoreCreateInfo::default(), None).map_err(error)?;
                self.images.push(SwapchainImage { raw, view, drawn });
            }
        }
        Ok(())
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        // SAFETY: the owner waits for the device before.
        unsafe {
            for image in &self.images {
                self.device.raw().destroy_image_view(image.view, None);
                self.device.raw().destroy_semaphore(image.drawn, None);
            }
            self.functions.destroy_swapchain(self.raw, None);
        }
    }
}

/// The surface's extent, or, if it leaves that open, `wanted` clamped to its limits.
fn extent(capabilities: &vk::SurfaceCapabilitiesKHR, wanted: [u32; 2]) -> vk::Extent2D {
    let current = capabilities.current_extent;
    if current.width != u32::MAX {
        return current;
    }
    let (least, most) = (capabilities.min_image_extent, capabilities.max_image_extent);
    vk::Extent2D {
        width: wanted[0].clamp(least.width, most.width.max(least.width)),
        height: wanted[1].clamp(least.height, most.height.max(least.height)),
    }
}

/// 8-bit UNORM: pictures are sRGB-encoded already.
fn format(offered: &[vk::SurfaceFormatKHR]) -> vk::SurfaceFormatKHR {
    let plain = [vk::Format::B8G8R8A8_UNORM, vk::Format::R8G8B8A8_UNORM];
    let fits = |format: &&vk::SurfaceFormatKHR| {
        plain.contains(&format.format) && format.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR
    };
    let first = offered.first().copied().unwrap_or_default();
    offered.iter().find(fits).copied().unwrap_or(first)
}
