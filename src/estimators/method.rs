//! The description of a method, so that nothing else needs to know it by name.

use super::{Estimator, EstimatorContext};
use crate::denoise::SignalNoise;
use crate::passes::buffer_view::View;
use crate::report::PassInfo;
use crate::settings::{Indirect, Settings};
use crate::vulkan::VulkanError;

/// The description of a method. Command line, scene files, reports, benchmarks and the window list what it names.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// Value of `--indirect`, whose name is that of the method. Settings of its own are the group `settings.NAME`.
    pub indirect: Indirect,
    /// A title for people.
    pub label: &'static str,
    /// Makes the estimator; fails where the device does not support it.
    pub make: fn(&EstimatorContext<'_>) -> Result<Box<dyn Estimator>, VulkanError>,
    /// Passes.
    pub passes: MethodPasses,
    /// Views.
    pub views: &'static [View],
    /// Counters.
    pub counters: &'static [CounterInfo],
    /// Frames after which the picture of a still scene is complete: benchmarks warm up for so many, `render` draws so many.
    pub warm_up: fn(&Settings) -> u32,
    /// The settings that benchmarks sweep and short names state.
    pub axes: &'static [Axis],
    /// The axis that makes it better and slower in proportion, for comparisons at equal time; none where nothing does.
    pub cost: Option<&'static Axis>,
    /// Short names of variants that `bench --methods all` adds to the method itself.
    pub variants: &'static [&'static str],
    /// About how many rays it casts for a pixel of a frame, for estimates of the remaining time.
    pub rays: fn(&Settings) -> u32,
    /// Whether [`Estimator::light_hits`] lights surfaces that are not on the screen, if only with zero light. Where it does
    /// not, users are told.
    pub lights_hits: bool,
    /// Whether it gives any light.
    pub gives_light: bool,
    /// Knowledge of the noise of its irradiance, which decides how that is denoised.
    pub noise: SignalNoise,
    /// Pixels from one texel of [`Estimator::signal`] to the next, in each direction.
    pub signal_step: u32,
}

/// A whole number among the settings, along which a method's quality and cost change.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Key of the setting.
    pub setting: &'static str,
    /// Short form in the short names of methods, if it has one: `T` in `vpls@T=1`.
    pub short: Option<&'static str>,
    /// Label in plots and tables.
    pub label: &'static str,
    /// A value in the name of a run, with `{}` for the number: `T = {}`. See [`Self::phrase`].
    pub phrase: &'static str,
    /// The list of values that `bench` measures and the window offers unless told otherwise; none: that of the scene.
    pub default_sweep: Option<&'static str>,
    /// Whether a frame at N does about one N-th of the work at 1.
    pub divides_work: bool,
    /// Value in the settings.
    pub get: fn(&Settings) -> u32,
    /// Sets it, as near to the value as its range and the other settings allow.
    pub set: fn(&mut Settings, u32),
    /// Undivided work at half resolution, where that is what divided work has.
    pub half: Option<HalfResolution>,
}

/// Undivided work at the half resolution of divided work: a row of its own in a sweep, by which a speed-up is split into what dividing
/// gains and what the resolution does.
#[derive(Clone, Copy, Debug)]
pub struct HalfResolution {
    /// The settings at half resolution; none where those given have it, or divide the work.
    pub of: fn(&Settings) -> Option<Settings>,
    /// Whether these settings are undivided work at half resolution.
    pub is: fn(&Settings) -> bool,
}

impl Axis {
    /// Value in the settings, as text.
    pub fn text(&self, settings: &Settings) -> String {
        (self.get)(settings).to_string() + self.note(settings)
    }

    /// Suffix of values of work at half resolution.
    pub fn note(&self, settings: &Settings) -> &'static str {
        if self.half.is_some_and(|half| (half.is)(settings)) { " (half)" } else { "" }
    }

    /// A value in the name of a run.
    pub fn phrase(&self, value: u32) -> String {
        let phrase = if value == 1 { self.phrase.trim_end_matches('s') } else { self.phrase };
        phrase.replace("{}", &value.to_string())
    }
}

/// A count that a method makes in each frame.
#[derive(Clone, Copy, Debug)]
pub struct CounterInfo {
    /// Key in reports; dots nest.
    pub name: &'static str,
    /// Name in tables; none: it is in files alone.
    pub label: Option<&'static str>,
    /// Colour in the window's plot, sRGB; none: it is not plotted.
    pub colour: Option<[u8; 3]>,
}

impl CounterInfo {
    /// A counter that is in files alone.
    pub const fn new(name: &'static str) -> Self {
        Self { name, label: None, colour: None }
    }

    /// A counter that is in tables.
    pub const fn listed(name: &'static str, label: &'static str) -> Self {
        Self { name, label: Some(label), colour: None }
    }

    /// A counter that is in tables, and plotted in this colour.
    pub const fn plotted(name: &'static str, label: &'static str, colour: [u8; 3]) -> Self {
        Self { name, label: Some(label), colour: Some(colour) }
    }
}

impl Method {
    /// A method without passes, views, counters and axes, which lights no hits: to be completed by what it has.
    pub const fn new(
        indirect: Indirect,
        label: &'static str,
        make: fn(&EstimatorContext<'_>) -> Result<Box<dyn Estimator>, VulkanError>,
    ) -> Self {
        Self {
            indirect,
            label,
            make,
            passes: MethodPasses { cpu: &[], device: &[] },
            views: &[],
            counters: &[],
            warm_up: |_| ANTIALIASING_POSITIONS,
            axes: &[],
            cost: None,
            variants: &[],
            rays: |_| 1,
            lights_hits: false,
            gives_light: true,
            noise: SignalNoise::None,
            signal_step: 1,
        }
    }

    /// The value of `--indirect`.
    pub const fn name(&self) -> &'static str {
        self.indirect.name()
    }

    /// The short name of the method with `settings`: `vpls@T=16`.
    pub fn short_name(&self, settings: &Settings) -> String {
        let axes = self.axes.iter().filter_map(|axis| Some((axis.short?, axis)));
        let stated = axes.map(|(short, axis)| format!("@{short}={}", axis.text(settings)));
        self.name().to_owned() + &stated.collect::<String>()
    }
}

/// Frames that antialiasing takes until the picture of a still scene is complete.
const ANTIALIASING_POSITIONS: u32 = 16;

/// The passes of a method, in the order of the frame.
#[derive(Clone, Copy, Debug)]
pub struct MethodPasses {
    /// On the CPU, while the device draws the frame before.
    pub cpu: &'static [PassInfo],
    /// On the device.
    pub device: &'static [PassInfo],
}
