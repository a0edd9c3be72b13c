//! What the outputs have shown since the model was made, resets included: how much a comparison of
//! them is worth. A hit that is counted shows nowhere until its phase step has ended and its count
//! stands on the stream: so only these are here.

use serde::{Deserialize, Serialize};

use super::coverage::Covered;
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;

/// What the compared outputs have shown.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Exercised {
    /// Detector by detector.
    pub detectors: Vec<DetectorExercised>,
    /// Phase steps whose integration ended.
    pub phase_steps: u64,
    /// Results that the receiver took.
    pub results_taken: u64,
    /// Last results of a scan.
    pub scan_ends: u64,
    /// Resets, that at the start included.
    pub resets: u64,
    /// Results that the receiver left standing for a clock or more.
    pub stalls: u64,
    /// Groups of results that were lost behind one that still stood.
    pub overruns: u64,
    /// Groups of results of which one was saturated.
    pub saturations: u64,
    /// Cover points that have shown.
    #[serde(skip)]
    pub covered: Covered,
}

/// What the results of one detector have shown.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct DetectorExercised {
    /// The detector's name.
    pub detector: String,
    /// Results that stood on the stream.
    pub results: u64,
    /// Hits that they counted up, each once for every phase step that saw it.
    pub hits_up: u64,
    /// Hits that they counted down.
    pub hits_down: u64,
}

/// What a result counted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct CountedHits {
    pub(super) detector: DetectorIndex,
    pub(super) up: u64,
    pub(super) down: u64,
}

impl CountedHits {
    /// Of a detector's `total` hits whose signs add up to `sum`.
    pub(super) fn new(detector: DetectorIndex, sum: i64, total: u64) -> CountedHits {
        let up = total.saturating_add_signed(sum) / 2;
        CountedHits { detector, up, down: total - up }
    }
}

impl Exercised {
    pub(super) fn of(detectors: usize) -> Exercised {
        Exercised {
            detectors: vec![DetectorExercised::default(); detectors],
            ..Exercised::default()
        }
    }

    /// A result stands on the stream.
    pub(super) fn shows(&mut self, counted: CountedHits, is_scan_end: bool) {
        let detector = &mut self.detectors[counted.detector];
        detector.results += 1;
        detector.hits_up += counted.up;
        detector.hits_down += counted.down;
        self.scan_ends += u64::from(is_scan_end);
    }
    /// With the detectors' names, in their order.
    pub fn named<'a>(mut self, names: impl Iterator<Item = &'a str>) -> Exercised {
        for (detector, name) in self.detectors.iter_mut().zip(names) {
            name.clone_into(&mut detector.detector);
        }
        self
    }

    /// Takes what other clocks of the same sensor have shown.
    pub fn append(&mut self, other: &Exercised) {
        for (detector, more) in self.detectors.iter_mut().zip(&other.detectors) {
            detector.results += more.results;
            detector.hits_up += more.hits_up;
            detector.hits_down += more.hits_down;
        }
        self.phase_steps += other.phase_steps;
        self.results_taken += other.results_taken;
        self.scan_ends += other.scan_ends;
        self.resets += other.resets;
        self.stalls += other.stalls;
        self.overruns += other.overruns;
        self.saturations += other.saturations;
    }

    /// What else was not exercised, in a few words each: a match says nothing of it.
    pub fn not_reached(&self, interface: &Interface) -> Vec<&'static str> {
        let parts = [
            (self.scan_ends == 0, "the end of a scan"),
            (self.scan_ends == 1, "a scan after the first one"),
            (self.stalls == 0, "a receiver that stalls"),
            (self.overruns == 0, "a result that is lost"),
            (interface.saturates() && self.saturations == 0, "a count that saturates"),
            (self.resets < 2, "a reset after the start"),
        ];
        let lacking = parts.into_iter().filter(|(lacks, _)| *lacks);
        lacking.map(|(_, part)| part).collect()
    }

    /// One line: what was exercised, in numbers.
    pub fn text(&self) -> String {
        let mut parts: Vec<String> = self
            .detectors
            .iter()
            .map(|d| {
                format!(
                    "{}: {} results, hits counted {} up and {} down",
                    d.detector, d.results, d.hits_up, d.hits_down
                )
            })
            .collect();
        parts.push(format!(
            "{} phase steps, {} results taken, {} scan ends, {} resets, {} stalls, {} overruns, {} \
             saturations",
            self.phase_steps,
            self.results_taken,
            self.scan_ends,
            self.resets,
            self.stalls,
            self.overruns,
            self.saturations
        ));
        parts.join("; ")
    }
}
