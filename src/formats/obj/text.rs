//! Validates an OBJ and rewrites it to a subset that tobj parses without error.
//!
//! In: the bytes of a file. Out: an equivalent OBJ of `v`, `vt`, `vn`, triangular `f`, `usemtl` and `o` lines, with
//! absolute indices in range, and the same attributes on all faces of one `o`; or an error that names the line, since
//! tobj's errors name neither line nor cause.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;

use glam::Vec3;

use crate::formats::error::SceneError;
use crate::scene::MAX_COORDINATE;
use crate::scene::polygon::triangulate;

/// A validated OBJ.
#[derive(Debug, Default)]
pub(crate) struct ObjText {
    /// The rewritten file.
    pub text: String,
    /// Arguments of its `mtllib` lines.
    pub libraries: Vec<String>,
    /// Names after `usemtl`, each once, in order of first use.
    pub materials: Vec<String>,
}

/// One vertex of a face: zero-based indices of position, texture coordinate, normal.
#[derive(Clone, Copy)]
struct Corner([Option<usize>; 3]);

/// Names and kinds of the three index lists of a face.
const LISTS: [(&str, &str); 3] = [("vertex", "v"), ("texture coordinate", "vt"), ("normal", "vn")];

impl ObjText {
    /// Validates and rewrites `bytes`, the content of `file`.
    pub fn check(file: &Path, bytes: &[u8]) -> Result<Self, SceneError> {
        if bytes.contains(&0) {
            return Err(SceneError::invalid(
                file,
                None,
                "is a binary file, not a Wavefront OBJ; export the model as text .obj",
            ));
        }
        // Comments and material names of old exporters are often Latin-1, so decode leniently.
        let text = String::from_utf8_lossy(bytes);
        let mut scan = Scan {
            file,
            out: Self::default(),
            positions: Vec::new(),
            totals: [0; 3],
            preceding: [0; 3],
            layout: None,
        };
        for (line, statement) in statements(&text) {
            scan.vertex_statement(line, &statement)?;
        }
        for (line, statement) in statements(&text) {
            scan.face_statement(line, &statement)?;
        }
        if scan.layout.is_none() {
            let vertices = scan.positions.len();
            return Err(SceneError::invalid(
                file,
                None,
                format!(
                    "has no triangles ({vertices} vertices, no faces); export a model with faces as .obj"
                ),
            ));
        }
        Ok(scan.out)
    }
}

/// Splits into numbered lines, joining lines that end in a backslash.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let mut statement = Cow::Borrowed(line.trim());
        while let Some(head) = statement.strip_suffix('\\') {
            let tail = lines.next().map_or("", |(_, line)| line.trim());
            statement = Cow::Owned(format!("{head} {tail}"));
        }
        Some((number + 1, statement))
    })
}

/// Keyword and the rest of a statement.
fn split(statement: &str) -> (&str, &str) {
    statement
        .split_once(char::is_whitespace)
        .map_or((statement, ""), |(keyword, rest)| (keyword, rest.trim()))
}

fn without_comment(rest: &str) -> &str {
    rest.split_once('#').map_or(rest, |(before, _)| before)
}

struct Scan<'a> {
    file: &'a Path,
    out: ObjText,
    positions: Vec<Vec3>,
    /// Number of v, vt and vn lines in the file.
    totals: [usize; 3],
    /// Number of them before the current line, for relative indices.
    preceding: [usize; 3],
    /// Whether the last face had texture coordinates and normals.
    layout: Option<[bool; 2]>,
}

impl Scan<'_> {
    fn error(&self, line: usize, problem: impl Into<String>) -> SceneError {
        SceneError::invalid(self.file, Some(line), problem)
    }

    fn numbers(&self, line: usize, statement: &str, least: usize) -> Result<Vec<f32>, SceneError> {
        let (_, rest) = split(statement);
        let numbers: Vec<f32> =
            without_comment(rest).split_whitespace().map_while(|word| word.parse().ok()).collect();
        if numbers.len() < least {
            let short: String = statement.chars().take(60).collect();
            return Err(
                self.error(line, format!("\"{short}\" needs {least} numbers; fix or re-export the model"))
            );
        }
        Ok(numbers)
    }

    /// First pass: `v`, `vt` and `vn`, since faces may precede the vertices that they reference.
    fn vertex_statement(&mut self, line: usize, statement: &str) -> Result<(), SceneError> {
        match split(statement).0 {
            "v" => self.position(line, statement),
            "vt" => {
                let n = self.numbers(line, statement, 1)?;
                let v = n.get(1).copied().unwrap_or(0.0);
                if !n[0].is_finite() || !v.is_finite() {
                    return Err(
                        self.error(line, "texture coordinate is not finite; fix or re-export the model")
                    );
                }
                self.totals[1] += 1;
                // fmt::Write on a String cannot fail.
                let _ = writeln!(self.out.text, "vt {} {v}", n[0]);
                Ok(())
            }
            "vn" => {
                let n = self.numbers(line, statement, 3)?;
                // A zero normal counts as missing and is generated from the faces.
                let normal = Vec3::new(n[0], n[1], n[2]).try_normalize().unwrap_or(Vec3::ZERO);
                self.totals[2] += 1;
                let _ = writeln!(self.out.text, "vn {} {} {}", normal.x, normal.y, normal.z);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn position(&mut self, line: usize, statement: &str) -> Result<(), SceneError> {
        let n = self.numbers(line, statement, 3)?;
        // Four numbers are homogeneous coordinates; more include vertex colours, which are ignored.
        let w = if n.len() == 4 { n[3] } else { 1.0 };
        let position = Vec3::new(n[0], n[1], n[2]) / w;
        if !position.is_finite() {
            return Err(
                self.error(line, "vertex position is not a finite number; fix or re-export the model")
            );
        }
        if position.abs().max_element() > MAX_COORDINATE {
            return Err(self.error(
                line,
                format!("vertex position is beyond +-{MAX_COORDINATE:e}; scale the model down"),
            ));
        }
        self.totals[0] += 1;
        self.positions.push(position);
        let _ = writeln!(self.out.text, "v {} {} {}", position.x, position.y, position.z);
        Ok(())
    }

    /// Second pass: faces and materials.
    fn face_statement(&mut self, line: usize, statement: &str) -> Result<(), SceneError> {
        let (keyword, rest) = split(statement);
        match keyword {
            "v" => self.preceding[0] += 1,
            "vt" => self.preceding[1] += 1,
            "vn" => self.preceding[2] += 1,
            "f" | "fo" => return self.face(line, rest),
            "usemtl" if !rest.is_empty() => {
                if !self.out.materials.iter().any(|name| name == rest) {
                    self.out.materials.push(rest.to_owned());
                }
                let _ = writeln!(self.out.text, "usemtl {rest}");
            }
            "mtllib" if !rest.is_empty() => self.out.libraries.push(rest.to_owned()),
            _ => {}
        }
        Ok(())
    }

    fn face(&mut self, line: usize, rest: &str) -> Result<(), SceneError> {
        let words = without_comment(rest).split_whitespace();
        let corners = words.map(|word| self.corner(line, word)).collect::<Result<Vec<_>, _>>()?;
        if corners.len() < 3 {
            // Points and lines have no surface.
            return Ok(());
        }
        // Use only attributes that all corners have, and start a new object where they change.
        let layout = [1, 2].map(|list| corners.iter().all(|corner| corner.0[list].is_some()));
        if self.layout.replace(layout) != Some(layout) {
            self.out.text.push_str("o part\n");
        }
        let index = |corner: &Corner, list: usize| corner.0[list].map_or(0, |index| index + 1);
        let points: Vec<Vec3> = corners.iter().map(|corner| self.positions[index(corner, 0) - 1]).collect();
        for triangle in triangulate(&points) {
            self.out.text.push('f');
            for corner in triangle.map(|i| &corners[i]) {
                let [v, vt, vn] = [0, 1, 2].map(|list| index(corner, list));
                let _ = match layout {
                    [false, false] => write!(self.out.text, " {v}"),
                    [true, false] => write!(self.out.text, " {v}/{vt}"),
                    [false, true] => write!(self.out.text, " {v}//{vn}"),
                    [true, true] => write!(self.out.text, " {v}/{vt}/{vn}"),
                };
            }
            self.out.text.push('\n');
        }
        Ok(())
    }

    fn corner(&self, line: usize, word: &str) -> Result<Corner, SceneError> {
        let mut corner = Corner([None; 3]);
        let parts = word.split('/').count();
        for (list, part) in word.split('/').enumerate() {
            if parts > 3 || (list == 0 && part.is_empty()) {
                return Err(self.error(
                    line,
                    format!("cannot read the face vertex \"{}\"; fix or re-export the model", clip(word)),
                ));
            }
            if !part.is_empty() {
                corner.0[list] = Some(self.index(line, list, part)?);
            }
        }
        Ok(corner)
    }

    fn index(&self, line: usize, list: usize, part: &str) -> Result<usize, SceneError> {
        let (name, keyword) = LISTS[list];
        let Ok(index) = part.parse::<i64>() else {
            return Err(self.error(
                line,
                format!("\"{}\" is not a {name} index; fix or re-export the model", clip(part)),
            ));
        };
        // Positive indices count from 1, negative ones backwards from the current line.
        let absolute = if index < 0 { index.saturating_add(self.preceding[list] as i64) } else { index - 1 };
        match usize::try_from(absolute) {
            Ok(found) if found < self.totals[list] => Ok(found),
            _ => Err(self.error(
                line,
                format!(
                    "face uses {name} {index}, but the file has {} ({keyword} lines); fix or re-export the model",
                    self.totals[list]
                ),
            )),
        }
    }
}

fn clip(word: &str) -> String {
    word.chars().take(40).collect()
}
