//! A heat map: one value a pixel in the magma colour map, with a title and a colour bar.

use image::{Rgb, RgbImage};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::text::{FONT, prepare_font, round_limit, short};
use crate::output::{OutputError, OutputFile};

const MARGIN: usize = 12;
const TITLE_HEIGHT: usize = 34;
const BAR_WIDTH: usize = 20;
/// Sizes of text in pixels.
const TITLE_SIZE: u32 = 20;
const LABEL_SIZE: u32 = 16;
const LABEL_WIDTH: usize = 96;
/// Small pictures are enlarged by an integer factor so that their longer side is close to this.
const TARGET_SIDE: usize = 480;

/// A heat map of a picture's values.
#[derive(Clone, Debug)]
pub struct Heatmap<'a> {
    /// Title.
    pub title: String,
    /// Width and height.
    pub size: [usize; 2],
    /// Width times height values, in rows from the top left.
    pub values: &'a [f32],
    /// The value of the brightest colour; larger values are clamped. Black is 0.
    pub limit: f64,
}

impl Heatmap<'_> {
    /// Draws and writes it as a PNG.
    ///
    /// # Errors
    /// If it cannot be drawn or written.
    pub fn save(&self, file: &OutputFile) -> Result<(), OutputError> {
        let error = |reason| OutputError::Encode(file.path().to_path_buf(), reason);
        let canvas = self.draw().map_err(error)?;
        file.save_png(canvas.dimensions().into(), &canvas)
    }

    fn draw(&self) -> Result<RgbImage, String> {
        let [width, height] = self.size;
        let zoom = (TARGET_SIDE / width.max(height)).max(1);
        let [map_width, map_height] = [width * zoom, height * zoom];
        let [left, top] = [MARGIN, MARGIN + TITLE_HEIGHT];
        let bar_left = left + map_width + MARGIN;
        let bar_height = map_height.max(TARGET_SIDE / 4);
        // Widen the canvas to the title if the picture is narrower.
        let drawn_width = (bar_left + BAR_WIDTH + LABEL_WIDTH).max(2 * MARGIN + title_width(&self.title)?);
        let drawn_height = top + bar_height + MARGIN;
        let mut canvas = RgbImage::from_fn(drawn_width as u32, drawn_height as u32, |x, y| {
            let (x, y) = (x as usize, (y as usize).wrapping_sub(top));
            let (map_x, bar_x) = (x.wrapping_sub(left), x.wrapping_sub(bar_left));
            Rgb(if map_x < map_width && y < map_height {
                self.colour(self.values[y / zoom * width + map_x / zoom].into())
            } else if bar_x < BAR_WIDTH && y < bar_height {
                self.colour(self.limit * (bar_height - 1 - y) as f64 / (bar_height - 1) as f64)
            } else {
                [u8::MAX; 3]
            })
        });
        self.draw_text(&mut canvas, [bar_left + BAR_WIDTH, top], bar_height)
            .map_err(|error| error.to_string())?;
        Ok(canvas)
    }

    fn draw_text(
        &self,
        canvas: &mut RgbImage,
        [bar_right, bar_top]: [usize; 2],
        bar_height: usize,
    ) -> Result<(), DrawingAreaErrorKind<<BitMapBackend<'static> as DrawingBackend>::ErrorType>> {
        prepare_font();
        let size = canvas.dimensions();
        let area = BitMapBackend::with_buffer(canvas, size).into_drawing_area();
        area.draw(&Text::new(self.title.as_str(), (MARGIN as i32, MARGIN as i32), (FONT, TITLE_SIZE)))?;
        let style = (FONT, LABEL_SIZE).into_text_style(&area).pos(Pos::new(HPos::Left, VPos::Center));
        let clipped = self.values.iter().any(|&value| f64::from(value) > self.limit);
        for tick in ticks(self.limit) {
            let share = 1.0 - tick / self.limit;
            let (x, y) =
                (bar_right as i32, bar_top as i32 + (share * (bar_height - 1) as f64).round() as i32);
            let sign = if clipped && tick == self.limit { "≥ " } else { "" };
            area.draw(&PathElement::new([(x, y), (x + 4, y)], BLACK))?;
            area.draw(&Text::new(format!("{sign}{}", short(tick)), (x + 8, y), &style))?;
        }
        area.present()
    }

    fn colour(&self, value: f64) -> [u8; 3] {
        magma(value / self.limit)
    }
}

/// The magma colour map, from 0 to 1.
pub fn magma(share: f64) -> [u8; 3] {
    let colour = colorous::MAGMA.eval_continuous(share.clamp(0.0, 1.0));
    [colour.r, colour.g, colour.b]
}

fn title_width(title: &str) -> Result<usize, String> {
    prepare_font();
    let ((left, _), (right, _)) =
        (FONT, TITLE_SIZE).into_font().layout_box(title).map_err(|error| error.to_string())?;
    Ok(usize::try_from(right - left).unwrap_or(0))
}

/// Round ticks from 0 to `limit`, inclusive.
fn ticks(limit: f64) -> Vec<f64> {
    let step = round_limit(limit / 5.0);
    let below = (0..).map(|i| f64::from(i) * step).take_while(|tick| *tick < limit - 0.5 * step);
    below.chain([limit]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_and_ticks_are_round() {
        for (value, limit) in
            [(0.013, 0.02), (0.2, 0.2), (3.0, 5.0), (7.0, 10.0), (0.0, 1.0), (f64::NAN, 1.0)]
        {
            assert!((round_limit(value) - limit).abs() < 1e-12, "{value}");
        }
        assert_eq!(ticks(1.0).len(), 6);
        assert_eq!(ticks(5.0), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
        assert_eq!(ticks(0.02).last(), Some(&0.02));
    }

    #[test]
    fn values_become_colours_beside_their_scale() {
        let values = [0.0, 0.5, 1.0, 2.0, f32::INFINITY, 0.25];
        let heatmap = Heatmap { title: "Error".to_owned(), size: [3, 2], values: &values, limit: 1.0 };
        let folder = tempfile::tempdir().unwrap();
        let file = OutputFile::new(folder.path().join("a.png")).unwrap();
        heatmap.save(&file).unwrap();
        let picture = image::open(file.path()).unwrap().into_rgb8();
        let zoom = TARGET_SIDE / 3;
        let at = |x: usize, y: usize| {
            picture.get_pixel((MARGIN + x * zoom) as u32, (MARGIN + TITLE_HEIGHT + y * zoom) as u32).0
        };
        let magma = |share: f64| {
            let colour = colorous::MAGMA.eval_continuous(share);
            [colour.r, colour.g, colour.b]
        };
        assert_eq!([at(0, 0), at(1, 0), at(2, 0)], [magma(0.0), magma(0.5), magma(1.0)]);
        assert_eq!([at(0, 1), at(1, 1), at(2, 1)], [magma(1.0), magma(1.0), magma(0.25)]);
        let bar = MARGIN + 3 * zoom + MARGIN;
        let bar_at = |y: usize| picture.get_pixel(bar as u32, y as u32).0;
        assert_eq!(bar_at(MARGIN + TITLE_HEIGHT), magma(1.0));
        assert_eq!(bar_at(MARGIN + TITLE_HEIGHT + 2 * zoom - 1), magma(0.0));
    }

    #[test]
    fn a_single_pixel_has_its_scale_and_title_too() {
        let title = "A title that is wider than all of its picture, which is a single pixel and its scale";
        let heatmap = Heatmap { title: title.to_owned(), size: [1, 1], values: &[0.3], limit: 0.5 };
        let canvas = heatmap.draw().unwrap();
        assert!(canvas.width() as usize >= title_width(title).unwrap() + 2 * MARGIN);
    }
}
