//! The textual syntax of settings, on the command line, in scene files and in reports.

/// Parses a whole number.
pub(crate) fn parse_whole(text: &str) -> Result<u32, String> {
    text.parse().map_err(|_| format!("must be a whole number from 0 to {}", u32::MAX))
}

/// Parses a number; [`super::Settings::check`] checks its range.
pub(crate) fn parse_number(text: &str) -> Result<f32, String> {
    text.parse().map_err(|_| "must be a number such as 0.5".to_owned())
}

/// `1280x720` -> width and height.
pub(crate) fn parse_size(text: &str) -> Result<[u32; 2], String> {
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some([width.parse().ok()?, height.parse().ok()?]))
        .ok_or_else(|| "must be a width and a height such as 1280x720".to_owned())
}

/// `1/60` or `0.02` -> seconds.
pub(crate) fn parse_seconds(text: &str) -> Result<f64, String> {
    let parts: (Result<f64, _>, Result<f64, _>) = match text.split_once('/') {
        Some((numerator, denominator)) => (numerator.trim().parse(), denominator.trim().parse()),
        None => (text.parse(), Ok(1.0)),
    };
    match parts {
        (Ok(numerator), Ok(denominator)) => Ok(numerator / denominator),
        _ => Err("must be seconds such as 1/60 or 0.02".to_owned()),
    }
}

/// The same, from 0 to 1,000,000.
pub(crate) fn parse_time(text: &str) -> Result<f64, String> {
    let range = 0.0..=1e6;
    parse_seconds(text)
        .ok()
        .filter(|seconds| range.contains(seconds))
        .ok_or_else(|| "must be seconds from 0 to 1,000,000, such as 2.5".to_owned())
}

/// `auto` -> none, `-1.5` -> stops.
pub(crate) fn parse_exposure(text: &str) -> Result<Option<f32>, String> {
    match text {
        "auto" => Ok(None),
        stops => stops.parse().map(Some).map_err(|_| "must be auto or stops such as -1.5".to_owned()),
    }
}

/// Exposure as `"auto"` or a number of stops.
pub(super) fn exposure_or_auto<S>(exposure: &Option<f32>, serializer: S) -> Result<S::Ok, S::Error>
where
    S: serde::Serializer,
{
    match exposure {
        Some(stops) => serializer.serialize_f32(*stops),
        None => serializer.serialize_str("auto"),
    }
}
