//! Metrics of pictures small enough to check by hand; tests/metrics/ has larger ones.

use super::*;

fn linear(width: usize, pixels: &[[f32; 3]]) -> Image {
    Image::from_linear("a.exr", [width, pixels.len() / width], pixels.to_vec()).unwrap()
}

fn grey(width: usize, values: impl IntoIterator<Item = f32>) -> Image {
    linear(width, &values.into_iter().map(|value| [value; 3]).collect::<Vec<_>>())
}

fn metrics(image: &Image, reference: &Image) -> Metrics {
    compare(image, reference, &CompareOptions::default()).unwrap().metrics
}

#[track_caller]
fn assert_close(actual: f64, expected: f64) {
    assert!((actual - expected).abs() <= 1e-6 * expected.abs().max(1e-6), "{actual} is not {expected}");
}

#[test]
fn two_pixels_by_hand() {
    let image = linear(2, &[[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]]);
    let reference = linear(2, &[[1.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
    let metrics = metrics(&image, &reference);
    assert_close(metrics.mae, 4.0 / 6.0);
    assert_close(metrics.rmse, 1.0);
    assert_close(metrics.relmse, 1.0 / 1.01);
    // Display values differ in the last channel only, by 1.
    assert_close(metrics.psnr, 10.0 * 6.0_f64.log10());
    let (bright, blue) = (0.2126 + 2.0 * 0.7152 + 3.0 * 0.0722, 0.0722);
    assert_close(metrics.mean_ratio, bright / (1.0 + blue));
    assert_close(metrics.mean_relative_error, 0.5 * (bright - 1.0 + 1.0));
    assert_close(metrics.p95_relative_error, 1.0);
    assert_close(metrics.blocks.mean_relative_error, bright / (1.0 + blue) - 1.0);
    let absolute = pixel_errors(&image, &reference, PixelError::Absolute).unwrap();
    assert_eq!(absolute, [1.0, 1.0 / 3.0]);
    let relative = pixel_errors(&image, &reference, PixelError::Relative).unwrap();
    assert!((relative[0] - 0.8596).abs() < 1e-6 && relative[1] == 1.0);
}

#[test]
fn equal_pictures_have_perfect_metrics() {
    let values = || (0..400).map(|i| (i % 23) as f32 * 0.11);
    let display = Image::from_display("a.png", [20, 20], values().map(|v| [v / 3.0; 3]).collect()).unwrap();
    let black = grey(20, vec![0.0; 400]);
    for image in [grey(20, values()), display, black] {
        let metrics = metrics(&image, &image);
        assert_eq!([metrics.mae, metrics.rmse, metrics.relmse, metrics.flip], [0.0; 4]);
        assert_eq!([metrics.ssim, metrics.mean_ratio], [1.0; 2]);
        assert_eq!(metrics.psnr, f64::INFINITY);
        assert_eq!([metrics.mean_relative_error, metrics.p95_relative_error], [0.0; 2]);
        assert_eq!(metrics.blocks.within_3_percent, 1.0);
        let json = serde_json::to_value(metrics).unwrap();
        assert!(json["psnr"].is_null() && json["ssim"] == 1.0, "{json}");
    }
}

#[test]
fn errors_in_black_are_relative_to_a_hundredth_of_the_mean() {
    // The mean is 1, so the black pixel is measured against 0.01 and the dim one too.
    let reference = grey(4, [0.0, 0.005, 1.995, 2.0]);
    let image = grey(4, [0.002, 0.01, 1.995, 1.0]);
    let errors = pixel_errors(&image, &reference, PixelError::Relative).unwrap();
    for (error, expected) in errors.iter().zip([0.2, 0.5, 0.0, 0.5]) {
        assert!((error - expected).abs() < 1e-5, "{errors:?}");
    }
    let metrics = metrics(&grey(4, [0.1; 4]), &grey(4, [0.0; 4]));
    assert_eq!(
        [metrics.mean_ratio, metrics.mean_relative_error, metrics.p95_relative_error],
        [f64::INFINITY; 3]
    );
    assert_eq!(metrics.blocks.within_5_percent, 0.0);
    assert!(serde_json::to_value(metrics).unwrap()["mean_ratio"].is_null());
}

#[test]
fn blocks_at_the_border_are_smaller() {
    // Blocks of 2 x 2 in 5 x 3 pixels: 2 x 2, 2 x 2, 1 x 2 above, 2 x 1, 2 x 1, 1 x 1 below.
    let reference = grey(5, [1.0; 15]);
    let mut values = [1.0; 15];
    values[0] = 1.08;
    values[4] = 1.08;
    values[12] = 1.2;
    values[14] = 0.5;
    let options = CompareOptions { block_side: 2, ..CompareOptions::default() };
    let blocks = compare(&grey(5, values), &reference, &options).unwrap().metrics.blocks;
    assert_eq!((blocks.side, blocks.count), (2, 6));
    assert_close(blocks.mean_relative_error, (0.02 + 0.04 + 0.1 + 0.5) / 6.0);
    assert_close(blocks.p95_relative_error, 0.5);
    assert_close(blocks.within_3_percent, 3.0 / 6.0);
    assert_close(blocks.within_5_percent, 4.0 / 6.0);
}

#[test]
fn exposure_changes_psnr_and_ssim_of_linear_pictures_only() {
    let (image, reference) =
        (grey(20, (0..400).map(|i| i as f32 / 40.0)), grey(20, (0..400).map(|i| i as f32 / 50.0)));
    let at = |exposure: f32| {
        compare(&image, &reference, &CompareOptions { exposure, ..CompareOptions::default() })
            .unwrap()
            .metrics
    };
    let (dark, bright) = (at(-4.0), at(0.0));
    assert!(dark.psnr != bright.psnr && dark.ssim != bright.ssim);
    assert_eq!(Metrics { psnr: bright.psnr, ssim: bright.ssim, ..dark }, bright);
}

#[test]
fn pictures_of_different_size_or_encoding_are_rejected() {
    let picture = grey(4, [0.5; 8]);
    let wider = Image::from_linear("b.exr", [8, 1], vec![[0.5; 3]; 8]).unwrap();
    let error = compare(&picture, &wider, &CompareOptions::default()).unwrap_err().to_string();
    assert_eq!(error, "a.exr has 4x2 pixels, b.exr 8x1: pixel (4, 1) is in one only");
    let display = Image::from_display("b.png", [4, 2], vec![[0.5; 3]; 8]).unwrap();
    for (a, b) in [(&picture, &display), (&display, &picture)] {
        let error = compare(a, b, &CompareOptions::default()).unwrap_err().to_string();
        assert!(error.starts_with("b.png (PNG) holds display values, a.exr linear ones"), "{error}");
    }
}

#[test]
fn the_temporal_error_is_the_mean_change_of_luminance() {
    let frames = [[1.0, 1.0], [1.5, 0.75], [1.5, 0.75], [0.5, 0.75]].map(|values| grey(2, values));
    let changes = [0.375, 0.0, 0.5];
    assert_close(temporal_error(&frames).unwrap().unwrap(), changes.iter().sum::<f64>() / 3.0);
    assert_eq!(temporal_error(&frames[..1]).unwrap(), None);
    assert_eq!(temporal_error(&[frames[0].clone(), frames[0].clone()]).unwrap(), Some(0.0));
    assert!(temporal_error(&[grey(2, [1.0; 2]), grey(1, [1.0; 2])]).is_err());
}

#[test]
fn a_sequence_has_the_metrics_of_its_frames_and_their_means() {
    let reference = grey(2, [1.0, 1.0]);
    let frames = [[1.0, 2.0], [1.0, 1.5], [1.0, 1.0]].map(|values| grey(2, values));
    let mut sequence = Sequence::new(CompareOptions::default(), true);
    for (frame, image) in (5..).zip(&frames) {
        let comparison = sequence.push(frame, image, &reference).unwrap();
        assert_eq!(comparison.metrics, metrics(image, &reference));
    }
    let result = sequence.finish().unwrap();
    assert_eq!(result.frames.iter().map(|frame| frame.frame).collect::<Vec<_>>(), [5, 6, 7]);
    assert_close(result.means.mae, 0.25);
    assert_close(result.means.mean_ratio, 1.25);
    assert_eq!(result.means.psnr, f64::INFINITY);
    assert_eq!(result.frames[0].temporal_error, None);
    assert_close(result.frames[1].temporal_error.unwrap(), 0.25);
    assert_close(result.temporal_error.unwrap(), 0.25);
    assert_eq!(result.reference_temporal_error, None);
    assert_eq!(Sequence::new(CompareOptions::default(), true).finish(), None);
}

#[test]
fn display_luminance_is_that_of_encoded_values() {
    let frames = [[0.2, 0.8], [0.3, 0.6], [0.3, 0.6]].map(|values| {
        Image::from_display("a", [2, 1], values.map(|value| [value, value, 0.5]).into()).unwrap()
    });
    let mut sequence = Sequence::new(CompareOptions { luminance: true, ..CompareOptions::default() }, true);
    for (number, frame) in (0..).zip(&frames) {
        sequence.push(number, frame, &frames[1]).unwrap();
    }
    let result = sequence.finish().unwrap();
    // Red and green weigh 0.9278 together.
    assert!((result.luminance_temporal_error.unwrap() - 0.9278 * 0.15 / 2.0).abs() < 1e-6);
    let first = result.frames[0].metrics.luminance.unwrap();
    assert!((first.rmse - 0.9278 * 0.025_f64.sqrt()).abs() < 1e-6);
    assert_eq!(result.frames[1].metrics.luminance.unwrap().ssim, 1.0);
}

#[test]
fn a_moving_reference_has_a_temporal_error_too() {
    let frames = [[1.0, 2.0], [2.0, 2.0]].map(|values| grey(2, values));
    let mut sequence = Sequence::new(CompareOptions::default(), false);
    for (number, frame) in (0..).zip(&frames) {
        sequence.push(number, &grey(2, [1.0, 1.0]), frame).unwrap();
    }
    let other_size = grey(1, [1.0]);
    let error = sequence.push(2, &other_size, &other_size).unwrap_err().to_string();
    assert!(error.contains("has 1x1 pixels"), "{error}");
    let result = sequence.finish().unwrap();
    assert_eq!(result.temporal_error, Some(0.0));
    assert_close(result.reference_temporal_error.unwrap(), 0.5);
}
