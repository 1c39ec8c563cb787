//! Denoisers: a noisy signal and what is known of the visible surfaces in, a clean one out.
//!
//! None knows where its signal comes from. Each owns its history and forgets it when told.

pub mod svgf;
