//! Histograms out of the beats of a result stream, and what every phase step counts by
//! them.

use super::sent_count::SentCount;
use crate::histogram::Histogram;
use crate::histogram::correlation::HistogramCorrelator;
use crate::scene::DetectorIndex;
use crate::sensor::histogram::HistogramPlan;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Field;

/// A row that is not where a frame ends, or is and does not say so.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Misplaced;

/// Collects the rows of a frame.
#[derive(Debug)]
pub(super) struct FrameReader {
    plan: HistogramPlan,
    data: Field,
    correlators: Vec<HistogramCorrelator>,
    /// Bins of the present frame, detector by detector.
    bins: Vec<u64>,
}

impl FrameReader {
    pub(super) fn new(interface: &Interface, plan: &HistogramPlan, data: Field) -> FrameReader {
        let codes = interface.reference_codes.iter();
        FrameReader {
            plan: *plan,
            data,
            correlators: codes.map(|code| HistogramCorrelator::new(code, plan.row_bins)).collect(),
            bins: Vec::new(),
        }
    }

    /// The row that stands on the stream.
    pub(super) fn row(&self, output: &[u64]) -> [u64; 2] {
        let bits = self.plan.row_data_bits();
        let low = self.data.bits(output, 0, bits.min(64));
        let high = match bits {
            0..=64 => 0,
            _ => self.data.bits(output, 64, bits - 64),
        };
        [low, high]
    }

    /// Takes a row. The last of a frame gives what every phase step of each detector
    /// counts: r\[k\] of the histogram, and all of its hits.
    pub(super) fn take(
        &mut self,
        row: [u64; 2],
        last: bool,
    ) -> Result<Option<impl Iterator<Item = SentCount>>, Misplaced> {
        let row = u128::from(row[0]) | u128::from(row[1]) << 64;
        let stride = self.plan.bin_data_bits();
        let mask = (1u128 << stride) - 1;
        let bins = (0..self.plan.row_bins).map(|bin| (row >> (bin * stride) & mask) as u64);
        self.bins.extend(bins);
        let of_detector = self.plan.bins() as usize;
        let ends = self.bins.len() == of_detector * self.correlators.len();
        if ends != last {
            return Err(Misplaced);
        }
        if !ends {
            return Ok(None);
        }
        let mut counts = Vec::new();
        let frames = self.bins.chunks_exact(of_detector).zip(&self.correlators);
        for (detector, (bins, correlator)) in DetectorIndex::all().zip(frames) {
            let histogram = Histogram::new(bins.to_vec(), self.plan.row_bins, self.plan.periods)
                .map_err(|_| Misplaced)?;
            let total = Some(histogram.total());
            let signed = correlator.signed_counts(&histogram);
            let of_steps = (0..).zip(signed.into_iter().zip(bins));
            counts.extend(of_steps.map(|(step, (signed, &bin))| SentCount {
                scan: 0,
                detector,
                step,
                signed,
                total,
                bin: Some(bin),
            }));
        }
        self.bins.clear();
        Ok(Some(counts.into_iter()))
    }
}
