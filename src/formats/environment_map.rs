//! Environment maps from files, read row by row: a larger one is shrunk on the way and never in memory as a whole.
//!
//! In: an `.hdr` (Radiance RGBE, rows from the top) or an `.exr`. Out: a map of at most [`MAX_SIZE`] texels, of which each
//! is the mean over its area in the file; and what was changed.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers, Vec2};
use glam::Vec3;

use crate::scene::EnvironmentMap;
use crate::untrusted::{guarded, wrong_format};

/// Largest map.
const MAX_SIZE: [usize; 2] = [8192, 4096];

/// Largest width and height in a file.
const MAX_EXTENT: usize = 65_536;

/// Longest line of an `.hdr`'s header, bytes.
const MAX_LINE: u64 = 4096;

/// A map that was read.
pub(crate) struct MapRead {
    pub map: EnvironmentMap,
    /// What is not as in the file, each completes a sentence about it.
    pub changes: Vec<String>,
}

/// Reads a map; the error completes a sentence about the file.
pub(crate) fn read(file: &Path) -> Result<MapRead, String> {
    let unreadable = |error: std::io::Error| format!("could not be read ({error})");
    let mut reader = BufReader::new(File::open(file).map_err(unreadable)?);
    let start = reader.fill_buf().map_err(unreadable)?;
    if let Some(why) = wrong_format(start) {
        return Err(why.to_owned());
    }
    let shrunk = if start.starts_with(b"#?") {
        read_hdr(&mut reader)
    } else if start.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        guarded(|| read_exr(reader)).and_then(|read| read)
    } else {
        Err("it is neither an .hdr nor an .exr".to_owned())
    };
    shrunk.map_err(|reason| format!("could not be decoded ({reason})"))?.finish()
}

/// A map under construction from the texels of a file.
struct Shrunk {
    from: [usize; 2],
    size: [usize; 2],
    /// For each column and row of the file, those that it falls on here.
    columns: Vec<[Share; 2]>,
    rows: Vec<[Share; 2]>,
    texels: Vec<Vec3>,
    /// Texels of the file that were not finite or negative.
    replaced: usize,
}

impl Shrunk {
    /// For a file of this size.
    fn new(width: usize, height: usize) -> Result<Self, String> {
        if !(2..=MAX_EXTENT).contains(&width) || !(2..=MAX_EXTENT).contains(&height) {
            return Err(format!("it is {width} x {height}, must be 2 x 2 to {MAX_EXTENT} x {MAX_EXTENT}"));
        }
        let size = [width.min(MAX_SIZE[0]), height.min(MAX_SIZE[1])];
        let texels = vec![Vec3::ZERO; size[0] * size[1]];
        let columns = (0..width).map(|x| shares(x, width, size[0])).collect();
        let rows = (0..height).map(|y| shares(y, height, size[1])).collect();
        Ok(Self { from: [width, height], size, columns, rows, texels, replaced: 0 })
    }

    /// Adds the texel at a place in the file.
    fn add(&mut self, x: usize, y: usize, colour: Vec3) {
        if !(colour.is_finite() && colour.min_element() >= 0.0) {
            self.replaced += 1;
            return;
        }
        for (row, part) in self.rows[y] {
            for (column, share) in self.columns[x] {
                if part * share > 0.0 {
                    self.texels[row * self.size[0] + column] += colour * (part * share);
                }
            }
        }
    }

    fn finish(self) -> Result<MapRead, String> {
        let mut changes = Vec::new();
        if self.replaced > 0 {
            changes.push(format!("{} texels are not finite or negative; they are black", self.replaced));
        }
        let ([width, height], [old_width, old_height]) = (self.size, self.from);
        if self.from != self.size {
            changes
                .push(format!("is {old_width} x {old_height}; it was shrunk to {width} x {height} texels"));
        }
        Ok(MapRead { map: EnvironmentMap::new(width, height, self.texels), changes })
    }
}

/// A texel of a smaller row, and the share that one of a larger has in its mean.
type Share = (usize, f32);

/// The texels of a row of `to` texels that texel `i` of `from` falls on: one, or two neighbours.
fn shares(i: usize, from: usize, to: usize) -> [Share; 2] {
    let scale = to as f64 / from as f64;
    let (start, end) = (i as f64 * scale, (i + 1) as f64 * scale);
    let first = (start as usize).min(to - 1);
    let edge = (first + 1) as f64;
    [(first, (end.min(edge) - start) as f32), ((first + 1).min(to - 1), (end - edge).max(0.0) as f32)]
}

fn read_exr(reader: BufReader<File>) -> Result<Shrunk, String> {
    // A texel beyond the size that was refused is dropped.
    let create = |size: Vec2<usize>, _: &_| Shrunk::new(size.x(), size.y());
    let add = |map: &mut Result<Shrunk, String>, at: Vec2<usize>, (r, g, b): (f32, f32, f32)| {
        if let Ok(map) = map {
            map.add(at.x(), at.y(), Vec3::new(r, g, b));
        }
    };
    let read = exr::prelude::read().no_deep_data().largest_resolution_level();
    let read = read.rgb_channels(create, add).first_valid_layer().all_attributes().non_parallel();
    let image = read.from_buffered(reader).map_err(|error| error.to_string())?;
    image.layer_data.channel_data.pixels
}

/// Reads RGBE rows (Ward 1991), which may be run-length encoded in either of two ways.
fn read_hdr(reader: &mut impl BufRead) -> Result<Shrunk, String> {
    let [width, height] = hdr_size(reader)?;
    let mut map = Shrunk::new(width, height)?;
    let mut row = vec![[0u8; 4]; width];
    for y in 0..height {
        read_row(reader, &mut row).map_err(|error| format!("row {y}: {error}"))?;
        let mut last = ([0; 4], Vec3::ZERO);
        for (x, &texel) in row.iter().enumerate() {
            // Rows of equal texels are common.
            if texel != last.0 {
                last = (texel, colour_of(texel));
            }
            map.add(x, y, last.1);
        }
    }
    Ok(map)
}

/// Linear colour of an RGBE texel.
fn colour_of([r, g, b, exponent]: [u8; 4]) -> Vec3 {
    if exponent == 0 {
        return Vec3::ZERO;
    }
    let scale = 2f64.powi(i32::from(exponent) - 136) as f32;
    Vec3::from_array([r, g, b].map(f32::from)) * scale
}

/// Reads the header to its end: the size.
fn hdr_size(reader: &mut impl BufRead) -> Result<[usize; 2], String> {
    let mut next_line = || {
        let mut line = Vec::new();
        let read = reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut line);
        read.map_err(|error| error.to_string())?;
        match line.pop() {
            Some(b'\n') => Ok(String::from_utf8_lossy(&line).trim_end().to_owned()),
            _ => Err("its header has no end".to_owned()),
        }
    };
    loop {
        let line = next_line()?;
        if line.is_empty() {
            break;
        }
        if let Some(format) = line.strip_prefix("FORMAT=")
            && format != "32-bit_rle_rgbe"
        {
            return Err(format!("its format is {format}, must be 32-bit_rle_rgbe"));
        }
    }
    let line = next_line()?;
    let words: Vec<&str> = line.split_whitespace().collect();
    match words[..] {
        ["-Y", height, "+X", width] => match (width.parse(), height.parse()) {
            (Ok(width), Ok(height)) => Ok([width, height]),
            _ => Err(format!("its size is \"{line}\"")),
        },
        _ => Err(format!("its size is \"{line}\", must be -Y height +X width")),
    }
}

/// Widths of which rows may be encoded channel by channel.
const CHANNEL_WIDTHS: std::ops::Range<usize> = 8..32_768;

fn read_row(reader: &mut impl BufRead, row: &mut [[u8; 4]]) -> std::io::Result<()> {
    let broken = || std::io::Error::other("a run leads out of it");
    let width = row.len();
    let mut texel = [0; 4];
    reader.read_exact(&mut texel)?;
    let [a, b, high, low] = texel;
    if CHANNEL_WIDTHS.contains(&width)
        && a == 2
        && b == 2
        && usize::from(high) << 8 | usize::from(low) == width
    {
        for channel in 0..4 {
            let mut x = 0;
            while x < width {
                let count = usize::from(byte(reader)?);
                let is_run = count > 128;
                let end = x + if is_run { count - 128 } else { count };
                if end > width || end == x {
                    return Err(broken());
                }
                let run = if is_run { Some(byte(reader)?) } else { None };
                for texel in &mut row[x..end] {
                    texel[channel] = run.map_or_else(|| byte(reader), Ok)?;
                }
                x = end;
            }
        }
        return Ok(());
    }
    // Plain texels, and runs of the one before: 1, 1, 1, count; of runs in a row each counts 256 times the last.
    let (mut x, mut factor) = (0, 1);
    loop {
        if texel[..3] == [1, 1, 1] {
            let count = usize::from(texel[3]) * factor;
            if x == 0 || count > width - x {
                return Err(broken());
            }
            let before = row[x - 1];
            row[x..x + count].fill(before);
            x += count;
            factor = (factor * 256).min(1 << 24);
        } else {
            row[x] = texel;
            x += 1;
            factor = 1;
        }
        if x == width {
            return Ok(());
        }
        reader.read_exact(&mut texel)?;
    }
}

fn byte(reader: &mut impl BufRead) -> std::io::Result<u8> {
    let mut byte = [0];
    reader.read_exact(&mut byte)?;
    Ok(byte[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shrinking_keeps_the_mean() {
        for (from, to) in [(8, 4), (7, 3), (10, 9), (5, 5), (9, 1)] {
            let mut weights = vec![0.0; to];
            for i in 0..from {
                let own: f32 = shares(i, from, to).iter().map(|share| share.1).sum();
                assert!((own - to as f32 / from as f32).abs() < 1e-6);
                shares(i, from, to).into_iter().for_each(|(place, share)| weights[place] += share);
            }
            assert!(weights.iter().all(|weight| (weight - 1.0).abs() < 1e-6), "{from} {to}: {weights:?}");
        }
    }

    #[test]
    fn rows_are_decoded_however_they_are_encoded() {
        let texels: Vec<[u8; 4]> = (0..10u8).map(|x| [x / 4, 7, x, 128]).collect();
        let flat: Vec<u8> = texels.concat();
        let mut by_channel = vec![2, 2, 0, 10];
        for channel in 0..4 {
            match channel {
                1 => by_channel.extend([128 + 10, 7]),
                3 => by_channel.extend([128 + 3, 128, 128 + 7, 128]),
                _ => {
                    by_channel.push(10);
                    by_channel.extend(texels.iter().map(|texel| texel[channel]));
                }
            }
        }
        for bytes in [&flat, &by_channel] {
            let mut row = vec![[0; 4]; 10];
            read_row(&mut &bytes[..], &mut row).unwrap();
            assert_eq!(row, texels);
        }
        // One texel, then 255 + 2 * 256 times the same.
        let mut row = vec![[0; 4]; 768];
        read_row(&mut &[9, 8, 7, 6, 1, 1, 1, 255, 1, 1, 1, 2][..], &mut row).unwrap();
        assert!(row.iter().all(|texel| *texel == [9, 8, 7, 6]));
        for broken in
            [&[1, 1, 1, 4][..], &[9, 9, 9, 9, 1, 1, 1, 200], &[2, 2, 0, 10, 200, 1], &[2, 2, 0, 10, 0]]
        {
            assert!(read_row(&mut &broken[..], &mut [[0; 4]; 10]).is_err(), "{broken:?}");
        }
    }

    #[test]
    fn texels_have_a_common_exponent() {
        assert_eq!(colour_of([128, 64, 0, 129]), Vec3::new(1.0, 0.5, 0.0));
        assert_eq!(colour_of([255, 1, 1, 0]), Vec3::ZERO);
        assert!(colour_of([255; 4]).is_finite());
    }
}
