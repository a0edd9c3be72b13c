//! Dead time and afterpulses as a histogram has them, if it shows them.

use crate::histogram::correction::{BinnedAfterpulses, BinnedDetector};
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Jitter of two detections is taken to reach this many standard deviations of one.
const JITTER_REACH_SIGMAS: f64 = 8.5;

/// Why dead time and afterpulses are left in a histogram.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Uncorrected {
    /// Some pulses lie between two samples.
    #[error(
        "pulses of {pulse_ns} ns may fall between two samples, {sample_ns} ns apart, so that the \
         histogram does not show when the detector was blind"
    )]
    PulsesMissed {
        /// Width of a pulse.
        pulse_ns: f64,
        /// From one sample to the next.
        sample_ns: f64,
    },
    /// Some detections have no rising edge of their own.
    #[error(
        "pulses of {pulse_ns} ns, sampled every {sample_ns} ns, may merge after a dead time of \
         {dead_time_ns} ns, so that the histogram does not show when the detector was blind"
    )]
    PulsesMerge {
        /// Width of a pulse.
        pulse_ns: f64,
        /// From one sample to the next.
        sample_ns: f64,
        /// The dead time.
        dead_time_ns: f64,
    },
    /// Afterpulses follow within a bin.
    #[error(
        "a dead time of {dead_time_ns} ns is shorter than a sample of {sample_ns} ns, so that the \
         histogram does not show afterpulses apart"
    )]
    DeadTimeBelowSample {
        /// The dead time.
        dead_time_ns: f64,
        /// From one sample to the next.
        sample_ns: f64,
    },
    /// The dead time has no fixed length.
    #[error(
        "with recharge = \"passive\" light prolongs the dead time of {dead_time_ns} ns, so that \
         the histogram does not show when the detector was blind"
    )]
    PassiveRecharge {
        /// The dead time after the last arrival.
        dead_time_ns: f64,
    },
    /// Other detectors fire it.
    #[error(
        "crosstalk of other detectors fires this one when these are ready, so that its histogram \
         alone does not show its light"
    )]
    Crosstalk,
    /// Several cells are blind at different times.
    #[error(
        "the detector has several cells, so that its histogram does not show which of them were \
         blind"
    )]
    Cells,
    /// Bins are of different widths.
    #[error(
        "the detector's samples are not equally far apart, so that the histogram does not show \
         when the detector was blind as if they were"
    )]
    UnevenSamples,
    /// Only counts of phase steps are known.
    #[error("counts of phase steps do not show when the detector was blind")]
    CountsOfSteps,
}

/// Dead time and afterpulses of a detector as its histogram has them, if it shows them.
///
/// # Errors
/// Why it does not.
pub fn dead_time(sensor: &Sensor, detector: DetectorIndex) -> Result<BinnedDetector, Uncorrected> {
    let spad = &sensor.scene().detectors[detector];
    let sample_ps = sensor.clock().sample_period_ps();
    let [pulse_ns, sample_ns, dead_time_ns] =
        [spad.pulse_width_ps, sample_ps, spad.dead_time_ps].map(|ps| ps / 1e3);
    if spad.is_paralyzable() {
        return Err(Uncorrected::PassiveRecharge { dead_time_ns });
    }
    if sensor.scene().hears_others(detector) {
        return Err(Uncorrected::Crosstalk);
    }
    if spad.cells > 1 {
        return Err(Uncorrected::Cells);
    }
    if !spad.sampler.is_even() {
        return Err(Uncorrected::UnevenSamples);
    }
    if pulse_ns < sample_ns {
        return Err(Uncorrected::PulsesMissed { pulse_ns, sample_ns });
    }
    let low_ps = spad.pulse_width_ps + sample_ps + JITTER_REACH_SIGMAS * spad.jitter_std_ps();
    if low_ps > spad.dead_time_ps {
        return Err(Uncorrected::PulsesMerge { pulse_ns, sample_ns, dead_time_ns });
    }
    let afterpulses = (spad.afterpulsing_probability > 0.0).then(|| BinnedAfterpulses {
        mean_per_avalanche: spad.afterpulses_per_avalanche(),
        time_constant_bins: spad.afterpulsing_time_constant_ps / sample_ps,
    });
    if afterpulses.is_some() && spad.dead_time_ps < sample_ps {
        return Err(Uncorrected::DeadTimeBelowSample { dead_time_ns, sample_ns });
    }
    Ok(BinnedDetector { bins: spad.dead_time_ps / sample_ps, afterpulses })
}

/// Whole code periods that a sensor's histogram takes in.
pub(super) fn periods(sensor: &Sensor) -> f64 {
    let timing = sensor.timing();
    (timing.scan.integration_chips / timing.code_chips()) as f64
}
