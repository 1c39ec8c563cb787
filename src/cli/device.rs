//! Opens the Vulkan device of the options, and checks its validation messages.

use std::sync::Arc;

use super::options::DeviceOptions;
use super::progress::preparing;
use super::{CliError, say};
use crate::activity;
use crate::vulkan::{Device, Instance, InstanceOptions};

/// Loads Vulkan, with validation if requested.
pub(super) fn instance(options: &DeviceOptions) -> Result<Arc<Instance>, CliError> {
    Ok(Instance::new(InstanceOptions { validate: options.validate, display: None })?)
}

/// Opens the device that the options name, or the best one.
pub(super) fn open(options: &DeviceOptions) -> Result<Arc<Device>, CliError> {
    activity::begin("opening the device");
    preparing(|| Ok(Device::open(&instance(options)?, options.device.as_deref())?))
}

/// Notes that the device is a slow CPU.
pub(super) fn note_slow(device: &Device) {
    let info = device.info();
    if info.is_cpu() {
        say::note(&format!("{} is a slow CPU; glowworm info lists all devices", info.name));
    }
}

/// Fails if there are validation messages: with the first one, and the rest as warnings.
pub(super) fn check_validation(messages: &[String]) -> Result<(), CliError> {
    let Some((first, others)) = messages.split_first() else { return Ok(()) };
    others.iter().for_each(|message| say::warning(message));
    Err(CliError::Validation { count: messages.len(), first: first.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_validation_message_is_a_failure() {
        assert!(check_validation(&[]).is_ok());
        let error = check_validation(&["bad barrier".to_owned(), "bad layout".to_owned()]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "--validate: 2 messages of the validation layer, the first: bad barrier"
        );
        assert_eq!(error.exit_code(), 1);
    }
}
