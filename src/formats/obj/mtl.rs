//! Material libraries: sanitises an MTL and parses it with tobj.
//!
//! In: the `mtllib` arguments of an OBJ. Out: tobj's materials, with finite values in range. Problems are warnings,
//! never errors.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::Vec3;

/// Most warnings of one file; further ones are counted.
const MAX_WARNINGS: usize = 8;

/// What a bump map is called among the parameters that tobj leaves as text; then come its multiplier and its file.
pub(crate) const BUMP: &str = "bump-map";

/// Largest multiplier of a bump map.
const MOST_BUMP: f32 = 1e4;

/// Reads the libraries named in `file` (an OBJ); later definitions override earlier ones.
pub(crate) fn read_libraries(
    file: &Path,
    libraries: &[String],
    warnings: &mut Vec<String>,
) -> Vec<tobj::Material> {
    let folder = file.parent().unwrap_or(Path::new(""));
    let mut materials = Vec::new();
    for argument in libraries {
        // Either one name with spaces or several names.
        let names = match find_file(folder, argument) {
            Some(_) => vec![argument.as_str()],
            None => argument.split_whitespace().collect(),
        };
        for name in names {
            let bytes = find_file(folder, name).map(|path| std::fs::read(&path).map(|bytes| (path, bytes)));
            match bytes {
                Some(Ok((path, bytes))) => materials.extend(parse(&path, &bytes, warnings)),
                Some(Err(error)) => warnings.push(format!(
                    "{}: material library {name} cannot be read ({error}); using grey",
                    file.display()
                )),
                None => warnings
                    .push(format!("{}: material library {name} is missing; using grey", file.display())),
            }
        }
    }
    materials
}

/// Finds `name` below `folder`: as written, ignoring case, or only its last component.
pub(crate) fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let name = name.trim().trim_matches('"').replace('\\', "/");
    let exact = folder.join(&name);
    if exact.is_file() {
        return Some(exact);
    }
    let last = name.rsplit('/').next().unwrap_or(&name);
    find_any_case(folder, &name).or_else(|| find_any_case(folder, last))
}

fn find_any_case(folder: &Path, name: &str) -> Option<PathBuf> {
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

/// Sanitises an MTL (tobj panics on a colour of two numbers) and parses it.
fn parse(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Vec<tobj::Material> {
    let mut clean = String::new();
    let mut problems = Vec::new();
    let mut not_shown = BTreeSet::new();
    for (number, line) in String::from_utf8_lossy(bytes).lines().enumerate() {
        let line = line.trim();
        let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        not_shown.extend(what_is_not_shown(keyword, rest));
        if let Err(problem) = rewrite(&mut clean, keyword, rest.trim()) {
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
    match tobj::load_mtl_buf(&mut clean.as_bytes()) {
        Ok((materials, _)) => materials,
        Err(error) => {
            warnings.push(format!("{}: cannot be parsed ({error}); using grey", path.display()));
            Vec::new()
        }
    }
}

/// The statement of a keyword that has an effect which is not shown, if it does.
fn what_is_not_shown(keyword: &str, rest: &str) -> Option<&'static str> {
    let zero = || rest.split_whitespace().all(|word| word.parse() == Ok(0.0f32));
    Some(match keyword.to_ascii_lowercase().as_str() {
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

/// Appends one checked statement to `clean`; skips statements that [`tobj::Material`] ignores.
fn rewrite(clean: &mut String, keyword: &str, rest: &str) -> Result<(), String> {
    let keyword = keyword.to_ascii_lowercase();
    // Writing to a String cannot fail.
    let _ = match keyword.as_str() {
        "newmtl" if rest.is_empty() => return Err("material without a name; ignored".into()),
        "newmtl" => writeln!(clean, "newmtl {rest}"),
        "kd" | "ks" => {
            let (colour, problem) = colour(&keyword, rest, 1.0)?;
            let _ = writeln!(clean, "K{} {} {} {}", &keyword[1..], colour.x, colour.y, colour.z);
            return problem.map_or(Ok(()), Err);
        }
        "ke" | "tf" => {
            let (name, most) = if keyword == "ke" { ("Ke", f32::MAX) } else { ("Tf", 1.0) };
            // `Tf xyz` and `Tf spectral` are rare.
            let (colour, problem) = colour(&keyword, rest, most)?;
            let _ = writeln!(clean, "{name} {} {} {}", colour.x, colour.y, colour.z);
            return problem.map_or(Ok(()), Err);
        }
        "illum" => {
            let model: u8 = rest.parse().map_err(|_| format!("illum {rest} is not a number; ignored"))?;
            writeln!(clean, "illum {model}")
        }
        "ns" | "d" | "tr" | "ni" | "pr" | "pm" => {
            // `d -halo 0.5` varies with the view angle; use its minimum.
            let word = rest.trim_start_matches("-halo").split_whitespace().next().unwrap_or("");
            let value: f32 = word.parse().map_err(|_| format!("{keyword} is not a number; ignored"))?;
            if !(value >= 0.0 && value.is_finite()) {
                return Err(format!("{keyword} {word} is negative or not finite; ignored"));
            }
            let name = match keyword.as_str() {
                "ns" => "Ns",
                "tr" => "Tr",
                "ni" => "Ni",
                "pr" => "Pr",
                "pm" => "Pm",
                _ => "d",
            };
            writeln!(clean, "{name} {value}")
        }
        "map_bump" | "bump" => {
            let file = without_options(rest);
            if file.is_empty() {
                return Err(format!("{keyword} names no file; ignored"));
            }
            writeln!(clean, "{BUMP} {} {file}", bump_multiplier(rest)?)
        }
        "map_kd" | "map_d" | "map_ke" | "map_pr" | "map_pm" | "norm" | "map_kn" => {
            let file = without_options(rest);
            if file.is_empty() {
                return Err(format!("{keyword} names no file; ignored"));
            }
            let name = match keyword.as_str() {
                "map_kd" => "map_Kd",
                "map_ke" => "map_Ke",
                "map_pr" => "map_Pr",
                "map_pm" => "map_Pm",
                "norm" | "map_kn" => "norm",
                _ => "map_d",
            };
            writeln!(clean, "{name} {file}")
        }
        _ => Ok(()),
    };
    Ok(())
}

/// A colour of one or three numbers, clamped to [0, max], with a warning where that changed it.
fn colour(keyword: &str, rest: &str, max: f32) -> Result<(Vec3, Option<String>), String> {
    let numbers: Vec<f32> = rest.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let given = match numbers[..] {
        [grey] => Vec3::splat(grey),
        [r, g, b, ..] => Vec3::new(r, g, b),
        _ => {
            return Err(format!("{keyword} \"{rest}\" is not a colour of three numbers; ignored"));
        }
    };
    let usable = given.to_array().map(|c| if c.is_finite() { c.clamp(0.0, max) } else { 0.0 });
    let usable = Vec3::from_array(usable);
    let problem = (usable != given).then(|| format!("{keyword} {rest} is out of range; clamped to {usable}"));
    Ok((usable, problem))
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
        assert_eq!(materials[0].diffuse, Some([1.0, 0.0, 0.0]));
        assert_eq!(materials[0].specular, Some([0.5; 3]));
        assert_eq!(materials[0].emissive, Some([5.0, 0.0, 0.0]));
        assert_eq!((materials[0].shininess, materials[0].dissolve), (None, None));
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
