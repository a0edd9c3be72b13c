//! Background: off-light, background and dark counts, one Poisson process.

use super::arithmetic::{LANES, LaneWords, exponential, to_ticks};
use super::streams::LaneStreams;

/// The background of all lanes.
#[derive(Debug, Clone)]
pub struct ConstantLight {
    pub streams: LaneStreams,
    mean_wait_ticks: f32,
}

impl ConstantLight {
    pub fn new(mean_wait_ticks: f64) -> ConstantLight {
        ConstantLight { streams: LaneStreams::new(), mean_wait_ticks: mean_wait_ticks as f32 }
    }

    /// Shortens the waits to the next arrival.
    #[inline(always)]
    pub fn shorten(&mut self, waits: &mut LaneWords) {
        let random = self.streams.next();
        for lane in 0..LANES {
            let wait = exponential(random[lane]) * self.mean_wait_ticks;
            waits[lane] = waits[lane].min(to_ticks(wait));
        }
    }
}
