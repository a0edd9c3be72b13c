//! The mean response of a detector to its periodic light, without random
//! numbers: means, variances and covariance of the counts of every phase step.
//!
//! The detector is a Markov chain with memory of one dead time. Ready with m
//! afterpulses pending it has probability p_m(t), and
//!
//! p_m' = -(lambda + m / tau) p_m + sum over j of K\[j\]\[m\] a_j(t - D),
//! a_j = lambda p_j + ((j + 1) / tau) p_(j+1),
//!
//! where lambda(t) is the primary rate, tau the afterpulsing time constant, D
//! the dead time, a_j the rate of avalanches after which j afterpulses stay
//! pending, and K\[j\]\[m\] the probability that m are pending when the dead time
//! ends: Binomial(j, exp(-D / tau)) survivors and a Poisson number of new ones.
//! The mean detection rate is the sum of a_j.
//!
//! It is solved once per light, on cells that end where the light changes
//! ([`grid`]); the correlator's edges then fall where they will, on the
//! cumulative mean, smoothed by the jitter ([`column`]). What of the detections the
//! sampled hardware counts is [`sampling`]'s.
//!
//! ```
//! use std::path::Path;
//!
//! use goldtof::photons::DetectorModel;
//! use goldtof::response::MeanResponse;
//! use goldtof::scene::DetectorIndex;
//! use goldtof::sensor::Sensor;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
//! let counts = MeanResponse::new(&model)?.mean_counts();
//! let peak = (0..counts.len()).max_by(|&a, &b| counts[a].signed.total_cmp(&counts[b].signed));
//! // 3.2 m are 21.3 ns, and a phase step is 1 ns; detector and sampling add their delay.
//! assert!((20..30).contains(&peak.unwrap()));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bins;
mod chain;
mod column;
mod correlator;
mod counts;
mod effort;
mod expected;
mod forward;
mod grid;
mod group_counts;
mod history;
mod integrator;
mod light;
mod moments;
mod pairs;
mod poisson;
mod sampling;
mod scan_moments;
mod tier;
mod variance;

pub use correlator::MeanCount;
pub use counts::CountSampler;
pub(crate) use effort::Effort;
pub use expected::MeanResponse;
pub use light::{Light, LightPath};
pub use moments::{CountMoments, GroupMoments, SecondMoments};
pub(crate) use sampling::{check_merging, merged_share};
pub use tier::CountingTier;

/// Most states of pending afterpulses.
const MAX_STATES: usize = 16;

/// Evaluates an expression with `$m` the number of states to calculate with, for
/// a number of states needed.
macro_rules! with_states {
    ($needed:expr, $m:ident => $body:expr) => {
        match $needed {
            0..=1 => {
                const $m: usize = 1;
                $body
            }
            2..=4 => {
                const $m: usize = 4;
                $body
            }
            5..=8 => {
                const $m: usize = 8;
                $body
            }
            _ => {
                const $m: usize = $crate::response::MAX_STATES;
                $body
            }
        }
    };
}
use with_states;

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
    /// There are no counts with such moments.
    #[error(
        "the counts' means or covariances are no finite numbers below 2^53; the tiers events and \
         sampled count photon by photon"
    )]
    NotDrawn,
    /// A rate is no number from zero on, or a delay none at all.
    #[error("the strength or the delay of the light at the detector is no finite number")]
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
