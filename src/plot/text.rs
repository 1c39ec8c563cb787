//! The font of all text, and numbers as text.

use std::sync::Once;

use plotters::prelude::FontStyle;
use plotters::style::register_font;

/// Font family of all text.
pub(super) const FONT: &str = "sans-serif";

/// Registers the embedded font with the plotting library.
pub(super) fn prepare_font() {
    static PREPARED: Once = Once::new();
    PREPARED.call_once(|| {
        let known = register_font(FONT, FontStyle::Normal, include_bytes!("DejaVuSans-Latin.ttf"));
        assert!(known.is_ok(), "the font is part of the program");
    });
}

/// Formats a number with few digits: 0.012346, 12.346, 1.235e-7.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-4..6).contains(&exponent) {
        return format!("{value:.3e}");
    }
    let decimals = usize::try_from(4 - exponent).unwrap_or(0);
    let text = format!("{value:.decimals$}");
    if !text.contains('.') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Rounds `value` up to 1, 2 or 5 times a power of ten; 1 if it is not a positive number.
pub fn round_limit(value: f64) -> f64 {
    if !(value > 0.0 && value.is_finite()) {
        return 1.0;
    }
    let power = 10.0_f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0].map(|step| step * power).into_iter().find(|&step| step >= value).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (0.25, "0.25"),
            (0.012_345_67, "0.012346"),
            (12.345_67, "12.346"),
            (-12.345_67, "-12.346"),
            (100_000.0, "100000"),
            (1.234_567e-7, "1.235e-7"),
            (1.0e9, "1.000e9"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(value), text);
        }
    }
}
