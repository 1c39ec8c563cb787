//! The passes of a frame in their order: those of the CPU, then on the device those that all methods share, with those of the
//! estimator and of the denoisers between.

use super::{Method, methods};
use crate::denoise::{self, Use};
use crate::report::PassInfo;

/// The CPU's passes that all methods share; those of the method follow.
const CPU: [PassInfo; 1] = [PassInfo::new("bvh_update", [140, 86, 75])];
/// The passes up to the noisy soft shadows, which are denoised next.
const SURFACES: [PassInfo; 3] = [
    PassInfo::new("gbuffer", [237, 201, 72]),
    PassInfo::new("reprojection", [214, 176, 120]),
    PassInfo::new("soft_shadows_trace", [150, 120, 20]),
];
/// The passes of direct light; those of the method follow, whose irradiance is then denoised.
const DIRECT: [PassInfo; 3] = [
    PassInfo::new("direct_shadows", [182, 153, 45]),
    PassInfo::new("direct_shading", [89, 161, 79]),
    PassInfo::new("thin_surfaces", [118, 183, 178]),
];
/// The passes of noisy reflections, which are denoised next.
const REFLECTIONS: [PassInfo; 2] = [
    PassInfo::new("environment_prefilter", [158, 154, 200]),
    PassInfo::new("reflections_trace", [120, 80, 170]),
];
/// The passes that make the picture.
const PICTURE: [PassInfo; 9] = [
    PassInfo::new("combine", [227, 119, 194]),
    PassInfo::part("combine", "radiance", [227, 119, 194]),
    PassInfo::part("combine", "exposure", [237, 160, 210]),
    PassInfo::part("combine", "tone_map", [200, 90, 170]),
    PassInfo::new("taa", [188, 128, 189]),
    PassInfo::new("still", [208, 168, 209]),
    PassInfo::part("still", "still_mean", [208, 168, 209]),
    PassInfo::part("still", "still_spatial_filter", [222, 190, 223]),
    PassInfo::part("still", "still_fade", [190, 145, 192]),
];

/// All passes in the order of a frame, each with the name of its method, or `shared` by all.
pub fn passes() -> impl Iterator<Item = (&'static str, &'static PassInfo)> {
    passes_with(methods())
}

/// The passes of a frame in which these methods may run, as [`passes`].
pub fn passes_with(methods: &'static [Method]) -> impl Iterator<Item = (&'static str, &'static PassInfo)> {
    let own = |of: fn(&Method) -> &'static [PassInfo]| {
        methods.iter().flat_map(move |method| of(method).iter().map(|pass| (method.name(), pass)))
    };
    let shared = |passes: &'static [PassInfo]| passes.iter().map(|pass| ("shared", pass));
    let denoisers = |usage: Use| denoise::passes(usage).map(|pass| ("shared", pass));
    let cpu = shared(&CPU).chain(own(|method| method.passes.cpu));
    let direct = shared(&SURFACES).chain(denoisers(Use::SoftShadows)).chain(shared(&DIRECT));
    let indirect = own(|method| method.passes.device).chain(denoisers(Use::Indirect));
    let reflections = shared(&REFLECTIONS).chain(denoisers(Use::Reflections));
    cpu.chain(direct).chain(indirect).chain(reflections).chain(shared(&PICTURE))
}

/// Whether a row of a frame's times is a part of a stage, whose time holds it already.
pub fn is_part(name: &str) -> bool {
    passes().any(|(_, pass)| pass.name == name && pass.stage.is_some())
}
