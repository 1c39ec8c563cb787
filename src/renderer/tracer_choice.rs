//! Which tracer a renderer uses: the one that was asked for, or ray queries where a GPU offers them.

use super::RenderError;
use crate::gpu_scene::tracer::RayTracer;
use crate::settings::TracerKind;
use crate::vulkan::DeviceInfo;

/// Finds the tracer for a device. The ray queries of a CPU are no faster than the software tracer.
///
/// # Errors
/// If the hardware tracer was asked for and the device lacks ray queries.
pub(super) fn choose(device: &DeviceInfo, wanted: TracerKind) -> Result<RayTracer, RenderError> {
    match (wanted, &device.ray_query_lacks) {
        (TracerKind::Hardware, Some(lacks)) => {
            Err(RenderError::NoHardwareTracer { device: device.name.clone(), lacks: lacks.clone() })
        }
        (TracerKind::Hardware, None) => Ok(RayTracer::Hardware),
        (TracerKind::Auto, None) if !device.is_cpu() => Ok(RayTracer::Hardware),
        (TracerKind::Auto | TracerKind::Software, _) => Ok(RayTracer::Software),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn auto_takes_the_ray_queries_of_gpus() {
        let device = |kind: &str, lacks: Option<&str>| DeviceInfo {
            kind: kind.to_owned(),
            ray_query_lacks: lacks.map(str::to_owned),
            ..DeviceInfo::default()
        };
        let lacks = Some("VK_KHR_ray_query");
        for (device, auto) in [
            (device("discrete", None), RayTracer::Hardware),
            (device("integrated", None), RayTracer::Hardware),
            (device("discrete", lacks), RayTracer::Software),
            (device("cpu", None), RayTracer::Software),
        ] {
            assert_eq!(choose(&device, TracerKind::Auto).unwrap(), auto, "{device:?}");
            assert_eq!(choose(&device, TracerKind::Software).unwrap(), RayTracer::Software);
            let hardware = choose(&device, TracerKind::Hardware);
            match &device.ray_query_lacks {
                None => assert_eq!(hardware.unwrap(), RayTracer::Hardware),
                Some(lacks) => assert!(hardware.unwrap_err().to_string().contains(lacks)),
            }
        }
    }
}
