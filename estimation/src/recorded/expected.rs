//! What every step of a scan is expected to count, as a file.

use std::fmt::Write as _;

use crate::estimate::{calibration_offset_ps, distance_m};
use crate::photons::DetectorModel;
use crate::printable::csv_field;
use crate::response::{CountingTier, MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Mean and standard deviation of every bin of a detector of a sensor that keeps histograms.
///
/// # Errors
/// When the mean response cannot be had.
pub fn expected_bins(
    sensor: &Sensor,
    detector: DetectorIndex,
) -> Result<Vec<[f64; 2]>, MeanResponseError> {
    let model = DetectorModel::new(sensor, detector);
    let means = MeanResponse::new(&model)?.mean_bins();
    let periods = sensor.interface().histogram().map_or(1, |plan| plan.periods) as f64;
    Ok(with_std(&means, periods))
}

/// Bins with their standard deviations: each comes by once in a period.
pub(super) fn with_std(means: &[f64], periods: f64) -> Vec<[f64; 2]> {
    let std = |mean: f64| (mean * (1.0 - mean / periods)).max(0.0).sqrt();
    means.iter().map(|&mean| [mean, std(mean)]).collect()
}

/// The bins of every detector, as CSV: the columns of `bins.csv`, with `_mean` and `_std`.
fn expected_bins_csv(sensor: &Sensor) -> Result<String, MeanResponseError> {
    let mut text = "bin,count_mean,count_std,detector\n".to_owned();
    for (detector, spad) in DetectorIndex::all().zip(&sensor.scene().detectors) {
        let name = csv_field(&spad.name);
        for (bin, [mean, std]) in expected_bins(sensor, detector)?.iter().enumerate() {
            let _ = writeln!(text, "{bin},{mean:.6},{std:.6},{name}");
        }
    }
    Ok(text)
}

/// Mean and standard deviation of the signed and the total count of every phase step
/// of every detector, as CSV: the columns of `counts.csv`, with `_mean` and `_std`, and
/// the covariance of the two; of a sensor that keeps histograms those of every bin.
///
/// # Errors
/// When the mean response cannot be had.
pub fn expected_csv(sensor: &Sensor, tier: CountingTier) -> Result<String, MeanResponseError> {
    if sensor.interface().histogram().is_some() {
        return expected_bins_csv(sensor);
    }
    let mut text = "measurement,phase_step,distance_m,detector,count_mean,count_std,\
                    total_count_mean,total_count_std,covariance\n"
        .to_owned();
    let scene = sensor.scene();
    let step_ps = sensor.clock().sample_period_ps();
    for (detector, spad) in DetectorIndex::all().zip(scene.detectors.iter()) {
        let model = DetectorModel::new(sensor, detector);
        let response = MeanResponse::of_tier(&model, tier)?;
        let moments = SecondMoments::new(&response)?.of_scan();
        let offset_ps = calibration_offset_ps(sensor, detector, tier);
        let name = csv_field(&spad.name);
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
