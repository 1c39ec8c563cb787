//! The state that the panel reads, and where it stands in the window.

use std::path::Path;

use egui::{Rect, pos2};

use crate::demo::compare::Comparison;
use crate::demo::gpu::Gpu;
use crate::demo::history::History;
use crate::demo::loader::Loader;
use crate::demo::session::Session;
use crate::demo::view::View;

/// Width of the panel, points.
pub(super) const WIDTH: f32 = 250.0;
/// Width of all that the bar holds, points.
const BAR: f32 = 1275.0;
/// Height of a row of the bar and of its margins, points.
const ROW: f32 = 22.0;
const MARGINS: f32 = 4.0;

/// Input of the panel.
pub(in crate::demo) struct Shown<'a> {
    pub view: &'a View,
    pub comparison: Option<&'a Comparison>,
    /// The caption of the tour.
    pub caption: Option<String>,
    pub assets: Option<&'a Path>,
    pub history: &'a History,
    pub loader: &'a Loader,
    pub gpu: &'a Gpu,
}

impl Shown<'_> {
    pub fn session(&self) -> Option<&Session> {
        self.view.session.as_ref()
    }

    /// The picture's part of the window, points.
    pub fn picture_area(&self, context: &egui::Context) -> Rect {
        picture_area(context, self.view.interface.hidden)
    }
}

/// Height of the bar in a window of this width, points: whatever it shows, so that the picture keeps its size.
pub(super) fn bar_height(width: f32) -> f32 {
    MARGINS + ROW * (BAR / width.max(1.0)).ceil().clamp(1.0, 3.0)
}

/// The part of the window that panel and bar leave to the picture, unless they are hidden, points.
pub(in crate::demo) fn picture_area(context: &egui::Context, hidden: bool) -> Rect {
    let window = context.content_rect();
    if hidden {
        return window;
    }
    let (right, top) = (window.right() - WIDTH, window.top() + bar_height(window.width()));
    let corner = pos2(window.left(), top.min(window.bottom() - 1.0));
    Rect::from_min_max(corner, pos2(right.max(window.left() + 1.0), window.bottom()))
}

/// Size of a window that has room for a picture of this size and the panel, pixels.
pub(in crate::demo) fn window_around(picture: [u32; 2], scale: f32) -> [u32; 2] {
    let width = picture[0] as f32 / scale + WIDTH;
    let height = picture[1] as f32 / scale + bar_height(width);
    [width, height].map(|points| (points * scale).round() as u32)
}
