//! What the adversary means to do with a group of phase steps.

use crate::reference::host::Request;
use crate::scene::DetectorIndex;
use crate::sensor::interface::{Correlator, Interface};

/// Most clocks for which a beat is held by plan.
pub(super) const LONGEST_HOLD: u64 = 17;

/// One group of phase steps, and what comes before it.
#[derive(Debug, Clone)]
pub(super) struct PlannedGroup {
    /// A reset before it.
    pub reset: Option<PlannedReset>,
    /// Words outside of scans before it.
    pub lead: Lead,
    /// How long it is to be.
    pub length: Length,
    /// Groups that are left between this one and the scan's last, if others are to be left
    /// out.
    pub left_to_the_last: Option<u64>,
    pub hits: Hits,
    /// What the receiver does with the results of the group before.
    pub receiver: ReceiverPlan,
    /// Chips after which a reset, which the next plan has, ends it.
    pub cut: Option<u64>,
    /// What a host does from then on.
    pub asks: Vec<Request>,
}

/// A reset.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlannedReset {
    /// Clocks between the last word before it and its first.
    pub age: u64,
    /// Its clocks.
    pub clocks: u64,
}

/// Words that no step counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lead {
    Random,
    /// A single hit, on the last sample.
    LastSample,
}

/// Chips of a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Length {
    /// Short, if steps can be shortened.
    Short,
    /// At least so many, if the step has them.
    AtLeast(u64),
    /// All of them.
    Whole,
    /// This many.
    Exactly(u64),
}

/// Hits of a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Hits {
    /// A pattern for each detector, by chance.
    Random,
    None,
    /// On every other sample.
    EveryOther,
    /// On this lane of every word.
    Lane {
        detector: DetectorIndex,
        lane: u64,
    },
    /// On this lane of the word so many clocks before a frame's last, and of as many code periods before as fill its bin:
    /// with the last one the bin is beyond its limit.
    BeyondLimitAtEnd {
        detector: DetectorIndex,
        lane: u64,
        age: u64,
    },
    /// Where the step has one sign, as many as there can be.
    OneSided {
        step: u64,
        up: bool,
    },
    /// Where all steps of the group have that sign; if they never have, as many as make each of their counts have it, or
    /// nearly.
    AllSteps {
        up: bool,
    },
    /// A single one, where a step counts it so.
    One {
        detector: DetectorIndex,
        step: u64,
        lane: u64,
        up: bool,
    },
    /// A single one that all steps of the group count so.
    OneForAll {
        detector: DetectorIndex,
        up: bool,
    },
    /// On the first, or the last, sample of the group.
    Border {
        first: bool,
    },
    /// A single one in the word so many clocks before the cut.
    BeforeCut {
        age: u64,
    },
    /// As many of one sign as make this count, in one step more than in any other.
    Count {
        detector: DetectorIndex,
        step: u64,
        count: i64,
    },
    /// As many as make this total, with counts near zero.
    Total {
        detector: DetectorIndex,
        hits: u64,
    },
}

/// What the receiver does between the arrivals of two groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ReceiverPlan {
    Random,
    /// Always ready.
    Takes,
    /// Takes nothing until well after the second arrival.
    Stalls,
    /// Holds one beat for some clocks.
    Holds {
        beat: u64,
    },
    /// Holds one beat, and each that stands behind it for a clock.
    HoldsEach {
        beat: u64,
    },
    /// Takes nothing from this beat on, until so many clocks after the second arrival.
    StopsAt {
        beat: u64,
        clocks: u64,
    },
    /// Holds it until after the second arrival.
    HoldsAcross {
        beat: u64,
    },
    /// Takes the last beat so many clocks after the second group arrives.
    TakesLastAfter {
        clocks: u64,
    },
}

impl PlannedGroup {
    /// A group by chance.
    pub fn random() -> PlannedGroup {
        PlannedGroup {
            reset: None,
            lead: Lead::Random,
            length: Length::Short,
            left_to_the_last: None,
            hits: Hits::Random,
            receiver: ReceiverPlan::Takes,
            cut: None,
            asks: Vec::new(),
        }
    }

    /// A group after a reset longer than all pipelines.
    pub fn fresh(interface: &Interface) -> PlannedGroup {
        let clocks = u64::from(interface.result_latency_clocks) + peak_clocks(interface) + 4;
        PlannedGroup::random().after_reset(3, clocks)
    }

    pub fn asks(self, asks: Vec<Request>) -> PlannedGroup {
        PlannedGroup { asks, ..self }
    }

    pub fn with(self, hits: Hits) -> PlannedGroup {
        PlannedGroup { hits, ..self }
    }

    pub fn received(self, receiver: ReceiverPlan) -> PlannedGroup {
        PlannedGroup { receiver, ..self }
    }

    /// Ends after so many chips, by a reset of one clock that the next plan has.
    pub fn cut_after(self, chips: u64) -> PlannedGroup {
        PlannedGroup { cut: Some(chips), ..self }
    }

    pub fn long(self, length: Length) -> PlannedGroup {
        PlannedGroup { length, ..self }
    }

    pub fn then_the_last(self) -> PlannedGroup {
        self.then_the_last_but(0)
    }

    /// The scan's last group comes so many groups behind the next one.
    pub fn then_the_last_but(self, groups: u64) -> PlannedGroup {
        PlannedGroup { left_to_the_last: Some(groups), ..self }
    }

    pub fn after_reset(self, age: u64, clocks: u64) -> PlannedGroup {
        let reset = Some(PlannedReset { age, clocks });
        PlannedGroup { reset, ..self }
    }
}

fn shortened(interface: &Interface, chips: u64) -> u64 {
    interface.rows().map_or(chips, |rows| rows.shortened(chips))
}

fn peak_clocks(interface: &Interface) -> u64 {
    u64::from(interface.peak_latency_clocks())
}

/// What can be shortened, and how far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shortening {
    /// Chips of the shortest group.
    pub shortest: u64,
    /// Groups can be left out.
    pub leaves_out: bool,
    /// Most clocks that are spent on the way to one cover point.
    pub most_clocks: u64,
    /// Most that are spent where a host talks, whose scans cannot be shortened.
    pub most_clocks_of_talk: u64,
}

impl Shortening {
    /// With or without the scan's counters at hand; the most clocks without a host, and with one.
    pub fn of(
        interface: &Interface,
        shortens: bool,
        [most_clocks, most_clocks_of_talk]: [u64; 2],
    ) -> Shortening {
        let chips = interface.timing.scan.integration_chips;
        let parallel = u64::from(interface.parallel());
        let peak = interface.peak().map_or(0, |peak| peak.least_chips);
        let shortest = 16
            + u64::from(interface.correlator().map_or(0, Correlator::clocks_of_counting))
            + parallel.div_ceil(u64::from(interface.lanes()))
            + peak;
        let is_long = chips >= 2 * shortest + 16 && interface.histogram().is_none();
        Shortening {
            shortest: if shortens && is_long { shortened(interface, shortest) } else { chips },
            leaves_out: shortens && interface.groups() > 3 && chips >= 16,
            most_clocks,
            most_clocks_of_talk,
        }
    }

    /// Chips of the shortest group of at least so many: where a step is counted in windows, whole ones
    /// are left out.
    pub fn chips_of_at_least(&self, interface: &Interface, chips: u64) -> u64 {
        let most = interface.timing.scan.integration_chips;
        shortened(interface, chips.clamp(self.shortest, most))
    }

    /// Whether groups can be made shorter.
    pub fn shortens(&self, interface: &Interface) -> bool {
        self.shortest < interface.timing.scan.integration_chips
    }

    /// Clocks of a scan, as short as can be.
    pub fn scan_clocks(&self, interface: &Interface) -> u64 {
        interface.groups().saturating_mul(self.shortest)
    }

    /// Groups after which all results of a group have been taken.
    pub fn groups_to_flush(&self, interface: &Interface) -> u64 {
        let beats = interface.beats_of_group();
        let latency = u64::from(interface.result_latency_clocks).max(peak_clocks(interface));
        let groups = |clocks: u64| clocks.div_ceil(self.shortest);
        match interface.histogram() {
            // Frames are long: the last one's rows, and what the receiver holds them for.
            Some(_) => groups(latency + beats + 2 + LONGEST_HOLD),
            None => groups(latency + beats + 2) + 1,
        }
    }
}
