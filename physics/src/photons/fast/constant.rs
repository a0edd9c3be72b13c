//! Background: off-light, background and dark counts, one Poisson process.

use super::arithmetic::{Floats, LANES, half_lives};
use super::streams::LaneStreams;

/// The background of all lanes.
#[derive(Debug, Clone)]
pub struct ConstantLight {
    pub streams: LaneStreams,
    half_life_ticks: f32,
}

impl ConstantLight {
    pub fn new(mean_wait_ticks: f64) -> ConstantLight {
        let half_life_ticks = (mean_wait_ticks * std::f64::consts::LN_2) as f32;
        ConstantLight { streams: LaneStreams::new(), half_life_ticks }
    }

    /// Shortens the waits, in ticks, to the next arrival.
    #[inline(always)]
    pub fn shorten(&mut self, waits: &mut Floats) {
        let random = self.streams.next();
        for lane in 0..LANES {
            let wait = half_lives(random[lane]) * self.half_life_ticks;
            waits[lane] = if wait < waits[lane] { wait } else { waits[lane] };
        }
    }
}
