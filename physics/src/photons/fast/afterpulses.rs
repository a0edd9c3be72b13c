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
    Floats, LANES, LONGEST_WAIT, LaneWords, exp2_of_negative, exponential, minus_ln, to_ticks,
};
use super::streams::LaneStreams;

/// The afterpulses of all lanes.
#[derive(Debug, Clone)]
pub struct Afterpulses {
    pub streams: LaneStreams,
    /// Expected number still to come, by lane.
    pub masses: Floats,
    mean_per_avalanche: f32,
    time_constant_ticks: f32,
    /// log2(e) over the time constant.
    halvings_per_tick: f32,
}

impl Afterpulses {
    pub fn new(mean_per_avalanche: f64, time_constant_ticks: f64) -> Afterpulses {
        Afterpulses {
            streams: LaneStreams::new(),
            masses: Floats::all(0.0),
            mean_per_avalanche: mean_per_avalanche as f32,
            time_constant_ticks: time_constant_ticks as f32,
            halvings_per_tick: (std::f64::consts::LOG2_E / time_constant_ticks) as f32,
        }
    }

    /// Shortens the waits to the next afterpulse.
    #[inline(always)]
    pub fn shorten(&mut self, waits: &mut LaneWords) {
        let random = self.streams.next();
        for lane in 0..LANES {
            let mass = self.masses[lane];
            let passed = exponential(random[lane]);
            let wait = minus_ln(1.0 - passed / mass, 0) * self.time_constant_ticks;
            let wait = if passed < mass { wait } else { LONGEST_WAIT as f32 };
            waits[lane] = waits[lane].min(to_ticks(wait));
        }
    }

    /// Lets the masses decay over `elapsed` ticks, and adds new afterpulses
    /// where the detector has fired (1, otherwise 0).
    #[inline(always)]
    pub fn decay(&mut self, elapsed: &LaneWords, fired: &LaneWords) {
        for lane in 0..LANES {
            let halvings = elapsed[lane] as i32 as f32 * self.halvings_per_tick;
            let new = fired[lane] as i32 as f32 * self.mean_per_avalanche;
            self.masses[lane] = self.masses[lane] * exp2_of_negative(-halvings) + new;
        }
    }
}
