//! A running total and what it grew by in a phase step.
//!
//! | port | |
//! |---|---|
//! | `i_addend`, `i_dump` | what to add; the step's last addend is in |
//! | `i_borrow`, `o_carry`, `o_borrow` | between segments of a wider total |
//! | `o_count` | growth within the last step |
//!
//! Latency 1 clock to the total and 1 more to `o_count`, in a segment above others another one.
//! A total that is never cleared keeps a multiplexer, a LUT per bit, out of the carry chain.
//!
//! Cost (ECP5, docs/resources.md): 36 LUTs, 51 flip-flops of a 17-bit count.

use crate::rtl::front::prelude::*;

/// A running total, or a segment of one.
#[block(AccumulatorPlan)]
pub struct Accumulator {
    /// what to add, signed
    #[width(plan.addend_bits)]
    pub i_addend: Input<Word>,
    /// the total holds the last addend of a phase step
    pub i_dump: Input<bool>,
    /// the segment below owes one
    #[when(plan.has_lower)]
    pub i_borrow: Optional<Input<bool>>,
    /// what the segment above is to add, signed
    #[when(plan.has_higher)]
    #[width(2)]
    pub o_carry: Optional<Output<Word>>,
    /// the segment above owes one
    #[when(plan.has_higher)]
    pub o_borrow: Optional<Output<bool>>,
    /// growth within the last phase step
    #[width(plan.bits)]
    pub o_count: Output<Word>,
    #[is(describe(*plan))]
    about: About,
    /// the new total and, signed, what leaves it
    #[when(plan.has_higher)]
    #[width(plan.bits + 2)]
    grown: Optional<Local<Word>>,
    #[width(plan.difference_bits())]
    difference: Local<Word>,
    /// sum of all addends, modulo its width
    #[width(plan.bits)]
    total: Register<Word>,
    /// total at the last dump
    #[width(plan.bits)]
    base: Register<Word>,
    /// growth, before the borrow is paid
    #[when(plan.has_lower)]
    #[width(plan.difference_bits())]
    growth: Optional<Register<Word>>,
    /// growth, less what the segment below owes
    #[when(plan.has_lower)]
    #[width(plan.difference_bits())]
    settled: Optional<Local<Word>>,
    #[width(plan.bits)]
    count: Register<Word>,
    #[when(plan.has_higher)]
    #[width(2)]
    carry: Optional<Register<Word>>,
    #[when(plan.has_higher)]
    borrow: Optional<Register<bool>>,
    plan: Plan<AccumulatorPlan>,
}

#[derive(Debug, Clone, Copy)]
struct AccumulatorPlan {
    bits: usize,
    /// Bits of what it adds in a clock, signed.
    addend_bits: usize,
    has_lower: bool,
    has_higher: bool,
}

impl AccumulatorPlan {
    fn difference_bits(&self) -> usize {
        self.bits + usize::from(self.has_higher)
    }
}

impl Accumulator {
    /// A total of `bits` bits that adds `addend_bits` signed bits a clock.
    pub fn new(bits: u32, addend_bits: usize) -> Accumulator {
        Accumulator::segment(bits, addend_bits, false, false)
    }

    /// A segment of a total, which may have others below and above it.
    pub fn segment(
        bits: u32,
        addend_bits: usize,
        has_lower: bool,
        has_higher: bool,
    ) -> Accumulator {
        let bits = bits as usize;
        Accumulator::build(&AccumulatorPlan { bits, addend_bits, has_lower, has_higher })
    }
}

fn describe(plan: AccumulatorPlan) -> About {
    let (name, title) = match (plan.has_lower, plan.has_higher) {
        (false, false) => ("accumulator", "a running total and its growth per phase step"),
        (false, true) => ("lowest_segment", "the lowest segment of a running total"),
        (true, true) => ("middle_segment", "a segment of a running total, between others"),
        (true, false) => ("highest_segment", "the highest segment of a running total"),
    };
    let about = About::new(name, title)
        .size(("BITS", "bits of the total"), plan.bits, plan.addend_bits..=usize::MAX, {
            move |bits| Accumulator::build(&AccumulatorPlan { bits, ..plan })
        })
        .note(
            "The total is never cleared: a step's count is the difference of two totals, which \
             keeps multiplexers out of the carry chain, and wrapping does no harm to a difference.",
        );
    let segment = "Carry and borrow reach the segment above one clock later, and so does i_dump.";
    match (plan.has_lower, plan.has_higher) {
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
        if self.plan.has_higher {
            self.add_and_carry();
        } else {
            self.total.d.next = self.total.q.val() + signed_cast(self.i_addend.val());
        }
        let bits = self.plan.difference_bits();
        self.difference.next =
            bit_cast(self.total.q.val(), bits) - bit_cast(self.base.q.val(), bits);
        if self.plan.has_lower {
            self.pay_borrow();
        }
        if self.i_dump.val() {
            self.base.d.next = self.total.q.val();
            if self.plan.has_lower {
                self.growth.d.next = self.difference.val();
            } else {
                self.count.d.next = bit_cast(self.difference.val(), self.plan.bits);
                if self.plan.has_higher {
                    self.borrow.d.next = self.difference.val().get_bit(self.plan.bits);
                }
            }
        }
        self.o_count.next = self.count.q.val();
    }

    fn add_and_carry(&mut self) {
        let bits = self.plan.bits;
        self.grown.next = bit_cast(self.total.q.val(), bits + 2) + signed_cast(self.i_addend.val());
        self.total.d.next = bit_cast(self.grown.val(), bits);
        self.carry.d.next = bit_cast(false, 2)
            .replace_bit(0, self.grown.val().get_bit(bits))
            .replace_bit(1, self.grown.val().get_bit(bits + 1));
        self.o_carry.next = self.carry.q.val();
        self.o_borrow.next = self.borrow.q.val();
    }

    fn pay_borrow(&mut self) {
        self.settled.next =
            self.growth.q.val() - bit_cast(self.i_borrow.val(), self.plan.difference_bits());
        self.count.d.next = bit_cast(self.settled.val(), self.plan.bits);
        if self.plan.has_higher {
            self.borrow.d.next = self.settled.val().get_bit(self.plan.bits);
        }
    }
}
