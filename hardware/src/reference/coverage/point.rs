//! What a sensor can be made to do, point by point.

use crate::scene::{DetectorIndex, SourceIndex};

/// Something that a sensor can be made to do.
///
/// Detectors, steps of a group, lanes (samples of a word), beats of a group and ages
/// count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum CoverPoint {
    /// A result counts a hit of this lane, with this sign.
    Hit {
        /// Detector.
        detector: DetectorIndex,
        /// Step of the group.
        step: usize,
        /// Sample of the word.
        lane: u32,
        /// Counted up.
        up: bool,
    },
    /// A word with as many hits as it can hold, all of one sign.
    FullWord {
        /// Detector.
        detector: DetectorIndex,
        /// Counted up.
        up: bool,
    },
    /// A hit on the very first sample of a scan.
    FirstSample {
        /// Detector.
        detector: DetectorIndex,
    },
    /// A hit on the last sample before a scan, which does not count.
    BeforeScan {
        /// Detector.
        detector: DetectorIndex,
    },
    /// A hit on the last sample of a step, or on the first of one that follows another.
    StepBorder {
        /// Detector.
        detector: DetectorIndex,
        /// The first sample, and not the last.
        first: bool,
    },
    /// The running total crosses a multiple of 2^bit, where a carry or a borrow leaves a
    /// segment of the counter.
    Carry {
        /// Detector.
        detector: DetectorIndex,
        /// Step of the group.
        step: usize,
        /// Bits below.
        bit: u32,
        /// Upwards.
        up: bool,
    },
    /// A step's count borrows across this bit.
    Borrow {
        /// Detector.
        detector: DetectorIndex,
        /// Step of the group.
        step: usize,
        /// Bits below.
        bit: u32,
    },
    /// The same of the total of all hits: a carry, or a borrow of its difference.
    TotalCarry {
        /// Detector.
        detector: DetectorIndex,
        /// Bits below.
        bit: u32,
        /// A borrow, and not a carry.
        borrow: bool,
    },
    /// A count exactly at the end of its range, which is not saturated.
    Limit {
        /// Detector.
        detector: DetectorIndex,
        /// Step of the group.
        step: usize,
        /// The largest count, and not the smallest.
        up: bool,
    },
    /// This count is saturated, alone, and `o_saturated` rises for it.
    Saturation {
        /// Detector.
        detector: DetectorIndex,
        /// Step of the group.
        step: usize,
        /// Beyond the largest count.
        up: bool,
    },
    /// The same in a scan's last group.
    LastSaturation {
        /// Detector.
        detector: DetectorIndex,
        /// Step of the group.
        step: usize,
        /// Beyond the largest count.
        up: bool,
    },
    /// A step that a scan's last group does not have would be saturated, alone: the flag
    /// stays low.
    AbsentSaturation {
        /// Detector.
        detector: DetectorIndex,
        /// Step of the group.
        step: usize,
        /// Beyond the largest count.
        up: bool,
    },
    /// A total of hits at its limit, or beyond it with no count saturated.
    TotalSaturation {
        /// Detector.
        detector: DetectorIndex,
        /// Beyond, and not at it.
        beyond: bool,
    },
    /// A scan's largest count.
    Peak {
        /// Detector.
        detector: DetectorIndex,
        /// Which.
        kind: PeakKind,
    },
    /// This beat of a group stands for more than a clock, and is taken then.
    Held {
        /// Beat.
        beat: usize,
    },
    /// This beat stands while another group arrives, which is lost; it and all behind it
    /// are taken then.
    HeldAcross {
        /// Beat.
        beat: usize,
    },
    /// A group is lost.
    Lost {
        /// Where in its scan.
        place: Place,
    },
    /// A scan's last beat, with `m_axis_tlast`, stands while the next group arrives.
    LastHeldAcross,
    /// A group arrives with the very clock that takes the last beat of the one before.
    BackToBack,
    /// A group is lost because the last beat before it is taken a clock too late.
    TooLate,
    /// All beats of a group in successive clocks.
    Burst,
    /// A frame shows, and the one before it was lost.
    AfterLost,
    /// `o_overrun` rises: out of a single memory for this row of a frame, the first that is lost
    /// since reset; with two for a frame that ends while this row of the one before it stands.
    FirstLost {
        /// Row.
        beat: usize,
    },
    /// What a detector's histogram does.
    Bin {
        /// Detector.
        detector: DetectorIndex,
        /// What.
        point: BinPoint,
    },
    /// A reset of one clock, so many clocks after the one that took a group's last word.
    ResetAge {
        /// Clocks between.
        age: u32,
    },
    /// A reset of one clock while the only hits in the pipeline are those of the word so
    /// many clocks before it.
    ResetHit {
        /// Clocks between.
        age: u32,
    },
    /// A reset of one clock, so many clocks after the one that took a scan's last word;
    /// the peak of the next scan shows.
    PeakReset {
        /// Clocks between.
        age: u32,
    },
    /// A reset of one clock while this row of a frame stands.
    ResetAtRow {
        /// Row.
        beat: usize,
    },
    /// A reset in a state of the ports or the scan, and a result after it.
    Reset {
        /// The state.
        state: ResetState,
    },
    /// A result of the first scan after a reset, or of a later one.
    Result {
        /// Which step.
        place: Place,
        /// A scan that follows another.
        later_scan: bool,
    },
    /// A step of the full number of chips.
    WholeStep,
    /// A scan's end after every one of its steps, not one of them left out.
    WholeScan,
    /// The delay grows past a whole chip, or past the code period.
    DelayWraps {
        /// The code period.
        period: bool,
    },
    /// A source's code begins anew.
    CodeWraps {
        /// The source.
        source: SourceIndex,
    },
}

/// What a histogram does. Lanes are samples of a word; adders serve neighbouring lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum BinPoint {
    /// A hit of this lane counts in the first code period of a frame, or in a later one.
    Hit {
        /// Sample of the word.
        lane: u32,
        /// In a later one.
        later: bool,
    },
    /// A bin of this lane had counts in the frame that its memory held before, and has
    /// none now.
    Emptied {
        /// Sample of the word.
        lane: u32,
    },
    /// A bin's count comes to 2^bit.
    Carry {
        /// Adder.
        adder: u32,
        /// The bit.
        bit: u32,
    },
    /// A bin of this lane with its top bit set is read out of this memory.
    Top {
        /// Sample of the word.
        lane: u32,
        /// The memory.
        memory: usize,
    },
    /// A word with a hit at each adder.
    FullRow,
    /// Several hits at one adder in a word.
    Extra {
        /// Adder.
        adder: u32,
    },
    /// A hit on the first sample of a frame, or on its last.
    Border {
        /// The first.
        first: bool,
    },
    /// A bin at its limit.
    Full {
        /// Sample of the word.
        lane: u32,
    },
    /// A hit finds its bin full, alone, and `o_saturated` rises for it.
    Clamped {
        /// Adder.
        adder: u32,
    },
}

/// What cover points belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Single hits.
    Hits,
    /// Carries and borrows of counters.
    Carries,
    /// Counts at their limits.
    Saturation,
    /// A scan's largest count.
    Peaks,
    /// Results on the stream.
    Stream,
    /// Bins of a histogram.
    Bins,
    /// What a reset comes upon.
    Resets,
    /// Steps, scans, codes.
    Scans,
}

impl Family {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Family::Hits => "hits",
            Family::Carries => "carries",
            Family::Saturation => "saturation",
            Family::Peaks => "peaks",
            Family::Stream => "stream",
            Family::Bins => "bins",
            Family::Resets => "resets",
            Family::Scans => "scans",
        }
    }
}

/// A kind of a scan's largest count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum PeakKind {
    /// Below zero.
    Negative,
    /// Above zero.
    Positive,
    /// That of the first step.
    First,
    /// That of the last step.
    Last,
    /// There is an equal one behind it.
    Equal,
    /// That of this step of its group, with no equal one.
    Step(usize),
}

/// A place in a scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Place {
    /// The first group of steps.
    First,
    /// Neither.
    Middle,
    /// The last.
    Last,
}

/// What a reset comes upon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ResetState {
    /// It is as long as one clock.
    OneClock,
    /// Two clocks.
    TwoClocks,
    /// Longer than all pipelines.
    Long,
    /// A result waits.
    Waiting,
    /// A result waits, and from the reset on until the next one stands nobody would take it.
    Stalled,
    /// `o_overrun` is high.
    Overrun,
    /// `o_saturated` is high.
    Saturated,
    /// Between two scans.
    Pause,
    /// It is one clock long, and the word of that clock has a hit.
    Hit,
}

impl CoverPoint {
    /// The detector that it is about; none of what concerns the sensor as a whole.
    pub(super) fn detector(&self) -> Option<DetectorIndex> {
        use CoverPoint::*;
        match *self {
            Hit { detector, .. }
            | FullWord { detector, .. }
            | FirstSample { detector }
            | BeforeScan { detector }
            | StepBorder { detector, .. }
            | Carry { detector, .. }
            | Borrow { detector, .. }
            | TotalCarry { detector, .. }
            | Limit { detector, .. }
            | Saturation { detector, .. }
            | LastSaturation { detector, .. }
            | AbsentSaturation { detector, .. }
            | TotalSaturation { detector, .. }
            | Peak { detector, .. }
            | Bin { detector, .. } => Some(detector),
            _ => None,
        }
    }

    /// What it belongs to.
    pub fn family(&self) -> Family {
        use CoverPoint::*;
        match self {
            Hit { .. }
            | FullWord { .. }
            | FirstSample { .. }
            | BeforeScan { .. }
            | StepBorder { .. } => Family::Hits,
            Carry { .. } | Borrow { .. } | TotalCarry { .. } => Family::Carries,
            Limit { .. }
            | Saturation { .. }
            | LastSaturation { .. }
            | AbsentSaturation { .. }
            | TotalSaturation { .. } => Family::Saturation,
            Peak { .. } => Family::Peaks,
            Held { .. }
            | HeldAcross { .. }
            | Lost { .. }
            | LastHeldAcross
            | BackToBack
            | TooLate
            | Burst
            | AfterLost
            | FirstLost { .. } => Family::Stream,
            Bin { .. } => Family::Bins,
            ResetAge { .. }
            | ResetHit { .. }
            | PeakReset { .. }
            | ResetAtRow { .. }
            | Reset { .. } => Family::Resets,
            Result { .. } | WholeStep | WholeScan | DelayWraps { .. } | CodeWraps { .. } => {
                Family::Scans
            }
        }
    }
}

impl PeakKind {
    /// All of them but those of a step.
    pub const PLAIN: [PeakKind; 5] =
        [PeakKind::Negative, PeakKind::Positive, PeakKind::First, PeakKind::Last, PeakKind::Equal];
}

impl Place {
    /// Of a group among so many.
    pub fn of(group: u64, groups: u64) -> Place {
        match group {
            _ if group + 1 == groups => Place::Last,
            0 => Place::First,
            _ => Place::Middle,
        }
    }
}
