//! A glTF file with its buffers.
//!
//! In: a `.gltf` or `.glb`. Out: the checked document and the bytes of its buffers and images; or an error that names
//! the file and what is wrong in it.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::gltf::json;
use ::gltf::json::validation::{Checked, Error as Violation, Validate};
use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::DecodePaddingMode;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};

use super::buffers::range;
use super::extensions::{Support, extensions_of_shapes, support_of};
use super::repair::repair;
use crate::formats::error::SceneError;
use crate::formats::obj::find_any_case;
use crate::untrusted::{unicode_of, wrong_format};

/// What the validation asks for and nobody needs: data that is zero, images that no material uses, shapes that have no
/// positions; and the bounds of positions, which are computed.
const DISPENSABLE: [&str; 3] = [".bufferView", ".source", "[\"POSITION\"]"];
const BOUNDS: [&str; 2] = [".min", ".max"];

const VERSION_1: &str = "is glTF 1.0; export it as glTF 2.0";

/// What is wrong with a text that could not be parsed.
fn why_not_gltf(json: &str, error: &serde_json::Error) -> String {
    let document: Option<serde_json::Value> = serde_json::from_str(json).ok();
    match document.as_ref().map(|document| (document.get("asset"), document.get("meshes"))) {
        None => format!("is not glTF, nor any JSON ({error}); export or download it again"),
        // It has objects by name, and may lack its asset.
        Some((_, Some(serde_json::Value::Object(_)))) => VERSION_1.to_owned(),
        Some((Some(asset), _)) if asset.get("version").is_some_and(|version| version == "1.0") => {
            VERSION_1.to_owned()
        }
        Some((None, _)) => "is JSON without an asset, not glTF; export the model as glTF 2.0".to_owned(),
        _ => format!("is not glTF 2.0 ({error}); export it again"),
    }
}

/// The bytes of a data URI (RFC 2397) behind its scheme; padding and alphabet of its base64 as writers have them.
fn data_of(data: &str) -> Result<Vec<u8>, String> {
    let (head, content) = data.split_once(',').ok_or("has no comma")?;
    let mut bytes: Vec<u8> = percent_encoding::percent_decode_str(content).collect();
    let end = head.len().saturating_sub(7);
    if !head.get(end..).is_some_and(|end| end.eq_ignore_ascii_case(";base64")) {
        return Ok(bytes);
    }
    bytes.retain(|byte| !byte.is_ascii_whitespace());
    for byte in &mut bytes {
        *byte = match *byte {
            b'-' => b'+',
            b'_' => b'/',
            other => other,
        };
    }
    let config = GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true);
    let engine = GeneralPurpose::new(&STANDARD, config);
    engine.decode(bytes).map_err(|error| format!("is not base64 ({error})"))
}

/// A file in memory.
pub(super) struct Source {
    pub file: PathBuf,
    pub document: Arc<::gltf::Document>,
    /// The bytes of each buffer, at least as many as it says.
    buffers: Vec<Vec<u8>>,
    /// Whether vertices may be integers.
    pub quantized: bool,
    /// What is in the file and is not shown, each once.
    pub not_shown: BTreeSet<String>,
}

impl Source {
    /// Reads `file` and the buffers that it names, and checks every index in it.
    pub fn read(file: &Path) -> Result<Self, SceneError> {
        let bytes =
            std::fs::read(file).map_err(|reason| SceneError::Unreadable { file: file.to_owned(), reason })?;
        let invalid = |problem: String| SceneError::invalid(file, None, problem);
        if let Some(why) = wrong_format(&bytes) {
            return Err(invalid(why.to_owned()));
        }
        if bytes.starts_with(b"glTF\x01\0\0\0") {
            return Err(invalid(VERSION_1.to_owned()));
        }
        let (json, blob) = if bytes.starts_with(b"glTF") {
            let glb = ::gltf::Glb::from_slice(&bytes).map_err(|error| {
                invalid(format!("is not a whole GLB ({error}); export or download it again"))
            })?;
            (glb.json, glb.bin.map(Cow::into_owned))
        } else {
            (Cow::Borrowed(bytes.as_slice()), None)
        };
        let json = unicode_of(&json)
            .ok_or_else(|| invalid("is not glTF: its JSON is no UTF-8 text; export it again".to_owned()))?;
        let wrong = |error: serde_json::Error| invalid(why_not_gltf(&json, &error));
        let mut document: serde_json::Value = serde_json::from_str(&json).map_err(wrong)?;
        if let Some(version) = document["asset"]["version"].as_str().filter(|v| !v.starts_with("2.")) {
            return Err(invalid(format!("is glTF {version}; export it as glTF 2.0")));
        }
        if !fits(&document) {
            return Err(invalid("has a number that is out of range; export it again".to_owned()));
        }
        let mut not_shown = BTreeSet::new();
        let of_shapes = extensions_of_shapes(&document);
        repair(&mut document, &mut not_shown);
        let root: json::Root = serde_json::from_value(document).map_err(wrong)?;
        let mut source = Self {
            file: file.to_owned(),
            quantized: root.extensions_used.iter().any(|name| name == "KHR_mesh_quantization"),
            document: Arc::new(::gltf::Document::from_json_without_validation(json::Root::default())),
            buffers: Vec::new(),
            not_shown,
        };
        source.check(&root, &of_shapes)?;
        source.buffers = source.read_buffers(&root, blob)?;
        #[cfg(any(feature = "draco", feature = "meshopt"))]
        let root = source.unpack(root)?;
        source.document = Arc::new(::gltf::Document::from_json_without_validation(root));
        Ok(source)
    }

    /// An error about the file.
    pub fn error(&self, problem: impl Into<String>) -> SceneError {
        SceneError::invalid(&self.file, None, problem)
    }

    /// Checks version, extensions, and what the format demands of each object.
    fn check(&mut self, root: &json::Root, of_shapes: &BTreeSet<String>) -> Result<(), SceneError> {
        if let Some(version) = root.asset.min_version.as_deref().filter(|version| *version != "2.0") {
            return Err(self.error(format!("needs a reader of glTF {version}; export it as glTF 2.0")));
        }
        for name in &root.extensions_required {
            let advice = match support_of(name) {
                Support::Refused(advice) if of_shapes.contains(name) => advice,
                Support::Unknown if of_shapes.contains(name) => "export the file again without it",
                _ => continue,
            };
            return Err(self.error(format!("needs the extension {name}, which is not read; {advice}")));
        }
        let left_out = root
            .extensions_used
            .iter()
            .chain(&root.extensions_required)
            .filter(|name| !matches!(support_of(name), Support::Read | Support::Approximated));
        self.not_shown.extend(left_out.map(|name| format!("extension {name}")));
        self.check_positions(root)?;
        let mut violation = None;
        root.validate(root, json::Path::new, &mut |path, error| {
            let path = path().to_string();
            let is_any = |ends: &[&str]| ends.iter().any(|end| path.ends_with(end));
            let dispensable = is_any(&BOUNDS) || error == Violation::Missing && is_any(&DISPENSABLE);
            if error != Violation::Unsupported && violation.is_none() && !dispensable {
                violation = Some((path, error));
            }
        });
        match violation {
            None => Ok(()),
            Some((path, error)) => {
                let what = match error {
                    Violation::IndexOutOfBounds => "is an index past the end",
                    Violation::Missing => "is missing",
                    _ => "is not valid",
                };
                Err(self.error(format!("{path} {what}; export the file again")))
            }
        }
    }

    /// Checks the indices of positions, which the validation below takes for granted.
    fn check_positions(&self, root: &json::Root) -> Result<(), SceneError> {
        let positions = Checked::Valid(::gltf::Semantic::Positions);
        for (index, mesh) in root.meshes.iter().enumerate() {
            for primitive in &mesh.primitives {
                let accessor = primitive.attributes.get(&positions);
                if accessor.is_some_and(|accessor| accessor.value() >= root.accessors.len()) {
                    return Err(self.error(format!(
                        "meshes[{index}]: POSITION is an index past the end; export the file again"
                    )));
                }
            }
        }
        Ok(())
    }

    fn read_buffers(&self, root: &json::Root, mut blob: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, SceneError> {
        let read = |(index, buffer): (usize, &json::Buffer)| {
            #[cfg(feature = "meshopt")]
            if super::meshopt::is_fallback(buffer) {
                return Ok(Vec::new());
            }
            let bytes = match &buffer.uri {
                Some(uri) => self.resolve(uri).map_err(|why| self.error(format!("buffer {index} {why}")))?,
                None => blob.take().filter(|_| index == 0).ok_or_else(|| {
                    self.error(format!("buffer {index} has no uri and no data; export the file again"))
                })?,
            };
            let needed = buffer.byte_length.0;
            let is_short = (bytes.len() as u64) < needed;
            // Numbers may begin as other files do, but not as such a text.
            let is_text = bytes.starts_with(b"version https:") || bytes.trim_ascii_start().starts_with(b"<");
            if let Some(why) = wrong_format(&bytes).filter(|_| is_short || is_text) {
                return Err(self.error(format!("buffer {index} {why}")));
            }
            if is_short {
                let is_plain = buffer
                    .uri
                    .as_ref()
                    .is_some_and(|uri| uri.starts_with("data:") && !uri.to_lowercase().contains(";base64,"));
                return Err(self.error(format!(
                    "buffer {index} has {} bytes instead of {needed}{}; export or download the file again",
                    bytes.len(),
                    if is_plain { " (its data URI is not base64)" } else { "" }
                )));
            }
            Ok(bytes)
        };
        root.buffers.iter().enumerate().map(read).collect()
    }

    /// Decodes what is compressed.
    #[cfg(any(feature = "draco", feature = "meshopt"))]
    fn unpack(&mut self, mut root: json::Root) -> Result<json::Root, SceneError> {
        #[cfg(feature = "meshopt")]
        super::meshopt::decode(&mut root, &mut self.buffers).map_err(|why| self.error(why))?;
        #[cfg(feature = "draco")]
        super::draco::decode(&mut root, &mut self.buffers).map_err(|why| self.error(why))?;
        Ok(root)
    }

    /// The bytes of a data URI or of a file below the folder of this one; the error completes a sentence about it.
    pub fn resolve(&self, uri: &str) -> Result<Vec<u8>, String> {
        if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
            return data_of(&uri[5..])
                .map_err(|why| format!("has a data URI that {why}; export the file again"));
        }
        let path = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
        let parts = Path::new(path.as_ref()).components();
        let mut inside =
            parts.map(|part| matches!(part, std::path::Component::Normal(_) | std::path::Component::CurDir));
        let path = path.replace('\\', "/");
        let is_url = path.contains("://");
        if path.is_empty()
            || is_url
            || path.split('/').any(|part| part == "..")
            || !inside.all(|inside| inside)
        {
            let problem = "leads out of the folder of the file; put it beside the file";
            return Err(format!("has the uri \"{uri}\", which {problem}"));
        }
        let folder = self.file.parent().unwrap_or(Path::new(""));
        // Names with a percent sign or a backslash of their own are there as they are written.
        let without_query = path.split(['?', '#']).next().unwrap_or_default();
        let file = match folder.join(uri) {
            literal if literal.is_file() => literal,
            _ => [&path, without_query]
                .into_iter()
                .find_map(|name| find_any_case(folder, name))
                .unwrap_or_else(|| folder.join(&path)),
        };
        std::fs::read(&file)
            .map_err(|reason| format!("is {}, which cannot be read ({reason}); put it there", file.display()))
    }

    /// The bytes of a buffer view; the error completes a sentence about what has it.
    pub fn view(&self, view: &::gltf::buffer::View<'_>) -> Result<&[u8], String> {
        range(&self.buffers, view.buffer().index(), view.offset(), view.length())
            .map_err(|why| format!("has buffer view {} {why}", view.index()))
    }
}

/// Whether all numbers that are read fit into 32-bit floats.
fn fits(value: &serde_json::Value) -> bool {
    use serde_json::Value;
    match value {
        Value::Number(number) => number.as_f64().is_some_and(|number| number.abs() <= f64::from(f32::MAX)),
        Value::Array(values) => values.iter().all(fits),
        Value::Object(object) => {
            object.iter().all(|(key, value)| ["extras", "min", "max"].contains(&key.as_str()) || fits(value))
        }
        _ => true,
    }
}
