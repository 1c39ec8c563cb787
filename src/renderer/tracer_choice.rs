//! Which tracer a renderer uses: the one that was asked for, or the faster one.
//!
//! Speeds are measured once for each device, driver and version of the tracers' shaders: once in a process and, where
//! [`remember_in`] names a folder, once for all. A file there that cannot be read or written changes nothing but
//! that.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use serde::{Deserialize, Serialize};

use super::{RenderError, tracer_speed};
use crate::output::OutputFile;
use crate::gpu_scene::tracer::RayTracer;
use crate::report::{TracerChoice, TracerRates};
use crate::settings::TracerKind;
use crate::vulkan::{Device, DeviceInfo, shaders};

/// Finds the tracer for a device.
///
/// # Errors
/// Where the hardware tracer was asked for and the device cannot do with it.
pub(super) fn choose(device: &Arc<Device>, wanted: TracerKind) -> Result<TracerChoice, RenderError> {
    let chosen = |used| TracerChoice { used, rays_per_second: None };
    match (wanted, &device.info().ray_query_lacks) {
        (TracerKind::Software, _) | (TracerKind::Auto, Some(_)) => Ok(chosen(RayTracer::Software)),
        (TracerKind::Hardware, None) => Ok(chosen(RayTracer::Hardware)),
        (TracerKind::Hardware, Some(lacks)) => {
            Err(RenderError::NoHardwareTracer { device: device.info().name.clone(), lacks: lacks.clone() })
        }
        (TracerKind::Auto, None) => Ok(match tracer_rates(device) {
            Some(rates) => TracerChoice { used: rates.faster(), rays_per_second: Some(rates) },
            None => chosen(RayTracer::Software),
        }),
    }
}

static FOLDER: OnceLock<PathBuf> = OnceLock::new();

/// Keeps what is measured from now on in `folder`, which need not exist, and uses what was kept there. The first
/// folder counts.
pub fn remember_in(folder: PathBuf) {
    let _ = FOLDER.set(folder);
}

/// Rates by [`key`].
type Known = BTreeMap<String, TracerRates>;

/// How fast the device's tracers are, as known or else as measured now; none where it offers only one or cannot be
/// measured.
pub fn tracer_rates(device: &Arc<Device>) -> Option<TracerRates> {
    if !device.info().ray_query {
        return None;
    }
    static KNOWN: Mutex<Known> = Mutex::new(Known::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let key = key(device.info());
    let file = FOLDER.get().map(|folder| Cache { folder: folder.clone() });
    let kept = known.get(&key).copied().or_else(|| file.as_ref()?.read().get(&key).copied());
    let rates = match kept {
        Some(rates) => rates,
        None => {
            let measured = tracer_speed::measure(device)
                .inspect_err(|error| log::warn!("the tracers could not be measured: {error}"))
                .ok()?;
            if let Some(file) = &file {
                file.add(&key, measured);
            }
            measured
        }
    };
    if known.insert(key, rates).is_none() {
        let from = if kept.is_some() { "kept from earlier" } else { "measured" };
        log::info!("tracers of {}, {from}: {rates}", device.info().name);
    }
    Some(rates)
}

/// What rates depend on: device, driver, and the shaders that were measured.
fn key(info: &DeviceInfo) -> String {
    let shader = shaders::CAST_RAYS_COMP;
    // FNV-1a.
    let hash =
        shader.software.iter().chain(shader.hardware).fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
            (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3)
        });
    format!("{}, {}, Vulkan {}, shaders {hash:016x}", info.name, info.driver, info.vulkan)
}

/// `tracers.json` in a folder for what can be made again.
struct Cache {
    folder: PathBuf,
}

/// What the file holds.
#[derive(Default, Serialize, Deserialize)]
struct Content {
    /// Rays a second.
    tracers: Known,
}

impl Cache {
    fn path(&self) -> PathBuf {
        self.folder.join("tracers.json")
    }

    /// What is there; nothing where it cannot be read or makes no sense.
    fn read(&self) -> Known {
        let text = std::fs::read_to_string(self.path()).unwrap_or_default();
        let content: Content = serde_json::from_str(&text).unwrap_or_default();
        let sensible = |rate: f64| rate.is_finite() && rate >= 0.0;
        let rates = content.tracers.into_iter();
        rates.filter(|(_, rates)| sensible(rates.hardware) && rates.software > 0.0).collect()
    }

    fn add(&self, key: &str, rates: TracerRates) {
        let mut tracers = self.read();
        tracers.insert(key.to_owned(), rates);
        let written = std::fs::create_dir_all(&self.folder)
            .map_err(|error| error.to_string())
            .and_then(|()| OutputFile::new(self.path()).map_err(|error| error.to_string()))
            .and_then(|file| file.save_json(&Content { tracers }).map_err(|error| error.to_string()));
        if let Err(error) = written {
            log::info!("what was measured of the tracers is not kept: {error}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATES: TracerRates = TracerRates { software: 3.5e6, hardware: 0.25e6 };

    #[test]
    fn rates_are_kept_beside_one_another() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache { folder: folder.path().join("a/b") };
        assert!(cache.read().is_empty());
        cache.add("one", RATES);
        cache.add("two", TracerRates { hardware: 0.0, ..RATES });
        let kept = cache.read();
        assert_eq!(kept["one"], RATES);
        assert_eq!(kept.len(), 2);
    }

    #[test]
    fn a_broken_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache { folder: folder.path().to_owned() };
        for text in [
            "",
            "{",
            "[]",
            "\u{0}",
            r#"{"tracers": {"one": 3}}"#,
            r#"{"tracers": {"one": {"software": -1.0, "hardware": 1.0}}}"#,
        ] {
            std::fs::write(cache.path(), text).unwrap();
            assert!(cache.read().is_empty(), "{text}");
            cache.add("one", RATES);
            assert_eq!(cache.read()["one"], RATES, "{text}");
        }
    }

    #[test]
    fn what_cannot_be_written_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let blocked = folder.path().join("file");
        std::fs::write(&blocked, "").unwrap();
        let cache = Cache { folder: blocked };
        cache.add("one", RATES);
        assert!(cache.read().is_empty());
    }
}
