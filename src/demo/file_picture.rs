//! A picture from a file beside the divider, such as one of another renderer, with the tones of the window.

use std::path::PathBuf;
use std::sync::Arc;
use std::thread::JoinHandle;

use image::RgbaImage;
use image::imageops::{FilterType, resize};

use super::live_metrics::Shot;
use super::loader::in_own_pool;
use crate::metrics::{Encoding, Image, MetricsError};
use crate::output::{Picture, Tones, tone_map};
use crate::settings::Settings;

/// The tones and the size for which a picture is shown.
type ShownFor = (Tones, [u32; 2]);

/// The picture of a file, as the window shows it.
pub(super) struct FilePicture {
    pub path: PathBuf,
    image: Arc<Image>,
    shown_for: ShownFor,
    pub shot: Arc<Shot>,
    /// Counts the pictures that were shown.
    pub version: u64,
    /// The next picture, for other tones or another size, while it is being made.
    next: Option<JoinHandle<(ShownFor, Shot)>>,
}

/// A picture that is being read.
pub(super) type Reading = JoinHandle<Result<FilePicture, MetricsError>>;

impl FilePicture {
    /// Reads a `.png`, `.exr` or `.hdr` in a thread of its own.
    pub fn read(path: PathBuf, settings: &Settings) -> Reading {
        let shown_for = (settings.into(), settings.size);
        in_background(move || {
            let image = Arc::new(Image::read(&path, None)?);
            let shot = Arc::new(shown(&image, shown_for));
            Ok(Self { path, image, shown_for, shot, version: 0, next: None })
        })
    }

    /// Goes on with other settings, once the picture for them is there.
    pub fn follow(&mut self, settings: &Settings) {
        if let Some(next) = self.next.take_if(|next| next.is_finished())
            && let Ok((shown_for, shot)) = next.join()
        {
            (self.shown_for, self.shot, self.version) = (shown_for, Arc::new(shot), self.version + 1);
        }
        let shown_for = (settings.into(), settings.size);
        if self.shown_for != shown_for && self.next.is_none() {
            let image = Arc::clone(&self.image);
            self.next = Some(in_background(move || (shown_for, shown(&image, shown_for))));
        }
    }

    /// Whether it has a value for each pixel of a window of these settings.
    pub fn is_whole(&self, settings: &Settings) -> bool {
        let (_, [width, height]) = self.shown_for;
        settings.size == [width, height] && scaled_width(self.image.size(), [width, height]) >= width
    }

    /// Its size, and what becomes of another one than the window's.
    pub fn described(&self) -> String {
        let ([width, height], (_, shown)) = (self.image.size(), self.shown_for);
        let scaled = scaled_width(self.image.size(), shown);
        let fate = if height != shown[1] as usize { ", scaled to the height" } else { "" };
        let sides = match scaled.cmp(&shown[0]) {
            std::cmp::Ordering::Less => ", too narrow to compare",
            std::cmp::Ordering::Equal => "",
            std::cmp::Ordering::Greater => ", sides cut off",
        };
        format!("{width}x{height}{fate}{sides}")
    }
}

fn in_background<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> JoinHandle<T> {
    std::thread::spawn(|| in_own_pool("picture", work))
}

/// The width of a picture that is scaled to the height of the window; the same camera then sees the same in the middle of both.
fn scaled_width(size: [usize; 2], window: [u32; 2]) -> u32 {
    let scaled = (size[0] as f64 * f64::from(window[1]) / size[1] as f64).round() as u32;
    // A pixel more or less is what sizes in whole pixels make of one aspect.
    if scaled.abs_diff(window[0]) <= 1 { window[0] } else { scaled.max(1) }
}

/// The picture with these tones, scaled to the height, in the middle of a black window.
fn shown(image: &Image, (tones, window): ShownFor) -> Shot {
    let [width, height] = image.size();
    let display = match image.encoding() {
        Encoding::Linear => {
            let mut picture =
                Picture { width, height, colour: image.pixels().to_vec(), ..Picture::default() };
            tone_map(&mut picture, tones, std::iter::repeat(1.0));
            picture.display
        }
        Encoding::Display => {
            let byte = |value: f32| (value * 255.0).round() as u8;
            image.pixels().iter().map(|pixel| pixel.map(byte)).map(|[r, g, b]| [r, g, b, 255]).collect()
        }
    };
    let whole = RgbaImage::from_fn(width as u32, height as u32, |x, y| {
        image::Rgba(display[y as usize * width + x as usize])
    });
    let scaled = resize(&whole, scaled_width(image.size(), window), window[1], FilterType::Triangle);
    let left = (i64::from(window[0]) - i64::from(scaled.width())) / 2;
    let mut shown = RgbaImage::from_pixel(window[0], window[1], image::Rgba([0, 0, 0, 255]));
    image::imageops::replace(&mut shown, &scaled, left, 0);
    Shot { size: window, pixels: shown.pixels().map(|pixel| pixel.0).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A picture of display values that rises to the right in red and downwards in green.
    fn ramp(size: [usize; 2]) -> Image {
        let share = |at: usize, side: usize| (at as f32 + 0.5) / side as f32;
        let pixel = |at: usize| [share(at % size[0], size[0]), share(at / size[0], size[1]), 0.5];
        Image::from_display("ramp", size, (0..size[0] * size[1]).map(pixel).collect()).unwrap()
    }

    #[test]
    fn pictures_are_scaled_to_the_height_in_the_middle() {
        let tones = Tones::from(&Settings::default());
        let at = |shot: &Shot, x: usize, y: usize| shot.pixels[y * shot.size[0] as usize + x];
        for size in [[64, 32], [32, 16], [128, 64], [129, 64]] {
            let shot = shown(&ramp(size), (tones, [64, 32]));
            for (x, y) in [(9, 5), (40, 20), (50, 29)] {
                let [r, g, ..] = at(&shot, x, y).map(f32::from);
                let expected = [x as f32 + 0.5, y as f32 + 0.5].map(|at| at * 255.0);
                assert!(
                    (r - expected[0] / 64.0).abs() < 4.0 && (g - expected[1] / 32.0).abs() < 5.0,
                    "{size:?}"
                );
            }
        }
        let wide = shown(&ramp([256, 32]), (tones, [64, 32]));
        assert!(at(&wide, 0, 0)[0].abs_diff(96) < 3 && at(&wide, 63, 0)[0].abs_diff(159) < 3);
        let narrow = shown(&ramp([16, 16]), (tones, [64, 32]));
        assert!(at(&narrow, 15, 0) == [0, 0, 0, 255] && at(&narrow, 16, 0)[2] == 128);
    }

    #[test]
    fn linear_values_have_the_tones_of_the_window() {
        let grey = Image::from_linear("grey", [8, 8], vec![[0.18; 3]; 64]).unwrap();
        let level = |exposure| {
            let settings = Settings { exposure, ..Settings::default() };
            shown(&grey, (Tones::from(&settings), [8, 8])).pixels[0][0]
        };
        assert!(level(Some(1.0)) > level(Some(0.0)) && level(Some(0.0)) > level(Some(-1.0)));
        // Its median is middle grey.
        assert!(level(None).abs_diff(level(Some(0.0))) < 6);
    }

    #[test]
    fn what_does_not_fit_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        RgbaImage::new(32, 16).save(&path).unwrap();
        let described = |size| {
            let settings = Settings { size, ..Settings::default() };
            let picture = FilePicture::read(path.clone(), &settings).join().unwrap().unwrap();
            (picture.described(), picture.is_whole(&settings))
        };
        assert_eq!(described([32, 16]), ("32x16".to_owned(), true));
        assert_eq!(described([64, 32]), ("32x16, scaled to the height".to_owned(), true));
        assert_eq!(described([60, 32]), ("32x16, scaled to the height, sides cut off".to_owned(), true));
        assert_eq!(described([33, 16]), ("32x16".to_owned(), true));
        assert_eq!(described([40, 16]), ("32x16, too narrow to compare".to_owned(), false));
        std::fs::write(&path, "no picture").unwrap();
        assert!(FilePicture::read(path.clone(), &Settings::default()).join().unwrap().is_err());
    }

    #[test]
    #[cfg(unix)]
    fn a_slow_file_keeps_nobody_waiting() {
        let folder = tempfile::tempdir().unwrap();
        let (pipe, file) = (folder.path().join("pipe.exr"), folder.path().join("a.exr"));
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        image::Rgb32FImage::new(32, 16).save(&file).unwrap();
        // Nobody writes to the pipe yet.
        let reading = FilePicture::read(pipe.clone(), &Settings::default());
        assert!(!reading.is_finished());
        std::fs::write(&pipe, std::fs::read(&file).unwrap()).unwrap();
        let _ = reading.join().unwrap();

        let start = Settings { size: [32, 16], ..Settings::default() };
        let wider = Settings { size: [64, 32], ..Settings::default() };
        let mut picture = FilePicture::read(file, &start).join().unwrap().unwrap();
        let end = std::time::Instant::now() + std::time::Duration::from_secs(60);
        while picture.version == 0 && std::time::Instant::now() < end {
            assert!(picture.shot.size == start.size && !picture.is_whole(&wider));
            picture.follow(&wider);
        }
        assert!(picture.shot.size == wider.size && picture.is_whole(&wider));
    }
}
