//! The machine that was measured, and its memory use.

use serde::{Deserialize, Serialize};
use sysinfo::{CpuRefreshKind, MemoryRefreshKind, RefreshKind, System};

use crate::report::COMMIT;
use crate::vulkan::DeviceInfo;

/// The machine and the program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Machine {
    /// Name of the Vulkan device.
    pub device: String,
    /// discrete, integrated, virtual, cpu or other.
    pub device_kind: String,
    /// Name and version of its driver.
    pub driver: String,
    /// Vulkan version.
    pub vulkan: String,
    /// Model of the CPU.
    pub cpu: String,
    /// Threads of the program's pool.
    pub cpu_threads: usize,
    /// Bytes of main memory.
    pub memory: u64,
    /// Operating system.
    pub os: String,
    /// Version of glowworm.
    pub version: String,
    /// Commit, or unknown.
    pub commit: String,
}

impl Machine {
    /// This machine with the device `info`.
    pub fn new(info: &DeviceInfo) -> Self {
        let wanted = RefreshKind::nothing()
            .with_cpu(CpuRefreshKind::nothing())
            .with_memory(MemoryRefreshKind::nothing().with_ram());
        let system = System::new_with_specifics(wanted);
        let unknown = || "unknown".to_owned();
        let cpu = system.cpus().first().map(|cpu| cpu.brand().trim().to_owned());
        let kernel =
            System::kernel_version().map(|version| format!(", kernel {version}")).unwrap_or_default();
        Self {
            device: info.name.clone(),
            device_kind: info.kind.clone(),
            driver: info.driver.clone(),
            vulkan: info.vulkan.clone(),
            cpu: cpu.filter(|brand| !brand.is_empty()).unwrap_or_else(unknown),
            cpu_threads: rayon::current_num_threads(),
            memory: system.total_memory(),
            os: System::long_os_version().unwrap_or_else(unknown) + &kernel,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: COMMIT.to_owned(),
        }
    }

    /// Labels and values to print.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let device = format!("{} ({}, Vulkan {})", self.device, self.device_kind, self.vulkan);
        vec![
            ("Device", device),
            ("Driver", self.driver.clone()),
            ("CPU", format!("{}, {} threads", self.cpu, self.cpu_threads)),
            ("Memory", format!("{:.1} GiB", self.memory as f64 / f64::from(1 << 30))),
            ("System", self.os.clone()),
            ("glowworm", format!("{}, commit {}", self.version, self.commit)),
        ]
    }

    /// The difference to `other` that makes times incomparable, if any.
    pub fn difference(&self, other: &Self) -> Option<&'static str> {
        let differing = [
            ("device", self.device != other.device),
            ("driver", self.driver != other.driver),
            ("CPU", (&self.cpu, self.cpu_threads) != (&other.cpu, other.cpu_threads)),
        ];
        differing.into_iter().find(|(_, differs)| *differs).map(|(what, _)| what)
    }
}

/// Peak resident memory of the program since [`restart_cpu_peak`], or since its start if that cannot be reset,
/// bytes; none if the system does not report it.
pub fn cpu_peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// Resets [`cpu_peak`]; false if the system does not allow that.
pub fn restart_cpu_peak() -> bool {
    std::fs::write("/proc/self/clear_refs", "5").is_ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn the_peak_falls_when_it_is_restarted() {
        let memory = std::hint::black_box(vec![1u8; 200 << 20]);
        let high = cpu_peak().unwrap();
        drop(memory);
        assert!(high >= 200 << 20);
        if restart_cpu_peak() {
            let low = cpu_peak().unwrap();
            assert!(low + (100 << 20) < high, "{low} {high}");
        }
    }
}
