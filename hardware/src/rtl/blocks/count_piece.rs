//! Compares some bits of two counts.
//!
//! | port | |
//! |---|---|
//! | `i_count`, `i_other`, `i_below` | bits of two counts, and what those below say |
//! | `o_greater` | the first is greater by the bits so far |
//!
//! Latency 1 clock. The result of the bits below enters as one more bit of the difference, so
//! that a piece needs a single carry chain and no test for equality.

use crate::rtl::front::prelude::*;

/// Whether a count is greater than another by some of its bits, or where they
/// are equal by those below.
#[block(PiecePlan)]
pub struct CountPiece {
    /// one comparison per cycle
    pub i_clk: Input<bool>,
    /// synchronous, active high
    pub i_rst: Input<bool>,
    /// bits of a count
    #[width(plan.bits)]
    pub i_count: Input<Word>,
    /// bits of what it is compared with
    #[width(plan.bits)]
    pub i_other: Input<Word>,
    /// the count is greater by the bits below
    #[when(plan.has_below)]
    pub i_below: Optional<Input<bool>>,
    /// the count was greater by the bits so far
    pub o_greater: Output<bool>,
    #[is(describe(plan))]
    about: About,
    /// sign of the difference
    #[width(plan.difference_bits())]
    #[value(1 << (plan.difference_bits() - 1))]
    negative: Constant,
    /// the other one less the count, negative if the count is greater
    #[width(plan.difference_bits())]
    difference: Local<Word>,
    greater: Register<bool>,
    plan: Plan<PiecePlan>,
}

#[derive(Debug, Clone)]
struct PiecePlan {
    bits: usize,
    has_below: bool,
}

impl PiecePlan {
    fn difference_bits(&self) -> usize {
        self.bits + 1 + usize::from(self.has_below)
    }
}

impl CountPiece {
    /// For `bits` bits, compared as unsigned; `has_below` if there are others
    /// below them.
    pub fn new(bits: u32, has_below: bool) -> CountPiece {
        CountPiece::build(&PiecePlan { bits: bits as usize, has_below })
    }
}

fn describe(plan: &PiecePlan) -> About {
    let mut about = About::new("count_piece", "whether some bits of a count are greater");
    if plan.has_below {
        about = about.note(
            "The bits below join the difference as a bit under its lowest, which decides where \
             all others are equal.",
        );
    }
    about.fact("Latency", "1 clock")
}

#[kernel]
impl Logic for CountPiece {
    fn update(&mut self) {
        let bits = self.plan.difference_bits();
        dff_setup!(self, i_clk, greater);
        if self.i_below.is_present() {
            self.difference.next = (bit_cast(self.i_other.val(), bits) << 1)
                - (bit_cast(self.i_count.val(), bits) << 1).replace_bit(0, self.i_below.val());
        } else {
            self.difference.next =
                bit_cast(self.i_other.val(), bits) - bit_cast(self.i_count.val(), bits);
        }
        self.greater.d.next = (self.difference.val() & self.negative.val()).any();
        self.o_greater.next = self.greater.q.val();
    }
}
