//! Material libraries.
//!
//! In: the `mtllib` argument of an OBJ. Out: its materials, with finite numbers in range. Problems are warnings, never errors:
//! a picture without a map is better than none.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::{Mat2, Vec2, Vec3};
use unicode_normalization::UnicodeNormalization;

use super::statements::without_comment;
use crate::scene::{TextureUse, Wrap};
use crate::untrusted;

/// Most warnings of one file; further ones are counted.
const MAX_WARNINGS: usize = 8;

/// Largest multiplier of a bump map.
const MOST_BUMP: f32 = 1e4;

/// A material of a library; what the library does not give is none.
#[derive(Clone, Debug, Default)]
pub(super) struct MtlMaterial {
    pub name: String,
    pub kd: Option<Vec3>,
    pub ks: Option<Vec3>,
    pub ke: Option<Vec3>,
    pub tf: Option<Vec3>,
    pub ns: Option<f32>,
    pub ni: Option<f32>,
    pub d: Option<f32>,
    pub tr: Option<f32>,
    pub pr: Option<f32>,
    pub pm: Option<f32>,
    pub illum: Option<u8>,
    pub map_kd: Option<Map>,
    pub map_d: Option<Map>,
    pub map_ke: Option<Map>,
    pub map_pr: Option<Map>,
    pub map_pm: Option<Map>,
    pub norm: Option<Map>,
    /// Heights, and their multiplier.
    pub bump: Option<(Map, f32)>,
}

/// An image file with how it is laid on the surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Map {
    pub file: String,
    /// Texture coordinates are multiplied by this (`-s`), then this is added (`-o`).
    pub scale: Vec2,
    pub offset: Vec2,
    /// Whether it ends at its border (`-clamp`).
    pub clamp: bool,
}

impl Map {
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

/// Reads the libraries that an `mtllib` of `file` (an OBJ) names; later definitions override earlier ones.
pub(super) fn read_libraries(file: &Path, argument: &str, warnings: &mut Vec<String>) -> Vec<MtlMaterial> {
    let folder = file.parent().unwrap_or(Path::new(""));
    // One name with spaces, several names, or either before a comment.
    let bare = without_comment(argument);
    let names = match [argument, bare].into_iter().find(|name| find_file(folder, name).is_some()) {
        Some(name) => vec![name],
        None => bare.split_whitespace().collect(),
    };
    let mut materials = Vec::new();
    for name in names {
        let problem = match find_file(folder, name).map(|path| (std::fs::read(&path), path)) {
            Some((Ok(bytes), path)) => match untrusted::wrong_format(&bytes).filter(|_| !bytes.is_empty()) {
                Some(why) => why.to_owned(),
                None => {
                    materials.extend(parse(&path, &bytes, warnings));
                    continue;
                }
            },
            Some((Err(error), _)) => format!("cannot be read ({error})"),
            None => "is missing".to_owned(),
        };
        warnings.push(format!("{}: material library {name} {problem}; using grey", file.display()));
    }
    materials
}

/// Finds `name` below `folder`: as written, ignoring case, only its last component; or so before a comment.
pub(super) fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let bare = without_comment(name);
    find_as_written(folder, name).or_else(|| find_as_written(folder, bare).filter(|_| bare != name))
}

fn find_as_written(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.trim().trim_matches('"').replace('\\', "/");
    let exact = folder.join(&name);
    if exact.is_file() {
        return Some(exact);
    }
    let last = name.rsplit('/').next().unwrap_or(&name);
    find_any_case(folder, &name).or_else(|| find_any_case(folder, last))
}

/// Finds `name` below `folder`, ignoring case and how accents are encoded.
pub(crate) fn find_any_case(folder: &Path, name: &str) -> Option<PathBuf> {
    let mut path = folder.to_owned();
    for component in name.split('/').filter(|component| !component.is_empty()) {
        let exact = path.join(component);
        path = if exact.exists() {
            exact
        } else {
            let folder = if path.as_os_str().is_empty() { Path::new(".") } else { &path };
            let mut entries: Vec<_> =
                std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()).collect();
            entries.sort();
            let folded = |name: &str| name.nfc().collect::<String>().to_lowercase();
            let same = |path: &PathBuf| {
                path.file_name().is_some_and(|name| folded(&name.to_string_lossy()) == folded(component))
            };
            entries.into_iter().find(same)?
        };
    }
    path.is_file().then_some(path)
}

/// Parses a library; what is wrong with a statement becomes a warning.
pub(super) fn parse(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Vec<MtlMaterial> {
    let (mut materials, mut problems) = (Vec::new(), Vec::new());
    let mut not_shown = BTreeSet::new();
    for (number, line) in untrusted::text_of(bytes).lines().enumerate() {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let (keyword, rest) = (keyword.to_ascii_lowercase(), rest.trim());
        not_shown.extend(what_is_not_shown(&keyword, rest));
        if keyword.starts_with("map_") || ["norm", "bump"].contains(&&*keyword) {
            not_shown
                .extend(options_of(rest).0.into_iter().filter_map(|(option, _)| option_not_shown(option)));
        }
        if let Err(problem) = read_statement(&mut materials, &keyword, rest) {
            problems.push(format!("{}:{}: {problem}", path.display(), number + 1));
        }
    }
    let more = problems.len().saturating_sub(MAX_WARNINGS);
    warnings.extend(problems.into_iter().take(MAX_WARNINGS));
    if more > 0 {
        warnings.push(format!("{}: {more} more warnings", path.display()));
    }
    if !not_shown.is_empty() {
        let names = not_shown.into_iter().collect::<Vec<_>>().join(", ");
        warnings.push(format!("{}: not shown: {names}", path.display()));
    }
    materials
}

/// The statement of a keyword that has an effect which is not shown, if it does.
fn what_is_not_shown(keyword: &str, rest: &str) -> Option<&'static str> {
    let zero = || rest.split_whitespace().all(|word| word.parse() == Ok(0.0f32));
    Some(match keyword {
        "disp" => "disp (displacement)",
        "refl" => "refl (reflection map)",
        "decal" => "decal",
        "map_ks" => "map_Ks (map of the reflectance)",
        "map_ns" => "map_Ns (map of the highlight)",
        "map_ps" | "ps" if !zero() => "Ps (sheen)",
        "pc" if !zero() => "Pc (clear coat)",
        "aniso" if !zero() => "aniso (anisotropy)",
        _ => return None,
    })
}

/// Begins a material, or gives a value to the last one. Statements without effect on the surface are skipped.
fn read_statement(materials: &mut Vec<MtlMaterial>, keyword: &str, rest: &str) -> Result<(), String> {
    if keyword == "newmtl" {
        if rest.is_empty() {
            return Err("material without a name; ignored".to_owned());
        }
        materials.push(MtlMaterial { name: rest.to_owned(), ..MtlMaterial::default() });
        return Ok(());
    }
    let mut nameless = MtlMaterial::default();
    let material = materials.last_mut().unwrap_or(&mut nameless);
    let colour = |most: f32, value: &mut Option<Vec3>| read_colour(keyword, rest, most, value);
    let number = |value: &mut Option<f32>| read_number(keyword, rest).map(|number| *value = Some(number));
    let file = |value: &mut Option<Map>| read_map(keyword, rest).map(|map| *value = Some(map));
    match keyword {
        "kd" => colour(1.0, &mut material.kd),
        "ks" => colour(1.0, &mut material.ks),
        "ke" => colour(f32::MAX, &mut material.ke),
        // `Tf xyz` and `Tf spectral` are rare.
        "tf" => colour(1.0, &mut material.tf),
        "ns" => number(&mut material.ns),
        "ni" => number(&mut material.ni),
        "d" => number(&mut material.d),
        "tr" => number(&mut material.tr),
        "pr" => number(&mut material.pr),
        "pm" => number(&mut material.pm),
        "illum" => {
            material.illum =
                Some(rest.parse().map_err(|_| format!("illum {rest} is not a number; ignored"))?);
            Ok(())
        }
        "map_kd" => file(&mut material.map_kd),
        "map_d" => file(&mut material.map_d),
        "map_ke" => file(&mut material.map_ke),
        "map_pr" => file(&mut material.map_pr),
        "map_pm" => file(&mut material.map_pm),
        "norm" | "map_kn" => file(&mut material.norm),
        "map_bump" | "bump" => {
            material.bump = Some((read_map(keyword, rest)?, bump_multiplier(rest)?));
            Ok(())
        }
        _ => Ok(()),
    }
}

/// Reads a colour of one or three numbers, clamped to [0, most]; where that changes it, the error says so.
fn read_colour(keyword: &str, rest: &str, most: f32, value: &mut Option<Vec3>) -> Result<(), String> {
    let numbers: Vec<f32> = rest.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let given = match numbers[..] {
        [grey] => Vec3::splat(grey),
        [r, g, b, ..] => Vec3::new(r, g, b),
        _ => return Err(format!("{keyword} \"{rest}\" is not a colour of three numbers; ignored")),
    };
    let usable = Vec3::from_array(
        given.to_array().map(|channel| if channel.is_finite() { channel.clamp(0.0, most) } else { 0.0 }),
    );
    *value = Some(usable);
    if usable == given {
        Ok(())
    } else {
        Err(format!("{keyword} {rest} is out of range; clamped to {usable}"))
    }
}

fn read_number(keyword: &str, rest: &str) -> Result<f32, String> {
    // `d -halo 0.5` varies with the view angle; use its minimum.
    let word = rest.trim_start_matches("-halo").split_whitespace().next().unwrap_or("");
    let value: f32 = word.parse().map_err(|_| format!("{keyword} is not a number; ignored"))?;
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(format!("{keyword} {word} is negative or not finite; ignored"))
    }
}

fn read_map(keyword: &str, rest: &str) -> Result<Map, String> {
    let (options, file) = options_of(rest);
    if file.is_empty() {
        return Err(format!("{keyword} names no file; ignored"));
    }
    let mut map = Map { file: file.to_owned(), scale: Vec2::ONE, ..Map::default() };
    for (option, arguments) in options {
        let number =
            |place: usize, default: f32| arguments.get(place).map_or(Ok(default), |word| word.parse());
        let pair = |default: f32| {
            let pair = Vec2::new(number(0, default).ok()?, number(1, default).ok()?);
            pair.is_finite().then_some(pair)
        };
        let unusable =
            || format!("{keyword} {option} {} is not of finite numbers; ignored", arguments.join(" "));
        match option {
            "-s" => map.scale = pair(1.0).ok_or_else(unusable)?,
            "-o" => map.offset = pair(0.0).ok_or_else(unusable)?,
            "-clamp" => map.clamp = arguments.first() == Some(&"on"),
            _ => {}
        }
    }
    Ok(map)
}

/// The argument of the option `-bm` before a file name; 1 without one.
fn bump_multiplier(rest: &str) -> Result<f32, String> {
    let (options, _) = options_of(rest);
    let Some((_, arguments)) = options.iter().find(|(option, _)| *option == "-bm") else { return Ok(1.0) };
    let word = arguments.first().copied().unwrap_or_default();
    let number = word.parse().ok().filter(|number: &f32| number.abs() <= MOST_BUMP);
    number.ok_or_else(|| {
        format!("-bm {word} is not a number from -{MOST_BUMP} to {MOST_BUMP}; bump map ignored")
    })
}

/// An option that changes the picture and is not read.
fn option_not_shown(option: &str) -> Option<&'static str> {
    Some(match option {
        "-t" => "-t (turbulence of a map)",
        "-mm" => "-mm (range of a map)",
        "-imfchan" => "-imfchan (channel of a map)",
        _ => return None,
    })
}

/// An option of a map with its arguments.
type MapOption<'a> = (&'a str, Vec<&'a str>);

/// The options such as `-clamp on` or `-s 1 1 1`, and the file name after them, which may contain spaces.
fn options_of(mut rest: &str) -> (Vec<MapOption<'_>>, &str) {
    let mut options = Vec::new();
    while rest.starts_with('-') {
        let (option, tail) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        // Number of arguments: fixed, or up to three numbers.
        let (fixed, numbers) = match option {
            "-o" | "-s" | "-t" => (0, 3),
            "-mm" => (2, 0),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-texres" | "-bm" | "-boost" | "-imfchan"
            | "-type" => (1, 0),
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
        ] {
            assert_eq!(options_of(given).1, expected);
        }
        let map = read_map("map_kd", "-s 2 -clamp on -o 0.5 0.25 7 -mm 0 1 b.png").unwrap();
        assert_eq!((map.scale, map.offset), (Vec2::new(2.0, 1.0), Vec2::new(0.5, 0.25)));
        assert!(map.clamp && map.file == "b.png" && read_map("map_kd", "-o nan a.png").is_err());
        // What lies at v from the bottom lies at 1 - v from the top.
        let place = map.of(0).coordinates([Vec2::new(0.25, 1.0 - 0.5); 2]);
        assert_eq!(place, Vec2::new(1.0, 1.0 - 0.75));
        for (given, expected) in
            [("a.png", 1.0), ("-bm 0.2 c d.png", 0.2), ("-clamp on -bm -3 -mm 0 1 e-bm 7.png", -3.0)]
        {
            assert_eq!(bump_multiplier(given), Ok(expected), "{given}");
        }
        assert!(bump_multiplier("-bm nan a.png").is_err() && bump_multiplier("-bm 1e9 a.png").is_err());
    }

    #[test]
    fn bad_values_warn_and_stay_in_range() {
        let text = b"newmtl a\nKd 2 -1 nan\nKs 0.5\nNs -3\nd half\nKe 5 inf 0\nKd 1 2\nmap_Kd\nnewmtl\nillum x\nTf 1\n";
        let mut warnings = Vec::new();
        let materials = parse(Path::new("m.mtl"), text, &mut warnings);
        assert_eq!(materials.len(), 1);
        assert_eq!(materials[0].kd, Some(Vec3::X));
        assert_eq!(materials[0].ks, Some(Vec3::splat(0.5)));
        assert_eq!(materials[0].ke, Some(Vec3::new(5.0, 0.0, 0.0)));
        assert_eq!((materials[0].ns, materials[0].d), (None, None));
        // The last is `illum x`: `Tf 1` is a grey.
        assert_eq!(warnings.len(), 8, "{warnings:?}");
        assert!(warnings[0].starts_with("m.mtl:2: kd 2 -1 nan"), "{}", warnings[0]);
    }

    #[test]
    fn any_bytes_parse_without_panic() {
        let text = b"newmtl a\nKd .1 .2 .3\nmap_Kd -s 1 1 x.png\nd 0.5\n";
        for i in 0..text.len() {
            parse(Path::new("m.mtl"), &text[..i], &mut Vec::new());
            for byte in [0u8, b'\n', b' ', b'-', 0xff] {
                let mut changed = text.to_vec();
                changed[i] = byte;
                parse(Path::new("m.mtl"), &changed, &mut Vec::new());
            }
        }
    }
}
