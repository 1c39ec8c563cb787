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
use base64::alphabet;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use unicode_normalization::UnicodeNormalization;

use super::extensions::{Support, support_of};
use super::repair::repair;
use crate::formats::error::SceneError;

/// What the validation asks for and nobody needs: data that is zero, images that no material uses, shapes that have no
/// positions; and the bounds of positions, which are computed.
const DISPENSABLE: [&str; 3] = [".bufferView", ".source", "[\"POSITION\"]"];
const BOUNDS: [&str; 2] = [".min", ".max"];

/// Base64 with or without padding.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

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
        let (json, blob) = if bytes.starts_with(b"glTF\x01\0\0\0") {
            return Err(invalid("is a GLB of glTF 1.0; export it as glTF 2.0".to_owned()));
        } else if bytes.starts_with(b"glTF") {
            let glb = ::gltf::Glb::from_slice(&bytes).map_err(|error| {
                invalid(format!("is not a whole GLB ({error}); export or download it again"))
            })?;
            (glb.json, glb.bin.map(Cow::into_owned))
        } else {
            (Cow::Borrowed(bytes.as_slice()), None)
        };
        let json = json.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&json);
        let is_none =
            |error: serde_json::Error| invalid(format!("is not glTF 2.0 ({error}); export it again"));
        let mut document: serde_json::Value = serde_json::from_slice(json).map_err(is_none)?;
        if let Some(version) = document["asset"]["version"].as_str().filter(|v| !v.starts_with("2.")) {
            return Err(invalid(format!("is glTF {version}; export it as glTF 2.0")));
        }
        if !fits(&document) {
            return Err(invalid("has a number that is out of range; export it again".to_owned()));
        }
        let mut not_shown = BTreeSet::new();
        repair(&mut document, &mut not_shown);
        let root: json::Root = serde_json::from_value(document).map_err(is_none)?;
        let mut source = Self {
            file: file.to_owned(),
            quantized: root.extensions_used.iter().any(|name| name == "KHR_mesh_quantization"),
            document: Arc::new(::gltf::Document::from_json_without_validation(json::Root::default())),
            buffers: Vec::new(),
            not_shown,
        };
        source.check(&root)?;
        source.buffers = source.read_buffers(&root, blob)?;
        source.document = Arc::new(::gltf::Document::from_json_without_validation(root));
        Ok(source)
    }

    /// An error about the file.
    pub fn error(&self, problem: impl Into<String>) -> SceneError {
        SceneError::invalid(&self.file, None, problem)
    }

    /// Checks version, extensions, and what the format demands of each object.
    fn check(&mut self, root: &json::Root) -> Result<(), SceneError> {
        if let Some(version) = root.asset.min_version.as_deref().filter(|version| *version != "2.0") {
            return Err(self.error(format!("needs a reader of glTF {version}; export it as glTF 2.0")));
        }
        for name in &root.extensions_required {
            if let Support::Refused(advice) = support_of(name) {
                return Err(self.error(format!("needs the extension {name}, which is not read; {advice}")));
            }
        }
        let left_out = root
            .extensions_used
            .iter()
            .chain(&root.extensions_required)
            .filter(|name| matches!(support_of(name), Support::Ignored | Support::Refused(_)));
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
            let bytes = match &buffer.uri {
                Some(uri) => self.resolve(uri, &format!("buffer {index}"))?,
                None => blob.take().filter(|_| index == 0).ok_or_else(|| {
                    self.error(format!("buffer {index} has no uri and no data; export the file again"))
                })?,
            };
            let needed = buffer.byte_length.0;
            if (bytes.len() as u64) < needed {
                return Err(self.error(format!(
                    "buffer {index} has {} bytes instead of {needed}; export or download the file again",
                    bytes.len()
                )));
            }
            Ok(bytes)
        };
        root.buffers.iter().enumerate().map(read).collect()
    }

    /// The bytes of a data URI or of a file below the folder of this one. `what` names it in errors.
    pub fn resolve(&self, uri: &str, what: &str) -> Result<Vec<u8>, SceneError> {
        if uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:")) {
            return self.decode_data_uri(uri, what);
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
            return Err(self.error(format!(
                "{what}: the uri \"{uri}\" leads out of the folder of the file; put it beside the file"
            )));
        }
        let folder = self.file.parent().unwrap_or(Path::new(""));
        let file = folder.join(&path);
        let file = match path.split_once('?') {
            // A question mark belongs to a name, or begins what only servers read.
            Some((before, _)) if !file.exists() => folder.join(before),
            _ => file,
        };
        let read = std::fs::read(&file).or_else(|reason| match same_name(&file) {
            Some(other) => std::fs::read(other),
            None => Err(reason),
        });
        read.map_err(|reason| {
            self.error(format!("{what}: {} cannot be read ({reason}); put it there", file.display()))
        })
    }

    /// The bytes of a data URI, percent-encoded or Base64: with either alphabet, padded or not, also with line breaks.
    fn decode_data_uri(&self, uri: &str, what: &str) -> Result<Vec<u8>, SceneError> {
        let (kind, data) = uri.split_once(',').unwrap_or((uri, ""));
        let bytes = percent_encoding::percent_decode_str(data);
        if !kind.to_ascii_lowercase().ends_with(";base64") {
            return Ok(bytes.collect());
        }
        let standard = |byte: u8| match byte {
            b'-' => b'+',
            b'_' => b'/',
            byte => byte,
        };
        let bytes: Vec<u8> = bytes.filter(|byte| !byte.is_ascii_whitespace()).map(standard).collect();
        BASE64.decode(bytes).map_err(|error| {
            self.error(format!("{what}: its data URI is not base64 ({error}); export the file again"))
        })
    }

    /// The bytes of a buffer view.
    pub fn view(&self, view: &::gltf::buffer::View<'_>) -> Result<&[u8], SceneError> {
        let bytes = &self.buffers[view.buffer().index()];
        let end = view.offset().checked_add(view.length());
        end.and_then(|end| bytes.get(view.offset()..end)).ok_or_else(|| {
            self.error(format!(
                "buffer view {} (bytes {} to {}) is out of the range of its buffer, which has {} bytes; export the file again",
                view.index(),
                view.offset(),
                view.offset().saturating_add(view.length()),
                bytes.len()
            ))
        })
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

/// The only file beside `file` whose name differs in nothing but case, or in how its accents are composed.
fn same_name(file: &Path) -> Option<PathBuf> {
    let name =
        |path: &Path| Some(path.file_name()?.to_string_lossy().nfc().collect::<String>().to_lowercase());
    let files = std::fs::read_dir(file.parent()?).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    let mut same = files.filter(|other| name(other) == name(file));
    same.next().filter(|_| same.next().is_none())
}
