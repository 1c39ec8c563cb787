//! Lists that code adds to while the program starts: methods, and the values of settings that name them.

use std::sync::{PoisonError, RwLock};

/// A list that grows and never shrinks.
pub(crate) struct Registry<Entry: 'static>(RwLock<&'static [Entry]>);

impl<Entry: Clone> Registry<Entry> {
    /// The list begins with these.
    pub const fn new(first: &'static [Entry]) -> Self {
        Self(RwLock::new(first))
    }

    /// The list as it is now.
    pub fn all(&self) -> &'static [Entry] {
        *self.0.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an entry.
    pub fn add(&self, entry: Entry) {
        let mut all = self.0.write().unwrap_or_else(PoisonError::into_inner);
        // Whoever has read the list keeps the old one, so it is never freed.
        *all = Vec::leak([*all, &[entry]].concat());
    }
}

/// Declares the type of a setting whose values are the names of methods, which register themselves.
macro_rules! registered {
    (
        $(#[doc = $about:literal])+
        struct $name:ident;
        $($(#[doc = $value_about:literal])+ $value:ident = $text:literal, $help:literal;)+
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, Copy, PartialEq, Eq)]
        pub struct $name {
            name: &'static str,
            help: &'static str,
        }

        const _: () = {
            static ALL: $crate::settings::Registry<$name> =
                $crate::settings::Registry::new(&[$($name::$value),+]);

            impl $name {
                $($(#[doc = $value_about])+ pub const $value: Self = Self::new($text, $help);)+

                /// A value, which is valid once its method has been registered.
                pub const fn new(name: &'static str, help: &'static str) -> Self {
                    Self { name, help }
                }

                /// The value on the command line and in files.
                pub const fn name(self) -> &'static str {
                    self.name
                }

                /// Adds a value: who registers its method calls it.
                pub(crate) fn add(self) {
                    ALL.add(self);
                }
            }

            impl clap::ValueEnum for $name {
                fn value_variants<'a>() -> &'a [Self] {
                    ALL.all()
                }

                fn to_possible_value(&self) -> Option<clap::builder::PossibleValue> {
                    Some(clap::builder::PossibleValue::new(self.name).help(self.help))
                }
            }

            impl std::fmt::Debug for $name {
                fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                    f.write_str(self.name)
                }
            }

            impl serde::Serialize for $name {
                fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                    serializer.serialize_str(self.name)
                }
            }
        };
    };
}
pub(super) use registered;
