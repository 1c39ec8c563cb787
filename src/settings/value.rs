//! The values of settings: how they are written and read, alike on the command line, in scene files and in reports.

use std::borrow::Cow;
use std::fmt::{Display, Formatter, Result as FormatResult};

use clap::ValueEnum;
use clap::builder::PossibleValue;
use toml::Value;

/// Most features of a fit by BMFR.
pub(super) const MOST_FEATURES: usize = 64;
/// Completes "must be".
const FEATURES_HELP: &str = "1 to 64 features with commas between, each a product of at most three of 1, nx, ny, nz, wx, wy, wz, d, r, ar, ag, ab, such as wx*wx, or their roots, such as sqrt(nx)";

/// Values that a setting accepts. `Display` completes the sentence "must be ...".
#[derive(Clone, Copy, Debug)]
pub(crate) enum Kind {
    /// A whole number.
    Whole { unit: &'static str, least: u32, most: u32 },
    /// A finite number; if `above`, `least` itself is too little.
    Number { unit: &'static str, least: f64, most: f64, above: bool },
    /// Seconds, from 0.
    Seconds { most: f64 },
    /// `auto`, or what this accepts.
    Auto(&'static Kind),
    /// Width and height, from 1.
    Size { most: u32 },
    /// Yes or no.
    Flag,
    /// Features of [`BmfrFeatures`](super::BmfrFeatures).
    Features,
    /// One of these.
    Choice(fn() -> Vec<PossibleValue>),
}

/// A whole number within a range.
pub(super) const fn whole(unit: &'static str, least: u32, most: u32) -> Kind {
    Kind::Whole { unit, least, most }
}

/// A number within a range.
pub(super) const fn number(unit: &'static str, least: f64, most: f64) -> Kind {
    Kind::Number { unit, least, most, above: false }
}

/// A number of at least 0.
pub(super) const fn at_least_0(unit: &'static str) -> Kind {
    number(unit, 0.0, f64::INFINITY)
}

/// A number above 0.
pub(super) const fn above_0(unit: &'static str) -> Kind {
    Kind::Number { unit, least: 0.0, most: f64::INFINITY, above: true }
}

/// One value of an enum.
pub(super) const fn choice<Choices: ValueEnum>() -> Kind {
    Kind::Choice(|| Choices::value_variants().iter().filter_map(ValueEnum::to_possible_value).collect())
}

impl Kind {
    /// Whether a value of the right type is in range.
    pub fn admits(&self, value: &Value) -> bool {
        let whole = |value: &Value| value.as_integer().unwrap_or(-1);
        let number = value.as_float().unwrap_or(f64::NAN);
        match *self {
            Self::Whole { least, most, .. } => (i64::from(least)..=i64::from(most)).contains(&whole(value)),
            Self::Number { least, most, above, .. } => {
                number.is_finite() && (least..=most).contains(&number) && !(above && number == least)
            }
            Self::Seconds { most } => (0.0..=most).contains(&number),
            Self::Auto(kind) => value.is_str() || kind.admits(value),
            Self::Size { most } => {
                let side = 1..=i64::from(most);
                value.as_array().is_some_and(|sides| sides.iter().map(whole).all(|at| side.contains(&at)))
            }
            Self::Flag | Self::Features | Self::Choice(_) => true,
        }
    }

    /// Placeholder of a value in the help of an option.
    pub fn unit(&self) -> Option<Cow<'static, str>> {
        Some(match *self {
            Self::Whole { unit, .. } | Self::Number { unit, .. } => unit.into(),
            Self::Seconds { .. } => "SECONDS".into(),
            Self::Auto(kind) => format!("{}|auto", kind.unit()?).into(),
            Self::Size { .. } => "WxH".into(),
            Self::Flag => "true|false".into(),
            Self::Features => "LIST".into(),
            Self::Choice(_) => return None,
        })
    }

    /// All values, where they are few.
    pub fn choices(&self) -> Vec<PossibleValue> {
        match self {
            Self::Flag => ["true", "false"].map(PossibleValue::new).into(),
            Self::Choice(choices) => choices(),
            _ => Vec::new(),
        }
    }
}

impl Kind {
    /// The range, where there is one.
    pub fn range(&self) -> Option<String> {
        match *self {
            Self::Whole { least: 0, most: u32::MAX, .. } | Self::Flag | Self::Choice(_) => None,
            Self::Features => Some(format!("1 to {MOST_FEATURES} of them")),
            Self::Whole { least, most: u32::MAX, .. } => Some(format!("at least {least}")),
            Self::Whole { least, most, .. } => Some(format!("{least} to {most}")),
            Self::Number { least, above: true, .. } => Some(format!("above {least}")),
            Self::Number { least, most: f64::INFINITY, .. } => Some(format!("at least {least}")),
            Self::Number { least, most, .. } => Some(format!("{least} to {most}")),
            Self::Seconds { most } => Some(format!("0 to {most:e}")),
            Self::Auto(kind) => kind.range(),
            Self::Size { most } => Some(format!("1x1 to {most}x{most}")),
        }
    }
}

impl Display for Kind {
    fn fmt(&self, text: &mut Formatter<'_>) -> FormatResult {
        let (what, example) = match self {
            Self::Whole { .. } => ("a whole number", ""),
            Self::Number { .. } => ("a number", ""),
            Self::Seconds { .. } => ("seconds", ", such as 1/60 or 0.02"),
            Self::Auto(kind) => return write!(text, "auto or {kind}"),
            Self::Size { .. } => ("a width and a height", ", such as 1280x720"),
            Self::Features => return write!(text, "{FEATURES_HELP}"),
            Self::Flag | Self::Choice(_) => {
                let choices = self.choices();
                let names: Vec<_> = choices.iter().map(PossibleValue::get_name).collect();
                return write!(text, "one of {}", names.join(", "));
            }
        };
        let range = self.range().map_or_else(String::new, |range| format!(", {range}"));
        write!(text, "{what}{range}{example}")
    }
}

/// The type of a setting.
pub(super) trait SettingType: Copy {
    /// Reads what [`text_of`] writes, and other ways to write it.
    fn read(text: &str) -> Option<Self>;
    /// The value in a scene file and in a report.
    fn value(self) -> Value;
}

impl SettingType for u32 {
    fn read(text: &str) -> Option<Self> {
        Self::try_from(read_whole(text)?).ok()
    }

    fn value(self) -> Value {
        i64::from(self).into()
    }
}

impl SettingType for f32 {
    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }

    /// The number with the fewest digits that is this one as `f32`.
    fn value(self) -> Value {
        self.to_string().parse().unwrap_or(f64::from(self)).into()
    }
}

impl SettingType for f64 {
    fn read(text: &str) -> Option<Self> {
        read_seconds(text)
    }

    fn value(self) -> Value {
        self.into()
    }
}

impl SettingType for bool {
    fn read(text: &str) -> Option<Self> {
        text.parse().ok()
    }

    fn value(self) -> Value {
        self.into()
    }
}

/// Width and height.
impl SettingType for [u32; 2] {
    fn read(text: &str) -> Option<Self> {
        let (width, height) = text.split_once(['x', 'X'])?;
        Some([width.parse().ok()?, height.parse().ok()?])
    }

    fn value(self) -> Value {
        self.map(i64::from).to_vec().into()
    }
}

/// A value, or none for auto.
impl<Value: SettingType> SettingType for Option<Value> {
    fn read(text: &str) -> Option<Self> {
        if text == "auto" { Some(None) } else { Value::read(text).map(Some) }
    }

    fn value(self) -> toml::Value {
        self.map_or_else(|| "auto".into(), SettingType::value)
    }
}

/// Makes enums with names for their values the types of settings.
macro_rules! choices {
    ($($choices:ty),+) => {$(
        impl $crate::settings::value::SettingType for $choices {
            fn read(text: &str) -> Option<Self> {
                <Self as clap::ValueEnum>::from_str(text, false).ok()
            }

            fn value(self) -> toml::Value {
                let choice = clap::ValueEnum::to_possible_value(&self);
                choice.map_or_else(String::new, |choice| choice.get_name().to_owned()).into()
            }
        }
    )+};
}
pub(super) use choices;

/// `2500`, `2.5e3` or `25e2` -> a whole number, if it is exactly one.
pub(crate) fn read_whole(text: &str) -> Option<u64> {
    let Some((digits, exponent)) = text.split_once(['e', 'E']) else { return text.parse().ok() };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let fraction = fraction.trim_end_matches('0');
    let zeros = exponent.parse::<u32>().ok()?.checked_sub(u32::try_from(fraction.len()).ok()?)?;
    let number: u64 = format!("{whole}{fraction}").parse().ok()?;
    number.checked_mul(10_u64.checked_pow(zeros)?)
}

/// `1/60` or `0.02` -> seconds.
pub(crate) fn read_seconds(text: &str) -> Option<f64> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    match text.split_once('/') {
        Some((numerator, denominator)) => Some(number(numerator)? / number(denominator)?),
        None => number(text),
    }
}

/// Seconds, as a fraction where that is shorter: `1/60`, `0.02`.
pub(super) fn text_of_seconds(seconds: f64) -> String {
    let decimal = seconds.to_string();
    let fraction = format!("1/{}", (1.0 / seconds).round());
    let is_exact = read_seconds(&fraction) == Some(seconds);
    if is_exact && fraction.len() < decimal.len() { fraction } else { decimal }
}

/// A value in the syntax of the command line.
pub(super) fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Float(number) => number.to_string(),
        // Names of features.
        Value::Array(names) if names.iter().all(Value::is_str) => {
            names.iter().filter_map(Value::as_str).collect::<Vec<_>>().join(",")
        }
        Value::Array(sides) if sides.len() == 2 => {
            sides.iter().map(ToString::to_string).collect::<Vec<_>>().join("x")
        }
        other => other.to_string(),
    }
}
