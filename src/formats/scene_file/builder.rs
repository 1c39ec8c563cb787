//! A scene under construction.

use std::collections::HashMap;
use std::path::Path;

use super::entry::{At, Entry};
use super::read_files::ReadFiles;
use crate::scene::Scene;

/// What has been built of a scene file so far.
pub(super) struct Builder<'a> {
    pub path: &'a Path,
    pub text: &'a str,
    pub assets: Option<&'a Path>,
    pub scene: Scene,
    /// Mesh of each model, by name.
    pub models: HashMap<String, usize>,
    /// Index of each instance, by name.
    pub instances: HashMap<String, usize>,
    /// What was read of files.
    pub read: ReadFiles,
}

impl<'a> Builder<'a> {
    /// Names a table for error messages.
    pub fn entry(&self, at: At, what: impl Into<String>) -> Entry<'a> {
        Entry::new(self.path, self.text, at, what)
    }
}
