//! Follows a target with a window of phase steps.
//!
//! | port | |
//! |---|---|
//! | `i_go`, `o_go` | scans are wanted; the next one may begin |
//! | `i_taken_first`, `i_word`, `o_word` | settings on their way to the sequencer, which a window has its own of |
//! | `i_refused` | they do not fit |
//! | `i_count`, `i_counted`, `i_last` | counts of the phase steps |
//! | `i_peak_step`, `i_peak_count`, `i_peak_valid` | what a scan has found |
//! | `o_position`, `o_locked`, `o_lost` | where the target is; it is there; it was lost |
//!
//! A window is a scan of two chips whose first step and number of steps stand in place of the host's while these
//! pass by. A scan that finds a target, and each window, is weighed before the next one begins: some 40 clocks. No two
//! carry chains follow one another within a clock, and none stands behind a choice of many. So the way to the peak, the
//! position and the next window's first step are made one after another by one adder, whose addend, sum and total are
//! registers each. The plan has the clocks, the reference model the rule.

use crate::rtl::front::prelude::*;
use crate::sensor::registers::SCAN_WORDS;
use crate::sensor::track::{
    FRACTION_BITS, HIDDEN_BITS, LIGHT_HALVINGS, PATIENCE_BITS, SHARE_BITS, TrackPlan,
};

/// Bits of a position's fraction.
const POSITION_BITS: usize = (FRACTION_BITS + HIDDEN_BITS) as usize;
/// The bit of a setting's word that turns it on, and the first of each number in it.
const GAIN: usize = 1;
const THRESHOLD: usize = GAIN + SHARE_BITS as usize;
const PATIENCE: usize = THRESHOLD + SHARE_BITS as usize;

#[block(target_tracker)]
/// follows a target with a window of phase steps
///
/// A scan's peak is where the first window is. Of each the later half's counts less the earlier half's, over the sum of
/// all, say how far the peak is from the middle, and the position moves by a share of that. The next window's first step
/// and number of steps take the place of the host's settings. After some windows in a row with less than a share of the
/// expected sum a scan looks for the target again.
///
/// - Window: {plan.window_steps()} phase steps
/// - Latency: {plan.decision_clocks() + 1} clocks from a window's last i_counted to o_go
pub struct TargetTracker {
    plan: TrackPlan,
    /// Words of settings; the last is this block's.
    settings: usize,
    /// Bits of a setting.
    word_bits: usize,
    /// Bits of one that the sequencer takes over.
    scan_word_bits: usize,
    /// Bits of a peak's step, from the scan's first on.
    peak_step_bits: usize,
    #[set(plan.sum_bits() as usize)]
    sum_bits: usize,
    #[set(plan.step_bits as usize)]
    step_bits: usize,
    #[set(plan.sample_bits as usize)]
    sample_bits: usize,
    #[set(plan.offset_bits() as usize)]
    offset_bits: usize,
    /// Bits of a step that may be beyond the code period's ends.
    #[set(step_bits + 3)]
    moved_bits: usize,
    /// The same with a fraction.
    #[set(moved_bits + POSITION_BITS)]
    total_bits: usize,
    /// Stages of a decision.
    #[set(plan.decision_clocks() as usize)]
    stages: usize,
    /// The stage that has the quotient, and the one that has the way.
    #[set(offset_bits + 4)]
    divided: usize,
    #[set(divided + (1 << SHARE_BITS) + 4)]
    halved: usize,
    /// scans are wanted
    #[under("Registers")]
    pub i_go: Input<bool>,
    /// the next one may begin
    pub o_go: Output<bool>,
    /// the first setting is read
    pub i_taken_first: Input<bool>,
    /// the setting that was read a clock ago
    #[width(word_bits)]
    pub i_word: Input<Word>,
    /// the same, or a window's own
    #[width(scan_word_bits)]
    pub o_word: Output<Word>,
    /// settings do not fit
    pub i_refused: Input<bool>,
    /// a scan's chips are counted
    #[under("Counts")]
    pub i_run: Input<bool>,
    /// count of a phase step, signed
    #[width(plan.count_bits)]
    pub i_count: Input<Word>,
    /// it is new
    pub i_counted: Input<bool>,
    /// it is a scan's last
    pub i_last: Input<bool>,
    /// phase step of a scan's peak, from the scan's first on
    #[under("Peak")]
    #[width(peak_step_bits)]
    pub i_peak_step: Input<Word>,
    /// its count, signed
    #[width(plan.count_bits)]
    pub i_peak_count: Input<Word>,
    /// they have just changed
    pub i_peak_valid: Input<bool>,
    /// phase step of the target's peak, and 8 bits of its fraction
    #[under("Target")]
    #[width(plan.position_bits())]
    pub o_position: Output<Word>,
    /// the last window had its light
    pub o_locked: Output<bool>,
    /// it has just been lost
    pub o_lost: Output<bool>,
    /// phase steps of a window
    #[width(scan_word_bits)]
    #[value(u128::from(plan.window_steps()))]
    #[number]
    window_steps: Constant,
    /// phase steps of the code period
    #[width(moved_bits)]
    #[value(u128::from(plan.period_steps))]
    #[number]
    period: Constant,
    /// the same, negative
    #[width(moved_bits)]
    #[value((1 << moved_bits) - u128::from(plan.period_steps))]
    #[number]
    less_period: Constant,
    /// phase steps of half a window
    #[width(moved_bits)]
    #[value(u128::from(plan.half_steps()))]
    #[number]
    half_window: Constant,
    /// half a phase step
    #[width(total_bits)]
    #[value(1 << (POSITION_BITS - 1))]
    #[number]
    half_step: Constant,
    /// the next scan follows a target
    follows: Register<bool>,
    /// the present scan is a window
    window: Register<bool>,
    /// a target is followed, as the present scan's settings say
    on: Register<bool>,
    /// what follows of the present scan is still to come
    waits: Register<bool>,
    /// the scan that is to find a target has begun: peaks are its own
    began: Register<bool>,
    /// it has ended, with a peak
    finds: Local<bool>,
    /// it had a clock ago
    found: Register<bool>,
    /// a setting passes by, one bit for each
    #[width(settings)]
    passes: Register<Word>,
    /// a window's own passes by: number of steps in bit 0, first in bit 1
    #[width(2)]
    own: Register<Word>,
    #[width(SHARE_BITS)]
    gain: Register<Word>,
    #[width(SHARE_BITS)]
    threshold: Register<Word>,
    #[width(PATIENCE_BITS)]
    patience: Register<Word>,
    /// first phase step of a scan
    #[width(step_bits)]
    first: Register<Word>,
    /// counts of the window so far
    #[width(sample_bits + 1)]
    place: Register<Word>,
    /// sum of the window's counts
    #[width(sum_bits)]
    all: Register<Word>,
    /// its later half less its earlier one
    #[width(sum_bits)]
    slope: Register<Word>,
    /// the sum that is expected
    #[width(sum_bits)]
    light: Register<Word>,
    /// stages of a decision, one bit for each
    #[width(stages)]
    stage: Register<Word>,
    /// halvings still to come
    #[width(SHARE_BITS)]
    halvings: Register<Word>,
    /// a share is halved
    halves: Register<bool>,
    /// the least sum with the target's light
    #[width(sum_bits)]
    least: Register<Word>,
    /// the sum less the least
    #[width(sum_bits + 1)]
    spare: Local<Word>,
    /// the sum is not less than the least, nor zero
    is_bright: Register<bool>,
    /// a sixteenth of what the sum has more than was expected
    #[width(sum_bits + 1 - LIGHT_HALVINGS as usize)]
    gained: Register<Word>,
    /// the window has its target's light
    lit: Register<bool>,
    /// the count is one of the earlier half
    early: Local<bool>,
    /// the count, turned if early
    #[width(sum_bits)]
    turned: Local<Word>,
    /// the slope with it; bit 0 carries
    #[width(sum_bits + 1)]
    leaned: Local<Word>,
    /// the slope is negative
    negative: Register<bool>,
    /// what is left of the slope's size
    #[width(sum_bits + 2)]
    rest: Register<Word>,
    /// the rest is not negative
    minus: Local<bool>,
    /// the slope comes in the rest's place
    begins: Register<bool>,
    /// to the rest
    #[width(sum_bits + 2)]
    taken: Local<Word>,
    /// the rest with it; bit 0 carries
    #[width(sum_bits + 3)]
    left: Local<Word>,
    /// the slope over the sum: a whole, and the bits of its share
    #[width(offset_bits + 1)]
    quotient: Register<Word>,
    /// the quotient, or the most
    #[width(offset_bits)]
    size: Local<Word>,
    /// way to the peak, then position, then the next window's first step
    #[width(total_bits)]
    total: Register<Word>,
    /// what is added to it next
    #[width(total_bits)]
    addend: Register<Word>,
    /// and one more
    carry: Register<bool>,
    /// its middle from position's step on
    #[width(total_bits)]
    middle: Local<Word>,
    /// to the peak, turned if negative
    #[width(total_bits)]
    offset: Local<Word>,
    /// position's step to next window's first
    #[width(moved_bits)]
    back: Local<Word>,
    /// the code period, added or taken off
    #[width(moved_bits)]
    turn: Local<Word>,
    /// total and addend; bit 0 carries
    #[width(total_bits + 1)]
    grown: Local<Word>,
    /// total and addend
    #[width(total_bits)]
    sum: Register<Word>,
    /// the sum becomes the total
    takes: Register<bool>,
    /// unless it is negative
    tries: Register<bool>,
    /// something else does
    loads: Register<bool>,
    /// the code period brings the total nearer to it
    turns: Register<bool>,
    /// fraction of the position's step
    #[width(POSITION_BITS)]
    fraction: Register<Word>,
    /// what the windows' middles owe to the positions, and half a step
    #[width(POSITION_BITS + 1)]
    owed: Register<Word>,
    /// steps from the position's to the window's later half
    #[width(2)]
    ahead: Register<Word>,
    /// where the window's later half is
    #[width(POSITION_BITS + 2)]
    placed: Local<Word>,
    /// phase step of the position
    #[width(step_bits)]
    step: Register<Word>,
    /// windows without light, one after another
    #[width(PATIENCE_BITS)]
    missed: Register<Word>,
    /// that was the last of them
    gives_up: Register<bool>,
    /// the next scan has a target
    keeps: Local<bool>,
    /// linters know by the name
    unused: Local<bool>,
    /// the position as it is told
    #[width(plan.position_bits())]
    position: Register<Word>,
    locked: Register<bool>,
    lost: Register<bool>,
}

#[kernel]
impl Logic for TargetTracker {
    fn update(&mut self) {
        self.pass_settings();
        self.sum_counts();
        self.run_stages();
        self.halve();
        self.weigh_light();
        self.divide();
        self.add_up();
        self.place_window();
        self.decide();
        self.tell();
    }

    /// Settings on their way from the registers to the sequencer.
    fn pass_settings(&mut self) {
        let last = self.settings - 1;
        self.passes.next = self.passes.val().shifted_in(self.i_taken_first.val());
        if self.i_taken_first.val() {
            self.window.next = self.follows.val();
        }
        self.own.next = self.passes.val().slice(0, 2) & signed_cast(self.window.val());
        if self.own.val().get_bit(0) {
            self.o_word.next = self.window_steps.val();
        } else if self.own.val().get_bit(1) {
            self.o_word.next = bit_cast(
                self.total.val().slice(POSITION_BITS, self.moved_bits),
                self.scan_word_bits,
            );
        } else {
            self.o_word.next = bit_cast(self.i_word.val(), self.scan_word_bits);
        }
        if self.passes.val().get_bit(SCAN_WORDS - 1) {
            self.first.next = bit_cast(self.i_word.val(), self.step_bits);
        }
        if self.passes.val().get_bit(last) {
            self.on.next = self.i_word.val().get_bit(0);
            self.gain.next = self.i_word.val().slice(GAIN, SHARE_BITS as usize);
            self.threshold.next = self.i_word.val().slice(THRESHOLD, SHARE_BITS as usize);
            self.patience.next = self.i_word.val().slice(PATIENCE, PATIENCE_BITS as usize);
            self.waits.next = self.i_word.val().get_bit(0) | self.window.val();
        }
        if self.i_refused.val() {
            self.waits.next = false;
        }
        self.o_go.next = self.i_go.val() & !self.waits.val();
    }

    /// The slope has one adder, too: what is taken from it is added with all bits turned, and one more, which bit 0 carries.
    fn sum_counts(&mut self) {
        self.early.next = !self.place.val().get_bit(self.sample_bits);
        self.turned.next = bit_cast(signed_cast(self.i_count.val()), self.sum_bits)
            ^ signed_cast(self.early.val());
        self.leaned.next = bit_cast(self.slope.val(), self.sum_bits + 1).shifted_in(true)
            + bit_cast(self.turned.val(), self.sum_bits + 1).shifted_in(self.early.val());
        if self.i_counted.val() {
            self.place.next = self.place.val() + 1;
            self.all.next = self.all.val() + signed_cast(self.i_count.val());
            self.slope.next = self.leaned.val().slice(1, self.sum_bits);
        }
        if self.i_taken_first.val() {
            self.place.next = 0.into();
            self.all.next = 0.into();
            self.slope.next = 0.into();
        }
    }

    /// A window's decision has all stages, a scan's those in which its peak's step comes within the code period.
    fn run_stages(&mut self) {
        self.began.next = self.i_run.val() | (self.began.val() & !self.i_taken_first.val());
        self.finds.next =
            self.i_peak_valid.val() & self.began.val() & self.waits.val() & !self.window.val();
        self.found.next = self.finds.val();
        self.stage.next = self
            .stage
            .val()
            .shifted_in(self.i_last.val() & self.window.val())
            .replace_bit(self.halved + 1, self.stage.val().get_bit(self.halved) | self.found.val());
    }

    /// Shares are taken by halves, that of the light and later that of the way.
    fn halve(&mut self) {
        self.halves.next = self.halvings.val().any();
        if self.halvings.val().any() {
            self.halvings.next = self.halvings.val() - 1;
        }
        if self.halves.val() {
            self.least.next = self.least.val() >> 1;
        }
        if self.stage.val().get_bit(0) {
            self.halvings.next = self.threshold.val();
            self.least.next = self.light.val();
        }
        if self.stage.val().get_bit(self.divided + 3) {
            self.halvings.next = self.gain.val();
        }
    }

    /// Whether the sum of the counts is at least a share of what was expected; a sixteenth of what it has more is
    /// expected from now on.
    fn weigh_light(&mut self) {
        self.spare.next = bit_cast(signed_cast(self.all.val()), self.sum_bits + 1)
            - bit_cast(self.least.val(), self.sum_bits + 1);
        self.is_bright.next = self.all.val().any() & !self.spare.val().get_bit(self.sum_bits);
        let (low, high) = (LIGHT_HALVINGS as usize, self.sum_bits + 1 - LIGHT_HALVINGS as usize);
        // Of the light no share is taken yet.
        if self.stage.val().get_bit(1) {
            self.gained.next = self.spare.val().slice(low, high);
        }
        if self.stage.val().get_bit(self.divided) {
            self.lit.next = self.is_bright.val();
        }
        if self.stage.val().get_bit(self.halved - 1) {
            self.missed.next = (self.missed.val() + 1) & signed_cast(!self.lit.val());
        }
        if self.stage.val().get_bit(self.halved - 1) & self.lit.val() {
            self.light.next =
                self.light.val() + bit_cast(signed_cast(self.gained.val()), self.sum_bits);
        }
    }

    /// The size of the slope over the sum, a bit in each clock, without restoring: the sum is taken from twice the rest if that
    /// is not negative, else added. The first bit says that the slope is as large as the sum, or larger. Before that the
    /// slope is turned to where it is not negative, by the same adder: the sign of what is there first decides.
    fn divide(&mut self) {
        let bits = self.sum_bits + 2;
        self.minus.next = !self.rest.val().get_bit(bits - 1);
        self.begins.next = (self.i_last.val() & self.window.val()) | self.stage.val().get_bit(0);
        if self.begins.val() {
            self.taken.next = bit_cast(signed_cast(self.slope.val()), bits);
        } else {
            self.taken.next = bit_cast(self.all.val(), bits) << 1;
        }
        if self.stage.val().get_bit(0) {
            self.negative.next = self.slope.val().get_bit(self.sum_bits - 1);
        }
        self.left.next = ((bit_cast(self.rest.val(), bits + 1) << 1)
            & signed_cast(!self.begins.val()))
        .shifted_in(true)
            + bit_cast(
                self.taken.val() ^ signed_cast(self.minus.val() | self.stage.val().get_bit(0)),
                bits + 1,
            )
            .shifted_in(self.minus.val() & !self.stage.val().get_bit(0));
        self.rest.next = self.left.val().slice(1, bits);
        self.quotient.next = self.quotient.val().shifted_in(self.minus.val());
        if self.quotient.val().get_bit(self.offset_bits) {
            self.size.next = bit_cast(signed_cast(true), self.offset_bits);
        } else {
            self.size.next = bit_cast(self.quotient.val(), self.offset_bits);
        }
    }

    /// An addend in one clock, the sum in the next one, and then the total. It begins with the window's middle, to which the
    /// offset comes, and from which the position's fraction is taken: the way to the peak. A share of that comes to the
    /// position, which comes back into the code period, twice, since a scan may have more steps than that. From there it
    /// goes to the next window's first step.
    fn add_up(&mut self) {
        let (bits, divided, halved) = (self.total_bits, self.divided, self.halved);
        self.turns.next = self.stage.val().get_bit(halved + 2)
            | self.stage.val().get_bit(halved + 5)
            | self.stage.val().get_bit(halved + 11);
        self.tries.next = self.stage.val().get_bit(halved + 4)
            | self.stage.val().get_bit(halved + 7)
            | self.stage.val().get_bit(halved + 13);
        self.takes.next = self.stage.val().get_bit(divided + 1)
            | self.stage.val().get_bit(divided + 3)
            | self.stage.val().get_bit(halved + 1)
            | self.stage.val().get_bit(halved + 4)
            | self.stage.val().get_bit(halved + 7)
            | self.stage.val().get_bit(halved + 10)
            | self.stage.val().get_bit(halved + 13);
        self.loads.next = self.stage.val().get_bit(divided - 1)
            | (self.stage.val().get_bit(halved - 1) & !self.lit.val())
            | self.finds.val()
            | self.halvings.val().any();
        self.choose_addend();
        self.grown.next = bit_cast(self.total.val(), bits + 1).shifted_in(true)
            + bit_cast(self.addend.val(), bits + 1).shifted_in(self.carry.val());
        self.sum.next = self.grown.val().slice(1, bits);
        self.middle.next =
            (bit_cast(self.ahead.val(), bits) << POSITION_BITS) - self.half_step.val();
        if self.loads.val()
            | (self.takes.val() & !(self.tries.val() & self.sum.val().get_bit(bits - 1)))
        {
            // At most one of them; without light there is no way.
            self.total.next = (self.sum.val() & signed_cast(self.takes.val()))
                | (self.middle.val() & signed_cast(self.stage.val().get_bit(divided)))
                | ((bit_cast(self.first.val(), bits) << POSITION_BITS)
                    & signed_cast(self.found.val()))
                | (bit_cast(signed_cast(self.total.val().slice(1, bits - 1)), bits)
                    & signed_cast(self.halves.val()));
        }
    }

    /// Of several at most one, so that there is no order among them.
    fn choose_addend(&mut self) {
        let (bits, divided, halved) = (self.total_bits, self.divided, self.halved);
        self.offset.next = (bit_cast(self.size.val(), bits) << (HIDDEN_BITS as usize))
            ^ signed_cast(self.negative.val());
        self.back.next = bit_cast(self.ahead.val(), self.moved_bits) - self.half_window.val();
        if self.total.val().get_bit(bits - 1) {
            self.turn.next = self.period.val();
        } else {
            self.turn.next = self.less_period.val();
        }
        self.addend.next = (self.offset.val() & signed_cast(self.stage.val().get_bit(divided)))
            | (!bit_cast(self.fraction.val(), bits)
                & signed_cast(self.stage.val().get_bit(divided + 2)))
            | (((bit_cast(self.step.val(), bits) << POSITION_BITS)
                | bit_cast(self.fraction.val(), bits))
                & signed_cast(self.stage.val().get_bit(halved)))
            | ((bit_cast(self.back.val(), bits) << POSITION_BITS)
                & signed_cast(self.stage.val().get_bit(halved + 9)))
            | ((bit_cast(self.i_peak_step.val(), bits) << POSITION_BITS)
                & signed_cast(self.found.val()))
            | ((bit_cast(self.turn.val(), bits) << POSITION_BITS) & signed_cast(self.turns.val()));
        self.carry.next = (self.stage.val().get_bit(divided) & self.negative.val())
            | self.stage.val().get_bit(divided + 2);
    }

    /// The position, and where the window stands about it.
    fn place_window(&mut self) {
        self.placed.next = bit_cast(self.total.val().slice(0, POSITION_BITS), POSITION_BITS + 2)
            + bit_cast(self.owed.val(), POSITION_BITS + 2);
        if self.stage.val().get_bit(self.halved + 6) {
            // Half a step is the fraction's highest bit: it turns, and carries.
            self.owed.next = gather(POSITION_BITS + 1, |bit| {
                if bit < POSITION_BITS - 1 {
                    self.placed.val().get_bit(bit)
                } else if bit < POSITION_BITS {
                    !self.placed.val().get_bit(bit)
                } else {
                    self.placed.val().get_bit(POSITION_BITS - 1)
                }
            });
            self.ahead.next = self.placed.val().slice(POSITION_BITS, 2);
        }
        if self.stage.val().get_bit(self.halved + 9) {
            self.fraction.next = bit_cast(self.total.val(), POSITION_BITS);
            self.step.next = self.total.val().slice(POSITION_BITS, self.step_bits);
        }
    }

    /// Whether there is still a target, and with that the next scan may begin. A scan's peak is one if it counts up.
    fn decide(&mut self) {
        if self.stage.val().get_bit(self.halved) {
            self.gives_up.next = !self.lit.val() & (self.missed.val() >= self.patience.val());
        }
        if self.found.val() {
            self.lit.next = self.i_peak_count.val().any()
                & !self.i_peak_count.val().get_bit(self.plan.count_bits as usize - 1);
            self.light.next = bit_cast(self.i_peak_count.val(), self.sum_bits) << self.sample_bits;
            self.owed.next = bit_cast(self.half_step.val(), POSITION_BITS + 1);
            self.missed.next = 0.into();
            self.gives_up.next = false;
        }
        self.keeps.next =
            self.on.val() & !self.gives_up.val() & (self.window.val() | self.lit.val());
        self.lost.next =
            self.stage.val().get_bit(self.halved + 15) & self.on.val() & self.gives_up.val();
        if self.stage.val().get_bit(self.halved + 15) {
            self.waits.next = false;
            self.follows.next = self.keeps.val();
            self.locked.next = self.on.val() & self.window.val() & self.lit.val();
            if self.keeps.val() {
                self.position.next = gather(self.plan.position_bits() as usize, |bit| {
                    if bit < FRACTION_BITS as usize {
                        self.fraction.val().get_bit(bit + HIDDEN_BITS as usize)
                    } else {
                        self.step.val().get_bit(bit - FRACTION_BITS as usize)
                    }
                });
            }
        }
        if !self.i_go.val() {
            self.follows.next = false;
            self.locked.next = false;
        }
    }

    fn tell(&mut self) {
        self.o_position.next = self.position.val();
        self.o_locked.next = self.locked.val();
        self.o_lost.next = self.lost.val();
        self.unused.next = self.spare.val().slice(0, LIGHT_HALVINGS as usize).any()
            | self.leaned.val().get_bit(0)
            | self.left.val().get_bit(0)
            | self.grown.val().get_bit(0);
    }
}

#[cfg(test)]
mod tests;
