//! Errors of the Vulkan layer; each message is one line.

use ash::vk;

/// A failed Vulkan operation.
#[derive(Debug, thiserror::Error)]
pub enum VulkanError {
    /// The loader library is missing.
    #[error(
        "no Vulkan: the loader library could not be opened ({0}); install it (Debian/Ubuntu: apt install libvulkan1 mesa-vulkan-drivers)"
    )]
    NoLoader(String),
    /// No driver, or no device that meets the requirements.
    #[error("no usable Vulkan device: {0}")]
    NoDevice(String),
    /// `--device` matches no device.
    #[error("--device {wanted}: no such device; available: {available}")]
    UnknownDevice {
        /// The requested device.
        wanted: String,
        /// Devices by index and name.
        available: String,
    },
    /// The validation layer is missing.
    #[error(
        "--validate: the layer VK_LAYER_KHRONOS_validation is missing; install it (Debian/Ubuntu: apt install vulkan-validationlayers)"
    )]
    NoValidation,
    /// A Vulkan call failed.
    #[error("Vulkan: {operation} of {object} failed: {}", reason(*result))]
    Call {
        /// The operation.
        operation: &'static str,
        /// Object.
        object: String,
        /// The driver's result code.
        result: vk::Result,
    },
    /// The user interface could not be drawn.
    #[error("user interface: {0}")]
    Interface(String),
    /// Device memory is exhausted.
    #[error(
        "not enough device memory for {object} ({mebibytes} MiB): {reason}; try a smaller --size, --temporal-sets or scene"
    )]
    Memory {
        /// The object.
        object: String,
        /// Size, MiB.
        mebibytes: u64,
        /// The allocator's message.
        reason: String,
    },
    /// The settings or the scene exceed a limit of the device.
    #[error("{what} exceeds the device's limit of {limit}; try a smaller --size, --temporal-sets or scene")]
    Limit {
        /// The requested object, with its size.
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
        /// The problem.
        problem: String,
    },
    /// A compiled shader could not be read.
    #[error("shader {name}: {problem}")]
    Shader {
        /// Shader name.
        name: String,
        /// The problem.
        problem: String,
    },
}

/// Explanation of a result code to the user.
fn reason(result: vk::Result) -> String {
    match result {
        vk::Result::ERROR_DEVICE_LOST => {
            "the device was lost, as after a reset of its driver; run it again, or on another --device"
                .to_owned()
        }
        other => other.to_string(),
    }
}

impl VulkanError {
    /// Whether the device is lost, as after a driver crash: everything on it must be recreated.
    pub fn is_device_lost(&self) -> bool {
        matches!(self, Self::Call { result: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// Wraps a result code: `.map_err(VulkanError::call("creation", "image depth"))`.
    pub(super) fn call(
        operation: &'static str,
        object: impl Into<String>,
    ) -> impl FnOnce(vk::Result) -> VulkanError {
        move |result| VulkanError::Call { operation, object: object.into(), result }
    }
}
