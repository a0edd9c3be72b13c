//! The model estimator: delay and strength of every path, and the constant
//! light, fitted to the counts.
//!
//! The expected counts of this detector under any light can be computed
//! ([`MeanResponse`](crate::response::MeanResponse)), so the fit does not need a phase: it is weighted least
//! squares of (r\[k\], N\[k\]) with the full 2 x 2 covariance of each step, by
//! Fisher scoring ([`scoring`]). Range walk, circular error and interference are part of the model
//! and do not bias it. The background is always an unknown, so that extinction ratio and ambient
//! light do not have to be known; this costs less than 2 % of the precision.
//!
//! All steps of the scan are used: the side lobes of a Gold code carry as much information about the
//! delay as its peak. A moving path, and one under light of another clock, is fitted to the 3 S
//! steps round the peak. Several sources are found one after another ([`joint`]); light of other codes
//! needs a scan over the whole code period, where its cross-correlation is as distinct as the
//! peak; in a window it hardly shows.

mod air;
pub(super) mod bins;
mod descent;
pub(super) mod error;
mod fitter;
mod hadamard;
mod joint;
mod known_moments;
pub(super) mod likeliest;
mod model_estimate;
pub(crate) mod moments;
pub(super) mod moving;
pub(crate) mod normal;
mod one_path;
mod pairs;
pub(super) mod parameters;
mod places;
pub(super) mod problem;
mod rivals;
pub(crate) mod scoring;
mod search;
pub(in crate::estimate) mod slipping;
pub(super) mod start;
pub(crate) mod template;
pub(crate) mod weights;

pub(super) use self::air::own_threshold;
pub use self::bins::BinFitter;
pub use self::error::FitError;
pub use self::fitter::Fitter;
pub use self::model_estimate::{ALARM_SIGMAS, FittedPath, ModelEstimate, Untold, Velocity};
pub(super) use self::pairs::{LEAST_SHARE, TOLD_APART};
use self::parameters::share_of_ones;
use super::CountingTier;
use super::approximation::Approximation;
use crate::photons::{DetectorModel, StepCount};
use crate::response::{Light, MeanCount};
use crate::scene::DetectorIndex;
pub use crate::scene::OtherLight;
use crate::sensor::Sensor;

/// Fits the counts of one scan of detector `detector`: [`Fitter::fit`], for one
/// scan only.
///
/// # Errors
/// As there.
pub fn fit(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    counts: &[StepCount],
    other: OtherLight,
) -> Result<ModelEstimate, FitError> {
    Fitter::new(sensor, detector, tier, other).fit(counts)
}

/// The same for counts that need not be whole, one per step of the scan.
///
/// # Errors
/// As [`fit`].
pub fn fit_means(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    counts: &[MeanCount],
    other: OtherLight,
) -> Result<ModelEstimate, FitError> {
    Fitter::new(sensor, detector, tier, other).fit_means(counts)
}

/// Below this many detections the difference of two steps that count the same light is not
/// normally distributed.
const FEW_BETWEEN_STEPS: f64 = 50.0;

/// Whether a fit to steps that share their light has the standard deviation that it reports.
///
/// # Errors
/// Why not: it may be up to 1.5 times as large for one path, up to 3 times for several.
pub fn check_shared_light(sensor: &Sensor, detector: DetectorIndex) -> Result<(), Approximation> {
    let parallel = sensor.timing().parallel;
    if parallel <= 1 {
        return Ok(());
    }
    let model = DetectorModel::new(sensor, detector);
    let of_one = Approximation {
        name: "that differences of neighbouring phase steps in a group are normally distributed",
        measure: "inverse of the detections by which they differ:",
        size: 1.0 / detections_between_steps(&model),
        bound: 1.0 / FEW_BETWEEN_STEPS,
        concerns_misses: false,
    };
    let of_several = Approximation {
        name: "that phase steps count different light where several paths are told apart",
        measure: "phase steps of a group:",
        size: f64::from(parallel),
        bound: 1.0,
        concerns_misses: false,
    };
    match air::is_one_path(sensor, &model, sensor.scene().other_light) {
        true => of_one.check(),
        false => of_several.check(),
    }
}

/// That more light makes more detections, which a dead time that arrivals prolong ends: beyond one
/// arrival in a dead time there are fewer, and counts fold over to those of less light.
pub fn folds_over(model: &DetectorModel, brightest_per_chip: f64) -> Approximation {
    let dead_time = model.dead_time();
    let arrivals = brightest_per_chip * dead_time.length;
    Approximation {
        name: "that more light makes more detections (recharge = \"passive\" folds over)",
        measure: "arrivals in a dead time while every laser is on",
        size: if dead_time.is_prolonged { arrivals } else { 0.0 },
        bound: 1.0,
        concerns_misses: true,
    }
}

/// The warning for fits to steps that share their light.
pub fn shared_light(sensor: &Sensor, detector: DetectorIndex) -> Option<String> {
    let parallel = sensor.timing().parallel;
    let size = check_shared_light(sensor, detector).err()?.size;
    Some(match size < 1.0 {
        true => format!(
            "with parallel = {parallel} the phase steps of a group count the same light, and \
             neighbours differ by only some {:.0} detections: the scatter may be up to \
             1.5 times the standard deviation of the fit (within 5 % from {FEW_BETWEEN_STEPS} on)",
            1.0 / size
        ),
        false => format!(
            "with parallel = {parallel} the phase steps of a group count the same light; the scatter of \
             several paths may be up to 3 times the standard deviation of the fit"
        ),
    })
}

/// Detections of a step that its neighbour counts with the other sign, about: those within a
/// phase step of the reference's edges.
fn detections_between_steps(model: &DetectorModel) -> f64 {
    let light = Light::of(model).of_cell(model);
    let lit = light.paths.iter().map(|path| path.rate_per_chip * share_of_ones(&path.code));
    let primary = light.constant_per_chip + lit.sum::<f64>();
    let detected = f64::from(model.added_cells()) * model.dead_time().detected(primary);
    let chips = &model.reference.chips;
    let next = chips.iter().cycle().skip(1);
    let edges = chips.iter().zip(next).filter(|(chip, next)| chip != next).count() as f64;
    let edges = edges / chips.len() as f64 * model.timing.scan.integration_chips as f64;
    detected * edges / f64::from(model.timing.clock.samples_per_chip)
}
