//! For each cover point, groups of phase steps that should reach it.

use super::plan::{GroupPlan, Hits, Lead, Length, Reach, Receiver};
use crate::reference::coverage::{BinPoint, CoverPoint, Family, PeakKind, Place, ResetState};
use crate::scene::DetectorIndex;
use crate::sensor::interface::Interface;
use crate::sensor::layout::mask;

/// The way to a cover point, or why it is too long.
///
/// Every recipe begins with a reset, so that it works wherever the one before it
/// ended.
pub(super) fn recipe(
    interface: &Interface,
    reach: &Reach,
    point: CoverPoint,
) -> Result<Vec<GroupPlan>, String> {
    let kitchen = Kitchen { interface, reach };
    let mut plans = match point.family() {
        Family::Stream | Family::Resets if interface.histogram().is_some() => {
            kitchen.frames(point)?
        }
        Family::Saturation => kitchen.saturations(point)?,
        Family::Peaks => kitchen.peaks(point)?,
        Family::Stream => kitchen.stream(point)?,
        Family::Resets => kitchen.resets(point)?,
        Family::Scans => kitchen.scans(point)?,
        Family::Bins => kitchen.bins(point),
        Family::Hits | Family::Carries => kitchen.hits(point),
    };
    let flush = reach.groups_to_flush(interface);
    let chips: u64 = plans.iter().map(|plan| kitchen.chips_of(plan)).sum();
    let clocks = chips.saturating_add(flush.saturating_mul(reach.shortest));
    if clocks > reach.most_clocks {
        return Err(format!("it takes {clocks} clocks"));
    }
    plans.extend((0..flush).map(|_| GroupPlan::random()));
    Ok(plans)
}

/// What recipes are made from.
pub(super) struct Kitchen<'a> {
    pub(super) interface: &'a Interface,
    pub(super) reach: &'a Reach,
}

impl Kitchen<'_> {
    pub(super) fn fresh(&self) -> GroupPlan {
        GroupPlan::fresh(self.interface)
    }

    /// Beats of a group.
    pub(super) fn beats(&self) -> u64 {
        self.interface.beats_of_group()
    }

    pub(super) fn chips_of(&self, plan: &GroupPlan) -> u64 {
        let most = self.interface.timing.scan.integration_chips;
        match plan.length {
            _ if plan.cut.is_some_and(|chips| chips < most) => plan.cut.unwrap_or(most),
            Length::Short => self.reach.shortest,
            Length::AtLeast(chips) => chips.clamp(self.reach.shortest, most),
            Length::Whole => most,
            Length::Exactly(chips) => chips,
        }
    }

    /// Groups up to the scan's last but one, after the `first` one of a scan; the last
    /// one follows.
    fn to_the_end(&self, first: GroupPlan) -> Result<Vec<GroupPlan>, String> {
        let groups = self.interface.groups();
        if self.reach.leaves_out {
            return Ok(vec![first.then_the_last()]);
        }
        let clocks = self.reach.scan_clocks(self.interface);
        if clocks > self.reach.most_clocks {
            return Err(format!("a scan takes {clocks} clocks"));
        }
        let filler = GroupPlan { reset: None, ..first.clone() };
        let mut plans = vec![first; usize::from(groups > 1)];
        plans.extend((2..groups).map(|_| filler.clone()));
        Ok(plans)
    }

    /// A whole scan; `last` is its last group.
    fn scan(&self, first: GroupPlan, last: GroupPlan) -> Result<Vec<GroupPlan>, String> {
        let reset = first.reset;
        let mut plans = self.to_the_end(first)?;
        let is_alone = plans.is_empty();
        plans.push(last);
        if is_alone {
            plans[0].reset = reset;
        }
        Ok(plans)
    }

    /// The same hits in a fresh group and in so many after it.
    fn again(&self, groups: u64, hits: Hits, length: Length) -> Vec<GroupPlan> {
        let mut plans = vec![self.fresh().with(hits).long(length)];
        plans.extend((0..groups).map(|_| GroupPlan::random().with(hits).long(length)));
        plans
    }

    fn hits(&self, point: CoverPoint) -> Vec<GroupPlan> {
        let plain = GroupPlan::random;
        let chips = self.interface.timing.scan.integration_chips;
        let lanes = u64::from(self.interface.lanes());
        match point {
            CoverPoint::Hit { detector, step, lane, up } => {
                // The sign that is wanted may come only later.
                let code = self.interface.reference_codes[detector].len();
                let groups = (code / chips).clamp(1, 40) + 1;
                let one = Hits::One { detector, step: step as u64, lane: u64::from(lane), up };
                self.again(groups, one, Length::AtLeast(code.min(512)))
            }
            CoverPoint::FullWord { .. } => vec![
                self.fresh().with(Hits::EveryOther).long(Length::AtLeast(128)),
                plain().with(Hits::EveryOther).long(Length::AtLeast(128)),
            ],
            CoverPoint::BeforeScan { .. } => {
                vec![GroupPlan { lead: Lead::LastSample, ..self.fresh() }]
            }
            CoverPoint::FirstSample { .. } => {
                vec![self.fresh().with(Hits::Border { first: true })]
            }
            CoverPoint::StepBorder { first, .. } => {
                vec![self.fresh().with(Hits::None), plain().with(Hits::Border { first })]
            }
            CoverPoint::TotalCarry { bit, .. } => {
                let chips = (1u64 << bit).div_ceil((lanes / 2).max(1)) * 2;
                let groups = chips.div_ceil(self.interface.timing.scan.integration_chips) + 2;
                self.again(groups, Hits::EveryOther, Length::AtLeast(chips.div_ceil(2)))
            }
            CoverPoint::Carry { step, .. } | CoverPoint::Borrow { step, .. } => {
                let step = step as u64;
                let side = |up| Hits::OneSided { step, up };
                let long = Length::AtLeast(64);
                vec![
                    self.fresh().with(side(false)).long(long),
                    plain().with(side(true)).long(Length::AtLeast(160)),
                    plain().with(side(false)).long(Length::AtLeast(320)),
                    plain().with(side(true)).long(Length::AtLeast(640)),
                ]
            }
            _ => vec![self.fresh()],
        }
    }

    fn bins(&self, point: CoverPoint) -> Vec<GroupPlan> {
        let CoverPoint::Bin { detector, point } = point else {
            return Vec::new();
        };
        let Some(plan) = self.interface.histogram() else {
            return Vec::new();
        };
        let lane = |lane| Hits::Lane { detector, lane };
        let of_adder = |adder: u32| lane(u64::from(adder * plan.adder_samples));
        let plain = GroupPlan::random;
        match point {
            BinPoint::Hit { lane: l, .. } | BinPoint::Full { lane: l } => {
                vec![self.fresh().with(lane(l.into()))]
            }
            // The frame after the next has the first one's memory, or the next.
            BinPoint::Emptied { lane: l } => vec![
                self.fresh().with(lane(l.into())),
                plain().with(Hits::None),
                plain().with(Hits::None),
            ],
            // Each frame that is read has the other memory.
            BinPoint::Top { lane: l, memory } => {
                let behind = (0..memory).map(|_| plain().with(lane(l.into())));
                std::iter::once(self.fresh().with(lane(l.into()))).chain(behind).collect()
            }
            BinPoint::Carry { adder, .. } => vec![self.fresh().with(of_adder(adder))],
            BinPoint::Clamped { adder } => {
                vec![self.fresh().with(Hits::None), plain().with(of_adder(adder))]
            }
            BinPoint::FullRow | BinPoint::Extra { .. } => {
                vec![self.fresh().with(Hits::EveryOther)]
            }
            BinPoint::Border { first } => {
                vec![self.fresh().with(Hits::None), plain().with(Hits::Border { first })]
            }
        }
    }

    fn saturations(&self, point: CoverPoint) -> Result<Vec<GroupPlan>, String> {
        let limit = 1i64 << (self.interface.count_bits() - 1);
        let count = |up: bool, beyond: i64| {
            if up { limit - 1 + beyond } else { -limit - beyond }
        };
        let hits = match point {
            CoverPoint::Limit { detector, step, up } => {
                Hits::Count { detector, step: step as u64, count: count(up, 0) }
            }
            CoverPoint::Saturation { detector, step, up }
            | CoverPoint::LastSaturation { detector, step, up }
            | CoverPoint::AbsentSaturation { detector, step, up } => {
                Hits::Count { detector, step: step as u64, count: count(up, 1) }
            }
            CoverPoint::TotalSaturation { detector, beyond } => Hits::Total {
                detector,
                hits: self.interface.total().map_or(0, |t| mask(t.bits)) + u64::from(beyond),
            },
            _ => Hits::Random,
        };
        if let CoverPoint::LastSaturation { .. } | CoverPoint::AbsentSaturation { .. } = point {
            let quiet = self.fresh().with(Hits::None);
            return self.scan(quiet, GroupPlan::random().with(hits));
        }
        // The first group of a scan, or a later one: their signs differ.
        let age = u64::from(self.interface.result_latency_clocks) + self.beats() + 2;
        let later = GroupPlan::random().with(hits);
        Ok(vec![self.fresh().with(hits), later.clone().after_reset(age, 2), later])
    }

    fn peaks(&self, point: CoverPoint) -> Result<Vec<GroupPlan>, String> {
        let CoverPoint::Peak { kind, .. } = point else {
            return Ok(Vec::new());
        };
        let side = |up| Hits::AllSteps { up };
        let (first, last) = match kind {
            PeakKind::Step(step) => {
                let limit = 1i64 << (self.interface.count_bits() - 1);
                let (step, count) = (step as u64, 4.min(limit - 1));
                let CoverPoint::Peak { detector, .. } = point else {
                    return Ok(Vec::new());
                };
                let one = Hits::Count { detector, step, count };
                (one, Hits::None)
            }
            PeakKind::Negative => (side(false), side(false)),
            PeakKind::Positive => (side(true), side(true)),
            PeakKind::First => (side(true), side(false)),
            PeakKind::Last => (side(false), side(true)),
            PeakKind::Equal => (Hits::None, Hits::None),
        };
        let long = Length::AtLeast(96);
        let mut plans = self.to_the_end(self.fresh().with(first).long(long))?;
        if kind == PeakKind::Last {
            plans.iter_mut().for_each(|plan| plan.hits = side(false));
        } else if matches!(kind, PeakKind::First | PeakKind::Step(_)) {
            plans.iter_mut().skip(1).for_each(|plan| plan.hits = last);
        }
        let reset = plans.is_empty().then_some(self.fresh().reset).flatten();
        let last = GroupPlan::random().with(last).long(long);
        plans.push(GroupPlan { reset, ..last });
        Ok(plans)
    }

    pub(super) fn stream(&self, point: CoverPoint) -> Result<Vec<GroupPlan>, String> {
        let plain = GroupPlan::random;
        let receiver = match point {
            CoverPoint::Held { beat } => Receiver::Holds { beat: beat as u64 },
            CoverPoint::HeldAcross { beat } => Receiver::HoldsAcross { beat: beat as u64 },
            CoverPoint::AfterLost => {
                let lost = plain().received(Receiver::HoldsAcross { beat: 0 });
                return Ok(vec![self.fresh(), lost, plain()]);
            }
            CoverPoint::BackToBack => Receiver::TakesLastAfter { clocks: 0 },
            CoverPoint::TooLate => Receiver::TakesLastAfter { clocks: 1 },
            CoverPoint::LastHeldAcross | CoverPoint::Lost { place: Place::First } => {
                let mut plans = self.scan(self.fresh(), plain())?;
                plans.push(plain().received(Receiver::HoldsAcross { beat: self.beats() }));
                return Ok(plans);
            }
            CoverPoint::Lost { place: Place::Last } if self.interface.groups() > 1 => {
                let last = plain().received(Receiver::HoldsAcross { beat: 0 });
                return self.scan(self.fresh(), last);
            }
            CoverPoint::Lost { .. } => Receiver::HoldsAcross { beat: 0 },
            _ => Receiver::Takes,
        };
        Ok(vec![self.fresh(), plain().received(receiver)])
    }

    pub(super) fn resets(&self, point: CoverPoint) -> Result<Vec<GroupPlan>, String> {
        let plain = GroupPlan::random;
        let latency = u64::from(self.interface.result_latency_clocks);
        let dense = self.fresh().with(Hits::OneSided { step: 0, up: true });
        Ok(match point {
            CoverPoint::ResetAge { age } => {
                vec![dense, plain().after_reset(u64::from(age), 1)]
            }
            CoverPoint::ResetHit { age } => {
                let age = u64::from(age);
                let depth = u64::from(self.interface.clocks_of_hit());
                let cut = Some(age + depth + 2);
                let hit = self.fresh().with(Hits::BeforeCut { age });
                vec![GroupPlan { cut, ..hit }, plain().after_reset(0, 1)]
            }
            CoverPoint::PeakReset { age } => {
                let mut plans = self.scan(self.fresh(), plain())?;
                let next = plain().after_reset(u64::from(age), 1);
                plans.extend(self.scan(next, plain())?);
                plans
            }
            CoverPoint::Reset { state } => match state {
                ResetState::TwoClocks => vec![dense, plain().after_reset(1, 2)],
                ResetState::Hit => vec![dense, plain().after_reset(0, 1)],
                ResetState::Waiting | ResetState::Overrun => vec![
                    dense,
                    plain().received(Receiver::Stalls),
                    plain().after_reset(latency + 2, 1),
                ],
                ResetState::Stalled => {
                    // Until the result of the group behind the reset stands.
                    let clocks = 2 * latency + self.reach.shortest + 16;
                    let stalls = Receiver::StopsAt { beat: 0, clocks };
                    let after = plain().after_reset(latency + 2, 1);
                    vec![
                        dense,
                        plain().received(stalls),
                        after.long(Length::Exactly(self.reach.shortest)),
                    ]
                }
                ResetState::Saturated if self.interface.histogram().is_some() => {
                    vec![self.fresh().with(Hits::EveryOther), plain().after_reset(latency + 2, 1)]
                }
                ResetState::Saturated => {
                    let count = 1i64 << (self.interface.count_bits() - 1);
                    let (detector, step) = (DetectorIndex(0), 0);
                    let clamp = Hits::Count { detector, step, count };
                    vec![self.fresh().with(clamp), plain().after_reset(latency + 2, 1)]
                }
                ResetState::Pause => {
                    let mut plans = self.scan(self.fresh(), plain())?;
                    plans.push(plain().after_reset(0, 1));
                    plans
                }
                ResetState::OneClock | ResetState::Long => vec![dense, self.fresh()],
            },
            _ => Vec::new(),
        })
    }

    fn scans(&self, point: CoverPoint) -> Result<Vec<GroupPlan>, String> {
        let plain = GroupPlan::random;
        let groups = self.interface.groups();
        let walk = |groups: u64| {
            let clocks = groups.saturating_mul(self.reach.shortest);
            if clocks > self.reach.most_clocks {
                return Err(format!("it takes {clocks} clocks"));
            }
            let mut plans = vec![self.fresh()];
            plans.extend((1..groups).map(|_| plain()));
            // A step without a hit shows nothing.
            let last = plans.len().saturating_sub(3);
            let side = Hits::OneSided { step: 0, up: true };
            plans[last..].iter_mut().for_each(|plan| plan.hits = side);
            Ok(plans)
        };
        match point {
            CoverPoint::Result { .. } if self.reach.leaves_out => {
                let mut plans = Vec::new();
                for first in [self.fresh(), plain()] {
                    plans.push(first);
                    plans.extend(self.scan(plain(), plain())?);
                }
                Ok(plans)
            }
            CoverPoint::Result { .. } => walk(2 * groups + 1),
            CoverPoint::WholeStep => Ok(vec![self.fresh().long(Length::Whole)]),
            CoverPoint::WholeScan => walk(groups),
            CoverPoint::DelayWraps { period: true } => walk(groups.saturating_add(2)),
            CoverPoint::DelayWraps { period: false } => {
                walk(u64::from(self.interface.lanes().div_ceil(self.interface.parallel())) + 2)
            }
            CoverPoint::CodeWraps { source } => {
                let code = self.interface.source_codes[source].len();
                walk((code + 2).div_ceil(self.reach.shortest))
            }
            _ => Ok(Vec::new()),
        }
    }
}
