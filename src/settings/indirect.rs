//! The values of `--indirect`: names of the estimators, which register themselves in `estimators/mod.rs`.

use std::fmt;
use std::sync::{PoisonError, RwLock};

use clap::builder::PossibleValue;
use serde::{Serialize, Serializer};

/// What computes indirect light.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Indirect {
    name: &'static str,
    help: &'static str,
}

static ALL: RwLock<&[Indirect]> = RwLock::new(&[Indirect::VPLS, Indirect::NONE]);

impl Indirect {
    /// The default.
    pub const VPLS: Self = Self::new("vpls", "Virtual point lights: instant radiosity with temporal sets");
    /// No estimator.
    pub const NONE: Self = Self::new("none", "Nothing: direct light only");

    /// A value, which is valid once its estimator has been registered.
    pub const fn new(name: &'static str, help: &'static str) -> Self {
        Self { name, help }
    }

    /// The value on the command line and in files.
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// Adds a value: `estimators::register` calls it.
    pub(crate) fn add(self) {
        let mut all = ALL.write().unwrap_or_else(PoisonError::into_inner);
        // Whoever has read the list keeps the old one, so it is never freed.
        *all = Vec::leak([*all, &[self]].concat());
    }
}

impl Default for Indirect {
    fn default() -> Self {
        Self::VPLS
    }
}

impl fmt::Debug for Indirect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl Serialize for Indirect {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

impl clap::ValueEnum for Indirect {
    fn value_variants<'a>() -> &'a [Self] {
        *ALL.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name).help(self.help))
    }
}
