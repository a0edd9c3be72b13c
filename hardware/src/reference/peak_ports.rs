//! The ports of the peak detector: step and count of each scan's peak.

use crate::scene::DetectorIndex;
use std::collections::VecDeque;
use std::ops::Range;

use super::canvas::Canvas;
use super::coverage::{CoverPoint, CoverTable, Covered, PeakPoint};
use crate::scan::Group;
use crate::sensor::interface::Interface;
use crate::sensor::layout::{Field, Layout};
use crate::sensor::peak::PeakPlan;
use crate::sensor::port::PortRole;

/// A detector's peak.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
struct Peak {
    step: u64,
    count: i64,
}

/// The largest count of a scan so far.
#[derive(Debug, Clone, Copy)]
struct Best {
    peak: Peak,
    group: Group,
    /// Its step of the group.
    place: usize,
    /// There is an equal one behind it.
    is_shared: bool,
}

/// Peaks on their way to the ports.
#[derive(Debug, Clone)]
struct Arrival {
    /// Clock after whose rising edge they show.
    clock: u64,
    peaks: Vec<Peak>,
    /// Cover points that they prove.
    proves: Vec<usize>,
}

/// What the peak detector shows.
#[derive(Debug, Clone)]
pub(super) struct PeakPorts {
    plan: PeakPlan,
    step: Field,
    count: Field,
    valid: Field,
    /// Largest count of the present scan so far, detector by detector.
    best: Vec<Option<Best>>,
    /// The present scan's last group.
    pub(super) last_group: Group,
    arriving: VecDeque<Arrival>,
    /// The ports' bits in a record, except `o_peak_valid`.
    record: Vec<u64>,
}

impl PeakPorts {
    /// Before the first scan; `None` if the interface has no peak detector.
    pub(super) fn new(interface: &Interface, layout: &Layout) -> Option<PeakPorts> {
        let detectors = interface.reference_codes.len();
        let field = |name| layout.outputs.field(name).clone();
        Some(PeakPorts {
            plan: *interface.peak()?,
            step: field(PortRole::PeakStep),
            count: field(PortRole::PeakCount),
            valid: field(PortRole::PeakValid),
            best: vec![None; detectors],
            last_group: Group(interface.groups() - 1),
            arriving: VecDeque::new(),
            record: vec![0; layout.outputs.words],
        })
    }

    /// Forgets everything, as reset does.
    pub(super) fn reset(&mut self) {
        self.best.fill(None);
        self.arriving.clear();
        self.record.fill(0);
    }

    /// Takes in a count; of equal ones the first is the peak.
    /// It is that of step `place` of its group.
    pub(super) fn count(
        &mut self,
        (detector, place): (DetectorIndex, usize),
        step: u64,
        count: i64,
        group: Group,
    ) {
        let best = &mut self.best[detector];
        match best {
            Some(best) if count == best.peak.count => best.is_shared = true,
            Some(best) if count < best.peak.count => {}
            _ => {
                *best = Some(Best { peak: Peak { step, count }, group, place, is_shared: false });
            }
        }
    }

    /// The scan whose counts were taken in ended before `clock`. Its peaks prove the
    /// points of `after_reset`, which is emptied.
    pub(super) fn end_scan(
        &mut self,
        clock: u64,
        after_reset: &mut Vec<usize>,
        table: &CoverTable,
    ) {
        let mut proves = std::mem::take(after_reset);
        for (detector, best) in DetectorIndex::all().zip(self.best.iter()) {
            let Some(best) = best else {
                continue;
            };
            let points = [
                (best.peak.count < 0, PeakPoint::Negative),
                (best.peak.count > 0, PeakPoint::Positive),
                (best.group == Group(0) && self.last_group > Group(0), PeakPoint::First),
                (best.group == self.last_group, PeakPoint::Last),
                (best.is_shared, PeakPoint::Equal),
                (!best.is_shared, PeakPoint::Step(best.place)),
            ];
            for (_, point) in points.into_iter().filter(|(is, _)| *is) {
                proves.extend(table.number(CoverPoint::of(detector, point)));
            }
        }
        let peaks = self.best.iter().map(|best| best.map_or_else(Peak::default, |best| best.peak));
        self.arriving.push_back(Arrival {
            clock: clock + u64::from(self.plan.latency_clocks),
            peaks: peaks.collect(),
            proves,
        });
        self.best.fill(None);
    }

    /// ORs the ports into the records of a stretch of clocks without reset. Gives the peaks that came in it,
    /// step and count of each detector, each with the clock after whose rising edge the ports have them.
    pub(super) fn predict(
        &mut self,
        clocks: Range<u64>,
        expected: &mut impl Canvas,
        covered: &mut Covered,
    ) -> Vec<(u64, Vec<(u64, i64)>)> {
        let mut come = Vec::new();
        let mut filled = clocks.start;
        while let Some(arrival) = self.arriving.pop_front_if(|a| a.clock < clocks.end) {
            let clock = arrival.clock;
            self.fill(filled..clock, expected);
            filled = clock;
            self.show(&arrival.peaks);
            for point in arrival.proves {
                covered.mark(point);
            }
            expected.or(clock..clock + 1, self.valid.word, 1 << self.valid.shift);
            let peaks = arrival.peaks.iter().map(|peak| (peak.step, peak.count));
            come.push((clock, peaks.collect()));
        }
        self.fill(filled..clocks.end, expected);
        come
    }

    fn show(&mut self, peaks: &[Peak]) {
        self.record.fill(0);
        for (detector, peak) in DetectorIndex::all().zip(peaks.iter()) {
            let detector = detector.0 as u32;
            let (steps, counts) = (self.plan.step_bits, self.plan.count_bits);
            self.step.or_bits(&mut self.record, detector * steps, steps, peak.step);
            self.count.or_bits(&mut self.record, detector * counts, counts, peak.count as u64);
        }
    }

    fn fill(&self, clocks: Range<u64>, expected: &mut impl Canvas) {
        for (word, &bits) in self.record.iter().enumerate() {
            if bits != 0 {
                expected.or(clocks.clone(), word, bits);
            }
        }
    }
}
