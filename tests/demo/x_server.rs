//! A separate X display with a window manager.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{
    AtomEnum, AutoRepeatMode, ChangeKeyboardControlAux, ChangeWindowAttributesAux, ClientMessageEvent,
    ConnectionExt, EventMask, Window,
};
use x11rb::rust_connection::RustConnection;

use crate::support::skip;

/// Longest wait for anything: a CPU driver with validation is slow.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// The window manager's settings: Alt+F4 closes a window, and no buttons of the mouse are its own. With bindings of its own
/// it would grab each press and hand it on some time later. Windows appear at once: while one is animated, nothing of it is
/// on screen but its title, however many frames it draws.
const MANAGER: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<openbox_config xmlns="http://openbox.org/3.4/rc">
  <focus><focusNew>yes</focusNew><followMouse>no</followMouse></focus>
  <desktops><number>2</number></desktops>
  <theme><name>Clearlooks</name><animateIconify>no</animateIconify></theme>
  <keyboard><keybind key="A-F4"><action name="Close"/></keybind></keyboard>
  <mouse></mouse>
</openbox_config>
"#;

/// Polls `is_so` until it is true.
#[track_caller]
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let end = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < end, "waited in vain: {what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// An X server without a screen, and a window manager on it.
pub struct XServer {
    server: Child,
    manager: Option<Child>,
    display: String,
    _settings: TempDir,
}

impl XServer {
    /// Starts both; skips the test if they are not installed.
    pub fn open() -> Option<Self> {
        let missing = ["Xvfb", "openbox", "xdotool"].into_iter().find(|program| !is_installed(program));
        if let Some(program) = missing {
            skip(&format!("{program} is not installed"));
            return None;
        }
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x900x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let settings = tempfile::tempdir().unwrap();
        let file = settings.path().join("rc.xml");
        std::fs::write(&file, MANAGER).unwrap();
        let mut server = Self { server, manager: None, display, _settings: settings };
        let mut manager = server.command("openbox");
        manager.arg("--config-file").arg(file).stderr(Stdio::null());
        server.manager = Some(manager.spawn().unwrap());
        let connection = server.connect();
        // Disable key repeat: on a busy machine a press lasts long.
        let once = ChangeKeyboardControlAux::new().auto_repeat_mode(AutoRepeatMode::OFF);
        connection.change_keyboard_control(&once).unwrap().check().unwrap();
        wait_for_manager(&connection);
        Some(server)
    }

    /// A connection that hears what windows tell the root window.
    pub fn connect(&self) -> RustConnection {
        let connection = x11rb::connect(Some(&self.display)).unwrap().0;
        let hears = ChangeWindowAttributesAux::new().event_mask(EventMask::SUBSTRUCTURE_NOTIFY);
        connection.change_window_attributes(root(&connection), &hears).unwrap().check().unwrap();
        connection
    }

    /// The display's name.
    pub fn display(&self) -> &str {
        &self.display
    }

    /// A program on this display.
    pub fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").stdin(Stdio::null());
        command
    }
}

impl Drop for XServer {
    fn drop(&mut self) {
        for child in self.manager.iter_mut().chain([&mut self.server]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Waits until the window manager answers a request: one desktop instead of two. It announces itself earlier, and loses
/// windows that are opened in between.
fn wait_for_manager(connection: &RustConnection) {
    const DESKTOPS: &str = "_NET_NUMBER_OF_DESKTOPS";
    let root = root(connection);
    let one = ClientMessageEvent::new(32, root, atom(connection, DESKTOPS), [1, 0, 0, 0, 0]);
    let mask = EventMask::SUBSTRUCTURE_NOTIFY | EventMask::SUBSTRUCTURE_REDIRECT;
    wait_until("the window manager", || {
        connection.send_event(false, root, mask, one).unwrap().check().unwrap();
        property(connection, root, DESKTOPS) == [1]
    });
}

fn is_installed(program: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder: PathBuf| folder.join(program).is_file())
}

pub fn root(connection: &RustConnection) -> Window {
    connection.setup().roots[0].root
}

pub fn atom(connection: &RustConnection, name: &str) -> u32 {
    connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
}

/// The values of a window's property; none if the window or the property does not exist.
pub fn property(connection: &RustConnection, window: Window, name: &str) -> Vec<u32> {
    let name = atom(connection, name);
    let asked = connection.get_property(false, window, name, AtomEnum::ANY, 0, 1024).unwrap();
    // The window may have gone meanwhile.
    let Ok(reply) = asked.reply() else { return Vec::new() };
    reply.value32().map_or_else(Vec::new, Iterator::collect)
}
