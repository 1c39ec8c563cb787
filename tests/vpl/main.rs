//! The VPL manager against known answers: energy, balance, budget, and expiry of history.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

#[path = "../support/depth.rs"]
mod depth;
mod emission;
mod energy;
mod history;
mod inspection;
mod motion;
mod moving_thin_surfaces;
mod placement;
mod replacement;
mod sizes;
mod support;
mod thin_surfaces;
