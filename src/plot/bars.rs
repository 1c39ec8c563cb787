//! Stacked bar charts, such as the passes of a frame: one panel for each group of bars.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::{Axis, Scale};
use super::page::{Drawn, Page, Plot, Sample, chart};
use super::text::FONT;

/// Width of a bar, relative to their distance.
const BAR_WIDTH: f64 = 0.68;

/// A page of panels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bars {
    /// Title.
    pub title: String,
    /// Names and colours of the stacked parts, from the bottom.
    pub parts: Vec<(String, [u8; 3])>,
    /// The panels, in rows.
    pub panels: Vec<BarPanel>,
    /// Panels in a row.
    pub columns: usize,
    /// Width and height of a panel, pixels.
    pub panel_size: (u32, u32),
}

/// Some bars over one axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BarPanel {
    /// Title.
    pub title: String,
    /// Label of the x axis.
    pub x_label: String,
    /// The quantity, with its unit.
    pub y_label: String,
    /// The bars, from the left.
    pub bars: Vec<Bar>,
}

/// One bar.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bar {
    /// Label below the bar.
    pub label: String,
    /// Text above the bar.
    pub total: String,
    /// Length of each part, at least 0.
    pub parts: Vec<f64>,
}

impl Plot for Bars {
    fn page(&self) -> Page<'_> {
        Page {
            title: &self.title,
            key: self
                .parts
                .iter()
                .map(|(name, colour)| (name.as_str(), rgb(*colour), Sample::Area))
                .collect(),
            panels: self.panels.len(),
            columns: self.columns,
            panel_size: self.panel_size,
        }
    }

    fn draw_panel<Canvas: DrawingBackend>(
        &self,
        index: usize,
        area: &DrawingArea<Canvas, Shift>,
    ) -> Drawn<Canvas> {
        let panel = &self.panels[index];
        let x = Axis::side_by_side(panel.bars.iter().map(|bar| bar.label.as_str()));
        let y = Axis { scale: Scale::FromZero, ..Axis::default() };
        let y = y.layout(panel.bars.iter().map(|bar| bar.parts.iter().sum()).chain([0.0]), 0.05);
        let axes = ((x, panel.x_label.as_str()), (y, panel.y_label.as_str()));
        let mut chart = chart(area, &panel.title, axes.0, axes.1, false)?;
        let total = (FONT, 12).into_font().into_text_style(area).pos(Pos::new(HPos::Center, VPos::Bottom));
        for (index, bar) in panel.bars.iter().enumerate() {
            let (left, right) = (index as f64 - BAR_WIDTH / 2.0, index as f64 + BAR_WIDTH / 2.0);
            let mut below = 0.0;
            for (part, (_, colour)) in bar.parts.iter().zip(&self.parts) {
                let above = below + part.max(0.0);
                let corners = [(left, below), (right, above)];
                chart.draw_series([Rectangle::new(corners, rgb(*colour).filled())])?;
                below = above;
            }
            let text = Text::new(bar.total.clone(), (0, -3), total.clone());
            chart.draw_series([EmptyElement::at((index as f64, below)) + text])?;
        }
        Ok(())
    }
}

fn rgb([r, g, b]: [u8; 3]) -> RGBColor {
    RGBColor(r, g, b)
}
