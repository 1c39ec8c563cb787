//! Line charts over a common x axis, such as metrics over the frames of a sequence: one panel for each quantity.

use indexmap::IndexSet;
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::{Axis, Layout, Scale};
use super::page::{Drawn, Page, Plot, Sample, chart};
use super::text::FONT;

/// A page of panels over one x axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Title.
    pub title: String,
    /// x axis.
    pub x: Axis,
    /// The panels, in rows.
    pub panels: Vec<Panel>,
    /// Panels in a row.
    pub columns: usize,
    /// Width and height of a panel, pixels.
    pub panel_size: (u32, u32),
}

impl Default for Curves {
    /// Small panels, two a row.
    fn default() -> Self {
        let (title, x, panels) = Default::default();
        Self { title, x, panels, columns: 2, panel_size: (480, 270) }
    }
}

/// The chart of one quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// y axis.
    pub y: Axis,
    /// The curves.
    pub lines: Vec<Line>,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// Name in the legend: lines of one name look the same in all panels. Without a name there is no entry.
    pub name: String,
    /// Points in ascending order of x. A non-finite point makes a gap.
    pub points: Vec<(f64, f64)>,
    /// Style.
    pub look: Look,
}

/// The style of a curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Look {
    /// A line through the points.
    #[default]
    Plain,
    /// With a marker at each point.
    Marked,
    /// With a marker and, for each point, a bar from one value of y to another.
    Intervals(Vec<[f64; 2]>),
    /// With a marker and a text at each point.
    Labelled(Vec<String>),
    /// A dashed grey line.
    Broken,
}

impl Plot for Curves {
    fn page(&self) -> Page<'_> {
        let lines = || self.panels.iter().flat_map(|panel| &panel.lines);
        let entry = |name| {
            let broken = lines().any(|line| line.name == name && line.look == Look::Broken);
            let sample = if broken { Sample::DashedLine } else { Sample::Line };
            (name, self.colour(name, broken), sample)
        };
        Page {
            title: &self.title,
            key: self.names().into_iter().map(entry).collect(),
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
        let points = || panel.lines.iter().flat_map(|line| line.points.iter().copied()).filter(is_finite);
        let has_marks = panel.lines.iter().any(|line| line.look != Look::Plain);
        let x = self.x.layout(points().map(|(x, _)| x), if has_marks { 0.04 } else { 0.0 });
        let y = panel.y.layout(points().map(|(_, y)| y), 0.05);
        let axes = ((x.clone(), self.x.label.as_str()), (y.clone(), panel.y.label.as_str()));
        let mut chart = chart(area, &panel.title, axes.0, axes.1, true)?;
        // Lines of labels alternate above and below their points.
        let mut labelled = 0;
        for line in &panel.lines {
            let broken = line.look == Look::Broken;
            let colour = self.colour(&line.name, broken);
            let places = placed(line, &x, &y);
            for piece in places.split(|point| !is_finite(point)).filter(|piece| !piece.is_empty()) {
                let points = piece.iter().copied();
                if broken {
                    let style = colour.stroke_width(2);
                    chart.draw_series(DashedLineSeries::new(points, 6, 5, style))?;
                    continue;
                }
                chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
                if line.look != Look::Plain {
                    chart.draw_series(points.map(|point| Circle::new(point, 4, colour.filled())))?;
                } else if let &[point] = piece {
                    // A line of one point would be invisible.
                    chart.draw_series([Circle::new(point, 2, colour.filled())])?;
                }
            }
            if let Look::Intervals(intervals) = &line.look {
                let bars = places.iter().zip(intervals).filter(|(point, _)| is_finite(point));
                chart.draw_series(bars.map(|(&(at, _), ends)| {
                    PathElement::new(ends.map(|end| (at, y.place(end))), colour.stroke_width(2))
                }))?;
            }
            if let Look::Labelled(texts) = &line.look {
                let style = (FONT, 11).into_font().color(&colour);
                let shown = places.iter().zip(texts).filter(|(point, _)| is_finite(point));
                let below = labelled % 2 == 1;
                labelled += 1;
                chart.draw_series(shown.map(|(point, text)| {
                    // The text stands on the side with more room.
                    let is_right = point.0 > 0.5 * (x.range().start + x.range().end);
                    let across = if is_right { HPos::Right } else { HPos::Left };
                    let place = (if is_right { -7 } else { 7 }, if below { 4 } else { -13 });
                    let style = style.clone().pos(Pos::new(across, VPos::Top));
                    EmptyElement::at(*point) + Text::new(text.clone(), place, style)
                }))?;
            }
        }
        Ok(())
    }
}

impl Curves {
    /// The names of all lines that have one, each once.
    fn names(&self) -> IndexSet<&str> {
        let lines = self.panels.iter().flat_map(|panel| &panel.lines);
        lines.map(|line| line.name.as_str()).filter(|name| !name.is_empty()).collect()
    }

    fn colour(&self, name: &str, broken: bool) -> RGBColor {
        if broken {
            return RGBColor(130, 130, 130);
        }
        line_colour(self.names().get_index_of(name).unwrap_or(0))
    }
}

fn placed(line: &Line, x: &Layout, y: &Layout) -> Vec<(f64, f64)> {
    line.points.iter().map(|point| (x.place(point.0), y.place(point.1))).collect()
}

fn is_finite((x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}

/// A palette for all types of colour vision (Okabe and Ito 2008).
fn line_colour(index: usize) -> RGBColor {
    const COLOURS: [RGBColor; 7] = [
        RGBColor(0, 114, 178),
        RGBColor(213, 94, 0),
        RGBColor(0, 158, 115),
        RGBColor(204, 121, 167),
        RGBColor(230, 159, 0),
        RGBColor(86, 180, 233),
        RGBColor(60, 60, 60),
    ];
    // Further ones are the same, lighter.
    let RGBColor(r, g, b) = COLOURS[index % COLOURS.len()];
    let lighter = |channel: u8| if index < COLOURS.len() { channel } else { channel / 2 + 110 };
    RGBColor(lighter(r), lighter(g), lighter(b))
}

impl Panel {
    /// A panel with a linear y axis.
    pub fn linear(title: &str, lines: Vec<Line>) -> Self {
        Self { title: title.to_owned(), y: Axis { scale: Scale::Linear, ..Axis::default() }, lines }
    }
}
