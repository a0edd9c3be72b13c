//! Hits: rising edges of the sampled SPAD level.
//!
//! | port | |
//! |---|---|
//! | `i_samples`, `i_run` | a word of samples; it belongs to a scan |
//! | `o_hits`, `o_early` | pairs with a hit; it is the earlier sample |
//!
//! Latency 1 clock. Two neighbouring samples hold at most one rising edge, so that two bits say
//! all about a pair: what counts the hits later sees half as many places as there are samples.
//!
//! Cost (ECP5, docs/resources.md): 4 LUTs, 9 flip-flops.

use crate::rtl::front::prelude::*;
use crate::scene::Polarity;

/// Marks every pair of samples that holds a rising edge, and says which.
#[block(EdgePlan)]
pub struct EdgeDetector {
    /// level of the SPAD, bit 0 earliest
    #[width(plan.lanes)]
    pub i_samples: Input<Word>,
    /// the word belongs to a scan
    pub i_run: Input<bool>,
    /// pairs of samples with a high one after a low one
    #[width(plan.pairs())]
    pub o_hits: Output<Word>,
    /// the hit is the earlier sample of its pair
    #[when(plan.has_pairs())]
    #[width(plan.pairs())]
    pub o_early: Optional<Output<Word>>,
    #[is(describe())]
    about: About,
    /// the samples the other way up: high during a pulse
    #[when(plan.inverts)]
    #[width(plan.lanes)]
    inverted: Optional<Local<Word>>,
    #[width(plan.lanes)]
    level: Wiring,
    #[width(plan.lanes)]
    rising: Local<Word>,
    #[width(plan.pairs())]
    pairs: Wiring,
    #[when(plan.has_pairs())]
    #[width(plan.pairs())]
    earlier: Optional<Wiring>,
    /// of the word before
    last_sample: Register<bool>,
    #[width(plan.pairs())]
    hits: Register<Word>,
    #[when(plan.has_pairs())]
    #[width(plan.pairs())]
    early: Optional<Register<Word>>,
    plan: Plan<EdgePlan>,
}

#[derive(Debug, Clone)]
struct EdgePlan {
    lanes: usize,
    /// A pulse is low.
    inverts: bool,
}

impl EdgePlan {
    fn pairs(&self) -> usize {
        self.lanes.div_ceil(2)
    }

    /// Whether there is a pair, and not a single sample.
    fn has_pairs(&self) -> bool {
        self.lanes > 1
    }
}

impl EdgeDetector {
    /// For words of `lanes` samples, which have this polarity.
    pub fn new(lanes: u32, polarity: Polarity) -> EdgeDetector {
        let inverts = polarity == Polarity::Low;
        EdgeDetector::build(&EdgePlan { lanes: lanes as usize, inverts })
    }
}

fn describe() -> About {
    About::new(
        "edge_detector",
        "one hit per rising edge of the SPAD's level",
    )
    .note(
        "Of two neighbouring samples at most one is a rising edge, and it is the earlier one \
         exactly when that sample is high: two bits say all about a pair.",
    )
    .note(
        "The last sample of a word is kept outside scans too, so that a pulse that began before \
         a scan is no hit of it.",
    )
    .fact("Latency", "1 clock")
}

#[kernel]
impl Logic for EdgeDetector {
    fn update(&mut self) {
        if self.plan.inverts {
            self.inverted.next = !self.i_samples.val();
            for l in 0..self.plan.lanes {
                self.level.i[l].next = self.inverted.val().get_bit(l);
            }
        } else {
            for l in 0..self.plan.lanes {
                self.level.i[l].next = self.i_samples.val().get_bit(l);
            }
        }
        self.last_sample.d.next = self.level.o.val().get_bit(self.plan.lanes - 1);
        self.rising.next = self.level.o.val()
            & !((self.level.o.val() << 1) | bit_cast(self.last_sample.q.val(), self.plan.lanes))
            & signed_cast(self.i_run.val());
        if self.plan.has_pairs() {
            for j in 0..self.plan.pairs() {
                self.pairs.i[j].next =
                    self.rising.val().get_bit(2 * j) | self.rising.val().get_bit(2 * j + 1);
                self.earlier.i[j].next = self.level.o.val().get_bit(2 * j);
            }
        } else {
            self.pairs.i[0].next = self.rising.val().get_bit(0);
        }
        self.hits.d.next = self.pairs.o.val();
        self.o_hits.next = self.hits.q.val();
        if self.early.is_present() {
            self.early.d.next = self.earlier.o.val();
            self.o_early.next = self.early.q.val();
        }
    }
}
