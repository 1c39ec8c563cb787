//! A display of its own, a window manager, the program in a window, and real input events.

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;
use x11rb::connection::Connection;
use x11rb::protocol::xproto::{AtomEnum, ConnectionExt, ImageFormat, InputFocus, MapState, Window};
use x11rb::rust_connection::RustConnection;

use crate::drop::drop_file;
use crate::support::skip;

/// Longest wait for anything: a CPU driver with validation is slow.
const PATIENCE: Duration = Duration::from_secs(120);
/// Width of the panel, points; pixels here.
pub const PANEL: u32 = 250;

/// What a person's cache says of devices is none of a test's business, but drivers keep compiled shaders there too.
pub const CACHE: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/cache");

/// An X server without a screen, and a window manager on it.
pub struct Desk {
    server: Child,
    manager: Option<Child>,
    display: String,
}

impl Desk {
    /// Starts both; where they are not installed the test is skipped.
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
        let mut desk = Self { server, manager: None, display };
        desk.manager = Some(desk.command("openbox").stderr(Stdio::null()).spawn().unwrap());
        desk.wait_for_manager();
        Some(desk)
    }

    /// Waits until windows that are opened are the window manager's.
    fn wait_for_manager(&self) {
        let connection = self.connect();
        let root = connection.setup().roots[0].root;
        let name = connection.intern_atom(false, b"_NET_SUPPORTING_WM_CHECK").unwrap().reply().unwrap().atom;
        let says =
            || connection.get_property(false, root, name, AtomEnum::WINDOW, 0, 1).unwrap().reply().unwrap();
        let end = Instant::now() + PATIENCE;
        while says().value_len == 0 {
            assert!(Instant::now() < end, "there is no window manager");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    fn connect(&self) -> RustConnection {
        x11rb::connect(Some(&self.display)).unwrap().0
    }

    fn command(&self, program: &str) -> Command {
        let mut command = Command::new(program);
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").stdin(Stdio::null());
        command
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        for child in self.manager.iter_mut().chain([&mut self.server]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn is_installed(program: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder| folder.join(program).is_file())
}

/// The program in its window.
pub struct Demo<'d> {
    desk: &'d Desk,
    child: Child,
    events: Arc<Mutex<Vec<Value>>>,
    other: Arc<Mutex<String>>,
    pub folder: TempDir,
    window: String,
    connection: RustConnection,
}

/// A picture of the window: width, height, RGB.
#[derive(Clone, PartialEq)]
pub struct Screen {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[u8; 3]>,
}

impl<'d> Demo<'d> {
    /// Starts the program and waits until it shows its scene.
    pub fn start(desk: &'d Desk, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut child = desk
            .command(env!("CARGO_BIN_EXE_glowworm"))
            .args(["demo", "-vv", "--json", "log.json"])
            .args(arguments)
            .current_dir(folder.path())
            .env_remove("RUST_LOG")
            .env("XDG_CACHE_HOME", CACHE)
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (events, other) = (Arc::new(Mutex::new(Vec::new())), Arc::new(Mutex::new(String::new())));
        let stderr = child.stderr.take().unwrap();
        let (to_events, to_other) = (Arc::clone(&events), Arc::clone(&other));
        std::thread::spawn(move || listen(stderr, &to_events, &to_other));
        let connection = desk.connect();
        let mut demo = Self { desk, child, events, other, folder, window: String::new(), connection };
        demo.wait("the scene", |event| event["event"] == "scene");
        demo.window = demo.find_window();
        demo.take_keyboard();
        demo
    }

    /// Waits until the window is seen and has the keyboard. The window manager does both some time after it is asked to, says
    /// so before it has, and forgets what it is asked before it knows the window.
    fn take_keyboard(&self) {
        let window: Window = self.window.parse().unwrap();
        let focus = || self.connection.get_input_focus().unwrap().reply().unwrap().focus;
        let state = || self.connection.get_window_attributes(window).unwrap().reply().unwrap().map_state;
        let end = Instant::now() + PATIENCE;
        while focus() != window || state() != MapState::VIEWABLE {
            assert!(Instant::now() < end, "the window, {:?}, does not get the keyboard", state());
            let ask = ["windowmap", &self.window, "windowactivate", &self.window];
            let _ = self.desk.command("xdotool").args(ask).status();
            std::thread::sleep(Duration::from_millis(50));
            // Fails as long as the window is not seen.
            let asked = self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME);
            let _ = asked.unwrap().check();
        }
    }

    fn find_window(&self) -> String {
        let found = self.desk.command("xdotool").args(["search", "--name", "glowworm"]).output().unwrap();
        let found = String::from_utf8(found.stdout).unwrap();
        found.lines().last().unwrap().to_owned()
    }

    /// What happened so far.
    pub fn events(&self) -> Vec<Value> {
        self.events.lock().unwrap().clone()
    }

    /// How many events there were: waits look at later ones only.
    pub fn now(&self) -> usize {
        self.events.lock().unwrap().len()
    }

    /// Waits for an event, from the first one on.
    pub fn wait(&mut self, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        self.wait_after(0, what, is_it)
    }

    /// Waits for an event after the first `seen`.
    pub fn wait_after(&mut self, seen: usize, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        loop {
            let found = self.events.lock().unwrap().iter().skip(seen).find(|event| is_it(event)).cloned();
            if let Some(event) = found {
                return event;
            }
            let gone = self.child.try_wait().unwrap();
            let said = self.other.lock().unwrap().clone();
            assert!(gone.is_none() && Instant::now() < end, "no {what}; ended: {gone:?}; said: {said}");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// Waits until `count` more frames have been shown.
    pub fn frames(&mut self, count: u64) {
        let shown = || self.events.lock().unwrap().iter().filter(|event| event["event"] == "frame").count();
        let wanted = shown() + count as usize;
        let end = Instant::now() + PATIENCE;
        while shown() < wanted {
            assert!(Instant::now() < end, "frames have stopped");
            std::thread::sleep(Duration::from_millis(20));
        }
    }

    /// The last frame that was shown.
    pub fn last_frame(&self) -> Value {
        self.events.lock().unwrap().iter().rfind(|event| event["event"] == "frame").unwrap().clone()
    }

    pub fn xdotool(&self, arguments: &[&str]) {
        let status = self.desk.command("xdotool").args(arguments).status().unwrap();
        assert!(status.success(), "xdotool {arguments:?}");
    }

    /// Presses a key and waits for the wish that it makes.
    pub fn key_for(&mut self, key: &str, wish: &str) {
        let seen = self.now();
        self.xdotool(&["key", key]);
        self.wait_after(seen, wish, |event| is_action(event, wish));
        self.frames(1);
    }

    pub fn move_to(&self, [x, y]: [i32; 2]) {
        self.xdotool(&["mousemove", "--window", &self.window, &x.to_string(), &y.to_string()]);
    }

    pub fn click(&mut self, at: [i32; 2]) {
        self.move_to(at);
        self.frames(2);
        self.xdotool(&["click", "1"]);
        self.frames(2);
    }

    /// Drags with the left button, in steps, as a hand does.
    pub fn drag(&mut self, from: [i32; 2], to: [i32; 2]) {
        self.move_to(from);
        self.frames(2);
        self.xdotool(&["mousedown", "1"]);
        for step in 1..=8 {
            let at = [0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * step / 8);
            self.move_to(at);
            self.frames(1);
        }
        self.xdotool(&["mouseup", "1"]);
        self.frames(2);
    }

    /// Clicks a thing of the panel by the name under which the log tells its place.
    pub fn click_thing(&mut self, name: &str) {
        let at = self.place(name);
        self.click(at);
    }

    /// Drags the middle of a thing of the panel by so many points to the right.
    pub fn drag_thing(&mut self, name: &str, way: i32) {
        let [x, y] = self.place(name);
        self.drag([x, y], [x + way, y]);
    }

    /// The middle of a thing of the panel.
    fn place(&mut self, name: &str) -> [i32; 2] {
        let end = Instant::now() + PATIENCE;
        // Sections fold and unfold in a short while.
        std::thread::sleep(Duration::from_millis(400));
        self.frames(2);
        loop {
            let layout = self.events().into_iter().rfind(|event| event["event"] == "layout");
            let rect = layout.as_ref().and_then(|layout| layout["details"][name].as_array().cloned());
            if let Some(rect) = rect {
                let side = |i: usize| rect[i].as_f64().unwrap();
                return [(side(0) + side(2)) / 2.0, (side(1) + side(3)) / 2.0].map(|at| at as i32);
            }
            assert!(Instant::now() < end, "{name} is not in the panel: {layout:?}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Drops a file on the window.
    pub fn drop_file(&self, file: &Path) {
        drop_file(&self.desk.display, self.window.parse().unwrap(), file);
    }

    /// Asks the window manager for another size.
    pub fn resize(&self, width: u32, height: u32) {
        self.xdotool(&["windowsize", &self.window, &width.to_string(), &height.to_string()]);
    }

    pub fn minimise(&self) {
        self.xdotool(&["windowminimize", &self.window]);
    }

    pub fn restore(&self) {
        self.xdotool(&["windowmap", &self.window]);
        self.xdotool(&["windowactivate", &self.window]);
    }

    /// What the window shows.
    pub fn screen(&self) -> Screen {
        let window = self.window.parse().unwrap();
        let shape = self.connection.get_geometry(window).unwrap().reply().unwrap();
        let (width, height) = (shape.width, shape.height);
        let image = self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, !0);
        let image = image.unwrap().reply().unwrap();
        let little =
            self.connection.setup().image_byte_order == x11rb::protocol::xproto::ImageOrder::LSB_FIRST;
        let rgb = |pixel: &[u8]| {
            if little { [pixel[2], pixel[1], pixel[0]] } else { [pixel[1], pixel[2], pixel[3]] }
        };
        let pixels = image.data.chunks_exact(4).map(rgb).collect();
        Screen { width: width.into(), height: height.into(), pixels }
    }

    /// Closes the window as a person does and gives the log, after a clean end.
    pub fn close(mut self) -> Value {
        self.take_keyboard();
        self.xdotool(&["key", "alt+F4"]);
        let end = Instant::now() + PATIENCE;
        let status = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status;
            }
            assert!(Instant::now() < end, "it does not close");
            std::thread::sleep(Duration::from_millis(50));
        };
        assert_eq!(status.code(), Some(0), "{}", self.other.lock().unwrap());
        let log: Value = serde_json::from_slice(&std::fs::read(self.path("log.json")).unwrap()).unwrap();
        let closed = log["events"].as_array().unwrap().last().unwrap().clone();
        assert_eq!(closed["event"], "closed");
        assert_eq!(closed["details"]["validation_messages"], 0);
        log
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

impl Drop for Demo<'_> {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Whether an event is a wish of this name.
pub fn is_action(event: &Value, name: &str) -> bool {
    event["event"] == "action" && (event["details"] == name || event["details"].get(name).is_some())
}

fn listen(stderr: impl Read, events: &Mutex<Vec<Value>>, other: &Mutex<String>) {
    for line in BufReader::new(stderr).lines().map_while(Result::ok) {
        let json =
            ["note", "detail"].iter().find_map(|kind| line.strip_prefix(&format!("glowworm: {kind}: ")));
        let event = json.and_then(|json| serde_json::from_str(json).ok());
        match event {
            Some(event) => events.lock().unwrap().push(event),
            None => *other.lock().unwrap() += &format!("{line}\n"),
        }
    }
}

impl Screen {
    /// Left of the panel.
    pub fn picture(&self) -> Screen {
        let width = self.width - PANEL;
        let rows = self.pixels.chunks_exact(self.width as usize);
        let pixels = rows.flat_map(|row| row[..width as usize].iter().copied()).collect();
        Screen { width, height: self.height, pixels }
    }

    /// Mean absolute difference of channels, 0 to 255.
    pub fn difference(&self, other: &Screen) -> f64 {
        assert_eq!((self.width, self.height), (other.width, other.height));
        let channels = |screen: &Screen| screen.pixels.iter().flatten().copied().collect::<Vec<u8>>();
        let (a, b) = (channels(self), channels(other));
        a.iter().zip(&b).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / a.len() as f64
    }

    /// Mean of each channel, 0 to 255.
    pub fn mean(&self) -> [f64; 3] {
        let count = self.pixels.len() as f64;
        [0, 1, 2]
            .map(|channel| self.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / count)
    }

    /// How many different colours there are.
    pub fn colours(&self) -> usize {
        self.pixels.iter().collect::<std::collections::HashSet<_>>().len()
    }

    /// Leaves the picture behind, to be looked at, where `GLOWWORM_PICTURES` names a folder.
    pub fn keep(&self, name: &str) {
        let Some(folder) = std::env::var_os("GLOWWORM_PICTURES") else { return };
        let bytes: Vec<u8> = self.pixels.iter().flatten().copied().collect();
        let path = PathBuf::from(folder).join(format!("{name}.png"));
        image::save_buffer(path, &bytes, self.width, self.height, image::ColorType::Rgb8).unwrap();
    }
}
