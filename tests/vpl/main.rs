//! The VPL manager against known answers: energy, balance, budget, and expiry of history.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod emission;
mod energy;
mod history;
mod inspection;
mod motion;
mod moving_sheets;
mod placement;
mod replacement;
mod sheets;
mod sizes;
mod support;
