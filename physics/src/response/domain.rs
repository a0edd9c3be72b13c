//! Which detectors and light the mean response is solved for.

use crate::photons::DetectorModel;
use crate::photons::tail::Tail;

/// The finest step of integration, as a share of a chip.
pub(super) const FINEST_CELL_CHIPS: f64 = 1.0 / 128.0;

/// Weights of a jitter's reach take some megabytes.
const LARGEST_JITTER_CHIPS: u32 = 1 << 10;

/// Why there is no mean response for a scene.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MeanResponseError {
    /// A path does not stand still within a scan.
    #[error(
        "the delay of a path moves by {moved_ps:.3} ps within a scan; one mean response for the \
         whole scan needs at most {limit_ps:.3} ps, a thousandth of a phase step"
    )]
    Moving {
        /// How far it moves: walk, and twice the fluctuation's standard deviation.
        moved_ps: f64,
        /// How far it may.
        limit_ps: f64,
    },
    /// Pulses merge in the sampled hardware, more than can be left out.
    #[error(
        "pulses of {} ns after a dead time of {} ns, sampled every {} ns, merge: up to {:.3} % of \
         the detections are no rising edge of their own, and for {obstacle} that is not worked \
         out; the tiers sampled and rtl count what the hardware does",
        pulse_width_ps / 1e3,
        dead_time_ps / 1e3,
        sample_ps / 1e3,
        share * 100.0
    )]
    PulsesMerge {
        /// Width of a pulse.
        pulse_width_ps: f64,
        /// The dead time.
        dead_time_ps: f64,
        /// From one sample to the next.
        sample_ps: f64,
        /// Bound on the share of detections that merge with the one before.
        share: f64,
        /// Why their number is not worked out.
        obstacle: &'static str,
    },
    /// Afterpulses prolong the dead time after which others come.
    #[error(
        "recharge is passive, so that afterpulses within a dead time prolong it; the mean response \
         of recharge = \"passive\" is solved without afterpulsing: simulate it photon by photon"
    )]
    AfterpulsesProlong,
    /// Crosstalk of second order is too large to be left out.
    #[error(
        "the mean response has crosstalk to first order, and what that leaves out is about {:.2} % of the \
         detector's avalanches, where {:.2} % may be: simulate it photon by photon",
        share * 100.0,
        limit * 100.0
    )]
    Crosstalk {
        /// Their share.
        share: f64,
        /// The largest that is left out.
        limit: f64,
    },
    /// A detector with cells hears others, or is heard.
    #[error(
        "crosstalk of other detectors fires it, and it or they have several cells; the mean response has \
         crosstalk between single SPADs: simulate it photon by photon"
    )]
    CrosstalkOfCells,
    /// Several cells make one level.
    #[error(
        "the detector has several cells; the mean response is solved for a single one, and for cells \
         whose hits are added up (combination = \"adder\"): simulate it photon by photon"
    )]
    Cells,
    /// Cells whose hits are added up have different dark counts.
    #[error(
        "the detector's cells differ (cell_dark_count_rates); the mean response is solved for cells \
         that are alike: give dark_count_rate, or simulate it photon by photon"
    )]
    UnlikeCells,
    /// Cells whose hits are added up fire one another.
    #[error(
        "the detector's cells fire one another (cell_crosstalk); the mean response is solved for cells \
         that do not: simulate it photon by photon"
    )]
    CrosstalkBetweenCells,
    /// There are no counts with such moments.
    #[error(
        "the counts' means or covariances are no finite numbers below 2^53; the tiers events and \
         sampled count photon by photon"
    )]
    NotDrawn,
    /// A rate is not a number of zero or more, or a delay is not a number.
    #[error("the strength or the delay of the light at the detector is not a finite number")]
    NotFinite,
    /// Light of codes with different periods repeats too late.
    #[error(
        "the codes at the detector repeat together after {chips} chips; \
         the mean response is solved for at most {limit}"
    )]
    PeriodTooLong {
        /// Common period of the codes.
        chips: u64,
        /// The longest period that is solved.
        limit: u64,
    },
    /// The dead time is shorter than the finest step of integration.
    #[error(
        "the dead time is {dead_time_ps} ps; the mean response needs at least {least_ps} ps \
         (or none, without afterpulsing)"
    )]
    DeadTimeTooShort {
        /// The scene's dead time.
        dead_time_ps: f64,
        /// The shortest that is solved.
        least_ps: f64,
    },
    /// A detector that fires like a clock, again and again at once.
    #[error(
        "the brightest light fires a ready detector at {rate_cps:.3e} cps; with this dead time and \
         chip period the mean response is solved up to {limit_cps:.3e} cps: take less light, or \
         simulate it photon by photon"
    )]
    TooBright {
        /// Primary rate with every path's chip on.
        rate_cps: f64,
        /// The largest that is solved.
        limit_cps: f64,
    },
    /// Jitter reaches over more chips than there are weights for.
    #[error(
        "the jitter is {jitter_chips:.3e} chips; the mean response takes up to {limit} chips: \
         simulate it photon by photon"
    )]
    JitterTooWide {
        /// Its standard deviation.
        jitter_chips: f64,
        /// The largest that is solved.
        limit: u32,
    },
    /// It would take too long to forget how the detector started.
    #[error(
        "the detector remembers its start for {chips:.3e} chips; the mean response is solved up to \
         {limit} chips: take less light beside so long a dead time, a shorter afterpulsing time \
         constant, or simulate it photon by photon"
    )]
    MemoryTooLong {
        /// How long it remembers.
        chips: f64,
        /// The longest that is solved.
        limit: u64,
    },
    /// Afterpulses come faster than the finest step of integration follows.
    #[error(
        "the afterpulsing time constant is {time_constant_ps} ps; \
         the mean response needs at least {least_ps} ps"
    )]
    TimeConstantTooShort {
        /// The scene's time constant.
        time_constant_ps: f64,
        /// The shortest that is solved.
        least_ps: f64,
    },
    /// More afterpulses are pending at a time than there are states for.
    #[error(
        "more than {limit} afterpulses are pending at a time; the mean response needs weaker \
         afterpulsing, or a shorter time constant beside the dead time"
    )]
    TooManyAfterpulses {
        /// Most that are told apart.
        limit: usize,
    },
    /// What is asked for would take too long.
    #[error(
        "this would take about {seconds:.1} s of solving; it is worked out up to {limit_s:.2} s \
         for each of the scene's detectors: simulate it photon by photon, or take fewer paths, \
         less jitter, a shorter dead time or afterpulsing time constant, a shorter code"
    )]
    TooMuchWork {
        /// How long, on one core.
        seconds: f64,
        /// The longest that is worked out.
        limit_s: f64,
    },
    /// What is asked for would take too much memory.
    #[error(
        "this would take {gigabytes:.1} GB of memory; it is worked out up to {limit_gigabytes:.1} \
         GB: simulate it photon by photon, or take fewer paths, a shorter dead time, a shorter code"
    )]
    TooMuchMemory {
        /// How much.
        gigabytes: f64,
        /// The most that is taken.
        limit_gigabytes: f64,
    },
    /// The counter's edge delays differ by a chip or more.
    #[error(
        "the counter's edges lie up to {apart_ps} ps apart (rising against falling delay, and \
         transition); the mean response needs less than the chip period of {chip_period_ps} ps"
    )]
    EdgesTooFarApart {
        /// Their distance.
        apart_ps: f64,
        /// The chip period.
        chip_period_ps: f64,
    },
}

/// Whether a detector's light has the same delays throughout a scan.
pub(super) fn check_stillness(model: &DetectorModel) -> Result<(), MeanResponseError> {
    let (moved_chips, limit_chips) = model.movement_in_scan();
    let [moved_ps, limit_ps] = [moved_chips, limit_chips].map(|chips| model.timing.clock.ps(chips));
    if moved_ps > limit_ps { Err(MeanResponseError::Moving { moved_ps, limit_ps }) } else { Ok(()) }
}

/// Whether a detector is one whose mean response is solved, whatever its light.
pub(super) fn check(model: &DetectorModel) -> Result<(), MeanResponseError> {
    let ps = |chips: f64| model.timing.clock.ps(chips);
    if model.is_paralyzable && model.afterpulsing.is_some() {
        return Err(MeanResponseError::AfterpulsesProlong);
    }
    if let Some(pixel) = &model.pixel {
        match model.added_cells() {
            1 => return Err(MeanResponseError::Cells),
            _ if !pixel.is_even() => return Err(MeanResponseError::UnlikeCells),
            _ if pixel.crosstalk.is_some() => return Err(MeanResponseError::CrosstalkBetweenCells),
            _ => {}
        }
    }
    if let Some(afterpulsing) = model.afterpulsing
        && afterpulsing.time_constant_chips < 2.0 * FINEST_CELL_CHIPS
    {
        return Err(MeanResponseError::TimeConstantTooShort {
            time_constant_ps: ps(afterpulsing.time_constant_chips),
            least_ps: ps(2.0 * FINEST_CELL_CHIPS),
        });
    }
    let tail_chips = model.tail.as_ref().map_or(0.0, Tail::longest_chips);
    let jitter_chips = model.jitter_chips.unwrap_or(0.0).max(tail_chips / 6.0);
    if jitter_chips > f64::from(LARGEST_JITTER_CHIPS) {
        return Err(MeanResponseError::JitterTooWide { jitter_chips, limit: LARGEST_JITTER_CHIPS });
    }
    let dead_time_needed = model.dead_time_chips > 0.0 || model.afterpulsing.is_some();
    if dead_time_needed && model.dead_time_chips < FINEST_CELL_CHIPS {
        return Err(MeanResponseError::DeadTimeTooShort {
            dead_time_ps: ps(model.dead_time_chips),
            least_ps: ps(FINEST_CELL_CHIPS),
        });
    }
    Ok(())
}
