//! Compares some bits of two counts.
//!
//! | port | |
//! |---|---|
//! | `i_count`, `i_other`, `i_below` | bits of two counts, and what those below say |
//! | `o_greater` | the first is greater by the bits so far |
//!
//! Latency 1 clock. The result of the bits below enters as one more bit of the comparison, so
//! that a piece needs a single carry chain and no test for equality.

use crate::rtl::front::prelude::*;

/// Whether a count is greater than another by some of its bits, or where they
/// are equal by those below.
#[block(PiecePlan)]
pub struct CountPiece {
    /// bits of a count
    #[width(plan.bits)]
    pub i_count: Input<Word>,
    /// bits of what it is compared with
    #[width(plan.bits)]
    pub i_other: Input<Word>,
    /// the count is greater by the bits below
    pub i_below: Input<bool>,
    /// the count was greater by the bits so far
    pub o_greater: Output<bool>,
    #[is(describe(plan.bits))]
    about: About,
    greater: Register<bool>,
    plan: Plan<PiecePlan>,
}

#[derive(Debug, Clone)]
struct PiecePlan {
    bits: usize,
}

impl CountPiece {
    /// For `bits` bits, compared as unsigned.
    pub fn new(bits: u32) -> CountPiece {
        CountPiece::build(&PiecePlan { bits: bits as usize })
    }
}

fn describe(bits: usize) -> About {
    About::new("count_piece", "whether some bits of a count are greater")
        .size(("BITS", "bits of a piece"), bits, 1..=usize::MAX, |bits| {
            CountPiece::build(&PiecePlan { bits })
        })
        .note(
            "What the bits below say joins the comparison as a bit under the lowest, which \
             decides where all others are equal.",
        )
        .fact("Latency", "1 clock")
}

#[kernel]
impl Logic for CountPiece {
    fn update(&mut self) {
        let bits = self.plan.bits + 1;
        self.greater.d.next = (bit_cast(self.i_other.val(), bits) << 1)
            < (bit_cast(self.i_count.val(), bits) << 1).replace_bit(0, self.i_below.val());
        self.o_greater.next = self.greater.q.val();
    }
}
