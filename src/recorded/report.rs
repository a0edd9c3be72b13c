//! The distance that recorded counts give, and how they agree with their scene.

use std::fmt;
use std::fmt::Write as _;

use serde::Serialize;

use super::RecordedScan;
use super::diagnosis::{Diagnosis, Found, diagnose};
use super::hypothesis::{NoFit, Unknown};
use crate::estimate::report::{EstimateReport, estimate_scan};
use crate::estimate::{TheoryEffort, distance_m};
use crate::scan::Step;
use crate::scene::{DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

/// What one detector's recorded scan says.
#[derive(Debug, Clone, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Assessment {
    /// The detector's name.
    pub detector: String,
    /// The scene's estimator's answer, beside the scene's own path.
    pub estimate: EstimateReport,
    /// The distance at which the scene's expected counts fit best.
    pub fitted_distance_m: Option<f64>,
    /// Its standard deviation.
    pub fitted_distance_std_m: Option<f64>,
    /// Weighted sum of squared residuals of all steps.
    pub chi_square: Option<f64>,
    /// What it is expected to be.
    pub degrees_of_freedom: Option<usize>,
    /// Chance of a chi-square at least as large.
    pub p_value: Option<f64>,
    /// What seems wrong.
    pub diagnosis: Option<Diagnosis>,
    /// Why there are no residuals, where that is so.
    pub remark: Option<String>,
    /// The residual of every step.
    pub phase_steps: Vec<StepResidual>,
}

/// One phase step of an assessment.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct StepResidual {
    /// The phase step.
    pub phase_step: u64,
    /// Calibrated distance that it stands for.
    pub distance_m: f64,
    /// The recorded signed count.
    pub count: i64,
    /// What the fitted scene expects.
    pub expected_count: f64,
    /// Its standard deviation.
    pub expected_count_std: f64,
    /// Recorded less expected, in standard deviations.
    pub residual_in_std: f64,
    /// The same of what the total count has beyond the signed one; none without totals.
    pub total_residual_in_std: Option<f64>,
}

/// Ranges a recorded scan with the scene's estimator, and holds it against what the
/// scene lets one expect.
///
/// The model estimator needs total counts: a scan without them is ranged by the phase,
/// with a remark.
pub fn assess(sensor: &Sensor, scan: &RecordedScan) -> Assessment {
    let scene = sensor.scene();
    let without_totals = !scan.has_totals && scene.estimator == EstimatorKind::Model;
    let mut estimate = match without_totals {
        true => estimate_scan(&by_phase(sensor), scan.detector, &scan.counts),
        false => estimate_scan(sensor, scan.detector, &scan.counts),
    };
    if without_totals {
        estimate
            .add_remark("ranged by the phase: the model estimator needs the column total_count");
    }
    let found = check_testable(sensor, scan.detector)
        .and_then(|()| diagnose(sensor, scan, later_ps(sensor, scan)).map_err(|e| e.to_string()));
    let mut assessment = Assessment {
        detector: scene.detectors[scan.detector].name.clone(),
        estimate,
        fitted_distance_m: None,
        fitted_distance_std_m: None,
        chi_square: None,
        degrees_of_freedom: None,
        p_value: None,
        diagnosis: None,
        remark: None,
        phase_steps: Vec::new(),
    };
    match found {
        Ok(found) => assessment.take(sensor, scan, found),
        Err(reason) => assessment.remark = Some(format!("no residuals: {reason}")),
    }
    assessment
}

/// Why counts cannot be held against their scene.
fn check_testable(sensor: &Sensor, detector: DetectorIndex) -> Result<(), String> {
    let parallel = sensor.scene().hardware.parallel;
    if parallel > 1 {
        return Err(format!(
            "with parallel = {parallel} the steps of a group see the same light, and their residuals \
             go together"
        ));
    }
    TheoryEffort::of(sensor, detector)
        .and_then(|effort| effort.check_fit())
        .map_err(|reason| NoFit::from(reason).to_string())
}

/// How much later than the scene's nearest own path the peak stands, by the phase.
fn later_ps(sensor: &Sensor, scan: &RecordedScan) -> Option<f64> {
    let report = estimate_scan(&by_phase(sensor), scan.detector, &scan.counts);
    let bias_m = report.expected_bias_m.unwrap_or(0.0);
    let ps_per_m = 1.0 / distance_m(1.0);
    Some((report.error_m? - bias_m) * ps_per_m)
}

/// The sensor, ranged by the phase.
fn by_phase(sensor: &Sensor) -> Sensor {
    sensor.with(|scene| scene.estimator = EstimatorKind::Fft)
}

impl Assessment {
    fn take(&mut self, sensor: &Sensor, scan: &RecordedScan, found: Found) {
        let (scene, fitted) = (sensor.scene(), found.fitted);
        let step_ps = scene.chip_period_ps / f64::from(scene.samples_per_chip);
        let offset_ps = self.estimate.calibration_offset_ps;
        let per_step = fitted.whitened.len() / scan.counts.len().max(1);
        let of_step = |(j, count): (usize, &crate::photons::StepCount)| {
            let moment = &fitted.moments[j];
            let phase_step = scene.scan.phase_step(Step::at(j));
            let residuals = &fitted.whitened[j * per_step..(j + 1) * per_step];
            StepResidual {
                phase_step,
                distance_m: distance_m(phase_step as f64 * step_ps - offset_ps),
                count: count.signed,
                expected_count: moment.signed_mean,
                expected_count_std: moment.signed_variance.max(0.0).sqrt(),
                residual_in_std: residuals[0],
                total_residual_in_std: residuals.get(1).copied(),
            }
        };
        self.phase_steps = scan.counts.iter().enumerate().map(of_step).collect();
        let delay_std = fitted.errors.iter().find(|(of, _)| *of == Unknown::Delay);
        if let (Some((_, std_ps)), Some(path)) = (delay_std, self.estimate.path) {
            let code = &scene.sources[scene.paths[path].source].code;
            let period_ps = scene.chip_period_ps * code.len() as f64;
            let delay_ps = scene.paths[path].delay_ps + fitted.change.delay_ps;
            self.fitted_distance_m = Some(distance_m(delay_ps.rem_euclid(period_ps)));
            self.fitted_distance_std_m = Some(distance_m(*std_ps));
        }
        self.chi_square = Some(fitted.chi_square);
        self.degrees_of_freedom = Some(fitted.degrees);
        self.p_value = fitted.p_value;
        self.diagnosis = Some(found.diagnosis);
    }

    /// The residuals as CSV.
    pub fn residuals_csv(&self) -> String {
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
            write!(
                f,
                " (expected bias {bias_mm:+.2} mm, standard deviation {std_mm:.2} mm)"
            )?;
        }
        if let Some(truth_m) = estimate.true_distance_m {
            write!(f, "; the scene's path: {truth_m:.4} m")?;
        }
        writeln!(f)?;
        if let (Some(distance_m), Some(std_m)) =
            (self.fitted_distance_m, self.fitted_distance_std_m)
        {
            let std_mm = std_m * 1e3;
            writeln!(
                f,
                "  best fit of the scene: {distance_m:.4} m +- {std_mm:.2} mm"
            )?;
        }
        if let (Some(chi_square), Some(degrees)) = (self.chi_square, self.degrees_of_freedom) {
            write!(
                f,
                "  chi-square {chi_square:.1} for {degrees} degrees of freedom"
            )?;
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
