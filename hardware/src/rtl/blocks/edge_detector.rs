//! Hits: rising edges of the sampled SPAD level.
//!
//! What counts the hits later sees half as many places as there are samples.
//!
//! Cost (ECP5, docs/resources.md): 4 LUTs, 9 flip-flops.

use crate::rtl::front::prelude::*;

#[block(edge_detector)]
/// one hit per rising edge of {if cells > 1 { "each cell's level" } else { "the SPAD's level" }}
///
/// Of two neighbouring samples at most one is a rising edge, and it is the earlier one exactly when that
/// sample is high: two bits say all about a pair. The last sample of a word is kept outside scans too,
/// so that a pulse that began before a scan does not count in it.
///
/// - Latency: 1 clock
pub struct EdgeDetector {
    lanes: usize,
    /// Levels, each with edges of its own.
    cells: usize,
    #[set(lanes * cells)]
    samples: usize,
    #[set(cells * lanes.div_ceil(2))]
    pair_count: usize,
    /// Whether there is a pair, and not a single sample.
    #[set(lanes > 1)]
    has_pairs: bool,
    /// {if cells > 1 { "level of each cell, bit 0 earliest, cell 0 lowest" } else { "level of the SPAD, bit 0 earliest" }}
    #[width(samples)]
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
    /// each sample's level one sample earlier
    #[when(cells > 1)]
    #[width(samples)]
    earlier_level: Optional<Local<Word>>,
    #[width(samples)]
    rising: Local<Word>,
    #[width(pair_count)]
    pairs: Local<Word>,
    #[when(has_pairs)]
    #[width(pair_count)]
    earlier: Optional<Local<Word>>,
    /// of the word before
    #[when(cells == 1)]
    last_sample: Optional<Register<bool>>,
    /// of the word before, of each cell
    #[when(cells > 1)]
    #[width(cells)]
    last_samples: Optional<Register<Word>>,
    #[width(pair_count)]
    hits: Register<Word>,
    #[when(has_pairs)]
    #[width(pair_count)]
    early: Optional<Register<Word>>,
}

#[kernel]
impl Logic for EdgeDetector {
    fn update(&mut self) {
        if self.last_sample.is_present() {
            self.last_sample.next = self.i_samples.val().get_bit(self.lanes - 1);
            self.rising.next = self.i_samples.val()
                & !((self.i_samples.val() << 1) | bit_cast(self.last_sample.val(), self.lanes))
                & signed_cast(self.i_run.val());
        } else {
            self.find_edges_of_cells();
        }
        self.pairs.next = gather(self.pair_count, |pair| {
            if self.has_pairs {
                self.rising.val().get_bit(2 * pair) | self.rising.val().get_bit(2 * pair + 1)
            } else {
                self.rising.val().get_bit(pair)
            }
        });
        self.hits.next = self.pairs.val();
        self.o_hits.next = self.hits.val();
        if self.early.is_present() {
            self.earlier.next =
                gather(self.pair_count, |pair| self.i_samples.val().get_bit(2 * pair));
            self.early.next = self.earlier.val();
            self.o_early.next = self.early.val();
        }
    }

    fn find_edges_of_cells(&mut self) {
        let lanes = self.lanes;
        self.last_samples.next =
            gather(self.cells, |cell| self.i_samples.val().get_bit(lanes * cell + lanes - 1));
        self.earlier_level.next = gather(self.samples, |sample| {
            if sample % lanes == 0 {
                self.last_samples.val().get_bit(sample / lanes)
            } else {
                self.i_samples.val().get_bit(sample - 1)
            }
        });
        self.rising.next =
            self.i_samples.val() & !self.earlier_level.val() & signed_cast(self.i_run.val());
    }
}
