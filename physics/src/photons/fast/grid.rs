//! Time in whole ticks.

use super::arithmetic::{CHIP_TABLE, LANES, Words};

/// Ticks of a power of two per chip, and the period after which everything that
/// a lane looks up repeats.
///
/// Phases are whole numbers of ticks within the period, beside a count of
/// periods, so that time never drifts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// A chip has 2^chip_bits ticks.
    pub chip_bits: u32,
    /// Chips in the period: a multiple of the period of every code.
    pub period_chips: u32,
    /// Ticks in the period, at most 2^30, so that two periods fit a word.
    pub period_ticks: u32,
}

/// Codes are repeated to at least this many chips: a wait is cut to a period,
/// and a cut costs an iteration.
const LEAST_PERIOD_CHIPS: u64 = 1024;
/// Period of the codes, together, that a grid can have.
pub const LONGEST_PERIOD_CHIPS: u64 = CHIP_TABLE as u64;
/// Finer ticks gain nothing: 2^-20 of 8 ns is 8 fs.
const MOST_CHIP_BITS: u32 = 20;

impl Grid {
    /// The finest grid for codes that repeat together after `chips` (at least 1)
    /// chips; `None` if that is longer than [`LONGEST_PERIOD_CHIPS`].
    pub fn new(chips: u64) -> Option<Grid> {
        let period_chips = chips * LEAST_PERIOD_CHIPS.div_ceil(chips);
        if period_chips > LONGEST_PERIOD_CHIPS {
            return None;
        }
        let period_chips = period_chips as u32;
        let chip_bits = ((1 << 30) / period_chips).ilog2().min(MOST_CHIP_BITS);
        Some(Grid { chip_bits, period_chips, period_ticks: period_chips << chip_bits })
    }

    /// Ticks per chip.
    pub fn chip_ticks(&self) -> u32 {
        1 << self.chip_bits
    }

    /// Ticks of a number of chips within the period.
    pub fn ticks_of_chips(&self, chips: u32) -> u32 {
        chips << self.chip_bits
    }

    /// The bits of a phase that are its offset inside a chip.
    #[inline(always)]
    pub fn fraction_mask(&self) -> u32 {
        self.chip_ticks() - 1
    }

    /// The chips that phases lie in.
    #[inline(always)]
    pub fn chips(&self, phases: &Words) -> Words {
        let mut chips = Words::all(0);
        for lane in 0..LANES {
            chips[lane] = phases[lane].wrapping_shr(self.chip_bits);
        }
        chips
    }

    /// The nearest number of ticks.
    pub fn round(&self, chips: f64) -> i64 {
        self.ticks(chips).round() as i64
    }

    /// Ticks of a duration, not rounded.
    pub fn ticks(&self, chips: f64) -> f64 {
        chips * f64::from(self.chip_ticks())
    }

    /// Phase of a time.
    pub fn phase(&self, ticks: i64) -> u32 {
        ticks.rem_euclid(i64::from(self.period_ticks)) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_periods_and_a_chip_index_always_fit() {
        for chips in [1, 2, 7, 1000, 1023, 2047, 4094, 16_376, 32_768] {
            let grid = Grid::new(chips).expect("it fits");
            assert_eq!(u64::from(grid.period_chips) % chips, 0);
            assert!(grid.period_chips >= 1024 && grid.period_ticks <= 1 << 30);
            assert!(grid.period_ticks >> grid.chip_bits <= 1 << 15);
        }
        assert_eq!(Grid::new(2047).map(|grid| grid.chip_bits), Some(19));
        assert_eq!(Grid::new(32_769), None);
    }
}
