//! The hardware's peak detector, as seen from outside.

use super::contract::Contract;

/// Bits of a count that are compared within a clock.
const PIECE_BITS: u32 = 8;

/// Running argmax over a scan (eq. 15): sizes and timing.
///
/// Counts are compared one after another, each in pieces from its highest bits
/// down, a piece a clock behind the one above it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PeakPlan {
    /// Bits of a phase step k: what the scan's largest one needs.
    pub step_bits: u32,
    /// Bits of a count.
    pub count_bits: u32,
    /// Pieces in which a count is compared.
    pub pieces: u32,
    /// Phase steps at once.
    pub parallel: u32,
    /// Phase steps of a scan's last group.
    pub last_steps: u32,
    /// Counts wait in registers: there are several at once, or they were
    /// clamped just before.
    pub has_queue: bool,
    /// First phase step of a scan.
    pub first_step: u64,
    /// The largest phase step, if the scan goes on behind it with step 0.
    pub wraps_after: Option<u64>,
    /// Clocks from the one at which a scan's last sample word is on
    /// `i_samples` to the one after which `o_peak_valid` is high.
    pub latency_clocks: u32,
}

impl PeakPlan {
    /// The peak detector of a contract that is complete but for it.
    pub(super) fn of(contract: &Contract) -> PeakPlan {
        let scan = &contract.scan;
        let wraps = scan.first_step + scan.steps > scan.steps_per_period;
        let largest = if wraps {
            scan.steps_per_period - 1
        } else {
            scan.first_step + scan.steps - 1
        };
        let pieces = contract.count_bits.div_ceil(PIECE_BITS);
        let has_queue = contract.parallel > 1 || contract.saturates();
        let last_steps = contract.last_group_steps() as u32;
        // Counts are there a clock before the stream shows the first of them.
        let counted = contract.result_latency_clocks - 1;
        let last_in = counted + u32::from(has_queue) + last_steps - 1;
        PeakPlan {
            step_bits: (u64::BITS - largest.leading_zeros()).max(1),
            count_bits: contract.count_bits,
            pieces,
            parallel: contract.parallel,
            last_steps,
            has_queue,
            first_step: scan.first_step,
            wraps_after: wraps.then_some(largest),
            latency_clocks: last_in + pieces + 1,
        }
    }

    /// Bits of a piece, the one with the sign first: all but it are full.
    pub fn piece_bits(&self, piece: u32) -> u32 {
        if piece == 0 {
            self.count_bits - (self.pieces - 1) * PIECE_BITS
        } else {
            PIECE_BITS
        }
    }

    /// Lowest bit of a piece within the count.
    pub fn piece_shift(&self, piece: u32) -> u32 {
        (self.pieces - 1 - piece) * PIECE_BITS
    }

    /// Chips that a group of phase steps has to take, so that its counts have
    /// been compared, and its scan's peak been kept, before the next come, and
    /// so that none changes before its lowest piece has been taken.
    pub fn least_chips(&self, clocks_to_count: u32) -> u32 {
        (self.parallel + self.pieces - 1).max(self.pieces + clocks_to_count - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pieces_make_up_the_count() {
        for count_bits in 2..=64u32 {
            let pieces = count_bits.div_ceil(PIECE_BITS);
            let plan = PeakPlan {
                step_bits: 1,
                count_bits,
                pieces,
                parallel: 1,
                last_steps: 1,
                has_queue: false,
                first_step: 0,
                wraps_after: None,
                latency_clocks: 0,
            };
            let mut above = count_bits;
            for piece in 0..pieces {
                assert!((1..=PIECE_BITS).contains(&plan.piece_bits(piece)));
                assert_eq!(plan.piece_shift(piece) + plan.piece_bits(piece), above);
                above = plan.piece_shift(piece);
            }
            assert_eq!(above, 0);
        }
    }
}
