//! Environment maps from files, read row by row: a larger one is shrunk on the way and never in memory as a whole.
//!
//! In: an `.hdr` (Radiance RGBE, rows from the top) or an `.exr`. Out: a map of at most [`MAX_SIZE`] texels, of which each
//! is the mean over its area in the file; and what was changed.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use glam::Vec3;

use super::exr_images;
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
        guarded(|| read_exr(reader.into_inner())).and_then(|read| read)
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
        check_extent([width, height], 2)?;
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

fn check_extent([width, height]: [usize; 2], least: usize) -> Result<(), String> {
    if (least..=MAX_EXTENT).contains(&width) && (least..=MAX_EXTENT).contains(&height) {
        return Ok(());
    }
    Err(format!("it is {width} x {height}, must be {least} x {least} to {MAX_EXTENT} x {MAX_EXTENT}"))
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

fn read_exr(mut file: File) -> Result<Shrunk, String> {
    let rewind = |file: &mut File| file.rewind().map_err(|error| error.to_string());
    rewind(&mut file)?;
    let layout = exr_images::Layout::read(BufReader::new(&file))?;
    rewind(&mut file)?;
    let [width, height] = layout.size;
    check_extent(layout.data_size, 1)?;
    // Texels of a size that is refused are dropped.
    let create = move || Shrunk::new(width, height);
    let add = |map: &mut Result<Shrunk, String>, [x, y]: [usize; 2], [r, g, b, _]: [f32; 4]| {
        if let Ok(map) = map {
            map.add(x, y, Vec3::new(r, g, b));
        }
    };
    layout.texels(BufReader::new(file), create, add)?
}

/// Reads RGBE rows (Ward 1991), which may be run-length encoded in either of two ways.
fn read_hdr(reader: &mut impl BufRead) -> Result<Shrunk, String> {
    let ([width, height], multiplier) = hdr_header(reader)?;
    let mut map = Shrunk::new(width, height)?;
    let mut row = vec![[0u8; 4]; width];
    for y in 0..height {
        read_row(reader, &mut row).map_err(|error| format!("row {y}: {error}"))?;
        let mut last = ([0; 4], Vec3::ZERO);
        for (x, &texel) in row.iter().enumerate() {
            // Rows of equal texels are common.
            if texel != last.0 {
                last = (texel, colour_of(texel) / multiplier);
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

/// Reads the header to its end: the size, and what radiance has been multiplied by (EXPOSURE and COLORCORR).
fn hdr_header(reader: &mut impl BufRead) -> Result<([usize; 2], Vec3), String> {
    let mut next_line = || {
        let mut line = Vec::new();
        let read = reader.by_ref().take(MAX_LINE).read_until(b'\n', &mut line);
        read.map_err(|error| error.to_string())?;
        match line.pop() {
            Some(b'\n') => Ok(String::from_utf8_lossy(&line).trim_end().to_owned()),
            _ => Err("its header has no end".to_owned()),
        }
    };
    let mut multiplier = Vec3::ONE;
    loop {
        let line = next_line()?;
        if line.is_empty() {
            break;
        }
        let Some((key, value)) = line.split_once('=') else { continue };
        let numbers: Vec<f32> = value.split_whitespace().map_while(|word| word.parse().ok()).collect();
        // Several lines of a key all count.
        multiplier *= match (key, &numbers[..]) {
            ("FORMAT", _) if value.trim() != "32-bit_rle_rgbe" => {
                return Err(format!("its format is {value}, must be 32-bit_rle_rgbe"));
            }
            ("EXPOSURE", &[factor]) => Vec3::splat(factor),
            ("COLORCORR", &[r, g, b]) => Vec3::new(r, g, b),
            ("EXPOSURE" | "COLORCORR", _) => Vec3::ZERO,
            _ => Vec3::ONE,
        };
        if !(multiplier.is_finite() && multiplier.min_element() > 0.0) {
            return Err(format!("its header says {line}, which must be positive numbers"));
        }
    }
    let line = next_line()?;
    let words: Vec<&str> = line.split_whitespace().collect();
    match words[..] {
        ["-Y", height, "+X", width] => match (width.parse(), height.parse()) {
            (Ok(width), Ok(height)) => Ok(([width, height], multiplier)),
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
    fn what_a_header_multiplied_by_is_divided_out() {
        let header = |lines: &str| hdr_header(&mut format!("#?RADIANCE\n{lines}\n-Y 2 +X 3\n").as_bytes());
        for (lines, expected) in [
            ("", Vec3::ONE),
            ("FORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n", Vec3::splat(2.0)),
            ("EXPOSURE= 4.0e0\n# a comment\nEXPOSURE=.5\n", Vec3::splat(2.0)),
            ("EXPOSURE=2\nCOLORCORR=1 2 0.5\n", Vec3::new(2.0, 4.0, 1.0)),
            ("\tEXPOSURE=7\n", Vec3::ONE),
        ] {
            assert_eq!(header(lines), Ok(([3, 2], expected)), "{lines}");
        }
        for lines in
            ["EXPOSURE=0\n", "EXPOSURE=-1\n", "EXPOSURE=x\n", "COLORCORR=1 2\n", "FORMAT=32-bit_rle_xyze\n"]
        {
            assert!(header(lines).is_err(), "{lines}");
        }
    }

    #[test]
    fn texels_have_a_common_exponent() {
        assert_eq!(colour_of([128, 64, 0, 129]), Vec3::new(1.0, 0.5, 0.0));
        assert_eq!(colour_of([255, 1, 1, 0]), Vec3::ZERO);
        assert!(colour_of([255; 4]).is_finite());
    }
}
