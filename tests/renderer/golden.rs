//! The built-in scene against a picture of it that was looked at and kept.

use std::path::{Path, PathBuf};

use super::support::{GpuFixture, mean, named_scene, plain, quantile};
use glowworm::settings::{Settings, VplSettings};
use image::RgbImage;

const SIDE: u32 = 96;
/// Most that the mean and the 99th percentile of the differences may be, of 1 for black against white:
/// another driver rounds otherwise, which shows at edges only.
const MEAN: f32 = 1.0 / 255.0;
const PERCENTILE_99: f32 = 8.0 / 255.0;

#[test]
fn the_cornell_box_looks_as_it_did() {
    let Some(gpu) = GpuFixture::open() else { return };
    let settings = Settings {
        size: [SIDE; 2],
        vpl: VplSettings { slots: 256, temporal_sets: 4, interleave: 2, ..VplSettings::default() },
        ..plain()
    };
    let picture = gpu.rendered(&named_scene("cornell-box", None), &settings, 4).read_picture(false).unwrap();
    let actual = picture.display.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    compare("cornell-box", &RgbImage::from_raw(SIDE, SIDE, actual).unwrap());
}

/// Compares with tests/golden/NAME.png. `GLOWWORM_BLESS=1` rewrites that picture instead.
fn compare(name: &str, actual: &RgbImage) {
    let golden_file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(format!("{name}.png"));
    if std::env::var_os("GLOWWORM_BLESS").is_some() {
        return actual.save(&golden_file).unwrap();
    }
    let golden = image::open(&golden_file).unwrap().into_rgb8();
    assert_eq!(actual.dimensions(), golden.dimensions());
    let differences: Vec<u8> =
        actual.as_raw().iter().zip(golden.as_raw()).map(|(a, b)| a.abs_diff(*b)).collect();
    let shares: Vec<f32> = differences.iter().map(|&difference| f32::from(difference) / 255.0).collect();
    let (mean, percentile) = (mean(shares.iter().copied()), quantile(shares, 0.99));
    if mean > MEAN || percentile > PERCENTILE_99 {
        let kept = keep(name, actual, differences);
        panic!(
            "{name} differs from {} by {mean:.4} in the mean and {percentile:.4} at the 99th percentile; \
             {name}-actual.png and {name}-difference.png (8 times as bright) are in {}; if the change is meant, \
             run the test with GLOWWORM_BLESS=1",
            golden_file.display(),
            kept.display()
        );
    }
}

/// Leaves the picture and the differences in target/golden/.
fn keep(name: &str, actual: &RgbImage, mut differences: Vec<u8>) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("golden");
    std::fs::create_dir_all(&folder).unwrap();
    actual.save(folder.join(format!("{name}-actual.png"))).unwrap();
    differences.iter_mut().for_each(|difference| *difference = difference.saturating_mul(8));
    let (width, height) = actual.dimensions();
    let difference = RgbImage::from_raw(width, height, differences).unwrap();
    difference.save(folder.join(format!("{name}-difference.png"))).unwrap();
    folder
}
