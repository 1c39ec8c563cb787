//! The CPU's stages of a frame for VPLs, while a torus turns under a light and nearly every frame loses some.

#![allow(missing_docs, reason = "criterion's macros make functions without")]

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use glowworm::bvh::TwoLevelBvh;
use glowworm::estimators::World;
use glowworm::estimators::vpls::VplManager;
use glowworm::formats::load_scene;
use glowworm::settings::{Settings, VplSettings};

fn stages(criterion: &mut Criterion) {
    let scene = load_scene("meeting-room", None).expect("a built-in scene");
    let rest = scene.pose(0.0);
    let mut group = criterion.benchmark_group("VPL stages on the CPU, 512 VPLs, budget 64");
    for pool in [512, 16_384] {
        let vpl = VplSettings { slots: 512, pool, budget: 64, ..VplSettings::default() };
        let settings = Settings { vpl, ..Settings::default() };
        let mut bvh = TwoLevelBvh::build(&scene, &rest.instances);
        let mut manager = VplManager::new(World { scene: &scene, pose: &rest, bvh: &bvh }, &settings);
        let mut frame = 0u32;
        group.bench_function(BenchmarkId::new("pool", pool), |bencher| {
            bencher.iter(|| {
                frame += 1;
                let pose = scene.pose(f64::from(frame) / 60.0);
                bvh.update(&pose.instances);
                let world = World { scene: &scene, pose: &pose, bvh: &bvh };
                manager.invalidate(world);
                manager.replace(world);
                let _ = manager.set_vpls(world, frame % settings.vpl.temporal_sets);
            });
        });
    }
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
