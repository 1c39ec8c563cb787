//! Reads an OBJ by the crate `tobj`, and adds what that lacks.
//!
//! In: the text of a file. Out: its vertices and faces, the material and smoothing group of each face, and the libraries that it
//! names; or an error with its line. `tobj` is given a text of one model without comments, in which all vertices have a colour
//! and all corners three indices. What is wrong with a vertex is an error only if a face uses it.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::fmt::Write;
use std::path::Path;

use glam::{Vec2, Vec3};

use crate::activity;
use crate::formats::error::SceneError;
use crate::scene::MAX_COORDINATE;

/// Names and keywords of the three index lists of a face.
const LISTS: [(&str, &str); 3] = [("vertex", "v"), ("texture coordinate", "vt"), ("normal", "vn")];

/// The texture coordinate and the normal of corners without any; they stand before those of the file.
const MISSING: &str = "vt 0 1\nvn 0 0 0\n";

/// After how many lines the progress is shown.
const SHOWN_LINES: usize = 100_000;

/// A line, and what is wrong with it.
type Fault = (usize, String);

/// What holds for a face.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Face {
    /// Index into [`Obj::materials`].
    pub material: Option<usize>,
    /// Smoothing group, 0 for none; nothing if the file has not said yet.
    pub smoothing: Option<u32>,
}

/// What a file says.
#[derive(Debug, Default)]
pub(super) struct Obj {
    /// Vertices and faces. Normals of no length are missing.
    pub mesh: tobj::Mesh,
    /// Whether any vertex has a colour (sRGB).
    pub is_coloured: bool,
    pub faces: Vec<Face>,
    /// Arguments of `mtllib` and of `usemtl`, the latter each once.
    pub libraries: Vec<String>,
    pub materials: Vec<String>,
    pub not_shown: BTreeSet<&'static str>,
}

impl Obj {
    /// Reads the text of `file`.
    pub fn read(file: &Path, text: &str) -> Result<Self, SceneError> {
        let mut totals = [0; 3];
        for (_, statement) in statements(text) {
            let list = LISTS.iter().position(|(_, keyword)| *keyword == parts(&statement).0);
            list.into_iter().for_each(|list| totals[list] += 1);
        }
        let mut reader = Reader::look(file, text, totals, HashMap::new())?;
        if !reader.faults.is_empty() {
            // A face may use a vertex of lines to come.
            reader = Reader::look(file, text, totals, reader.faults)?;
        }
        activity::begin(format!("{}: joining {} faces", file.display(), reader.obj.faces.len()));
        let options = tobj::LoadOptions { single_index: true, ..tobj::LoadOptions::default() };
        let no_library = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
        let (models, _) = tobj::load_obj_buf(&mut reader.text.as_bytes(), &options, no_library)
            .map_err(|why| SceneError::invalid(file, None, format!("{why}; fix or re-export the model")))?;
        let mesh = models.into_iter().next().map(|model| model.mesh);
        Ok(Self { mesh: mesh.unwrap_or_default(), ..reader.obj })
    }
}

/// The numbered statements of a text: its lines, with those joined that end in a backslash.
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

/// Keyword and arguments of a statement.
pub(super) fn parts(statement: &str) -> (&str, &str) {
    statement
        .split_once(char::is_whitespace)
        .map_or((statement, ""), |(keyword, rest)| (keyword, rest.trim()))
}

/// The words of a statement before its comment.
fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_once('#').map_or(rest, |(before, _)| before).split_whitespace()
}

/// A name before its comment, which is behind a blank: names may have a `#`, too.
pub(super) fn without_comment(name: &str) -> &str {
    let comment = name.char_indices().zip(name.chars().skip(1));
    let start = comment.into_iter().find(|((_, blank), mark)| blank.is_whitespace() && *mark == '#');
    start.map_or(name, |((at, _), _)| name[..at].trim_end())
}

/// The numbers that a statement begins with: how many, as they are written, and their values; 0 where there is none.
fn numbers<const N: usize>(rest: &str) -> (usize, [&str; N], [f32; N]) {
    let (mut written, mut values) = (["0"; N], [0.0; N]);
    let given = words(rest).map_while(|word| Some((word, word.parse().ok()?)));
    let places = written.iter_mut().zip(&mut values);
    let count = places.zip(given).map(|((word, value), given)| (*word, *value) = given).count();
    (count, written, values)
}

/// Looks at the lines of a file.
struct Reader {
    obj: Obj,
    /// What `tobj` is given.
    text: String,
    /// Lengths of the lists in the whole file, and up to here.
    totals: [usize; 3],
    counts: [usize; 3],
    /// What is wrong with vertices, by list and index.
    faults: HashMap<(usize, usize), Fault>,
    /// What holds for the next face.
    face: Face,
    known: HashMap<String, usize>,
}

impl Reader {
    /// Reads all lines; `faults` are those known from an earlier look.
    fn look(
        file: &Path,
        text: &str,
        totals: [usize; 3],
        faults: HashMap<(usize, usize), Fault>,
    ) -> Result<Self, SceneError> {
        let mut written = String::with_capacity(text.len() + text.len() / 4);
        written += MISSING;
        let (obj, face) = (Obj::default(), Face::default());
        let mut reader =
            Self { obj, text: written, totals, counts: [0; 3], faults, face, known: HashMap::new() };
        for (line, statement) in statements(text) {
            if line.is_multiple_of(SHOWN_LINES) {
                let millions = line as f32 * 1e-6;
                activity::begin(format!("reading {}: {millions:.1} million lines", file.display()));
            }
            let (keyword, rest) = parts(&statement);
            reader.add(line, keyword, rest).map_err(|(line, problem)| {
                let problem = format!("{problem}; fix or re-export the model");
                SceneError::invalid(file, Some(line), problem)
            })?;
        }
        Ok(reader)
    }

    fn add(&mut self, line: usize, keyword: &str, rest: &str) -> Result<(), Fault> {
        match keyword {
            "v" => self.add_position(line, rest),
            "vt" => {
                let (count, [u, v], values) = numbers::<2>(rest);
                self.text.extend(["vt ", u, " ", v, "\n"]);
                let is_usable = count > 0 && Vec2::from_array(values).is_finite();
                let fault = (!is_usable).then(|| "texture coordinate is not finite".to_owned());
                self.end_vertex(1, line, fault);
            }
            "vn" => {
                // What is no normal counts as missing.
                let (count, [x, y, z], _) = numbers::<3>(rest);
                let [x, y, z] = if count == 3 { [x, y, z] } else { ["0"; 3] };
                self.text.extend(["vn ", x, " ", y, " ", z, "\n"]);
                self.end_vertex(2, line, None);
            }
            "f" | "fo" => return self.add_face(line, rest),
            "usemtl" if !rest.is_empty() => {
                let next = self.obj.materials.len();
                let index = *self.known.entry(rest.to_owned()).or_insert(next);
                if index == next {
                    self.obj.materials.push(rest.to_owned());
                }
                self.face.material = Some(index);
            }
            "mtllib" if !rest.is_empty() => self.obj.libraries.push(rest.to_owned()),
            "s" => {
                let group = words(rest).next().unwrap_or("off");
                let number = if group == "off" { Some(0) } else { group.parse().ok() };
                self.face.smoothing = number.or(self.face.smoothing);
            }
            "l" => _ = self.obj.not_shown.insert("lines"),
            "p" => _ = self.obj.not_shown.insert("points"),
            "curv" | "curv2" | "surf" => _ = self.obj.not_shown.insert("curves and curved surfaces"),
            _ => {}
        }
        Ok(())
    }

    fn add_position(&mut self, line: usize, rest: &str) {
        let (count, written, [x, y, z, w, ..]) = numbers::<7>(rest);
        // Four numbers are homogeneous coordinates; from six on the last ones are a colour.
        let position = Vec3::new(x, y, z) / if count == 4 { w } else { 1.0 };
        if count == 4 {
            let [x, y, z] = position.to_array();
            _ = write!(self.text, "v {x} {y} {z}");
        } else {
            self.text.extend(["v ", written[0], " ", written[1], " ", written[2]]);
        }
        self.obj.is_coloured |= count >= 6;
        let colour = match count {
            6 => &written[3..6],
            7 => &written[4..],
            _ => &["1"; 3],
        };
        self.text.extend([" ", colour[0], " ", colour[1], " ", colour[2], "\n"]);
        let fault = if count < 3 {
            Some(format!("\"{}\" needs 3 numbers", clip(&format!("v {rest}"))))
        } else if !position.is_finite() {
            Some("vertex position is not a finite number".to_owned())
        } else if position.abs().max_element() > MAX_COORDINATE {
            Some(format!("vertex position is beyond +-{MAX_COORDINATE:e}; scale the model down"))
        } else {
            None
        };
        self.end_vertex(0, line, fault);
    }

    /// Ends an entry of a list, which may have a fault.
    fn end_vertex(&mut self, list: usize, line: usize, fault: Option<String>) {
        if let Some(problem) = fault {
            self.faults.insert((list, self.counts[list]), (line, problem));
        }
        self.counts[list] += 1;
    }

    /// Adds a face of three corners or more.
    fn add_face(&mut self, line: usize, rest: &str) -> Result<(), Fault> {
        if words(rest).nth(2).is_none() {
            return Ok(());
        }
        self.text.push('f');
        words(rest).try_for_each(|word| self.add_corner(line, word))?;
        self.text.push('\n');
        self.obj.faces.push(self.face);
        Ok(())
    }

    /// Adds a corner, such as `3/1/2`. Positive indices may be those of lines to come.
    fn add_corner(&mut self, line: usize, word: &str) -> Result<(), Fault> {
        if word.split('/').count() > LISTS.len() || word.starts_with('/') {
            return Err((line, format!("cannot read the face vertex \"{}\"", clip(word))));
        }
        let mut indices = word.split('/');
        for (list, (name, keyword)) in LISTS.into_iter().enumerate() {
            let (index, total) = (indices.next().unwrap_or(""), self.totals[list]);
            // Some exporters write `f 1//1` without any normals.
            if list > 0 && (index.is_empty() || total == 0) {
                self.text += "/1";
                continue;
            }
            let Ok(given) = index.parse::<i64>() else {
                return Err((line, format!("\"{}\" is not a {name} index", clip(index))));
            };
            // Positive indices count from 1, negative ones backwards from the current line.
            let place = if given < 0 { given.saturating_add(self.counts[list] as i64) } else { given - 1 };
            let Some(place) = usize::try_from(place).ok().filter(|place| *place < total) else {
                let problem = format!("face uses {name} {given}, but the file has {total} ({keyword} lines)");
                return Err((line, problem));
            };
            if let Some(fault) = self.faults.get(&(list, place)) {
                return Err(fault.clone());
            }
            let (mark, first) = if list == 0 { (' ', 1) } else { ('/', 2) };
            _ = write!(self.text, "{mark}{}", place + first);
        }
        Ok(())
    }
}

fn clip(word: &str) -> String {
    word.chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_end_names_behind_a_blank() {
        for (name, expected) in [
            ("red paint", "red paint"),
            ("red # paint", "red"),
            ("mat#1", "mat#1"),
            ("é #b#c", "é"),
            ("#a", "#a"),
        ] {
            assert_eq!(without_comment(name), expected);
        }
    }
}
