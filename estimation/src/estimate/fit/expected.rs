//! What a fit says of expected counts.

use super::bins::BinFitter;
use super::error::FitError;
use super::fitter::Fitter;
use super::model_estimate::ModelEstimate;
use super::moving;
use crate::estimate::bound::bound;
use crate::estimate::{CountingTier, TheoryEffort};
use crate::photons::DetectorModel;
use crate::response::MeanResponse;
use crate::scene::{Architecture, DetectorIndex};
use crate::sensor::Sensor;

/// What the fit says of a scene's expected counts, told of other light what the
/// scene says: its average answer, to first order in the noise.
///
/// # Errors
/// As [`Fitter::fit`].
///
/// # Panics
/// If the scene has no such detector.
pub fn expected_fit(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
) -> Result<ModelEstimate, FitError> {
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        TheoryEffort::of(sensor, detector)?.check_histogram()?;
        return BinFitter::new(sensor, detector)?.expected();
    }
    let other = sensor.scene().other_light;
    let fitter = Fitter::new(sensor, detector, tier, other);
    let moment_ps = fitter.moment_ps()?;
    TheoryEffort::of(sensor, detector)?.check_fit()?;
    let still;
    let standing = match moment_ps {
        Some(moment_ps) => {
            still = sensor.still_at(moment_ps);
            &still
        }
        None => sensor,
    };
    let model = DetectorModel::new(standing, detector);
    let response = MeanResponse::of_tier(&model, tier)?;
    if response.misses_pulses() {
        // A fit settles everywhere, but there its average is not that of the average.
        bound(sensor, detector, tier)?;
    }
    let mut means = response.mean_counts();
    if let Some(moment_ps) = moment_ps {
        moving::take_movement(sensor, &response, tier, moment_ps, &mut means)?;
    }
    fitter.fit_means(&means)
}
