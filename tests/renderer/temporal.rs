//! Temporal sets and interleaving change when and where VPLs are used, not what comes out.

use glowworm::settings::{Settings, VplSettings};

use super::support::{
    GpuFixture, exact, indirect, layer, luminance, mean, named_scene, plain, relative_differences,
};

fn cornell(vpls: u32, temporal_sets: u32, interleave: u32) -> Settings {
    let vpl = VplSettings { slots: vpls, temporal_sets, interleave, ..VplSettings::default() };
    // Without interleaving every VPL is gathered, and there are no short rays.
    let vpl = VplSettings { pool: vpls, clamp: 0.0, ..vpl };
    Settings { vpl, size: [96, 96], ..plain() }
}

#[test]
fn sixteen_sets_show_what_one_shows() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    // Interleaved, set buffers have half the resolution, and pixels sample other VPLs: each is near what it is with one set, the
    // mean the same.
    for (interleave, most_mean, most, of_mean) in [(1, 0.001, 0.01, 0.003), (4, 0.1, f32::INFINITY, 0.01)] {
        let many = indirect(&gpu.rendered(&scene, &cornell(512, 16, interleave), 16));
        let one = indirect(&gpu.rendered(&scene, &cornell(512, 1, interleave), 1));
        let (average, worst) = relative_differences(&many, &one);
        assert!(average <= most_mean && worst <= most, "interleave {interleave}: {average}, {worst}");
        let brightness = |picture: &[[f32; 3]]| mean(picture.iter().map(luminance));
        let ratio = brightness(&many) / brightness(&one);
        assert!((ratio - 1.0).abs() <= of_mean, "interleave {interleave}: the mean is {ratio}");
    }
}

#[test]
fn interleaving_keeps_the_brightness() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let settings =
        |interleave| Settings { size: [192, 192], exposure: Some(0.0), ..cornell(1024, 1, interleave) };
    let picture = |interleave| gpu.rendered(&scene, &settings(interleave), 1).read_picture(true).unwrap();
    let (with, without) = (picture(4), picture(1));
    let brightness = |picture| mean(layer(picture, "indirect").iter().map(luminance));
    let ratio = brightness(&with) / brightness(&without);

    assert!((ratio - 1.0).abs() <= 0.005, "mean brightness changes by {ratio}");
    let squares = with.display.iter().zip(&without.display).flat_map(|(with, without)| {
        [0, 1, 2].map(|c| ((f32::from(with[c]) - f32::from(without[c])) / 255.0).powi(2))
    });
    let rmse = mean(squares).sqrt();
    assert!(rmse <= 0.02, "tone-mapped pixels differ by {rmse}");
}

#[test]
fn a_static_scene_shoots_nothing_where_nothing_is_averaged() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let settings =
        Settings { vpl: VplSettings { budget: 16, ..cornell(128, 8, 4).vpl }, ..cornell(128, 8, 4) };
    let pose = scene.pose(0.0);
    let mut renderer = gpu.renderer(&scene, &settings, &pose);
    (0..32).for_each(|_| renderer.render(&pose).unwrap());
    let reports = renderer.finish().unwrap();
    assert_eq!(reports.len(), 32);
    for report in reports {
        assert_eq!(report.figures.counters.get("vpls.shot"), 0, "frame {} shot VPLs", report.frame);
        assert!(report.figures.counters.get("shadow_rays") > 0);
    }
}

#[test]
fn reruns_are_the_same_bits() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let picture = || gpu.rendered(&scene, &cornell(100, 4, 4), 6).read_picture(true).unwrap();
    assert!(picture() == picture());
}

#[test]
fn uneven_divisions_keep_the_brightness() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let brightness = |vpls, temporal_sets, interleave, bounces| {
        let settings = Settings {
            bounces,
            size: [61, 47],
            vpl: VplSettings { slots: vpls, temporal_sets, interleave, ..exact([61, 47]).vpl },
            ..exact([61, 47])
        };
        mean(indirect(&gpu.rendered(&scene, &settings, temporal_sets)).iter().map(luminance))
    };
    for (vpls, sets, interleave) in [(1021, 7, 3), (999, 13, 5), (2000, 64, 8), (1025, 1, 7)] {
        let ratio = brightness(vpls, sets, interleave, 3) / brightness(vpls, 1, 1, 3);
        assert!((ratio - 1.0).abs() < 0.05, "{vpls} VPLs, {sets} sets, interleave {interleave}: {ratio}");
    }
}

#[test]
fn extremes_work() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    for (vpls, temporal_sets, interleave, bounces, size) in [
        (1, 1, 1, 1, [1, 1]),
        (64, 64, 8, 16, [5, 3]),
        (65_536, 64, 8, 16, [16, 9]),
        (65_536, 1, 1, 2, [2, 2]),
    ] {
        let settings = Settings {
            bounces,
            size,
            vpl: VplSettings { slots: vpls, temporal_sets, interleave, ..VplSettings::default() },
            ..plain()
        };
        let picture = gpu.rendered(&scene, &settings, 3).read_picture(false).unwrap();
        assert!(picture.colour.iter().flatten().all(|value| value.is_finite() && *value >= 0.0));
    }
}

#[test]
fn rays_are_cast_only_where_they_matter() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let pose = scene.pose(0.0);
    let mut renderer = gpu.renderer(&scene, &cornell(512, 1, 1), &pose);
    renderer.render(&pose).unwrap();
    let ids = renderer.read_picture(true).unwrap();
    let report = renderer.finish().unwrap().remove(0).figures;
    let seen = ids.layers.iter().find(|layer| layer.name == "instance").unwrap().channels[0].1.iter();
    let pairs = seen.filter(|id| **id >= 0.0).count() as u64 * report.counters.get("vpls.valid");
    let share = report.counters.get("shadow_rays") as f64 / pairs as f64;
    assert!((0.2..0.7).contains(&share), "{share} of all pairs of pixel and VPL got a ray");
}

#[test]
fn temporal_sets_share_the_rays_of_a_frame() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let pose = scene.pose(0.0);
    let rays = |temporal_sets: u32| {
        let base = cornell(512, temporal_sets, 1);
        let settings = Settings { vpl: VplSettings { refresh: 0, ..base.vpl }, ..base };
        let mut renderer = gpu.renderer(&scene, &settings, &pose);
        (0..temporal_sets).for_each(|_| renderer.render(&pose).unwrap());
        let reports = renderer.finish().unwrap();
        mean(reports.iter().map(|report| report.figures.counters.get("shadow_rays") as f32))
    };
    let ratio = rays(1) / rays(16);
    assert!(ratio >= 14.0, "T = 16 casts only {ratio} times fewer rays");
}

#[test]
fn no_vpl_is_lost_where_a_frame_has_very_many() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cathedral", None);
    let settings = |temporal_sets| Settings {
        vpl: VplSettings { slots: 4096, pool: 4096, temporal_sets, clamp: 0.0, ..exact([48, 27]).vpl },
        ..exact([48, 27])
    };
    let pose = scene.pose(0.0);
    let brightness = |temporal_sets| {
        let mut renderer = gpu.renderer(&scene, &settings(temporal_sets), &pose);
        for _ in 0..temporal_sets {
            renderer.render(&pose).unwrap();
        }
        mean(indirect(&renderer).iter().map(luminance))
    };
    let ratio = brightness(1) / brightness(64);
    assert!((ratio - 1.0).abs() < 1e-3, "{ratio}");
}
