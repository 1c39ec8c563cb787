//! Moves of the pointer, clicks and drags in the window, on the picture and on widgets of the panel.

use crate::window::{Demo, is_frame};
use crate::x_server::wait_until;

/// Frames without motion after which the panel counts as stationary: its sections fold and unfold over several frames.
const STATIONARY: usize = 3;

impl Demo<'_> {
    pub fn move_to(&mut self, [x, y]: [i32; 2]) {
        let window = self.window.to_string();
        self.input(&["mousemove", "--window", &window, &x.to_string(), &y.to_string()]);
    }

    pub fn click(&mut self, at: [i32; 2]) {
        self.move_to(at);
        self.input(&["mousedown", "1"]);
        self.input(&["mouseup", "1"]);
    }

    /// Moves the pointer to a pixel of the picture.
    pub fn move_to_picture(&mut self, at: [i32; 2]) {
        let at = self.in_picture(at);
        self.move_to(at);
    }

    /// Clicks a pixel of the picture.
    pub fn click_picture(&mut self, at: [i32; 2]) {
        let at = self.in_picture(at);
        self.click(at);
    }

    /// Drags from one pixel of the picture to another.
    pub fn drag_picture(&mut self, from: [i32; 2], to: [i32; 2]) {
        let [from, to] = [from, to].map(|at| self.in_picture(at));
        self.drag(from, to);
    }

    fn in_picture(&mut self, at: [i32; 2]) -> [i32; 2] {
        let viewport = self.viewport();
        [0, 1].map(|axis| at[axis] + viewport[axis] as i32)
    }

    /// Drags with the left button, in steps, as a hand does.
    pub fn drag(&mut self, from: [i32; 2], to: [i32; 2]) {
        self.move_to(from);
        self.input(&["mousedown", "1"]);
        for step in 1..=8 {
            self.move_to([0, 1].map(|axis| from[axis] + (to[axis] - from[axis]) * step / 8));
        }
        self.input(&["mouseup", "1"]);
    }

    /// Clicks a widget of the panel by its name in the log.
    pub fn click_widget(&mut self, name: &str) {
        let at = self.place(name);
        self.click(at);
    }

    /// Clicks a widget of the panel or over the picture, from another place, all of it between two frames.
    pub fn click_widget_at_once(&mut self, name: &str, from: [i32; 2]) {
        let at = self.place(name);
        self.move_to_picture(from);
        let window = self.window.to_string();
        let [x, y] = at.map(|pixels| pixels.to_string());
        self.input(&["mousemove", "--window", &window, &x, &y, "mousedown", "1", "mouseup", "1"]);
    }

    /// Drags the centre of a widget of the panel to the right, in points.
    pub fn drag_widget(&mut self, name: &str, way: i32) {
        let [x, y] = self.place(name);
        self.drag([x, y], [x + way, y]);
    }

    /// The centre of a widget of the panel, once the layout is stationary. Another scene may move the widgets, but only in
    /// the frames after its event.
    fn place(&mut self, name: &str) -> [i32; 2] {
        let mut rect = None;
        wait_until(name, || {
            let events = self.events();
            let layout = events.iter().rposition(|event| event["event"] == "layout").unwrap();
            let scene = events.iter().rposition(|event| event["event"] == "scene").unwrap_or(0);
            let frames = events[layout.max(scene)..].iter().filter(|event| is_frame(event)).count();
            rect = events[layout]["details"][name].as_array().cloned();
            // The frame of the layout itself counts as well.
            frames > STATIONARY && rect.is_some()
        });
        let side = |i: usize| rect.as_ref().unwrap()[i].as_f64().unwrap();
        [(side(0) + side(2)) / 2.0, (side(1) + side(3)) / 2.0].map(|at| at as i32)
    }
}
