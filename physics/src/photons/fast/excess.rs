//! The excess on-light of one path, by a change of time.

use super::arithmetic::{ChipTable, LANES, Words, exponential, to_ticks, wrap};
use super::grid::Grid;
use super::streams::LaneStreams;

/// Where a code's on-chips are, within the period of the grid.
///
/// On-time counts only ticks within on-chips: there the arrivals are a
/// homogeneous Poisson process, so the wait is one exponential, and the tables
/// lead from time to on-time and back. Nothing is drawn in vain.
#[derive(Debug, Clone)]
pub struct OnTime {
    grid: Grid,
    /// By chip: the on-time before it in the upper bits; the lower bits (those
    /// of an offset inside a chip) all ones if the chip is on, else zeros.
    before: ChipTable,
    /// By number of on-chip: its first tick.
    starts: ChipTable,
    /// On-time in a period.
    ticks: u32,
}

impl OnTime {
    /// Tables of a code with at least one on-chip, repeated to fill the grid.
    pub fn new(grid: Grid, code: &[u8]) -> OnTime {
        let chips = || code.iter().cycle().take(grid.period_chips as usize);
        let mut on_chips = 0;
        let before = chips().map(|&chip| {
            let entry = grid.ticks_of_chips(on_chips) | (grid.fraction_mask() * u32::from(chip));
            on_chips += u32::from(chip);
            entry
        });
        let before = ChipTable::new(before);
        let numbered = chips().zip(0..).filter(|&(&chip, _)| chip == 1);
        OnTime {
            grid,
            before,
            starts: ChipTable::new(numbered.map(|(_, number)| grid.ticks_of_chips(number))),
            ticks: grid.ticks_of_chips(on_chips),
        }
    }

    /// Ticks from `phases` (below one period) until `waits` ticks of on-time have
    /// passed; one period where that takes a period or longer.
    ///
    /// With less than a period's on-time to pass, the end is found within the
    /// period: an arrival can never come out after the last on-chip.
    #[inline(always)]
    fn until(&self, phases: &Words, waits: &Words) -> Words {
        let fraction = self.grid.fraction_mask();
        let before = self.before.at(&self.grid.chips(phases));
        let mut on_times = Words::all(0);
        let last = self.ticks - 1;
        for lane in 0..LANES {
            let passed = before[lane] & (phases[lane] | !fraction);
            let within = waits[lane].min(last);
            on_times[lane] = wrap(passed.wrapping_add(within), self.ticks);
        }
        let starts = self.starts.at(&self.grid.chips(&on_times));
        let mut elapsed = Words::all(0);
        for lane in 0..LANES {
            let end = starts[lane] | (on_times[lane] & fraction);
            let short = end.wrapping_sub(phases[lane]);
            // The end lies in this period or in the next one.
            let short = short.min(short.wrapping_add(self.grid.period_ticks));
            elapsed[lane] = if waits[lane] < self.ticks { short } else { self.grid.period_ticks };
        }
        elapsed
    }
}

/// The excess light of one path in all lanes.
#[derive(Debug, Clone)]
pub struct ExcessLight<'t> {
    on_time: &'t OnTime,
    pub streams: LaneStreams,
    /// Phase of the arriving code where a lane's phase is zero, by lane.
    pub offsets: Words,
    mean_wait_ticks: f32,
}

impl<'t> ExcessLight<'t> {
    pub fn new(on_time: &'t OnTime, mean_wait_ticks: f64) -> ExcessLight<'t> {
        ExcessLight {
            on_time,
            streams: LaneStreams::new(),
            offsets: Words::all(0),
            mean_wait_ticks: mean_wait_ticks as f32,
        }
    }

    /// Shortens the waits to the next arrival after `phases`.
    #[inline(always)]
    pub fn shorten(&mut self, phases: &Words, waits: &mut Words) {
        let period = self.on_time.grid.period_ticks;
        let mut arriving = Words::all(0);
        for lane in 0..LANES {
            arriving[lane] = wrap(phases[lane].wrapping_add(self.offsets[lane]), period);
        }
        let random = self.streams.next();
        let mut on_waits = Words::all(0);
        for lane in 0..LANES {
            let wait = exponential(random[lane]) * self.mean_wait_ticks;
            on_waits[lane] = to_ticks(wait);
        }
        let elapsed = self.on_time.until(&arriving, &on_waits);
        for lane in 0..LANES {
            waits[lane] = waits[lane].min(elapsed[lane]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the definition: walk tick by tick.
    #[test]
    fn on_time_passes_in_on_chips_only() {
        let code = [0, 1, 1, 0, 1, 0, 0];
        let grid = Grid { chip_bits: 2, period_chips: 7, period_ticks: 28 };
        let on_time = OnTime::new(grid, &code);
        let is_on = |tick: u32| code[(tick / 4 % 7) as usize] == 1;
        for phase in 0..28 {
            for wait in 0..30 {
                let mut elapsed = 0;
                let mut passed = 0;
                // The arrival is inside the on-tick that follows `wait` others.
                while !is_on(phase + elapsed) || passed < wait {
                    passed += u32::from(is_on(phase + elapsed));
                    elapsed += 1;
                }
                let expected = if wait < 12 { elapsed } else { 28 };
                let found = on_time.until(&Words::all(phase), &Words::all(wait));
                assert_eq!(found, Words::all(expected), "{phase} {wait}");
            }
        }
    }
}
