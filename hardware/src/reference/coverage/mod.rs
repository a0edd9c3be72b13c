//! What hostile inputs are to reach: a table of cover points that follows from the
//! interface alone, and which of them the reference model has seen.
//!
//! A point is covered when what it names has shown at the ports: a hit with the
//! result that counts it, a reset with the first result after it. So an error
//! there would have been a mismatch.
//!
//! Each family of points has a file: what they are, which of them an interface has, their words,
//! and the way to each.

mod bins;
mod carries;
mod cells;
mod hits;
mod peaks;
pub(super) mod registers;
mod resets;
mod running;
mod saturation;
mod scans;
mod signs;
mod stream;

use std::collections::HashMap;
use std::sync::Arc;

pub use self::bins::BinPoint;
pub use self::carries::CarryPoint;
pub use self::cells::CellPoint;
pub use self::hits::HitPoint;
pub use self::peaks::PeakPoint;
pub(super) use self::registers::LONG_STALL;
pub use self::registers::{
    Extreme, First, Meeting, RegisterKind, RegisterPoint, ScanStart, TrackNumber, TrackPoint,
};
pub use self::resets::{ResetPoint, ResetState};
pub(super) use self::running::{CountedHit, Running};
pub use self::saturation::SaturationPoint;
pub use self::scans::{GroupPosition, ScanPoint};
pub use self::signs::signs_reached;
pub use self::stream::StreamPoint;
use super::group_maker::GroupMaker;
use super::planned::PlannedGroup;
use crate::scene::DetectorIndex;
use crate::sensor::interface::{Counting, Interface};

/// What a family's points have in common.
trait PointFamily {
    /// In words, without the detector.
    fn text(&self) -> String;

    /// Groups of phase steps that should reach it, from a reset on, or why they are too many.
    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String>;
}

/// A point, and why no inputs reach it, if none do.
type Hindered<P> = (P, Option<&'static str>);

/// Steps of a group: a scan of fewer steps than there are correlators leaves the last ones out.
fn steps(interface: &Interface) -> std::ops::Range<usize> {
    0..u64::from(interface.parallel()).min(interface.timing.scan.steps) as usize
}

macro_rules! families {
    ($($(#[$about:meta])* $family:ident($point:ty) = $name:literal,)+) => {
        /// What happens at a cover point.
        ///
        /// Steps of a group, lanes (samples of a word), beats of a group and ages count from 0.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Happening {
            $($(#[$about])* $family($point),)+
        }

        $(impl From<$point> for Happening {
            fn from(point: $point) -> Happening {
                Happening::$family(point)
            }
        }

        impl From<$point> for CoverPoint {
            fn from(point: $point) -> CoverPoint {
                CoverPoint { detector: None, what: point.into() }
            }
        })+

        impl Happening {
            /// The name of its family in reports.
            fn family(&self) -> &'static str {
                match self {
                    $(Happening::$family(_) => $name,)+
                }
            }

            fn point(&self) -> &dyn PointFamily {
                match self {
                    $(Happening::$family(point) => point,)+
                }
            }
        }
    };
}

families! {
    /// Single hits.
    Hits(HitPoint) = "hits",
    /// Pulses of the cells of a detector.
    Cells(CellPoint) = "cells",
    /// Carries and borrows of counters.
    Carries(CarryPoint) = "carries",
    /// Counts at their limits.
    Saturation(SaturationPoint) = "saturation",
    /// A scan's largest count.
    Peaks(PeakPoint) = "peaks",
    /// Results on the stream.
    Stream(StreamPoint) = "stream",
    /// Bins of a histogram.
    Bins(BinPoint) = "bins",
    /// What a reset comes upon.
    Resets(ResetPoint) = "resets",
    /// Steps, scans, codes.
    Scans(ScanPoint) = "scans",
    /// What a host does.
    Registers(RegisterPoint) = "registers",
}

/// Something that a sensor can be made to do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct CoverPoint {
    /// The detector that it is about; none of what concerns the sensor as a whole.
    pub detector: Option<DetectorIndex>,
    /// What it is.
    pub what: Happening,
}

impl CoverPoint {
    /// What one of the detectors does.
    pub fn of(detector: DetectorIndex, what: impl Into<Happening>) -> CoverPoint {
        CoverPoint { detector: Some(detector), what: what.into() }
    }

    /// The name of its family in reports.
    pub fn family(&self) -> &'static str {
        self.what.family()
    }

    /// In words, with the detectors' names.
    pub fn text(&self, names: &[String]) -> String {
        let text = self.what.point().text();
        match self.detector {
            Some(detector) => {
                let name = names.get(detector.0).map_or("?", String::as_str);
                format!("{name}: {text}")
            }
            None => text,
        }
    }

    /// Groups of phase steps that should reach it, from a reset on.
    pub(super) fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        self.what.point().recipe(maker)
    }
}

/// Cover points of an interface.
#[derive(Debug, Clone)]
pub struct CoverTable {
    points: Vec<CoverPoint>,
    numbers: HashMap<CoverPoint, usize>,
    /// Points that no inputs reach, with the reason.
    unreachable: Vec<(CoverPoint, &'static str)>,
}

/// Which points of a table were covered.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Covered {
    bits: Vec<u64>,
}

impl Covered {
    /// Marks a point; says whether it is new.
    pub(super) fn mark(&mut self, number: usize) -> bool {
        let (word, bit) = (number / 64, 1 << (number % 64));
        if self.bits.len() <= word {
            self.bits.resize(word + 1, 0);
        }
        let is_new = self.bits[word] & bit == 0;
        self.bits[word] |= bit;
        is_new
    }

    /// Whether a point was covered.
    pub fn contains(&self, number: usize) -> bool {
        let word = self.bits.get(number / 64).copied().unwrap_or(0);
        word >> (number % 64) & 1 == 1
    }

    /// Points that were covered.
    pub fn count(&self) -> usize {
        self.bits.iter().map(|word| word.count_ones() as usize).sum()
    }
}

impl CoverTable {
    /// The points of an interface.
    pub fn of(interface: &Interface) -> Arc<CoverTable> {
        let mut table =
            CoverTable { points: Vec::new(), numbers: HashMap::new(), unreachable: Vec::new() };
        let detectors = DetectorIndex::first(interface.reference_codes.len());
        match &interface.counting {
            Counting::Correlator(correlator) => {
                for detector in detectors {
                    table.add_of(detector, hits::points(interface, detector));
                    if interface.input_cells.count > 1 {
                        table.add_of(detector, cells::points(&interface.input_cells));
                    }
                    table.add_of(detector, carries::points(interface, correlator));
                    table.add_of(detector, saturation::points(interface, detector, correlator));
                    if correlator.peak.is_some() {
                        table.add_of(detector, peaks::points(interface));
                    }
                }
                table.add(stream::of_counts(interface));
                table.add(resets::points(interface));
                table.add(scans::results(interface));
                table.add(scans::delays(interface));
            }
            Counting::Histogram(plan) => {
                for detector in detectors {
                    table.add_of(detector, bins::points(plan));
                }
                table.add(stream::of_rows(interface, plan));
                table.add(scans::results(interface));
                table.add(resets::points(interface));
            }
        }
        table.add(scans::codes(interface));
        if let Some(plan) = &interface.registers {
            table.add(registers::points(interface, plan));
        }
        Arc::new(table)
    }

    /// Adds points, each as one that can be reached, or with the reason why not.
    fn add<P: Into<CoverPoint>>(&mut self, points: Vec<Hindered<P>>) {
        for (point, hindrance) in points {
            let point = point.into();
            match hindrance {
                Some(reason) => self.unreachable.push((point, reason)),
                None => {
                    self.numbers.insert(point, self.points.len());
                    self.points.push(point);
                }
            }
        }
    }

    /// Adds those of a detector.
    fn add_of(&mut self, detector: DetectorIndex, points: Vec<Hindered<impl Into<Happening>>>) {
        let of_detector = |(point, hindrance)| (CoverPoint::of(detector, point), hindrance);
        self.add(points.into_iter().map(of_detector).collect());
    }

    /// Every point that can be reached.
    pub fn points(&self) -> &[CoverPoint] {
        &self.points
    }

    /// A point's number, if the table has it.
    pub fn number(&self, point: impl Into<CoverPoint>) -> Option<usize> {
        self.numbers.get(&point.into()).copied()
    }

    /// Points that no inputs reach, each with the reason.
    pub fn unreachable(&self) -> &[(CoverPoint, &'static str)] {
        &self.unreachable
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::CoverTable;
    use crate::scene;
    use crate::sensor::Sensor;

    #[test]
    fn every_point_has_words_of_its_own() {
        let text = include_str!("../../../../tests/scenes/totals.toml");
        let mut scene = scene::parse("totals.toml", text).expect("it is sound");
        scene.hardware.peak_detector = true;
        scene.hardware.parallel = 4;
        let table = CoverTable::of(Sensor::new(&scene).interface());
        let names: Vec<String> = scene.detectors.iter().map(|d| d.name.clone()).collect();
        let unreachable = table.unreachable().iter().map(|(point, _)| point);
        let words: Vec<String> =
            table.points().iter().chain(unreachable).map(|p| p.text(&names)).collect();
        assert!(words.len() > 50, "{}", words.len());
        assert!(words.iter().all(|words| !words.ends_with(": ") && !words.is_empty()));
        assert_eq!(words.iter().collect::<HashSet<_>>().len(), words.len());
    }
}
