//! A running total, or a segment of one, and what it grew by in a phase step.

use crate::rtl::front::prelude::*;

/// A segment of a running total.
#[derive(Debug, Clone, LogicBlock)]
pub struct Accumulator {
    /// Clock.
    pub i_clk: Input<bool>,
    /// Synchronous reset.
    pub i_rst: Input<bool>,
    /// What to add.
    pub i_addend: Input<Word>,
    /// The total holds the last addend of a phase step.
    pub i_dump: Input<bool>,
    /// The segment below owes one.
    pub i_borrow: Optional<Input<bool>>,
    /// What the segment above is to add.
    pub o_carry: Optional<Output<Word>>,
    /// The segment above owes one.
    pub o_borrow: Optional<Output<bool>>,
    /// Growth within the last phase step.
    pub o_count: Output<Word>,
    about: About,
    grown: Optional<Local<Word>>,
    difference: Local<Word>,
    total: Register<Word>,
    base: Register<Word>,
    growth: Optional<Register<Word>>,
    settled: Optional<Local<Word>>,
    count: Register<Word>,
    carry: Optional<Register<Word>>,
    borrow: Optional<Register<bool>>,
    _bits: usize,
    _difference_bits: usize,
}

/// Where a segment stands in its total.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// There is a segment below it.
    pub has_lower: bool,
    /// There is a segment above it.
    pub has_higher: bool,
}

impl Accumulator {
    /// A segment of `bits` bits that adds `addend_bits` signed bits a clock.
    pub fn new(bits: u32, addend_bits: u32, place: Place) -> Accumulator {
        let difference_bits = bits + u32::from(place.has_higher);
        let when_higher = |bit| Optional::new(place.has_higher, bit);
        let mut about = About::new(
            "accumulator",
            "a running total and its growth per phase step",
        )
        .note(
            "The total is never cleared: a step's count is the difference of two totals, \
                 which keeps multiplexers out of the carry chain, and wrapping does no harm to a \
                 difference.",
        )
        .fact("Latency", "1 clock to the total, 1 more to o_count");
        if place.has_lower || place.has_higher {
            about = about.note(
                "It is a segment of a wider total: carry and borrow reach the next segment one \
                 clock later, and so does i_dump.",
            );
        }
        Accumulator {
            i_clk: Input::bit("one addend per cycle"),
            i_rst: Input::bit("synchronous, active high"),
            i_addend: Input::word(addend_bits, "what to add, signed"),
            i_dump: Input::bit("the total holds the last addend of a phase step"),
            i_borrow: Optional::new(place.has_lower, Input::bit("the segment below owes one")),
            o_carry: Optional::new(
                place.has_higher,
                Output::word(2, "what the segment above is to add, signed"),
            ),
            o_borrow: when_higher(Output::bit("the segment above owes one")),
            o_count: Output::word(bits, "growth within the last phase step"),
            about,
            grown: Optional::new(
                place.has_higher,
                Local::word(bits + 2, "the new total and, signed, what leaves it"),
            ),
            difference: Local::word(difference_bits, ""),
            total: Register::word(bits, 0, "sum of all addends, modulo its width"),
            base: Register::word(bits, 0, "total at the last dump"),
            growth: Optional::new(
                place.has_lower,
                Register::word(difference_bits, 0, "growth, before the borrow is paid"),
            ),
            settled: Optional::new(
                place.has_lower,
                Local::word(difference_bits, "growth, less what the segment below owes"),
            ),
            count: Register::word(bits, 0, "growth within the last phase step"),
            carry: Optional::new(
                place.has_higher,
                Register::word(2, 0, "what the segment above is to add, signed"),
            ),
            borrow: Optional::new(
                place.has_higher,
                Register::bit(false, "the segment above owes one"),
            ),
            _bits: bits as usize,
            _difference_bits: difference_bits as usize,
        }
    }
}

impl Logic for Accumulator {
    #[hdl_gen]
    fn update(&mut self) {
        dff_setup!(self, i_clk, total, base, count);
        for _higher in 0..self.grown.count() {
            dff_setup!(self, i_clk, carry[0], borrow[0]);
            self.grown[0].next =
                bit_cast(self.total.q.val(), self._bits + 2) + signed_cast(self.i_addend.val());
            self.total.d.next = bit_cast(self.grown[0].val(), self._bits);
            for bits in self._bits..(self._bits + 1) {
                self.carry[0].d.next = bit_cast(false, 2)
                    .replace_bit(0, self.grown[0].val().get_bit(bits))
                    .replace_bit(1, self.grown[0].val().get_bit(bits + 1));
            }
            self.o_carry[0].next = self.carry[0].q.val();
            self.o_borrow[0].next = self.borrow[0].q.val();
        }
        for _top in self.grown.count()..1 {
            self.total.d.next = self.total.q.val() + signed_cast(self.i_addend.val());
        }
        self.difference.next = bit_cast(self.total.q.val(), self._difference_bits)
            - bit_cast(self.base.q.val(), self._difference_bits);
        for _lower in 0..self.growth.count() {
            dff_setup!(self, i_clk, growth[0]);
            self.settled[0].next =
                self.growth[0].q.val() - bit_cast(self.i_borrow[0].val(), self._difference_bits);
            self.count.d.next = bit_cast(self.settled[0].val(), self._bits);
            for _higher in 0..self.grown.count() {
                for top in (self._difference_bits - 1)..self._difference_bits {
                    self.borrow[0].d.next = self.settled[0].val().get_bit(top);
                }
            }
        }
        if self.i_dump.val() {
            self.base.d.next = self.total.q.val();
            for _lower in 0..self.growth.count() {
                self.growth[0].d.next = self.difference.val();
            }
            for _lowest in self.growth.count()..1 {
                self.count.d.next = bit_cast(self.difference.val(), self._bits);
                for _higher in 0..self.grown.count() {
                    for top in (self._difference_bits - 1)..self._difference_bits {
                        self.borrow[0].d.next = self.difference.val().get_bit(top);
                    }
                }
            }
        }
        self.o_count.next = self.count.q.val();
    }
}
