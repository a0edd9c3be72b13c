//! Counts as sparse and scenes as odd as may be: a fit gives finite numbers, or a reason.

use goldtof::estimate::CountingTier;
use goldtof::estimate::fit::{Fitter, OtherLight};
use goldtof::estimate::report::Reporter;
use goldtof::photons::{DetectorModel, StepCount};
use goldtof::report::estimates::{BothEstimates, texts};
use goldtof::response::MeanResponse;
use goldtof::scene::{DetectorIndex, EstimatorKind, Scene};
use goldtof::sensor::Sensor;
use optics_support::{code, full_scan, ideal_scene, repeated, table_i_scene};

/// The weight-3 code of the issue: a largest count of 1 in 2 means no light of the
/// path's at all, and used to divide by zero.
#[test]
fn a_count_that_shows_no_light_of_the_path_gives_a_fit_or_words() {
    let mut scene = ideal_scene(code(&[1, 1, 0, 1]), 1e6, 250);
    scene.samples_per_chip = 16;
    scene.scan = full_scan(16, &scene.sources[0].code, 250);
    let spad = &mut scene.detectors[0];
    (spad.dead_time_ps, spad.pulse_width_ps) = (14e3, 2e3);
    let mut counts = vec![StepCount { signed: 0, total: 4 }; 64];
    for count in &mut counts[20..40] {
        *count = StepCount { signed: 2, total: 4 };
    }
    assert_finite(&scene, &counts, "half");
    let fitted = Fitter::new(
        &Sensor::new(&scene),
        DetectorIndex(0),
        CountingTier::Sampled,
        OtherLight::None,
    )
    .fit(&counts);
    if let Err(reason) = fitted {
        assert!(!reason.to_string().contains("fires"), "{reason}");
    }
}

/// Fits, by the library and for the report: no number of it may be infinite or none.
fn assert_finite(scene: &Scene, counts: &[StepCount], name: &str) -> bool {
    let tier = CountingTier::Sampled;
    let fitted =
        Fitter::new(&Sensor::new(scene), DetectorIndex(0), tier, OtherLight::None).fit(counts);
    let fits = fitted.is_ok();
    let text = match fitted {
        // Codes say "infinite" nowhere; numbers would as "inf" or "NaN".
        Ok(fit) => format!(
            "{:?} {:?} {:?} {:?} {:?}",
            (fit.delay_ps, fit.distance_m, fit.std_m, fit.constant_rate_hz, fit.chi_square),
            fit.alarm_sigmas(),
            fit.paths.iter().map(|p| (p.delay_ps, p.rate_hz)).collect::<Vec<_>>(),
            fit.paths.iter().map(|p| (p.delay_std_ps, p.rate_relative_std)).collect::<Vec<_>>(),
            fit.degrees_of_freedom,
        ),
        Err(reason) => reason.to_string(),
    };
    let report = Reporter::new(&Sensor::new(scene), DetectorIndex(0)).scan(counts);
    let (own, other) = (&report, &report);
    let (told, shared) = texts(&[BothEstimates { own, other }], None);
    let told = told.concat() + &shared;
    for text in [text, format!("{report:?}"), told] {
        let words = text.split(|c: char| !c.is_ascii_alphabetic());
        let wrong: Vec<&str> = words.filter(|word| ["NaN", "inf"].contains(word)).collect();
        assert!(wrong.is_empty(), "{name}: {text}");
    }
    fits
}

/// A generator of Lehmer's, enough to be anywhere.
struct Draw(u64);

impl Draw {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % limit
    }

    fn of<T: Copy>(&mut self, values: &[T]) -> T {
        values[self.below(values.len() as u64) as usize]
    }
}

fn random_scene(draw: &mut Draw) -> Scene {
    let length = 2 + draw.below(14) as usize;
    let mut chips: Vec<u8> = (0..length).map(|_| draw.below(2) as u8).collect();
    (chips[0], chips[1]) = (1, 0);
    let mut scene = table_i_scene(code(&chips), draw.of(&[1e4, 1e6, 40e6]), draw.of(&[1, 50, 500]));
    scene.samples_per_chip = draw.of(&[1, 2, 4, 8]);
    let chips = scene.scan.integration_chips;
    scene.scan = full_scan(scene.samples_per_chip, &scene.sources[0].code, chips);
    scene.estimator = EstimatorKind::Model;
    scene.sources[0].extinction_ratio = draw.of(&[1.01, 10.0, f64::INFINITY]);
    let spad = &mut scene.detectors[0];
    spad.dark_count_rate_cps = draw.of(&[0.0, 71e3]);
    spad.dead_time_ps = draw.of(&[0.0, 2e3, 14e3, 30e3]);
    spad.pulse_width_ps = draw.of(&[100.0, 300.0, 2e3, 7e3]);
    if draw.below(2) == 0 || spad.dead_time_ps == 0.0 {
        spad.afterpulsing_probability = 0.0;
        spad.afterpulsing_time_constant_ps = 0.0;
    }
    scene
}

fn random_counts(draw: &mut Draw, steps: u64) -> Vec<StepCount> {
    let most = draw.of(&[1, 2, 5, 300]);
    let seldom = draw.of(&[1, 3, 40]);
    (0..steps)
        .map(|_| {
            let total = if draw.below(seldom) == 0 { draw.below(most + 1) } else { 0 };
            let up = draw.below(total + 1);
            StepCount { signed: 2 * up as i64 - total as i64, total }
        })
        .collect()
}

/// What is expected, rounded, one more or less.
fn likely_counts(draw: &mut Draw, scene: &Scene) -> Vec<StepCount> {
    let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
    let Ok(response) = MeanResponse::new(&model) else {
        return random_counts(draw, scene.scan.steps);
    };
    let means = response.mean_counts();
    let counts = means.iter().map(|mean| {
        let total = (mean.total + draw.below(3) as f64 - 1.0).round().max(0.0);
        let up = (0.5 * (mean.total + mean.signed)).round().clamp(0.0, total);
        StepCount { signed: (2.0 * up - total) as i64, total: total as u64 }
    });
    counts.collect()
}

#[test]
fn fits_of_random_scenes_to_random_counts_are_finite_or_refused_in_words() {
    let mut draw = Draw(20_260_727);
    let mut fits = 0;
    // The ninth and the eighteenth are of counts that saturate the detector.
    let scenes = repeated(18, 24);
    for number in 0..scenes {
        let scene = random_scene(&mut draw);
        let counts = match number % 2 {
            0 => random_counts(&mut draw, scene.scan.steps),
            _ => likely_counts(&mut draw, &scene),
        };
        fits += usize::from(assert_finite(&scene, &counts, &format!("number {number}")));
    }
    println!("{fits} of {scenes} fitted");
    assert!(fits > 0, "only {fits} of {scenes} fitted");
}
