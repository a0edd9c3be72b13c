//! The hardware's peak detector, as seen from outside.

use crate::scan::Timing;

/// Longest piece of a count that is compared within a clock.
const LONGEST_PIECE: u32 = 9;

/// Counts of a group among which one clock chooses.
const CHOICE: u32 = 8;

/// Running argmax over a scan (eq. 15): sizes and timing.
///
/// The counts of a group stand still until the next group's, and are compared
/// one after another with the largest so far, each in pieces from the lowest
/// bits up, a piece per clock.
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
    /// Clocks from a count's turn to the first comparison: to choose it among
    /// several, or to keep one that was saturated just before.
    pub choosing_clocks: u32,
    /// First phase step of a scan.
    pub first_step: u64,
    /// The largest phase step, if the scan goes on behind it with step 0.
    pub wraps_after: Option<u64>,
    /// Chips that a group of phase steps has to take, so that all its counts
    /// have had their turn before the first of the next group's changes.
    pub least_chips: u64,
    /// Clocks from the one at which a scan's last sample word is on
    /// `i_samples` to the one after which `o_peak_valid` is high.
    pub latency_clocks: u32,
}

/// The counts that a peak detector compares.
pub(super) struct PeakCounts {
    /// Bits of a count.
    pub bits: u32,
    /// Whether they may have been saturated.
    pub saturate: bool,
    /// Clocks from the first bits of a group's counts to the last.
    pub clocks_of_counting: u32,
    /// Clocks from the last sample word to the first count on the stream.
    pub latency_clocks: u32,
}

impl PeakPlan {
    /// The peak detector over such counts.
    pub(super) fn of(timing: &Timing, counts: &PeakCounts) -> PeakPlan {
        let (scan, parallel) = (&timing.scan, timing.parallel);
        let wraps = scan.first_step + scan.steps > scan.steps_per_period;
        let largest =
            if wraps { scan.steps_per_period - 1 } else { scan.first_step + scan.steps - 1 };
        let mut plan = PeakPlan {
            step_bits: (u64::BITS - largest.leading_zeros()).max(1),
            count_bits: counts.bits,
            pieces: counts.bits.div_ceil(LONGEST_PIECE),
            parallel,
            last_steps: timing.grouping().steps_of_last() as u32,
            choosing_clocks: match parallel {
                1 => u32::from(counts.saturate),
                // Whose turn it is, the choice of eight, the choice of those.
                parallel => 2 + u32::from(parallel > CHOICE),
            },
            first_step: scan.first_step,
            wraps_after: wraps.then_some(largest),
            least_chips: 0,
            latency_clocks: 0,
        };
        plan.least_chips =
            u64::from(parallel * plan.clocks_per_count()) + u64::from(counts.clocks_of_counting);
        // Counts are there a clock before the stream shows the first of them.
        plan.latency_clocks = counts.latency_clocks - 1 + plan.clocks_to_peak();
        plan
    }

    /// Clocks from one count's turn to the next one's: to compare its pieces,
    /// to join in what is to be done with it, and to do it.
    pub fn clocks_per_count(&self) -> u32 {
        self.pieces + 2
    }

    /// Clocks from a count's turn until it has been compared.
    pub fn clocks_to_compare(&self) -> u32 {
        self.choosing_clocks + self.pieces
    }

    /// Clocks from the one in which the counts of a scan's last group are there
    /// to the first in which its peak shows.
    pub fn clocks_to_peak(&self) -> u32 {
        let last_turn = (self.last_steps - 1) * self.clocks_per_count();
        last_turn + self.clocks_to_compare() + 3
    }

    /// Counts in each choice of a group's counts, at most eight; those chosen
    /// are chosen from once more.
    pub fn choices(&self) -> Vec<u32> {
        (0..self.parallel)
            .step_by(CHOICE as usize)
            .map(|first| CHOICE.min(self.parallel - first))
            .collect()
    }

    /// Bits of a piece, piece 0 the lowest: all but the top one are equal.
    pub fn piece_bits(&self, piece: u32) -> u32 {
        let bits = self.count_bits.div_ceil(self.pieces);
        bits.min(self.count_bits - piece * bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pieces_make_up_the_count() {
        for count_bits in 2..=64u32 {
            let plan = PeakPlan {
                step_bits: 1,
                count_bits,
                pieces: count_bits.div_ceil(LONGEST_PIECE),
                parallel: 1,
                last_steps: 1,
                choosing_clocks: 0,
                first_step: 0,
                wraps_after: None,
                least_chips: 0,
                latency_clocks: 0,
            };
            let pieces: Vec<u32> = (0..plan.pieces).map(|p| plan.piece_bits(p)).collect();
            assert_eq!(pieces.iter().sum::<u32>(), count_bits);
            let (top, lower) = pieces.split_last().expect("there is a piece");
            assert!((1..=LONGEST_PIECE).contains(top), "{pieces:?}");
            assert!(lower.iter().all(|bits| bits == &pieces[0]), "{pieces:?}");
        }
    }
}
