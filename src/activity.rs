//! What the program is preparing at the moment, such as `reading a.obj: 2.0 million lines`: written by what takes long, read by
//! who shows it.

use std::sync::{Mutex, PoisonError};

static NOW: Mutex<String> = Mutex::new(String::new());

/// Says what begins now.
pub(crate) fn begin(what: impl Into<String>) {
    *NOW.lock().unwrap_or_else(PoisonError::into_inner) = what.into();
}

/// What began last.
pub(crate) fn now() -> String {
    NOW.lock().unwrap_or_else(PoisonError::into_inner).clone()
}
