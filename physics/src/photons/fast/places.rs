//! Where in time, and where in a code, each lane is.
//!
//! A place is a chip, and ticks into it. Chips are counted by whole numbers, so that time
//! never drifts, and a tick is the same share of a chip whatever a code's length.

use super::arithmetic::{Integers, LANES, LaneWords, wrap};

/// A chip has 2^19 ticks: one is 15 fs of 8 ns.
pub const CHIP_BITS: u32 = 19;
/// Ticks of a chip.
pub const CHIP_TICKS: u32 = 1 << CHIP_BITS;
/// The bits of ticks that are the place inside a chip.
pub const IN_CHIP: u32 = CHIP_TICKS - 1;

/// No wait and dead time together are as long: 2^30 ticks, less a chip.
pub const LONGEST_CHIPS: u32 = (1 << (30 - CHIP_BITS)) - 1;
/// Codes are repeated to at least this many chips, so that no lane goes on by more than a
/// period at a time.
const LEAST_PERIOD_CHIPS: usize = LONGEST_CHIPS as usize;
/// Chips of the longest code that there are tables for: 8 MB each.
pub const MOST_CODE_CHIPS: usize = 1 << 21;

/// The nearest number of ticks.
pub fn round_ticks(chips: f64) -> i64 {
    ticks(chips).round() as i64
}

/// Ticks of a duration, not rounded.
pub fn ticks(chips: f64) -> f64 {
    chips * f64::from(CHIP_TICKS)
}

/// Ticks of whole chips.
pub fn ticks_of_chips(chips: i64) -> i64 {
    chips << CHIP_BITS
}

/// A code, repeated until it is no shorter than a wait can be.
pub fn repeated(code: &[u8]) -> Vec<u8> {
    let times = LEAST_PERIOD_CHIPS.div_ceil(code.len());
    code.repeat(times)
}

/// Times of all lanes, before (negative) or after a border of each.
#[derive(Debug, Clone)]
pub struct LaneTimes {
    /// Whole chips, as signed numbers.
    pub chips: LaneWords,
    /// Ticks into the chip.
    pub fractions: LaneWords,
}

impl LaneTimes {
    /// Far before every border.
    pub fn new() -> LaneTimes {
        LaneTimes { chips: LaneWords::all(i32::MIN as u32), fractions: LaneWords::all(0) }
    }

    /// Puts a lane's clock to some ticks, less than 2^31 chips.
    pub fn set(&mut self, lane: usize, ticks: i64) {
        self.chips[lane] = (ticks >> CHIP_BITS) as i32 as u32;
        self.fractions[lane] = ticks as u32 & IN_CHIP;
    }

    /// A lane's time in ticks.
    pub fn ticks(&self, lane: usize) -> i64 {
        ticks_of_chips(i64::from(self.chips[lane] as i32)) + i64::from(self.fractions[lane])
    }

    /// Puts a lane far before its border.
    pub fn park(&mut self, lane: usize) {
        self.chips[lane] = i32::MIN as u32;
    }

    /// Whether a lane has come to its border.
    pub fn is_at_border(&self, lane: usize) -> bool {
        self.chips[lane] as i32 >= 0
    }

    /// Whether any lane has come to its border.
    #[inline(always)]
    pub fn any_at_border(&self) -> bool {
        self.chips.iter().fold(u32::MAX, |all, chips| all & chips) >> 31 == 0
    }

    /// Goes on.
    #[inline(always)]
    pub fn advance(&mut self, elapsed: &LaneWords) {
        for lane in 0..LANES {
            let end = self.fractions[lane].wrapping_add(elapsed[lane]);
            self.fractions[lane] = end & IN_CHIP;
            self.chips[lane] = self.chips[lane].wrapping_add(end >> CHIP_BITS);
        }
    }
}

/// Places of all lanes in a code.
#[derive(Debug, Clone)]
pub struct CodePlaces {
    period_chips: u32,
    /// Below the period.
    pub chips: LaneWords,
    /// Ticks into the chip.
    pub fractions: LaneWords,
}

impl CodePlaces {
    /// In a code of some chips, at least [`LONGEST_CHIPS`].
    pub fn new(period_chips: u32) -> CodePlaces {
        CodePlaces { period_chips, chips: LaneWords::all(0), fractions: LaneWords::all(0) }
    }

    /// Puts a lane to some ticks after the code's start, modulo its period.
    pub fn set(&mut self, lane: usize, ticks: i64) {
        let chips = (ticks >> CHIP_BITS).rem_euclid(i64::from(self.period_chips));
        self.chips[lane] = chips as u32;
        self.fractions[lane] = ticks as u32 & IN_CHIP;
    }

    /// Goes on, by less than [`LONGEST_CHIPS`].
    #[inline(always)]
    pub fn advance(&mut self, elapsed: &LaneWords) {
        // Read anew in each lane, after what is stored there, it would keep the compiler from vectors.
        let period_chips = self.period_chips;
        for lane in 0..LANES {
            let end = self.fractions[lane].wrapping_add(elapsed[lane]);
            self.fractions[lane] = end & IN_CHIP;
            let chip = self.chips[lane].wrapping_add(end >> CHIP_BITS);
            self.chips[lane] = wrap(chip, period_chips);
        }
    }

    /// Places later or earlier by less than half of [`LONGEST_CHIPS`].
    #[inline(always)]
    pub fn shifted(&self, shifts: &Integers) -> CodePlaces {
        let mut shifted = CodePlaces::new(self.period_chips);
        for lane in 0..LANES {
            let end = (self.fractions[lane] as i32).wrapping_add(shifts[lane]);
            shifted.fractions[lane] = end as u32 & IN_CHIP;
            let chip = self.chips[lane].wrapping_add((end >> CHIP_BITS) as u32);
            // From less than half a period before it to more than half behind it.
            let chip = chip.wrapping_add(self.period_chips);
            shifted.chips[lane] = wrap(wrap(chip, self.period_chips), self.period_chips);
        }
        shifted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_go_on_in_whole_chips_and_come_round() {
        let (mut clock, mut places) = (LaneTimes::new(), CodePlaces::new(3000));
        let start = -ticks_of_chips(4500) - 7;
        clock.set(5, start);
        places.set(5, start);
        let mut elapsed = LaneWords::all(0);
        let mut time = start;
        for wait in [0, 7, 8, 1 << 19, (1 << 30) - 1, 123_456_789, 1_000_000_000] {
            elapsed[5] = wait;
            clock.advance(&elapsed);
            places.advance(&elapsed);
            time += i64::from(wait);
            assert_eq!(clock.ticks(5), time);
            let place = i64::from(places.chips[5]) << CHIP_BITS | i64::from(places.fractions[5]);
            assert_eq!(place, time.rem_euclid(3000 << CHIP_BITS));
            for shift in [0, 5, -5, 1 << 19, -(1 << 28), 123_456_789, -536_000_000] {
                let mut shifts = Integers::all(0);
                shifts[5] = shift;
                let shifted = places.shifted(&shifts);
                let place = ticks_of_chips(i64::from(shifted.chips[5]));
                let place = place + i64::from(shifted.fractions[5]);
                assert_eq!(place, (time + i64::from(shift)).rem_euclid(3000 << CHIP_BITS));
            }
            assert_eq!(clock.is_at_border(5), time >= 0);
            assert_eq!(clock.any_at_border(), time >= 0);
        }
    }

    #[test]
    fn short_codes_are_repeated_as_a_whole() {
        for length in [1, 2, 31, 2047, 2048, 5000] {
            let chips = repeated(&vec![1; length]).len();
            assert!(chips.is_multiple_of(length) && chips >= LONGEST_CHIPS as usize);
            assert!(chips < LONGEST_CHIPS as usize + length || chips == length);
        }
    }
}
