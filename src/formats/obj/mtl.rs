//! Material libraries, parsed by the crate `tobj`.
//!
//! In: the `mtllib` argument of an OBJ. Out: its materials, with finite numbers in range. Problems are warnings, never errors:
//! a picture without a map is better than none.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::Vec3;
use unicode_normalization::UnicodeNormalization;

use super::map::{self, Map};
use super::reader::{parts, without_comment};
use crate::untrusted;

/// Most warnings of one file; further ones are counted.
const MAX_WARNINGS: usize = 8;

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
    /// Heights.
    pub bump: Option<Map>,
}

impl MtlMaterial {
    /// What `tobj` read of usable statements.
    fn of(material: tobj::Material) -> Self {
        let other = |keyword: &str| material.unknown_param.get(keyword);
        let number = |keyword: &str| other(keyword)?.parse().ok();
        let map = |text: Option<&String>| Map::read("", text?).ok();
        let colour = |text: &String| read_colour("", text, 1.0).ok();
        Self {
            kd: material.diffuse.map(Vec3::from_array),
            ks: material.specular.map(Vec3::from_array),
            ke: material.emissive.map(Vec3::from_array),
            tf: other("tf").and_then(colour).map(|(given, _)| given),
            ns: material.shininess,
            ni: material.optical_density,
            d: material.dissolve,
            tr: number("tr"),
            pr: number("pr"),
            pm: number("pm"),
            illum: material.illumination_model,
            map_kd: map(material.diffuse_texture.as_ref()),
            map_d: map(material.dissolve_texture.as_ref()),
            map_ke: map(other("map_ke")),
            map_pr: map(other("map_pr")),
            map_pm: map(other("map_pm")),
            norm: map(other("norm")),
            bump: map(material.normal_texture.as_ref()),
            name: material.name,
        }
    }
}

/// Reads the libraries that an `mtllib` of `file` (an OBJ) names; later definitions override earlier ones.
pub(super) fn read_libraries(file: &Path, argument: &str, warnings: &mut Vec<String>) -> Vec<MtlMaterial> {
    let folder = file.parent().unwrap_or(Path::new(""));
    // One name with spaces, several names, or either before a comment; a space in one of several names is escaped.
    let bare = without_comment(argument);
    let names = match [argument, bare].into_iter().find(|name| find_file(folder, name).is_some()) {
        Some(name) => vec![name.to_owned()],
        None => {
            let names = bare.replace("\\ ", "\0");
            names.split_whitespace().map(|name| name.replace('\0', " ")).collect()
        }
    };
    let mut materials = Vec::new();
    for name in names {
        let problem = match find_file(folder, &name).map(|path| (std::fs::read(&path), path)) {
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

/// Finds `name` below `folder`: as written, ignoring case, only its last component; or so before a comment; or with its escaped
/// spaces.
pub(super) fn find_file(folder: &Path, name: &str) -> Option<PathBuf> {
    let bare = without_comment(name);
    let unescaped = bare.replace("\\ ", " ");
    let mut names = vec![name, bare, &unescaped];
    names.dedup();
    names.into_iter().find_map(|name| find_as_written(folder, name))
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

/// Parses a library; what is wrong with a statement becomes a warning, and `tobj` is given the others.
pub(super) fn parse(path: &Path, bytes: &[u8], warnings: &mut Vec<String>) -> Vec<MtlMaterial> {
    let (mut usable, mut problems) = (String::new(), Vec::new());
    let mut not_shown = BTreeSet::new();
    for (number, line) in untrusted::text_of(bytes).lines().enumerate() {
        let (keyword, rest) = parts(line.trim());
        let keyword = keyword.to_ascii_lowercase();
        not_shown.extend(what_is_not_shown(&keyword, rest));
        if keyword.starts_with("map_") || ["norm", "bump"].contains(&&*keyword) {
            not_shown.extend(map::not_shown(&keyword, rest));
        }
        let statement = usable_statement(&keyword, rest).unwrap_or_else(|(statement, problem)| {
            problems.push(format!("{}:{}: {problem}", path.display(), number + 1));
            statement
        });
        usable.extend([&statement, "\n"]);
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
    match tobj::load_mtl_buf(&mut usable.as_bytes()) {
        Ok((materials, _)) => materials.into_iter().map(MtlMaterial::of).collect(),
        Err(why) => {
            warnings.push(format!("{}: {why}; using grey", path.display()));
            Vec::new()
        }
    }
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

/// A statement as `tobj` can read it, which is none without effect on the surface; or what is usable of it, and the problem.
fn usable_statement(keyword: &str, rest: &str) -> Result<String, (String, String)> {
    let nothing = |problem| (String::new(), problem);
    // `tobj` knows keywords by their case.
    let name = match keyword {
        "kd" => "Kd",
        "ks" => "Ks",
        "ke" => "Ke",
        "ns" => "Ns",
        "ni" => "Ni",
        "map_kd" => "map_Kd",
        "map_kn" => "norm",
        "map_bump" => "bump",
        other => other,
    };
    match keyword {
        "newmtl" if rest.is_empty() => return Err(nothing("material without a name; ignored".to_owned())),
        "newmtl" => {}
        "kd" | "ks" | "ke" | "tf" => {
            // `Tf xyz` and `Tf spectral` are rare.
            let most = if keyword == "ke" { f32::MAX } else { 1.0 };
            let (given, usable) = read_colour(keyword, rest, most).map_err(nothing)?;
            let statement = format!("{name} {} {} {}", usable.x, usable.y, usable.z);
            return if usable == given {
                Ok(statement)
            } else {
                Err((statement, format!("{keyword} {rest} is out of range; clamped to {usable}")))
            };
        }
        "ns" | "ni" | "d" | "tr" | "pr" | "pm" => {
            return read_number(keyword, rest).map(|number| format!("{name} {number}")).map_err(nothing);
        }
        "illum" => {
            rest.parse::<u8>().map_err(|_| nothing(format!("illum {rest} is not a number; ignored")))?;
        }
        "map_kd" | "map_d" | "map_ke" | "map_pr" | "map_pm" | "norm" | "map_kn" | "map_bump" | "bump" => {
            Map::read(keyword, rest).map_err(nothing)?;
        }
        _ => return Ok(String::new()),
    }
    Ok(format!("{name} {rest}"))
}

/// Reads a colour of one or three numbers, as it is and clamped to [0, most].
fn read_colour(keyword: &str, rest: &str, most: f32) -> Result<(Vec3, Vec3), String> {
    let numbers: Vec<f32> = rest.split_whitespace().map_while(|word| word.parse().ok()).collect();
    let given = match numbers[..] {
        [grey] => Vec3::splat(grey),
        [r, g, b, ..] => Vec3::new(r, g, b),
        _ => return Err(format!("{keyword} \"{rest}\" is not a colour of three numbers; ignored")),
    };
    let usable = |channel: f32| if channel.is_finite() { channel.clamp(0.0, most) } else { 0.0 };
    Ok((given, Vec3::from_array(given.to_array().map(usable))))
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

#[cfg(test)]
mod tests {
    use super::*;

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
