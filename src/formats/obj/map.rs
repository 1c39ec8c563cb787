//! Maps of an MTL: a file name with options before or behind it.
//!
//! In: the arguments of a statement. Out: a [`Map`], or what is wrong with it.

use glam::{Mat2, Vec2};

use super::reader::without_comment;
use crate::scene::{TextureUse, Wrap};

/// Largest multiplier of a bump map.
const MOST_BUMP: f32 = 1e4;

/// An image file with how it is laid on the surface.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Map {
    pub file: String,
    /// Texture coordinates are multiplied by this (`-s`), then this is added (`-o`).
    pub scale: Vec2,
    pub offset: Vec2,
    /// Whether it ends at its border (`-clamp`).
    pub clamp: bool,
    /// Multiplies heights (`-bm`).
    pub multiplier: f32,
}

impl Map {
    /// Reads the arguments of a statement.
    pub fn read(keyword: &str, rest: &str) -> Result<Self, String> {
        let (options, file) = options_of(rest);
        if file.is_empty() {
            return Err(format!("{keyword} names no file; ignored"));
        }
        let (scale, offset) = (Vec2::ONE, Vec2::ZERO);
        let mut map = Self { file: file.to_owned(), scale, offset, clamp: false, multiplier: 1.0 };
        for (option, arguments) in options {
            let number =
                |place: usize, default: f32| arguments.get(place).map_or(Ok(default), |word| word.parse());
            let pair = |default: f32| {
                let pair = Vec2::new(number(0, default).ok()?, number(1, default).ok()?);
                pair.is_finite().then_some(pair)
            };
            let unusable = |range: &str| {
                format!("{keyword} {option} {} is not of finite numbers{range}; ignored", arguments.join(" "))
            };
            match option {
                "-s" => map.scale = pair(1.0).ok_or_else(|| unusable(""))?,
                "-o" => map.offset = pair(0.0).ok_or_else(|| unusable(""))?,
                "-clamp" => map.clamp = arguments.first() == Some(&"on"),
                "-bm" => {
                    let usable = number(0, 1.0).ok().filter(|number| number.abs() <= MOST_BUMP);
                    map.multiplier =
                        usable.ok_or_else(|| unusable(&format!(" from -{MOST_BUMP} to {MOST_BUMP}")))?;
                }
                _ => {}
            }
        }
        Ok(map)
    }

    /// The use of `texture`, whose coordinates v count from the top of the image, while those of an OBJ count from the bottom.
    pub fn of(&self, texture: usize) -> TextureUse {
        TextureUse {
            matrix: Mat2::from_diagonal(self.scale),
            offset: Vec2::new(self.offset.x, 1.0 - self.scale.y - self.offset.y),
            wrap: if self.clamp { [Wrap::Clamp; 2] } else { Wrap::REPEAT },
            ..texture.into()
        }
    }
}

/// The options of a statement that change the picture and are not read.
pub(super) fn not_shown(keyword: &str, rest: &str) -> impl Iterator<Item = &'static str> {
    let is_colour = matches!(keyword, "map_kd" | "map_ke");
    options_of(rest).0.into_iter().filter_map(move |(option, arguments)| {
        Some(match option {
            "-t" => "-t (turbulence of a map)",
            "-mm" => "-mm (range of a map)",
            "-imfchan" => "-imfchan (channel of a map)",
            "-colorspace"
                if arguments.iter().all(|space| space.eq_ignore_ascii_case("srgb")) != is_colour =>
            {
                "-colorspace (colour space of a map)"
            }
            _ => return None,
        })
    })
}

/// An option of a map with its arguments.
type MapOption<'a> = (&'a str, Vec<&'a str>);

/// The options such as `-clamp on` or `-s 1 1 1` before or behind a file name, and that name, which may contain spaces.
fn options_of(rest: &str) -> (Vec<MapOption<'_>>, &str) {
    let (mut options, file) = options_before(rest);
    let bare = without_comment(file);
    for (end, _) in bare.match_indices(" -") {
        let (behind, more) = options_before(&bare[end + 1..]);
        if more.is_empty() {
            options.extend(behind);
            return (options, bare[..end].trim_end());
        }
    }
    (options, file)
}

/// The options that a text begins with, and what is behind them.
fn options_before(mut rest: &str) -> (Vec<MapOption<'_>>, &str) {
    let mut options = Vec::new();
    while rest.starts_with('-') {
        let (option, tail) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        // Number of arguments: fixed, or up to three numbers.
        let (fixed, numbers) = match option {
            "-o" | "-s" | "-t" => (0, 3),
            "-mm" => (2, 0),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-texres" | "-bm" | "-boost" | "-imfchan"
            | "-type" | "-colorspace" => (1, 0),
            _ => break,
        };
        rest = tail.trim_start();
        let mut arguments = Vec::new();
        for i in 0..fixed.max(numbers) {
            let (word, tail) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            if i >= fixed && word.parse::<f32>().is_err() {
                break;
            }
            arguments.push(word);
            rest = tail.trim_start();
        }
        options.push((option, arguments));
    }
    (options, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_options_are_read() {
        for (given, expected) in [
            ("a.png", "a.png"),
            ("-clamp on my file.png", "my file.png"),
            ("-s 1 2 3 -o 0.5 b.png", "b.png"),
            ("-bm 0.2 -mm 0 1 c d.png", "c d.png"),
            ("-clamp", ""),
            ("-unknown e.png", "-unknown e.png"),
            ("f.png -bm 1.5", "f.png"),
            ("-clamp on g h.png -s 2 2 -colorspace linear # a comment", "g h.png"),
            ("i -bm.png", "i -bm.png"),
            ("j -s 2 k.png", "j -s 2 k.png"),
        ] {
            assert_eq!(options_of(given).1, expected);
        }
        let read = |rest| Map::read("map_kd", rest);
        let map = read("-s 2 -clamp on -o 0.5 0.25 7 -mm 0 1 b.png").unwrap();
        assert_eq!((map.scale, map.offset), (Vec2::new(2.0, 1.0), Vec2::new(0.5, 0.25)));
        assert!(map.clamp && map.file == "b.png" && read("-o nan a.png").is_err());
        // What lies at v from the bottom lies at 1 - v from the top.
        let place = map.of(0).coordinates([Vec2::new(0.25, 1.0 - 0.5); 2]);
        assert_eq!(place, Vec2::new(1.0, 1.0 - 0.75));
        for (given, expected) in [
            ("a.png", 1.0),
            ("-bm 0.2 c d.png", 0.2),
            ("-clamp on -bm -3 -mm 0 1 e-bm 7.png", -3.0),
            ("f.png -bm 1.5", 1.5),
        ] {
            assert_eq!(read(given).unwrap().multiplier, expected, "{given}");
        }
        assert!(read("-bm nan a.png").is_err() && read("-bm 1e9 a.png").is_err());
        for (keyword, given, told) in
            [("map_kd", "sRGB", 0), ("map_kd", "linear", 1), ("bump", "linear", 0), ("norm", "srgb", 1)]
        {
            assert_eq!(not_shown(keyword, &format!("-colorspace {given} a.png")).count(), told, "{given}");
        }
    }
}
