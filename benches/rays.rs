//! Rays per second of each tracer on the rays of real frames. With `--features embree` Embree casts them too.

#![allow(missing_docs, reason = "criterion's macros make functions without")]

use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use glowworm::bench::micro::{Contender, Obvhs, OwnTracer, Query, RaySet, ShaderTracer, ray_sets};
use glowworm::renderer::PreparedScene;

/// Most rays of a set.
const RAYS: usize = 1 << 16;

fn rays(criterion: &mut Criterion) {
    let device = glowworm_benches::device();
    for scene in glowworm_benches::scenes() {
        let pose = scene.pose(0.0);
        let prepared = PreparedScene::new(&scene);
        let sets = ray_sets(&prepared, &pose, &glowworm_benches::settings(), RAYS);
        let mut tracers: Vec<Box<dyn Contender + '_>> = vec![Box::new(OwnTracer(prepared.bvh()))];
        if let Some(device) = &device {
            let shaders = ShaderTracer::all(device, prepared.bvh()).expect("a device that works");
            tracers.extend(shaders.into_iter().map(|tracer| Box::new(tracer) as Box<dyn Contender>));
        }
        if let Some(obvhs) = Obvhs::new(&scene, &pose) {
            tracers.push(Box::new(obvhs));
        }
        for tracer in &mut tracers {
            cast(criterion, &scene.name, &sets, tracer.as_mut());
        }
        #[cfg(feature = "embree")]
        glowworm::bench::micro::with_embree(&scene, &pose, |embree| {
            embree.into_iter().for_each(|embree| cast(criterion, &scene.name, &sets, embree));
        });
    }
}

fn cast(criterion: &mut Criterion, scene: &str, sets: &[RaySet], tracer: &mut dyn Contender) {
    for (set, query) in sets.iter().flat_map(|set| Query::ALL.map(|query| (set, query))) {
        let mut group = criterion.benchmark_group(format!("{scene}, {}, {}", set.kind.name(), query.name()));
        group.throughput(Throughput::Elements(set.rays.len() as u64)).sample_size(10);
        let name = tracer.name().to_owned();
        group.bench_function(BenchmarkId::from_parameter(name), |bencher| {
            bencher.iter_custom(|times| {
                let cast = || tracer.cast(set, query).expect("a device that works").seconds;
                Duration::from_secs_f64(std::iter::repeat_with(cast).take(times as usize).sum())
            });
        });
        group.finish();
    }
}

criterion_group!(benches, rays);
criterion_main!(benches);
