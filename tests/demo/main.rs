//! The window, driven by real input events on an X server without a screen.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

#[path = "../support/mod.rs"]
mod support;

mod compare;
mod drop;
mod edits;
mod log;
mod loss;
mod methods;
mod newcomer;
mod opening;
mod pointer;
mod replay;
mod screen;
mod session;
mod smooth;
mod split;
mod timeline;
mod tour;
mod visit;
mod window;
mod x_server;

use std::sync::Mutex;

/// Windows get input one at a time: two at once are slow enough to seem stuck.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
