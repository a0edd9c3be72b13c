//! Where the target is, and with it the next window.

use crate::rtl::front::prelude::*;
use crate::sensor::track::{FRACTION_BITS, HIDDEN_BITS, TrackPlan};

/// Bits of a position's fraction.
const POSITION_BITS: usize = (FRACTION_BITS + HIDDEN_BITS) as usize;
/// Clocks from the share of the way to the next window's first step.
pub(super) const MOVES: usize = 16;

#[block(window_position)]
/// where the target is, and where the next window begins
///
/// One adder, whose addend, sum and total are registers each, makes the way to the peak, the position and the window's first
/// step, one after another.
pub struct WindowPosition {
    plan: TrackPlan,
    /// Bits of a peak's step, from the scan's first on.
    peak_step_bits: usize,
    /// Bits of a step on its way to the sequencer.
    scan_word_bits: usize,
    #[set(plan.step_bits as usize)]
    step_bits: usize,
    #[set(plan.offset_bits() as usize)]
    offset_bits: usize,
    /// Bits of a step that may be beyond the code period's ends.
    #[set(step_bits + 3)]
    moved_bits: usize,
    /// The same with a fraction.
    #[set(moved_bits + POSITION_BITS)]
    total_bits: usize,
    /// Of them those that go to the sequencer.
    #[set(moved_bits.min(scan_word_bits))]
    first_bits: usize,
    /// from the window's middle to the peak, in size
    #[under("Window")]
    #[width(offset_bits)]
    pub i_size: Input<Word>,
    /// that is negative
    pub i_negative: Input<bool>,
    /// a scan finds a target
    #[under("Scan")]
    pub i_finds: Input<bool>,
    /// it has found it a clock ago
    pub i_found: Input<bool>,
    /// its first phase step
    #[width(step_bits)]
    pub i_first: Input<Word>,
    /// phase step of its peak, from there on
    #[width(peak_step_bits)]
    pub i_peak_step: Input<Word>,
    /// the window's quotient comes, was there one clock ago, and so on
    #[under("Stages of a decision")]
    #[width(5)]
    pub i_way: Input<Word>,
    /// halvings are still to come
    pub i_halving: Input<bool>,
    /// a share is halved
    pub i_halves: Input<bool>,
    /// the share of the way comes
    pub i_moves: Input<bool>,
    /// the window has its target's light
    pub i_lit: Input<bool>,
    /// the target is still there
    pub i_follows: Input<bool>,
    /// the share of the way is there
    pub o_moves: Output<bool>,
    /// the next window is placed
    pub o_placed: Output<bool>,
    /// the next window's first step
    #[under("Position")]
    #[width(first_bits)]
    pub o_first: Output<Word>,
    /// phase step of the target's peak, and 8 bits of its fraction
    #[width(plan.position_bits())]
    pub o_position: Output<Word>,
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
    /// clocks since the share of the way was there, one bit for each
    #[width(MOVES)]
    stage: Register<Word>,
    /// the sum becomes the total
    takes: Register<bool>,
    /// unless it is negative
    tries: Register<bool>,
    /// something else does
    loads: Register<bool>,
    /// the code period is added to a negative total, or taken from another
    turns: Register<bool>,
    /// way to the peak, then position, then the next window's first step; with a fraction
    #[width(total_bits)]
    total: Register<Word>,
    /// what is added to it next
    #[width(total_bits)]
    addend: Register<Word>,
    /// and one more
    carry: Register<bool>,
    /// the window's middle, from the position's step on
    #[width(total_bits)]
    middle: Local<Word>,
    /// from the window's middle to the peak, all bits turned if that is negative
    #[width(total_bits)]
    offset: Local<Word>,
    /// the position
    #[width(total_bits)]
    at: Local<Word>,
    /// from the position's step to the next window's first
    #[width(moved_bits)]
    back: Local<Word>,
    /// the code period, such that the total comes nearer to it
    #[width(moved_bits)]
    turn: Local<Word>,
    /// total and addend; bit 0 carries
    #[width(total_bits + 1)]
    grown: Local<Word>,
    /// total and addend
    #[width(total_bits)]
    sum: Register<Word>,
    /// fraction of the position's step
    #[width(POSITION_BITS)]
    fraction: Register<Word>,
    /// what the windows' middles owe to the positions, of one step, and half a step
    #[width(POSITION_BITS + 1)]
    owed: Register<Word>,
    /// steps from the position's to the first of the window's later half
    #[width(2)]
    ahead: Register<Word>,
    /// half a step behind the position, from its step on, with what is owed: where the window's later half begins
    #[width(POSITION_BITS + 2)]
    placed: Local<Word>,
    /// phase step of the position
    #[width(step_bits)]
    step: Register<Word>,
    /// the position as it is told
    #[width(plan.position_bits())]
    position: Register<Word>,
    /// the bit that carries has no use; linters know by the name
    unused: Local<bool>,
}

#[kernel]
impl Logic for WindowPosition {
    fn update(&mut self) {
        self.add_up();
        self.place_window();
        self.run_stages();
        self.tell();
        self.o_first.next = self.total.val().slice(POSITION_BITS, self.first_bits);
        self.unused.next = self.grown.val().get_bit(0);
    }

    /// An addend in one clock, the sum in the next one, and then the total. It begins with the window's middle, to which the
    /// offset comes, and from which the position's fraction is taken: the way to the peak. A share of that comes to the
    /// position, which comes back into the code period, twice, since a scan may have more steps than that. From there it
    /// goes to the next window's first step.
    fn add_up(&mut self) {
        let bits = self.total_bits;
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
                | (self.middle.val() & signed_cast(self.i_way.val().get_bit(1)))
                | ((bit_cast(self.i_first.val(), bits) << POSITION_BITS)
                    & signed_cast(self.i_found.val()))
                | (bit_cast(signed_cast(self.total.val().slice(1, bits - 1)), bits)
                    & signed_cast(self.i_halves.val()));
        }
    }

    /// Of several at most one, so that there is no order among them.
    fn choose_addend(&mut self) {
        let bits = self.total_bits;
        self.offset.next = (bit_cast(self.i_size.val(), bits) << (HIDDEN_BITS as usize))
            ^ signed_cast(self.i_negative.val());
        self.back.next = bit_cast(self.ahead.val(), self.moved_bits) - self.half_window.val();
        if self.total.val().get_bit(bits - 1) {
            self.turn.next = self.period.val();
        } else {
            self.turn.next = self.less_period.val();
        }
        self.at.next = gather(bits, |bit| {
            if bit < POSITION_BITS {
                self.fraction.val().get_bit(bit)
            } else if bit < POSITION_BITS + self.step_bits {
                self.step.val().get_bit(bit - POSITION_BITS)
            } else {
                false
            }
        });
        self.addend.next = (self.offset.val() & signed_cast(self.i_way.val().get_bit(1)))
            | (!bit_cast(self.fraction.val(), bits) & signed_cast(self.i_way.val().get_bit(3)))
            | (self.at.val() & signed_cast(self.stage.val().get_bit(0)))
            | ((bit_cast(self.back.val(), bits) << POSITION_BITS)
                & signed_cast(self.stage.val().get_bit(9)))
            | ((bit_cast(self.i_peak_step.val(), bits) << POSITION_BITS)
                & signed_cast(self.i_found.val()))
            | ((bit_cast(self.turn.val(), bits) << POSITION_BITS) & signed_cast(self.turns.val()));
        self.carry.next =
            (self.i_way.val().get_bit(1) & self.i_negative.val()) | self.i_way.val().get_bit(3);
    }

    /// The position, and where the window stands about it.
    fn place_window(&mut self) {
        self.placed.next = bit_cast(self.total.val().slice(0, POSITION_BITS), POSITION_BITS + 2)
            + bit_cast(self.owed.val(), POSITION_BITS + 2);
        if self.stage.val().get_bit(6) {
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
        if self.stage.val().get_bit(9) {
            self.fraction.next = bit_cast(self.total.val(), POSITION_BITS);
            self.step.next = self.total.val().slice(POSITION_BITS, self.step_bits);
        }
        if self.i_found.val() {
            self.owed.next = bit_cast(self.half_step.val(), POSITION_BITS + 1);
        }
    }

    /// What the adder is for in which clock. A scan's decision has those stages in which its peak's step comes within the
    /// code period.
    fn run_stages(&mut self) {
        self.stage.next = self
            .stage
            .val()
            .shifted_in(self.i_moves.val())
            .replace_bit(1, self.stage.val().get_bit(0) | self.i_found.val());
        self.turns.next = self.stage.val().get_bit(2)
            | self.stage.val().get_bit(5)
            | self.stage.val().get_bit(11);
        self.tries.next = self.stage.val().get_bit(4)
            | self.stage.val().get_bit(7)
            | self.stage.val().get_bit(13);
        self.takes.next = self.i_way.val().get_bit(2)
            | self.i_way.val().get_bit(4)
            | self.stage.val().get_bit(1)
            | self.stage.val().get_bit(4)
            | self.stage.val().get_bit(7)
            | self.stage.val().get_bit(10)
            | self.stage.val().get_bit(13);
        self.loads.next = self.i_way.val().get_bit(0)
            | (self.i_moves.val() & !self.i_lit.val())
            | self.i_finds.val()
            | self.i_halving.val();
        self.o_moves.next = self.stage.val().get_bit(0);
        self.o_placed.next = self.stage.val().get_bit(MOVES - 1);
    }

    fn tell(&mut self) {
        if self.stage.val().get_bit(MOVES - 1) & self.i_follows.val() {
            self.position.next = gather(self.plan.position_bits() as usize, |bit| {
                if bit < FRACTION_BITS as usize {
                    self.fraction.val().get_bit(bit + HIDDEN_BITS as usize)
                } else {
                    self.step.val().get_bit(bit - FRACTION_BITS as usize)
                }
            });
        }
        self.o_position.next = self.position.val();
    }
}
