//! The VPL manager against known answers: energy, balance, budget, and forgetting the past.

mod emission;
mod energy;
mod forgetting;
mod looking;
mod motion;
mod replacement;
mod sizes;
mod support;
