//! Denoisers: a noisy signal and what is known of the visible surfaces in, a clean one out.
//!
//! None knows where its signal comes from. Each owns its history and forgets it when told.

pub mod svgf;

/// A frame of a still scene. A denoiser begins another history at the first, which depends on nothing before, and shows that in
/// the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RestFrame {
    /// Its number, from 0.
    pub index: u32,
    /// Whether that history is shown from now on.
    pub shown: bool,
}
