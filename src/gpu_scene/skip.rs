//! The one mechanism by which a pass is skipped: it is, as a whole, where all its inputs are those of its last run.

/// Tells one content of a pass's outputs from the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Version(u64);

impl Version {
    /// The next one.
    pub fn next(self) -> Self {
        Self(self.0 + 1)
    }
}

/// The inputs of a pass's last run, by value or by the [`Version`] of what they hold.
pub struct LastInputs<Inputs> {
    inputs: Option<Inputs>,
    version: Version,
}

impl<Inputs> Default for LastInputs<Inputs> {
    /// The pass has not run yet.
    fn default() -> Self {
        Self { inputs: None, version: Version::default() }
    }
}

impl<Inputs: PartialEq> LastInputs<Inputs> {
    /// Whether the pass has to run since its inputs differ from those of its last run. If so, its outputs have another
    /// version from now on.
    pub fn differ(&mut self, inputs: Inputs) -> bool {
        let differ = self.inputs.as_ref() != Some(&inputs);
        if differ {
            self.inputs = Some(inputs);
            self.version = self.version.next();
        }
        differ
    }

    /// The inputs of the last run.
    pub fn inputs(&self) -> Option<&Inputs> {
        self.inputs.as_ref()
    }

    /// The version of the pass's outputs.
    pub fn version(&self) -> Version {
        self.version
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_runs_where_an_input_differs() {
        let mut last = LastInputs::default();
        assert!(last.differ((1, Version(7))), "it has not run yet");
        let version = last.version();
        assert!(!last.differ((1, Version(7))));
        assert_eq!(last.version(), version);
        assert!(last.differ((1, Version(8))));
        assert_ne!(last.version(), version);
        assert!(last.differ((1, Version(7))), "only the last run counts");
    }
}
