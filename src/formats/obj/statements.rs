//! The statements of an OBJ.
//!
//! In: the text of a file. Out: its lists of vertices, its faces, the libraries and materials that it names; or an error with
//! its line. What is wrong with a vertex is an error only if a face uses it.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use glam::{Vec2, Vec3};

use crate::activity;
use crate::formats::error::SceneError;
use crate::scene::MAX_COORDINATE;

/// Names and keywords of the three index lists of a face.
const LISTS: [(&str, &str); 3] = [("vertex", "v"), ("texture coordinate", "vt"), ("normal", "vn")];

/// After how many lines the progress is shown.
const SHOWN_LINES: usize = 100_000;

/// The index of what a corner does not have.
pub(super) const NONE: u32 = u32::MAX;

/// A face: its corners, up to those of the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    pub first_corner: usize,
    /// Index into [`Statements::materials`], or [`NONE`].
    pub material: u32,
    /// Smoothing group, 0 for none; nothing if the file has not said yet.
    pub smoothing: Option<u32>,
    line: usize,
}

/// What a file says.
#[derive(Debug, Default)]
pub(super) struct Statements {
    pub positions: Vec<Vec3>,
    /// sRGB, one a position; empty if none has one.
    pub colours: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub normals: Vec<Vec3>,
    pub faces: Vec<Face>,
    /// Indices of position, texture coordinate and normal.
    pub corners: Vec<[u32; 3]>,
    /// Arguments of `mtllib` and of `usemtl`, the latter each once.
    pub libraries: Vec<String>,
    pub materials: Vec<String>,
    pub not_shown: BTreeSet<&'static str>,
    /// Line and fault of vertices, by list and index.
    faults: HashMap<(usize, u32), (usize, String)>,
}

/// What holds for the next faces.
#[derive(Default)]
struct State {
    material: Option<u32>,
    smoothing: Option<u32>,
    known: HashMap<String, u32>,
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

impl Statements {
    /// Reads the text of `file`.
    pub fn read(file: &Path, text: &str) -> Result<Self, SceneError> {
        let (mut read, mut state) = (Self::default(), State::default());
        for (line, statement) in statements(text) {
            if line.is_multiple_of(SHOWN_LINES) {
                let millions = line as f32 * 1e-6;
                activity::begin(format!("reading {}: {millions:.1} million lines", file.display()));
            }
            let (keyword, rest) = statement
                .split_once(char::is_whitespace)
                .map_or((&*statement, ""), |(keyword, rest)| (keyword, rest.trim()));
            read.add(line, keyword, rest, &mut state)
                .map_err(|problem| SceneError::invalid(file, Some(line), problem))?;
        }
        read.colours.resize(if read.colours.is_empty() { 0 } else { read.positions.len() }, Vec3::ONE);
        match read.fault() {
            Some((line, problem)) => {
                let problem = format!("{problem}; fix or re-export the model");
                Err(SceneError::invalid(file, Some(line), problem))
            }
            None => Ok(read),
        }
    }

    fn add(&mut self, line: usize, keyword: &str, rest: &str, state: &mut State) -> Result<(), String> {
        match keyword {
            "v" => self.add_vertex(line, rest),
            "vt" => {
                let [u, v] = self.numbers::<2>(1, 1, line, rest).0;
                if !(u + v).is_finite() {
                    self.fault_of_next(1, line, "texture coordinate is not finite".to_owned());
                }
                self.uvs.push(Vec2::new(u, v));
            }
            "vn" => {
                let normal = self.numbers::<3>(2, 3, line, rest).0;
                self.normals.push(Vec3::from_array(normal));
            }
            "f" | "fo" => return self.add_face(line, rest, state),
            "usemtl" if !rest.is_empty() => {
                let next = self.materials.len() as u32;
                let index = *state.known.entry(rest.to_owned()).or_insert(next);
                if index == next {
                    self.materials.push(rest.to_owned());
                }
                state.material = Some(index);
            }
            "mtllib" if !rest.is_empty() => self.libraries.push(rest.to_owned()),
            "s" => {
                let group = words(rest).next().unwrap_or("off");
                state.smoothing =
                    if group == "off" { Some(0) } else { group.parse().ok().or(state.smoothing) };
            }
            "l" => _ = self.not_shown.insert("lines"),
            "p" => _ = self.not_shown.insert("points"),
            "curv" | "curv2" | "surf" => _ = self.not_shown.insert("curves and curved surfaces"),
            _ => {}
        }
        Ok(())
    }

    fn add_vertex(&mut self, line: usize, rest: &str) {
        let (numbers, count) = self.numbers::<7>(0, 3, line, rest);
        let [x, y, z, w, r, g, b] = numbers;
        // Four numbers are homogeneous coordinates; from six on the last ones are a colour.
        let position = Vec3::new(x, y, z) / if count == 4 { w } else { 1.0 };
        if !position.is_finite() {
            self.fault_of_next(0, line, "vertex position is not a finite number".to_owned());
        } else if position.abs().max_element() > MAX_COORDINATE {
            let problem = format!("vertex position is beyond +-{MAX_COORDINATE:e}; scale the model down");
            self.fault_of_next(0, line, problem);
        }
        if count >= 6 {
            let colour = if count == 6 { Vec3::new(w, r, g) } else { Vec3::new(r, g, b) };
            self.colours.resize(self.positions.len(), Vec3::ONE);
            self.colours.push(if colour.is_finite() { colour.max(Vec3::ZERO) } else { Vec3::ONE });
        }
        self.positions.push(position);
    }

    /// The numbers of the next entry of a list, 0 where there is none, and how many there are, which should be `least`.
    fn numbers<const N: usize>(
        &mut self,
        list: usize,
        least: usize,
        line: usize,
        rest: &str,
    ) -> ([f32; N], usize) {
        let mut numbers = [0.0; N];
        let given = words(rest).map_while(|word| word.parse().ok());
        let count = numbers.iter_mut().zip(given).map(|(number, given)| *number = given).count();
        if count < least {
            let statement = clip(&format!("{} {rest}", LISTS[list].1));
            self.fault_of_next(list, line, format!("\"{statement}\" needs {least} numbers"));
        }
        (numbers, count)
    }

    fn fault_of_next(&mut self, list: usize, line: usize, problem: String) {
        self.faults.entry((list, self.totals()[list] as u32)).or_insert((line, problem));
    }

    fn totals(&self) -> [usize; 3] {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }

    fn add_face(&mut self, line: usize, rest: &str, state: &State) -> Result<(), String> {
        let first_corner = self.corners.len();
        for word in words(rest) {
            let corner =
                self.corner(word).map_err(|problem| format!("{problem}; fix or re-export the model"))?;
            self.corners.push(corner);
        }
        if self.corners.len() < first_corner + 3 {
            self.corners.truncate(first_corner);
            return Ok(());
        }
        let material = state.material.unwrap_or(NONE);
        self.faces.push(Face { first_corner, material, smoothing: state.smoothing, line });
        Ok(())
    }

    /// The indices of a corner, such as `3/1/2`. Positive ones may be those of lines to come.
    fn corner(&self, word: &str) -> Result<[u32; 3], String> {
        if word.split('/').count() > LISTS.len() || word.starts_with('/') {
            return Err(format!("cannot read the face vertex \"{}\"", clip(word)));
        }
        let mut corner = [NONE; 3];
        for (list, index) in word.split('/').enumerate().filter(|(_, index)| !index.is_empty()) {
            let (name, keyword) = LISTS[list];
            let Ok(given) = index.parse::<i64>() else {
                return Err(format!("\"{}\" is not a {name} index", clip(index)));
            };
            // Positive indices count from 1, negative ones backwards from the current line.
            let total = self.totals()[list];
            let place = if given < 0 { given.saturating_add(total as i64) } else { given - 1 };
            let place = u32::try_from(place).ok().filter(|&place| place != NONE);
            corner[list] = place.ok_or_else(|| {
                format!("face uses {name} {given}, but the file has {total} ({keyword} lines) up to there")
            })?;
        }
        Ok(corner)
    }

    /// The first thing wrong with what faces use, with its line.
    fn fault(&self) -> Option<(usize, String)> {
        let totals = self.totals();
        let is_good = |corner: &[u32; 3]| {
            (0..3).all(|list| corner[list] == NONE && list > 0 || (corner[list] as usize) < totals[list])
        };
        if self.faults.is_empty() && self.corners.iter().all(is_good) {
            return None;
        }
        self.faces.iter().zip(0..).find_map(|(face, index)| {
            self.corners_of(index).iter().flat_map(|corner| corner.iter().enumerate()).find_map(
                |(list, &place)| {
                    let (name, keyword) = LISTS[list];
                    let total = totals[list];
                    if place != NONE && place as usize >= total {
                        let given = u64::from(place) + 1;
                        let problem =
                            format!("face uses {name} {given}, but the file has {total} ({keyword} lines)");
                        return Some((face.line, problem));
                    }
                    self.faults.get(&(list, place)).cloned()
                },
            )
        })
    }

    /// The corners of a face.
    pub fn corners_of(&self, face: usize) -> &[[u32; 3]] {
        let end = self.faces.get(face + 1).map_or(self.corners.len(), |next| next.first_corner);
        &self.corners[self.faces[face].first_corner..end]
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
