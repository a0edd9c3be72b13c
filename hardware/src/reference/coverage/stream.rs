//! Cover points of results on the stream.

use super::scans::{GroupPosition, places};
use super::{Hindered, PointFamily, steps};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Length, PlannedGroup, ReceiverPlan};
use crate::scene::DetectorIndex;
use crate::sensor::histogram::{CLOCKS_TO_ROW, HistogramPlan};
use crate::sensor::interface::Interface;

/// Clocks that may be spent on first losses row by row.
const MOST_CLOCKS_OF_LOSSES: u64 = 1 << 18;

/// What becomes of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum StreamPoint {
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
        place: GroupPosition,
    },
    /// A scan's last beat, with `m_axis_tlast`, stands while the next group arrives.
    LastHeldAcross,
    /// A group arrives with the very clock that takes the last beat of the one before.
    BackToBack,
    /// The same of a scan's last group, whose last beat shows.
    LastBackToBack,
    /// A group arrives with the very clock that takes a scan's last beat.
    BehindLastBackToBack,
    /// A group arrives with the very clock that takes the last beat before it, when another has been
    /// lost since reset.
    BackToBackAfterLost,
    /// A group is lost because the last beat before it is taken a clock too late.
    TooLate,
    /// A second group is lost while the same beat stands; it and all behind it are taken then.
    LostAgain,
    /// A scan's last beat shows while `o_overrun` is high.
    LastAfterOverrun,
    /// A frame is lost in a clock in which a row of the one before is taken.
    LostAsTaken,
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
}

/// Those of counts.
pub(super) fn of_counts(interface: &Interface) -> Vec<Hindered<StreamPoint>> {
    let groups = interface.groups();
    let beats = interface.reference_codes.len() * steps(interface).len();
    let mut points = Vec::new();
    for beat in 0..beats {
        points.extend([StreamPoint::Held { beat }, StreamPoint::HeldAcross { beat }]);
    }
    points.extend(places(groups).map(|place| StreamPoint::Lost { place }));
    points.extend([
        StreamPoint::LastHeldAcross,
        StreamPoint::BackToBack,
        StreamPoint::LastBackToBack,
        StreamPoint::BehindLastBackToBack,
        StreamPoint::BackToBackAfterLost,
        StreamPoint::TooLate,
        StreamPoint::LostAgain,
        StreamPoint::LastAfterOverrun,
    ]);
    let mut points: Vec<_> = points.into_iter().map(|point| (point, None)).collect();
    if beats > 1 {
        let chips = interface.timing.scan.integration_chips;
        let hurried = chips < beats as u64 && groups > 1;
        let reason = "a group has more results than its steps have clocks";
        points.push((StreamPoint::Burst, hurried.then_some(reason)));
    }
    points
}

/// Those of the rows of a frame.
pub(super) fn of_rows(interface: &Interface, plan: &HistogramPlan) -> Vec<Hindered<StreamPoint>> {
    let lost = rows_that_may_be_lost(interface, plan);
    let mut points: Vec<_> = lost.iter().map(|&beat| StreamPoint::Held { beat }).collect();
    // Out of a single memory every row that is held, but the last, stands while one is lost.
    if plan.takes_turns() {
        let rows = plan.rows as usize;
        let detectors = 1..=interface.reference_codes.len();
        let mut beats = vec![0, 1, 2, rows / 2];
        beats.extend(detectors.flat_map(|d| [d * rows - 2, d * rows - 1, d * rows]));
        beats.retain(|&beat| beat < interface.beats_of_group() as usize);
        points.extend(beats.into_iter().map(|beat| StreamPoint::HeldAcross { beat }));
    }
    points.extend(lost.into_iter().map(|beat| StreamPoint::FirstLost { beat }));
    if plan.takes_turns() {
        points.extend([StreamPoint::LostAgain, StreamPoint::LostAsTaken]);
    }
    points.extend([
        StreamPoint::Lost { place: GroupPosition::Last },
        StreamPoint::LastHeldAcross,
        StreamPoint::BackToBack,
        StreamPoint::TooLate,
        StreamPoint::Burst,
        StreamPoint::AfterLost,
    ]);
    points.into_iter().map(|point| (point, None)).collect()
}

/// Rows of a frame: its first ones, one in the middle, and those round the places where
/// detectors change and the frame ends, as far as the reader is ahead of the stream.
pub(super) fn rows_at_borders(interface: &Interface, plan: &HistogramPlan) -> Vec<usize> {
    let rows = plan.rows as usize;
    let detectors = interface.reference_codes.len();
    let ahead = CLOCKS_TO_ROW as usize + 2;
    let mut beats: Vec<usize> = vec![0, 1, 2, rows / 2];
    beats.extend((1..=detectors).flat_map(|d| d * rows - ahead..d * rows + 2));
    beats.retain(|&beat| beat < detectors * rows);
    beats.sort_unstable();
    beats.dedup();
    beats
}

/// Rows at which the first loss since reset is looked for: all of them, or where frames are
/// long those at borders. A loss takes two frames of its own.
fn rows_that_may_be_lost(interface: &Interface, plan: &HistogramPlan) -> Vec<usize> {
    let beats = interface.beats_of_group();
    let clocks = beats.saturating_mul(2 * interface.timing.scan.integration_chips);
    match clocks <= MOST_CLOCKS_OF_LOSSES {
        true => (0..beats as usize).collect(),
        false => rows_at_borders(interface, plan),
    }
}

impl PointFamily for StreamPoint {
    fn text(&self) -> String {
        match *self {
            StreamPoint::Held { beat } => format!("beat {beat} of a group held by the receiver"),
            StreamPoint::HeldAcross { beat } => {
                format!("beat {beat} of a group held while a group is lost")
            }
            StreamPoint::Lost { place } => format!("the {} group of a scan lost", place.text()),
            StreamPoint::LastHeldAcross => {
                "a scan's last beat held while a group is lost".to_owned()
            }
            StreamPoint::BackToBack => {
                "a group that arrives as the last beat before it is taken".to_owned()
            }
            StreamPoint::LastBackToBack => {
                "a scan's last group that arrives as the last beat before it is taken".to_owned()
            }
            StreamPoint::BehindLastBackToBack => {
                "a group that arrives as a scan's last beat is taken".to_owned()
            }
            StreamPoint::BackToBackAfterLost => {
                "a group that arrives as the last beat before it is taken, after one was lost"
                    .to_owned()
            }
            StreamPoint::LostAgain => "a second group lost while a beat is held".to_owned(),
            StreamPoint::LastAfterOverrun => "a scan's last beat after a group was lost".to_owned(),
            StreamPoint::LostAsTaken => {
                "a frame lost as a row of the one before is taken".to_owned()
            }
            StreamPoint::TooLate => "a group lost by a single clock".to_owned(),
            StreamPoint::Burst => "a group taken in successive clocks".to_owned(),
            StreamPoint::AfterLost => "a frame behind one that was lost".to_owned(),
            StreamPoint::FirstLost { beat } => {
                format!("the first loss since reset at row {beat} of a frame")
            }
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let plain = PlannedGroup::random;
        let histogram = maker.interface.histogram();
        let just_in_time = ReceiverPlan::TakesLastAfter { clocks: 0 };
        let receiver = match (*self, histogram) {
            // On the way the rows behind it are held, too, or every other one.
            (StreamPoint::Held { beat }, Some(_)) => ReceiverPlan::HoldsEach { beat: beat as u64 },
            (StreamPoint::Held { beat }, None) => ReceiverPlan::Holds { beat: beat as u64 },
            (StreamPoint::HeldAcross { beat }, _) => {
                ReceiverPlan::HoldsAcross { beat: beat as u64 }
            }
            (StreamPoint::AfterLost, _) => {
                let lost = plain().received(ReceiverPlan::HoldsAcross { beat: 0 });
                return Ok(vec![maker.fresh(), lost, plain()]);
            }
            (StreamPoint::BackToBack, _) => just_in_time,
            (StreamPoint::LastBackToBack, _) if maker.interface.groups() > 1 => {
                return maker.scan(maker.fresh(), plain().received(just_in_time));
            }
            (StreamPoint::LastBackToBack, _) => just_in_time,
            (StreamPoint::BehindLastBackToBack, _) => {
                let mut plans = maker.scan(maker.fresh(), plain())?;
                plans.push(plain().received(just_in_time));
                return Ok(plans);
            }
            (StreamPoint::BackToBackAfterLost, _) => {
                let lost = plain().received(ReceiverPlan::HoldsAcross { beat: 0 });
                return Ok(vec![maker.fresh(), lost, plain(), plain().received(just_in_time)]);
            }
            (StreamPoint::TooLate, _) => ReceiverPlan::TakesLastAfter { clocks: 1 },
            (StreamPoint::LostAgain, _) => {
                let length = Length::Exactly(maker.reach.shortest);
                let pause = pause_of_few_groups(maker.interface);
                let clocks = 2 * maker.reach.shortest + pause + 8;
                let stops = plain().received(ReceiverPlan::StopsAt { beat: 0, clocks });
                let mut plans = vec![maker.fresh(), stops.long(length), plain().long(length)];
                // Until what stands is taken.
                let groups = 1 + pause / maker.reach.shortest;
                plans.extend((0..groups).map(|_| plain()));
                return Ok(plans);
            }
            (StreamPoint::LastAfterOverrun, _) => {
                let lost = plain().received(ReceiverPlan::HoldsAcross { beat: 0 });
                let mut plans = maker.scan(maker.fresh(), lost)?;
                plans.extend(maker.scan(plain(), plain())?);
                return Ok(plans);
            }
            (StreamPoint::LostAsTaken, _) => {
                ReceiverPlan::TakesLastAfter { clocks: maker.beats().div_ceil(2) }
            }
            (
                StreamPoint::LastHeldAcross | StreamPoint::Lost { place: GroupPosition::First },
                _,
            ) => {
                let mut plans = maker.scan(maker.fresh(), plain())?;
                plans.push(plain().received(ReceiverPlan::HoldsAcross { beat: maker.beats() }));
                return Ok(plans);
            }
            (StreamPoint::Lost { place: GroupPosition::Last }, _)
                if maker.interface.groups() > 1 =>
            {
                let last = plain().received(ReceiverPlan::HoldsAcross { beat: 0 });
                return maker.scan(maker.fresh(), last);
            }
            (StreamPoint::Lost { .. }, _) => ReceiverPlan::HoldsAcross { beat: 0 },
            (StreamPoint::FirstLost { beat }, Some(plan)) => {
                let rows = rows_that_may_be_lost(maker.interface, plan);
                return Ok(maker.row_by_row(rows, beat, |row| first_loss(maker, plan, row)));
            }
            (StreamPoint::Burst | StreamPoint::FirstLost { .. }, _) => ReceiverPlan::Takes,
        };
        Ok(vec![maker.fresh(), plain().received(receiver)])
    }
}

/// Most clocks between a group and the next within three, where a scan has no more: its codes begin anew.
fn pause_of_few_groups(interface: &Interface) -> u64 {
    match interface.groups() <= 3 && interface.realigns() {
        true => interface.reference_codes[DetectorIndex(0)].len() + interface.lead_clocks(),
        false => 0,
    }
}

/// A frame is there to be read: from the second on it is lost, or a row of it, and a reset
/// ends what was lost.
fn first_loss(maker: &GroupMaker, plan: &HistogramPlan, row: u64) -> Vec<PlannedGroup> {
    let latency = u64::from(maker.interface.result_latency_clocks);
    let plain = PlannedGroup::random;
    let before = match plan.takes_turns() {
        // A frame that ends is lost.
        true => Some(row),
        // The frame's first row is, while the last one of the frame before stands.
        false if row == 0 => Some(maker.beats() - 1),
        false => None,
    };
    let (mut plans, age) = match before {
        Some(beat) => {
            let holds = ReceiverPlan::StopsAt { beat, clocks: latency + 2 };
            let (cut, age) = maker.cut_at(latency + 2);
            (vec![plain().received(holds), cut], age)
        }
        None => {
            let (cut, age) = maker.cut_at(latency + row + 2);
            let holds = ReceiverPlan::StopsAt { beat: row - 1, clocks: age + 2 };
            (vec![cut.received(holds)], age)
        }
    };
    plans.push(plain().after_reset(age, 1));
    plans
}
