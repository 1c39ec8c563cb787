//! Axes: scales and ticks.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::text::{round_limit, short};

/// The scale of an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Linear.
    #[default]
    Linear,
    /// Linear, from 0.
    FromZero,
    /// Logarithmic; only positive values can be shown.
    Logarithmic,
}

/// An axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Label: the quantity and its unit.
    pub label: String,
    /// Scale.
    pub scale: Scale,
    /// Ticks: values with their labels; empty: automatic.
    pub ticks: Vec<(f64, String)>,
}

/// An axis with its range and ticks in axis coordinates.
#[derive(Clone, Debug)]
pub(super) struct Layout {
    scale: Scale,
    /// Ends, in axis coordinates.
    range: Range<f64>,
    /// Ticks, in axis coordinates, with their labels.
    ticks: Vec<(f64, String)>,
}

impl Axis {
    /// A linear axis.
    pub fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), ..Self::default() }
    }

    /// Fits the axis to `values`, with `margin` times their range at either end. Without values the range is a
    /// default.
    pub(super) fn layout(&self, values: impl Iterator<Item = f64>, margin: f64) -> Layout {
        let places = values.chain(self.ticks.iter().map(|(value, _)| *value));
        let places = places.map(|value| place(self.scale, value)).filter(|place| place.is_finite());
        let mut range = range(places, margin);
        if self.scale == Scale::FromZero {
            range = 0.0..range.end.max(f64::MIN_POSITIVE);
        }
        let ticks = if self.ticks.is_empty() {
            let values = match self.scale {
                Scale::Logarithmic => logarithmic_ticks(&range),
                Scale::Linear | Scale::FromZero => linear_ticks(&range),
            };
            values.into_iter().map(|value| (place(self.scale, value), short(value))).collect()
        } else {
            self.ticks.iter().map(|(value, text)| (place(self.scale, *value), text.clone())).collect()
        };
        Layout { scale: self.scale, range, ticks }
    }

    /// A categorical axis with `labels` at 0, 1, 2, ...
    pub(super) fn side_by_side<'a>(labels: impl Iterator<Item = &'a str>) -> Layout {
        let ticks: Vec<_> =
            labels.enumerate().map(|(place, label)| (place as f64, label.to_owned())).collect();
        Layout { scale: Scale::Linear, range: -0.6..ticks.len().max(1) as f64 - 0.4, ticks }
    }
}

impl Layout {
    /// A value in axis coordinates; not finite if it cannot be shown.
    pub fn place(&self, value: f64) -> f64 {
        place(self.scale, value)
    }
}

impl Ranged for Layout {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, place: &f64, (first, last): (i32, i32)) -> i32 {
        let share = (place - self.range.start) / (self.range.end - self.range.start);
        first + (f64::from(last - first) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|(place, _)| *place).collect()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Layout {
    fn format(place: &f64) -> String {
        short(*place)
    }

    fn format_ext(&self, place: &f64) -> String {
        let distance = |tick: &(f64, String)| (tick.0 - place).abs();
        let nearest = self.ticks.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map(|(_, text)| text.clone()).unwrap_or_default()
    }
}

fn place(scale: Scale, value: f64) -> f64 {
    match scale {
        Scale::Linear | Scale::FromZero => value,
        Scale::Logarithmic => value.log10(),
    }
}

/// The range of `values`, extended by `margin` times its size at either end; never empty.
fn range(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let ends = values.fold(None, |ends: Option<(f64, f64)>, value| {
        Some(ends.map_or((value, value), |(least, greatest)| (least.min(value), greatest.max(value))))
    });
    match ends {
        None => 0.0..1.0,
        Some((least, greatest)) if least == greatest => {
            let half = if least == 0.0 { 0.5 } else { 0.05 * least.abs() };
            least - half..least + half
        }
        Some((least, greatest)) => {
            // Do not magnify differences that the labels cannot resolve.
            let middle = 0.5 * least + 0.5 * greatest;
            let half = (0.5 * greatest - 0.5 * least) * (1.0 + 2.0 * margin);
            let half = half.max(1.0e-6 * middle.abs());
            middle - half..middle + half
        }
    }
}

/// About five round ticks.
fn linear_ticks(range: &Range<f64>) -> Vec<f64> {
    let step = round_limit((range.end - range.start) / 6.0);
    let (first, last) = ((range.start / step).ceil(), (range.end / step).floor());
    let count = (last - first).clamp(0.0, 20.0) as u32;
    (0..=count).map(|i| (first + f64::from(i)) * step).filter(|tick| *tick <= range.end).collect()
}

/// Powers of ten, and up to three decades also 2 and 5 times these.
fn logarithmic_ticks(range: &Range<f64>) -> Vec<f64> {
    let steps: &[f64] = if range.end - range.start > 3.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
    let powers = range.start.floor() as i32..=range.end.ceil() as i32;
    let values = powers.flat_map(|power| steps.iter().map(move |step| step * 10f64.powi(power)));
    values.filter(|value| range.contains(&value.log10())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_hold_their_values() {
        assert_eq!(range([].into_iter(), 0.1), 0.0..1.0);
        assert_eq!(range([0.0; 3].into_iter(), 0.1), -0.5..0.5);
        assert_eq!(range([20.0].into_iter(), 0.1), 19.0..21.0);
        assert_eq!(range([3.0, -1.0, 1.0].into_iter(), 0.0), -1.0..3.0);
        assert_eq!(range([0.0, 8.0].into_iter(), 0.25), -2.0..10.0);
    }

    #[test]
    fn ticks_are_round_and_within_the_range() {
        assert_eq!(linear_ticks(&(0.0..10.0)), [0.0, 2.0, 4.0, 6.0, 8.0, 10.0]);
        assert_eq!(linear_ticks(&(-0.3..0.31)).len(), 3);
        assert_eq!(logarithmic_ticks(&(0.9..2.0)), [10.0, 20.0, 50.0]);
        assert_eq!(logarithmic_ticks(&(0.5..4.5)), [10.0, 100.0, 1000.0, 10_000.0]);
    }

    #[test]
    fn invalid_values_have_no_coordinate() {
        let axis = Axis { scale: Scale::Logarithmic, ..Axis::default() };
        let layout = axis.layout([0.0, 1.0, 100.0].into_iter(), 0.0);
        assert_eq!(layout.range, 0.0..2.0);
        assert!(!layout.place(0.0).is_finite());
        assert_eq!((layout.place(10.0), layout.format_ext(&1.02)), (1.0, "10".to_owned()));
    }
}
