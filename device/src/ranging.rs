use goldtof::Sensor;
use goldtof::estimate::report::{EstimateReport, estimate_histogram, estimate_scan};
use goldtof::histogram::Histogram;
use goldtof::recorded::RecordedScan;
use goldtof::scene::{DetectorIndex, EstimatorKind};

use crate::{DetectorScan, Scan};

/// Ranges scans with the estimator of the scene that the device was built from.
#[derive(Debug)]
pub struct Ranging {
    sensor: Sensor,
    /// Of scans without the total counts that the model estimator needs.
    by_phase: Sensor,
}

impl Ranging {
    /// By a scene.
    pub fn new(sensor: Sensor) -> Ranging {
        let by_phase = sensor.estimated_by(EstimatorKind::Fft);
        Ranging { sensor, by_phase }
    }

    /// The scene.
    pub fn sensor(&self) -> &Sensor {
        &self.sensor
    }

    /// What each detector's counts say.
    ///
    /// # Errors
    ///
    /// They are no counts of this scene: what is wrong, detector by detector.
    pub fn range(&self, scan: &Scan) -> Vec<Result<EstimateReport, String>> {
        let detectors = DetectorIndex::of(&self.sensor.scene().detectors);
        detectors.zip(&scan.detectors).map(|(detector, of)| self.of_one(detector, of)).collect()
    }

    fn of_one(&self, detector: DetectorIndex, of: &DetectorScan) -> Result<EstimateReport, String> {
        if let Some(plan) = self.sensor.interface().histogram() {
            if of.counts.len() as u64 != plan.bins() {
                return Err(format!(
                    "{} bins came, and a histogram of this scene has {}",
                    of.counts.len(),
                    plan.bins()
                ));
            }
            let bins = of.counts.iter().map(|&count| u64::try_from(count).unwrap_or(0)).collect();
            let histogram = Histogram::new(bins, plan.row_bins, plan.periods);
            let histogram = histogram.map_err(|error| error.to_string())?;
            return Ok(estimate_histogram(&self.sensor, detector, &histogram));
        }
        let totals = (!of.totals.is_empty()).then_some(&of.totals[..]);
        let scan = RecordedScan::new(self.sensor.scene(), detector, &of.counts, totals)
            .map_err(|error| error.to_string())?;
        let sensor = if scan.has_totals { &self.sensor } else { &self.by_phase };
        Ok(estimate_scan(sensor, detector, &scan.counts))
    }
}
