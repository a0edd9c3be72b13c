//! Correlators of some phase steps that share their light.
//!
//! | port | |
//! |---|---|
//! | `i_hits`, `i_early` | hits of a word, by pairs of samples |
//! | `i_window` | reference of each sample, for this bank's steps and all later ones |
//! | `i_dump` | the step's last hits are in, a bit for each segment |
//! | `o_count` | counts of the bank's steps |
//! | `o_hits`, `o_early`, `o_window`, `o_dump` | the same for the next bank, a clock later |
//!
//! Latency as the correlators'. A register for each bank keeps hits, reference and dump within
//! reach of four correlators, so that the clock does not fall as steps are added.
//!
//! Cost (ECP5, docs/resources.md): 217 LUTs, 241 flip-flops for three steps more at once.

use super::UpdownCorrelator;
use super::scan_controller::dump_about;
use crate::rtl::front::prelude::*;
use crate::sensor::interface::CountSegments;

/// Correlates one detector's hits with several delays of its reference, and
/// hands both on to the next bank.
#[block(BankPlan)]
pub struct CorrelatorBank {
    /// one word per cycle
    pub i_clk: Input<bool>,
    /// synchronous, active high
    pub i_rst: Input<bool>,
    /// pairs of samples with a hit
    #[width(plan.pairs())]
    pub i_hits: Input<Word>,
    /// the hit is the earlier sample of its pair
    #[when(plan.has_pairs())]
    #[width(plan.pairs())]
    pub i_early: Optional<Input<Word>>,
    /// reference of each sample; the last step's lowest
    #[width(plan.lanes + plan.rest - 1)]
    pub i_window: Input<Word>,
    /// A step's last hits are in; one bit for each segment of the count.
    #[about(dump_about(plan.segments.count))]
    #[width(plan.segments.count)]
    pub i_dump: Input<Word>,
    /// Counts of the bank's steps.
    #[each(step in 0..plan.steps)]
    #[about(format!("count of step {step}, signed"))]
    #[width(plan.segments.bits())]
    pub o_count: Vec<Output<Word>>,
    /// i_hits for the next bank
    #[when(plan.has_next())]
    #[width(plan.pairs())]
    pub o_hits: Optional<Output<Word>>,
    /// i_early for the next bank
    #[when(plan.has_next() && plan.has_pairs())]
    #[width(plan.pairs())]
    pub o_early: Optional<Output<Word>>,
    /// i_window for the next bank
    #[when(plan.has_next())]
    #[width(plan.next_bits())]
    pub o_window: Optional<Output<Word>>,
    /// i_dump for the next bank
    #[when(plan.has_next())]
    #[width(plan.segments.count)]
    pub o_dump: Optional<Output<Word>>,
    #[is(describe(plan))]
    about: About,
    #[each(_step in 0..plan.steps)]
    #[width(plan.lanes)]
    reference: Vec<Wiring>,
    #[each(_step in 0..plan.steps)]
    #[is(UpdownCorrelator::new(plan.lanes as u32, plan.segments))]
    correlator: Vec<UpdownCorrelator>,
    #[when(plan.has_next())]
    #[width(plan.pairs())]
    hits: Optional<Register<Word>>,
    #[when(plan.has_next() && plan.has_pairs())]
    #[width(plan.pairs())]
    early: Optional<Register<Word>>,
    #[when(plan.has_next())]
    #[width(plan.next_bits())]
    window: Optional<Register<Word>>,
    #[when(plan.has_next())]
    #[width(plan.segments.count)]
    dump: Optional<Register<Word>>,
    plan: Plan<BankPlan>,
}

#[derive(Debug, Clone)]
struct BankPlan {
    lanes: usize,
    segments: CountSegments,
    steps: usize,
    rest: usize,
}

impl BankPlan {
    fn pairs(&self) -> usize {
        self.lanes.div_ceil(2)
    }

    fn has_pairs(&self) -> bool {
        self.lanes > 1
    }

    fn has_next(&self) -> bool {
        self.rest > self.steps
    }

    /// Samples of the reference that the next bank needs.
    fn next_bits(&self) -> usize {
        self.lanes + self.rest - 1 - self.steps
    }
}

impl CorrelatorBank {
    /// The first `steps` of the `rest` steps that this bank and those after it
    /// have.
    pub fn new(lanes: u32, segments: CountSegments, steps: u32, rest: u32) -> CorrelatorBank {
        CorrelatorBank::build(&BankPlan {
            lanes: lanes as usize,
            segments,
            steps: steps as usize,
            rest: rest as usize,
        })
    }
}

fn describe(plan: &BankPlan) -> About {
    let steps = plan.steps;
    let about = About::new(
        "correlator_bank",
        &format!("correlators of {steps} phase steps that share their light"),
    )
    .note("Each step takes the reference a sample later than the step before it.");
    if plan.has_next() {
        about.note(
            "The next bank works a clock behind this one, so that no register has to reach all \
             correlators within a clock.",
        )
    } else {
        about
    }
}

#[kernel]
impl Logic for CorrelatorBank {
    fn update(&mut self) {
        let last = self.plan.rest - 1;
        for q in 0..self.plan.steps {
            for l in 0..self.plan.lanes {
                self.reference[q].i[l].next = self.i_window.val().get_bit(l + last - q);
            }
        }
        for q in 0..self.plan.steps {
            self.correlator[q].i_clk.next = self.i_clk.val();
            self.correlator[q].i_rst.next = self.i_rst.val();
            self.correlator[q].i_hits.next = self.i_hits.val();
            if self.i_early.is_present() {
                self.correlator[q].i_early.next = self.i_early.val();
            }
            self.correlator[q].i_reference.next = self.reference[q].o.val();
            self.correlator[q].i_dump.next = self.i_dump.val();
            self.o_count[q].next = self.correlator[q].o_count.val();
        }
        if self.plan.has_next() {
            self.hand_on();
        }
    }

    /// What the next bank gets.
    fn hand_on(&mut self) {
        dff_setup!(self, i_clk, hits, window, dump);
        self.hits.d.next = self.i_hits.val();
        self.window.d.next = bit_cast(self.i_window.val(), self.plan.next_bits());
        self.dump.d.next = self.i_dump.val();
        self.o_hits.next = self.hits.q.val();
        self.o_window.next = self.window.q.val();
        self.o_dump.next = self.dump.q.val();
        if self.o_early.is_present() {
            dff_setup!(self, i_clk, early);
            self.early.d.next = self.i_early.val();
            self.o_early.next = self.early.q.val();
        }
    }
}
