//! The hardware that counts hits by their time in the code period, as seen from outside.

use crate::scan::Timing;
use crate::scene::{Detector, JitterTail, Scene};

/// Standard deviations of jitter that no detection is taken to be off by.
const MOST_SIGMAS: f64 = 6.0;

/// A histogram of arrival times: a bin for each sample of the code period, a row of bins
/// for each of its chips. A frame is what one histogram counts.
///
/// In the first code period of a frame counts begin anew, so that nothing has to be
/// cleared. Two memories take turns, one counts while the other is read; or there is one, and
/// a frame's rows leave it while the next frame's first code period is counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HistogramPlan {
    /// Rows: chips of the code period, L'.
    pub rows: u64,
    /// Code periods of a frame.
    pub periods: u64,
    /// Bins of a row: samples per chip, S.
    pub row_bins: u32,
    /// Bits of a bin; fewer than `exact_bits` means that it saturates.
    pub bin_bits: u32,
    /// Bits of a bin that nothing can overflow: a sample is at most one rising edge in
    /// each code period.
    pub exact_bits: u32,
    /// Neighbouring samples of a word that share an adder, because at most one of them
    /// can be a hit: two always, since a rising edge needs a low sample; more where the
    /// dead time says so. Of several hits among them the earliest counts.
    pub adder_samples: u32,
    /// Memories of each detector: two, or one.
    pub buffers: u32,
}

/// Clocks from the one at which a frame's last word is on `i_samples` to the one at
/// whose rising edge the memories change places, if the one before has been read; from there
/// on the next frame begins anew in a single memory.
pub const CLOCKS_TO_TURN: u32 = 1;
/// Clocks from there to the first row on the stream: address, memory, its output register, the
/// register behind it, row.
pub const CLOCKS_TO_ROW: u32 = 4;
/// Clocks from a word to the flag of a bin that it found full: hits, memory, its output
/// register, the one behind it, bin, sum, flag.
pub const CLOCKS_TO_FLAG: u32 = 6;
/// Clocks from a word to its new bin in the memory.
pub const CLOCKS_TO_BIN: u32 = 7;
/// Fewest chips of a code period: a row's new counts are in the memory before the row is
/// read again.
pub const LEAST_ROWS: u64 = 8;
/// Most bits of a row on the stream.
pub const MOST_ROW_BITS: u32 = 128;

impl HistogramPlan {
    /// The histogram of a scene, whose integration time is whole code periods.
    pub(super) fn of(scene: &Scene, timing: &Timing) -> HistogramPlan {
        let rows = timing.code_chips();
        let periods = (timing.scan.integration_chips / rows).max(1);
        let exact_bits = u64::BITS - periods.leading_zeros();
        let samples = scene.samples_per_chip;
        let apart = scene
            .detectors
            .iter()
            .map(|detector| samples_apart(detector, timing.clock.sample_period_ps()))
            .fold(f64::INFINITY, f64::min);
        let mut adder_samples = samples.min(2);
        while adder_samples < samples && f64::from(2 * adder_samples) <= apart {
            adder_samples *= 2;
        }
        HistogramPlan {
            rows,
            periods,
            row_bins: samples,
            bin_bits: scene.hardware.counter_width.map_or(exact_bits, |bits| bits.min(exact_bits)),
            exact_bits,
            adder_samples,
            buffers: scene.hardware.buffers,
        }
    }

    /// Whether two memories take turns.
    pub fn takes_turns(&self) -> bool {
        self.buffers == 2
    }

    /// Whether bins can saturate.
    pub fn saturates(&self) -> bool {
        self.bin_bits < self.exact_bits
    }

    /// Bits of a bin on the stream: whole bytes.
    pub fn bin_data_bits(&self) -> u32 {
        self.bin_bits.div_ceil(8) * 8
    }

    /// Bits of a row on the stream.
    pub fn row_data_bits(&self) -> u32 {
        self.row_bins * self.bin_data_bits()
    }

    /// Bins of a histogram, one for each phase step.
    pub fn bins(&self) -> u64 {
        self.rows * u64::from(self.row_bins)
    }

    /// Groups of samples that share an adder.
    pub fn adders(&self) -> u32 {
        self.row_bins / self.adder_samples
    }

    /// Clocks from the one at which a frame's last word is on `i_samples` to the one
    /// after which its first row shows.
    pub fn latency_clocks(&self) -> u32 {
        CLOCKS_TO_TURN + CLOCKS_TO_ROW
    }

    /// Bits of memory for so many detectors.
    pub fn memory_bits(&self, detectors: usize) -> u128 {
        let histograms = u128::from(self.buffers) * detectors as u128;
        histograms * u128::from(self.bins()) * u128::from(self.bin_bits)
    }
}

/// Samples between two hits of a detector, at least.
fn samples_apart(detector: &Detector, sample_period_ps: f64) -> f64 {
    // Another cell may fire at once.
    if detector.jitter_tail != JitterTail::None || detector.cells > 1 {
        return 0.0;
    }
    let least_ps = detector.dead_time_ps - 2.0 * MOST_SIGMAS * detector.jitter_std_ps();
    least_ps / sample_period_ps
}
