//! The command line that renders the current picture.

use std::path::PathBuf;

use super::clock::Clock;
use super::saving::free_name;
use super::session::Session;
use super::view::View;

/// The command line that renders the current scene. If the scene was edited or the camera moved, it is first to be saved to a new file,
/// which comes second.
pub(super) fn command(view: &View) -> Option<(String, Option<PathBuf>)> {
    let session = view.session.as_ref()?;
    let saved =
        session.saved.as_ref().filter(|saved| !session.is_edited() && saved.camera == session.pose.camera);
    let scene = saved.map_or(session.name.clone(), |saved| saved.path.to_string_lossy().into_owned());
    let differs = saved.is_none() && (session.is_edited() || view.flight.moved.is_some());
    if session.headlamp.is_none() && !differs {
        return Some((command_line(session, &scene, &view.clock), None));
    }
    let path = free_name(&format!("glowworm-{}", session.live_scene.name), ".toml").ok()?;
    Some((command_line(session, &path.to_string_lossy(), &view.clock), Some(path)))
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
