//! The statements of an OBJ: what tobj is given of them, and the line at which it fails.
//!
//! In: the text of a file. Out: the same without what tobj takes for something else or does not read (comments behind
//! numbers, continued lines, polylines, colours of some vertices); or the error of a file that it does not read, with its
//! line, since tobj's errors name neither line nor cause.

use std::borrow::Cow;
use std::path::Path;

use glam::Vec3;

use crate::formats::error::SceneError;
use crate::scene::MAX_COORDINATE;

/// Names and keywords of the three index lists of a face.
const LISTS: [(&str, &str); 3] = [("vertex", "v"), ("texture coordinate", "vt"), ("normal", "vn")];

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

/// Keyword and the rest of a statement.
fn split(statement: &str) -> (&str, &str) {
    statement
        .split_once(char::is_whitespace)
        .map_or((statement, ""), |(keyword, rest)| (keyword, rest.trim()))
}

/// The words of a statement before its comment.
fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_once('#').map_or(rest, |(before, _)| before).split_whitespace()
}

/// The statements that make meshes, libraries first. An `o` separates faces with different attributes, since tobj leaves out an
/// attribute that a vertex of an object lacks.
pub(super) fn of_meshes(text: &str) -> String {
    let (mut libraries, mut meshes) = (String::new(), String::with_capacity(text.len()));
    let mut attributes = None;
    for (_, statement) in statements(text) {
        let (keyword, rest) = split(&statement);
        let given: Vec<&str> = words(rest).collect();
        let mut add = |keyword: &str, words: &[&str]| {
            meshes.push_str(keyword);
            words.iter().for_each(|word| meshes.extend([" ", *word]));
            meshes.push('\n');
        };
        match (keyword, &given[..]) {
            // Four numbers are homogeneous coordinates; more include the colour, which is ignored.
            ("v", [_, _, _, _]) => add("v", &given),
            ("v" | "vn", all) => add(keyword, &all[..all.len().min(3)]),
            ("vt", [u]) => add("vt", &[*u, "0"]),
            ("vt", [u, v, ..]) => add("vt", &[*u, *v]),
            ("f" | "fo", [first, _, _, ..]) => {
                let of_face: Vec<bool> = first.split('/').skip(1).map(|index| !index.is_empty()).collect();
                if attributes.replace(of_face.clone()).is_some_and(|before| before != of_face) {
                    add("o", &[]);
                }
                add("f", &given);
            }
            ("usemtl", _) if !rest.is_empty() => add("usemtl", &[rest]),
            ("mtllib", _) if !rest.is_empty() => libraries.extend(["mtllib ", rest, "\n"]),
            _ => {}
        }
    }
    libraries + &meshes
}

/// The names after `usemtl` in the statements of [`of_meshes`], each once, in order of first use.
pub(super) fn materials_of(meshes: &str) -> Vec<&str> {
    let mut names = Vec::new();
    for name in meshes.lines().filter_map(|line| line.strip_prefix("usemtl ")) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names
}

/// The first error in the numbers of a file, with its line.
pub(super) fn error_in(file: &Path, text: &str) -> Option<SceneError> {
    let list_of = |keyword: &str| LISTS.iter().position(|(_, known)| *known == keyword);
    let mut totals = [0; 3];
    for list in statements(text).filter_map(|(_, statement)| list_of(split(&statement).0)) {
        totals[list] += 1;
    }
    // Negative indices count backwards from the current line.
    let mut preceding = [0; 3];
    statements(text).find_map(|(line, statement)| {
        let (keyword, rest) = split(&statement);
        let problem = match (keyword, list_of(keyword)) {
            (_, Some(list)) => {
                preceding[list] += 1;
                problem_of_numbers(&statement, list)
            }
            ("f" | "fo", _) => words(rest).find_map(|word| problem_of_corner(word, totals, preceding)),
            _ => None,
        }?;
        let problem = format!("{problem}; fix or re-export the model");
        Some(SceneError::invalid(file, Some(line), problem))
    })
}

/// What is wrong with a vertex, a texture coordinate or a normal.
fn problem_of_numbers(statement: &str, list: usize) -> Option<String> {
    let numbers: Vec<f32> = words(split(statement).1).map_while(|word| word.parse().ok()).collect();
    let least = [3, 1, 3][list];
    if numbers.len() < least {
        return Some(format!("\"{}\" needs {least} numbers", clip(statement)));
    }
    match (list, &numbers[..]) {
        (0, [x, y, z, rest @ ..]) => {
            let w = if let [w] = rest { *w } else { 1.0 };
            let position = Vec3::new(*x, *y, *z) / w;
            if !position.is_finite() {
                return Some("vertex position is not a finite number".to_owned());
            }
            let is_far = position.abs().max_element() > MAX_COORDINATE;
            is_far.then(|| format!("vertex position is beyond +-{MAX_COORDINATE:e}; scale the model down"))
        }
        (1, [u, rest @ ..]) if !(u + rest.first().unwrap_or(&0.0)).is_finite() => {
            Some("texture coordinate is not finite".to_owned())
        }
        _ => None,
    }
}

/// What is wrong with a corner of a face, such as `3/1/2`.
fn problem_of_corner(word: &str, totals: [usize; 3], preceding: [usize; 3]) -> Option<String> {
    if word.split('/').count() > LISTS.len() || word.starts_with('/') {
        return Some(format!("cannot read the face vertex \"{}\"", clip(word)));
    }
    let mut indices = word.split('/').enumerate().filter(|(_, index)| !index.is_empty());
    indices.find_map(|(list, index)| {
        let (name, keyword) = LISTS[list];
        let Ok(given) = index.parse::<i64>() else {
            return Some(format!("\"{}\" is not a {name} index", clip(index)));
        };
        // Positive indices count from 1.
        let place = if given < 0 { given.saturating_add(preceding[list] as i64) } else { given - 1 };
        let is_there = (0..totals[list] as i64).contains(&place);
        let total = totals[list];
        (!is_there).then(|| format!("face uses {name} {given}, but the file has {total} ({keyword} lines)"))
    })
}

fn clip(word: &str) -> String {
    word.chars().take(60).collect()
}
