//! How fast each tracer is on a device: occlusion rays in a small world of its own.
//!
//! In: a device that offers both. Out: rays a second in a hall with columns.

mod hall;

use std::sync::Arc;

use glam::Affine3A;

use crate::bvh::TwoLevelBvh;
use crate::passes::cast_rays::RayCaster;
use crate::gpu_scene::tracer::RayTracer;
use crate::report::TracerRates;
use crate::vulkan::{Device, VulkanError};

/// Rays of the first try; each further one has so many times more.
const FIRST: u32 = 4096;
const MORE: u32 = 8;
/// Most rays of a try.
const MOST: u32 = FIRST * MORE * MORE * MORE * MORE;
/// A try that takes so long is long enough, milliseconds.
const ENOUGH_MS: f64 = 2.0;
/// Tries of that length; the fastest counts, since whatever else the machine does only costs time.
const ROUNDS: u32 = 3;
/// Share of rays about which the tracers may disagree: those that pass an edge.
const DISAGREEMENT: f64 = 1e-3;

/// Measures both in turns; takes a fraction of a second.
pub(super) fn measure(device: &Arc<Device>) -> Result<TracerRates, VulkanError> {
    let scene = hall::scene();
    let bvh = TwoLevelBvh::build(&scene, &[Affine3A::IDENTITY]);
    let rays = hall::rays();
    let caster = |tracer| {
        let mut caster = RayCaster::new(device, tracer, &bvh)?;
        caster.upload(&rays)?;
        Ok::<_, VulkanError>(caster)
    };
    let mut casters = [caster(RayTracer::Software)?, caster(RayTracer::Hardware)?];

    // Find how many rays take long enough to be timed.
    let mut counts = [FIRST; 2];
    for (caster, count) in casters.iter_mut().zip(&mut counts) {
        while caster.cast_occluded(*count)? < ENOUGH_MS && *count < MOST {
            *count *= MORE;
        }
    }

    // Compare what both have answered.
    let [software, hardware] = [casters[0].answers()?, casters[1].answers()?];
    let common = (counts[0].min(counts[1]) as usize).min(rays.len());
    let differing = (0..common).filter(|&ray| (software[ray] < 0.0) != (hardware[ray] < 0.0)).count();
    let wrong = differing as f64 > DISAGREEMENT * common as f64;
    if wrong {
        log::warn!(
            "{}: its ray queries answer otherwise than the software tracer for {differing} of {common} rays",
            device.info().name
        );
    }

    let mut rates = [0.0f64; 2];
    for _ in 0..ROUNDS {
        for (caster, (count, rate)) in casters.iter_mut().zip(counts.iter().zip(&mut rates)) {
            let ms = caster.cast_occluded(*count)?.max(1e-6);
            *rate = rate.max(f64::from(*count) / ms * 1e3);
        }
    }
    Ok(TracerRates { software: rates[0], hardware: if wrong { 0.0 } else { rates[1] } })
}
