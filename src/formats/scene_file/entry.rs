//! Checks of the values of a scene file, and where a wrong one is.

use std::ops::Range;
use std::path::Path;

use glam::Vec3;

use crate::formats::error::SceneError;
use crate::scene::MAX_COORDINATE;

/// A table of the file, as error messages name it.
#[derive(Clone, Debug)]
pub(crate) struct Entry<'a> {
    path: &'a Path,
    text: &'a str,
    at: At,
    /// Whether it is the animation of the table there.
    is_animation: bool,
    /// Type and name, such as `light "sun"`.
    what: String,
}

/// Where a table is in its file.
#[derive(Clone, Copy, Debug)]
pub(crate) enum At {
    /// The whole file.
    File,
    /// The table of this key.
    Table(&'static str),
    /// An entry of an array of tables.
    Entry(&'static str, usize),
}

impl<'a> Entry<'a> {
    /// A table of the file at `path`, whose content is `text`. `what` is its type and name, such as `light "sun"`.
    pub fn new(path: &'a Path, text: &'a str, at: At, what: impl Into<String>) -> Self {
        Self { path, text, at, is_animation: false, what: what.into() }
    }

    /// A table that is edited, and may be in no file yet.
    pub fn edited(path: &'a Path, what: impl Into<String>) -> Self {
        Self::new(path, "", At::File, what)
    }

    /// The animation of this table.
    pub fn animation(&self) -> Self {
        Self { is_animation: true, what: format!("{}: animation", self.what), ..self.clone() }
    }

    /// Looks for the line in the text, which is parsed again for that.
    fn line(&self) -> Option<usize> {
        let document = toml_edit::Document::parse(self.text).ok().filter(|_| !self.text.is_empty())?;
        let table = match self.at {
            At::File => return Some(1),
            At::Table(key) => document.as_item().get(key)?,
            At::Entry(key, index) => document.as_item().get(key)?.get(index)?,
        };
        let table = if self.is_animation { table.get("animation")? } else { table };
        Some(line_of(self.text, &table.span()?))
    }

    /// An error about this table.
    pub fn error(&self, problem: impl AsRef<str>) -> SceneError {
        SceneError::invalid(self.path, self.line(), format!("{}: {}", self.what, problem.as_ref()))
    }

    /// A vector; must be finite.
    pub fn vector(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let vector = Vec3::from_array(value);
        if vector.is_finite() {
            Ok(vector)
        } else {
            Err(self.error(format!("{key} must be finite, is {vector}")))
        }
    }

    /// A point or size in scene units; must be finite and within [`MAX_COORDINATE`].
    pub fn place(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let place = self.vector(key, value)?;
        if place.abs().max_element() > MAX_COORDINATE {
            return Err(self.error(format!("{key} must lie within +-{MAX_COORDINATE:e}, is {place}")));
        }
        Ok(place)
    }

    /// A number; must be finite.
    pub fn number(&self, key: &str, value: f32) -> Result<f32, SceneError> {
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.error(format!("{key} must be finite, is {value}")))
        }
    }

    /// A colour; must be finite and not negative.
    pub fn power(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let colour = self.vector(key, value)?;
        if colour.min_element() < 0.0 {
            return Err(self.error(format!("{key} must not be negative, is {colour}")));
        }
        Ok(colour)
    }

    /// A number from 0 to 1.
    pub fn share(&self, key: &str, value: f32) -> Result<f32, SceneError> {
        let share = self.number(key, value)?;
        let fits = (0.0..=1.0).contains(&share);
        if fits { Ok(share) } else { Err(self.error(format!("{key} must be from 0 to 1, is {share}"))) }
    }

    /// A colour; each channel must be from 0 to 1.
    pub fn reflectance(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let colour = self.power(key, value)?;
        let fits = colour.max_element() <= 1.0;
        if fits { Ok(colour) } else { Err(self.error(format!("{key} must not be above 1, is {colour}"))) }
    }

    /// A direction, normalised; must be finite and not zero.
    pub fn direction(&self, key: &str, value: [f32; 3]) -> Result<Vec3, SceneError> {
        let vector = self.vector(key, value)?.as_dvec3();
        let unit = vector.try_normalize();
        unit.map(|unit| unit.as_vec3()).ok_or_else(|| self.error(format!("{key} must not be zero")))
    }

    /// The value of a required key.
    pub fn required<T>(&self, key: &str, value: Option<T>) -> Result<T, SceneError> {
        value.ok_or_else(|| self.error(format!("the key {key} is missing")))
    }
}

/// The line, from 1, where `span` starts.
pub(super) fn line_of(text: &str, span: &Range<usize>) -> usize {
    let before = text.as_bytes().iter().take(span.start);
    1 + before.filter(|byte| **byte == b'\n').count()
}

/// Degrees that convert back to exactly these radians, if such exist.
pub(crate) fn degrees_of(radians: f32) -> f32 {
    let near = radians.to_degrees();
    let neighbours = [near, near.next_up(), near.next_down()];
    neighbours.into_iter().find(|degrees| degrees.to_radians() == radians).unwrap_or(near)
}
