//! The excess on-light of one path, by a change of time.

use super::arithmetic::{LANES, LONGEST_WAIT, LaneWords, LookUp, half_lives, to_ticks, wrap};
use super::movement::LaneMovement;
use super::places::{CHIP_BITS, CodePlaces, IN_CHIP, LONGEST_CHIPS, repeated};
use super::profile::Profile;
use super::streams::LaneStreams;
use crate::photons::movement::PathMovement;

/// Lower bits of a start: its chip. Those above are the pattern of a profile.
const START_BITS: u32 = 22;

/// Where a code's lit chips are: those that are on and, where the light has edges, those
/// that light of earlier ones reaches into.
///
/// On-time counts only ticks within lit chips: there the candidates are a
/// homogeneous Poisson process, so the wait is one exponential, and the tables
/// lead from time to on-time and back. Nothing is drawn in vain but near edges.
#[derive(Debug, Clone)]
pub struct OnTime {
    pub period_chips: u32,
    /// By chip: twice the number of lit chips before it, and 1 if it is itself lit.
    before: LookUp,
    /// By number of lit chip: its chip, and which of the latest chips are on.
    starts: LookUp,
    lit_chips: u32,
    /// The longest wait in on-time, in ticks, that ends within a period and within a wait.
    last: u32,
}

impl OnTime {
    /// Tables of a code with at least one on-chip, whose light reaches `reach` chips into
    /// the dark.
    pub fn new(code: &[u8], reach: u32) -> OnTime {
        let chips = repeated(code);
        let period = chips.len();
        let pattern = |chip: usize| {
            let bit = |back: usize| u32::from(chips[(chip + period - back % period) % period]);
            (0..=reach as usize).fold(0, |pattern, back| pattern | bit(back) << back)
        };
        let patterns: Vec<u32> = (0..period).map(pattern).collect();
        let mut lit_chips = 0;
        let before = patterns.iter().map(|&pattern| {
            let entry = 2 * lit_chips + u32::from(pattern != 0);
            lit_chips += u32::from(pattern != 0);
            entry
        });
        let before = LookUp::new(before);
        let lit = (0..).zip(&patterns).filter(|&(_, &pattern)| pattern != 0);
        let starts = lit.map(|(chip, &pattern): (u32, _)| {
            // Without edges all lit chips are alike.
            if reach == 0 { chip } else { pattern << START_BITS | chip }
        });
        OnTime {
            period_chips: period as u32,
            before,
            starts: LookUp::new(starts),
            lit_chips,
            last: lit_chips.min(LONGEST_WAIT >> CHIP_BITS) * (1 << CHIP_BITS) - 1,
        }
    }

    /// Ticks from `places` until `waits` ticks of on-time have passed, or longer than any
    /// wait where that takes as long; and where in a chip it ends, with the chip's start.
    ///
    /// With less than a period's on-time to pass, the end is found within the
    /// period: an arrival can never come out after the last lit chip.
    #[inline(always)]
    fn until(&self, places: &CodePlaces, waits: &LaneWords) -> (LaneWords, LaneWords, LaneWords) {
        let before = self.before.at(&places.chips);
        let mut lit = LaneWords::all(0);
        let mut ends = LaneWords::all(0);
        for lane in 0..LANES {
            let if_lit = 0_u32.wrapping_sub(before[lane] & 1) & places.fractions[lane];
            let passed = if_lit.wrapping_add(waits[lane].min(self.last));
            lit[lane] = wrap((before[lane] >> 1).wrapping_add(passed >> CHIP_BITS), self.lit_chips);
            ends[lane] = passed & IN_CHIP;
        }
        let starts = self.starts.at(&lit);
        let mut elapsed = LaneWords::all(0);
        for lane in 0..LANES {
            let chip = starts[lane] & ((1 << START_BITS) - 1);
            let ahead = chip.wrapping_sub(places.chips[lane]);
            // The end lies in this period or in the next one.
            let ahead = ahead.min(ahead.wrapping_add(self.period_chips)).min(LONGEST_CHIPS);
            // In the next one's same chip, earlier in it, it is an endless time away.
            let ticks = (ahead << CHIP_BITS).wrapping_add(ends[lane]);
            let ticks = ticks.wrapping_sub(places.fractions[lane]);
            elapsed[lane] = if waits[lane] <= self.last { ticks } else { LONGEST_WAIT };
        }
        (elapsed, ends, starts)
    }
}

/// The excess light of one path in all lanes.
#[derive(Debug, Clone)]
pub struct LaneExcessLight<'t> {
    on_time: &'t OnTime,
    pub streams: LaneStreams,
    /// Of the arriving code where the detectors get ready.
    pub places: CodePlaces,
    /// Of the wait in on-time.
    half_life_ticks: f32,
    /// What comes of candidates, and who decides; none without edges.
    pub edges: Option<(&'t Profile, LaneStreams)>,
    /// None of a path that keeps its delay.
    pub movement: Option<LaneMovement<'t>>,
}

impl<'t> LaneExcessLight<'t> {
    pub fn new(
        on_time: &'t OnTime,
        profile: Option<&'t Profile>,
        mean_wait_ticks: f64,
        movement: Option<&'t PathMovement>,
    ) -> LaneExcessLight<'t> {
        LaneExcessLight {
            on_time,
            streams: LaneStreams::new(),
            places: CodePlaces::new(on_time.period_chips),
            half_life_ticks: (mean_wait_ticks * std::f64::consts::LN_2) as f32,
            edges: profile.map(|profile| (profile, LaneStreams::new())),
            movement: movement.map(LaneMovement::new),
        }
    }

    /// Goes on, by less than [`LONGEST_CHIPS`].
    #[inline(always)]
    pub fn advance(&mut self, elapsed: &LaneWords) {
        match &mut self.movement {
            None => self.places.advance(elapsed),
            Some(movement) => self.places.advance(&movement.code_time(elapsed)),
        }
    }

    /// Shortens the waits to the next arrival. A candidate that does not arrive cuts the
    /// wait: from there on, another one is drawn.
    #[inline(always)]
    pub fn shorten(&mut self, waits: &mut LaneWords, cuts: &mut LaneWords) {
        let random = self.streams.next();
        let mut on_waits = LaneWords::all(0);
        for lane in 0..LANES {
            on_waits[lane] = to_ticks(half_lives(random[lane]) * self.half_life_ticks);
        }
        let (mut elapsed, ends, starts) = self.on_time.until(&self.places, &on_waits);
        if let Some(movement) = &self.movement {
            movement.arrivals(&mut elapsed);
        }
        match &mut self.edges {
            None => {
                for lane in 0..LANES {
                    waits[lane] = waits[lane].min(elapsed[lane]);
                }
            }
            Some((profile, streams)) => {
                let mut patterns = starts;
                for pattern in patterns.iter_mut() {
                    *pattern >>= START_BITS;
                }
                let arrive = profile.arrive(&patterns, &ends, &streams.next());
                for lane in 0..LANES {
                    let (arrival, cut) = match arrive[lane] {
                        0 => (LONGEST_WAIT, elapsed[lane]),
                        _ => (elapsed[lane], LONGEST_WAIT),
                    };
                    waits[lane] = waits[lane].min(arrival);
                    cuts[lane] = cuts[lane].min(cut);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::places::CHIP_TICKS;
    use super::*;

    /// Against the definition: walk chip by chip.
    #[test]
    fn on_time_passes_in_on_chips_only() {
        let code = [0, 1, 1, 0, 1, 0, 0];
        let on_time = OnTime::new(&code, 0);
        let mut places = CodePlaces::new(on_time.period_chips);
        for quarter in 0..28 {
            let start = quarter * i64::from(CHIP_TICKS) / 4;
            places.set(0, start);
            for wait in (0..6000).step_by(7) {
                let wait = wait * CHIP_TICKS / 4;
                let (mut left, mut time) = (i64::from(wait), start);
                loop {
                    let chip = time >> CHIP_BITS;
                    let end = (chip + 1) << CHIP_BITS;
                    if code[(chip % 7) as usize] == 1 {
                        // The arrival is inside the on-tick that follows `wait` others.
                        if left < end - time {
                            break;
                        }
                        left -= end - time;
                    }
                    time = end;
                }
                let expected = time + left - start;
                let mut waits = LaneWords::all(0);
                waits[0] = wait;
                let found = i64::from(on_time.until(&places, &waits).0[0]);
                let longest = i64::from(LONGEST_CHIPS - 1) << CHIP_BITS;
                if expected < longest {
                    assert_eq!(found, expected, "{quarter} {wait}");
                } else {
                    assert!(found >= longest, "{quarter} {wait}");
                }
            }
        }
    }
}
