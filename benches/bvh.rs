//! Building the BVH, moving a hundred of a thousand instances in it, and bringing it to a device.

#![allow(missing_docs, reason = "criterion's macros make functions without")]

use criterion::{Criterion, criterion_group, criterion_main};
use glam::Affine3A;
use glowworm::bench::micro::crowd;
use glowworm::bvh::TwoLevelBvh;
use glowworm::gpu_scene::tracer::{RayTracer, Tracer};
use glowworm::vulkan::Frames;

fn build(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("BVH build");
    group.sample_size(10);
    for scene in glowworm_benches::scenes() {
        let rest = scene.pose(0.0);
        group.bench_function(&scene.name, |bencher| {
            bencher.iter(|| TwoLevelBvh::build(&scene, &rest.instances));
        });
    }
    group.finish();
}

fn update(criterion: &mut Criterion) {
    let scene = crowd().expect("the scene format has not changed");
    let rest = scene.pose(0.0).instances;
    let moved = |instance: usize| scene.instances[instance].dynamic;
    let aside = |(index, transform): (usize, &Affine3A)| {
        let mut transform = *transform;
        transform.translation.y += if moved(index) { 0.5 } else { 0.0 };
        transform
    };
    let poses = [rest.iter().enumerate().map(aside).collect(), rest.clone()];
    let mut bvh = TwoLevelBvh::build(&scene, &rest);
    let mut turns = poses.iter().cycle();
    criterion.bench_function("BVH update, 100 of 1,000 instances", |bencher| {
        bencher.iter(|| turns.next().map(|pose| bvh.update(pose)));
    });

    let Some(device) = glowworm_benches::device() else { return };
    criterion.bench_function("BVH upload", |bencher| {
        bencher.iter(|| Tracer::new(&device, RayTracer::Software, &bvh).expect("a device that works"));
    });
    let mut tracer = Tracer::new(&device, RayTracer::Software, &bvh).expect("a device that works");
    let mut frames = Frames::new(&device).expect("a device that works");
    criterion.bench_function("BVH update and its upload", |bencher| {
        bencher.iter(|| {
            turns.next().map(|pose| bvh.update(pose));
            let (mut frame, _) = frames.begin().expect("a device that works");
            tracer.update(&mut frame, &bvh).expect("a device that works");
            frame.submit().expect("a device that works");
            frames.finish().expect("a device that works")
        });
    });
}

criterion_group!(benches, build, update);
criterion_main!(benches);
