//! A page of panels: title, common legend, panels in rows.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::axis::Layout;
use super::text::{FONT, prepare_font};

pub(super) type Drawn<Canvas> = Result<(), DrawingAreaErrorKind<<Canvas as DrawingBackend>::ErrorType>>;

const TITLE_SIZE: u32 = 20;
const TITLE_HEIGHT: u32 = 40;
const KEY_SIZE: u32 = 13;
const KEY_LINE: u32 = 22;
/// Width of the sample beside a name, and gap between entries, pixels.
const SAMPLE: i32 = 22;
const GAP: i32 = 18;
const MARGIN: i32 = 16;

/// Title, legend and layout of a page.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    pub(super) title: &'a str,
    /// Name, colour and sample of each entry of the legend.
    pub(super) key: Vec<(&'a str, RGBColor, Sample)>,
    pub(super) panels: usize,
    pub(super) columns: usize,
    pub(super) panel_size: (u32, u32),
}

/// The sample beside a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sample {
    Line,
    DashedLine,
    Area,
}

/// A page of panels, independent of the format.
pub trait Plot {
    /// Title, legend and layout.
    fn page(&self) -> Page<'_>;

    /// Draws one panel.
    ///
    /// # Errors
    /// If the canvas fails.
    fn draw_panel<Canvas: DrawingBackend>(
        &self,
        index: usize,
        area: &DrawingArea<Canvas, Shift>,
    ) -> Drawn<Canvas>;

    /// Width and height in pixels.
    fn size(&self) -> (u32, u32) {
        self.page().size()
    }

    /// Draws it on a canvas of that size.
    ///
    /// # Errors
    /// If the canvas fails.
    fn draw<Canvas: DrawingBackend>(&self, canvas: &DrawingArea<Canvas, Shift>) -> Drawn<Canvas> {
        let page = self.page();
        let areas = page.draw(canvas)?;
        areas.iter().take(page.panels).enumerate().try_for_each(|(index, area)| self.draw_panel(index, area))
    }
}

/// A chart with linear or logarithmic axes.
type Chart<'a, Canvas> = ChartContext<'a, Canvas, Cartesian2d<Layout, Layout>>;

/// A chart with its title, on an area: the axes with their labels, and lines at the ticks of y and, if `has_x_lines`, of x.
pub(super) fn chart<'a, Canvas: DrawingBackend>(
    area: &'a DrawingArea<Canvas, Shift>,
    title: &str,
    (x, x_label): (Layout, &str),
    (y, y_label): (Layout, &str),
    has_x_lines: bool,
) -> Result<Chart<'a, Canvas>, DrawingAreaErrorKind<Canvas::ErrorType>> {
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 16))
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(if y_label.is_empty() { 60 } else { 74 })
        .build_cartesian_2d(x, y)?;
    {
        let mut mesh = chart.configure_mesh();
        if !has_x_lines {
            mesh.disable_x_mesh();
        }
        mesh.light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.12))
            .x_desc(x_label)
            .y_desc(y_label)
            .label_style((FONT, 12))
            .axis_desc_style((FONT, 13))
            .draw()?;
    }
    Ok(chart)
}

impl Page<'_> {
    fn columns(&self) -> usize {
        self.panels.clamp(1, self.columns.max(1))
    }

    fn rows(&self) -> usize {
        self.panels.max(1).div_ceil(self.columns())
    }

    fn width(&self) -> u32 {
        self.columns() as u32 * self.panel_size.0
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.width(), self.head() + self.rows() as u32 * self.panel_size.1)
    }

    /// Height of title and legend.
    fn head(&self) -> u32 {
        let lines = self.places().last().map_or(0, |(_, line)| line + 1);
        TITLE_HEIGHT + lines as u32 * KEY_LINE
    }

    /// Position of each legend entry: x in pixels, and the line.
    fn places(&self) -> Vec<(i32, usize)> {
        let (mut x, mut line) = (MARGIN, 0);
        let mut places = Vec::new();
        for (name, ..) in &self.key {
            let width = SAMPLE + text_width(name) + GAP;
            if x + width > self.width() as i32 && x > MARGIN {
                (x, line) = (MARGIN, line + 1);
            }
            places.push((x, line));
            x += width;
        }
        places
    }

    /// Draws title and legend; returns the areas of the panels.
    pub fn draw<Canvas: DrawingBackend>(
        &self,
        canvas: &DrawingArea<Canvas, Shift>,
    ) -> Result<Vec<DrawingArea<Canvas, Shift>>, DrawingAreaErrorKind<Canvas::ErrorType>> {
        canvas.fill(&WHITE)?;
        let title = (FONT, TITLE_SIZE).into_text_style(canvas).pos(Pos::new(HPos::Center, VPos::Top));
        canvas.draw(&Text::new(self.title, (self.width() as i32 / 2, 10), title))?;
        let label = (FONT, KEY_SIZE).into_text_style(canvas).pos(Pos::new(HPos::Left, VPos::Center));
        for ((name, colour, sample), (x, line)) in self.key.iter().zip(self.places()) {
            let y = (TITLE_HEIGHT + line as u32 * KEY_LINE + KEY_LINE / 2) as i32;
            let stroke = |from: i32, to: i32| {
                canvas.draw(&PathElement::new([(x + from, y), (x + to, y)], colour.stroke_width(3)))
            };
            match sample {
                Sample::Line => stroke(0, SAMPLE - 6)?,
                Sample::DashedLine => [(0, 6), (10, 16)].into_iter().try_for_each(|(a, b)| stroke(a, b))?,
                Sample::Area => {
                    canvas.draw(&Rectangle::new([(x + 2, y - 6), (x + 14, y + 6)], colour.filled()))?;
                }
            }
            canvas.draw(&Text::new(*name, (x + SAMPLE, y), label.clone()))?;
        }
        let (_, panels) = canvas.split_vertically(self.head());
        Ok(panels.split_evenly((self.rows(), self.columns())))
    }
}

fn text_width(text: &str) -> i32 {
    prepare_font();
    let measured = (FONT, KEY_SIZE).into_font().layout_box(text);
    measured.map_or(0, |((left, _), (right, _))| right - left)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_legend_wraps() {
        let page = |names: usize| Page {
            title: "",
            key: vec![("indirect_reprojection", BLACK, Sample::Area); names],
            panels: 3,
            columns: 2,
            panel_size: (300, 100),
        };
        assert_eq!(page(0).size(), (600, TITLE_HEIGHT + 200));
        assert_eq!(page(2).size(), (600, TITLE_HEIGHT + KEY_LINE + 200));
        let many = page(11);
        assert!(many.size().1 > page(2).size().1);
        let right = |(x, _): (i32, usize)| x + SAMPLE + text_width("indirect_reprojection");
        assert!(many.places().into_iter().all(|place| right(place) <= 600));
    }
}
