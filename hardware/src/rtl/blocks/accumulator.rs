//! A running total and what it grew by in a phase step.
//!
//! | port | |
//! |---|---|
//! | `i_addend`, `i_dump` | what to add; the step's last addend is in, a bit for each segment |
//! | `i_borrow` | the segment below owes one |
//! | `o_count` | growth within the last step |
//!
//! Latency 1 clock to the total and 1 more to `o_count`; of a total in segments 1 for each, and 1.
//! A total that is never cleared keeps a multiplexer, a LUT per bit, out of the carry chain.
//!
//! Cost (ECP5, docs/resources.md): 36 LUTs, 51 flip-flops of a 17-bit count.

use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

/// A running total, or a segment of one with those above it.
#[block(AccumulatorPlan)]
pub struct Accumulator {
    /// one addend per cycle
    pub i_clk: Input<bool>,
    /// synchronous, active high
    pub i_rst: Input<bool>,
    /// what to add, signed
    #[width(plan.addend_bits)]
    pub i_addend: Input<Word>,
    /// The total holds the last addend of a phase step.
    #[about(match plan.segments.count {
        1 => "the total holds the last addend of a phase step",
        _ => "bit s: segment s holds the last addend of a phase step",
    })]
    #[width(plan.segments.count)]
    pub i_dump: Input<Word>,
    /// the segment below owes one
    #[when(plan.has_lower)]
    pub i_borrow: Optional<Input<bool>>,
    /// growth within the last phase step
    #[width(plan.segments.bits())]
    pub o_count: Output<Word>,
    #[is(describe(plan))]
    about: About,
    /// the new total and, signed, what leaves it
    #[when(plan.has_higher())]
    #[width(plan.bits() + 2)]
    grown: Optional<Local<Word>>,
    #[width(plan.difference_bits())]
    difference: Local<Word>,
    /// sum of all addends, modulo its width
    #[width(plan.bits())]
    total: Register<Word>,
    /// total at the last dump
    #[width(plan.bits())]
    base: Register<Word>,
    /// growth, before the borrow is paid
    #[when(plan.has_lower)]
    #[width(plan.difference_bits())]
    growth: Optional<Register<Word>>,
    /// growth, less what the segment below owes
    #[when(plan.has_lower)]
    #[width(plan.difference_bits())]
    settled: Optional<Local<Word>>,
    #[width(plan.bits())]
    count: Register<Word>,
    /// what the segment above is to add, signed
    #[when(plan.has_higher())]
    #[width(2)]
    carry: Optional<Register<Word>>,
    /// the segment above owes one
    #[when(plan.has_higher())]
    borrow: Optional<Register<bool>>,
    #[when(plan.has_higher())]
    #[width(plan.upper_bits().max(1))]
    count_above: Optional<Local<Word>>,
    #[each(upper in plan.upper().iter())]
    #[is(Accumulator::build(upper))]
    upper: Vec<Accumulator>,
    plan: Plan<AccumulatorPlan>,
}

#[derive(Debug, Clone)]
struct AccumulatorPlan {
    /// This segment and those above it.
    segments: CountSegments,
    /// Bits of what it adds in a clock, signed.
    addend_bits: usize,
    has_lower: bool,
}

impl AccumulatorPlan {
    fn has_higher(&self) -> bool {
        self.segments.count > 1
    }

    /// Bits of this segment.
    fn bits(&self) -> usize {
        match self.has_higher() {
            true => self.segments.lower_bits as usize,
            false => self.segments.top_bits as usize,
        }
    }

    fn whole_bits(&self) -> usize {
        self.segments.bits() as usize
    }

    fn difference_bits(&self) -> usize {
        self.bits() + usize::from(self.has_higher())
    }

    fn upper_bits(&self) -> usize {
        self.whole_bits() - self.bits()
    }

    fn upper_segments(&self) -> usize {
        self.segments.count as usize - 1
    }

    /// The segments above it.
    fn upper(&self) -> Option<AccumulatorPlan> {
        self.has_higher().then(|| AccumulatorPlan {
            segments: CountSegments { count: self.segments.count - 1, ..self.segments },
            addend_bits: 2,
            has_lower: true,
        })
    }
}

impl Accumulator {
    /// A total that adds `addend_bits` signed bits a clock.
    pub fn new(segments: CountSegments, addend_bits: usize) -> Accumulator {
        Accumulator::build(&AccumulatorPlan { segments, addend_bits, has_lower: false })
    }
}

fn describe(plan: &AccumulatorPlan) -> About {
    let about = About::new(
        "accumulator",
        "a running total and its growth per phase step",
    )
    .note(
        "The total is never cleared: a step's count is the difference of two totals, which keeps \
         multiplexers out of the carry chain, and wrapping does no harm to a difference.",
    )
    .fact("Latency", "1 clock to the total, 1 more to o_count");
    if plan.has_lower || plan.has_higher() {
        about.note(
            "It is a segment of a wider total: carry and borrow reach the next segment one clock \
             later, and so does i_dump.",
        )
    } else {
        about
    }
}

#[kernel]
impl Logic for Accumulator {
    fn update(&mut self) {
        dff_setup!(self, i_clk, total, base, count);
        if self.plan.has_higher() {
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
        if self.i_dump.val().get_bit(0) {
            self.base.d.next = self.total.q.val();
            if self.plan.has_lower {
                self.growth.d.next = self.difference.val();
            } else {
                self.count.d.next = bit_cast(self.difference.val(), self.plan.bits());
                if self.plan.has_higher() {
                    self.borrow.d.next = self.difference.val().get_bit(self.plan.bits());
                }
            }
        }
        if self.plan.has_higher() {
            self.hand_on();
        } else {
            self.o_count.next = self.count.q.val();
        }
    }

    fn add_and_carry(&mut self) {
        dff_setup!(self, i_clk, carry, borrow);
        let bits = self.plan.bits();
        self.grown.next = bit_cast(self.total.q.val(), bits + 2) + signed_cast(self.i_addend.val());
        self.total.d.next = bit_cast(self.grown.val(), bits);
        self.carry.d.next = bit_cast(false, 2)
            .replace_bit(0, self.grown.val().get_bit(bits))
            .replace_bit(1, self.grown.val().get_bit(bits + 1));
    }

    fn pay_borrow(&mut self) {
        dff_setup!(self, i_clk, growth);
        self.settled.next =
            self.growth.q.val() - bit_cast(self.i_borrow.val(), self.plan.difference_bits());
        self.count.d.next = bit_cast(self.settled.val(), self.plan.bits());
        if self.plan.has_higher() {
            self.borrow.d.next = self.settled.val().get_bit(self.plan.bits());
        }
    }

    /// The segments above, each a clock behind the one below it.
    fn hand_on(&mut self) {
        let bits = self.plan.whole_bits();
        self.upper[0].i_clk.next = self.i_clk.val();
        self.upper[0].i_rst.next = self.i_rst.val();
        self.upper[0].i_addend.next = self.carry.q.val();
        self.upper[0].i_borrow.next = self.borrow.q.val();
        self.upper[0].i_dump.next = bit_cast(self.i_dump.val() >> 1, self.plan.upper_segments());
        self.count_above.next = self.upper[0].o_count.val();
        self.o_count.next = bit_cast(self.count.q.val(), bits)
            | (bit_cast(self.count_above.val(), bits) << self.plan.bits());
    }
}
