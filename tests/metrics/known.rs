//! Metrics of the pairs in pairs.rs against other programs.

use glowworm::metrics::{CompareOptions, Metrics, compare};

use super::pairs::{Kind, pair};

/// Errors of each pair.
const FIGURES: usize = 15;

/// Name, kind, and: MAE, RMSE, relative MSE, PSNR, SSIM (scikit-image 0.26), FLIP (flip-evaluator 1.7), mean ratio,
/// mean and 95th percentile of the relative error, and of blocks: mean, 95th percentile, shares within 3 % and 5 %;
/// RMSE and SSIM of display luminance.
/// From `scripts/study check-metrics --known-answers`.
#[rustfmt::skip]
const KNOWN: [(&str, &str, [f64; FIGURES]); 10] = [
    ("noise", "png", [0.04705095, 0.05468752, 0.05558195, 25.24224, 0.7119614, 0.108281, 1.024222, 0.2483654, 0.6212344, 0.03210553, 0.07862629, 0.625, 0.75, 0.04117094, 0.8225165]),
    ("blur", "png", [0.01751621, 0.03620128, 0.02520399, 28.82552, 0.8884495, 0.07296754, 0.9699468, 0.1611416, 0.6407551, 0.03102581, 0.04463144, 0.5, 0.9583333, 0.03984157, 0.8472723]),
    ("shift", "png", [0.02656122, 0.05549906, 0.06334043, 25.11429, 0.8322205, 0.1499374, 0.9971466, 0.1721729, 0.741185, 0.03450465, 0.108491, 0.5416667, 0.7916667, 0.05788078, 0.7945422]),
    ("brightness", "png", [0.03944802, 0.0468937, 0.01109843, 26.57771, 0.9874049, 0.2774927, 1.274769, 0.2598346, 0.2912448, 0.2718353, 0.280885, 0.0, 0.0, 0.04359008, 0.987722]),
    ("fireflies", "png", [0.00465431, 0.04598721, 0.05513069, 26.74726, 0.8738894, 0.05134218, 1.039807, 0.08557891, 0.0, 0.05006747, 0.1334943, 0.3333333, 0.5833333, 0.04641127, 0.8813054]),
    ("noise", "exr", [0.8326304, 2.618336, 0.04292339, 27.87109, 0.9237222, 0.1351012, 0.9986461, 0.1487612, 0.3140985, 0.01001407, 0.02546907, 1.0, 1.0, 0.02943803, 0.9465156]),
    ("blur", "exr", [0.5678359, 2.75223, 0.8579835, 20.31295, 0.8606678, 0.2037517, 0.999977, 0.2833756, 1.199443, 0.009472756, 0.03345794, 0.9166667, 0.9583333, 0.09306109, 0.7826532]),
    ("shift", "exr", [0.7733394, 4.629111, 2.922909, 19.20717, 0.86881, 0.2742355, 0.9985469, 0.2375865, 0.7867465, 0.04007615, 0.1715722, 0.5, 0.75, 0.09596585, 0.8228801]),
    ("brightness", "exr", [0.5480581, 1.493163, 0.01358735, 33.96516, 0.9881062, 0.1872601, 1.12499, 0.1244467, 0.125, 0.1249751, 0.1249984, 0.0, 0.0, 0.01665014, 0.9919384]),
    ("fireflies", "exr", [1.177281, 30.30295, 3.924709, 28.38353, 0.9825539, 0.08247764, 1.286814, 0.2147977, 0.0, 0.2274962, 0.4812792, 0.125, 0.125, 0.02945702, 0.9794141]),
];

fn figures(metrics: &Metrics) -> [f64; FIGURES] {
    let (blocks, luminance) = (metrics.blocks, metrics.luminance.unwrap());
    [
        metrics.mae,
        metrics.rmse,
        metrics.relmse,
        metrics.psnr,
        metrics.ssim,
        metrics.flip,
        metrics.mean_ratio,
        metrics.mean_relative_error,
        metrics.p95_relative_error,
        blocks.mean_relative_error,
        blocks.p95_relative_error,
        blocks.within_3_percent,
        blocks.within_5_percent,
        luminance.rmse,
        luminance.ssim,
    ]
}

fn kind_of(extension: &str) -> Kind {
    if extension == "png" { Kind::Png } else { Kind::Exr }
}

#[test]
fn other_programs_say_the_same() {
    let options = CompareOptions { luminance: true, ..CompareOptions::default() };
    for (name, extension, expected) in KNOWN {
        let [image, reference] = pair(name, kind_of(extension));
        let metrics = compare(&image, &reference, &options).unwrap().metrics;
        for (index, (actual, expected)) in figures(&metrics).into_iter().zip(expected).enumerate() {
            let tolerance = 2e-5 * expected.abs();
            assert!(
                (actual - expected).abs() <= tolerance,
                "{name} {extension}, figure {index}: {actual}, not {expected}"
            );
        }
    }
}

#[test]
fn swapped_pictures_have_the_same_symmetric_metrics() {
    for (name, extension, _) in KNOWN {
        let [image, reference] = pair(name, kind_of(extension));
        let [forth, back] = [(&image, &reference), (&reference, &image)]
            .map(|(a, b)| compare(a, b, &CompareOptions::default()).unwrap().metrics);
        let symmetric = |metrics: Metrics| [metrics.mae, metrics.rmse, metrics.psnr, metrics.ssim];
        assert_eq!(symmetric(forth), symmetric(back), "{name} {extension}");
        if extension == "png" {
            assert_eq!(forth.flip, back.flip, "{name}");
        }
        let ratios = forth.mean_ratio * back.mean_ratio;
        assert!((ratios - 1.0).abs() < 1e-9, "{name} {extension}: {ratios}");
    }
}
