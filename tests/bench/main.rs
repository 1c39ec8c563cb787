//! The benchmark from the command line, its reports and comparisons; data sets for denoisers, and denoisers over them.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod against;
mod bad_datasets;
mod command;
mod dataset;
mod denoise;
mod methods;
mod micro;
#[path = "../program/mod.rs"]
mod program;
mod report;
mod resume;
#[path = "../support/mod.rs"]
mod support;
