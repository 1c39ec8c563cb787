//! Curves over a common axis, such as metrics over the frames of a sequence: one panel for each quantity.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::prelude::*;

use super::{FONT, short};

const PANEL_WIDTH: u32 = 480;
const PANEL_HEIGHT: u32 = 270;
const TITLE_HEIGHT: u32 = 44;
const COLUMNS: usize = 2;

/// A page of panels over one x axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    /// What stands above.
    pub title: String,
    /// What x is.
    pub x_label: String,
    /// The panels, two a row.
    pub panels: Vec<Panel>,
}

/// One quantity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// The quantity, with its unit.
    pub title: String,
    /// The curves.
    pub lines: Vec<Line>,
}

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// What the key calls it; there is a key where a panel has several.
    pub name: String,
    /// Points in the order of x. Where one is not finite there is a gap.
    pub points: Vec<(f64, f64)>,
}

type Drawn<Canvas> = Result<(), DrawingAreaErrorKind<<Canvas as DrawingBackend>::ErrorType>>;

impl Curves {
    /// Width and height in pixels.
    pub(super) fn size(&self) -> (u32, u32) {
        let (columns, rows) = self.grid();
        (columns as u32 * PANEL_WIDTH, TITLE_HEIGHT + rows as u32 * PANEL_HEIGHT)
    }

    fn grid(&self) -> (usize, usize) {
        let panels = self.panels.len().max(1);
        (panels.min(COLUMNS), panels.div_ceil(COLUMNS))
    }

    pub(super) fn draw<Canvas: DrawingBackend>(&self, canvas: &DrawingArea<Canvas, Shift>) -> Drawn<Canvas> {
        canvas.fill(&WHITE)?;
        let page = canvas.margin(8, 0, 0, 0).titled(&self.title, (FONT, 20))?;
        let (columns, rows) = self.grid();
        for (panel, area) in self.panels.iter().zip(page.split_evenly((rows, columns))) {
            self.draw_panel(panel, &area)?;
        }
        Ok(())
    }

    fn draw_panel<Canvas: DrawingBackend>(
        &self,
        panel: &Panel,
        area: &DrawingArea<Canvas, Shift>,
    ) -> Drawn<Canvas> {
        let points = || panel.lines.iter().flat_map(|line| line.points.iter().copied().filter(is_finite));
        let (x_range, y_range) =
            (range(points().map(|(x, _)| x), 0.0), range(points().map(|(_, y)| y), 0.05));
        let mut chart = ChartBuilder::on(area)
            .caption(&panel.title, (FONT, 16))
            .margin(10)
            .x_label_area_size(36)
            .y_label_area_size(64)
            .build_cartesian_2d(x_range, y_range)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(&self.x_label)
            .x_labels(8)
            .y_labels(6)
            .x_label_formatter(&|value| short(*value))
            .y_label_formatter(&|value| short(*value))
            .label_style((FONT, 12))
            .axis_desc_style((FONT, 13))
            .draw()?;
        for (index, line) in panel.lines.iter().enumerate() {
            let colour = line_colour(index);
            let mut key = Some(line.name.as_str());
            for piece in line.points.split(|point| !is_finite(point)).filter(|piece| !piece.is_empty()) {
                if let &[point] = piece {
                    // A line of one point would not be seen.
                    chart.draw_series([Circle::new(point, 2, colour.filled())])?;
                }
                let drawn =
                    chart.draw_series(LineSeries::new(piece.iter().copied(), colour.stroke_width(2)))?;
                if let Some(name) = key.take() {
                    drawn.label(name).legend(move |(x, y)| {
                        PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2))
                    });
                }
            }
        }
        if panel.lines.len() > 1 {
            chart
                .configure_series_labels()
                .label_font((FONT, 12))
                .background_style(WHITE.mix(0.8))
                .border_style(BLACK.mix(0.3))
                .draw()?;
        }
        Ok(())
    }
}

fn is_finite((x, y): &(f64, f64)) -> bool {
    x.is_finite() && y.is_finite()
}

/// From the least to the greatest value and `margin` of that beyond; something to be drawn in any case.
fn range(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let ends = values.fold(None, |ends: Option<(f64, f64)>, value| {
        Some(ends.map_or((value, value), |(least, greatest)| (least.min(value), greatest.max(value))))
    });
    match ends {
        None => 0.0..1.0,
        Some((least, greatest)) if least == greatest => {
            let half = if least == 0.0 { 0.5 } else { 0.05 * least.abs() };
            least - half..least + half
        }
        Some((least, greatest)) => {
            // Differences too small for the labels are not blown up.
            let middle = 0.5 * least + 0.5 * greatest;
            let half = (0.5 * greatest - 0.5 * least) * (1.0 + 2.0 * margin);
            let half = half.max(1.0e-6 * middle.abs());
            middle - half..middle + half
        }
    }
}

/// Colours that also people with impaired colour vision can tell apart (Okabe and Ito 2008).
fn line_colour(index: usize) -> RGBColor {
    const COLOURS: [RGBColor; 6] = [
        RGBColor(0, 114, 178),
        RGBColor(213, 94, 0),
        RGBColor(0, 158, 115),
        RGBColor(204, 121, 167),
        RGBColor(230, 159, 0),
        RGBColor(86, 180, 233),
    ];
    COLOURS[index % COLOURS.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_their_values() {
        assert_eq!(range([].into_iter(), 0.1), 0.0..1.0);
        assert_eq!(range([0.0; 3].into_iter(), 0.1), -0.5..0.5);
        assert_eq!(range([20.0].into_iter(), 0.1), 19.0..21.0);
        assert_eq!(range([3.0, -1.0, 1.0].into_iter(), 0.0), -1.0..3.0);
        assert_eq!(range([0.0, 8.0].into_iter(), 0.25), -2.0..10.0);
    }
}
