//! Temporal sets spread the rays of all VPLs over the frames, which is what makes a frame cheap.

use glowworm::settings::{Settings, VplSettings};

use super::support::{GpuFixture, named_scene, plain};

#[test]
fn temporal_sets_share_the_rays_out() {
    let Some(gpu) = GpuFixture::open() else { return };
    let scene = named_scene("cornell-box", None);
    let rays_of_frames = |temporal_sets: u32| -> Vec<u64> {
        let vpl = VplSettings { slots: 256, pool: 256, temporal_sets, clamp: 0.0, ..VplSettings::default() };
        let mut renderer = gpu.rendered(&scene, &Settings { vpl, size: [64, 64], ..plain() }, 16);
        let reports = renderer.finish().unwrap();
        reports.iter().map(|report| report.figures.counters.get("shadow_rays")).collect()
    };
    let (one, sixteen) = (rays_of_frames(1), rays_of_frames(16));
    let (most, all) = (sixteen.iter().max().unwrap(), sixteen.iter().sum::<u64>());
    println!("shadow rays of frames: T = 1 {:?}, T = 16 {sixteen:?}", &one[..1]);
    assert_eq!(sixteen.len(), 16);
    // A set has a sixteenth of the VPLs, some with more surfaces in their reach than others.
    assert!(*most * 10 < one[0], "{most} of {}", one[0]);
    // Together the sets cast what one set casts in a frame.
    let ratio = all as f64 / one[0] as f64;
    assert!((0.8..1.25).contains(&ratio), "{ratio}");
}
