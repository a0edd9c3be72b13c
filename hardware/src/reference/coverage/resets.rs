//! Cover points of what a reset comes upon.

use super::stream::rows_at_borders;
use super::{Hindered, PointFamily, saturation};
use crate::reference::group_maker::GroupMaker;
use crate::reference::planned::{Hits, Length, PlannedGroup, ReceiverPlan};
use crate::scene::DetectorIndex;
use crate::sensor::interface::{Counting, Interface};

const SHORT_STEPS: &str =
    "steps are shorter than the pipeline: a group's end is never that long ago";

/// When a reset comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ResetPoint {
    /// One of one clock, so many clocks after the one that took a group's last word.
    Age {
        /// Clocks between.
        age: u32,
    },
    /// One of one clock while the only hits in the pipeline are those of the word so
    /// many clocks before it.
    Hit {
        /// Clocks between.
        age: u32,
    },
    /// One of one clock, so many clocks after the one that took a scan's last word;
    /// the peak of the next scan shows.
    Peak {
        /// Clocks between.
        age: u32,
    },
    /// One of one clock while this row of a frame stands.
    AtRow {
        /// Row.
        beat: usize,
    },
    /// One in a state of the ports or the scan, and a result after it.
    In {
        /// The state.
        state: ResetState,
    },
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

/// All of them.
pub(super) fn points(interface: &Interface) -> Vec<Hindered<ResetPoint>> {
    let chips = interface.timing.scan.integration_chips;
    let ages = (0..=interface.result_latency_clocks).map(|age| {
        // Unless it is the end of a scan, and a pause follows.
        let hidden = u64::from(age) >= chips && !interface.realigns();
        (ResetPoint::Age { age }, hidden.then_some(SHORT_STEPS))
    });
    let mut points: Vec<_> = ages.collect();
    points.extend((0..interface.clocks_of_hit()).map(|age| (ResetPoint::Hit { age }, None)));
    points.extend((0..interface.peak_latency_clocks()).map(|age| {
        let hidden = u64::from(age) >= interface.scan_clocks();
        (ResetPoint::Peak { age }, hidden.then_some(SHORT_STEPS))
    }));
    if let Some(plan) = interface.histogram() {
        let rows = rows_at_borders(interface, plan).into_iter();
        points.extend(rows.map(|beat| (ResetPoint::AtRow { beat }, None)));
    }
    let states = [
        (ResetState::OneClock, true),
        (ResetState::TwoClocks, true),
        (ResetState::Long, true),
        (ResetState::Waiting, true),
        (ResetState::Stalled, true),
        (ResetState::Overrun, true),
        (ResetState::Hit, true),
        (ResetState::Saturated, interface.saturates()),
        (ResetState::Pause, interface.realigns() && !ends_at_epochs(interface)),
    ];
    let present = states.into_iter().filter(|&(_, exists)| exists);
    points.extend(present.map(|(state, _)| {
        let hindrance = match state {
            ResetState::Saturated => saturation::hindrance(interface),
            _ => None,
        };
        (ResetPoint::In { state }, hindrance)
    }));
    points
}

/// Whether every scan ends just before an epoch, so that none waits for one.
fn ends_at_epochs(interface: &Interface) -> bool {
    let period = interface.reference_codes[0].len();
    interface.scan_clocks().is_multiple_of(period)
}

impl PointFamily for ResetPoint {
    fn text(&self) -> String {
        let after = |age, of| format!("a reset of one clock {age} clocks after {of}");
        match *self {
            ResetPoint::Age { age } => after(age, "a group's last word"),
            ResetPoint::Hit { age } => after(age, "a lone hit"),
            ResetPoint::Peak { age } => after(age, "a scan's last word"),
            ResetPoint::AtRow { beat } => {
                format!("a reset of one clock while row {beat} of a frame stands")
            }
            ResetPoint::In { state } => format!("a reset {}", state.text()),
        }
    }

    fn recipe(&self, maker: &GroupMaker) -> Result<Vec<PlannedGroup>, String> {
        let plain = PlannedGroup::random;
        Ok(match *self {
            ResetPoint::Age { age } => {
                // Behind a scan's end alone a group does not follow at once.
                let mut plans = match u64::from(age) < maker.reach.shortest {
                    true => vec![dense(maker)],
                    false => maker.scan(dense(maker), plain())?,
                };
                plans.push(plain().after_reset(u64::from(age), 1));
                plans
            }
            ResetPoint::Hit { age } => {
                let age = u64::from(age);
                let depth = u64::from(maker.interface.clocks_of_hit());
                let cut = Some(age + depth + 2);
                let hit = maker.fresh().with(Hits::BeforeCut { age });
                vec![PlannedGroup { cut, ..hit }, plain().after_reset(0, 1)]
            }
            ResetPoint::Peak { age } => {
                let mut plans = maker.scan(maker.fresh(), plain())?;
                let next = plain().after_reset(u64::from(age), 1);
                plans.extend(maker.scan(next, plain())?);
                plans
            }
            ResetPoint::AtRow { beat } => {
                let histogram = maker.interface.histogram();
                let rows = histogram.map(|plan| rows_at_borders(maker.interface, plan));
                maker.row_by_row(rows.unwrap_or_default(), beat, |row| at_row(maker, row))
            }
            ResetPoint::In { state } => in_state(maker, state)?,
        })
    }
}

/// A group with many hits, behind a reset.
fn dense(maker: &GroupMaker) -> PlannedGroup {
    maker.fresh().with(Hits::OneSided { step: 0, up: true })
}

fn in_state(maker: &GroupMaker, state: ResetState) -> Result<Vec<PlannedGroup>, String> {
    let plain = PlannedGroup::random;
    let latency = u64::from(maker.interface.result_latency_clocks);
    let behind_results = plain().after_reset(latency + 2, 1);
    Ok(match state {
        ResetState::TwoClocks => vec![dense(maker), plain().after_reset(1, 2)],
        ResetState::Hit => vec![dense(maker), plain().after_reset(0, 1)],
        ResetState::Waiting | ResetState::Overrun => {
            vec![dense(maker), plain().received(ReceiverPlan::Stalls), behind_results]
        }
        ResetState::Stalled => {
            // Until the result of the group behind the reset stands.
            let shortest = maker.reach.shortest;
            let clocks = 2 * latency + shortest + 16 + maker.interface.lead_clocks();
            let stalls = ReceiverPlan::StopsAt { beat: 0, clocks };
            let after = behind_results.long(Length::Exactly(shortest));
            vec![dense(maker), plain().received(stalls), after]
        }
        ResetState::Saturated => {
            let clamp = match &maker.interface.counting {
                Counting::Correlator(correlator) => {
                    let count = 1i64 << (correlator.count_bits - 1);
                    Hits::Count { detector: DetectorIndex(0), step: 0, count }
                }
                Counting::Histogram(_) => Hits::EveryOther,
            };
            vec![maker.fresh().with(clamp), behind_results]
        }
        ResetState::Pause => {
            let mut plans = maker.scan(maker.fresh(), plain())?;
            plans.push(plain().after_reset(0, 1));
            plans
        }
        ResetState::OneClock | ResetState::Long => vec![dense(maker), maker.fresh()],
    })
}

/// A reset while a row stands, and a frame behind it that is read.
fn at_row(maker: &GroupMaker, row: u64) -> Vec<PlannedGroup> {
    let latency = u64::from(maker.interface.result_latency_clocks);
    let (cut, age) = maker.cut_at(latency + row);
    let after = PlannedGroup::random().with(Hits::EveryOther).after_reset(age, 1);
    vec![cut, after, PlannedGroup::random()]
}

impl ResetState {
    fn text(self) -> &'static str {
        match self {
            ResetState::OneClock => "of one clock",
            ResetState::TwoClocks => "of two clocks",
            ResetState::Long => "longer than all pipelines",
            ResetState::Waiting => "while a result waits",
            ResetState::Stalled => {
                "while a result waits, with m_axis_tready low until the next one stands"
            }
            ResetState::Overrun => "while o_overrun is high",
            ResetState::Saturated => "while o_saturated is high",
            ResetState::Pause => "between two scans",
            ResetState::Hit => "of one clock with a hit in its word",
        }
    }
}
