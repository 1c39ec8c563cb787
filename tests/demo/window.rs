//! The program in a window, and real input events.
//!
//! No fixed waits. Input has been handled once the program answers a ping that was sent after it; the next frame of the
//! log is then the first that shows it. A frame of the log is on screen once all images of the swapchain have been
//! presented after it.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;
use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    ClientMessageEvent, ConnectionExt, EventMask, ImageFormat, ImageOrder, MapState, Window,
};
use x11rb::rust_connection::RustConnection;

use crate::drop::drop_file;
use crate::log::Log;
use crate::screen::Screen;
use crate::x_server::{XServer, atom, property, root, wait_until};

/// Tests do not use the user's cache of devices, but drivers keep compiled shaders there too.
pub const CACHE: &str = concat!(env!("CARGO_TARGET_TMPDIR"), "/cache");

/// The file in the cache that tells that the first lines were read.
pub const WELCOMED: &str = "welcomed";
/// Frames after which one is on screen: Mesa's swapchains have at most five images here, and one more frame sees to it that
/// the server has drawn what it was sent.
const ON_SCREEN: u64 = 6;
/// Frames after which light no longer changes, and what stands still is frozen.
const SETTLED: u64 = 24;
/// Time in which 4 stops of automatic exposure shrink to less than its last step, .02 stops: seven time constants.
const ADAPTED: Duration = Duration::from_millis(1100);
/// Pings of this program count up from here; the window manager's own are small numbers.
const FIRST_PING: u32 = 0x4000_0000;

/// The program in its window.
pub struct Demo<'d> {
    server: &'d XServer,
    child: Child,
    log: Log,
    pub folder: TempDir,
    pub window: Window,
    connection: RustConnection,
    pings: u32,
}

impl<'d> Demo<'d> {
    /// Starts the program and waits until it shows its scene.
    pub fn start(server: &'d XServer, arguments: &[&str]) -> Self {
        Self::start_losing(server, "", arguments)
    }

    /// The same, with devices that are lost at some submissions.
    pub fn start_losing(server: &'d XServer, losses: &str, arguments: &[&str]) -> Self {
        // The first lines were read before.
        let cache = Path::new(CACHE).join("glowworm");
        std::fs::create_dir_all(&cache).unwrap();
        std::fs::write(cache.join(WELCOMED), "").unwrap();
        Self::start_with(server, losses, arguments)
    }

    /// The same, whether the first lines were read or not.
    pub fn start_as_it_is(server: &'d XServer, arguments: &[&str]) -> Self {
        Self::start_with(server, "", arguments)
    }

    fn start_with(server: &'d XServer, losses: &str, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let said = folder.path().join("stderr.txt");
        let child = server
            .command(env!("CARGO_BIN_EXE_glowworm"))
            // Pictures that stand still are to freeze soon.
            .args(["demo", "-vv", "--json", "log.json", "--still-frames", "8"])
            .args(arguments)
            .current_dir(folder.path())
            .env_remove("RUST_LOG")
            .env("XDG_CACHE_HOME", CACHE)
            .env("GLOWWORM_LOSE_DEVICE", losses)
            .stderr(File::create(&said).unwrap())
            .spawn()
            .unwrap();
        let (log, connection) = (Log::open(&said), server.connect());
        let mut demo = Self { server, child, log, folder, window: 0, connection, pings: FIRST_PING };
        demo.wait("the scene", |event| event["event"] == "scene");
        demo.window = demo.find_window();
        demo.take_keyboard();
        demo
    }

    /// The window, once the window manager knows it.
    fn find_window(&mut self) -> Window {
        let (connection, process) = (&self.connection, self.child.id());
        let is_ours = |window: &Window| property(connection, *window, "_NET_WM_PID") == [process];
        let mut found = None;
        wait_until("the window manager knows the window", || {
            found = property(connection, root(connection), "_NET_CLIENT_LIST").into_iter().find(is_ours);
            found.is_some()
        });
        found.unwrap()
    }

    /// Shows and focuses the window, and waits for both.
    fn take_keyboard(&mut self) {
        let name = self.window.to_string();
        self.xdotool(&["windowmap", &name, "windowactivate", &name]);
        let (connection, window) = (&self.connection, self.window);
        let has_focus = || connection.get_input_focus().unwrap().reply().unwrap().focus == window;
        // The window manager sets it last.
        let is_active = || property(connection, root(connection), "_NET_ACTIVE_WINDOW") == [window];
        wait_until("the window has the keyboard", || {
            is_seen(connection, window) && has_focus() && is_active()
        });
        self.handle_input();
    }

    /// Waits until the program has handled all input that was sent so far: events reach it in order, and it answers a ping.
    fn handle_input(&mut self) {
        self.pings += 1;
        let (connection, ping) = (&self.connection, atom(&self.connection, "_NET_WM_PING"));
        let data = [ping, self.pings, self.window, 0, 0];
        let event = ClientMessageEvent::new(32, self.window, atom(connection, "WM_PROTOCOLS"), data);
        connection.send_event(false, self.window, EventMask::NO_EVENT, event).unwrap();
        connection.flush().unwrap();
        let is_answer = |event: Option<Event>| matches!(event, Some(Event::ClientMessage(message)) if message.data.as_data32() == data);
        let child = &mut self.child;
        wait_until("the program answers", || {
            assert!(has_ended(child).is_none(), "the program has ended");
            loop {
                match connection.poll_for_event().unwrap() {
                    None => return false,
                    event if is_answer(event.clone()) => return true,
                    _ => {}
                }
            }
        });
    }

    /// What happened so far.
    pub fn events(&mut self) -> &[Value] {
        self.log.events()
    }

    /// Number of events so far: waits consider later ones only.
    pub fn now(&mut self) -> usize {
        self.events().len()
    }

    /// Waits for an event, from the first one on.
    pub fn wait(&mut self, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        self.wait_after(0, what, is_it)
    }

    /// Waits for an event after the first `seen`.
    pub fn wait_after(&mut self, seen: usize, what: &str, is_it: impl Fn(&Value) -> bool) -> Value {
        let mut found = None;
        wait_until(what, || {
            let ended = has_ended(&mut self.child);
            found = self.log.events().iter().skip(seen).find(|event| is_it(event)).cloned();
            assert!(
                found.is_some() || ended.is_none(),
                "no {what}; ended: {ended:?}; said: {}",
                self.log.other()
            );
            found.is_some()
        });
        found.unwrap()
    }

    /// Waits until `count` more frames have been shown.
    pub fn frames(&mut self, count: u64) {
        let shown = |events: &[Value]| events.iter().filter(|event| is_frame(event)).count() as u64;
        let wanted = shown(self.events()) + count;
        wait_until("more frames", || {
            assert!(
                has_ended(&mut self.child).is_none(),
                "the program has ended; said: {}",
                self.log.other()
            );
            shown(self.log.events()) >= wanted
        });
    }

    /// Waits until the picture of a stationary scene is stationary: each temporal set in frames, then the exposure in time.
    pub fn settle(&mut self) {
        self.frames(SETTLED);
        std::thread::sleep(ADAPTED);
    }

    /// The last frame that was shown.
    pub fn last_frame(&mut self) -> Value {
        self.events().iter().rfind(|event| is_frame(event)).unwrap().clone()
    }

    fn xdotool(&self, arguments: &[&str]) {
        let status = self.server.command("xdotool").args(arguments).status().unwrap();
        assert!(status.success(), "xdotool {arguments:?}");
    }

    /// Sends input and waits for the first frame that shows it.
    pub fn input(&mut self, arguments: &[&str]) {
        self.xdotool(arguments);
        self.handle_input();
        self.frames(1);
    }

    /// Presses a key and waits for its action.
    pub fn key_for(&mut self, key: &str, action: &str) {
        let seen = self.now();
        self.input(&["key", key]);
        self.wait_after(seen, action, |event| is_action(event, action));
    }

    /// The window's title.
    pub fn title(&self) -> String {
        let window = self.window.to_string();
        let output = self.server.command("xdotool").args(["getwindowname", &window]).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    }

    /// Whether the panel shows a widget.
    pub fn shows(&mut self, name: &str) -> bool {
        let layout = self.events().iter().rfind(|event| event["event"] == "layout").unwrap();
        layout["details"].get(name).is_some()
    }

    /// Where the picture is in the window: left, top, right, bottom.
    pub fn viewport(&mut self) -> [u32; 4] {
        let layout = self.events().iter().rfind(|event| event["event"] == "layout").unwrap();
        [0, 1, 2, 3].map(|side| layout["details"]["picture"][side].as_f64().unwrap() as u32)
    }

    /// Drops a file on the window.
    pub fn drop_file(&self, file: &Path) {
        drop_file(self.server.display(), self.window, file);
    }

    /// Asks the window manager for another size.
    pub fn resize(&self, width: u32, height: u32) {
        self.xdotool(&["windowsize", &self.window.to_string(), &width.to_string(), &height.to_string()]);
    }

    /// Hides the window and waits until the program knows.
    pub fn minimise(&mut self) {
        let seen = self.now();
        self.xdotool(&["windowminimize", &self.window.to_string()]);
        self.wait_after(seen, "hiding", |event| event["event"] == "hidden");
    }

    /// Shows the hidden window again and waits until it is seen.
    pub fn restore(&mut self) {
        let seen = self.now();
        self.take_keyboard();
        self.wait_after(seen, "coming back", |event| event["event"] == "seen");
    }

    /// Runs the program's loop this many times: each ping wakes it.
    pub fn turns(&mut self, count: u32) {
        (0..count).for_each(|_| self.handle_input());
    }

    /// A screenshot of the window: the last frame or a later one.
    pub fn screen(&mut self) -> Screen {
        self.frames(ON_SCREEN);
        let viewport = self.viewport();
        let (connection, window) = (&self.connection, self.window);
        // The window is not moved, resized or hidden between the two requests.
        connection.grab_server().unwrap();
        let shape = connection.get_geometry(window).unwrap().reply().unwrap();
        let (width, height) = (shape.width, shape.height);
        let image = connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, !0);
        let image = image.unwrap().reply();
        connection.ungrab_server().unwrap();
        connection.flush().unwrap();
        let little = connection.setup().image_byte_order == ImageOrder::LSB_FIRST;
        let rgb = |pixel: &[u8]| {
            if little { [pixel[2], pixel[1], pixel[0]] } else { [pixel[1], pixel[2], pixel[3]] }
        };
        let pixels = image.unwrap().data.chunks_exact(4).map(rgb).collect();
        Screen { width: width.into(), height: height.into(), pixels, viewport }
    }

    /// Closes the window, whose scene has unsaved edits: it asks, and the same again discards them.
    pub fn discard_and_close(mut self) -> Value {
        self.take_keyboard();
        let seen = self.now();
        self.xdotool(&["key", "alt+F4"]);
        let asked = self.wait_after(seen, "question", |event| event["event"] == "unsaved");
        assert_eq!(asked["details"], "quit");
        self.close()
    }

    /// Closes the window like a user and returns the log, after a clean exit.
    pub fn close(mut self) -> Value {
        self.take_keyboard();
        self.xdotool(&["key", "alt+F4"]);
        let mut ended = None;
        wait_until("it closes", || {
            ended = has_ended(&mut self.child);
            ended.is_some()
        });
        self.events();
        assert_eq!(ended.unwrap().code(), Some(0), "{}", self.log.other());
        let log: Value = serde_json::from_slice(&std::fs::read(self.path("log.json")).unwrap()).unwrap();
        let closed = log["events"].as_array().unwrap().last().unwrap().clone();
        assert_eq!(closed["event"], "closed");
        assert_eq!(closed["details"]["validation_messages"], 0);
        log
    }

    /// Waits until it ends by itself: the exit code, and what it said besides events.
    pub fn end(mut self) -> (Option<i32>, String) {
        let mut ended = None;
        wait_until("it ends", || {
            ended = has_ended(&mut self.child);
            ended.is_some()
        });
        self.events();
        (ended.unwrap().code(), self.log.other().to_owned())
    }

    /// Runs the program with `arguments`, which write the picture `out`: the same as on `screen`, pixel by pixel.
    pub fn assert_renders_to(&self, arguments: &[&str], out: &str, screen: &Screen) {
        let output = Command::new(env!("CARGO_BIN_EXE_glowworm"))
            .args(arguments)
            .current_dir(self.folder.path())
            .env("XDG_CACHE_HOME", CACHE)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let rendered = image::open(self.path(out)).unwrap().to_rgb8();
        assert_eq!(rendered.dimensions(), (screen.width, screen.height));
        let same = rendered.pixels().zip(&screen.pixels).filter(|(a, b)| a.0 == **b).count();
        assert_eq!(same, screen.pixels.len(), "{arguments:?}: pixels that are the same, of all");
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

/// Whether an event is an action of this name.
pub fn is_action(event: &Value, name: &str) -> bool {
    event["event"] == "action" && (event["details"] == name || event["details"].get(name).is_some())
}

pub fn is_frame(event: &Value) -> bool {
    event["event"] == "frame"
}

/// Whether the window is on screen, so that its pixels can be read.
fn is_seen(connection: &RustConnection, window: Window) -> bool {
    let attributes = connection.get_window_attributes(window).unwrap().reply().unwrap();
    attributes.map_state == MapState::VIEWABLE
}

fn has_ended(child: &mut Child) -> Option<ExitStatus> {
    child.try_wait().unwrap()
}
