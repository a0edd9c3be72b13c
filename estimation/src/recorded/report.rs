//! The distance that recorded counts give, and how they agree with their scene.

use std::fmt;
use std::fmt::Write as _;

use serde::Serialize;

use super::diagnosis::{Diagnosis, delay_of_scene, diagnose};
use super::hypothesis::{SceneFit, Unknown};
use super::observed::{Agreement, ExpectedNumbers, Observed};
use super::{Cause, RecordedHistogram, RecordedScan};
use crate::estimate::chance::{DOUBTFUL, NO_PEAK};
use crate::estimate::coverage::steps_outside;
use crate::estimate::report::{EstimateReport, Reporter};
use crate::estimate::{CountingTier, TheoryEffort, Work, calibration_offset_ps, distance_m};
use crate::photons::StepCount;
use crate::scan::Step;
use crate::scene::{DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

/// The assessment of one detector's recorded scan.
#[derive(Debug, Clone, Default, Serialize, schemars::JsonSchema)]
pub struct Assessment {
    /// The detector's name.
    pub detector: String,
    /// The estimate of the scene's estimator, compared with the scene's path.
    pub estimate: EstimateReport,
    /// The distance at which the scene's expected counts fit best.
    pub fitted_distance_m: Option<f64>,
    /// Its standard deviation.
    pub fitted_distance_std_m: Option<f64>,
    /// Weighted sum of squared residuals of all steps.
    pub chi_square: Option<f64>,
    /// What it is expected to be.
    pub degrees_of_freedom: Option<usize>,
    /// Probability of a chi-square at least as large.
    pub p_value: Option<f64>,
    /// What seems wrong.
    pub diagnosis: Option<Diagnosis>,
    /// Why there are no residuals, if there are none.
    pub remark: Option<String>,
    /// The residual of every step; empty for a histogram.
    pub phase_steps: Vec<StepResidual>,
    /// The residual of every bin of a histogram; empty for phase steps.
    pub bins: Vec<BinResidual>,
}

/// One phase step of an assessment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct StepResidual {
    /// The phase step.
    pub phase_step: u64,
    /// Calibrated distance that it stands for.
    pub distance_m: f64,
    /// The recorded signed count.
    pub count: i64,
    /// Expected count of the fitted scene.
    pub expected_count: f64,
    /// Its standard deviation.
    pub expected_count_std: f64,
    /// Recorded less expected, in standard deviations.
    pub residual_in_std: f64,
    /// The same for the part of the total count that is not correlated with the signed one; null
    /// without totals.
    pub total_residual_in_std: Option<f64>,
}

/// One bin of an assessment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct BinResidual {
    /// The bin: samples from the start of the code period.
    pub bin: u64,
    /// The recorded count.
    pub count: u64,
    /// Expected count of the fitted scene.
    pub expected_count: f64,
    /// Its standard deviation.
    pub expected_count_std: f64,
    /// Recorded count less its expectation given the bins before it, in standard deviations.
    pub residual_in_std: f64,
}

/// Ranges a recorded scan with the scene's estimator, and compares it with the scene's
/// expectation.
///
/// The model estimator needs total counts: a scan without them is ranged by the phase,
/// with a remark.
pub fn assess(sensor: &Sensor, scan: &RecordedScan) -> Assessment {
    let without_totals = !scan.has_totals && sensor.scene().estimator == EstimatorKind::Model;
    let observed = Observed::Steps(scan);
    let mut assessment = match without_totals {
        true => held_against(&by_phase(sensor), observed),
        false => held_against(sensor, observed),
    };
    if without_totals {
        let why = "ranged by the phase: the model estimator needs the column total_count";
        assessment.estimate.add_remark(why);
    }
    assessment
}

/// The same of a recorded histogram.
///
/// # Panics
/// If it has not one bin per sample of the scene's code period.
pub fn assess_histogram(sensor: &Sensor, recorded: &RecordedHistogram) -> Assessment {
    held_against(sensor, Observed::Bins(recorded))
}

/// What a fit to signed counts alone assumes.
const LIGHT_OF_SCENE: &str = "of signed counts alone, which do not tell light level and background: \
     these are the scene's; total_counts = true, or estimator = \"model\", adds the counts that do";

/// Replaces a model estimate, which signed counts alone do not allow, by the best fit of the scene with
/// only its distance unknown. `phase` is the phase estimate of the same counts, `model` the model's. It
/// stays as it is if the counts may be noise, if several paths lead to the detector, since their light would
/// move together, and if the scene's expected counts cannot be tested.
pub fn fit_distance_alone(
    sensor: &Sensor,
    (scan, as_it_is): (&RecordedScan, &AsItIs),
    phase: &EstimateReport,
    model: &mut EstimateReport,
) {
    if model.chance_fraction.is_some_and(|chance| chance >= NO_PEAK) {
        return;
    }
    let observed = Observed::Steps(scan);
    let paths = sensor.scene().paths.iter().filter(|path| path.detector == scan.detector);
    let is_whole = scan.counts.len() as u64 == sensor.scene().scan.steps;
    if paths.count() != 1 || !is_whole || check_testable(sensor, observed).is_err() {
        return;
    }
    let delays_ps: Vec<f64> = later_ps(phase).into_iter().chain([0.0]).collect();
    let known = as_it_is.of(scan).ok();
    let fitted = delay_of_scene(sensor, observed, &delays_ps, known.as_ref()).ok();
    let (Some([later_ps, std_ps]), Some(true_m)) = (fitted, model.true_distance_m) else {
        return;
    };
    let range_m = model.unambiguous_range_m;
    let [later_m, std_m] = [later_ps, std_ps].map(distance_m);
    let error_m = later_m - (later_m / range_m).round() * range_m;
    model.distance_m = Some((true_m + error_m).rem_euclid(range_m));
    model.error_m = Some(error_m);
    (model.expected_bias_m, model.expected_std_m) = (Some(0.0), Some(std_m));
    model.deviation_in_std = Some(error_m / std_m);
    model.std_over_bound = model.bound_m.map(|bound_m| std_m / bound_m);
    model.remark = Some(LIGHT_OF_SCENE.to_owned());
}

/// Ranges with the sensor's estimator, and compares with the scene.
fn held_against(sensor: &Sensor, observed: Observed) -> Assessment {
    let detector = observed.detector();
    let estimate = observed.estimate(&Reporter::new(sensor, detector));
    let found = check_testable(sensor, observed).and_then(|()| {
        // The phase may mistake another path's peak for the own one, and a fit may take an own peak
        // far from the scene's for other light.
        let is_fit = sensor.scene().estimator == EstimatorKind::Model;
        let phase = is_fit.then(|| {
            let by_phase = by_phase(sensor);
            observed.estimate(&Reporter::new(&by_phase, detector).without_theory())
        });
        let found_ps = [Some(&estimate), phase.as_ref()].into_iter().flatten().filter_map(later_ps);
        let delays_ps: Vec<f64> = found_ps.chain([0.0]).collect();
        // A peak that is not chance is of some light.
        let may_be_dark = estimate.chance_fraction.is_none_or(|chance| chance >= DOUBTFUL);
        diagnose(sensor, observed, &delays_ps, may_be_dark).map_err(|e| e.to_string())
    });
    let mut assessment = Assessment {
        detector: sensor.scene().detectors[observed.detector()].name.clone(),
        estimate,
        ..Assessment::default()
    };
    match found {
        Ok((diagnosis, fitted)) => assessment.take(sensor, observed, diagnosis, &fitted),
        Err(reason) => assessment.remark = Some(format!("no residuals: {reason}")),
    }
    assessment
}

const OF_BINS: &str = "counts of a histogram's phase steps are of the same photons, and their residuals \
     go together; its bins (bins.csv of `goldtof run`) have some that do not";

/// Why counts cannot be tested against their scene.
fn check_testable(sensor: &Sensor, observed: Observed) -> Result<(), String> {
    if matches!(observed, Observed::Bins(_)) {
        return Ok(());
    }
    if sensor.interface().histogram().is_some() {
        return Err(OF_BINS.to_owned());
    }
    let parallel = sensor.scene().hardware.parallel;
    if parallel > 1 {
        return Err(format!(
            "with parallel = {parallel} the steps of a group see the same light, and their residuals \
             go together"
        ));
    }
    TheoryEffort::of(sensor, observed.detector())
        .and_then(|effort| effort.check(Work::Fit))
        .map_err(|reason| reason.to_string())
}

/// How much later than the scene's nearest own path the peak stands.
fn later_ps(report: &EstimateReport) -> Option<f64> {
    let bias_m = report.expected_bias_m.unwrap_or(0.0);
    let ps_per_m = 1.0 / distance_m(1.0);
    Some((report.error_m? - bias_m) * ps_per_m)
}

/// The sensor, ranged by the phase.
fn by_phase(sensor: &Sensor) -> Sensor {
    sensor.with(|scene| scene.estimator = EstimatorKind::Fft)
}

impl Assessment {
    fn take(
        &mut self,
        sensor: &Sensor,
        observed: Observed,
        diagnosis: Diagnosis,
        fitted: &SceneFit,
    ) {
        let scene = sensor.scene();
        match observed {
            Observed::Steps(scan) => {
                let offset_ps = self.estimate.calibration_offset_ps;
                self.phase_steps =
                    steps(sensor, scan, offset_ps, &fitted.expected, &fitted.agreement);
            }
            Observed::Bins(recorded) => {
                self.bins = bins(recorded, &fitted.expected, &fitted.agreement);
            }
        }
        if let (Some(std_ps), Some(path)) = (fitted.std_of(Unknown::Delay), self.estimate.path) {
            let code = &scene.sources[scene.paths[path].source].code;
            let period_ps = scene.clock().ps(code.len() as f64);
            let delay_ps = scene.paths[path].delay_ps + fitted.change.value(Unknown::Delay);
            self.fitted_distance_m = Some(distance_m(delay_ps.rem_euclid(period_ps)));
            self.fitted_distance_std_m = Some(distance_m(std_ps));
            if diagnosis.causes.contains(&Cause::Offset) {
                self.refuse_outside_of_scan(sensor, delay_ps);
            }
        }
        self.chi_square = Some(fitted.agreement.chi_square);
        self.degrees_of_freedom = Some(fitted.degrees);
        self.p_value = fitted.p_value;
        self.diagnosis = Some(diagnosis);
    }

    /// Takes an estimate back where the scan does not come by the peak that fits the counts: it is of a sidelobe.
    fn refuse_outside_of_scan(&mut self, sensor: &Sensor, delay_ps: f64) {
        if steps_outside(sensor, delay_ps + self.estimate.calibration_offset_ps) == 0.0 {
            return;
        }
        (self.estimate.distance_m, self.estimate.error_m) = (None, None);
        (self.estimate.deviation_in_std, self.estimate.expectation_holds) = (None, None);
        self.estimate.remark = Some(
            "no estimate: the scan does not come by the peak that fits its counts best".to_owned(),
        );
    }

    /// Whether the counts contradict neither the expectation nor the rest of the scene.
    pub fn holds(&self) -> bool {
        let is_accused = self.diagnosis.as_ref().is_some_and(|found| !found.causes.is_empty());
        self.estimate.expectation_holds != Some(false) && !is_accused
    }

    /// The residuals as CSV.
    pub fn residuals_csv(&self) -> String {
        if !self.bins.is_empty() {
            return self.bins_csv();
        }
        let mut text = "phase_step,distance_m,count,expected,expected_std,residual_in_std,\
                        total_residual_in_std\n"
            .to_owned();
        for step in &self.phase_steps {
            let total = step.total_residual_in_std;
            let _ = writeln!(
                text,
                "{},{:.6},{},{:.6},{:.6},{:.4},{}",
                step.phase_step,
                step.distance_m,
                step.count,
                step.expected_count,
                step.expected_count_std,
                step.residual_in_std,
                total.map_or_else(String::new, |total| format!("{total:.4}"))
            );
        }
        text
    }

    fn bins_csv(&self) -> String {
        let mut text = "bin,count,expected,expected_std,residual_in_std\n".to_owned();
        for bin in &self.bins {
            let _ = writeln!(
                text,
                "{},{},{:.6},{:.6},{:.4}",
                bin.bin, bin.count, bin.expected_count, bin.expected_count_std, bin.residual_in_std
            );
        }
        text
    }
}

/// Residuals of each step of a scan.
fn steps(
    sensor: &Sensor,
    scan: &RecordedScan,
    offset_ps: f64,
    expected: &ExpectedNumbers,
    agreement: &Agreement,
) -> Vec<StepResidual> {
    let step_ps = sensor.clock().sample_period_ps();
    let residuals = &agreement.whitened;
    let per_step = residuals.len() / scan.counts.len().max(1);
    let of_steps = scan.counts.iter().zip(expected.each()).enumerate();
    let of_step = |(j, (count, [mean, std])): (usize, (&StepCount, [f64; 2]))| {
        let phase_step = sensor.timing().scan.phase_step(Step::at(j));
        let residuals = &residuals[j * per_step..(j + 1) * per_step];
        StepResidual {
            phase_step,
            distance_m: distance_m(phase_step as f64 * step_ps - offset_ps),
            count: count.signed,
            expected_count: mean,
            expected_count_std: std,
            residual_in_std: residuals[0],
            total_residual_in_std: residuals.get(1).copied(),
        }
    };
    of_steps.map(of_step).collect()
}

/// Residuals of each bin of a histogram.
fn bins(
    recorded: &RecordedHistogram,
    expected: &ExpectedNumbers,
    agreement: &Agreement,
) -> Vec<BinResidual> {
    let counts = recorded.histogram.bins().iter().copied();
    let of_bins = counts.zip(expected.each()).zip(&agreement.whitened);
    let of_bin =
        |(bin, ((count, [mean, std]), residual)): (u64, ((u64, [f64; 2]), &f64))| BinResidual {
            bin,
            count,
            expected_count: mean,
            expected_count_std: std,
            residual_in_std: *residual,
        };
    (0..).zip(of_bins).map(of_bin).collect()
}

/// What a scene as it is lets one expect of a whole scan of a detector, or why nothing is: the counts do not
/// change it.
#[derive(Debug, Clone)]
pub struct AsItIs(Result<ExpectedNumbers, String>);

impl AsItIs {
    /// Works it out.
    pub fn new(sensor: &Sensor, detector: DetectorIndex) -> AsItIs {
        if sensor.interface().histogram().is_some() {
            return AsItIs(Err(OF_BINS.to_owned()));
        }
        let scan = RecordedScan { detector, counts: Vec::new(), has_totals: false };
        AsItIs(as_it_is(sensor, Observed::Steps(&scan)))
    }

    /// Of a scan with or without totals.
    fn of(&self, scan: &RecordedScan) -> Result<ExpectedNumbers, String> {
        self.0.clone().map(|expected| expected.with_totals(scan.has_totals))
    }
}

/// Residuals of each phase step relative to the scene as it is, with nothing fitted: the chi-square has
/// as many degrees of freedom as there are numbers.
///
/// # Errors
/// Why there is no expectation.
pub fn against_scene(
    sensor: &Sensor,
    scan: &RecordedScan,
    as_it_is: &AsItIs,
) -> Result<Vec<StepResidual>, String> {
    if scan.counts.len() as u64 != sensor.scene().scan.steps {
        return Err("the scan is not whole".to_owned());
    }
    let observed = Observed::Steps(scan);
    let (expected, agreement) = held(observed, as_it_is.of(scan)?)?;
    let offset_ps = calibration_offset_ps(sensor, scan.detector, CountingTier::Sampled);
    Ok(steps(sensor, scan, offset_ps, &expected, &agreement))
}

/// The same of a histogram, bin by bin.
///
/// # Errors
/// Why there is no expectation.
///
/// # Panics
/// If it has not one bin per sample of the scene's code period.
pub fn histogram_against_scene(
    sensor: &Sensor,
    recorded: &RecordedHistogram,
) -> Result<Vec<BinResidual>, String> {
    let observed = Observed::Bins(recorded);
    let (expected, agreement) = held(observed, as_it_is(sensor, observed)?)?;
    Ok(bins(recorded, &expected, &agreement))
}

fn as_it_is(sensor: &Sensor, observed: Observed) -> Result<ExpectedNumbers, String> {
    let effort = TheoryEffort::of(sensor, observed.detector()).map_err(|e| e.to_string())?;
    effort.check(Work::Predictions(1)).map_err(|e| e.to_string())?;
    observed.expected(sensor, 0.0).map_err(|reason| reason.to_string())
}

fn held(
    observed: Observed,
    expected: ExpectedNumbers,
) -> Result<(ExpectedNumbers, Agreement), String> {
    let agreement = expected.judge(&observed.values()).map_err(|reason| reason.to_string())?;
    Ok((expected, agreement))
}

impl fmt::Display for Assessment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let estimate = &self.estimate;
        write!(f, "{} ({}):", self.detector, estimate.estimator)?;
        match estimate.distance_m {
            Some(distance_m) => write!(f, " {distance_m:.4} m")?,
            None => write!(f, " no distance")?,
        }
        if let (Some(bias_m), Some(std_m)) = (estimate.expected_bias_m, estimate.expected_std_m) {
            let (bias_mm, std_mm) = (bias_m * 1e3, std_m * 1e3);
            write!(f, " (expected bias {bias_mm:+.2} mm, standard deviation {std_mm:.2} mm)")?;
        }
        if let Some(truth_m) = estimate.true_distance_m {
            write!(f, "; the scene's path: {truth_m:.4} m")?;
        }
        writeln!(f)?;
        if let (Some(distance_m), Some(std_m)) =
            (self.fitted_distance_m, self.fitted_distance_std_m)
        {
            let std_mm = std_m * 1e3;
            write!(f, "  best fit of the scene: {distance_m:.4} m +- {std_mm:.2} mm")?;
            match (estimate.estimator, estimate.distance_m.zip(estimate.expected_bias_m)) {
                (EstimatorKind::Model, _) => {
                    writeln!(f, ", of its light and background; the model leaves both free")?;
                }
                (EstimatorKind::Fft, Some((phase_m, bias_m))) => {
                    writeln!(f, "; the phase less its bias: {:.4} m", phase_m - bias_m)?;
                }
                (EstimatorKind::Fft, None) => writeln!(f, "; the phase has a bias")?,
            }
        }
        if let (Some(chi_square), Some(degrees)) = (self.chi_square, self.degrees_of_freedom) {
            write!(f, "  chi-square {chi_square:.1} for {degrees} degrees of freedom")?;
            match self.p_value {
                Some(p) => writeln!(f, ", p = {p:.2e}")?,
                None => writeln!(f)?,
            }
        }
        if let Some(diagnosis) = &self.diagnosis {
            writeln!(f, "  {}", diagnosis.sentence)?;
            for reason in &diagnosis.not_tested {
                writeln!(f, "  not tested: {reason}")?;
            }
        }
        for remark in estimate.remark.iter().chain(&self.remark) {
            writeln!(f, "  {remark}")?;
        }
        Ok(())
    }
}
