//! Signed counts of all phase steps from one histogram.
//!
//! Step k = d S + b has the sign of chip i - d in the S bins from i S + b on, its slot i.
//! So all shifts d at one b are a periodic correlation of the slots' sums with the code:
//! S transforms of L' points for all L' S steps.

use std::sync::Arc;

use goldtof_fft::Fft;
use goldtof_fft::num_complex::Complex64;

use super::Histogram;
use crate::code::Code;

/// Slots' sums are transformed in digits of so many bits. A correlation of 2^18 of them (the
/// longest interleaved code) has rounding errors of some 10^-8, so that rounding to the
/// nearest integer is exact.
const DIGIT_BITS: u32 = 24;

/// Correlates histograms with a code.
///
/// ```
/// # mod goldtof {
/// #     pub use goldtof_sensor::*;
/// #     pub use goldtof_physics::*;
/// # }
/// # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
/// use std::path::Path;
///
/// use goldtof::histogram::Histogram;
/// use goldtof::histogram::correlation::HistogramCorrelator;
///
/// let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
/// let code = &scene.sources[goldtof::scene::SourceIndex(0)].code;
/// let samples = 8;
/// // Light that comes 5 samples after its chips begin, once in each sample of an on-chip.
/// let mut bins = vec![0; code.chips.len() * samples];
/// for a in 0..bins.len() {
///     bins[(a + 5) % (code.chips.len() * samples)] = u64::from(code.chips[a / samples]);
/// }
/// let counts = HistogramCorrelator::new(code, 8).signed_counts(&Histogram::new(bins, 8, 1)?);
/// let peak = (0..counts.len()).max_by_key(|&k| counts[k]);
/// assert_eq!(peak, Some(5));
/// assert_eq!(counts[5], 8 * code.weight() as i64);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone)]
pub struct HistogramCorrelator {
    samples_per_chip: usize,
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    /// Conjugate spectrum of the code's signs, over L'.
    code: Vec<Complex64>,
}

impl std::fmt::Debug for HistogramCorrelator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Correlator")
            .field("samples_per_chip", &self.samples_per_chip)
            .field("chips", &self.code.len())
            .finish()
    }
}

impl HistogramCorrelator {
    /// A correlator for bins of `samples_per_chip` per chip of the (interleaved) code.
    pub fn new(code: &Code, samples_per_chip: u32) -> HistogramCorrelator {
        let length = code.chips.len();
        let [forward, inverse] = goldtof_fft::pair(length);
        let sign = |&chip: &u8| Complex64::new(2.0 * f64::from(chip) - 1.0, 0.0);
        let mut spectrum: Vec<Complex64> = code.chips.iter().map(sign).collect();
        forward.process(&mut spectrum);
        let code = spectrum.iter().map(|s| s.conj() / length as f64).collect();
        HistogramCorrelator { samples_per_chip: samples_per_chip as usize, forward, inverse, code }
    }

    /// Bins of a code period, L' S, which is also the number of phase steps.
    pub fn bins(&self) -> usize {
        self.code.len() * self.samples_per_chip
    }

    /// The signed count r\[k\] of every phase step, exactly.
    ///
    /// # Panics
    /// If the histogram is one of another code length or other samples.
    pub fn signed_counts(&self, histogram: &Histogram) -> Vec<i64> {
        assert_eq!(histogram.bins().len(), self.bins(), "one bin per sample of the code");
        let sums = self.slot_sums(histogram.bins());
        let largest = sums.iter().copied().max().unwrap_or(0);
        let mut counts = vec![0_i64; self.bins()];
        let mut shift = 0;
        while shift < u64::BITS && largest >> shift > 0 {
            let digit = |&sum: &u64| (sum >> shift & ((1 << DIGIT_BITS) - 1)) as f64;
            let digits: Vec<f64> = sums.iter().map(digit).collect();
            for (count, value) in counts.iter_mut().zip(self.correlated(&digits)) {
                // Each digit's part is at most the total, which fits (Histogram::new).
                *count += (value.round() as i64) << shift;
            }
            shift += DIGIT_BITS;
        }
        counts
    }

    /// The same for bins that need not be whole numbers, such as expected or corrected ones.
    ///
    /// # Panics
    /// If there is not one value per bin.
    pub fn correlate(&self, bins: &[f64]) -> Vec<f64> {
        assert_eq!(bins.len(), self.bins(), "one value per sample of the code");
        self.correlated(&self.slot_sums(bins))
    }

    /// Sums of the S bins from each bin on: slot i of phase b stands at i S + b.
    fn slot_sums<T: Copy + std::iter::Sum<T>>(&self, bins: &[T]) -> Vec<T> {
        let after = bins.iter().cycle().take(self.samples_per_chip - 1);
        let bins: Vec<T> = bins.iter().chain(after).copied().collect();
        bins.windows(self.samples_per_chip).map(|slot| slot.iter().copied().sum()).collect()
    }

    /// Correlations of slots' sums with the code. Two phases at a time are the real and the
    /// imaginary part of one signal.
    fn correlated(&self, sums: &[f64]) -> Vec<f64> {
        let samples = self.samples_per_chip;
        let mut counts = vec![0.0; sums.len()];
        let mut signal = vec![Complex64::ZERO; self.code.len()];
        for phase in (0..samples).step_by(2) {
            let pairs = phase + 1 < samples;
            for (value, sums) in signal.iter_mut().zip(sums.chunks_exact(samples)) {
                let other = if pairs { sums[phase + 1] } else { 0.0 };
                *value = Complex64::new(sums[phase], other);
            }
            self.forward.process(&mut signal);
            for (value, code) in signal.iter_mut().zip(&self.code) {
                *value *= code;
            }
            self.inverse.process(&mut signal);
            for (value, counts) in signal.iter().zip(counts.chunks_exact_mut(samples)) {
                counts[phase] = value.re;
                if pairs {
                    counts[phase + 1] = value.im;
                }
            }
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{Generator, parse_chips};
    use proptest::prelude::*;

    fn code(chips: &str, interleave: u32) -> Code {
        let chips = parse_chips(chips).expect("zeros and ones");
        Code::new(Generator::Chips(chips), interleave).expect("a code")
    }

    /// r[k] as it is written down.
    fn by_definition(bins: &[u64], chips: &[u8], samples_per_chip: usize) -> Vec<i64> {
        let (bin_count, length) = (bins.len() as i64, chips.len() as i64);
        let samples = samples_per_chip as i64;
        (0..bin_count)
            .map(|k| {
                let signed = |a: i64| {
                    let chip = (a - k).div_euclid(samples).rem_euclid(length);
                    (2 * i128::from(chips[chip as usize]) - 1) * i128::from(bins[a as usize])
                };
                i64::try_from((0..bin_count).map(signed).sum::<i128>()).expect("it fits")
            })
            .collect()
    }

    proptest! {
        /// Counts up to 2^50 in a bin, lengths that are prime and even.
        #[test]
        fn every_step_is_the_definitions(
            chips in "10[01]{0,38}",
            interleave in 0_u32..3,
            samples in prop::sample::select(vec![1_usize, 2, 3, 4, 8, 16]),
            bits in 1_u32..51,
            seed in any::<u64>(),
        ) {
            let made = Code::new(Generator::Chips(parse_chips(&chips).expect("zeros and ones")), interleave);
            // Chips that repeat are not a code.
            prop_assume!(made.is_ok());
            let code = made.expect("a code");
            let bins: Vec<u64> = (0..code.chips.len() * samples)
                .scan(seed | 1, |state, _| {
                    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    Some(*state >> (64 - bits))
                })
                .collect();
            let periods = bins.iter().copied().max().unwrap_or(0).max(1);
            let histogram = Histogram::new(bins.clone(), samples as u32, periods).expect("counts");
            let counts = HistogramCorrelator::new(&code, samples as u32).signed_counts(&histogram);
            prop_assert_eq!(counts, by_definition(&bins, &code.chips, samples));
        }
    }

    #[test]
    fn values_that_are_not_whole_correlate_alike() {
        let code = code("1101001", 1);
        let bins: Vec<u64> = (0..28).map(|a| a * a % 11).collect();
        let shares: Vec<f64> = bins.iter().map(|&count| count as f64 / 64.0).collect();
        let correlator = HistogramCorrelator::new(&code, 2);
        let expected = by_definition(&bins, &code.chips, 2);
        for (value, expected) in correlator.correlate(&shares).iter().zip(expected) {
            assert!((value - expected as f64 / 64.0).abs() < 1e-12);
        }
    }
}
