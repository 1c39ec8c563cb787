//! Methods at equal time: each with so much of what it scales with that a frame takes as long as one of the first method.
//!
//! In: the runs of a scene. Out: for each method its picture of the last moment, in motion, with its error.

use super::method::Method;
use super::quality::{ReferencePictures, compare_with};
use super::report::{EqualTime, PictureKind};
use super::run::{FrameQuality, Run};
use super::samples::TOTAL;
use super::source::{BenchScene, FrameSource, warm_up};
use super::summary::{Noise, Summary};
use super::{Bench, BenchError, Control};
use crate::estimators;
use crate::metrics::Comparison;
use crate::output::{Picture, Tones, automatic_exposure, tone_map};
use crate::plot::magma;
use crate::settings::Settings;
use crate::statistics::percentile;

/// Frames whose median time counts.
const FRAMES: u32 = 8;
/// Most trials.
const TRIALS: u32 = 3;
/// Times count as equal up to this relative difference.
const TOLERANCE: f64 = 0.1;
/// Most samples a pixel, and most of a setting.
const MOST: u32 = 65_536;

/// A trial and its result.
struct Trial {
    method: Method,
    settings: Settings,
    ms: f64,
    picture: Picture,
}

/// The pictures of a method at equal time.
struct Pictures {
    picture: Picture,
    /// FLIP error of each pixel.
    map: Picture,
}

impl Bench {
    /// Whether a scene's methods are to be compared at equal time: where there are several.
    pub(super) fn wants_equal_time(&self, scene: &str) -> bool {
        let done = self.report.equal_time.iter().any(|equal| equal.scene == scene);
        let plan = &self.report.plan;
        plan.quality && plan.spp > 0 && plan.sweep.methods.len() > 1 && !done
    }

    /// Renders every method so that its frames take as long as those of the first one.
    pub(super) fn compare_at_equal_time(
        &mut self,
        index: usize,
        scene: &BenchScene,
        references: &mut Vec<ReferencePictures>,
        control: &mut Control<'_>,
    ) -> Result<(), BenchError> {
        let name = scene.scene.name.clone();
        if !self.wants_equal_time(&name) {
            return Ok(());
        }
        let noise = Noise::of(&self.report.runs);
        let time = |run: &Run| Summary::of(run, &noise).map_or(0.0, |summary| summary.median(TOTAL));
        let mut runs: Vec<Run> = Vec::new();
        for run in self.report.runs_of(&name) {
            // With other samples the path tracer is the same method.
            let is_same = |known: &Run| match known.method.samples() {
                Some(_) => run.method.samples().is_some(),
                None => known.method == run.method,
            };
            if !runs.iter().any(is_same) {
                runs.push(run.clone());
            }
        }
        let Some(first) = runs.first() else { return Ok(()) };
        let wanted = time(first);
        let reference =
            ReferencePictures::of(references, scene, &first.settings, &self.report.plan, control)?;
        self.keep_picture(self.entry(index, PictureKind::Reference, &first.settings), reference.last().1)?;
        let mut all = Vec::new();
        for run in &runs {
            control.begin(format!("{name}: {} at equal time", run.method));
            let reference =
                ReferencePictures::of(references, scene, &run.settings, &self.report.plan, control)?;
            let (equal, shown) = at_time(scene, run, [time(run), wanted], reference, control)?;
            for (kind, picture) in
                [(PictureKind::EqualTime, &shown.picture), (PictureKind::FlipMap, &shown.map)]
            {
                let entry = self.entry(index, kind, &run.settings).of(&run.method);
                self.keep_picture(entry, picture)?;
            }
            all.push(equal);
        }
        self.report.equal_time.extend(all);
        self.keep()
    }
}

/// Renders `run`, whose frames take `own_ms`, so that they take `wanted_ms`.
fn at_time(
    scene: &BenchScene,
    run: &Run,
    [own_ms, wanted_ms]: [f64; 2],
    reference: &ReferencePictures,
    control: &mut Control<'_>,
) -> Result<(EqualTime, Pictures), BenchError> {
    let (frame, reference) = reference.last();
    let mut known = (f64::from(amount(&run.method, &run.settings)), own_ms);
    let mut wanted = known.0 * wanted_ms / own_ms;
    let mut trial = Trial::new(scene, run, wanted, frame, control)?;
    for _ in 1..TRIALS {
        let now = (f64::from(amount(&trial.method, &trial.settings)), trial.ms);
        let slope = (now.1 - known.1) / (now.0 - known.0);
        if (now.1 / wanted_ms - 1.0).abs() < TOLERANCE || !slope.is_finite() || slope <= 0.0 {
            break;
        }
        wanted = now.0 + (wanted_ms - now.1) / slope;
        known = now;
        trial = Trial::new(scene, run, wanted, frame, control)?;
    }
    let comparison = compare_with(&trial.picture, reference)?;
    let map = flip_map(&comparison);
    let mut tones = Tones::from(&trial.settings);
    let exposure = automatic_exposure(reference, tones.curve, std::iter::repeat(1.0)).log2();
    tones.exposure = tones.exposure.or(Some(exposure));
    tone_map(&mut trial.picture, tones, std::iter::repeat(1.0));
    let cost = estimators::method(&trial.settings).cost.filter(|_| trial.method.samples().is_none());
    let equal = EqualTime {
        scene: run.scene.clone(),
        method: trial.method,
        run: run.method.clone(),
        setting: cost.map(|axis| (axis.setting.to_owned(), (axis.get)(&trial.settings))),
        ms: trial.ms,
        error: FrameQuality::of(frame, &comparison),
    };
    Ok((equal, Pictures { picture: trial.picture, map }))
}

/// The number that makes a method better and slower: samples a pixel, or the setting that the estimator names; 0 where it
/// names none.
fn amount(method: &Method, settings: &Settings) -> u32 {
    let cost = estimators::method(settings).cost;
    method.samples().or(cost.map(|axis| (axis.get)(settings))).unwrap_or(0)
}

impl Trial {
    /// Renders `run` with about this amount, in motion up to frame `last`.
    fn new(
        scene: &BenchScene,
        run: &Run,
        amount: f64,
        last: u32,
        control: &mut Control<'_>,
    ) -> Result<Self, BenchError> {
        let (mut method, mut settings) = (run.method.clone(), run.settings.clone());
        let amount = if amount.is_finite() { amount.round().min(MOST.into()) as u32 } else { 0 };
        if method.samples().is_some() {
            method = Method::reference(amount.max(1));
        } else if let Some(axis) = estimators::method(&settings).cost {
            (axis.set)(&mut settings, amount);
        }
        let last = i64::from(last);
        let first = last - i64::from(warm_up(&settings) + FRAMES) + 1;
        let mut source = FrameSource::new(scene, &method, &settings, &scene.pose(first, &settings))?;
        let mut times = Vec::new();
        for number in first..=last {
            times.push(source.render(&scene.pose(number, &settings), control)?.0);
        }
        let measured = times.split_off(times.len() - FRAMES as usize);
        let ms = percentile(measured, 0.5).unwrap_or(0.0);
        Ok(Self { method, settings, ms, picture: source.picture()? })
    }
}

/// FLIP errors in the colours of FLIP.
fn flip_map(comparison: &Comparison) -> Picture {
    let [width, height] = comparison.size;
    let colour = |error: &f32| {
        let [r, g, b] = magma(f64::from(*error));
        [r, g, b, u8::MAX]
    };
    let display = comparison.flip_errors.iter().map(colour).collect();
    Picture { width, height, display, ..Picture::default() }
}
