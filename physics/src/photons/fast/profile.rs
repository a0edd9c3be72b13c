//! How light with edges follows its code: the share of it that is there, place by place.
//!
//! Candidates come as if the light were full wherever any of it is, and each arrives with the
//! share that there is at its place in the chip, given which of the latest chips are on. A
//! detector has no memory of light that does not arrive, so a thinned process is exact, and
//! costs the same for any number of strands.

use super::arithmetic::{FixedTable, LANES, LaneWords};
use super::places::{CHIP_BITS, round_ticks};
use super::sign::threshold_of;
use crate::photons::PulseShape;
use crate::photons::shape::Strand;

/// Cells of a chip, in each of which the share is a mean: one is 8 ps of 8 ns.
const CELL_BITS: u32 = 10;
const CELLS: usize = 1 << CELL_BITS;
/// Light that reaches farther than so many chips is taken strand by strand.
const MOST_REACH: u32 = 4;

/// Shares of one shape.
#[derive(Debug, Clone)]
pub struct Profile {
    /// By pattern (bit j: the chip j before is on) and cell: of 2^31 candidates so many and
    /// one more arrive.
    thresholds: FixedTable<{ CELLS << (MOST_REACH + 1) }>,
    /// Chips that light reaches into the dark.
    pub reach: u32,
    /// The delay of its earliest light.
    pub first_chips: f64,
}

impl Profile {
    /// `None` where the light reaches too far.
    pub fn new(shape: &PulseShape) -> Option<Profile> {
        let delays = || shape.strands.iter().map(|strand| strand.delay_chips);
        let gates = shape.strands.iter().filter_map(|strand| strand.gate);
        let all = || delays().chain(gates.clone().map(|gate| gate.delay_chips));
        let first_chips = all().fold(f64::INFINITY, f64::min);
        let reach = all().fold(0.0, |last: f64, delay| last.max(delay - first_chips)).ceil();
        if reach > f64::from(MOST_REACH) {
            return None;
        }
        let reach = reach as u32;
        let mut shares = vec![0.0; CELLS << (reach + 1)];
        for strand in &shape.strands {
            add(strand, first_chips, &mut shares);
        }
        let thresholds = shares.iter().map(|&share| threshold_of(share) as u32);
        Some(Profile { thresholds: FixedTable::new(thresholds), reach, first_chips })
    }

    /// 1 where a candidate arrives, else 0.
    #[inline(always)]
    pub fn arrive(
        &self,
        patterns: &LaneWords,
        in_chip: &LaneWords,
        random: &LaneWords,
    ) -> LaneWords {
        let mut places = LaneWords::all(0);
        for lane in 0..LANES {
            places[lane] = patterns[lane] << CELL_BITS | in_chip[lane] >> (CHIP_BITS - CELL_BITS);
        }
        let thresholds = self.thresholds.at(&places);
        let mut arrive = LaneWords::all(0);
        for lane in 0..LANES {
            let is_below = (random[lane] >> 1) as i32 <= thresholds[lane] as i32;
            arrive[lane] = u32::from(is_below);
        }
        arrive
    }
}

/// Adds a strand's share of each pattern's cells.
fn add(strand: &Strand, first_chips: f64, shares: &mut [f64]) {
    // To the tick, as all times of the lanes.
    let late = |chips: f64| round_ticks(chips - first_chips) as f64 / f64::from(1 << CHIP_BITS);
    let delay = late(strand.delay_chips);
    let gate = strand.gate.map(|gate| (late(gate.delay_chips), gate.open_at));
    // Which chip is on `delay` later: so many before, at a place in a chip.
    let back = |place: f64, delay: f64| -(place - delay).floor() as usize;
    let within = |delay: f64| delay - delay.floor();
    for cell in 0..CELLS {
        let [from, to] = [cell, cell + 1].map(|cell| cell as f64 / CELLS as f64);
        let mut cuts = [from, within(delay), gate.map_or(from, |gate| within(gate.0)), to];
        cuts.iter_mut().for_each(|cut| *cut = cut.clamp(from, to));
        cuts.sort_by(f64::total_cmp);
        for part in cuts.windows(2).filter(|part| part[0] < part[1]) {
            let middle = 0.5 * (part[0] + part[1]);
            let share = strand.share * (part[1] - part[0]) * CELLS as f64;
            let on = back(middle, delay);
            let gate = gate.map(|(delay, open_at)| (back(middle, delay), usize::from(open_at)));
            for (pattern, cells) in shares.chunks_exact_mut(CELLS).enumerate() {
                let chip = |back: usize| pattern >> back & 1;
                if chip(on) == 1 && gate.is_none_or(|(back, open_at)| chip(back) == open_at) {
                    cells[cell] += share;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Clock;
    use crate::scene::LaserResponse;

    /// A straight edge, up from 0 to 1 within 1000 ps and down within 3000 ps: at each place
    /// the light is between that of its eighths.
    #[test]
    fn shares_follow_straight_edges() {
        let clock = Clock { chip_period_ps: 8000.0, samples_per_chip: 8 };
        let response = LaserResponse::Edges { rise_time_ps: 800.0, fall_time_ps: 2400.0 };
        let profile = Profile::new(&PulseShape::new(&response, clock)).expect("short edges");
        assert_eq!(profile.reach, 1);
        for cell in 0..CELLS as u32 {
            let time_ps =
                (f64::from(cell) + 0.5) / CELLS as f64 * 8000.0 + profile.first_chips * 8000.0;
            let up = (0.5 + time_ps / 1000.0).clamp(0.0, 1.0);
            let down = 1.0 - (0.5 + time_ps / 3000.0).clamp(0.0, 1.0);
            for (pattern, expected) in [(0, 0.0), (1, up), (2, down), (3, 1.0)] {
                let place = LaneWords::all(cell << (CHIP_BITS - CELL_BITS));
                // In each lane another draw.
                let shares = (0..16).map(|part| {
                    let mut random = LaneWords::all(0);
                    for lane in 0..LANES {
                        random[lane] = ((part * LANES + lane) << 22 | 1 << 21) as u32;
                    }
                    let arrive = profile.arrive(&LaneWords::all(pattern), &place, &random);
                    (0..LANES).map(|lane| arrive[lane]).sum::<u32>()
                });
                let share = f64::from(shares.sum::<u32>()) / (16 * LANES) as f64;
                assert!((share - expected).abs() < 0.07, "{cell} {pattern}: {share} {expected}");
            }
        }
    }
}
