//! Screenshots of the window.

use std::path::PathBuf;

/// Height of the line that names a debug view, at the lower edge of the picture.
pub const LEGEND: u32 = 26;

/// A picture of the window: width, height, RGB.
#[derive(Clone, PartialEq)]
pub struct Screen {
    pub width: u32,
    pub height: u32,
    pub pixels: Vec<[u8; 3]>,
    /// Where the scene is shown: left, top, right, bottom.
    pub viewport: [u32; 4],
}

impl Screen {
    /// The scene, above the legend.
    pub fn picture(&self) -> Screen {
        let [left, top, right, bottom] = self.viewport;
        self.crop([left, top, right, bottom - LEGEND])
    }

    /// All of the scene.
    pub fn whole_picture(&self) -> Screen {
        self.crop(self.viewport)
    }

    fn crop(&self, [left, top, right, bottom]: [u32; 4]) -> Screen {
        let rows = self.pixels.chunks_exact(self.width as usize).take(bottom as usize).skip(top as usize);
        let pixels = rows.flat_map(|row| row[left as usize..right as usize].iter().copied()).collect();
        let (width, height) = (right - left, bottom - top);
        Screen { width, height, pixels, viewport: [0, 0, width, height] }
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

    /// Number of distinct colours.
    pub fn colours(&self) -> usize {
        self.pixels.iter().collect::<std::collections::HashSet<_>>().len()
    }

    /// Saves the picture for inspection in the folder `GLOWWORM_PICTURES`, if set.
    pub fn keep(&self, name: &str) {
        let Some(folder) = std::env::var_os("GLOWWORM_PICTURES") else { return };
        let bytes: Vec<u8> = self.pixels.iter().flatten().copied().collect();
        let path = PathBuf::from(folder).join(format!("{name}.png"));
        image::save_buffer(path, &bytes, self.width, self.height, image::ColorType::Rgb8).unwrap();
    }
}
