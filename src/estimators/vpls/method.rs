//! The description of the method: passes, counters, axes.

use super::{InvalidationReason, SHADOW_RAYS, VIEWS, Vpls};
use crate::denoise::SignalNoise;
use crate::estimators::{Axis, CounterInfo, HalfResolution, Method, MethodPasses};
use crate::report::PassInfo;
use crate::settings::{Indirect, SetResolution, Settings, VplSettings};

/// The description of the method.
pub const METHOD: Method = Method {
    passes: PASSES,
    views: VIEWS,
    counters: &COUNTERS,
    warm_up: |settings| settings.vpl.temporal_sets,
    axes: AXES,
    cost: Some(&AXES[1]),
    variants: &["vpls@T=1", "vpls@T=4", "vpls@direct=soft"],
    rays: |Settings { vpl, .. }| vpl.slots.div_ceil(vpl.temporal_sets * vpl.interleave.pow(2)),
    lights_hits: true,
    noise: SignalNoise::Variance,
    signal_step: 2,
    ..Method::new(Indirect::VPLS, "VPLs", |context| Ok(Box::new(Vpls::new(context)?)))
};

pub(super) const AXES: &[Axis] = &[
    Axis {
        setting: "temporal_sets",
        short: Some("T"),
        label: "temporal sets T",
        phrase: "T = {}",
        default_sweep: Some("1,4,8,16,32"),
        divides_work: true,
        get: |settings| settings.vpl.temporal_sets,
        set: |settings, sets| settings.vpl.temporal_sets = sets.clamp(1, settings.vpl.slots),
        half: Some(HalfResolution { of: at_half_resolution, is: is_single_at_half }),
    },
    Axis {
        setting: "vpls",
        short: None,
        label: "VPLs",
        phrase: "{} VPLs",
        default_sweep: None,
        divides_work: false,
        get: |settings| settings.vpl.slots,
        set: |settings, slots| settings.vpl.slots = slots.clamp(settings.vpl.temporal_sets, MOST_VPLS),
        half: None,
    },
    Axis {
        setting: "interleave",
        short: None,
        label: "interleave n",
        phrase: "n = {}",
        default_sweep: None,
        divides_work: false,
        get: |settings| settings.vpl.interleave,
        set: |settings, interleave| settings.vpl.interleave = interleave.clamp(1, 8),
        half: None,
    },
];

/// Whether there is one set, of half the resolution.
fn is_single_at_half(settings: &Settings) -> bool {
    settings.vpl.temporal_sets == 1 && settings.vpl.set_resolution == SetResolution::Half
}

/// One set, of the resolution that several have by themselves.
fn at_half_resolution(settings: &Settings) -> Option<Settings> {
    let vpl = VplSettings { set_resolution: SetResolution::Half, ..settings.vpl };
    let is_full = settings.indirect == Indirect::VPLS && vpl.temporal_sets == 1 && vpl.interleave > 1;
    (is_full && !is_single_at_half(settings)).then(|| Settings { vpl, ..settings.clone() })
}

/// Most VPL slots.
const MOST_VPLS: u32 = 65_536;

const PASSES: MethodPasses = MethodPasses {
    cpu: &[
        PassInfo::new("vpl_invalidation", [214, 95, 95]),
        PassInfo::new("vpl_replacement", [242, 142, 43]),
    ],
    device: &[
        PassInfo::new("indirect_shadows", [31, 111, 180]),
        PassInfo::part("indirect_shadows", "cluster_visibility", [91, 151, 205]),
        PassInfo::part("indirect_shadows", "vpl_sampling", [31, 111, 180]),
        PassInfo::part("indirect_shadows", "bias_compensation", [20, 75, 125]),
        PassInfo::new("indirect_shading", [98, 182, 222]),
        PassInfo::part("indirect_shading", "discontinuity_filter", [98, 182, 222]),
        PassInfo::new("indirect_reprojection", [148, 103, 189]),
        PassInfo::part("indirect_reprojection", "set_reprojection", [148, 103, 189]),
        PassInfo::part("indirect_reprojection", "irradiance_upsampling", [178, 143, 209]),
        PassInfo::new("hit_light", [70, 130, 160]),
    ],
};

pub(super) const COUNTERS: [CounterInfo; 14] = [
    CounterInfo::new("vpls.slots"),
    CounterInfo::plotted("vpls.valid", "valid", [110, 200, 110]),
    CounterInfo::new("vpls.useful"),
    CounterInfo::plotted("vpls.escaped", "escaped", [110, 160, 230]),
    CounterInfo::plotted("vpls.stale", "stale", [200, 200, 90]),
    CounterInfo::plotted("vpls.invalidated", "invalidated", [230, 90, 80]),
    CounterInfo::plotted("vpls.shot", "shot", [230, 160, 60]),
    CounterInfo::new(InvalidationReason::LightTurnedAway.counter()),
    CounterInfo::new(InvalidationReason::FacesAway.counter()),
    CounterInfo::new(InvalidationReason::Occluded.counter()),
    CounterInfo::new(InvalidationReason::ParentInvalid.counter()),
    CounterInfo::new(InvalidationReason::LightChanged.counter()),
    CounterInfo::new(InvalidationReason::NoSlot.counter()),
    CounterInfo::listed(SHADOW_RAYS, "shadow rays"),
];
