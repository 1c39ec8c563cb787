//! The benchmark as a person meets it, its reports, and what it says of changes; data sets for denoisers.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod against;
mod command;
mod dataset;
mod micro;
#[path = "../program/mod.rs"]
mod program;
mod report;
mod resume;
#[path = "../support/mod.rs"]
mod support;
