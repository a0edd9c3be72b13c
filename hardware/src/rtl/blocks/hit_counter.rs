//! Counts hits, whatever their sign.
//!
//! | port | |
//! |---|---|
//! | `i_hits` | hits of a word, by pairs of samples |
//! | `i_dump` | the step's last hits are in, a bit for each segment |
//! | `o_total`, `o_clamped` | hits of the last step; there were more |
//!
//! Latency as the correlators', whose dump it takes. One for all steps of a group, which see the
//! same light, in place of one for each.
//!
//! Cost (ECP5, docs/resources.md): 32 LUTs, 66 flip-flops.

use super::scan_controller::dump_about;
use super::{Accumulator, QuadCounter, SegmentedTotal};
use crate::rtl::front::prelude::*;
use crate::sensor::interface::{CountSegments, TotalCount};

/// Total counts of one phase step after another: hits up and down together.
#[block(HitPlan)]
pub struct HitCounter {
    /// pairs of samples with a hit
    #[width(plan.pairs())]
    pub i_hits: Input<Word>,
    /// A step's last hits are in; one bit for each segment of the total.
    #[about(dump_about(plan.segments.count))]
    #[width(plan.segments.count)]
    pub i_dump: Input<Word>,
    /// hits of the last step, unsigned
    #[width(plan.total.bits)]
    pub o_total: Output<Word>,
    /// there were more than o_total can hold
    #[when(plan.total.saturates())]
    pub o_clamped: Optional<Output<bool>>,
    #[is(describe(plan))]
    about: About,
    /// pairs with a hit
    #[width(plan.pairs())]
    hit: Register<Word>,
    #[each(_quad in 0..plan.quads())]
    #[width(4)]
    hit_of_quad: Vec<Wiring>,
    #[each(_quad in 0..plan.quads())]
    #[is(QuadCounter::new())]
    quad: Vec<QuadCounter>,
    #[when(plan.pairs() == 2 || plan.quads() == 2)]
    #[about(format!("hits in samples 0 to {}", plan.lanes - 1))]
    #[width(plan.addend_bits())]
    sum: Optional<Register<Word>>,
    /// hits of one word
    #[width(plan.addend_bits())]
    addend: Local<Word>,
    #[when(plan.segments.count == 1)]
    #[is(Accumulator::new(plan.segments.top_bits, plan.addend_bits()))]
    total: Optional<Accumulator>,
    #[each(_total in 0..usize::from(plan.segments.count > 1))]
    #[is(SegmentedTotal::new(plan.segments, plan.addend_bits()))]
    segmented: Vec<SegmentedTotal>,
    /// hits of the last step, all of them
    #[width(plan.exact_bits())]
    exact: Local<Word>,
    plan: Plan<HitPlan>,
}

#[derive(Debug, Clone)]
struct HitPlan {
    lanes: usize,
    total: TotalCount,
    segments: CountSegments,
}

impl HitPlan {
    fn pairs(&self) -> usize {
        self.lanes.div_ceil(2)
    }

    fn quads(&self) -> usize {
        self.pairs() / 4
    }

    fn levels(&self) -> usize {
        self.pairs().ilog2() as usize
    }

    /// Up to `pairs` hits, and a bit that stays 0, as the total takes a signed
    /// addend.
    fn addend_bits(&self) -> usize {
        self.levels() + 2
    }

    fn exact_bits(&self) -> usize {
        self.total.exact_bits as usize
    }

    fn total_bits(&self) -> usize {
        self.total.bits as usize
    }
}

impl HitCounter {
    /// For `lanes` samples per word; `count_segments` are the signed count's.
    pub fn new(lanes: u32, total: TotalCount, count_segments: CountSegments) -> HitCounter {
        HitCounter::build(&HitPlan {
            lanes: lanes as usize,
            total,
            segments: count_segments.of_total(total),
        })
    }
}

fn describe(plan: &HitPlan) -> About {
    let clocks = plan.levels() + 2 + plan.segments.clocks() as usize;
    let about = About::new("hit_counter", "hits of a phase step, up and down together")
        .note(
            "All steps of a group see the same light, so one counter serves them all. It keeps \
             time with their correlators and takes the same i_dump; its first registers hold what \
             theirs do, and a synthesizer that looks across modules makes one of both.",
        )
        .fact("Latency", format!("{clocks} clocks from i_hits to o_total"));
    if plan.total.saturates() {
        about.note("A total of more bits than o_total has shows as all ones.")
    } else {
        about
    }
}

#[kernel]
impl Logic for HitCounter {
    fn update(&mut self) {
        self.hit.d.next = self.i_hits.val();
        self.count_word();
        if self.total.is_present() {
            self.total.i_addend.next = self.addend.val();
            self.total.i_dump.next = self.i_dump.val().get_bit(0);
            self.exact.next = self.total.o_count.val();
        }
        for t in 0..self.segmented.len() {
            self.segmented[t].i_addend.next = self.addend.val();
            self.segmented[t].i_dump.next = self.i_dump.val();
            self.exact.next = self.segmented[t].o_count.val();
        }
        if self.o_clamped.is_present() {
            let bits = self.plan.total_bits();
            self.o_clamped.next =
                bit_cast(bit_cast(self.exact.val(), bits), self.plan.exact_bits())
                    != self.exact.val();
            self.o_total.next =
                bit_cast(self.exact.val(), bits) | signed_cast(self.o_clamped.val());
        } else {
            self.o_total.next = self.exact.val();
        }
    }

    /// The hits of a word.
    fn count_word(&mut self) {
        for q in 0..self.plan.quads() {
            for j in 0..4 {
                self.hit_of_quad[q].i[j].next = self.hit.q.val().get_bit(4 * q + j);
            }
            self.quad[q].i_hit.next = self.hit_of_quad[q].o.val();
            self.quad[q].i_down.next = bit_cast(false, 4);
        }
        if self.plan.quads() == 1 {
            self.addend.next = self.quad[0].o_sum.val();
        } else if self.plan.quads() == 2 {
            self.sum.d.next = (signed_cast(self.quad[0].o_sum.val())
                + signed_cast(self.quad[1].o_sum.val()))
            .into();
            self.addend.next = self.sum.q.val();
        } else if self.plan.pairs() == 2 {
            self.sum.d.next = bit_cast(self.hit.q.val().get_bit(0), self.plan.addend_bits())
                + bit_cast(self.hit.q.val().get_bit(1), self.plan.addend_bits());
            self.addend.next = self.sum.q.val();
        } else {
            self.addend.next = bit_cast(self.hit.q.val(), self.plan.addend_bits());
        }
    }
}
