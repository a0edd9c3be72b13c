//! Whether a histogram's memories fit into the target's block RAM.

use std::fmt::Write as _;
use std::slice;

use super::histogram::HistogramPlan;
use crate::scene::FpgaTarget;

/// Block RAM of a device: so many blocks, each of which can be one of these memories.
#[derive(Debug, Clone, Copy)]
pub struct BlockRam {
    /// What a block is called.
    pub name: &'static str,
    /// Blocks of the device.
    pub blocks: u64,
    /// Words and bits of a word that a block can have, one port writing, one reading, the
    /// deepest first.
    shapes: &'static [(u64, u32)],
    joining: Joining,
}

/// How a memory is made of several blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Joining {
    /// Beside one another only, each with all words, where blocks have so many: those that
    /// `ECP5_BLOCK_RAM` makes have no choice between two behind them.
    SideBySide,
    /// Beside and behind one another.
    Rectangle,
    /// So too, and 2, 4, 8 ... of the words can share one of the blocks', since each bit of a
    /// word is written by an enable of its own.
    Packed,
}

/// The device's block RAM: Lattice FPGA-DS-02012 (ECP5, 56 blocks of 18 kbit), DS1040
/// (iCE40 HX8K, 32 of 4 kbit), AMD DS180 and UG473 (XC7A35T, 100 halves of 18 kbit).
pub const fn block_ram(target: FpgaTarget) -> BlockRam {
    match target {
        FpgaTarget::Ecp525k6 => BlockRam {
            name: "DP16KD",
            blocks: 56,
            shapes: &[(16_384, 1), (8192, 2), (4096, 4), (2048, 9), (1024, 18)],
            joining: Joining::SideBySide,
        },
        FpgaTarget::Ice40Hx8k => BlockRam {
            name: "SB_RAM40_4K",
            blocks: 32,
            shapes: &[(2048, 2), (1024, 4), (512, 8), (256, 16)],
            joining: Joining::Packed,
        },
        FpgaTarget::Xc7 => BlockRam {
            name: "RAMB18E1",
            blocks: 100,
            shapes: &[(16_384, 1), (8192, 2), (4096, 4), (2048, 9), (1024, 18), (512, 36)],
            joining: Joining::Rectangle,
        },
    }
}

impl BlockRam {
    /// The same kind of block in another device, which has so many of them by this name.
    #[must_use]
    pub const fn of_device(self, name: &'static str, blocks: u64) -> BlockRam {
        BlockRam { name, blocks, ..self }
    }

    /// Blocks of a memory of so many words.
    pub fn blocks_of(&self, words: u64, bits: u32) -> u64 {
        let widest = self.shapes.iter().rev().find(|&&(deep, _)| deep >= words);
        let shapes = match widest.filter(|_| self.joining == Joining::SideBySide) {
            Some(shape) => slice::from_ref(shape),
            None => self.shapes,
        };
        // So many of the words share one of the blocks'.
        let shares: &[u64] = match self.joining {
            Joining::Packed => &[1, 2, 4, 8, 16],
            Joining::SideBySide | Joining::Rectangle => &[1],
        };
        let blocks = shapes.iter().flat_map(|&(deep, wide)| {
            shares.iter().map(move |share| {
                let shared_bits = u64::from(bits) * share;
                words.div_ceil(deep * share) * shared_bits.div_ceil(u64::from(wide))
            })
        });
        blocks.min().unwrap_or(u64::MAX)
    }

    /// Blocks of the histograms of so many detectors: for each sample of the chip a memory,
    /// or two.
    pub fn blocks_of_histograms(&self, plan: &HistogramPlan, detectors: usize) -> u64 {
        let memories = u64::from(plan.buffers) * u64::from(plan.row_bins) * detectors as u64;
        memories * self.blocks_of(plan.rows, plan.bin_bits)
    }

    /// What would fit, in words.
    pub fn advice(&self, plan: &HistogramPlan, detectors: usize) -> String {
        let mut advice = String::new();
        let fits = |plan: &HistogramPlan| self.blocks_of_histograms(plan, detectors) <= self.blocks;
        let single = HistogramPlan { buffers: 1, ..*plan };
        if plan.takes_turns() && detectors == 1 && fits(&single) {
            advice.push_str("buffers = 1, ");
        }
        let narrower =
            (2..plan.bin_bits).rev().find(|&bin_bits| fits(&HistogramPlan { bin_bits, ..*plan }));
        if let Some(bits) = narrower {
            let _ = write!(advice, "counter_width = {bits}, ");
        }
        let fewer = |samples: u32| HistogramPlan { row_bins: samples, ..*plan };
        let samples = (0..plan.row_bins.ilog2()).rev().map(|log2| 1 << log2);
        if let Some(samples) = samples.into_iter().find(|&samples| fits(&fewer(samples))) {
            let _ = write!(advice, "samples_per_chip = {samples}, ");
        }
        advice + "a shorter code, or another target"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_those_that_the_data_sheets_allow() {
        let ecp5 = block_ram(FpgaTarget::Ecp525k6);
        // 2,047 words: one block up to 9 bits, two up to 18.
        let blocks = [1, 4, 9, 10, 18, 19].map(|bits| ecp5.blocks_of(2047, bits));
        assert_eq!(blocks, [1, 1, 1, 2, 2, 3]);
        // 4,095: four bits each; 31: eighteen; 32,767: two rows of one bit.
        assert_eq!([4, 5, 18].map(|bits| ecp5.blocks_of(4095, bits)), [1, 2, 5]);
        assert_eq!([18, 19].map(|bits| ecp5.blocks_of(31, bits)), [1, 2]);
        assert_eq!(ecp5.blocks_of(32_767, 1), 2);
        let ice40 = block_ram(FpgaTarget::Ice40Hx8k);
        assert_eq!([1, 2, 3, 16].map(|bits| ice40.blocks_of(2047, bits)), [1, 1, 2, 8]);
        assert_eq!(ice40.blocks_of(31, 16), 1);
        // 8,191 words of three bits: four of them to a row of 2,048 words of twelve bits.
        assert_eq!(ice40.blocks_of(8191, 3), 6);
    }
}
