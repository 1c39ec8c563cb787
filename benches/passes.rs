//! Each pass alone, by its timer, in a stationary and in a moving world: with the default settings, and with those
//! that are there to be faster or slower.

#![allow(missing_docs, reason = "criterion's macros make functions without")]

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use glowworm::bench::micro::{Motion, PassFrames};
use glowworm::renderer::PreparedScene;
use glowworm::settings::Settings;

/// The defaults and what differs from them in cost.
fn settings() -> [(&'static str, Settings); 3] {
    let default = glowworm_benches::settings();
    let (mut one_set, mut separable) = (default.clone(), default.clone());
    one_set.vpl.temporal_sets = 1;
    separable.svgf.separable = true;
    [("default", default), ("--temporal-sets 1", one_set), ("--svgf-separable", separable)]
}

fn passes(criterion: &mut Criterion) {
    let Some(device) = glowworm_benches::device() else { return };
    for scene in glowworm_benches::scenes() {
        let prepared = PreparedScene::new(&scene);
        for ((name, settings), motion) in settings()
            .iter()
            .flat_map(|settings| [Motion::Still, Motion::Moving].map(|motion| (settings, motion)))
        {
            let mut frames = PassFrames::new(&device, &prepared, settings).expect("a device that works");
            let mut group = criterion.benchmark_group(format!("{}, {name}, {}", scene.name, motion.name()));
            group.sample_size(10).measurement_time(Duration::from_secs(2));
            let names: Vec<&'static str> =
                frames.render(motion).expect("a device that works").into_keys().collect();
            for name in names {
                // A pass that has nothing to do takes no time at all, which cannot be measured.
                let works = |frames: &mut PassFrames| {
                    (0..3).any(|_| frames.render(motion).expect("a device that works")[name] > 0.0)
                };
                if !works(&mut frames) {
                    continue;
                }
                group.bench_function(name, |bencher| {
                    bencher.iter_custom(|times| {
                        let mut pass = || frames.render(motion).expect("a device that works")[name];
                        let ms: f64 = (0..times).map(|_| pass()).sum();
                        Duration::from_secs_f64(ms * 1e-3)
                    });
                });
            }
            group.finish();
        }
    }
}

criterion_group!(benches, passes);
criterion_main!(benches);
