//! The Vulkan instance and its validation messages.

use std::ffi::{CStr, c_char, c_void};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use ash::{ext, khr, vk};
use raw_window_handle::RawDisplayHandle;

use super::VulkanError;

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Options of an [`Instance`].
#[derive(Clone, Copy, Debug, Default)]
pub struct InstanceOptions {
    /// Enables the Khronos validation layer, with synchronisation validation.
    pub validate: bool,
    /// The display of the windows to present to; none: no windows.
    pub display: Option<RawDisplayHandle>,
}

type Messages = Mutex<Vec<String>>;

/// Held while instances and devices are created and destroyed: loaders and layers read dispatch tables that another
/// thread may be changing (Vulkan-Loader issue 200).
pub(super) fn creation_lock() -> MutexGuard<'static, ()> {
    static COMING_OR_GOING: Mutex<()> = Mutex::new(());
    COMING_OR_GOING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A loaded Vulkan loader with an instance.
pub struct Instance {
    debug: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    raw: ash::Instance,
    messages: Arc<Messages>,
    has_debug_utils: bool,
    // Dropped last: the functions of `raw` live in the loaded library.
    entry: ash::Entry,
}

impl Instance {
    /// Loads the loader and creates an instance for Vulkan 1.3.
    pub fn new(options: InstanceOptions) -> Result<Arc<Self>, VulkanError> {
        // SAFETY: the loader is the system's Vulkan library; it stays loaded as long as `entry` lives.
        let entry =
            unsafe { ash::Entry::load() }.map_err(|error| VulkanError::NoLoader(error.to_string()))?;
        let has_debug_utils = has_extension(&entry, None, ext::debug_utils::NAME);
        if options.validate && !has_layer(&entry) {
            return Err(VulkanError::NoValidation);
        }
        let raw = create_instance(&entry, options, has_debug_utils)?;
        let messages = Arc::new(Messages::default());
        let mut instance = Self { debug: None, raw, messages, has_debug_utils, entry };
        if options.validate && has_debug_utils {
            instance.debug = Some(instance.create_messenger()?);
        }
        Ok(Arc::new(instance))
    }

    /// Messages of the validation layer so far.
    pub fn validation_messages(&self) -> Vec<String> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn raw(&self) -> &ash::Instance {
        &self.raw
    }

    pub(super) fn entry(&self) -> &ash::Entry {
        &self.entry
    }

    pub(super) fn has_debug_utils(&self) -> bool {
        self.has_debug_utils
    }

    fn create_messenger(
        &self,
    ) -> Result<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT), VulkanError> {
        let functions = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::ERROR | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING,
            )
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                    | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
            )
            .pfn_user_callback(Some(on_message))
            .user_data(Arc::as_ptr(&self.messages).cast_mut().cast());
        // SAFETY: `user_data` points into `self.messages`, which outlives the messenger (see `drop`).
        let messenger = unsafe { functions.create_debug_utils_messenger(&info, None) }
            .map_err(VulkanError::call("creation", "debug messenger"))?;
        Ok((functions, messenger))
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        let _guard = creation_lock();
        // SAFETY: devices hold an `Arc` of the instance, so none is left; the messenger goes first.
        unsafe {
            if let Some((functions, messenger)) = self.debug.take() {
                functions.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn create_instance(
    entry: &ash::Entry,
    options: InstanceOptions,
    has_debug_utils: bool,
) -> Result<ash::Instance, VulkanError> {
    let application = vk::ApplicationInfo::default()
        .application_name(c"glowworm")
        .engine_name(c"glowworm")
        .api_version(vk::API_VERSION_1_3);
    let mut extensions: Vec<*const c_char> = Vec::new();
    let mut flags = vk::InstanceCreateFlags::empty();
    // Otherwise the loader hides drivers that lack parts of Vulkan, as MoltenVK does.
    if has_extension(entry, None, khr::portability_enumeration::NAME) {
        extensions.push(khr::portability_enumeration::NAME.as_ptr());
        flags |= vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR;
    }
    if has_debug_utils {
        extensions.push(ext::debug_utils::NAME.as_ptr());
    }
    if let Some(display) = options.display {
        let needed = ash_window::enumerate_required_extensions(display)
            .map_err(VulkanError::call("query of the extensions", "windows"))?;
        extensions.extend_from_slice(needed);
    }
    let layers = if options.validate { vec![VALIDATION_LAYER.as_ptr()] } else { Vec::new() };
    let has_features =
        options.validate && has_extension(entry, Some(VALIDATION_LAYER), ext::validation_features::NAME);
    if has_features {
        extensions.push(ext::validation_features::NAME.as_ptr());
    }
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut info = vk::InstanceCreateInfo::default()
        .flags(flags)
        .application_info(&application)
        .enabled_extension_names(&extensions)
        .enabled_layer_names(&layers);
    if has_features {
        info = info.push_next(&mut features);
    }
    let _guard = creation_lock();
    // SAFETY: every pointer in `info` outlives the call.
    unsafe { entry.create_instance(&info, None) }.map_err(|result| match result {
        vk::Result::ERROR_INCOMPATIBLE_DRIVER | vk::Result::ERROR_INITIALIZATION_FAILED => {
            VulkanError::NoDevice(
                "no Vulkan driver is installed (Debian/Ubuntu: apt install mesa-vulkan-drivers)".to_owned(),
            )
        }
        vk::Result::ERROR_EXTENSION_NOT_PRESENT if options.display.is_some() => {
            VulkanError::NoDevice("no Vulkan driver can present to windows of this display".to_owned())
        }
        result => VulkanError::call("creation", "instance")(result),
    })
}

fn has_layer(entry: &ash::Entry) -> bool {
    // SAFETY: plain query.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(VALIDATION_LAYER))
}

fn has_extension(entry: &ash::Entry, layer: Option<&CStr>, name: &CStr) -> bool {
    // SAFETY: plain query.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(layer) }.unwrap_or_default();
    extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name))
}

unsafe extern "system" fn on_message(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: the layer passes valid data, and `user` is the `Messages` given at creation.
    let (text, messages) = unsafe {
        let text = (*data).message_as_c_str().map(CStr::to_string_lossy);
        (text, &*user.cast::<Messages>())
    };
    let text = text.map_or_else(String::new, |text| text.into_owned());
    log::debug!("validation: {text}");
    messages.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    vk::FALSE
}
