//! Everything that is known of a sensor before it is simulated.

use serde::Serialize;

use super::cells::FpgaCells;
use super::figures::Figures;
use super::link::{LinkBudget, link_budget};
use super::resources::{Resources, resources, saved_by};
use super::{Plan, measure};
use crate::estimate::bound::BoundKind;
use crate::estimate::report::{EstimateReport, Reporter};
use crate::scene::{DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

/// What `goldtof plan` gives.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Overview {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// Scans that a board adds up, of whose sum errors are expected.
    #[serde(skip)]
    pub added_scans: u32,
    /// Every part, kept or left out.
    #[serde(flatten)]
    pub plan: Plan,
    /// The sensor in numbers.
    pub figures: Figures,
    /// What its hardware takes; none of a sensor like none that was measured.
    pub resources: Option<Resources>,
    /// Photons of each path, but for those of dark sources.
    pub link: Vec<LinkBudget>,
    /// What theory expects of each detector's estimates, by either estimator: of sums of scans where
    /// `hardware.accumulate` asks for them.
    pub expected: Vec<ExpectedError>,
}

/// What theory expects of an estimator.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ExpectedError {
    /// The detector's name.
    pub detector: String,
    /// The source that it ranges.
    pub source: String,
    /// The estimator.
    pub estimator: EstimatorKind,
    /// Whether the hardware sends what it needs.
    pub has_its_counts: bool,
    /// The path's distance, folded into the unambiguous range.
    pub true_distance_m: Option<f64>,
    /// Mean error.
    pub expected_bias_m: Option<f64>,
    /// Standard deviation.
    pub expected_std_m: Option<f64>,
    /// Share of scans that miss the peak, of which they are not; of a fit null where the phase misses one in a thousand at most.
    pub expected_missed_fraction: Option<f64>,
    /// Least standard deviation of an estimate.
    pub bound_m: Option<f64>,
    /// What `bound_m` is; null without one.
    pub bound_kind: Option<BoundKind>,
    /// Why something is missing.
    pub remark: Option<String>,
}

/// Works it out, and measures what the parts that the simulation leaves out save.
pub fn overview(sensor: &Sensor) -> Overview {
    let plan = measure::with_savings(super::plan(sensor), sensor);
    Overview {
        scene: sensor.scene().name.clone(),
        added_scans: sensor.scene().hardware.accumulate,
        plan: with_cells(plan, sensor),
        figures: Figures::of(sensor),
        resources: resources(sensor),
        link: link_budget(sensor),
        // Of what a host gets.
        expected: expected(&sensor.summed()),
    }
}

/// Adds what parts of the hardware that are left out would take.
pub fn with_cells(mut plan: Plan, sensor: &Sensor) -> Plan {
    for part in plan.hardware.iter_mut().filter(|part| !part.kept) {
        let nothing = FpgaCells { luts: 0, flip_flops: 0 };
        part.saved_cells = saved_by(sensor, part).filter(|cells| *cells != nothing);
    }
    plan
}

/// Both estimators, detector by detector.
pub fn expected(sensor: &Sensor) -> Vec<ExpectedError> {
    let [phase, model] =
        [EstimatorKind::Fft, EstimatorKind::Model].map(|kind| sensor.estimated_by(kind));
    let of_detector = |detector| {
        let by_phase = Reporter::new(&phase, detector);
        let mut by_fit = Reporter::new(&model, detector);
        for path in sensor.scene().own_paths(detector).take(1) {
            by_fit = by_fit.knowing(path, by_phase.theory(path).clone());
        }
        [by_phase, by_fit].map(|reporter| of(reporter.expected(), sensor))
    };
    DetectorIndex::of(&sensor.scene().detectors).flat_map(of_detector).collect()
}

fn of(report: EstimateReport, sensor: &Sensor) -> ExpectedError {
    ExpectedError {
        detector: report.detector,
        source: report.source,
        estimator: report.estimator,
        has_its_counts: report.estimator == EstimatorKind::Fft
            || sensor.scene().sends_total_counts(),
        true_distance_m: report.true_distance_m,
        expected_bias_m: report.expected_bias_m,
        expected_std_m: report.expected_std_m,
        expected_missed_fraction: report.expected_missed_fraction,
        bound_m: report.bound_m,
        bound_kind: report.bound_kind,
        remark: report.remark.or(report.folded).or(report.bound_remark),
    }
}
