//! What every step of a scan is expected to count, as a file.

use crate::scene::DetectorIndex;
use std::fmt::Write as _;

use crate::estimate::{calibration_offset_ps, distance_m};
use crate::photons::DetectorModel;
use crate::report::quoted;
use crate::response::{CountingTier, MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::sensor::Sensor;

/// Mean and standard deviation of the signed and the total count of every phase step
/// of every detector, as CSV: the columns of `counts.csv`, with `_mean` and `_std`, and
/// the covariance of the two.
///
/// # Errors
/// When the mean response cannot be had.
pub fn expected_csv(sensor: &Sensor, tier: CountingTier) -> Result<String, MeanResponseError> {
    let mut text = "measurement,phase_step,distance_m,detector,count_mean,count_std,\
                    total_count_mean,total_count_std,covariance\n"
        .to_owned();
    let scene = sensor.scene();
    let step_ps = scene.chip_period_ps / f64::from(scene.samples_per_chip);
    for (detector, spad) in DetectorIndex::all().zip(scene.detectors.iter()) {
        let model = DetectorModel::new(sensor, detector);
        let response = MeanResponse::of_tier(&model, tier)?;
        let moments = SecondMoments::new(&response)?.of_scan();
        let offset_ps = calibration_offset_ps(sensor, detector, tier);
        let name = quoted(&spad.name);
        for (j, moment) in moments.iter().enumerate() {
            let phase_step = scene.scan.phase_step(Step::at(j));
            let distance_m = distance_m(phase_step as f64 * step_ps - offset_ps);
            let _ = writeln!(
                text,
                "{j},{phase_step},{distance_m:.6},{name},{:.6},{:.6},{:.6},{:.6},{:.6}",
                moment.signed_mean,
                moment.signed_variance.max(0.0).sqrt(),
                moment.total_mean,
                moment.total_variance.max(0.0).sqrt(),
                moment.covariance
            );
        }
    }
    Ok(text)
}
