//! What people read: plots, tables, the report page.

mod block_diagram;
pub mod chart;
pub(crate) mod columns;
mod coordinate;
pub mod curves;
pub mod estimates;
mod figure;
mod geometry;
pub(crate) mod image;
pub(crate) mod kept;
mod layers;
pub(crate) mod limits;
mod offsets;
pub(crate) mod page;
#[cfg(feature = "parquet")]
pub mod parquet;
pub mod plan;
mod prelude;
pub mod provenance;
pub(crate) mod raster;
mod residuals;
mod role;
pub mod table;
pub(crate) mod timing;

use std::fmt::Write as _;

use crate::cosim::sent::SentCount;
use crate::estimate::distance_m;
use crate::printable::csv_field;
use crate::recorded::RecordedHistogram;
use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

pub use self::residuals::residual_plot;

/// One detector's counts of a scan.
#[derive(Debug, Clone)]
pub struct DetectorCounts {
    /// Its index in the scene.
    pub detector: DetectorIndex,
    /// Distance of the light that each step stands for, calibrated; the steps
    /// before the calibration offset have negative ones.
    pub distances_m: Vec<f64>,
    /// Signed counts of the steps, in order.
    pub counts: Vec<i64>,
    /// Their total counts, if the hardware sends them.
    pub totals: Option<Vec<u64>>,
}

impl DetectorCounts {
    /// Where so many of the scan's first steps belong, without counts.
    pub fn of_steps(
        sensor: &Sensor,
        detector: DetectorIndex,
        calibration_offset_ps: f64,
        steps: usize,
    ) -> DetectorCounts {
        let of_step =
            |step| distance_m(sensor.timing().reference_delay_ps(step) - calibration_offset_ps);
        DetectorCounts {
            detector,
            distances_m: Step::all(steps as u64).map(of_step).collect(),
            counts: Vec::new(),
            totals: None,
        }
    }

    /// Counts that were sent of the scan's steps, or of the first of them, and where
    /// they belong.
    pub fn new(
        sensor: &Sensor,
        detector: DetectorIndex,
        calibration_offset_ps: f64,
        sent: &[SentCount],
    ) -> DetectorCounts {
        DetectorCounts {
            counts: sent.iter().map(|count| count.signed).collect(),
            totals: sent.iter().map(|count| count.total).collect(),
            ..DetectorCounts::of_steps(sensor, detector, calibration_offset_ps, sent.len())
        }
    }
}

/// The counts of a scan as CSV: number of the measurement, phase step, its
/// calibrated distance, signed count, name of the detector, and the total count if
/// the scene's hardware sends it; the chips of a step where a board adds up scans, of which these
/// are one.
pub fn counts_csv(sensor: &Sensor, detectors: &[DetectorCounts]) -> String {
    let scene = sensor.scene();
    let total = if scene.sends_total_counts() { ",total_count" } else { "" };
    let (chips, of_chips) = match scene.hardware.accumulate {
        1 => ("", String::new()),
        _ => (",integration_chips", format!(",{}", scene.scan.integration_chips)),
    };
    let mut text = format!("measurement,phase_step,distance_m,count,detector{total}{chips}\n");
    for of_detector in detectors {
        let name = csv_field(&sensor.scene().detectors[of_detector.detector].name);
        let steps = of_detector.distances_m.iter().zip(&of_detector.counts);
        for (j, (distance_m, count)) in steps.enumerate() {
            let step = sensor.timing().scan.phase_step(Step::at(j));
            let _ = write!(text, "{j},{step},{distance_m:.6},{count},{name}");
            let total = of_detector.totals.as_ref().map(|totals| totals[j]);
            if let Some(total) = total {
                let _ = write!(text, ",{total}");
            }
            let _ = writeln!(text, "{of_chips}");
        }
    }
    text
}

/// Histograms as CSV: bin, its count, and the name of the detector.
pub fn bins_csv(sensor: &Sensor, histograms: &[RecordedHistogram]) -> String {
    let mut text = "bin,count,detector\n".to_owned();
    for RecordedHistogram { detector, histogram } in histograms {
        let name = csv_field(&sensor.scene().detectors[*detector].name);
        for (bin, count) in histogram.bins().iter().enumerate() {
            let _ = writeln!(text, "{bin},{count},{name}");
        }
    }
    text
}
