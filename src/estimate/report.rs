//! The estimate of one detector beside the truth and what theory expects.

use std::fmt;

use serde::Serialize;

use super::{
    CountingTier, Measurement, calibration_offset_ps, delay_error_ps, distance_m, estimate,
    predict, true_delay,
};
use crate::scene::{EstimatorKind, Path, Scene};

/// Said when a scene asks for the estimator that these counts do not suffice for.
const PHASE_FOR_MODEL: &str = "estimator = \"model\" needs the total counts beside the signed ones, \
                               which the hardware does not send: this is the phase estimate";

/// What a scan's counts say about the distance.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EstimateReport {
    /// The detector's name.
    pub detector: String,
    /// The source whose light it ranges.
    pub source: String,
    /// Index of the path that the estimate is held against: of all paths of its
    /// reference's source, the nearest to the estimate; without an estimate the
    /// first.
    pub path: Option<usize>,
    /// The estimate; none when the counts have no peak.
    pub distance_m: Option<f64>,
    /// That path's distance, folded into the unambiguous range.
    pub true_distance_m: Option<f64>,
    /// When a path that moves has it, from the start of the scan: as the scan comes
    /// by the path. None for a path that stands still.
    pub true_at_s: Option<f64>,
    /// Estimate less truth, the shorter way round the unambiguous range.
    pub error_m: Option<f64>,
    /// The estimator's bias on the exact mean counts of this scene (dead-time
    /// walk, interference, circular error).
    pub expected_bias_m: Option<f64>,
    /// Its standard deviation from the counts' variances.
    pub expected_std_m: Option<f64>,
    /// (error - expected bias) / expected standard deviation.
    pub deviation_in_std: Option<f64>,
    /// Phase step of the largest count.
    pub coarse_step: Option<u64>,
    /// Subtracted from the measured delay: everything constant that is not light.
    pub calibration_offset_ps: f64,
    /// Distance beyond which the code repeats.
    pub unambiguous_range_m: f64,
    /// Why there is no estimate, or only a coarse one, or no expectation.
    pub remark: Option<String>,
}

/// Estimates the distance that a detector's counts of one scan give.
///
/// `counts` are those of the steps in order; fewer than the scan's steps give no
/// estimate.
pub fn estimate_scan(scene: &Scene, detector: usize, counts: &[i64]) -> EstimateReport {
    let spad = &scene.detectors[detector];
    let source = &scene.sources[spad.reference];
    let code_period_ps = scene.chip_period_ps * source.code.len() as f64;
    let offset_ps = calibration_offset_ps(scene, detector, CountingTier::Sampled);
    let mut report = EstimateReport {
        detector: spad.name.clone(),
        source: source.name.clone(),
        path: None,
        distance_m: None,
        true_distance_m: None,
        true_at_s: None,
        error_m: None,
        expected_bias_m: None,
        expected_std_m: None,
        deviation_in_std: None,
        coarse_step: None,
        calibration_offset_ps: offset_ps,
        unambiguous_range_m: distance_m(code_period_ps),
        remark: None,
    };
    if (counts.len() as u64) < scene.scan.steps {
        report.remark = Some(format!(
            "no estimate: {} of the scan's {} phase steps were measured",
            counts.len(),
            scene.scan.steps
        ));
        return report;
    }
    let mut measured_ps = None;
    match estimate(&Measurement::new(scene, counts), offset_ps) {
        Err(reason) => report.remark = Some(format!("no estimate: {reason}")),
        Ok(estimate) => {
            report.distance_m = Some(estimate.distance_m);
            report.coarse_step = Some(estimate.coarse_step);
            report.remark = match (estimate.coarse_only, scene.estimator) {
                (Some(reason), _) => Some(format!("coarse estimate only: {reason}")),
                (None, EstimatorKind::Model) => Some(PHASE_FOR_MODEL.to_owned()),
                (None, EstimatorKind::Fft) => None,
            };
            measured_ps = Some(estimate.delay_ps);
        }
    }
    let truth = |p: usize| true_delay(scene, p, CountingTier::Sampled);
    let error_ps = |p: usize| {
        let true_ps = truth(p).delay_ps;
        delay_error_ps(measured_ps.unwrap_or(true_ps), true_ps, code_period_ps)
    };
    let is_own = |path: &Path| path.detector == detector && path.source == spad.reference;
    report.path = (0..scene.paths.len())
        .filter(|&p| is_own(&scene.paths[p]))
        .min_by(|&a, &b| error_ps(a).abs().total_cmp(&error_ps(b).abs()));
    if let Some(path) = report.path {
        let truth = truth(path);
        let true_ps = truth.delay_ps.rem_euclid(code_period_ps);
        report.true_distance_m = Some(distance_m(true_ps));
        report.true_at_s = truth.at_ps.map(|ps| ps * 1e-12);
        report.error_m = measured_ps.map(|_| distance_m(error_ps(path)));
        report.add_expectation(scene, detector, path);
    }
    report
}

impl EstimateReport {
    fn add_expectation(&mut self, scene: &Scene, detector: usize, path: usize) {
        match predict(scene, detector, path, CountingTier::Sampled) {
            Ok(expected) => {
                self.expected_bias_m = Some(expected.bias_m);
                self.expected_std_m = Some(expected.std_m);
                self.deviation_in_std = self
                    .error_m
                    .map(|error_m| (error_m - expected.bias_m) / expected.std_m);
            }
            Err(reason) if self.remark.is_none() => {
                self.remark = Some(format!("no expectation: {reason}"));
            }
            Err(_) => {}
        }
    }

    /// Name and value of everything that is known, for a table.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let metres = |value: f64| format!("{value:.4} m");
        let millimetres = |value: f64| format!("{:.2} mm", value * 1e3);
        let mut rows = vec![("detector", self.detector.clone())];
        let mut row = |name, value: Option<String>| {
            if let Some(value) = value {
                rows.push((name, value));
            }
        };
        row("estimated distance", self.distance_m.map(metres));
        row("true distance", self.true_distance_m.map(metres));
        row(
            "true distance is that of",
            self.true_at_s
                .map(|at_s| format!("{:.4} ms after the start of the scan", at_s * 1e3)),
        );
        row("error", self.error_m.map(millimetres));
        row("expected bias", self.expected_bias_m.map(millimetres));
        row(
            "expected standard deviation",
            self.expected_std_m.map(millimetres),
        );
        row(
            "error less expected bias",
            self.deviation_in_std
                .map(|d| format!("{d:+.2} standard deviations")),
        );
        row("coarse phase step", self.coarse_step.map(|k| k.to_string()));
        row(
            "calibration offset",
            Some(format!("{:.1} ps", self.calibration_offset_ps)),
        );
        row("unambiguous range", Some(metres(self.unambiguous_range_m)));
        row("remark", self.remark.clone());
        rows
    }
}

impl fmt::Display for EstimateReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.detector)?;
        if let Some(distance_m) = self.distance_m {
            write!(f, " {distance_m:.4} m")?;
        }
        if let (Some(truth_m), Some(error_m)) = (self.true_distance_m, self.error_m) {
            write!(f, ", true {truth_m:.4} m, error {:+.2} mm", error_m * 1e3)?;
        }
        if let (Some(bias_m), Some(std_m)) = (self.expected_bias_m, self.expected_std_m) {
            write!(
                f,
                " (expected bias {:+.2} mm, standard deviation {:.2} mm)",
                bias_m * 1e3,
                std_m * 1e3
            )?;
        }
        match &self.remark {
            Some(remark) => write!(f, " {remark}"),
            None => Ok(()),
        }
    }
}
