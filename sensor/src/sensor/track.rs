//! The hardware that follows a target, as seen from outside.

use crate::scan::Timing;

use crate::scene::Hardware;

/// Bits of a position behind the phase step, as a host reads it: at Table I's 1 ns a step, 0.6 mm.
pub const FRACTION_BITS: u32 = 8;
/// Bits below these, which keep a small gain from rounding its steps.
pub const HIDDEN_BITS: u32 = 7;
/// Bits of the number of halvings that make a share.
pub const SHARE_BITS: u32 = 3;
/// Bits of the number of windows.
pub const PATIENCE_BITS: u32 = 4;
/// The largest patience.
pub const MOST_PATIENCE: u32 = (1 << PATIENCE_BITS) - 1;
/// Halvings of the share by which the light that is expected of a window becomes that of the last one.
pub const LIGHT_HALVINGS: u32 = 4;
/// Clocks from where a scan's peak shows to where the first window begins: a decision's last stages.
pub const CLOCKS_FROM_PEAK: u32 = 17;

/// A window of phase steps that follows the peak of its own counts: sizes and timing.
///
/// A scan finds the peak, and windows of two chips follow it, each a scan of its own. What the counts of a window's
/// later half have more than those of its earlier one says where the peak is; the reference model has the rule.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackPlan {
    /// log2 S, samples per chip.
    pub sample_bits: u32,
    /// Bits of a phase step.
    pub step_bits: u32,
    /// Phase steps of the code period.
    pub period_steps: u64,
    /// Bits of a count.
    pub count_bits: u32,
    /// As the scene has them.
    pub setting: TrackSetting,
}

/// How a target is followed, as a host sets it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TrackSetting {
    /// One is.
    pub is_on: bool,
    /// Halvings of the distance from the peak by which a window moves.
    pub gain_halvings: u32,
    /// Halvings of the followed light below which a window has lost it.
    pub threshold_halvings: u32,
    /// Windows without it, one after another, after which a scan looks for the target.
    pub patience: u32,
}

impl TrackSetting {
    /// Bits of its word.
    pub const BITS: u32 = 1 + 2 * SHARE_BITS + PATIENCE_BITS;

    /// As a word of the registers has it: on, gain, threshold and patience, from bit 0 on.
    pub fn of_word(word: u32) -> TrackSetting {
        let field = |first: u32, bits: u32| word >> first & ((1 << bits) - 1);
        TrackSetting {
            is_on: field(0, 1) == 1,
            gain_halvings: field(1, SHARE_BITS),
            threshold_halvings: field(1 + SHARE_BITS, SHARE_BITS),
            patience: field(1 + 2 * SHARE_BITS, PATIENCE_BITS),
        }
    }

    /// As that word.
    pub fn word(self) -> u32 {
        let numbers = self.gain_halvings
            | self.threshold_halvings << SHARE_BITS
            | self.patience << (2 * SHARE_BITS);
        u32::from(self.is_on) | numbers << 1
    }
}

impl TrackPlan {
    /// For a scene's hardware with counts of so many bits, if it follows a target.
    pub fn of(hardware: &Hardware, timing: &Timing, count_bits: u32) -> Option<TrackPlan> {
        let chips = timing.code_chips();
        let sample_bits = timing.clock.samples_per_chip.trailing_zeros();
        hardware.track.then(|| TrackPlan {
            sample_bits,
            step_bits: u64::BITS - (chips - 1).leading_zeros() + sample_bits,
            period_steps: chips << sample_bits,
            count_bits,
            setting: TrackSetting {
                is_on: false,
                gain_halvings: hardware.track_gain.halvings(),
                threshold_halvings: hardware.track_threshold.halvings(),
                patience: hardware.track_patience,
            },
        })
    }

    /// Phase steps of a window: two chips, which is the width of a code's peak.
    pub fn window_steps(&self) -> u64 {
        2 << self.sample_bits
    }

    /// Those of each of its halves.
    pub fn half_steps(&self) -> u64 {
        1 << self.sample_bits
    }

    /// Bits of the sum of a window's counts.
    pub fn sum_bits(&self) -> u32 {
        self.count_bits + self.sample_bits + 1
    }

    /// Bits of the distance from a window's middle to the peak, at most half a chip, without its sign.
    pub fn offset_bits(&self) -> u32 {
        FRACTION_BITS + self.sample_bits - 1
    }

    /// Bits of a position as a host reads it: phase step and fraction.
    pub fn position_bits(&self) -> u32 {
        self.step_bits + FRACTION_BITS
    }

    /// Clocks from a window's last count to where the next one begins: a bit of the quotient each, halvings of the way, and
    /// for all that is added up, brought back into the code period, and weighed.
    pub fn decision_clocks(&self) -> u32 {
        self.offset_bits() + (1 << SHARE_BITS) + 24
    }
}
