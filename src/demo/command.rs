//! The command line that renders the current picture.

use std::path::PathBuf;

use super::action::Action;
use super::app::Open;
use super::clock::Clock;
use super::screenshot::free_name;
use super::session::Session;

impl Open {
    /// The command line that renders the current scene. If the scene was edited or the camera moved, it is first
    /// saved to a new file.
    pub(super) fn command(&mut self) -> Option<String> {
        let session = self.session.as_ref()?;
        let camera_moved = self.flight.has_moved();
        let stem = format!("glowworm-{}", session.live_scene.name);
        let saved = session.saved.as_ref().filter(|saved| saved.is_current(session));
        let mut scene = saved.map_or(session.name.clone(), |saved| saved.path.to_string_lossy().into_owned());
        if session.headlamp.is_some() || saved.is_none() && (session.is_edited() || camera_moved) {
            let path: PathBuf = free_name(&stem, ".toml").ok()?;
            scene = path.to_string_lossy().into_owned();
            self.actions.push(Action::Save(path));
        }
        Some(command_line(session, &scene, &self.clock))
    }
}

/// Renders as many frames as a picture takes to come to rest; all of them at one time if the animation is paused.
fn command_line(session: &Session, scene: &str, clock: &Clock) -> String {
    let mut settings = session.settings.clone();
    if clock.paused {
        settings.time_step = 0.0;
    }
    let (frames, time) = (settings.still_frames.max(settings.vpl.temporal_sets), clock.time);
    let options: String = settings
        .differing_options()
        .into_iter()
        .map(|(option, value)| format!(" --{option}={value}"))
        .collect();
    let out = quoted(&format!("{}.png", session.live_scene.name));
    format!("glowworm render {} --frames {frames} --time {time}{options} --out {out}", quoted(scene))
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
