//! What the sensor has counted so far, from the reference model's results: numbers
//! whose bits a design may have in its registers.

use crate::reference::predictor::StepResult;
use crate::scan::Step;
use crate::scene::{DetectorIndex, Scan};
use crate::sensor::interface::Interface;

/// The numbers after so many groups.
#[derive(Debug, Clone)]
pub(super) struct LaneTally {
    parallel: usize,
    /// Per detector and step of a group: signed counts of all groups so far.
    signed: Vec<i64>,
    /// Per detector: hits of all groups so far.
    hits: Vec<i64>,
    /// Per detector: largest count of the scan and its phase step, of all groups so
    /// far.
    best: Vec<(i64, i64)>,
    /// Whether a count was saturated.
    saturated: i64,
    /// Per detector and step of a group: the last group's counts as sent.
    last: Vec<i64>,
    /// The numbers before the last group, which are still on their way.
    before: Vec<i64>,
    scan: Scan,
}

impl LaneTally {
    /// Where the first signed count is among the numbers.
    #[cfg(test)]
    pub(super) const SIGNED: usize = 1;

    /// Before the first group.
    pub(super) fn new(interface: &Interface) -> LaneTally {
        let detectors = interface.reference_codes.len();
        let counters = detectors * interface.parallel() as usize;
        let mut tally = LaneTally {
            parallel: interface.parallel() as usize,
            signed: vec![0; counters],
            hits: vec![0; detectors],
            best: vec![(0, 0); detectors],
            saturated: 0,
            last: vec![0; counters],
            before: Vec::new(),
            scan: interface.timing.scan,
        };
        tally.before = tally.present();
        tally
    }

    /// Takes in a result; those of a group follow one another.
    pub(super) fn add(&mut self, result: &StepResult) {
        let in_group = (result.step % self.parallel as u64) as usize;
        if result.detector == DetectorIndex(0) && in_group == 0 {
            self.before = self.present();
        }
        let counter = result.detector.0 * self.parallel + in_group;
        self.signed[counter] += result.exact;
        if in_group == 0 {
            self.hits[result.detector] += result.exact_total.cast_signed();
        }
        let phase_step = self.scan.phase_step(Step(result.step)).cast_signed();
        let best = &mut self.best[result.detector];
        if result.step == 0 || result.count > best.0 {
            *best = (result.count, phase_step);
        }
        let is_exact = result.count == result.exact && result.total == result.exact_total;
        self.saturated |= i64::from(!is_exact);
        self.last[counter] = result.count;
    }

    /// All numbers, in an order that is always the same: those of all groups, and
    /// those of all but the last.
    pub(super) fn values(&self) -> Vec<i64> {
        let mut values = self.present();
        values.extend(&self.before);
        values
    }

    fn present(&self) -> Vec<i64> {
        // First, since what changes once is taken for it.
        let mut values = vec![self.saturated];
        values.extend(&self.signed);
        values.extend(&self.hits);
        for (counter, signed) in self.signed.iter().enumerate() {
            let hits = self.hits[counter / self.parallel];
            values.extend([(hits + signed) / 2, (hits - signed) / 2]);
        }
        values.extend(self.best.iter().flat_map(|&(count, step)| [count, step]));
        values.extend(&self.last);
        values
    }
}
