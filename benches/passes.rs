//! Each pass alone, by its timer, while the world stands still and while it moves.

#![allow(missing_docs, reason = "criterion's macros make functions without")]

mod support;

use std::time::Duration;

use criterion::{Criterion, criterion_group, criterion_main};
use glowworm::bench::micro::{Motion, PassFrames};
use glowworm::renderer::PreparedScene;

fn passes(criterion: &mut Criterion) {
    let Some(device) = support::device() else { return };
    for scene in support::scenes() {
        let prepared = PreparedScene::new(&scene);
        let mut frames =
            PassFrames::new(&device, &prepared, &support::settings()).expect("a device that works");
        for motion in [Motion::Still, Motion::Moving] {
            let mut group = criterion.benchmark_group(format!("{}, {}", scene.name, motion.name()));
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
