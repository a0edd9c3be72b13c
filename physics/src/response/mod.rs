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
//! The mean detection rate is the sum of a_j. With passive recharge each arrival begins the dead
//! time anew, and what is left of the chain is a closed form ([`paralyzable`]).
//!
//! It is solved once per light, on cells that end where the light changes
//! ([`grid`]); the correlator's edges then fall where they will, on the
//! cumulative mean, smoothed by the jitter ([`column`]). What of the detections the
//! sampled hardware counts is [`sampling`]'s.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! #     pub use goldtof_physics::*;
//! # }
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
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

mod avalanches;
mod bins;
mod chain;
mod column;
mod correlator;
mod counts;
mod domain;
mod effort;
mod expected;
mod forward;
mod grid;
mod group_counts;
mod heard;
mod history;
mod integrator;
mod light;
mod long_run;
mod long_scan;
mod moments;
mod pairs;
mod paralyzable;
mod poisson;
mod sampling;
mod scan_moments;
mod several;
mod span;
mod steady;
mod tier;
mod variance;

pub use correlator::{MeanCount, dot};
pub use counts::CountSampler;
pub use domain::MeanResponseError;
pub use effort::Effort;
pub use expected::MeanResponse;
pub use heard::second_order_share;
pub use light::{Light, LightPath};
pub(crate) use long_run::LongRun;
pub use moments::{CountMoments, GroupMoments, SecondMoments, SolvedPairs};
pub use moments::{MOST_CORRELATION, ROUNDING};
pub use sampling::{check_merging, merged_share};
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
