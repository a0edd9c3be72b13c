//! Hits: rising edges of the sampled SPAD level.
//!
//! What counts the hits later sees half as many places as there are samples.
//!
//! Cost (ECP5, docs/resources.md): 4 LUTs, 9 flip-flops.

use crate::rtl::front::prelude::*;
use crate::scene::Polarity;

#[block(edge_detector)]
/// one hit per rising edge of the SPAD's level
///
/// Of two neighbouring samples at most one is a rising edge, and it is the earlier one exactly when that
/// sample is high: two bits say all about a pair.
///
/// The last sample of a word is kept outside scans too, so that a pulse that began before a scan is no
/// hit of it.
///
/// - Latency: 1 clock
pub struct EdgeDetector {
    lanes: usize,
    /// A pulse is low.
    polarity: Polarity,
    #[set(polarity == Polarity::Low)]
    inverts: bool,
    #[set(lanes.div_ceil(2))]
    pair_count: usize,
    /// Whether there is a pair, and not a single sample.
    #[set(lanes > 1)]
    has_pairs: bool,
    /// level of the SPAD, bit 0 earliest
    #[width(lanes)]
    pub i_samples: Input<Word>,
    /// the word belongs to a scan
    pub i_run: Input<bool>,
    /// pairs of samples with a high one after a low one
    #[width(pair_count)]
    pub o_hits: Output<Word>,
    /// the hit is the earlier sample of its pair
    #[when(has_pairs)]
    #[width(pair_count)]
    pub o_early: Optional<Output<Word>>,
    /// the samples the other way up: high during a pulse
    #[when(inverts)]
    #[width(lanes)]
    inverted: Optional<Local<Word>>,
    #[width(lanes)]
    level: Local<Word>,
    #[width(lanes)]
    rising: Local<Word>,
    #[width(pair_count)]
    pairs: Local<Word>,
    #[when(has_pairs)]
    #[width(pair_count)]
    earlier: Optional<Local<Word>>,
    /// of the word before
    last_sample: Register<bool>,
    #[width(pair_count)]
    hits: Register<Word>,
    #[when(has_pairs)]
    #[width(pair_count)]
    early: Optional<Register<Word>>,
}

#[kernel]
impl Logic for EdgeDetector {
    fn update(&mut self) {
        if self.inverts {
            self.inverted.next = !self.i_samples.val();
            self.level.next = self.inverted.val();
        } else {
            self.level.next = self.i_samples.val();
        }
        self.last_sample.next = self.level.val().get_bit(self.lanes - 1);
        self.rising.next = self.level.val()
            & !((self.level.val() << 1) | bit_cast(self.last_sample.val(), self.lanes))
            & signed_cast(self.i_run.val());
        self.pairs.next = gather(self.pair_count, |pair| {
            if self.has_pairs {
                self.rising.val().get_bit(2 * pair) | self.rising.val().get_bit(2 * pair + 1)
            } else {
                self.rising.val().get_bit(0)
            }
        });
        self.hits.next = self.pairs.val();
        self.o_hits.next = self.hits.val();
        if self.early.is_present() {
            self.earlier.next = gather(self.pair_count, |pair| self.level.val().get_bit(2 * pair));
            self.early.next = self.earlier.val();
            self.o_early.next = self.early.val();
        }
    }
}
