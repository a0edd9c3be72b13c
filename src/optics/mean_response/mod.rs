//! The mean response of a detector to its periodic light, without random
//! numbers: expected hits per sample, and the variance of signed counts.
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
//! Jitter is left out: it is symmetric and smooths the counts over its standard
//! deviation, which matters only where that is not small against T_s. Two
//! pulses that merge into one rising edge count twice here.

mod cells;
mod chain;
mod expected;
mod forward;
mod grid;
mod integrator;
mod variance;

pub use expected::MeanResponse;

/// Why there is no mean response for a scene.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum MeanResponseError {
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
}
