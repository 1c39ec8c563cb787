//! What the files of a scene hold beside what is shown of them, for information.

use std::collections::BTreeSet;

/// What the files of a scene hold beside what is shown of them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileContents {
    /// Extensions of glTF that they use.
    pub extensions: BTreeSet<String>,
    /// Animations of a glTF file by name, or else by index; one of them is shown.
    pub animations: Vec<String>,
    /// Number of cameras; none: the camera is made up.
    pub cameras: usize,
}
