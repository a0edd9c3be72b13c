//! From counts to distance: bounds, expectations and diagnoses where they are tempted most.

use super::case::{Case, CaseError, Group, Measured};
use super::scenes::{GOLD_5, table_i};
use super::statistics::worst;
use crate::estimate::fit::Fitter;
use crate::estimate::{CountingTier, predict};
use crate::photons::DetectorModel;
use crate::recorded::{RecordedScan, assess};
use crate::response::{CountSampler, MeanResponse, SecondMoments};
use crate::scene::{DetectorIndex, EstimatorKind, OtherLight, PathIndex, Scene, SourceIndex};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::repeat::simulate;
use crate::simulate::scans::scans;

const FIRST: DetectorIndex = DetectorIndex(0);
const OWN: PathIndex = PathIndex(0);

pub(super) const CASES: &[Case] = &[
    Case {
        name: "the-fit-reaches-the-bound-of-all-steps",
        group: Group::Light,
        quick: false,
        what: "standard deviation of 400 fits over the Cramer-Rao bound, less one, Table I with a code \
               of 31 chips, in standard errors of that ratio",
        why: "the fit takes the likelihood of the same counts, and its errors are nearly normal: a bound \
              of fewer steps is undercut, a fit of fewer steps falls short",
        run: fit_reaches_bound,
    },
    Case {
        name: "expectations-of-what-is-not-covered",
        group: Group::Numbers,
        quick: true,
        what: "expected errors that are given for a target outside of the scan, for counts that are \
               clamped, and for bright light of another clock",
        why: "there the linear theory of the peak that is looked for says nothing of what is found",
        run: |_| uncovered_expectations(),
    },
    Case {
        name: "all-steps-at-once-drawn",
        group: Group::Numbers,
        quick: true,
        what: "of 300 drawn scans of all 56 steps at once, a code of 7 chips, those in which all steps count the \
               same",
        why: "the same photons are counted by every step, but the steps' signs differ: the peak stands out \
              by thousands of counts",
        run: all_steps_at_once,
    },
    Case {
        name: "jitter-of-a-nanosecond-merges-nothing",
        group: Group::Detectors,
        quick: true,
        what: "expectations refused for pulses said to merge, jitter of 1 ns, dead time twice the pulse \
               width",
        why: "two avalanches are 14 ns apart; jitter brings their pulses within 7 ns of each other once in \
              10^6",
        run: |_| jitter_merges_nothing(),
    },
    Case {
        name: "nobody-else-is-found-where-nobody-is",
        group: Group::Light,
        quick: true,
        what: "of 40 scans of one sensor alone, code of 31 chips, those in which the search finds others, or \
               nothing at all",
        why: "thresholds are for one scan in a thousand",
        run: nobody_else,
    },
    Case {
        name: "a-right-scene-beside-ten-times-brighter-light",
        group: Group::Light,
        quick: false,
        what: "of 10 scans of a sensor beside another one ten times as bright, those whose right scene is \
               said to be wrong",
        why: "six tests at 0.2 % each: two or more of ten once in 120",
        run: right_scene_beside_light,
    },
    Case {
        name: "paths-of-3-m-and-20-km",
        group: Group::Stiff,
        quick: true,
        what: "largest relative difference of expected total counts when the second of two paths becomes a \
               whole number of code periods (some 20 km) longer, jitter of 54 ps, all of Table I",
        why: "light that repeats comes the same after whole periods; a double holds 1.3 10^8 ps to 2 \
              10^-8 ps",
        run: |_| far_paths(),
    },
];

/// Table I at 3.2 m with the fit, a code of 31 chips and so many chips a step.
fn fitted(rate_cps: f64, chips: u64) -> Result<Scene, CaseError> {
    let mut scene = table_i(GOLD_5, rate_cps, chips)?;
    scene.estimator = EstimatorKind::Model;
    scene.hardware.total_counts = Some(true);
    Ok(scene)
}

fn fit_reaches_bound(seed: u64) -> Result<Measured, CaseError> {
    const SCANS: u64 = 400;
    let simulation = simulate(&Sensor::new(&fitted(20e6, 2500)?), Tier::Counts, seed, SCANS)?;
    let path = &simulation.estimates[0];
    let ratio = path.std_m.zip(path.bound_m).map_or(f64::NAN, |(std, bound)| std / bound);
    Measured::deviation((ratio - 1.0) * (2.0 * SCANS as f64).sqrt())
}

fn uncovered_expectations() -> Result<Measured, CaseError> {
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
    let is_given =
        |scene: &&Scene| predict(&Sensor::new(scene), FIRST, OWN, CountingTier::Sampled).is_ok();
    let given = [outside, clamped, other_clock].iter().filter(is_given).count();
    Measured::none(given, "expectations")
}

fn all_steps_at_once(seed: u64) -> Result<Measured, CaseError> {
    let mut scene = table_i(r#"{ family = "chips", chips = "0111001" }"#, 20e6, 250_000)?;
    scene.hardware.parallel = 56;
    let mut alike = 0;
    scans(&Sensor::new(&scene), FIRST, Tier::Counts, seed, 300, |counts| {
        alike += usize::from(counts.iter().all(|count| count.signed == counts[0].signed));
    })?;
    Measured::none(alike, "scans")
}

fn jitter_merges_nothing() -> Result<Measured, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, 250)?;
    scene.detectors[0].jitter_ps = vec![1000.0];
    scene.detectors[0].pulse_width_ps = 7000.0;
    let refused = predict(&Sensor::new(&scene), FIRST, OWN, CountingTier::Sampled).is_err();
    Measured::none(usize::from(refused), "refusals")
}

fn nobody_else(seed: u64) -> Result<Measured, CaseError> {
    let sensor = Sensor::new(&fitted(4e6, 13_100)?);
    let model = DetectorModel::new(&sensor, FIRST);
    let response = MeanResponse::of_tier(&model, CountingTier::Events)?;
    let second = SecondMoments::new(&response)?;
    let sampler = CountSampler::of(&model, &second)?;
    let fitter = Fitter::new(&sensor, FIRST, CountingTier::Events, OtherLight::Search);
    let found = (0..40).filter(|&scan| {
        let fit = fitter.fit(&sampler.scan(seed, scan));
        fit.map_or(true, |fit| fit.paths.len() != 1)
    });
    Measured::at_most(found.count() as f64, "scans", 1.0)
}

fn right_scene_beside_light(seed: u64) -> Result<Measured, CaseError> {
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
    let mut accused = 0;
    scans(&sensor, FIRST, Tier::Sampled, seed, 10, |counts| {
        let scan = RecordedScan { detector: FIRST, counts: counts.to_vec(), has_totals: true };
        let found = assess(&sensor, &scan).diagnosis;
        accused += u32::from(found.is_none_or(|found| !found.causes.is_empty()));
    })?;
    Measured::at_most(f64::from(accused), "scans", 1.0)
}

fn far_paths() -> Result<Measured, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, 2480)?;
    let totals = |scene: &Scene| -> Result<Vec<f64>, CaseError> {
        let model = DetectorModel::new(&Sensor::new(scene), FIRST);
        let response = MeanResponse::of_tier(&model, CountingTier::Events)?;
        Ok(response.mean_counts().iter().map(|count| count.total).collect())
    };
    let second = scene.paths[0].clone();
    scene.paths.push(second);
    let near = totals(&scene)?;
    let period_ps = scene.clock().ps(scene.sources[0].code.len() as f64);
    scene.paths[0].delay_ps += (1.334e8 / period_ps).round() * period_ps;
    let far = totals(&scene)?;
    let differences = near.iter().zip(&far).map(|(near, far)| far / near - 1.0);
    Measured::at_most(worst(differences), "of the count", 1e-9)
}
