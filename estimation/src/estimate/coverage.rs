//! The range of validity of expectations, decided in one place.
//!
//! Each approximation behind an expected bias, standard deviation and share of missed peaks
//! has a name, a measure of its size in the scene at hand, and a bound beyond which no number is
//! given. Every expectation is checked here, whatever the tier and the command; a missing check
//! shows when scans are compared with expectations ([`super::evidence`]).

use super::approximation::Approximation;
use super::evidence::ExpectedErrors;
use super::fit::slipping::SlippingLight;
use super::fit::{
    FittedPath, ModelEstimate, TOLD_APART, check_shared_light, folds_over, own_threshold,
};
use super::missed::errors_wrap;
use super::prediction::Prediction;
use super::truth::Asked;
use super::{CountingTier, distance_m};
use crate::math::normal_cdf;
use crate::photons::DetectorModel;
use crate::photons::light::ExcessLight;
use crate::response::{Light, MOST_CORRELATION, MeanResponse, MeanResponseError};
use crate::scene::{Architecture, DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Whether anything can be expected of a path's estimates by either estimator: the scan comes
/// by the path, and counts are not clamped.
///
/// # Errors
/// What does not hold.
pub(super) fn check_scene(asked: &Asked) -> Result<(), Approximation> {
    outside_scan(asked).check()?;
    let model = DetectorModel::new(asked.sensor, asked.detector);
    short_steps(&model).check()?;
    steady_beside(&model).check()?;
    folds_over(&model, Light::of(&model).of_cell(&model).brightest_per_chip()).check()?;
    match clamped(asked) {
        // Without a response the expectation fails for that reason.
        Err(_) | Ok(None) => Ok(()),
        Ok(Some(clamped)) => clamped.check(),
    }
}

/// Whether `expected` can be expected of a path's estimates by the fit, whose answer to the
/// expected counts is `fitted`: the scan comes by the path, counts are not clamped, all light
/// is told apart, and no other peak of the likelihood is near.
///
/// # Errors
/// What does not hold.
pub fn check_fit(
    sensor: &Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    counting: CountingTier,
    (fitted, expected): (&ModelEstimate, ExpectedErrors),
) -> Result<(), Approximation> {
    let asked = Asked { sensor, detector, path, tier: counting };
    check_scene(&asked)?;
    are_moments(fitted.most_correlated).check()?;
    let untold = fitted.untold.as_ref();
    Approximation {
        name: "that the fit tells all paths apart",
        measure: "paths that the expected counts do not show:",
        size: untold.map_or(0, |untold| untold.missing + untold.missing_of_others) as f64,
        bound: 0.0,
        concerns_misses: true,
    }
    .check()?;
    Approximation {
        name: "that the fit tells close paths apart in every scan",
        measure: "probability that two are taken for one:",
        size: normal_cdf(TOLD_APART.sqrt() - fitted.told_apart_by),
        bound: 0.02,
        concerns_misses: true,
    }
    .check()?;
    let model = DetectorModel::new(sensor, detector);
    if sensor.scene().hardware.architecture == Architecture::UpDown {
        check_shared_light(sensor, detector)?;
        within_corners(sensor, expected.std_m).check()?;
    }
    if model.modulated_paths().count() + model.slipping().count() <= 1 {
        return Ok(());
    }
    let chips = sensor.timing().scan.steps as f64 / f64::from(sensor.clock().samples_per_chip);
    let weakest = fitted.paths.iter().map(FittedPath::significance).fold(f64::INFINITY, f64::min);
    Approximation {
        name: "that each path stands out from other light in every scan",
        measure: "probability that the weakest one does not:",
        size: normal_cdf(own_threshold(chips) - weakest),
        bound: 0.02,
        concerns_misses: true,
    }
    .check()
}

/// Share of a chip, for each sample that it has, by which a fit's distance may scatter: beyond that it finds other corners of
/// the code's correlation. Measured: of one sample a chip as expected at 0.027 chips, 1.4 times as far at 0.039 and 1.6 at 0.05;
/// of two within 7 % at 0.05. With several steps at once of one sample a chip up to 3 times as far at 0.03.
const MOST_CHIPS_A_SAMPLE: f64 = 0.03;
/// The same of many: the likelihood of dim light has as high peaks anywhere, and the likeliest delay is any.
const MOST_CHIPS: f64 = 0.25;

/// How far a fit's distance scatters beside the corners of the code's correlation.
pub(super) fn within_corners(sensor: &Sensor, std_m: f64) -> Approximation {
    let clock = sensor.clock();
    let samples = f64::from(clock.samples_per_chip);
    let is_one_of_several = samples == 1.0 && sensor.timing().parallel > 1;
    Approximation {
        name: match is_one_of_several {
            true => {
                "that the fit finds the right corner of the code's correlation, which of one sample a chip needs \
                 parallel = 1"
            }
            false => {
                "that the fit finds the right corner of the code's correlation (more samples_per_chip or light help)"
            }
        },
        measure: "standard deviation in chips:",
        size: std_m / distance_m(clock.chip_period_ps),
        bound: if is_one_of_several {
            0.0
        } else {
            (samples * MOST_CHIPS_A_SAMPLE).min(MOST_CHIPS)
        },
        concerns_misses: false,
    }
}

/// Whether a phase step lasts long beside the detector's memory: moments are worked out without the rims of
/// steps. Measured for Table I's detector at 10 and 40 million detections per second, variances are 2.4 % off
/// in steps of 6 memories, and 0.7 % of 20.
pub fn short_steps(model: &DetectorModel) -> Approximation {
    let brightest = Light::of(model).of_cell(model).brightest_per_chip();
    let memory = model.memory_under(brightest).scale_chips();
    Approximation {
        name: "that a phase step is long beside the detector's memory",
        measure: "share of a step that it remembers:",
        size: memory / model.timing().scan.integration_chips as f64,
        bound: 1.0 / 6.0,
        concerns_misses: true,
    }
}

/// How many phase steps a measured delay is outside of the scan: half a step beyond its rims is within.
pub fn steps_outside(sensor: &Sensor, measured_ps: f64) -> f64 {
    let scan = &sensor.timing().scan;
    let period = scan.steps_per_period as f64;
    let place = measured_ps / sensor.clock().sample_period_ps() - scan.first_step as f64;
    let after_first = place.rem_euclid(period);
    let beyond_last = after_first - (scan.steps - 1) as f64;
    let outside = beyond_last.min(period - after_first);
    if scan.is_full() || outside <= MOST_OUTSIDE { 0.0 } else { outside }
}

/// Steps beyond a scan's rims that are within it.
const MOST_OUTSIDE: f64 = 0.5;

/// How far a path's delay is outside of the scan.
fn outside_scan(asked: &Asked) -> Approximation {
    let offset_ps = asked.offset_ps();
    Approximation {
        name: match offset_ps > 0.0 {
            true => {
                "that the true delay is in the scan (detector.delay is added to that of the path)"
            }
            false => "that the true delay is in the scan",
        },
        measure: "it is outside by this many phase steps:",
        size: steps_outside(asked.sensor, asked.truth().delay_ps + offset_ps),
        bound: MOST_OUTSIDE,
        concerns_misses: true,
    }
}

/// How often the largest count of a scan, or of a histogram, is clamped; none without a
/// counter that is too narrow for it.
fn clamped(asked: &Asked) -> Result<Option<Approximation>, MeanResponseError> {
    let Asked { sensor, detector, tier, .. } = *asked;
    let Some(limit) = count_limit(sensor).filter(|_| tier == CountingTier::Sampled) else {
        return Ok(None);
    };
    let model = DetectorModel::new(sensor, detector);
    if most_counts(sensor, &model) <= limit {
        return Ok(None);
    }
    let response = MeanResponse::of_tier(&model, tier)?;
    let (largest, total) = match sensor.scene().hardware.architecture {
        Architecture::UpDown => response.mean_counts().iter().fold((0.0, 0.0), |most, count| {
            let signed: f64 = count.signed.abs();
            if signed > most.0 { (signed, count.total) } else { most }
        }),
        Architecture::Histogram => {
            let largest = response.mean_bins().into_iter().fold(0.0, f64::max);
            (largest, largest)
        }
    };
    Ok(Some(Approximation {
        name: "that counts are not clamped",
        measure: "share of scans whose largest count is clamped:",
        // Counts scatter no more than without dead time.
        size: normal_cdf((largest - limit - 0.5) / total.max(1.0).sqrt()),
        bound: 1e-3,
        concerns_misses: true,
    }))
}

/// Largest count of a counter that the scene makes narrower than it needs to be.
pub fn count_limit(sensor: &Sensor) -> Option<f64> {
    let width = sensor.scene().hardware.counter_width? as i32;
    Some(match sensor.scene().hardware.architecture {
        Architecture::UpDown => 2_f64.powi(width - 1) - 1.0,
        Architecture::Histogram => 2_f64.powi(width) - 1.0,
    })
}

/// The most that a phase step, or a bin, may count: one detection in a dead time.
pub fn most_counts(sensor: &Sensor, model: &DetectorModel) -> f64 {
    let chips = sensor.timing().scan.integration_chips as f64;
    match sensor.scene().hardware.architecture {
        Architecture::UpDown => chips * model.most_detections_per_chip(),
        Architecture::Histogram => chips / sensor.timing().code_chips() as f64,
    }
}

/// Largest relative error of the share of periods in which a bin finds the detector ready: where
/// the phase divides by it, and where a fit takes the roots of bins for normal numbers. Estimates
/// of a fit scatter by an eighth more than expected at 1.2, and as expected at 0.8.
const PHASE_READY_ERROR: f64 = 0.25;
const FIT_READY_ERROR: f64 = 1.0;

/// Whether histograms of so many code periods show, bin by bin, in what share of them the
/// detector was ready, `ready` on average.
///
/// Dead time is taken out by dividing by that share. It scatters with the periods, and where
/// the detector was never ready there is nothing to divide.
///
/// # Errors
/// What does not hold.
pub(super) fn check_ready(ready: &[f64], periods: f64) -> Result<(), Approximation> {
    ready_shown(ready, periods, PHASE_READY_ERROR).check()?;
    Approximation {
        name: "that the detector is ready in each bin at least once",
        measure: "probability that it never is, in the worst bin:",
        size: (1.0 - least(ready)).powf(periods),
        bound: 0.01,
        concerns_misses: true,
    }
    .check()
}

/// The same of what a fit rests on.
pub(super) fn ready_for_fit(ready: &[f64], periods: f64) -> Approximation {
    ready_shown(ready, periods, FIT_READY_ERROR)
}

fn ready_shown(ready: &[f64], periods: f64, most: f64) -> Approximation {
    let least = least(ready);
    Approximation {
        name: "that a histogram shows how often the detector was ready",
        measure: "relative error of that share in the worst bin:",
        size: ((1.0 - least) / (least * periods)).sqrt(),
        bound: most,
        concerns_misses: true,
    }
}

fn least(ready: &[f64]) -> f64 {
    ready.iter().copied().fold(1.0, f64::min)
}

/// Whether what bins tell of the delay is nearly the same in each scan, where so many photons
/// [tell](super::fit::likeliest::photons_that_tell) of it. Where that scatters by half, estimates scatter within 5 % of what is
/// expected; where it scatters by two thirds, 20 % less, and some are of another peak.
pub(super) fn enough_photons(photons: f64) -> Approximation {
    Approximation {
        name: "that enough photons determine the delay",
        measure: "relative scatter of a scan's information about it:",
        size: photons.sqrt().recip(),
        bound: 0.5,
        concerns_misses: true,
    }
}

/// Whether the likeliest delay is on the path's peak, and not anywhere in the code period: where it
/// scatters by `std_chips`, it seldom is on another peak as long as that is a fraction of a chip.
pub(super) fn of_one_peak(std_chips: f64) -> Approximation {
    Approximation {
        name: "that the likeliest delay is on the path's peak",
        measure: "its standard deviation in chips:",
        size: std_chips,
        bound: 0.25,
        concerns_misses: true,
    }
}

/// Whether the moments that counts of steps are weighed with are any: `most_correlated` is the largest correlation of a step's
/// signed and total count. In short steps of a detector that fires like a clock hits vary by less than what the rims of steps add.
/// Measured of 88 to 1,000 chips of one at 113 Mcps, 4.3 ns dead: at 1.3 and 1.5 a fit scatters 8 and 200 times as far as expected,
/// up to 0.9 as expected.
pub(super) fn are_moments(most_correlated: f64) -> Approximation {
    Approximation {
        name: "that the moments of a phase step hold without its rims",
        measure: "largest correlation of a step's signed and total count:",
        size: most_correlated,
        bound: MOST_CORRELATION,
        concerns_misses: true,
    }
}

/// Whether light of other clocks, which expectations take as constant, leaves as much of the detector to all other light as
/// it does on and off in turns: [by dead time](crate::photons::DeadTime::slope_changed_by), of what comes in one, in which
/// chips average out. Measured of 1.6 photons in dead times of 3, 14 and 60 ns beside chips of 8 ns: where this is 0.03, 0.06,
/// 0.19 and 0.28, estimates scatter up to 5, 6, 15 and 22 % less than expected.
fn steady_beside(model: &DetectorModel) -> Approximation {
    let (dead_time, cells) = (model.dead_time(), f64::from(model.added_cells()));
    let variance = |light: &ExcessLight| {
        let on = light.code.weight() as f64 / light.code.len() as f64;
        on * (1.0 - on) * (light.rate_per_chip / cells).powi(2)
    };
    let chips = dead_time.length;
    let left = if chips < 1.0 { 1.0 - chips / 3.0 } else { (1.0 - 1.0 / (3.0 * chips)) / chips };
    let varies = left * model.slipping().map(variance).sum::<f64>();
    let excess = model.excess.iter().map(ExcessLight::mean_per_chip).sum::<f64>();
    let mean_per_chip = (model.constant_per_chip + excess) / cells;
    Approximation {
        name: "that light of other clocks dims the detector as constant light does",
        measure: "share by which it does not:",
        size: dead_time.slope_changed_by(mean_per_chip, varies).abs(),
        bound: 0.04,
        concerns_misses: true,
    }
}

/// Whether light of other clocks may be taken as constant by the phase, of counts or of a
/// histogram, where the signed count at the peak has the variance `peak_variance`.
///
/// # Errors
/// What does not hold.
pub(super) fn check_slipping(
    model: &DetectorModel,
    counting: CountingTier,
    peak_variance: f64,
) -> Result<(), Approximation> {
    if model.slipping().next().is_none() {
        return Ok(());
    }
    let Ok(slipping) = SlippingLight::new(model, counting) else { return Ok(()) };
    Approximation {
        name: "that light of other clocks is constant",
        measure: "share of the counts' variance that it adds:",
        size: slipping.variance() / (slipping.variance() + peak_variance).max(f64::MIN_POSITIVE),
        bound: 0.1,
        concerns_misses: true,
    }
    .check()
}

/// Whether bias and standard deviation of the phase, which are those of scans that find the
/// path, linear in the counts' errors and round the leading phase step, stand for its
/// estimates.
///
/// # Errors
/// What does not hold.
pub(super) fn check_phase(asked: &Asked, prediction: &Prediction) -> Result<(), Approximation> {
    // Errors that wrap count for the path wherever they are, and have statistics of their
    // own (`unwrap`).
    if errors_wrap(asked.sensor, asked.path) {
        return Ok(());
    }
    Approximation {
        name: "that the phase reports the path",
        measure: "share of scans that miss it:",
        size: prediction.missed_fraction.unwrap_or(0.0),
        bound: 0.999,
        concerns_misses: false,
    }
    .check()?;
    Approximation {
        name: "that the scan has the steps that the phase needs round the largest count",
        measure: "share of scans whose largest count is too near the rim:",
        size: prediction.coarse_only_fraction,
        // These estimates are as coarse as a phase step: a thousandth of them that are a step off
        // doubles the variance of a scatter of a thirtieth of a step. So few are seldom among the
        // scans that are simulated.
        bound: 1e-3,
        concerns_misses: false,
    }
    .check()?;
    if prediction.is_drawn {
        return Ok(());
    }
    Approximation {
        name: "that the estimate is linear in the counts",
        measure: "standard deviation of the phase in rad:",
        size: prediction.phase_std_rad,
        bound: 0.7,
        concerns_misses: false,
    }
    .check()?;
    Approximation {
        name: "that one phase step has the largest count",
        measure: "scatter of the estimates round all that may have it, in standard deviations:",
        size: prediction.coarse_spread_in_std(),
        bound: 0.5,
        concerns_misses: false,
    }
    .check()
}

/// Whether bias and standard deviation of the share of a path's errors that counts for it are
/// those of the middle of a normal law, and not of its tail.
///
/// # Errors
/// What does not hold.
pub(super) fn check_counted(share: f64) -> Result<(), Approximation> {
    Approximation {
        name: "that the path's estimates are attributed to it",
        measure: "share of them that are nearer to another path, or too far off:",
        size: 1.0 - share,
        bound: 0.95,
        concerns_misses: false,
    }
    .check()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::estimate::fit::error::FitError;
    use crate::estimate::{PredictionError, bound, predict, theory};
    use crate::scene::load_with;

    fn sensor(scene: &str, settings: &[&str]) -> Sensor {
        let settings: Vec<_> = settings.iter().map(|s| s.parse().expect("a setting")).collect();
        Sensor::new(&load_with(Path::new(scene), &settings).expect("it is sound"))
    }

    const FIRST: (DetectorIndex, PathIndex) = (DetectorIndex(0), PathIndex(0));

    fn refused(sensor: &Sensor) -> Option<Approximation> {
        match predict(sensor, FIRST.0, FIRST.1, CountingTier::Sampled) {
            Err(PredictionError::NotCovered(why)) => Some(why),
            _ => None,
        }
    }

    #[test]
    fn a_path_that_the_scan_does_not_come_by_has_no_number() {
        // 33 steps of 149.9 mm round 25 m; light at 3.2 m comes again after 31 chips, and
        // 2.75 ns later by the detector's delay and sampling.
        let window = "scan.steps={ around = \"25 m\", halfwidth = 16 }";
        let far = sensor("../scenes/quick.toml", &[window]);
        let why = refused(&far).expect("no number");
        let beyond = (3.2 - 25.0) / 0.149_896_229 + 248.0 + 2.75 - 16.0;
        assert!((why.size - beyond).abs() < 0.6, "{why}");
        let told = theory(&far, FIRST.0, &[FIRST.1], CountingTier::Sampled);
        assert_eq!((told.predictions[0].is_err(), told.missed[0]), (true, None));
        let bound = bound::bound_m(&far, FIRST.1, CountingTier::Sampled, &told.bound);
        assert_eq!(bound, Err(why.to_string()));
        for inside in ["path.distance=24 m", "path.distance=26.5 m"] {
            assert_eq!(refused(&sensor("../scenes/quick.toml", &[window, inside])), None);
        }
        // The other side of the period is no farther than the shorter way.
        let folded = sensor("../scenes/quick.toml", &[window, "path.distance=62.2 m"]);
        assert_eq!(refused(&folded), None);
    }

    /// Beside a sensor of another code and clock: 5 and 1 photons of it in four dead times. Whether the second has a number
    /// is for the variance to say that it adds.
    #[test]
    fn light_of_other_clocks_that_blinds_in_turns_has_no_number() {
        let beside = |power: &str, offset: &str| {
            let settings = [
                format!("source[1].mean_power={power}"),
                format!("source[1].clock_offset={offset}"),
            ];
            refused(&sensor(
                "../tests/scenes/near-far.toml",
                &settings.each_ref().map(String::as_str),
            ))
        };
        let dims = |why: &Approximation| why.name.contains("dims");
        // 73 Mcps beside 1.5: x = 1.05 in a dead time of 1.75 chips, of which half is off but for a tenth.
        let why = beside("60 pW", "100 ppm").expect("no number");
        let expected =
            3.0 / (1.0_f64 + 1.05).powi(2) * (0.82 * 1.03_f64).powi(2) * (1.0 - 1.0 / 5.25) / 1.75;
        assert!(dims(&why) && (why.size / expected - 1.0).abs() < 0.1, "{why}, {expected}");
        assert!(!beside("12 pW", "100 ppm").is_some_and(|why| dims(&why)));
        assert_eq!(beside("60 pW", "0 ppm"), None);
    }

    /// 88 and 880 chips of a detector that fires like a clock: a tenth of the light cannot tell the delay seventeen times as well.
    #[test]
    fn moments_that_are_none_have_no_bound() {
        let of = |integration: &str| {
            let settings = [
                "source.code={ family = \"gold\", degree = 6, index = 14 }",
                "source.mean_power=404 pW",
                "source.extinction_ratio=inf",
                "detector.dead_time=4.336 ns",
                "detector.pulse_width=1.7432 ns",
                "detector.afterpulsing.probability=0",
                integration,
            ];
            let sensor = sensor("../scenes/quick.toml", &settings);
            bound::bound(&sensor, FIRST.0, CountingTier::Sampled)
                .map(|bound| bound.paths[0].bound_m)
        };
        match of("scan.integration=704 ns") {
            Err(FitError::NotCovered(why)) => assert!(why.size > 1.3, "{why}"),
            other => panic!("{other:?}"),
        }
        let bound_m = of("scan.integration=7.04 us").expect("a bound");
        assert!((1e-3..3e-3).contains(&bound_m), "{bound_m}");
    }

    #[test]
    fn clamped_counts_have_no_number() {
        // A sensor of 31 chips, of either architecture: up to some hundred counts in a step,
        // some ten in a bin.
        for (architecture, narrow, wide, integration) in
            [("updown", 6, 13, "100 us"), ("histogram", 2, 12, "1 ms")]
        {
            let of = |width: i32| {
                let settings = [
                    format!("hardware.architecture={architecture}"),
                    format!("hardware.counter_width={width}"),
                    format!("scan.integration={integration}"),
                ];
                refused(&sensor("../scenes/quick.toml", &settings.each_ref().map(String::as_str)))
            };
            let why = of(narrow).expect("no number");
            assert!(why.name.contains("clamped"), "{architecture}: {why}");
            assert_eq!(of(wide), None, "{architecture}");
        }
    }
}
