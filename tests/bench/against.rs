//! Significance of changes between reports.

use std::fs;

use glowworm::bench::{Report, compare_reports, read_report};

use super::program::{Run, assert_fails, stderr};
use super::report::folder;

/// The pass that is made slower.
const SLOWED: &str = "indirect_shadows";

/// Random numbers: SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Approximately normal.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.next()).sum::<f64>() - 6.0
    }
}

/// A real report with synthetic times: 10 ms of [`SLOWED`], 1 ms of everything else, increasing by half along the
/// animation; correlated noise of `frame` between frames, and of `round` between rounds.
fn made_up(seed: u64, frame: f64, round: f64) -> Report {
    let mut random = Random(seed);
    let mut report = read_report(&folder().join("bench.json")).unwrap();
    let frames = 40;
    report.plan.frames = frames;
    for measured in report.runs.iter_mut().flat_map(|run| &mut run.rounds) {
        let samples = &mut measured.samples;
        let drift = 1.0 + round * random.normal();
        let mut lasting = 0.0;
        samples.total_ms.clear();
        samples.other_ms.clear();
        samples.passes.0.values_mut().for_each(Vec::clear);
        for number in 0..frames {
            lasting = 0.8 * lasting + 0.6 * frame * random.normal();
            let speed = drift * (1.0 + lasting) * (1.0 + 0.5 * f64::from(number) / f64::from(frames));
            for (pass, column) in &mut samples.passes.0 {
                column.push(if *pass == SLOWED { 10.0 } else { 1.0 } * speed);
            }
            samples.other_ms.push(0.5 * speed);
            samples.total_ms.push(19.5 * speed);
        }
    }
    report
}

/// Makes [`SLOWED`] slower in one run.
fn slow_down(report: &mut Report, run: usize, factor: f64) {
    for samples in report.runs[run].rounds.iter_mut().map(|round| &mut round.samples) {
        for (time, total) in samples.passes.0[SLOWED].iter_mut().zip(&mut samples.total_ms) {
            *total += *time * (factor - 1.0);
            *time *= factor;
        }
    }
}

#[test]
fn a_report_differs_from_itself_in_nothing() {
    for report in [read_report(&folder().join("bench.json")).unwrap(), made_up(1, 0.1, 0.1)] {
        let comparison = compare_reports(&report, &report);
        assert_eq!((comparison.compared, comparison.unmatched, comparison.changes.len()), (10, 0, 0));
    }
}

#[test]
fn noise_is_no_change() {
    let mut alarms = 0;
    for seed in 0..50 {
        let [old, new] = [2 * seed, 2 * seed + 1].map(|seed| made_up(seed, 0.05, 0.03));
        alarms +=
            compare_reports(&old, &new).changes.iter().filter(|change| change.quantity == "total").count();
    }
    // There are 50 times 10 totals; the passes vary alike here, so each of them would be reported, too.
    assert!(alarms <= 8, "{alarms} false alarms");
}

#[test]
fn a_pass_that_was_slowed_is_reported() {
    for seed in 0..10 {
        let [old, mut new] = [100 + seed, 200 + seed].map(|seed| made_up(seed, 0.02, 0.01));
        slow_down(&mut new, 6, 1.4);
        let comparison = compare_reports(&old, &new);
        let of_run = |quantity: &str| {
            let mut found = comparison.changes.iter().filter(|change| change.quantity == quantity);
            found.find(|change| change.run.starts_with("playroom, vpls, T = 4"))
        };
        let (pass, total) = (of_run("indirect_shadows").unwrap(), of_run("total").unwrap());
        assert!(pass.is_regression() && total.is_regression());
        let [low, high] = pass.growth;
        assert!(low < 0.4 * pass.old && 0.4 * pass.old < high, "{pass}");
        assert!(comparison.changes.iter().all(|change| change.run == pass.run), "{:?}", comparison.changes);
        // In reverse it is faster.
        assert!(compare_reports(&new, &old).changes.iter().any(|change| !change.is_regression()));
    }
}

#[test]
fn a_worse_picture_is_reported() {
    let old = made_up(4, 0.0, 0.0);
    let mut new = old.clone();
    for frame in &mut new.runs[2].quality.as_mut().unwrap().frames {
        frame.flip *= 1.1;
    }
    let [worse, better] = [compare_reports(&old, &new), compare_reports(&new, &old)];
    let [worse, better] = [worse, better].map(|comparison| comparison.changes[0].clone());
    assert!(worse.quantity == "FLIP error" && worse.is_regression() && !better.is_regression());
    assert!(worse.to_string().starts_with("worse  cornell-box, vpls, T = 1"), "{worse}");
}

#[test]
fn reports_of_other_runs_and_machines_say_so() {
    let old = made_up(3, 0.0, 0.0);
    let mut new = old.clone();
    new.machine.driver.push('2');
    new.runs.remove(0);
    new.runs[0].settings.vpl.budget += 1;
    let comparison = compare_reports(&old, &new);
    assert_eq!(comparison.other_machine, Some("driver"));
    assert_eq!((comparison.compared, comparison.unmatched), (8, 3));
}

/// Copies the finished report with constant times, so that the result is deterministic.
fn steady(run: &Run) -> Report {
    let mut report = read_report(&folder().join("bench.json")).unwrap();
    for measured in &mut report.runs {
        let first = measured.rounds[0].clone();
        measured.rounds.fill(first);
        for samples in measured.rounds.iter_mut().map(|round| &mut round.samples) {
            let columns = samples.passes.0.values_mut().chain([&mut samples.total_ms, &mut samples.other_ms]);
            columns.for_each(|column| {
                let first = column[0];
                column.fill(first);
            });
        }
    }
    fs::create_dir(run.path("a")).unwrap();
    fs::create_dir(run.path("a/pictures")).unwrap();
    for entry in fs::read_dir(folder().join("pictures")).unwrap() {
        let entry = entry.unwrap();
        fs::copy(entry.path(), run.folder.path().join("a/pictures").join(entry.file_name())).unwrap();
    }
    save(run, "a/bench.json", &report);
    report
}

fn save(run: &Run, name: &str, report: &Report) {
    fs::write(run.path(name), serde_json::to_vec(report).unwrap()).unwrap();
}

#[test]
fn a_regression_ends_with_3() {
    let run = Run::new();
    let report = steady(&run);
    let against = |file: &str| run.glowworm(&["bench", "--out", "a", "--resume", "--against", file]);
    let same = against("a/bench.json");
    assert_eq!(same.status.code(), Some(0), "{}", stderr(&same));
    let said = String::from_utf8(same.stdout).unwrap();
    assert!(
        said.ends_with(
            "against a/bench.json: 0 slower or worse, 0 faster or better beyond noise, in 10 runs\n"
        ),
        "{said}"
    );

    // In reverse it is slower.
    let mut faster = report.clone();
    slow_down(&mut faster, 1, 0.3);
    save(&run, "faster.json", &faster);
    let slower = against("faster.json");
    assert_eq!(slower.status.code(), Some(3), "{}", stderr(&slower));
    assert!(stderr(&slower).contains("--against faster.json: 2 figures are slower or worse beyond noise"));
    let said = String::from_utf8(slower.stdout).unwrap();
    assert!(
        said.contains(
            "slower  cornell-box, vpls, T = 4, 32 VPLs, n = 1, 48x32, 2 bounces: indirect_shadows "
        ),
        "{said}"
    );

    let mut nothing = report.clone();
    nothing.runs.truncate(1);
    nothing.runs[0].settings.seed += 1;
    save(&run, "nothing.json", &nothing);
    let output = against("nothing.json");
    assert_eq!(output.status.code(), Some(1));
    assert!(stderr(&output).contains("nothing was compared"), "{}", stderr(&output));

    fs::write(run.path("text.json"), "{}").unwrap();
    assert_fails(&against("text.json"), 1, &["text.json: is not a report of glowworm bench"]);
}
