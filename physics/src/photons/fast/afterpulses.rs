//! Afterpulses without a list: a decaying mass.
//!
//! A Poisson number of afterpulses, each with an exponential delay, is a Poisson
//! process whose rate decays exponentially. Those of several avalanches add up,
//! and stay one decaying process: A / tau exp(-t / tau), of which the mass A is
//! all there is to know. What has been due by a time says nothing about what
//! comes after it (the process has independent increments), so whoever fires the
//! detector, the mass just decays; afterpulses due in a dead time are lost with
//! the mass that decays in it; and an avalanche adds its mean number at the end
//! of its dead time, from where their delays count.
//!
//! The wait t to the first afterpulse has A (1 - exp(-t / tau)) = E with E a unit
//! exponential: none comes if E >= A, else t = -tau ln(1 - E / A).

use super::arithmetic::{
    Floats, LANES, LONGEST_WAIT, LaneWords, SLIGHT, exp2_of_negative, exponential, minus_log2,
    slight_exponential,
};
use super::streams::LaneStreams;

/// The afterpulses of all lanes.
#[derive(Debug, Clone)]
pub struct Afterpulses {
    pub streams: LaneStreams,
    /// Expected number still to come, by lane.
    pub masses: Floats,
    mean_per_avalanche: f32,
    half_life_ticks: f32,
    /// Negative, because masses decay.
    half_lives_per_tick: f32,
    /// No mass is greater than [`SLIGHT`].
    are_slight: bool,
}

impl Afterpulses {
    /// Of a detector that is blind for some ticks from each avalanche on.
    pub fn new(
        mean_per_avalanche: f64,
        time_constant_ticks: f64,
        dead_time_ticks: u32,
    ) -> Afterpulses {
        let half_life_ticks = time_constant_ticks * std::f64::consts::LN_2;
        // One avalanche as soon as the other.
        let kept = (-f64::from(dead_time_ticks) / time_constant_ticks).exp();
        Afterpulses {
            streams: LaneStreams::new(),
            masses: Floats::all(0.0),
            mean_per_avalanche: mean_per_avalanche as f32,
            half_life_ticks: half_life_ticks as f32,
            half_lives_per_tick: (-1.0 / half_life_ticks) as f32,
            are_slight: mean_per_avalanche < SLIGHT * (1.0 - kept),
        }
    }

    /// Shortens the waits, in ticks, to the next afterpulse.
    #[inline(always)]
    pub fn shorten(&mut self, waits: &mut Floats) {
        let random = self.streams.next();
        let mut passed = Floats::all(0.0);
        if self.are_slight {
            for lane in 0..LANES {
                passed[lane] = slight_exponential(random[lane]);
            }
        } else {
            for lane in 0..LANES {
                passed[lane] = exponential(random[lane]);
            }
        }
        for lane in 0..LANES {
            let mass = self.masses[lane];
            let wait = minus_log2(1.0 - passed[lane] / mass, 0) * self.half_life_ticks;
            let wait = if passed[lane] < mass { wait } else { LONGEST_WAIT as f32 };
            waits[lane] = if wait < waits[lane] { wait } else { waits[lane] };
        }
    }

    /// Lets the masses decay over `elapsed` ticks, and adds new afterpulses
    /// where the detector has fired (1, otherwise 0).
    #[inline(always)]
    pub fn decay(&mut self, elapsed: &LaneWords, fired: &LaneWords) {
        for lane in 0..LANES {
            let half_lives = elapsed[lane] as i32 as f32 * self.half_lives_per_tick;
            let new = if fired[lane] != 0 { self.mean_per_avalanche } else { 0.0 };
            self.masses[lane] = self.masses[lane] * exp2_of_negative(half_lives) + new;
        }
    }
}
