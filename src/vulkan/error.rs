//! What can go wrong with Vulkan, in one line each.

use ash::vk;

/// A failed Vulkan operation.
#[derive(Debug, thiserror::Error)]
pub enum VulkanError {
    /// The loader library is missing.
    #[error(
        "no Vulkan: the loader library could not be opened ({0}); install it (Debian/Ubuntu: apt install libvulkan1 mesa-vulkan-drivers)"
    )]
    NoLoader(String),
    /// No driver, or none good enough.
    #[error("no usable Vulkan device: {0}")]
    NoDevice(String),
    /// `--device` names nothing.
    #[error("--device {wanted}: no such device; there are: {available}")]
    UnknownDevice {
        /// What was asked for.
        wanted: String,
        /// Devices by index and name.
        available: String,
    },
    /// The validation layer is missing.
    #[error(
        "--validate: the layer VK_LAYER_KHRONOS_validation is missing; install it (Debian/Ubuntu: apt install vulkan-validationlayers)"
    )]
    NoValidation,
    /// A call failed.
    #[error("Vulkan: {operation} of {object} failed: {result}")]
    Call {
        /// What was being done.
        operation: &'static str,
        /// To which object.
        object: String,
        /// What the driver answered.
        result: vk::Result,
    },
    /// The user interface could not be drawn.
    #[error("user interface: {0}")]
    Interface(String),
    /// Memory could not be had.
    #[error(
        "not enough device memory for {object} ({mebibytes} MiB): {reason}; try a smaller --size, --temporal-sets or scene"
    )]
    Memory {
        /// What needed it.
        object: String,
        /// How much.
        mebibytes: u64,
        /// What the allocator said.
        reason: String,
    },
    /// The device cannot do what the settings or the scene ask for.
    #[error(
        "{what} is more than the device allows ({limit}); try a smaller --size, --temporal-sets or scene"
    )]
    Limit {
        /// What was asked for, with its number.
        what: String,
        /// The device's limit.
        limit: u64,
    },
    /// A pass was recorded with a binding that its shader does not have, without one that it has, or
    /// with one of another kind.
    #[error("pass {pass}: binding {binding:?} {problem}")]
    Binding {
        /// Pass name.
        pass: String,
        /// Binding name.
        binding: String,
        /// What is wrong.
        problem: String,
    },
    /// A compiled shader could not be read.
    #[error("shader {name}: {problem}")]
    Shader {
        /// Shader name.
        name: String,
        /// What is wrong.
        problem: String,
    },
}

impl VulkanError {
    /// Whether the device is gone, as after a crash of its driver: everything on it must be made anew.
    pub fn is_device_lost(&self) -> bool {
        matches!(self, Self::Call { result: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// Wraps a driver answer: `.map_err(VulkanError::call("creation", "image depth"))`.
    pub(super) fn call(
        operation: &'static str,
        object: impl Into<String>,
    ) -> impl FnOnce(vk::Result) -> VulkanError {
        move |result| VulkanError::Call { operation, object: object.into(), result }
    }
}
