//! Samples of a detector's level, and the clocks whose words hold them.

use std::ops::{Add, AddAssign, Range, Sub};

/// Number of a sample, from 0 at the first sample of the clock from which clocks are
/// counted: sample s is the level at time s T_s after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Sample(pub u64);

impl Add<u64> for Sample {
    type Output = Sample;

    #[inline]
    fn add(self, samples: u64) -> Sample {
        Sample(self.0 + samples)
    }
}

impl AddAssign<u64> for Sample {
    #[inline]
    fn add_assign(&mut self, samples: u64) {
        self.0 += samples;
    }
}

/// How many samples one comes after another.
impl Sub for Sample {
    type Output = u64;

    #[inline]
    fn sub(self, earlier: Sample) -> u64 {
        self.0 - earlier.0
    }
}

/// How clocks and samples number one another: the word of clock t holds samples
/// t S .. (t + 1) S.
///
/// ```
/// # mod goldtof {
/// #     pub use goldtof_sensor::*;
/// # }
/// use goldtof::scan::{Sample, Sampling};
///
/// let sampling = Sampling::new(8);
/// assert_eq!(sampling.first_sample(3), Sample(24));
/// assert_eq!(sampling.clock_of(Sample(29)), 3);
/// assert_eq!(sampling.lane_of(Sample(29)), 5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Sampling {
    /// Every word is shifted by it, in the innermost loops: a division costs more.
    samples_log2: u32,
}

impl Sampling {
    /// With S samples in a chip, a power of two.
    pub fn new(samples_per_chip: u32) -> Sampling {
        debug_assert!(samples_per_chip.is_power_of_two());
        Sampling { samples_log2: samples_per_chip.trailing_zeros() }
    }

    /// Samples of so many chips.
    #[inline]
    pub fn samples_of(self, chips: u64) -> u64 {
        chips << self.samples_log2
    }

    /// The earliest sample of a clock's word.
    #[inline]
    pub fn first_sample(self, clock: u64) -> Sample {
        Sample(self.samples_of(clock))
    }

    /// The samples of some clocks' words.
    #[inline]
    pub fn samples(self, clocks: &Range<u64>) -> Range<Sample> {
        self.first_sample(clocks.start)..self.first_sample(clocks.end)
    }

    /// The clock whose word holds a sample.
    #[inline]
    pub fn clock_of(self, sample: Sample) -> u64 {
        sample.0 >> self.samples_log2
    }

    /// Where a sample is in its word, 0..S, the earliest first.
    #[inline]
    pub fn lane_of(self, sample: Sample) -> u32 {
        (sample.0 & ((1 << self.samples_log2) - 1)) as u32
    }
}
