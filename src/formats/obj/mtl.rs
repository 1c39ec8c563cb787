//! Material libraries.
//!
//! In: the `mtllib` argument of an OBJ. Out: its materials, with finite numbers in range. Problems are warnings, never errors:
//! tobj's own parser gives up at the first, and panics at a colour of two numbers.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::Vec3;

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
    pub map_kd: Option<String>,
    pub map_d: Option<String>,
    pub map_ke: Option<String>,
    pub map_pr: Option<String>,
    pub map_pm: Option<String>,
    pub norm: Option<String>,
    /// File of heights, and their multiplier.
    pub bump: Option<(String, f32)>,
}

/// Reads the libraries that an `mtllib` of `file` (an OBJ) names; later definitions override earlier ones.
pub(super) fn read_libraries(file: &Path, argument: &str, warnings: &mut Vec<String>) -> Vec<MtlMaterial> {
    let folder = file.parent().unwrap_or(Path::new(""));
    // Either one name with spaces or several names.
    let names = match find_file(folder, argument) {
        Some(_) => vec![argument],
        None => argument.split_whitespace().collect(),
    };
    let mut materials = Vec::new();
    for name in names {
        let problem = match find_file(folder, name).map(|path| (std::fs::read(&path), path)) {
            Some((Ok(bytes), path)) => {
                materials.extend(parse(&path, &bytes, warnings));
                continue;
            }
            Some((Err(error), _)) => format!("cannot be read ({error})"),
            None => "is missing".to_owned(),
        };
        warnings.push(format!("{}: material library {name} {problem}; using grey", file.display()));
    }
    materials
}

/// Finds `name` below `folder`: as written, ignoring case, or only its last component.
pub(super) fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.trim().trim_matches('"').replace('\\', "/");
    let exact = folder.join(&name);
    if exact.is_file() {
        return Some(exact);
    }
    let last = name.rsplit('/').next().unwrap_or(&name);
    find_any_case(folder, &name).or_else(|| find_any_case(folder, last))
}

/// Finds `name` below `folder`, ignoring case.
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
            let same = |path: &PathBuf| {
                path.file_name()
                    .is_some_and(|n| n.to_string_lossy().to_lowercase() == component.to_lowercase())
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
    for (number, line) in String::from_utf8_lossy(bytes).lines().enumerate() {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let (keyword, rest) = (keyword.to_ascii_lowercase(), rest.trim());
        not_shown.extend(what_is_not_shown(&keyword, rest));
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
    let file = |value: &mut Option<String>| read_file(keyword, rest).map(|file| *value = Some(file));
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
            material.bump = Some((read_file(keyword, rest)?, bump_multiplier(rest)?));
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

fn read_file(keyword: &str, rest: &str) -> Result<String, String> {
    let file = without_options(rest);
    if file.is_empty() { Err(format!("{keyword} names no file; ignored")) } else { Ok(file.to_owned()) }
}

/// The argument of the option `-bm` before a file name; 1 without one.
fn bump_multiplier(rest: &str) -> Result<f32, String> {
    let options = rest.strip_suffix(without_options(rest)).unwrap_or("");
    let mut words = options.split_whitespace().skip_while(|word| *word != "-bm").skip(1);
    let Some(word) = words.next() else { return Ok(1.0) };
    let number = word.parse().ok().filter(|number: &f32| number.abs() <= MOST_BUMP);
    number.ok_or_else(|| {
        format!("-bm {word} is not a number from -{MOST_BUMP} to {MOST_BUMP}; bump map ignored")
    })
}

/// The file name after options such as `-clamp on` or `-s 1 1 1`; it may contain spaces.
fn without_options(mut rest: &str) -> &str {
    while rest.starts_with('-') {
        let (option, tail) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        // Number of arguments: fixed, or up to three numbers.
        let (fixed, numbers) = match option {
            "-o" | "-s" | "-t" => (0, 3),
            "-mm" => (2, 0),
            "-blendu" | "-blendv" | "-cc" | "-clamp" | "-texres" | "-bm" | "-boost" | "-imfchan"
            | "-type" => (1, 0),
            _ => return rest,
        };
        rest = tail.trim_start();
        for i in 0..fixed.max(numbers) {
            let (word, tail) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
            if i >= fixed && word.parse::<f32>().is_err() {
                break;
            }
            rest = tail.trim_start();
        }
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_options_are_skipped() {
        for (given, expected) in [
            ("a.png", "a.png"),
            ("-clamp on my file.png", "my file.png"),
            ("-s 1 2 3 -o 0.5 b.png", "b.png"),
            ("-bm 0.2 -mm 0 1 c d.png", "c d.png"),
            ("-clamp", ""),
            ("-unknown e.png", "-unknown e.png"),
        ] {
            assert_eq!(without_options(given), expected);
        }
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
