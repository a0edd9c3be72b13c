//! With `parallel` phase steps at once, the steps of a group count the same
//! detections: in every tier, and in what theory expects.

use goldtof::Jobs as _;
use goldtof::estimate::bound::bound;
use goldtof::estimate::fit::{Fitter, ModelEstimate, OtherLight};
use goldtof::estimate::predict;
use goldtof::photons::fast::StepCounter;
use goldtof::photons::{DetectorModel, StepCount, count_step};
use goldtof::response::{CountSampler, CountingTier, MeanResponse, SecondMoments};
use goldtof::scan::{Group, Step};
use goldtof::scene::{DetectorIndex, PathIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::path_statistics::PathStatistics;
use goldtof::simulate::scans::scans;
use optics_support::{assert_within_standard_errors, gold_5, repeated, table_i_scene};

const PARALLEL: u32 = 4;

/// Table I with a code of 31 chips, at 10 million detections per second, and
/// steps that are no whole number of code periods.
fn scene() -> Scene {
    let mut scene = table_i_scene(gold_5(), 12e6, 31 * 20 + 17);
    scene.hardware.parallel = PARALLEL;
    scene
}

/// The scene whose continuous-time counter counts what the sampled hardware of
/// `scene` does: sample s stands for the registered times in ((s - 1) T_s, s T_s],
/// so the detections come T_s later, and the counter's edges are where they are.
fn as_sampled(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let spad = &mut scene.detectors[0];
    spad.delay_ps += scene.chip_period_ps / f64::from(scene.samples_per_chip);
    spad.counter.rising_delay_ps = 0.0;
    spad.counter.falling_delay_ps = 0.0;
    spad.counter.transition_ps = 0.0;
    scene
}

/// Mean and variance of the mean of every step's signed count, over scans.
fn step_means(all: &[Vec<StepCount>]) -> Vec<(f64, f64)> {
    let n = all.len() as f64;
    (0..all[0].len())
        .map(|step| {
            let values = || all.iter().map(|scan| scan[step].signed as f64);
            let mean = values().sum::<f64>() / n;
            let squares: f64 = values().map(|v| (v - mean).powi(2)).sum();
            (mean, squares / (n - 1.0) / n)
        })
        .collect()
}

/// Scans of a tier, from a seed of its own: of the same seed the tiers see the same avalanches.
fn collect(scene: &Scene, tier: Tier, repetitions: u64) -> Vec<Vec<StepCount>> {
    let mut all = Vec::new();
    let seed = 3 + tier as u64;
    scans(&Sensor::new(scene), DetectorIndex(0), tier, seed, repetitions, |scan| {
        all.push(scan.to_vec())
    })
    .unwrap();
    all
}

/// Holds every step's means against each other: no single one far off, and
/// their squares together as chance has it. Steps of a group go together, so
/// there are no more independent ones than groups.
fn assert_same_means(a: &[(f64, f64)], b: &[(f64, f64)], what: &str) {
    assert_eq!(a.len(), b.len());
    let z: Vec<f64> =
        a.iter().zip(b).map(|((x, vx), (y, vy))| (x - y) / (vx + vy).sqrt()).collect();
    for (step, z) in z.iter().enumerate() {
        assert_within_standard_errors(*z, 5.0, &format!("{what}, step {step}"));
    }
    let groups = z.len() as f64 / f64::from(PARALLEL);
    let mean_square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
    assert_within_standard_errors(
        (mean_square - 1.0) / (2.0 / groups).sqrt(),
        5.0,
        &format!("{what}, squares"),
    );
}

#[test]
fn steps_of_a_group_count_the_same_detections() {
    let scene = scene();
    let steps = scene.scan.steps as usize;
    for tier in [Tier::Counts, Tier::Events, Tier::Sampled] {
        let scan = &collect(&scene, tier, 1)[0];
        assert_eq!(scan.len(), steps);
        let totals: Vec<u64> = scan.iter().map(|count| count.total).collect();
        let groups: Vec<&[u64]> = totals.chunks(PARALLEL as usize).collect();
        for group in &groups {
            assert!(group.iter().all(|total| total == &group[0]), "{tier}: {group:?}");
        }
        let mut different: Vec<u64> = groups.iter().map(|group| group[0]).collect();
        different.sort_unstable();
        different.dedup();
        assert!(different.len() > 10, "{tier}: {different:?}");
    }
}

#[test]
fn the_tiers_agree_step_by_step() {
    let hardware = scene();
    let counter = as_sampled(&hardware);
    let sampled = step_means(&collect(&hardware, Tier::Sampled, 400));
    let events = step_means(&collect(&counter, Tier::Events, 400));
    assert_same_means(&sampled, &events, "events");
    let counts = step_means(&collect(&hardware, Tier::Counts, 400));
    assert_same_means(&sampled, &counts, "counts");
    let model = DetectorModel::new(&Sensor::new(&hardware), DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, CountingTier::Sampled).unwrap();
    let expected: Vec<(f64, f64)> =
        response.mean_counts().iter().map(|mean| (mean.signed, 0.0)).collect();
    assert_same_means(&sampled, &expected, "expected");
}

#[test]
fn a_last_group_that_is_not_full_is_counted_too() {
    let mut hardware = scene();
    hardware.hardware.parallel = 5;
    hardware.scan.first_step = 243;
    hardware.scan.steps = 13;
    let counter = as_sampled(&hardware);
    let sampled = step_means(&collect(&hardware, Tier::Sampled, 500));
    let events = step_means(&collect(&counter, Tier::Events, 500));
    assert_eq!(sampled.len(), 13);
    assert_same_means(&sampled, &events, "events");
}

#[test]
fn lanes_and_plain_loop_agree() {
    let mut scene = scene();
    scene.scan.steps = 16;
    let all = |scene: &Scene, fast: bool| -> Vec<Vec<StepCount>> {
        let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
        let counter = StepCounter::new(&model);
        if fast {
            assert!(counter.outside_domain().is_none());
            let mut counts = vec![StepCount::ZERO; 300 * 16];
            counter.count(1, 0..300, 0..16, &mut counts);
            return counts.chunks(16).map(<[_]>::to_vec).collect();
        }
        let scan = |repetition| {
            let count = |step| count_step(&model, 2, repetition, step);
            Step::all(16).map(count).collect()
        };
        (0..300).map(scan).collect()
    };
    // The second jitter reaches from one step's edge to the next one's.
    for jitter_ps in [53.5, 90.0] {
        scene.detectors[0].jitter_ps = vec![jitter_ps];
        let (fast, plain) = (all(&scene, true), all(&scene, false));
        let what = format!("lanes, {jitter_ps} ps");
        assert_same_means(&step_means(&fast), &step_means(&plain), &what);
    }
}

#[test]
fn covariances_of_a_group_are_those_of_its_counts() {
    let mut scene = scene();
    scene.scan.first_step = 160;
    scene.scan.steps = u64::from(PARALLEL);
    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, CountingTier::Events).unwrap();
    let moments = SecondMoments::new(&response).unwrap().of_group(Group(0));
    let scans = collect(&scene, Tier::Events, 20_000);
    let n = scans.len() as f64;
    let value = |scan: &[StepCount], i: usize| match scan.get(i) {
        Some(count) => count.signed as f64 - moments.signed_means[i],
        None => scan[0].total as f64 - moments.total_mean,
    };
    let count = PARALLEL as usize + 1;
    for i in 0..count {
        for j in 0..=i {
            let found = scans.iter().map(|s| value(s, i) * value(s, j)).sum::<f64>() / n;
            let c = &moments.covariance;
            let error = ((c[i][i] * c[j][j] + c[i][j] * c[i][j]) / n).sqrt();
            // Two per cent of a variance on top: the code's phase at the rim of a
            // step is taken to the whole chip.
            let limit = 4.5 * error + 0.02 * (c[i][i] * c[j][j]).sqrt();
            assert!((found - c[i][j]).abs() < limit, "{i} {j}: {found} {}", c[i][j]);
        }
    }
    // Neighbours go together, which independent light would not.
    assert!(moments.covariance[0][1] > 0.5 * moments.covariance[0][0]);
}

#[test]
fn the_predicted_scatter_knows_that_steps_of_a_group_go_together() {
    let scene = scene();
    let mut alone = scene.clone();
    alone.hardware.parallel = 1;
    let of = |tier: Tier, repetitions| -> PathStatistics {
        Sensor::new(&scene).simulate(tier.scans(repetitions).seeded(5)).unwrap().estimates[0]
            .clone()
    };
    let independent =
        predict(&Sensor::new(&alone), DetectorIndex(0), PathIndex(0), CountingTier::Events)
            .unwrap()
            .std_m;
    for (tier, repetitions) in
        [(Tier::Counts, 3_000), (Tier::Events, 1_500), (Tier::Sampled, 1_500)]
    {
        let found = of(tier, repetitions);
        let sensor = Sensor::new(&scene);
        let counting = tier.counting(&sensor);
        let expected = predict(&sensor, DetectorIndex(0), PathIndex(0), counting).unwrap();
        let (std, error) = (found.std_m.unwrap(), found.std_std_error_m.unwrap());
        assert_within_standard_errors((std - expected.std_m) / error, 4.5, &format!("{tier} std"));
        let z = (found.bias_m.unwrap() - expected.bias_m) / found.bias_std_error_m.unwrap();
        assert_within_standard_errors(z, 4.5, &format!("{tier} bias"));
        // Independent steps would scatter by something else altogether.
        assert!((std - independent).abs() > 6.0 * error, "{tier}: {std} {independent}");
    }
    let expected = of(Tier::Expected, 7);
    assert_eq!(expected.estimates, 0);
    assert_eq!(expected.std_m, expected.expected_std_m);
}

/// Under light that keeps the detector blind nearly all the time, so that it starts
/// anywhere in a dead time: the start, too, belongs to the light that a group shares.
#[test]
fn steps_of_a_group_share_the_start_of_a_detector_that_is_nearly_always_blind() {
    const STEPS: u64 = 8;
    const SCANS: u64 = 24;
    let mut scene = scene();
    let spad = &mut scene.detectors[0];
    spad.background_rate_cps = 65e9;
    spad.afterpulsing_probability = 0.0;
    scene.scan.steps = STEPS;
    scene.scan.integration_chips = 1_249;
    // The detector fires once in a dead time and a wait for light.
    let spad = &scene.detectors[0];
    let wait_ps = 1e12 / (spad.background_rate_cps * spad.photon_detection_probability);
    let step_ps = 1_249.0 * scene.chip_period_ps;
    let turns = step_ps / (spad.dead_time_ps + wait_ps);

    let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
    let counter = StepCounter::new(&model);
    assert_eq!(counter.outside_domain(), None, "the lanes must be used");
    let mut lanes = vec![StepCount::ZERO; (SCANS * STEPS) as usize];
    counter.count(1, 0..SCANS, 0..STEPS, &mut lanes);
    let plain = |repetition: u64| -> Vec<StepCount> {
        let count = |step| count_step(&model, 2, repetition, step);
        Step::all(STEPS).map(count).collect()
    };
    let engines: [(&str, Vec<Vec<StepCount>>); 2] = [
        ("lanes", lanes.chunks(STEPS as usize).map(<[_]>::to_vec).collect()),
        ("plain loop", (0..SCANS).map(plain).collect()),
    ];
    for (engine, scans) in &engines {
        let mut of_groups = Vec::new();
        for group in scans.iter().flat_map(|scan| scan.chunks(PARALLEL as usize)) {
            let totals: Vec<u64> = group.iter().map(|count| count.total).collect();
            assert!(totals.iter().all(|t| t == &totals[0]), "{engine}: {totals:?}");
            of_groups.push(totals[0] as f64);
        }
        // A clock whose phase is anywhere: the whole number below or above.
        let n = of_groups.len() as f64;
        let mean = of_groups.iter().sum::<f64>() / n;
        let whole = turns.floor();
        let spread = ((turns - whole) * (1.0 - turns + whole)).max(0.1);
        let what = format!("{engine}: {mean} for {turns}");
        assert_within_standard_errors((mean - turns) / (spread / n).sqrt(), 5.0, &what);
        let (least, most) = of_groups
            .iter()
            .fold((f64::MAX, 0.0_f64), |(least, most), &n| (least.min(n), most.max(n)));
        assert!(least < most, "{what}: groups have light of their own");
    }
}

/// Holds fits of many scans against truth and bound: bias, scatter, what the fits say of
/// themselves, and chi-square.
fn check_fits(scene: &Scene, fits: &[ModelEstimate], what: &str) {
    let bound = bound(&Sensor::new(scene), DetectorIndex(0), CountingTier::Events);
    let bound = bound.expect("a bound").of_path(PathIndex(0));
    let bound_m = bound.expect("that of the path");
    let scans = fits.len() as f64;
    let truth_m = scene.paths[0].distance_m();
    let errors: Vec<f64> = fits.iter().map(|fit| fit.distance_m - truth_m).collect();
    let bias = errors.iter().sum::<f64>() / scans;
    let variance = errors.iter().map(|e| (e - bias).powi(2)).sum::<f64>() / (scans - 1.0);
    let ratio = variance.sqrt() / bound_m;
    let claimed = fits.iter().map(|fit| fit.std_m).sum::<f64>() / scans / variance.sqrt();
    let degrees = fits[0].degrees_of_freedom as f64;
    let chi_square = fits.iter().map(|fit| fit.chi_square).sum::<f64>() / scans / degrees;
    let largest = errors.iter().fold(0.0_f64, |most, e| most.max(e.abs())) / bound_m;
    println!(
        "{what}: bound {:.2} mm, bias {:.2} mm, std / bound {ratio:.3}, own std / std \
         {claimed:.3}, chi-square {chi_square:.3} a degree of {degrees}, largest {largest:.2} \
         bounds",
        1e3 * bound_m,
        1e3 * bias,
    );
    let error = 1.0 / (2.0 * (scans - 1.0)).sqrt();
    assert_within_standard_errors((ratio - 1.0) / error, 4.0, "std / bound");
    assert_within_standard_errors((claimed - 1.0) / error, 4.0, "own std / std");
    assert_within_standard_errors(bias / bound_m * scans.sqrt(), 5.0, "bias");
    let spread = (2.0 / degrees / scans).sqrt();
    assert_within_standard_errors((chi_square - 1.0) / spread, 5.0, "chi-square");
}

fn scene_of(parallel: u32, periods: u64) -> Scene {
    let mut scene = scene();
    scene.scan.integration_chips = 31 * periods;
    scene.hardware.parallel = parallel;
    scene
}

/// The model estimator: steps of a group are weighed with what they know of each other, so
/// that its scatter is the bound's and its own standard deviation and chi-square hold.
#[test]
fn the_fit_meets_the_bound_with_steps_that_share_their_light() {
    let (detector, tier) = (DetectorIndex(0), CountingTier::Events);
    for (parallel, periods) in [(4, 200), (16, 200), (16, 1600)] {
        let scene = scene_of(parallel, periods);
        let sensor = Sensor::new(&scene);
        let model = DetectorModel::new(&sensor, detector);
        let response = MeanResponse::of_tier(&model, tier).expect("a response");
        let second = SecondMoments::new(&response).expect("second moments");
        let sampler = CountSampler::of(&model, &second).expect("finite moments");
        let fitter = Fitter::new(&sensor, detector, tier, OtherLight::Given);
        let fits =
            (0..repeated(80, 150)).map(|scan| fitter.fit(&sampler.scan(11, scan)).expect("a fit"));
        let what = format!("moments, parallel {parallel}, {periods} periods");
        check_fits(&scene, &fits.collect::<Vec<_>>(), &what);
    }
}

/// The same on photons.
#[test]
fn the_fit_meets_the_bound_in_photons_of_shared_light() {
    let scene = scene_of(4, 100);
    let (detector, tier) = (DetectorIndex(0), CountingTier::Events);
    let sensor = Sensor::new(&scene);
    let fitter = Fitter::new(&sensor, detector, tier, OtherLight::Given);
    let mut fits: Vec<ModelEstimate> = Vec::new();
    scans(&sensor, detector, Tier::Events, 3, 100, |scan| {
        fits.push(fitter.fit(scan).expect("a fit"));
    })
    .unwrap();
    check_fits(&scene, &fits, "photons, parallel 4");
}

/// All steps at once count one and the same light: sums of their counts are known, and
/// their covariance has directions in which nothing varies. Counts that are drawn have the
/// means and variances of those that photons make.
#[test]
fn counts_of_all_steps_at_once_are_drawn_as_photons_make_them() {
    let mut scene = table_i_scene(gold_5(), 4e6, 31 * 1000);
    scene.samples_per_chip = 2;
    scene.scan.steps = 62;
    for parallel in [62, 14] {
        scene.hardware.parallel = parallel;
        let drawn = collect(&scene, Tier::Counts, 600);
        let photons = collect(&as_sampled(&scene), Tier::Events, 150);
        let variance = |all: &[Vec<StepCount>]| {
            step_means(all).iter().map(|(_, v)| v * all.len() as f64).collect::<Vec<_>>()
        };
        let means = step_means(&drawn).into_iter().zip(step_means(&photons));
        for (step, ((drawn, a), (counted, b))) in means.enumerate() {
            let what = format!("mean of step {step}, {parallel} at once");
            assert_within_standard_errors((drawn - counted) / (a + b).sqrt(), 5.0, &what);
        }
        let error = (2.0 / 600.0 + 2.0 / 150.0_f64).sqrt();
        for (step, (a, b)) in variance(&drawn).into_iter().zip(variance(&photons)).enumerate() {
            let what = format!("variance of step {step}, {parallel} at once");
            assert_within_standard_errors((a / b - 1.0) / error, 5.5, &what);
        }
    }
}
