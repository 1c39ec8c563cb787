use glowworm::bench::micro::*;
use glowworm::renderer::PreparedScene;
use glowworm::settings::Settings;
use glowworm::vulkan::*;
use std::sync::Arc;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let turns: usize = args[1].parse().unwrap();
    let which = &args[2];
    let assets = std::env::var_os("GLOWWORM_ASSETS").map(std::path::PathBuf::from);
    for name in &args[3..] {
        let scene = Arc::new(glowworm::scene::load_scene(name, assets.as_deref()).unwrap());
        let pose = scene.pose(0.0);
        let prepared = PreparedScene::new(&scene);
        let settings = Settings { size: [256, 256], ..Settings::default() };
        let sets = ray_sets(&prepared, &pose, &settings, 1 << 18);
        let bvh = glowworm::bvh::TwoLevelBvh::build(&scene, &pose.instances);
        let mut own = OwnTracer(&bvh);
        let mut obvhs = Obvhs::new(&scene, &pose).unwrap();
        let device = which.contains('s').then(|| Device::open(&Instance::new(InstanceOptions { validate: false, display: None }).unwrap(), None).unwrap());
        let mut shader = device.as_ref().map(|d| ShaderTracer::software(d, &bvh).unwrap());
        let mut variants: Vec<ShaderTracer> = std::env::var("SPV").unwrap_or_default().split_whitespace().map(|f| ShaderTracer::exp(f.rsplit('/').next().unwrap(), device.as_ref().unwrap(), &bvh, &std::fs::read(f).unwrap()).unwrap()).collect();
        with_embree(&scene, &pose, |embree| {
            let mut all: Vec<&mut dyn Contender> = vec![&mut own];
            if which.contains('o') { all.push(&mut obvhs); }
            if which.contains('e') { all.push(embree.unwrap()); }
            if let Some(s) = &mut shader { all.push(s); }
            for v in &mut variants { all.push(v); }
            for set in &sets {
                for query in Query::ALL {
                    if which.contains('h') && (set.kind != RayKind::Shadow || query != Query::Occluded) { continue; }
                    let mut rates = vec![vec![]; all.len()];
                    let mut answers: Vec<Vec<f32>> = vec![vec![]; all.len()];
                    for _ in 0..turns {
                        for (i, c) in all.iter_mut().enumerate() {
                            let cast = c.cast(set, query).unwrap();
                            rates[i].push(set.rays.len() as f64 / cast.seconds * 1e-6);
                            answers[i] = cast.answers;
                        }
                    }
                    print!("{name:10} {:10} {:8} {:6}k", set.kind.name(), query.name(), set.rays.len() / 1000);
                    for (i, c) in all.iter().enumerate() {
                        let mut ratio: Vec<f64> = rates[0].iter().zip(&rates[i]).map(|(a, b)| a / b).collect();
                        ratio.sort_by(f64::total_cmp);
                        rates[i].sort_by(f64::total_cmp);
                        print!(" | {} {:6.2} best {:6.2} own/it {:4.2} diff {}", c.name().chars().take(14).collect::<String>(), rates[i][turns / 2], rates[i][turns-1], ratio[turns / 2], differing(&answers[0], &answers[i]));
                    }
                    for (i, c) in all.iter().enumerate() { if c.name().starts_with("count") {
                        let n = answers[i].len() as f32;
                        print!(" | {} mean {:.2} of max of 8 {:.2}", c.name(), answers[i].iter().sum::<f32>() / n, answers[i].chunks(8).map(|c| 8.0 * c.iter().copied().fold(0.0, f32::max)).sum::<f32>() / n);
                    } }
                    println!(" | hits {:.2}", answers[0].iter().filter(|t| **t >= 0.0).count() as f64 / set.rays.len() as f64);
                }
            }
        });
    }
}
