//! Histograms of arrival times: what follows from the counts of a sensor that keeps one
//! bin per sample of the code period.
//!
//! Bin a counts the rising edges at sample a of the code period, 0 <= a < L' S: the chip
//! counter modulo L', times S, plus the sample within the chip. From whole code periods
//! every phase step's signed count follows exactly ([`correlation`]):
//!
//! r\[k\] = sum over a of H\[a\] (2 c\[floor((a - k) / S) mod L'\] - 1),
//!
//! with the signs that the up/down correlator of step k has at those samples. All of them
//! come from the same photons, so their errors go together.
//!
//! How often the detector was ready at each bin follows from the histogram itself, too, so
//! that dead time and afterpulses can be taken out without a model of light or code
//! ([`correction`]). How far bins go together follows, too ([`innovations`]): that weighs them in
//! fits, and draws histograms without photons.

pub mod correction;
pub mod correlation;
pub mod innovations;

/// Counts by arrival time within the code period.
///
/// ```
/// # mod goldtof {
/// #     pub use goldtof_physics::*;
/// # }
/// use goldtof::histogram::Histogram;
///
/// // A code of 3 chips with 2 samples each, over 10 periods.
/// let histogram = Histogram::new(vec![0, 7, 1, 0, 2, 0], 2, 10)?;
/// assert_eq!(histogram.total(), 10);
/// assert_eq!(histogram.per_period()[1], 0.7);
/// # Ok::<(), goldtof::histogram::HistogramError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Histogram {
    bins: Vec<u64>,
    samples_per_chip: u32,
    periods: u64,
}

/// Why counts are not a histogram.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum HistogramError {
    /// Bins are not whole chips.
    #[error(
        "{bins} bins are not a whole number of chips of {samples_per_chip} samples; a histogram has \
         one bin per sample of the code period"
    )]
    NoWholeChips {
        /// Bins given.
        bins: usize,
        /// Samples per chip.
        samples_per_chip: u32,
    },
    /// Nothing was measured.
    #[error("a histogram over 0 code periods says nothing; it needs at least one")]
    NoPeriods,
    /// A bin counted more often than it came by.
    #[error(
        "bin {bin} counts {count} rising edges, but each of the {periods} code periods has it once"
    )]
    TooMany {
        /// The first such bin.
        bin: usize,
        /// What it holds.
        count: u64,
        /// Code periods.
        periods: u64,
    },
    /// Sums would not fit.
    #[error("all bins together count {total}; signed counts of 64 bits take up to {}", i64::MAX)]
    TooLarge {
        /// Sum of all bins.
        total: u128,
    },
}

impl Histogram {
    /// A histogram over `periods` whole code periods: one bin per sample of the period,
    /// `samples_per_chip` of them per chip.
    ///
    /// # Errors
    /// When there are no whole chips or no periods, or more rising edges than there can be.
    pub fn new(
        bins: Vec<u64>,
        samples_per_chip: u32,
        periods: u64,
    ) -> Result<Histogram, HistogramError> {
        let chip = samples_per_chip as usize;
        if chip == 0 || bins.is_empty() || !bins.len().is_multiple_of(chip) {
            return Err(HistogramError::NoWholeChips { bins: bins.len(), samples_per_chip });
        }
        if periods == 0 {
            return Err(HistogramError::NoPeriods);
        }
        if let Some(bin) = bins.iter().position(|&count| count > periods) {
            let count = bins[bin];
            return Err(HistogramError::TooMany { bin, count, periods });
        }
        let total: u128 = bins.iter().map(|&count| u128::from(count)).sum();
        if i64::try_from(total).is_err() {
            return Err(HistogramError::TooLarge { total });
        }
        Ok(Histogram { bins, samples_per_chip, periods })
    }

    /// Rising edges in each bin.
    pub fn bins(&self) -> &[u64] {
        &self.bins
    }

    /// Samples per chip, S.
    pub fn samples_per_chip(&self) -> u32 {
        self.samples_per_chip
    }

    /// Chips of the code period, L'.
    pub fn chips(&self) -> usize {
        self.bins.len() / self.samples_per_chip as usize
    }

    /// Whole code periods that were counted, K.
    pub fn periods(&self) -> u64 {
        self.periods
    }

    /// Rising edges in all bins.
    pub fn total(&self) -> u64 {
        self.bins.iter().sum()
    }

    /// Mean rising edges of each bin in a code period.
    pub fn per_period(&self) -> Vec<f64> {
        let periods = self.periods as f64;
        self.bins.iter().map(|&count| count as f64 / periods).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_a_histogram_is_refused() {
        let new = |bins: &[u64], samples, periods| Histogram::new(bins.to_vec(), samples, periods);
        let no_chips =
            |bins, samples_per_chip| Err(HistogramError::NoWholeChips { bins, samples_per_chip });
        assert_eq!(new(&[1, 0, 0], 2, 9), no_chips(3, 2));
        assert_eq!(new(&[], 2, 9), no_chips(0, 2));
        assert_eq!(new(&[1], 0, 9), no_chips(1, 0));
        assert_eq!(new(&[0, 0], 2, 0), Err(HistogramError::NoPeriods));
        let too_many = HistogramError::TooMany { bin: 1, count: 3, periods: 2 };
        assert_eq!(new(&[2, 3], 2, 2), Err(too_many));
        let most = i64::MAX as u64;
        let total = u128::from(most) + 1;
        assert_eq!(new(&[most, 1], 2, most), Err(HistogramError::TooLarge { total }));
        assert_eq!(new(&[most, 0], 2, most).map(|h| h.total()), Ok(most));
    }
}
