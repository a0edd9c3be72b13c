//! What people read: plots, tables, the report page.

#[cfg(feature = "plots")]
mod block_diagram;
#[cfg(feature = "plots")]
pub(crate) mod chart;
mod columns;
#[cfg(feature = "plots")]
mod coordinate;
#[cfg(feature = "plots")]
pub(crate) mod curves;
pub mod estimates;
#[cfg(feature = "plots")]
mod figure;
#[cfg(feature = "plots")]
mod geometry;
#[cfg(feature = "plots")]
mod layers;
#[cfg(feature = "plots")]
mod line_plot;
#[cfg(feature = "plots")]
mod netlist;
#[cfg(feature = "plots")]
pub(crate) mod page;
pub mod plan;
pub mod provenance;
pub(crate) mod quantities;
#[cfg(feature = "plots")]
pub(crate) mod timing;

use crate::scene::DetectorIndex;
use std::fmt::Write as _;

use crate::cosim::sent::SentCount;
use crate::estimate::distance_m;
use crate::histogram::Histogram;
use crate::scan::Step;
use crate::sensor::Sensor;

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
    /// Counts that were sent of the scan's steps, or of the first of them, and where
    /// they belong.
    pub fn new(
        sensor: &Sensor,
        detector: DetectorIndex,
        calibration_offset_ps: f64,
        sent: &[SentCount],
    ) -> DetectorCounts {
        let of_step =
            |step| distance_m(sensor.timing().reference_delay_ps(step) - calibration_offset_ps);
        DetectorCounts {
            detector,
            distances_m: Step::all(sent.len() as u64).map(of_step).collect(),
            counts: sent.iter().map(|count| count.signed).collect(),
            totals: sent.iter().map(|count| count.total).collect(),
        }
    }
}

/// The counts of a scan as CSV: number of the measurement, phase step, its
/// calibrated distance, signed count, name of the detector, and the total count if
/// the scene's hardware sends it.
pub fn counts_csv(sensor: &Sensor, detectors: &[DetectorCounts]) -> String {
    let heading = match sensor.scene().sends_total_counts() {
        true => ",total_count",
        false => "",
    };
    let mut text = format!("measurement,phase_step,distance_m,count,detector{heading}\n");
    for of_detector in detectors {
        let name = quoted(&sensor.scene().detectors[of_detector.detector].name);
        let steps = of_detector.distances_m.iter().zip(&of_detector.counts);
        for (j, (distance_m, count)) in steps.enumerate() {
            let step = sensor.timing().scan.phase_step(Step::at(j));
            let _ = write!(text, "{j},{step},{distance_m:.6},{count},{name}");
            let total = of_detector.totals.as_ref().map(|totals| totals[j]);
            let _ = match total {
                Some(total) => writeln!(text, ",{total}"),
                None => writeln!(text),
            };
        }
    }
    text
}

/// Histograms as CSV: bin, its count, and the name of the detector.
pub fn bins_csv(sensor: &Sensor, histograms: &[(DetectorIndex, Histogram)]) -> String {
    let mut text = "bin,count,detector\n".to_owned();
    for (detector, histogram) in histograms {
        let name = quoted(&sensor.scene().detectors[*detector].name);
        for (bin, count) in histogram.bins().iter().enumerate() {
            let _ = writeln!(text, "{bin},{count},{name}");
        }
    }
    text
}

/// A field of a CSV file (RFC 4180).
pub(crate) fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn a_name_with_commas_or_quotes_stays_one_field() {
        assert_eq!(quoted("spad"), "spad");
        assert_eq!(quoted("left, \"old\""), "\"left, \"\"old\"\"\"");
    }
}
