//! Which tracer a renderer uses: the one that was asked for, or the faster one.
//!
//! Speeds are measured once for each device, driver and version of the tracers' shaders: once in a process and, where
//! [`remember_in`] names a folder, once for all. A file there that cannot be read or written changes nothing but
//! that.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use serde::{Deserialize, Serialize};

use super::{RenderError, TracerRates};
use crate::output::OutputFile;
use crate::passes::tracer::RayTracer;
use crate::settings::TracerKind;
use crate::vulkan::{Device, DeviceInfo, shaders};

/// The tracer in use.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TracerChoice {
    /// The tracer.
    pub used: RayTracer,
    /// What was measured, if that decided.
    pub rays_per_second: Option<TracerRates>,
}

impl TracerChoice {
    /// Finds the tracer for a device.
    ///
    /// # Errors
    /// Where the hardware tracer was asked for and the device cannot do with it.
    pub fn new(device: &Arc<Device>, wanted: TracerKind) -> Result<Self, RenderError> {
        let chosen = |used| Self { used, rays_per_second: None };
        match (wanted, &device.info().ray_query_lacks) {
            (TracerKind::Software, _) | (TracerKind::Auto, Some(_)) => Ok(chosen(RayTracer::Software)),
            (TracerKind::Hardware, None) => Ok(chosen(RayTracer::Hardware)),
            (TracerKind::Hardware, Some(lacks)) => Err(RenderError::NoHardwareTracer {
                device: device.info().name.clone(),
                lacks: lacks.clone(),
            }),
            (TracerKind::Auto, None) => Ok(Self::faster(device)),
        }
    }

    fn faster(device: &Arc<Device>) -> Self {
        match rates(device) {
            Some(rates) => Self { used: rates.faster(), rays_per_second: Some(rates) },
            None => Self { used: RayTracer::Software, rays_per_second: None },
        }
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

/// What is known, or else what is measured now; none where the device cannot be measured.
fn rates(device: &Arc<Device>) -> Option<TracerRates> {
    static KNOWN: Mutex<Known> = Mutex::new(Known::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    let key = key(device.info());
    let file = FOLDER.get().map(|folder| Cache { folder: folder.clone() });
    let kept = known.get(&key).copied().or_else(|| file.as_ref()?.read().get(&key).copied());
    let rates = match kept {
        Some(rates) => rates,
        None => {
            let measured = TracerRates::measure(device)
                .inspect_err(|error| log::warn!("the tracers could not be measured: {error}"))
                .ok()?;
            if let Some(file) = &file {
                file.add(&key, measured);
            }
            measured
        }
    };
    if known.insert(key, rates).is_none() {
        let TracerRates { software, hardware } = rates;
        let from = if kept.is_some() { "kept from earlier" } else { "measured" };
        log::info!(
            "tracers on {}: software {:.2}, hardware {:.2} million rays a second ({from}), so auto is {:?}",
            device.info().name,
            software * 1e-6,
            hardware * 1e-6,
            rates.faster()
        );
    }
    Some(rates)
}

/// What rates depend on: device, driver, and the shaders that were measured.
fn key(info: &DeviceInfo) -> String {
    let shader = shaders::OCCLUSION_RAYS_COMP;
    // FNV-1a.
    let hash = shader.software.iter().chain(shader.hardware).fold(0xcbf2_9ce4_8422_2325u64, |hash, byte| {
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
