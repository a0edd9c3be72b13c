//! How far the peak is from a window's middle.

use crate::rtl::front::prelude::*;
use crate::sensor::track::TrackPlan;

#[block(window_offset)]
/// how far the peak is from a window's middle, of the counts' slope over their sum
///
/// The later half's counts less the earlier half's, over the sum of all, say how far the peak is from the middle. Both are
/// summed while counts come; then the slope's size is divided by the sum, a bit in each clock.
///
/// - Latency: {offset_bits + 3} clocks from i_ends to o_size
pub struct WindowOffset {
    plan: TrackPlan,
    #[set(plan.sum_bits() as usize)]
    sum_bits: usize,
    #[set(plan.sample_bits as usize)]
    sample_bits: usize,
    #[set(plan.offset_bits() as usize)]
    offset_bits: usize,
    /// a window begins
    pub i_clear: Input<bool>,
    /// count of a phase step, signed
    #[width(plan.count_bits)]
    pub i_count: Input<Word>,
    /// it is new
    pub i_counted: Input<bool>,
    /// it is the window's last
    pub i_ends: Input<bool>,
    /// the slope is turned to where it is not negative: a clock later
    pub i_turns: Input<bool>,
    /// sum of the window's counts
    #[width(sum_bits)]
    pub o_sum: Output<Word>,
    /// the slope is negative
    pub o_negative: Output<bool>,
    /// its size over the sum, or the most
    #[width(offset_bits)]
    pub o_size: Output<Word>,
    /// counts of the window so far
    #[width(sample_bits + 1)]
    place: Register<Word>,
    /// sum of the window's counts
    #[width(sum_bits)]
    all: Register<Word>,
    /// its later half less its earlier one
    #[width(sum_bits)]
    slope: Register<Word>,
    /// the count is one of the earlier half
    early: Local<bool>,
    /// a count that is added to the slope, or, all its bits turned, taken from it
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
    /// what is added to twice the rest, or comes in its place
    #[width(sum_bits + 2)]
    taken: Local<Word>,
    /// all its bits are turned
    turns_taken: Local<bool>,
    /// the rest with it; bit 0 carries
    #[width(sum_bits + 3)]
    left: Local<Word>,
    /// whether the slope is as large as the sum, and the bits of its share
    #[width(offset_bits + 1)]
    quotient: Register<Word>,
    /// the quotient, or the most
    #[width(offset_bits)]
    size: Local<Word>,
    /// bits that nobody reads: those that carry; linters know by the name
    unused: Local<bool>,
}

#[kernel]
impl Logic for WindowOffset {
    fn update(&mut self) {
        self.sum_counts();
        self.divide();
        self.o_sum.next = self.all.val();
        self.o_negative.next = self.negative.val();
        self.o_size.next = self.size.val();
        self.unused.next = self.leaned.val().get_bit(0) | self.left.val().get_bit(0);
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
        if self.i_clear.val() {
            self.place.next = 0.into();
            self.all.next = 0.into();
            self.slope.next = 0.into();
        }
    }

    /// The size of the slope over the sum, a bit in each clock, without restoring: the sum is taken from twice the rest if that
    /// is not negative, else added. The first bit says that the slope is as large as the sum, or larger. Before that the
    /// slope is turned to where it is not negative, by the same adder: the sign of what is there first decides.
    fn divide(&mut self) {
        let bits = self.sum_bits + 2;
        self.minus.next = !self.rest.val().get_bit(bits - 1);
        self.begins.next = self.i_ends.val() | self.i_turns.val();
        if self.begins.val() {
            self.taken.next = bit_cast(signed_cast(self.slope.val()), bits);
        } else {
            self.taken.next = bit_cast(self.all.val(), bits) << 1;
        }
        self.turns_taken.next = self.minus.val() | self.i_turns.val();
        if self.i_turns.val() {
            self.negative.next = self.slope.val().get_bit(self.sum_bits - 1);
        }
        self.left.next = ((bit_cast(self.rest.val(), bits + 1) << 1)
            & signed_cast(!self.begins.val()))
        .shifted_in(true)
            + bit_cast(self.taken.val() ^ signed_cast(self.turns_taken.val()), bits + 1)
                .shifted_in(self.minus.val() & !self.i_turns.val());
        self.rest.next = self.left.val().slice(1, bits);
        self.quotient.next = self.quotient.val().shifted_in(self.minus.val());
        if self.quotient.val().get_bit(self.offset_bits) {
            self.size.next = bit_cast(signed_cast(true), self.offset_bits);
        } else {
            self.size.next = bit_cast(self.quotient.val(), self.offset_bits);
        }
    }
}
