//! Runs of the program, for tests of what a person meets.

#![allow(clippy::unwrap_used, dead_code, reason = "a test that cannot go on has failed; no test uses all")]

use std::fs;
use std::process::{Command, Output, Stdio};

use tempfile::TempDir;

/// The cache of all runs, where drivers keep compiled shaders: tests leave a person's alone.
pub const CACHE: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/cache");

/// A run of the program in a folder of its own.
pub struct Run {
    pub folder: TempDir,
    environment: Vec<(&'static str, String)>,
}

impl Run {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap(), environment: Vec::new() }
    }

    pub fn with(mut self, variable: &'static str, value: impl Into<String>) -> Self {
        self.environment.push((variable, value.into()));
        self
    }

    pub fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    pub fn glowworm(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_glowworm"))
            .args(arguments)
            .current_dir(self.folder.path())
            .env("XDG_CACHE_HOME", CACHE)
            .env_remove("RUST_LOG")
            .env_remove("RUST_BACKTRACE")
            .envs(self.environment.iter().map(|(variable, value)| (variable, value)))
            .stdin(Stdio::null())
            .output()
            .unwrap()
    }

    /// Renders a small picture; of an option given twice, the later one counts.
    pub fn render(&self, scene: &str, arguments: &[&str]) -> Output {
        let small = ["--size", "16x8", "--frames", "1", "--vpls", "16", "--out", "a.png"];
        self.glowworm(&[&["render", scene], &small[..], arguments].concat())
    }

    pub fn files(&self) -> Vec<String> {
        let mut names: Vec<_> = fs::read_dir(self.folder.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Asserts that the run failed with `code` and said, besides notes and warnings, one line,
/// an error, with every one of `says`.
#[track_caller]
pub fn assert_fails(output: &Output, code: i32, says: &[&str]) {
    let message = stderr(output);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
    let is_remark =
        |line: &&str| ["note", "warning"].iter().any(|kind| line.starts_with(&format!("glowworm: {kind}: ")));
    let errors: Vec<_> = message.lines().filter(|line| !is_remark(line)).collect();
    assert_eq!(errors.len(), 1, "{message}");
    assert!(errors[0].starts_with("glowworm: error: "), "{message}");
    assert!(!message.contains("panicked") && !message.contains("internal error"), "{message}");
    for part in says {
        assert!(message.contains(part), "{part:?} is not in {message:?}");
    }
}

/// The passes and stages of `--indirect vpls`, in the order of the frame.
pub const PASS_NAMES: [&str; 43] = [
    "bvh_update",
    "vpl_invalidation",
    "vpl_replacement",
    "gbuffer",
    "reprojection",
    "soft_shadows_trace",
    "soft_shadows_svgf_temporal",
    "soft_shadows_svgf_variance",
    "soft_shadows_svgf_atrous",
    "direct_shadows",
    "direct_shading",
    "thin_surfaces",
    "indirect_shadows",
    "cluster_visibility",
    "vpl_sampling",
    "bias_compensation",
    "indirect_shading",
    "discontinuity_filter",
    "indirect_reprojection",
    "set_reprojection",
    "irradiance_upsampling",
    "hit_light",
    "indirect_spatial_filter",
    "indirect_svgf_temporal",
    "indirect_svgf_variance",
    "indirect_svgf_atrous",
    "indirect_bmfr_accumulate",
    "indirect_bmfr_fit",
    "indirect_bmfr_filtered",
    "environment_prefilter",
    "reflections_trace",
    "reflections_svgf_temporal",
    "reflections_svgf_variance",
    "reflections_svgf_atrous",
    "combine",
    "radiance",
    "exposure",
    "tone_map",
    "taa",
    "still",
    "still_mean",
    "still_spatial_filter",
    "still_fade",
];
