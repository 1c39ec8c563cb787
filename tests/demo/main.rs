//! The window, driven by real input events on an X server without a screen.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../support/mod.rs"]
mod support;

mod desk;
mod drop;
mod opening;
mod replay;
mod session;
mod smooth;

use std::sync::Mutex;

/// Windows get input one after the other: two at once are slow enough to be taken for stuck.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
