//! Errors of the model estimator beside the phase's, on simulated photons of the
//! article's sensor: dead-time walk, circular error, interference, and what wrong
//! detector parameters cost.
//!
//!     cargo bench --bench estimators -- [walk] [circular] [interference] [wrong]

#[path = "../../tests/optics_support/mod.rs"]
mod optics_support;
mod noiseless;
mod timing;

use std::error::Error;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use goldtof::code::{CodeSpec, Family};
use goldtof::estimate::bound::bound;
use goldtof::estimate::model::{OtherLight, fit};
use goldtof::estimate::{
    CountingTier, Measurement, calibration_offset_ps, delay_error_ps, distance_m, estimate,
};
use goldtof::optics::{
    CountSampler, DetectorModel, MeanResponse, SecondMoments, StepCount, count_step,
};
use goldtof::scene::{self, Path as LightPath, Scene, Source};

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

const TIER: CountingTier = CountingTier::Events;

fn main() -> Outcome {
    let parts: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with('-'))
        .collect();
    let asked = |part: &str| parts.is_empty() || parts.iter().any(|p| p == part);
    let scene = scene::load(Path::new("scenes/paper-single.toml"))?;
    if asked("timing") {
        timing::timing(&scene)?;
    }
    if asked("noiseless") {
        noiseless::walk(&scene)?;
        noiseless::circular(&scene)?;
    }
    if asked("noiseless-interference") {
        noiseless::interference(&scene)?;
    }
    if asked("walk") {
        walk(&scene)?;
    }
    if asked("circular") {
        circular(&scene)?;
    }
    if asked("wrong") {
        wrong(&scene)?;
    }
    if asked("interference") {
        interference(&scene)?;
    }
    Ok(())
}

/// Errors of many scans in millimetres.
struct Errors(Vec<f64>);

impl Errors {
    fn mean(&self) -> f64 {
        self.0.iter().sum::<f64>() / self.0.len() as f64
    }

    fn std(&self) -> f64 {
        let mean = self.mean();
        let squares: f64 = self.0.iter().map(|e| (e - mean).powi(2)).sum();
        (squares / (self.0.len() - 1) as f64).sqrt()
    }

    fn standard_error(&self) -> f64 {
        self.std() / (self.0.len() as f64).sqrt()
    }
}

/// Sets the laser's power for a mean detection rate.
fn set_detection_rate(scene: &mut Scene, rate_cps: f64) -> Outcome {
    for _ in 0..30 {
        let model = DetectorModel::new(scene, 0);
        let found = MeanResponse::of_tier(&model, TIER)?.detection_rate_hz();
        let dead = scene.detectors[0].dead_time_ps * 1e-12;
        // The rates before the dead time, roughly, as a ratio.
        let open = |rate: f64| rate / (1.0 - rate * dead);
        for source in &mut scene.sources {
            source.mean_power_w *= open(rate_cps) / open(found);
        }
    }
    Ok(())
}

/// The steps round the first path.
fn cut_scan(scene: &mut Scene, halfwidth: u64) {
    let step_ps = scene.chip_period_ps / f64::from(scene.samples_per_chip);
    let peak = (scene.paths[0].delay_ps + calibration_offset_ps(scene, 0, TIER)) / step_ps;
    let all = scene.scan.steps_per_period;
    scene.scan.first_step = (peak.round() as u64 + all - halfwidth) % all;
    scene.scan.steps = 2 * halfwidth;
}

fn count(scene: &Scene, repetition: u64) -> Vec<StepCount> {
    let model = DetectorModel::new(scene, 0);
    (0..scene.scan.steps)
        .map(|step| count_step(&model, 20_231, repetition, step))
        .collect()
}

fn error_mm(scene: &Scene, delay_ps: f64) -> f64 {
    let period_ps = scene.scan.steps_per_period as f64 * scene.chip_period_ps
        / f64::from(scene.samples_per_chip);
    1e3 * distance_m(delay_error_ps(delay_ps, scene.paths[0].delay_ps, period_ps))
}

fn phase_error_mm(scene: &Scene, counts: &[StepCount]) -> Outcome<f64> {
    let signed: Vec<i64> = counts.iter().map(|count| count.signed).collect();
    let offset_ps = calibration_offset_ps(scene, 0, TIER);
    let found = estimate(&Measurement::new(scene, &signed), offset_ps)?;
    Ok(error_mm(scene, found.delay_ps))
}

/// Phase and model errors of `scans` scans; `assumed` is what the fit believes.
fn errors(scene: &Scene, assumed: &Scene, scans: u64) -> Outcome<[Errors; 3]> {
    let (mut phase, mut model, mut alarm) = (Vec::new(), Vec::new(), Vec::new());
    for repetition in 0..scans {
        let counts = count(scene, repetition);
        phase.push(phase_error_mm(scene, &counts)?);
        let fitted = fit(assumed, 0, TIER, &counts, OtherLight::None)?;
        model.push(error_mm(scene, fitted.delay_ps));
        alarm.push(fitted.alarm_sigmas());
    }
    Ok([Errors(phase), Errors(model), Errors(alarm)])
}

fn walk(scene: &Scene) -> Outcome {
    println!(
        "dead-time walk at 3.2 m: errors in mm; biases with 10.48 ms a step, the rest with 104.8 us"
    );
    println!(
        "  detected |  phase bias   std |   model bias  +-s.e.   std  bound  ratio | chi2 alarm"
    );
    for rate in [1e6, 5e6, 10e6, 20e6, 30e6, 45e6] {
        let mut scene = scene.clone();
        set_detection_rate(&mut scene, rate)?;
        cut_scan(&mut scene, 14);
        let start = Instant::now();
        let [_, short, alarm] = errors(&scene, &scene, 400)?;
        let bound_mm = bound(&scene, 0, TIER)?.paths[0].bound_m * 1e3;
        scene.scan.integration_chips *= 100;
        let [phase, model, _] = errors(&scene, &scene, 40)?;
        println!(
            "  {:4.0} Mcps | {:9.3} {:7.3} | {:9.3} {:7.3} {:7.3} {:6.3} {:6.3} | {:5.2}   ({:.1} s)",
            rate / 1e6,
            phase.mean(),
            10.0 * phase.std(),
            model.mean(),
            model.standard_error(),
            short.std(),
            bound_mm,
            short.std() / bound_mm,
            alarm.mean(),
            start.elapsed().as_secs_f64(),
        );
    }
    Ok(())
}

fn circular(scene: &Scene) -> Outcome {
    println!("circular error at 10 Mcps, 1 s a scan: errors in mm");
    println!("  sub-step delay |  phase   model  +-s.e.");
    let mut scene = scene.clone();
    set_detection_rate(&mut scene, 10e6)?;
    scene.scan.integration_chips = 13_100 * 50;
    for eighth in 0..8 {
        scene.paths[0].delay_ps = 21_348.0 + 125.0 * f64::from(eighth);
        let mut scene = scene.clone();
        cut_scan(&mut scene, 14);
        let [phase, model, _] = errors(&scene, &scene, 40)?;
        println!(
            "  {:11} ps | {:7.3} {:7.3} {:6.3}",
            125 * eighth,
            phase.mean(),
            model.mean(),
            model.standard_error()
        );
    }
    Ok(())
}

fn wrong(scene: &Scene) -> Outcome {
    println!("wrong parameters in the fit, 10 ms a step: bias in mm +- s.e. (chi-square alarm)");
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 6] = [
        ("none", |_| {}),
        ("dead time + 0.1 ns", |s| {
            s.detectors[0].dead_time_ps += 100.0
        }),
        ("dead time - 0.1 ns", |s| {
            s.detectors[0].dead_time_ps -= 100.0
        }),
        ("afterpulsing + 1 %", |s| {
            s.detectors[0].afterpulsing_probability += 0.01;
        }),
        ("extinction ratio + 10 %", |s| {
            s.sources[0].extinction_ratio *= 1.1
        }),
        ("no ambient light assumed", |_| {}),
    ];
    for rate in [5e6, 20e6, 45e6] {
        println!("  {:.0} Mcps", rate / 1e6);
        for (what, change) in changes {
            let mut scene = scene.clone();
            if what.starts_with("no ambient") {
                scene.detectors[0].background_rate_cps = 10e6;
            }
            set_detection_rate(&mut scene, rate)?;
            scene.scan.integration_chips = 1_310_000;
            cut_scan(&mut scene, 14);
            let mut assumed = scene.clone();
            assumed.detectors[0].background_rate_cps = 0.0;
            change(&mut assumed);
            let [phase, model, alarm] = errors(&scene, &assumed, 8)?;
            println!(
                "    {what:26} {:8.3} +- {:5.3} ({:7.1})   phase {:8.3}",
                model.mean(),
                model.standard_error(),
                alarm.mean(),
                phase.mean()
            );
        }
    }
    Ok(())
}

fn interference(scene: &Scene) -> Outcome {
    println!("equal-power interferer at 10 Mcps, 104.8 ms a step, counts tier: errors in mm");
    println!("  relative delay |   phase   given  (std)   found  (std)  code right | s a fit");
    let mut spec = CodeSpec::new(Family::Gold);
    spec.degree = Some(11);
    spec.index = Some(417);
    let code = Arc::new(spec.build()?);
    for index in 0..20 {
        // Whole, half and odd parts of a chip, near and far.
        let chips = [-700.37, -3.1, -0.5, 0.0, 0.25, 1.7, 12.45, 333.3][index % 8]
            + 61.0 * (index / 8) as f64;
        let mut scene = scene.clone();
        scene.sources.push(Source {
            name: "other".to_owned(),
            code: Arc::clone(&code),
            ..scene.sources[0].clone()
        });
        let delay_ps = scene.paths[0].delay_ps + chips * scene.chip_period_ps;
        scene.paths.push(LightPath {
            source: 1,
            delay_ps: delay_ps.rem_euclid(2047.0 * scene.chip_period_ps),
            ..scene.paths[0].clone()
        });
        set_detection_rate(&mut scene, 10e6)?;
        scene.scan.integration_chips *= 1_000;
        let model = DetectorModel::new(&scene, 0);
        let response = MeanResponse::of_tier(&model, TIER)?;
        let moments = SecondMoments::new(&response)?.of_scan();
        let counts = CountSampler::new(&model, &moments).scan(20_231, index as u64);
        let phase = phase_error_mm(&scene, &counts)?;
        let start = Instant::now();
        let given = fit(&scene, 0, TIER, &counts, OtherLight::Given)?;
        let seconds = start.elapsed().as_secs_f64();
        let found = fit(&scene, 0, TIER, &counts, OtherLight::Search)?;
        let right = found
            .paths
            .get(1)
            .is_some_and(|path| path.code.chips == code.chips);
        println!(
            "  {chips:8.2} chips | {phase:7.3} {:7.3} ({:5.3}) {:7.3} ({:5.3})  {right:5} | {seconds:.2}  alarm {:.1} delay {:.2}",
            error_mm(&scene, given.delay_ps),
            given.std_m * 1e3,
            error_mm(&scene, found.delay_ps),
            found.std_m * 1e3,
            found.alarm_sigmas(),
            (given.paths[1].delay_ps - given.paths[0].delay_ps) / scene.chip_period_ps,
        );
    }
    Ok(())
}
