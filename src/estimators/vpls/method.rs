//! The description of the method: passes, counters, axes.

use super::{InvalidationReason, SHADOW_RAYS, VIEWS, Vpls};
use crate::estimators::{Axis, CounterInfo, Method, MethodPasses};
use crate::report::PassInfo;
use crate::settings::{Indirect, Settings};

/// The description of the method.
pub const METHOD: Method = Method {
    passes: PASSES,
    views: VIEWS,
    counters: &COUNTERS,
    warm_up: |settings| settings.vpl.temporal_sets,
    axes: AXES,
    cost: Some(&AXES[1]),
    variants: &["vpls@T=1", "vpls@T=4", "vpls@direct=rays"],
    rays: |Settings { vpl, .. }| vpl.slots.div_ceil(vpl.temporal_sets * vpl.interleave.pow(2)),
    lights_hits: true,
    ..Method::new(Indirect::VPLS, "VPLs", |context| Ok(Box::new(Vpls::new(context)?)))
};

const AXES: &[Axis] = &[
    Axis {
        setting: "temporal_sets",
        short: Some("T"),
        label: "temporal sets T",
        phrase: "T = {}",
        default_sweep: Some("1,4,8,16,32"),
        divides_work: true,
        get: |settings| settings.vpl.temporal_sets,
        set: |settings, sets| settings.vpl.temporal_sets = sets.clamp(1, settings.vpl.slots),
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
    },
];
/// Most VPL slots.
const MOST_VPLS: u32 = 65_536;

const PASSES: MethodPasses = MethodPasses {
    cpu: &[
        PassInfo { name: "vpl_invalidation", colour: [214, 95, 95] },
        PassInfo { name: "vpl_replacement", colour: [242, 142, 43] },
    ],
    device: &[
        PassInfo { name: "indirect_shadows", colour: [31, 111, 180] },
        PassInfo { name: "indirect_shading", colour: [98, 182, 222] },
        PassInfo { name: "indirect_reprojection", colour: [148, 103, 189] },
        PassInfo { name: "hit_light", colour: [70, 130, 160] },
    ],
};

const COUNTERS: [CounterInfo; 14] = [
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
