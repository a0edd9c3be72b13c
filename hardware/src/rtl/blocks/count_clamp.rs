//! Clamps a count to fewer bits.
//!
//! | port | |
//! |---|---|
//! | `i_count` | the exact count |
//! | `o_count`, `o_clamped` | the nearest that fits; it is another |
//!
//! Latency 0 clocks. The count fits if its low bits extend to it, one comparison in place of two
//! with the largest and the smallest.
//!
//! Cost (ECP5, docs/resources.md): 15 LUTs for 8 bits out of 17, which save 8 flip-flops.

use crate::rtl::front::prelude::*;

/// The nearest count that fits.
#[block(ClampPlan)]
pub struct CountClamp {
    /// exact count, signed
    #[width(plan.exact_bits)]
    pub i_count: Input<Word>,
    /// the nearest count that fits, signed
    #[width(plan.count_bits)]
    pub o_count: Output<Word>,
    /// it is not the exact one
    pub o_clamped: Output<bool>,
    #[is(describe())]
    about: About,
    #[width(plan.count_bits)]
    #[value((1 << (plan.count_bits - 1)) - 1)]
    largest: Constant,
    #[width(plan.count_bits)]
    #[value(1 << (plan.count_bits - 1))]
    smallest: Constant,
    plan: Plan<ClampPlan>,
}

#[derive(Debug, Clone)]
struct ClampPlan {
    exact_bits: usize,
    count_bits: usize,
}

impl CountClamp {
    /// From `exact_bits` to `count_bits`, which are fewer.
    pub fn new(exact_bits: u32, count_bits: u32) -> CountClamp {
        CountClamp::build(&ClampPlan {
            exact_bits: exact_bits as usize,
            count_bits: count_bits as usize,
        })
    }
}

fn describe() -> About {
    About::new("count_clamp", "the nearest count of fewer bits").fact("Latency", "0 clocks")
}

#[kernel]
impl Logic for CountClamp {
    fn update(&mut self) {
        let sign = self.plan.exact_bits - 1;
        self.o_clamped.next = bit_cast(
            signed_cast(bit_cast(self.i_count.val(), self.plan.count_bits)),
            self.plan.exact_bits,
        ) != self.i_count.val();
        if !self.o_clamped.val() {
            self.o_count.next = bit_cast(self.i_count.val(), self.plan.count_bits);
        } else if self.i_count.val().get_bit(sign) {
            self.o_count.next = self.smallest.val();
        } else {
            self.o_count.next = self.largest.val();
        }
    }
}
