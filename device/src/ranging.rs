use goldtof::Sensor;
use goldtof::estimate::report::{EstimateReport, Reporter};
use goldtof::histogram::Histogram;
use goldtof::recorded::RecordedScan;
use goldtof::scene::{DetectorIndex, EstimatorKind};

use crate::{DetectorScan, Scan};

/// The scene that a device was built from, whose estimator ranges its scans.
#[derive(Debug)]
pub struct Ranging {
    sensor: Sensor,
    /// Of scans without the total counts that the model estimator needs.
    by_phase: Sensor,
}

/// Ranges scan after scan: what follows from the scene alone is worked out once.
#[derive(Debug)]
pub struct Ranger<'r> {
    ranging: &'r Ranging,
    /// Of each detector: by the scene's estimator, and by the phase.
    reporters: Vec<[Reporter<'r>; 2]>,
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

    /// What ranges its scans.
    pub fn ranger(&self) -> Ranger<'_> {
        let sensors = [&self.sensor, &self.by_phase];
        let of = |detector| sensors.map(|sensor| Reporter::new(sensor, detector));
        let detectors = DetectorIndex::of(&self.sensor.scene().detectors);
        Ranger { ranging: self, reporters: detectors.map(of).collect() }
    }
}

impl Ranger<'_> {
    /// What each detector's counts say.
    ///
    /// # Errors
    ///
    /// They are no counts of this scene: what is wrong, detector by detector.
    pub fn range(&self, scan: &Scan) -> Vec<Result<EstimateReport, String>> {
        let detectors = DetectorIndex::all().zip(&self.reporters).zip(&scan.detectors);
        let range = |((detector, reporters), of)| self.of_one(detector, reporters, of);
        detectors.map(range).collect()
    }

    fn of_one(
        &self,
        detector: DetectorIndex,
        [reporter, by_phase]: &[Reporter; 2],
        of: &DetectorScan,
    ) -> Result<EstimateReport, String> {
        let sensor = &self.ranging.sensor;
        if let Some(plan) = sensor.interface().histogram() {
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
            return Ok(reporter.histogram(&histogram));
        }
        let totals = (!of.totals.is_empty()).then_some(&of.totals[..]);
        let scan = RecordedScan::new(sensor.scene(), detector, &of.counts, totals)
            .map_err(|error| error.to_string())?;
        let reporter = if scan.has_totals { reporter } else { by_phase };
        Ok(reporter.scan(&scan.counts))
    }
}
