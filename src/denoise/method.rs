//! The description of a denoiser, so that nothing else needs to know it by name.

use std::sync::Arc;

use super::{Denoiser, SignalNoise};
use crate::report::PassInfo;
use crate::settings::{BmfrSettings, Denoise, Settings, SvgfSettings};
use crate::vulkan::{Device, VulkanError};

/// A denoiser is used for one of these signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// Indirect irradiance of an estimator.
    Indirect,
    /// Visibility of lights with an extent.
    SoftShadows,
    /// Radiance along reflection rays.
    Reflections,
}

impl Use {
    /// Every use, in the order of the names and colours of [`DenoiserPass::new`].
    pub const ALL: [Self; 3] = [Self::Indirect, Self::SoftShadows, Self::Reflections];
}

/// The settings of denoisers, which see no others: a denoiser stays while these do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DenoiserSettings {
    /// Which denoiser.
    pub denoise: Denoise,
    /// Settings of SVGF.
    pub svgf: SvgfSettings,
    /// Settings of BMFR; its defaults where the use never gets it.
    pub bmfr: BmfrSettings,
}

impl DenoiserSettings {
    /// The denoiser settings for one use.
    pub fn of(settings: &Settings, usage: Use) -> Self {
        let bmfr = if usage == Use::Indirect { settings.bmfr } else { BmfrSettings::default() };
        Self { denoise: settings.effects.denoise, svgf: settings.svgf, bmfr }
    }
}

/// A denoiser is made of this alone: the same description makes the same denoiser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DenoiserDescription {
    /// It denoises this signal.
    pub usage: Use,
    /// The noise of the signal.
    pub noise: SignalNoise,
    /// The size of the signal, texels.
    pub extent: [u32; 2],
    /// The settings, which were checked.
    pub settings: DenoiserSettings,
}

/// Makes a denoiser; fails where the device does not support it.
pub type MakeDenoiser = fn(&Arc<Device>, &DenoiserDescription) -> Result<Box<dyn Denoiser>, VulkanError>;

/// The description of a denoiser. Command line, scene files, reports, benchmarks and the window list what it names.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Value of `--denoise`.
    pub denoise: Denoise,
    /// Makes the denoiser of one use; fails where the device does not support it.
    pub make: MakeDenoiser,
    /// Whether it follows surfaces from frame to frame even where the signal's variance is known.
    pub follows_known_noise: bool,
    /// Passes, in the order of the frame.
    pub passes: &'static [DenoiserPass],
}

impl Method {
    /// A method without passes: to be completed by what it has.
    pub const fn new(denoise: Denoise, make: MakeDenoiser) -> Self {
        Self { denoise, make, follows_known_noise: false, passes: &[] }
    }
}

/// A pass of a denoiser, made by [`denoiser_pass`](crate::denoiser_pass). Each use has a name and a colour of its own for it.
#[derive(Clone, Copy, Debug)]
pub struct DenoiserPass {
    infos: [PassInfo; 3],
    only: Option<Use>,
}

impl DenoiserPass {
    /// A pass with a name and a colour for each use, in the order of [`Use`].
    pub const fn new(names: [&'static str; 3], colours: [[u8; 3]; 3]) -> Self {
        let [indirect, shadows, reflections] = names;
        let infos = [
            PassInfo::new(indirect, colours[0]),
            PassInfo::new(shadows, colours[1]),
            PassInfo::new(reflections, colours[2]),
        ];
        Self { infos, only: None }
    }

    /// The pass for a denoiser that runs it for one use alone.
    #[must_use]
    pub const fn only_for(self, usage: Use) -> Self {
        Self { only: Some(usage), ..self }
    }

    /// The name of the pass for one use: that of its timer, label and row in reports.
    pub const fn name(&self, usage: Use) -> &'static str {
        self.infos[usage as usize].name
    }

    /// The row of the pass for one use; none where that use never runs it.
    pub fn info(&self, usage: Use) -> Option<&PassInfo> {
        self.only.is_none_or(|only| only == usage).then_some(&self.infos[usage as usize])
    }
}

/// A [`DenoiserPass`] whose name has the prefix of each use, with its colours in plots for indirect light, soft shadows and
/// reflections.
#[macro_export]
macro_rules! denoiser_pass {
    ($name:literal, $colours:expr) => {
        $crate::denoise::DenoiserPass::new(
            [concat!("indirect_", $name), concat!("soft_shadows_", $name), concat!("reflections_", $name)],
            $colours,
        )
    };
}
