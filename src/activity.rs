//! The step of loading in progress, such as `reading a.obj: 2.0 million lines`, for a progress message.

use std::sync::{Mutex, PoisonError};

static NOW: Mutex<String> = Mutex::new(String::new());

/// Sets the step that begins.
pub(crate) fn begin(what: impl Into<String>) {
    *NOW.lock().unwrap_or_else(PoisonError::into_inner) = what.into();
}

/// The step in progress.
pub(crate) fn now() -> String {
    NOW.lock().unwrap_or_else(PoisonError::into_inner).clone()
}
