//! From counts to distance: bounds, expectations and diagnoses where they are tempted most.

use super::prelude::*;
use crate::estimate::bound::bound;
use crate::estimate::fit::Fitter;
use crate::photons::DetectorModel;
use crate::recorded::{RecordedScan, assess};
use crate::scene::{self, OtherLight, PathIndex, SourceIndex};

const FIRST: DetectorIndex = DetectorIndex(0);

pub(super) const CASES: &[Case] = cases! {
    Light slow "the-fit-reaches-the-bound-of-all-steps":
        "standard deviation of 400 fits over the Cramer-Rao bound, less one, Table I with a code \
         of 31 chips, in standard errors of that ratio",
        "the fit takes the likelihood of the same counts, and its errors are nearly normal: a \
         bound of fewer steps is undercut, a fit of fewer steps falls short; side lobes of a \
         Gold code tell as much as its peak, so that the peak's 24 steps alone must have a bound \
         1.25 times as large",
        fit_reaches_bound;
    Numbers quick "expectations-of-what-is-not-covered":
        "expected errors that are given for a target outside of the scan, for counts that are \
         clamped, and for bright light of another clock",
        "there the linear theory of the peak that is looked for says nothing of what is found",
        |_| uncovered_expectations();
    Numbers quick "all-steps-at-once-drawn":
        "of 300 drawn scans of all 14 steps at once, a code of 7 chips of 2 ns, those in which all \
         steps count the same",
        "the same photons are counted by every step, but the steps' signs differ: the peak \
         stands out by hundreds of counts",
        all_steps_at_once;
    Detectors quick "jitter-of-a-nanosecond-merges-nothing":
        "wrong verdicts on whether pulses merge, jitter of 1 ns, dead time of 14 ns, pulses of 7 \
         ns and of 20 ns",
        "two avalanches are 14 ns apart; jitter brings their pulses within 7 ns of each other \
         once in 10^6, and pulses of 20 ns merge whenever two avalanches are less than 20 ns \
         apart",
        |_| jitter_merges_nothing();
    Light quick "nobody-else-is-found-where-nobody-is":
        "of 40 scans of one sensor alone, code of 31 chips, those in which the search finds \
         others, or nothing at all",
        "thresholds are for one scan in a thousand",
        nobody_else;
    Light slow "a-right-scene-beside-ten-times-brighter-light":
        "of 10 scans of a sensor beside another one ten times as bright, those whose right scene \
         is said to be wrong",
        "six tests at 0.2 % each: two or more of ten once in 120",
        right_scene_beside_light;
    Light slow "an-image-over-three-decades-of-light":
        "root mean square of z of 384 pixels of a room, each simulated, z the error less the interpolated \
         bias over the interpolated standard deviation; the brightest fires a thousand times as often as \
         the darkest, and is blind for a third of the time",
        "z is 1 if theory, its interpolation and the light of each pixel are right, and known to 3.6 %; a \
         bias off by one standard deviation makes it 1.4",
        image_over_light;
    Stiff quick "paths-of-3-m-and-20-km":
        "largest difference of expected signed counts between a second path of 20 km and one of \
         20 km less whole code periods, in counts of that path's peak, all of Table I",
        "light that repeats comes the same after whole periods; 20 km are 133,425,638,079 fs, \
         538 periods of 248 ns and 1,638,079 fs; a double holds 1.3 10^8 ps to 2 10^-8 ps, and \
         edges of the light are one if they are 10^-7 chips apart",
        |_| far_paths();
};

/// Table I at 3.2 m with the fit, a code of 31 chips and so many chips a step.
fn fitted(rate_cps: f64, chips: u64) -> Result<Scene, CaseError> {
    let mut scene = table_i(GOLD_5, rate_cps, chips)?;
    scene.estimator = EstimatorKind::Model;
    scene.hardware.total_counts = Some(true);
    Ok(scene)
}

fn fit_reaches_bound(seed: u64) -> Result<CaseMeasurement, CaseError> {
    const SCANS: u64 = 400;
    let scene = fitted(20e6, 2500)?;
    let simulation = simulated(&scene, Tier::Counts, seed, SCANS)?;
    let path = &simulation.estimates[0];
    let mut peak = scene;
    window(&mut peak, 12, 24);
    let of_peak = bound(&Sensor::new(&peak), FIRST, CountingTier::Sampled);
    let of_peak = of_peak.ok().and_then(|bound| bound.of_path(PathIndex(0)));
    let tells_more = path.bound_m.zip(of_peak).is_some_and(|(all, few)| all < 0.8 * few);
    ensure!(tells_more, "side lobes tell nothing: {:?} m and {of_peak:?} m", path.bound_m);
    let ratio = path.std_m.zip(path.bound_m).map_or(f64::NAN, |(std, bound)| std / bound);
    CaseMeasurement::deviation([(ratio - 1.0) * (2.0 * SCANS as f64).sqrt()])
}

fn image_over_light(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let settings = [
        "array.rows=16",
        "array.columns=24",
        "array.focal_length=0.28125 mm",
        "array.plane[1].reflectance=0.002",
        "source.mean_power=45 W",
    ];
    let settings = settings.map(str::parse).into_iter().collect::<Result<Vec<_>, _>>()?;
    let text = include_str!("../../../scenes/image.toml");
    let scene = scene::parse_with("image.toml", text, &settings)?;
    let (z, span) = deviations_of_pixels(&scene, seed)?;
    ensure!(span > 1e3, "the light spans a factor of {span} alone");
    let square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
    CaseMeasurement::between(square.sqrt(), "standard deviations", [0.9, 1.1])
}

fn uncovered_expectations() -> Result<CaseMeasurement, CaseError> {
    let mut outside = fitted(20e6, 2500)?;
    (outside.scan.first_step, outside.scan.steps) = (160, 32);
    let mut clamped = table_i(GOLD_5, 20e6, 2500)?;
    clamped.hardware.counter_width = Some(6);
    let mut other_clock = table_i(GOLD_5, 2e6, 2500)?;
    let mut light = other_clock.sources[0].clone();
    light.name = "other".to_owned();
    light.clock.offset = 3e-4;
    light.mean_power_w *= 10.0;
    other_clock.sources.push(light);
    let mut path = other_clock.paths[0].clone();
    path.source = SourceIndex(1);
    other_clock.paths.push(path);
    let given = [outside, clamped, other_clock].iter().filter(|scene| is_expected(scene)).count();
    let covered = [fitted(20e6, 2500)?, table_i(GOLD_5, 20e6, 2500)?];
    CaseMeasurement::none(
        given,
        covered.iter().filter(|scene| is_expected(scene)).count(),
        "expectations",
    )
}

/// Whether a scatter is expected of a scene's own path.
fn is_expected(scene: &Scene) -> bool {
    predicted(scene, CountingTier::Sampled).is_ok_and(|expected| expected.std_m > 0.0)
}

fn all_steps_at_once(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let scene = scene::parse("all-steps.toml", ALL_STEPS)?;
    let found = scanned(&Sensor::new(&scene), Tier::Counts, seed, 300)?;
    let is_alike = |counts: &&Vec<StepCount>| {
        counts.windows(2).all(|neighbours| neighbours[0].signed == neighbours[1].signed)
    };
    CaseMeasurement::none(found.iter().filter(is_alike).count(), found.len(), "scans")
}

/// Two paths, all 14 phase steps at once: sums of neighbouring counts have hardly any variance.
const ALL_STEPS: &str = r#"
clock = { chip_period = "2 ns", samples_per_chip = 2 }
source = [{ name = "laser", code = { family = "chips", chips = "0111001" }, mean_power = "1.334 pW", extinction_ratio = 10 }]
path = [
    { source = "laser", detector = "spad", delay = "6.497454 ns" },
    { source = "laser", detector = "spad", delay = "2.339781 ns", transmission = 0.4982 },
]
scan = { steps = "all", integration = "579074 ns" }
hardware = { parallel = 14 }
[[detector]]
name = "spad"
reference = "laser"
photon_detection_probability = 0.31
dead_time = "2 ns"
dark_count_rate = "18744.71 cps"
background_rate = "4303936 cps"
afterpulsing = { probability = 0.136, time_constant = "5 ns" }
jitter = ["53.5 ps", "4 ps"]
"#;

fn jitter_merges_nothing() -> Result<CaseMeasurement, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, 250)?;
    scene.detectors[0].jitter_ps = vec![1000.0];
    scene.detectors[0].pulse_width_ps = 7000.0;
    let mut merging = scene.clone();
    merging.detectors[0].pulse_width_ps = 20_000.0;
    let wrong = usize::from(!is_expected(&scene)) + usize::from(is_expected(&merging));
    CaseMeasurement::none(wrong, 2, "verdicts")
}

fn nobody_else(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let sensor = Sensor::new(&fitted(4e6, 13_100)?);
    let model = DetectorModel::new(&sensor, FIRST);
    let response = MeanResponse::of_tier(&model, CountingTier::Events)?;
    let second = SecondMoments::new(&response)?;
    let sampler = CountSampler::of(&model, &second)?;
    let fitter = Fitter::new(&sensor, FIRST, CountingTier::Events, OtherLight::Search);
    let found = (0..40).filter(|&scan| {
        let fit = fitter.fit(&drawn(&sampler, 248, seed, scan));
        fit.map_or(true, |fit| fit.paths.len() != 1)
    });
    CaseMeasurement::between(found.count() as f64, "scans", [0.0, 1.0])
}

fn right_scene_beside_light(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let code = r#"{ family = "gold", degree = 7, index = 3 }"#;
    let mut scene = table_i(code, 1.2e6, 12_500)?;
    (scene.estimator, scene.hardware.total_counts) = (EstimatorKind::Model, Some(true));
    let mut light = scene.sources[0].clone();
    light.name = "bright".to_owned();
    light.code = table_i(&code.replace('3', "9"), 1e6, 12_500)?.sources[0].code.clone();
    light.mean_power_w *= 10.0;
    scene.sources.push(light);
    let mut path = scene.paths[0].clone();
    (path.source, path.delay_ps) = (SourceIndex(1), 501_100.0);
    scene.paths.push(path);
    let sensor = Sensor::new(&scene);
    let is_accused = |sensor: &Sensor, counts: &[StepCount]| {
        let scan = RecordedScan { detector: FIRST, counts: counts.to_vec(), has_totals: true };
        let found = assess(sensor, &scan).diagnosis;
        found.is_none_or(|found| !found.causes.is_empty())
    };
    let found = scanned(&sensor, Tier::Sampled, seed, 10)?;
    ensure!(found.iter().all(|counts| seen(counts) > 0), "a scan has counted nothing");
    // Three metres of another distance are seen.
    let farther = sensor.with(|scene| scene.paths[0].delay_ps += 20_000.0);
    let is_told = found.first().is_some_and(|counts| is_accused(&farther, counts));
    ensure!(is_told, "a scene that is wrong is not said to be");
    let accused = found.iter().filter(|counts| is_accused(&sensor, counts)).count();
    CaseMeasurement::between(accused as f64, "scans", [0.0, 1.0])
}

fn far_paths() -> Result<CaseMeasurement, CaseError> {
    const PERIOD_FS: u64 = 248_000_000;
    const FAR_FS: u64 = 133_425_638_079;
    let mut scene = table_i(GOLD_5, 20e6, 2480)?;
    scene.paths.push(scene.paths[0].clone());
    let mut signed = |second_fs: u64| -> Result<Vec<f64>, CaseError> {
        scene.paths[1].delay_ps = second_fs as f64 * 1e-3;
        Ok(mean_counts(&scene)?.iter().map(|count| count.signed).collect())
    };
    let far = signed(FAR_FS)?;
    let near = signed(FAR_FS % PERIOD_FS)?;
    let elsewhere = signed(FAR_FS % PERIOD_FS + PERIOD_FS / 2)?;
    // What the second path adds where it is, and nowhere else.
    let largest = |a: &[f64], b: &[f64]| worst(a.iter().zip(b).map(|(a, b)| a - b));
    let (peak, difference) = (largest(&far, &elsewhere), largest(&far, &near));
    ensure!(peak > 100.0, "the second path shows in {peak:.1} counts");
    CaseMeasurement::largest([difference / peak], "of the peak", 1e-6)
}
