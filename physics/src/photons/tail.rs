//! The delay that a detection has beside its constant and Gaussian ones.

use rand::RngExt;
use rand_distr::{Distribution, Exp1};

use super::random::StreamRng;
use crate::scan::Clock;
use crate::scene::JitterTail;

/// An exponential delay is cut at so many time constants (probability 10^-13).
pub(crate) const MOST_TIME_CONSTANTS: f64 = 30.0;

/// Distribution of that delay, in chips. It is never negative.
#[derive(Debug, Clone, PartialEq)]
pub enum Tail {
    /// An exponential delay of a share of the detections, none of the others.
    Exponential {
        /// Share of the detections.
        share: f64,
        /// Mean delay of these.
        time_constant_chips: f64,
    },
    /// Delays and their shares.
    Delays(Vec<[f64; 2]>),
}

impl Tail {
    /// `None` where there is no tail.
    pub fn new(tail: &JitterTail, clock: Clock) -> Option<Tail> {
        match tail {
            JitterTail::None => None,
            JitterTail::Exponential { share, time_constant_ps } => Some(Tail::Exponential {
                share: *share,
                time_constant_chips: clock.chips(*time_constant_ps),
            }),
            JitterTail::Measured(curve) => {
                let points = curve.points.iter();
                let points = points.map(|&[time_ps, share]| [clock.chips(time_ps), share]);
                Some(Tail::Delays(points.collect()))
            }
        }
    }

    /// The longest delay.
    pub fn longest_chips(&self) -> f64 {
        match self {
            Tail::Exponential { time_constant_chips, .. } => {
                MOST_TIME_CONSTANTS * time_constant_chips
            }
            Tail::Delays(delays) => delays.last().map_or(0.0, |delay| delay[0]),
        }
    }

    /// A delay.
    #[inline]
    pub fn draw(&self, rng: &mut StreamRng) -> f64 {
        let uniform: f64 = rng.random();
        match self {
            Tail::Exponential { share, time_constant_chips } => {
                if uniform >= *share {
                    return 0.0;
                }
                let exponential: f64 = Exp1.sample(rng);
                time_constant_chips * exponential.min(MOST_TIME_CONSTANTS)
            }
            Tail::Delays(delays) => {
                let mut below = 0.0;
                let found = delays.iter().find(|delay| {
                    below += delay[1];
                    uniform < below
                });
                found.map_or_else(|| self.longest_chips(), |delay| delay[0])
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::*;

    fn shares_beyond(tail: &Tail, limits: [f64; 3]) -> [f64; 3] {
        const DRAWS: u32 = 200_000;
        let mut rng = StreamRng::seed_from_u64(4);
        let delays: Vec<f64> = (0..DRAWS).map(|_| tail.draw(&mut rng)).collect();
        limits.map(|limit| {
            let beyond = delays.iter().filter(|&&delay| delay > limit).count();
            beyond as f64 / f64::from(DRAWS)
        })
    }

    #[test]
    fn a_share_of_the_delays_is_exponential() {
        let tail = Tail::Exponential { share: 0.3, time_constant_chips: 0.05 };
        let found = shares_beyond(&tail, [0.0, 0.05, 0.15]);
        for (found, expected) in found.iter().zip([0.3, 0.3 / 1f64.exp(), 0.3 / 3f64.exp()]) {
            // Five standard errors of 200,000 draws at most.
            assert!((found - expected).abs() < 0.0052, "{found} {expected}");
        }
    }

    #[test]
    fn measured_delays_come_as_often_as_they_were_measured() {
        let tail = Tail::Delays(vec![[0.0, 0.5], [0.1, 0.3], [0.2, 0.2]]);
        let found = shares_beyond(&tail, [0.05, 0.15, 0.25]);
        for (found, expected) in found.iter().zip([0.5, 0.2, 0.0]) {
            assert!((found - expected).abs() < 0.0057, "{found} {expected}");
        }
    }
}
