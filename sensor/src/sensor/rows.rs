//! Counts that are read out by rows: how a phase step is cut.
//!
//! Each detector counts up and down in a narrow counter that is never cleared. At the end of a
//! window all counters are taken over at once into a row of registers, which is shifted to one adder
//! while the next window is counted: what a counter has grown by is added to the detector's count
//! in a memory. So a detector needs the bits of a window and not those of a step, and no place in a
//! queue.

use crate::scene::LEAST_CHIPS_OF_ROWS;

/// Windows of a phase step, and the bits that one needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RowPlan {
    /// Detectors of a row.
    pub detectors: u64,
    /// Windows of a phase step.
    pub windows: u64,
    /// Chips of each of them but the first.
    pub window_chips: u64,
    /// Chips of a step's first window, which takes what a step has beyond whole ones: less than
    /// twice as many.
    pub first_chips: u64,
    /// Bits of a detector's counter: those of the signed count that no stimulus exceeds within a
    /// window.
    pub piece_bits: u32,
}

impl RowPlan {
    /// Clocks from the one at which the counters have a step's last hits until the counts are there,
    /// the first of which is offered in the next: a row of registers, the memory behind it, the
    /// counter's growth, its sum with the count, and the memory of results.
    pub const CLOCKS_OF_COUNTING: u32 = 5;

    /// The windows of a step of `chips` chips with so many hits at most each: as short as the row allows.
    /// A step that is shorter is one window.
    pub fn of(detectors: u64, chips: u64, hits_per_chip: u32) -> RowPlan {
        let window_chips = detectors.max(LEAST_CHIPS_OF_ROWS);
        let windows = (chips / window_chips).max(1);
        let first_chips = chips - (windows - 1) * window_chips;
        RowPlan {
            detectors,
            windows,
            window_chips,
            first_chips,
            piece_bits: signed_bits(u128::from(first_chips) * u128::from(hits_per_chip)),
        }
    }

    /// Chips of the shortest step of at least `chips` chips that whole windows can be left out of a
    /// step for.
    pub fn shortened(&self, chips: u64) -> u64 {
        let whole = self.first_chips + (self.windows - 1) * self.window_chips;
        let left_out = whole.saturating_sub(chips) / self.window_chips;
        whole - left_out.min(self.windows - 1) * self.window_chips
    }

    /// Bits of a detector's number.
    pub fn address_bits(&self) -> u32 {
        (u64::BITS - (self.detectors - 1).leading_zeros()).max(1)
    }
}

/// Bits of a two's complement number that holds -magnitude..=magnitude.
pub(super) fn signed_bits(magnitude: u128) -> u32 {
    129 - magnitude.leading_zeros()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_make_up_a_step() {
        for detectors in [2, 7, 8, 64, 100] {
            for chips in [8, 64, 100, 128, 1000, 13_100] {
                for hits_per_chip in [1, 4, 8, 64] {
                    let plan = RowPlan::of(detectors, chips, hits_per_chip);
                    let whole = (plan.windows - 1) * plan.window_chips;
                    assert_eq!(plan.first_chips + whole, chips);
                    assert!(plan.window_chips >= detectors);
                    assert!(plan.windows == 1 || plan.first_chips >= plan.window_chips);
                    let most = plan.first_chips.max(plan.window_chips.min(chips))
                        * u64::from(hits_per_chip);
                    assert!(most < 1 << (plan.piece_bits - 1), "{plan:?}");
                    assert!(plan.detectors <= 1 << plan.address_bits());
                    let shorter = plan.shortened(chips / 2);
                    assert!(shorter >= (chips / 2).max(plan.first_chips) && shorter <= chips);
                    assert_eq!((chips - shorter) % plan.window_chips, 0);
                }
            }
        }
    }
}
