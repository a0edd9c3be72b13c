//! The estimate of one detector beside the truth and what theory expects.

use std::cell::OnceCell;
use std::fmt::Display;

use serde::Serialize;

use super::bound::{bound, bound_and_remark};
use super::chance::{DOUBTFUL, Darkness, NO_PEAK};
use super::coverage;
use super::evidence::{Comparisons, Evidence, Expectation, ExpectedErrors};
use super::histogram::{self, PhaseOfHistogram, step_counts};
use super::theory::covered;
use super::truth::Asked;
use super::unwrap::{check_normal, fold, fold_distance};
use super::{
    CountingTier, Estimate, Prediction, calibration_offset_ps, check_modulated, delay_error_ps,
    distance_m, estimate, folded, predict, share_error, tolerance_ps, true_delay,
};
use crate::estimate::fit::{
    ALARM_SIGMAS, BinFitter, FitError, FittedPath, Fitter, ModelEstimate, expected_fit,
    shared_light,
};
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::scene::{Architecture, DetectorIndex, EstimatorKind, Path, PathIndex};
use crate::sensor::Sensor;

/// Why counts cannot be fitted, and what would make it possible. Signed counts alone
/// hardly tell how much light there is in all, and with it how far dead time moves them.
const SIGNED_ALONE: &str = "the fit needs total counts, and this hardware sends the signed ones \
     alone; total_counts = true, or estimator = \"model\", adds them";

/// Why counts of phase steps are not enough for a histogram sensor.
const NO_BINS: &str = "the bins of the histogram do not follow from the counts of phase steps";

/// The distance that a scan's counts give.
#[derive(Debug, Clone, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct EstimateReport {
    /// The detector's name.
    pub detector: String,
    /// The source whose light it ranges.
    pub source: String,
    /// How the distance was obtained from the counts.
    pub estimator: EstimatorKind,
    /// Index of the path that the estimate is compared with: of all paths of its
    /// reference's source, the nearest to the estimate; without an estimate the
    /// first.
    pub path: Option<PathIndex>,
    /// The estimate; null if the counts do not have a peak, or no modulated light could
    /// have caused one, or scans without any have as large counts too often.
    pub distance_m: Option<f64>,
    /// Share of scans without any light of the source in which some count is as large as what the estimate
    /// rests on ([`crate::estimate::chance`]); null without hits, and where counts may saturate. From 0.02
    /// on there is no estimate.
    pub chance_fraction: Option<f64>,
    /// That path's distance, folded into the unambiguous range.
    pub true_distance_m: Option<f64>,
    /// When a moving path has it, from the start of the scan: when the scan passes
    /// the path. Null for a path at rest.
    pub true_distance_at_s: Option<f64>,
    /// Estimate less truth, the shorter way round the unambiguous range.
    pub error_m: Option<f64>,
    /// The estimator's bias on the exact mean counts of this scene (for the
    /// phase: range walk, interference, circular error).
    pub expected_bias_m: Option<f64>,
    /// Its standard deviation from the counts' variances; of the model estimator no less
    /// than the bound.
    pub expected_std_m: Option<f64>,
    /// (error - expected bias) / expected standard deviation.
    pub deviation_in_std: Option<f64>,
    /// Whether the estimate agrees with its expectation, at a significance level of 1 in 10,000
    /// ([`crate::estimate::evidence`]); null without an expectation. A contradiction is described
    /// in `remark`.
    pub expectation_holds: Option<bool>,
    /// Cramer-Rao bound: the least standard deviation of any unbiased estimate
    /// from these counts ([`crate::estimate::bound`]).
    pub bound_m: Option<f64>,
    /// `expected_std_m` over `bound_m`.
    pub std_over_bound: Option<f64>,
    /// Why there is no bound, or which steps it is of if not all.
    pub bound_remark: Option<String>,
    /// The fit behind the estimate; null for the phase estimator.
    pub fit: Option<FitReport>,
    /// Phase step of the largest count.
    pub coarse_phase_step: Option<u64>,
    /// Subtracted from the measured delay: everything constant that is not time of flight.
    pub calibration_offset_ps: f64,
    /// Distance beyond which the code repeats.
    pub unambiguous_range_m: f64,
    /// Why there is no estimate, or only a coarse one, or no expectation.
    pub remark: Option<String>,
    /// Of a path beyond the unambiguous range: that its distance is folded into it.
    pub folded: Option<String>,
}

/// What the model estimator reports besides the distance.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FitReport {
    /// Every path that was fitted, the strongest of the detector's source first.
    pub paths: Vec<FittedPathReport>,
    /// Primary rate of all light that is not modulated, dark counts included.
    pub unmodulated_primary_rate_cps: f64,
    /// Weighted sum of squared residuals.
    pub chi_square: f64,
    /// What it is expected to be.
    pub degrees_of_freedom: usize,
    /// How many standard deviations it is above that.
    pub chi_square_excess_in_std: f64,
    /// Whether that is too much: the light or the detector is not as modelled.
    pub alarm: bool,
    /// Speed of the path's distance, positive away from the sensor; none of light that stands
    /// still.
    pub velocity_m_per_s: Option<f64>,
    /// Its standard deviation, by the fit itself.
    pub velocity_std_m_per_s: Option<f64>,
    /// Phase steps that took part.
    pub phase_steps: usize,
}

/// One path of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FittedPathReport {
    /// The source with this path's code; none if the scene has no such source.
    pub source: Option<String>,
    /// Distance, folded into the unambiguous range.
    pub distance_m: f64,
    /// Its standard deviation, by the fit itself.
    pub distance_std_m: f64,
    /// Primary rate that on-chips add.
    pub primary_rate_cps: f64,
    /// That rate in its standard deviations.
    pub significance_in_std: f64,
}

/// Estimates the distance that a detector's counts of one scan give, with the
/// scene's estimator.
///
/// `counts` are those of the steps in order; fewer than the scan's steps give no
/// estimate.
pub fn estimate_scan(
    sensor: &Sensor,
    detector: DetectorIndex,
    counts: &[StepCount],
) -> EstimateReport {
    let mut report = EstimateReport::without_estimate(sensor, detector);
    if (counts.len() as u64) < sensor.timing().scan.steps {
        report.remark = Some(format!(
            "no estimate: {} of the scan's {} phase steps were measured",
            counts.len(),
            sensor.timing().scan.steps
        ));
        return report;
    }
    report.take(sensor, detector, Counted::Steps(counts));
    report
}

/// Estimates the distance that a detector's histogram gives, with the scene's estimator.
///
/// # Panics
/// If the scene has no such detector, or the histogram not one bin per sample of its code.
pub fn estimate_histogram(
    sensor: &Sensor,
    detector: DetectorIndex,
    histogram: &Histogram,
) -> EstimateReport {
    let mut report = EstimateReport::without_estimate(sensor, detector);
    report.take(sensor, detector, Counted::Bins(histogram));
    report
}

/// The same without counts: what is expected of the estimator against the first path.
pub fn expected_errors(sensor: &Sensor, detector: DetectorIndex) -> EstimateReport {
    let mut report = EstimateReport::without_estimate(sensor, detector);
    match check_modulated(sensor, detector) {
        Err(reason) => report.remark = Some(format!("no estimate: {reason}")),
        Ok(()) => report.compare(&Ranging::of(sensor, detector), None, false),
    }
    report
}

/// A detector of a sensor, and what fits its counts.
struct Ranging<'s> {
    sensor: &'s Sensor,
    detector: DetectorIndex,
    /// Of phase steps: the counts that were measured and the expected ones have most of a fit's
    /// work in common.
    fitter: OnceCell<Fitter<'s>>,
}

impl<'s> Ranging<'s> {
    fn of(sensor: &'s Sensor, detector: DetectorIndex) -> Ranging<'s> {
        Ranging { sensor, detector, fitter: OnceCell::new() }
    }

    fn fitter(&self) -> &Fitter<'s> {
        let other = self.sensor.scene().other_light;
        let tier = CountingTier::Sampled;
        self.fitter.get_or_init(|| Fitter::new(self.sensor, self.detector, tier, other))
    }
}

/// What an estimate is made from.
#[derive(Clone, Copy)]
enum Counted<'c> {
    /// Counts of phase steps, of either architecture.
    Steps(&'c [StepCount]),
    /// The bins of a histogram.
    Bins(&'c Histogram),
}

/// Why the phase estimator leaves range walk in its answer, if it does in that of a histogram.
fn walks(sensor: &Sensor, detector: DetectorIndex, counted: Counted) -> Option<String> {
    let Architecture::Histogram = sensor.scene().hardware.architecture else { return None };
    match (sensor.scene().estimator, counted) {
        (EstimatorKind::Model, _) => None,
        (EstimatorKind::Fft, Counted::Steps(_)) => Some(NO_BINS.to_owned()),
        (EstimatorKind::Fft, Counted::Bins(_)) => {
            PhaseOfHistogram::new(sensor, detector).walks().map(|reason| reason.to_string())
        }
    }
}

impl EstimateReport {
    fn without_estimate(sensor: &Sensor, detector: DetectorIndex) -> EstimateReport {
        let spad = &sensor.scene().detectors[detector];
        let source = &sensor.scene().sources[spad.reference];
        EstimateReport {
            detector: spad.name.clone(),
            source: source.name.clone(),
            estimator: sensor.scene().estimator,
            calibration_offset_ps: calibration_offset_ps(sensor, detector, CountingTier::Sampled),
            unambiguous_range_m: distance_m(sensor.timing().code_period_ps()),
            ..EstimateReport::default()
        }
    }

    /// Takes the estimator's answer, with truth and expectation beside it.
    fn take(&mut self, sensor: &Sensor, detector: DetectorIndex, counted: Counted) {
        let is_modulated = check_modulated(sensor, detector).map_err(|reason| reason.to_string());
        let walks = is_modulated.is_ok().then(|| walks(sensor, detector, counted)).flatten();
        let ranging = Ranging::of(sensor, detector);
        let measured_ps = is_modulated.and_then(|()| {
            self.check_chance(sensor, detector, counted)?;
            self.answer(&ranging, counted)
        });
        if let Err(reason) = &measured_ps {
            self.add_remark(&format!("no estimate: {reason}"));
        }
        if let Some(walks) = walks {
            self.add_remark(&format!("range walk is left in: {walks}"));
        }
        let of_steps = matches!(counted, Counted::Steps(_));
        self.compare(&ranging, measured_ps.ok(), of_steps);
    }

    /// Whether a scan without the own light has counts as large: then there is no estimate.
    fn check_chance(
        &mut self,
        sensor: &Sensor,
        detector: DetectorIndex,
        counted: Counted,
    ) -> Result<(), String> {
        let of_bins;
        let counts = match counted {
            Counted::Steps(counts) => counts,
            Counted::Bins(histogram) => {
                of_bins = step_counts(sensor, detector, histogram);
                &of_bins
            }
        };
        self.chance_fraction = Darkness::of(sensor, detector, counts).chance(counts);
        let Some(fraction) = self.chance_fraction.filter(|&fraction| fraction >= DOUBTFUL) else {
            return Ok(());
        };
        let as_large = format!(
            "{:.1} % of scans without any light of \"{}\" have as large counts",
            fraction * 1e2,
            self.source
        );
        if fraction >= NO_PEAK {
            return Err(as_large);
        }
        self.add_remark(&format!("the peak may be chance: {as_large}"));
        Ok(())
    }

    /// The estimate of the scene's estimator: the delay, in ps, or why it failed.
    fn answer(&mut self, ranging: &Ranging, counted: Counted) -> Result<f64, String> {
        let Ranging { sensor, detector, .. } = *ranging;
        let scene = sensor.scene();
        match (scene.estimator, counted) {
            (EstimatorKind::Fft, Counted::Bins(histogram)) => {
                self.of_phase(PhaseOfHistogram::new(sensor, detector).estimate(histogram))
            }
            (EstimatorKind::Fft, Counted::Steps(counts)) => {
                let signed: Vec<i64> = counts.iter().map(|count| count.signed).collect();
                self.of_phase(estimate(sensor.timing(), &signed, self.calibration_offset_ps))
            }
            (EstimatorKind::Model, Counted::Bins(histogram)) => {
                let fitter = BinFitter::new(sensor, detector);
                self.of_fit(sensor, fitter.and_then(|fitter| fitter.fit(histogram)), None)
            }
            (EstimatorKind::Model, Counted::Steps(counts)) => {
                if scene.hardware.architecture == Architecture::Histogram {
                    return Err(NO_BINS.to_owned());
                }
                if !scene.sends_total_counts() {
                    return Err(SIGNED_ALONE.to_owned());
                }
                let fitted = ranging.fitter().fit(counts);
                self.of_fit(sensor, fitted, shared_light(sensor, detector))
            }
        }
    }

    fn of_phase(&mut self, estimate: Result<Estimate, impl Display>) -> Result<f64, String> {
        let estimate = estimate.map_err(|reason| reason.to_string())?;
        self.distance_m = Some(estimate.distance_m);
        self.coarse_phase_step = Some(estimate.coarse_step);
        if let Some(reason) = estimate.coarse_only {
            self.add_remark(&format!("coarse estimate only: {reason}"));
        }
        Ok(estimate.delay_ps)
    }

    fn of_fit(
        &mut self,
        sensor: &Sensor,
        fitted: Result<ModelEstimate, FitError>,
        remark: Option<String>,
    ) -> Result<f64, String> {
        let fitted = fitted.map_err(|reason| reason.to_string())?;
        self.distance_m = Some(fitted.distance_m);
        self.fit = Some(FitReport::of(sensor, &fitted));
        let untold = fitted.untold.as_ref().map(ToString::to_string);
        remark.into_iter().chain(untold).for_each(|remark| self.add_remark(&remark));
        Ok(fitted.delay_ps)
    }

    /// Puts truth and expectation beside the time of flight, if there is one; `of_steps` where it
    /// is of phase steps' counts.
    fn compare(&mut self, ranging: &Ranging, measured_ps: Option<f64>, of_steps: bool) {
        let Ranging { sensor, detector, .. } = *ranging;
        let own = sensor.scene().detectors[detector].reference;
        let code_period_ps = sensor.timing().code_period_ps();
        let truth = |p: PathIndex| true_delay(sensor, p, CountingTier::Sampled);
        let error_ps = |p: PathIndex| {
            let true_ps = truth(p).delay_ps;
            delay_error_ps(measured_ps.unwrap_or(true_ps), true_ps, code_period_ps)
        };
        let is_own = |path: &Path| path.detector == detector && path.source == own;
        self.path = PathIndex::of(&sensor.scene().paths)
            .filter(|&p| is_own(&sensor.scene().paths[p]))
            .min_by(|&a, &b| error_ps(a).abs().total_cmp(&error_ps(b).abs()));
        let Some(path) = self.path else { return };
        let truth = truth(path);
        let true_ps = fold_distance(truth.delay_ps, code_period_ps);
        self.true_distance_m = Some(distance_m(true_ps));
        self.true_distance_at_s = truth.at_ps.map(|ps| ps * 1e-12);
        self.error_m = measured_ps.map(|_| distance_m(error_ps(path)));
        let bound = bound(sensor, detector, CountingTier::Sampled);
        (self.bound_m, self.bound_remark) =
            bound_and_remark(sensor, path, CountingTier::Sampled, &bound);
        match expectation(ranging, path, of_steps) {
            Ok((errors, missed)) => {
                let ExpectedErrors { bias_m, std_m } = match (self.estimator, &bound) {
                    (EstimatorKind::Model, Ok(bound)) => bound.errors_of_fit(path, errors),
                    _ => errors,
                };
                let delay_std_ps = sensor.scene().detectors[detector].delay_std_ps;
                let std_m = std_m.hypot(distance_m(delay_std_ps));
                self.expected_bias_m = Some(bias_m);
                self.expected_std_m = Some(std_m);
                let range_m = self.unambiguous_range_m;
                self.deviation_in_std =
                    self.error_m.map(|error_m| fold(error_m - bias_m, range_m) / std_m);
                let with_error = |share| (share, share_error(sensor, detector, share));
                let missed = missed.map(with_error);
                let errors = Some(ExpectedErrors { bias_m, std_m });
                self.take_evidence(sensor, &Expectation { errors, missed });
            }
            Err(reason) => self.add_remark(&format!("no expectation: {reason}")),
        }
        let ratio = self.expected_std_m.zip(self.bound_m);
        self.std_over_bound = ratio.map(|(std_m, bound_m)| std_m / bound_m);
        self.folded = folded(sensor, path);
    }

    /// Holds the one scan against what is expected of it.
    fn take_evidence(&mut self, sensor: &Sensor, expected: &Expectation) {
        let Some(error_m) = self.error_m else { return };
        let chip_ps = sensor.clock().chip_period_ps;
        let tolerance_m = distance_m(tolerance_ps(chip_ps, sensor.timing().code_period_ps()));
        let is_missed = error_m.abs() > tolerance_m;
        // An estimate elsewhere does not belong to any path, and is not an error of this one.
        let found = [error_m];
        let evidence = Evidence {
            errors_m: if is_missed { &[] } else { &found },
            scans: 1,
            missed: u64::from(is_missed),
            range_m: self.unambiguous_range_m,
        };
        let paths = sensor.scene().paths.len();
        let told = Comparisons::of_paths(paths).contradictions(&evidence, expected);
        match told {
            Some(told) if !told.is_empty() => {
                self.expectation_holds = Some(false);
                self.add_remark(&format!("the expectation does not hold: {}", told.join("; ")));
            }
            // A single scan that misses what is seldom missed bears nothing out.
            _ if is_missed => self.add_remark(
                "the estimate does not belong to any of the scene's paths, and is not compared with the \
                 expectation",
            ),
            Some(_) => self.expectation_holds = Some(true),
            None => {}
        }
    }

    /// Adds to what is remarked on already.
    pub fn add_remark(&mut self, remark: &str) {
        let before = self.remark.take().map(|before| before + "; ");
        self.remark = Some(before.unwrap_or_default() + remark);
    }
}

impl FitReport {
    fn of(sensor: &Sensor, fitted: &ModelEstimate) -> FitReport {
        let of_path = |path: &FittedPath| FittedPathReport {
            source: sensor
                .scene()
                .sources
                .iter()
                .find(|source| source.code.chips == path.code.chips)
                .map(|source| source.name.clone()),
            distance_m: distance_m(path.delay_ps),
            distance_std_m: distance_m(path.delay_std_ps),
            primary_rate_cps: path.rate_hz,
            significance_in_std: path.significance(),
        };
        FitReport {
            paths: fitted.paths.iter().map(of_path).collect(),
            unmodulated_primary_rate_cps: fitted.constant_rate_hz,
            chi_square: fitted.chi_square,
            degrees_of_freedom: fitted.degrees_of_freedom,
            chi_square_excess_in_std: fitted.alarm_sigmas(),
            alarm: fitted.alarm_sigmas() > ALARM_SIGMAS,
            velocity_m_per_s: fitted.velocity.map(|velocity| velocity.m_per_s),
            velocity_std_m_per_s: fitted.velocity.map(|velocity| velocity.std_m_per_s),
            phase_steps: fitted.steps,
        }
    }
}

/// What the scene's estimator is expected to say of a path, and the share of scans that miss it,
/// where that is known.
fn expectation(
    ranging: &Ranging,
    path: PathIndex,
    of_steps: bool,
) -> Result<(ExpectedErrors, Option<f64>), String> {
    let Ranging { sensor, detector, .. } = *ranging;
    let tier = CountingTier::Sampled;
    let is_histogram = sensor.scene().hardware.architecture == Architecture::Histogram;
    if sensor.scene().estimator == EstimatorKind::Fft {
        let expected = match of_steps && is_histogram {
            true => {
                let asked = Asked { sensor, detector, path, tier };
                covered(&asked, histogram::predict(&asked, true))
            }
            false => predict(sensor, detector, path, tier),
        };
        let expected = expected.map_err(|e| e.to_string())?;
        let range_m = distance_m(sensor.code_period_of_path_ps(path));
        check_normal(expected.std_m, range_m).map_err(|spread| spread.to_string())?;
        let Prediction { bias_m, std_m, missed_fraction, .. } = expected;
        return Ok((ExpectedErrors { bias_m, std_m }, missed_fraction));
    }
    let fitted = match is_histogram {
        true => expected_fit(sensor, detector, tier),
        false => ranging.fitter().expected(),
    };
    let fitted = fitted.map_err(|e| e.to_string())?;
    coverage::check_fit(sensor, detector, path, tier, &fitted).map_err(|e| e.to_string())?;
    let code = &sensor.scene().sources[sensor.scene().paths[path].source].code;
    let code_period_ps = sensor.code_period_of_path_ps(path);
    let true_ps = true_delay(sensor, path, tier).delay_ps;
    let error_ps = |fitted: &FittedPath| delay_error_ps(fitted.delay_ps, true_ps, code_period_ps);
    let nearest = fitted
        .paths
        .iter()
        .filter(|fitted| fitted.code.chips == code.chips)
        .min_by(|a, b| error_ps(a).abs().total_cmp(&error_ps(b).abs()));
    let nearest = nearest.ok_or("the expected counts do not show the path")?;
    let [bias_m, std_m] = [error_ps(nearest), nearest.delay_std_ps].map(distance_m);
    Ok((ExpectedErrors { bias_m, std_m }, None))
}
