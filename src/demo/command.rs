//! The command line that renders the current picture.

use std::path::PathBuf;

use super::action::Action;
use super::app::Open;
use super::screenshot::free_name;
use super::stage::Stage;

impl Open {
    /// The command line that renders the current scene. If the scene was edited or the camera moved, it is first
    /// saved to a new file.
    pub(super) fn command(&mut self) -> Option<String> {
        let stage = self.stage.as_ref()?;
        let camera_moved = self.flight.has_moved();
        let stem = format!("glowworm-{}", stage.rest.name);
        let mut scene = stage.name.clone();
        if stage.edited || stage.headlamp.is_some() || camera_moved {
            let path: PathBuf = free_name(&stem, "toml").ok()?;
            scene = path.to_string_lossy().into_owned();
            self.actions.push(Action::Save(path));
        }
        // Render enough frames to reach the current animation time, and at least one per temporal set.
        let step = stage.settings.time_step;
        let passed = if step > 0.0 { (self.clock.time / step).round() as u64 + 1 } else { 1 };
        let frames = passed.clamp(u64::from(stage.settings.vpl.temporal_sets), 100_000);
        Some(command_line(stage, &scene, frames))
    }
}

fn command_line(stage: &Stage, scene: &str, frames: u64) -> String {
    let options: String = stage
        .settings
        .differing_options()
        .into_iter()
        .map(|(option, value)| format!(" --{option}={value}"))
        .collect();
    let out = quoted(&format!("{}.png", stage.rest.name));
    format!("glowworm render {} --frames {frames}{options} --out {out}", quoted(scene))
}

/// Quotes a word for the shell.
fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./".contains(c);
    if text.chars().all(plain) { text.to_owned() } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stay_words() {
        assert_eq!(quoted("scenes/a-b_1.toml"), "scenes/a-b_1.toml");
        assert_eq!(quoted("my scene's.toml"), "'my scene'\\''s.toml'");
    }
}
