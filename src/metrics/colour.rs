//! Colours: the sRGB transfer function (IEC 61966-2-1) and luminance.

/// One display channel in [0, 1] to linear light.
pub(super) fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.04045 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

/// One linear channel, clamped to [0, 1], to display values.
pub(super) fn linear_to_srgb(linear: f32) -> f32 {
    let linear = linear.clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Luminance of linear RGB (ITU-R BT.709); display luminance of display values (Flatval 2020).
pub(super) fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_transfer_function_matches_the_standard() {
        for (linear, encoded) in [(0.0, 0.0), (0.002, 0.025_84), (0.214_041_14, 0.5), (1.0, 1.0), (7.0, 1.0)]
        {
            assert!((linear_to_srgb(linear) - encoded).abs() < 1e-6, "{linear}");
        }
        assert!((srgb_to_linear(0.5) - 0.214_041_14).abs() < 1e-6);
        assert!((srgb_to_linear(0.025_84) - 0.002).abs() < 1e-8);
        assert_eq!(linear_to_srgb(-1.0), 0.0);
    }

    #[test]
    fn white_has_luminance_one() {
        assert!((luminance([1.0; 3]) - 1.0).abs() < 1e-12);
        assert!((luminance([0.0, 2.0, 0.0]) - 1.4304).abs() < 1e-9);
    }
}
