//! A setting is declared once, by the macro `settings!` of this file: its key, type, default, range and help make the field
//! of a struct, the option of the command line, the key of a scene file and of reports, the row of the window's panel and
//! the line of docs/OPTIONS.md.

use super::value::{Kind, text_of, text_of_seconds};
use super::{PRESET, Settings};

/// A setting.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Setting {
    /// Key in scene files and reports; with `-` for `_` its option.
    pub key: &'static str,
    /// Type and range of its values.
    pub kind: Kind,
    /// Whether the window's panel may change it.
    pub live: bool,
    pub(super) documentation: &'static str,
    pub(super) read: fn(&mut Settings, &str) -> bool,
    pub(super) value: fn(&Settings) -> toml::Value,
}

/// The settings of a method, or those that all share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    /// Table in a scene file: `settings` or `settings.vpls`.
    pub table: &'static str,
    /// Title in help and panel.
    pub title: &'static str,
    /// Settings, in order.
    pub settings: &'static [Setting],
    /// Whether they have an effect.
    pub in_use: fn(&Settings) -> bool,
    /// Values that do not go together.
    pub(super) conflict: fn(&Settings) -> Option<Conflict>,
}

/// Two settings whose values do not go together.
pub(super) struct Conflict {
    /// Keys.
    pub keys: [&'static str; 2],
    /// One line that names both.
    pub message: String,
}

impl Setting {
    /// The name of its option, without the dashes.
    pub fn option(&self) -> String {
        self.key.replace('_', "-")
    }

    /// Effect and cost, and its range; without a full stop at the end.
    pub fn help(&self) -> String {
        let text = self.documentation.trim().trim_end_matches('.');
        self.kind.range().map_or_else(|| text.to_owned(), |range| format!("{text} [{range}]"))
    }

    /// Help of this setting and of each of its values.
    pub fn full_help(&self) -> String {
        let values = self
            .kind
            .choices()
            .into_iter()
            .filter_map(|choice| Some(format!(". {}: {}", choice.get_name(), choice.get_help()?)));
        self.help() + &values.collect::<String>()
    }

    /// Value of this setting in `settings`.
    pub fn value(&self, settings: &Settings) -> toml::Value {
        (self.value)(settings)
    }

    /// Value of this setting in `settings`, in the syntax of the command line.
    pub fn text(&self, settings: &Settings) -> String {
        let value = self.value(settings);
        match (self.kind, value.as_float()) {
            (Kind::Seconds { .. }, Some(seconds)) => text_of_seconds(seconds),
            _ => text_of(&value),
        }
    }

    /// Sets it to a value in the syntax of the command line.
    ///
    /// # Errors
    /// What is allowed, if the value cannot be read or is out of range.
    pub fn set(&self, settings: &mut Settings, text: &str) -> Result<(), String> {
        let mut changed = settings.clone();
        if !(self.read)(&mut changed, text) || !self.kind.admits(&self.value(&changed)) {
            return Err(format!("must be {}", self.kind));
        }
        *settings = if self.key == PRESET { changed.with_preset(changed.preset) } else { changed };
        Ok(())
    }
}

/// Declares a group of settings: the struct, its defaults, and its descriptors. The shared settings have the other groups as
/// fields.
macro_rules! settings {
    (
        $(#[doc = $about:literal])+
        struct $name:ident $(: $derived:ident)?, table $table:literal, $title:literal;
        at $settings:ident => $place:expr;
        used if $in_use:expr;
        $(conflict $conflict:expr;)?
        $(
            $(#[doc = $help:literal])+
            $key:literal $field:ident: $type:ty = $default:expr, $kind:expr $(, $fixed:ident)?;
        )+
        $(
            groups {$(
                $(#[doc = $group_about:literal])+
                $group:ident: $group_type:ty,
            )+}
        )?
    ) => {
        $(#[doc = $about])+
        #[derive(Clone, $($derived,)? Debug, PartialEq)]
        pub struct $name {
            $(
                $(#[doc = $help])+
                pub $field: $type,
            )+
            $($(
                $(#[doc = $group_about])+
                pub $group: $group_type,
            )+)?
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default,)+ $($($group: Default::default(),)+)? }
            }
        }

        impl $name {
            /// The descriptors of the settings.
            pub(crate) const GROUP: $crate::settings::Group = $crate::settings::Group {
                table: $table,
                title: $title,
                in_use: $in_use,
                conflict: $crate::settings::setting::settings!(@conflict $($conflict)?),
                settings: &[$($crate::settings::Setting {
                    key: $key,
                    kind: $kind,
                    live: $crate::settings::setting::settings!(@live $($fixed)?),
                    documentation: concat!($($help),+),
                    read: |$settings, text| {
                        let read = <$type as $crate::settings::value::SettingType>::read(text);
                        read.map(|value| $place.$field = value).is_some()
                    },
                    value: |$settings| $crate::settings::value::SettingType::value($place.$field),
                }),+],
            };
        }
    };
    (@conflict) => { |_| None };
    (@conflict $conflict:expr) => { $conflict };
    (@live) => { true };
    (@live fixed) => { false };
}
pub(super) use settings;
