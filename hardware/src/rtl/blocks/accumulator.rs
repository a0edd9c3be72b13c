//! A running total and what it grew by in a phase step.
//!
//! A total that is never cleared keeps a multiplexer, a LUT per bit, out of the carry chain.
//!
//! Cost (ECP5, docs/resources.md): 36 LUTs, 51 flip-flops of a 17-bit count.

use crate::rtl::front::prelude::*;

/// A running total, or a segment of one.
#[block(describe(has_lower, has_higher, bits, addend_bits))]
pub struct Accumulator {
    bits: usize,
    /// Bits of what it adds in a clock, signed.
    addend_bits: usize,
    has_lower: bool,
    has_higher: bool,
    #[set(bits + usize::from(has_higher))]
    difference_bits: usize,
    /// what to add, signed
    #[width(addend_bits)]
    pub i_addend: Input<Word>,
    /// the total holds the last addend of a phase step
    pub i_dump: Input<bool>,
    /// the segment below owes one
    #[when(has_lower)]
    pub i_borrow: Optional<Input<bool>>,
    /// what the segment above is to add, signed
    #[when(has_higher)]
    #[width(2)]
    pub o_carry: Optional<Output<Word>>,
    /// the segment above owes one
    #[when(has_higher)]
    pub o_borrow: Optional<Output<bool>>,
    /// growth within the last phase step
    #[width(bits)]
    pub o_count: Output<Word>,
    /// the new total and, signed, what leaves it
    #[when(has_higher)]
    #[width(bits + 2)]
    grown: Optional<Local<Word>>,
    #[width(difference_bits)]
    difference: Local<Word>,
    /// sum of all addends, modulo its width
    #[width(bits)]
    total: Register<Word>,
    /// total at the last dump
    #[width(bits)]
    base: Register<Word>,
    /// growth, before the borrow is paid
    #[when(has_lower)]
    #[width(difference_bits)]
    growth: Optional<Register<Word>>,
    /// growth, less what the segment below owes
    #[when(has_lower)]
    #[width(difference_bits)]
    settled: Optional<Local<Word>>,
    #[width(bits)]
    count: Register<Word>,
    #[when(has_higher)]
    #[width(2)]
    carry: Optional<Register<Word>>,
    #[when(has_higher)]
    borrow: Optional<Register<bool>>,
}

fn describe(has_lower: bool, has_higher: bool, bits: usize, addend_bits: usize) -> About {
    let (name, title) = match (has_lower, has_higher) {
        (false, false) => ("accumulator", "a running total and its growth per phase step"),
        (false, true) => ("lowest_segment", "the lowest segment of a running total"),
        (true, true) => ("middle_segment", "a segment of a running total, between others"),
        (true, false) => ("highest_segment", "the highest segment of a running total"),
    };
    let about = About::new(name, title)
        .size(("BITS", "bits of the total"), bits, addend_bits..=usize::MAX, move |bits| {
            Accumulator::new(bits, addend_bits, has_lower, has_higher)
        })
        .note(
            "The total is never cleared: a step's count is the difference of two totals, which \
             keeps multiplexers out of the carry chain, and wrapping does no harm to a difference.",
        );
    let segment = "Carry and borrow reach the segment above one clock later, and so does i_dump.";
    match (has_lower, has_higher) {
        (false, false) => about.fact("Latency", "1 clock to the total, 1 more to o_count"),
        (false, true) => {
            about.note(segment).fact("Latency", "1 clock to the total, 1 more to o_count")
        }
        (true, _) => about.note(segment).fact("Latency", "1 clock to the total, 2 more to o_count"),
    }
}

#[kernel]
impl Logic for Accumulator {
    fn update(&mut self) {
        if self.has_higher {
            self.add_and_carry();
        } else {
            self.total.next = self.total.val() + signed_cast(self.i_addend.val());
        }
        let bits = self.difference_bits;
        self.difference.next = bit_cast(self.total.val(), bits) - bit_cast(self.base.val(), bits);
        if self.has_lower {
            self.pay_borrow();
        }
        if self.i_dump.val() {
            self.base.next = self.total.val();
            if self.has_lower {
                self.growth.next = self.difference.val();
            } else {
                self.count.next = bit_cast(self.difference.val(), self.bits);
                if self.has_higher {
                    self.borrow.next = self.difference.val().get_bit(self.bits);
                }
            }
        }
        self.o_count.next = self.count.val();
    }

    fn add_and_carry(&mut self) {
        let bits = self.bits;
        self.grown.next = bit_cast(self.total.val(), bits + 2) + signed_cast(self.i_addend.val());
        self.total.next = bit_cast(self.grown.val(), bits);
        self.carry.next = bit_cast(false, 2)
            .replace_bit(0, self.grown.val().get_bit(bits))
            .replace_bit(1, self.grown.val().get_bit(bits + 1));
        connect! { self: carry, borrow }
    }

    fn pay_borrow(&mut self) {
        self.settled.next = self.growth.val() - bit_cast(self.i_borrow.val(), self.difference_bits);
        self.count.next = bit_cast(self.settled.val(), self.bits);
        if self.has_higher {
            self.borrow.next = self.settled.val().get_bit(self.bits);
        }
    }
}
