//! The article's continuous-time up/down counter.

use rand::RngExt;

use super::detector::DetectorModel;
use super::random::Part;
use super::registration::Detection;
use crate::scan::Step;

/// What the counter shows at the end of a phase step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StepCount {
    /// Detections while the reference was 1, less those while it was 0.
    pub signed: i64,
    /// All detections.
    pub total: u64,
}

impl StepCount {
    /// Nothing counted.
    pub const ZERO: StepCount = StepCount { signed: 0, total: 0 };

    /// `total` detections, `ups` of them while the reference was 1.
    pub(crate) fn of(ups: u32, total: u32) -> StepCount {
        StepCount { signed: 2 * i64::from(ups) - i64::from(total), total: u64::from(total) }
    }

    pub(crate) fn add(&mut self, other: StepCount) {
        self.signed += other.signed;
        self.total += other.total;
    }
}

/// Counts a step of scan number `repetition` up and down (eq. 11), with the reference
/// delayed by k T_s (k from the scan) and by the counter's own edge delays. Steps
/// of one group count the same detections.
pub fn count_step(model: &DetectorModel, seed: u64, repetition: u64, step: Step) -> StepCount {
    let group = model.timing.grouping().group_of(step);
    count_detections(model, seed, repetition, step, model.step(seed, repetition, group))
}

/// Counts the detections of a step's group as [`count_step`] does.
pub(crate) fn count_detections(
    model: &DetectorModel,
    seed: u64,
    repetition: u64,
    step: Step,
    detections: impl Iterator<Item = Detection>,
) -> StepCount {
    let reference = CounterReference::new(model, repetition, step);
    let group = model.timing.grouping().group_of(step);
    let key = model.key(seed, repetition, group);
    let mut transition = key.stream_of_step(step, Part::Transition);
    let mut count = StepCount { signed: 0, total: 0 };
    for detection in detections {
        count.total += 1;
        let up = reference.level(detection).unwrap_or_else(|| transition.random());
        count.signed += if up { 1 } else { -1 };
    }
    count
}

/// The counter's reference during one phase step.
struct CounterReference<'m> {
    chips: &'m [u8],
    /// Code position minus step-relative chip number.
    offset: i64,
    /// Delay of the earlier kind of edge, in chips, phase step included.
    delay_chips: f64,
    /// How much later the other kind of edge comes, in chips.
    lag_chips: f64,
    /// Whether it is the rising edge that comes later.
    rising_lags: bool,
    transition_chips: f64,
}

impl<'m> CounterReference<'m> {
    fn new(model: &'m DetectorModel, repetition: u64, step: Step) -> CounterReference<'m> {
        let timing = &model.counter;
        let chips = |ps: f64| model.timing.clock.chips(ps);
        let samples_per_chip = u64::from(model.timing.clock.samples_per_chip);
        let phase_step = model.timing.scan.phase_step(step);
        let whole_chips = (phase_step / samples_per_chip) as i64;
        let part_chips = (phase_step % samples_per_chip) as f64 / samples_per_chip as f64;
        let first_edge_ps = timing.rising_delay_ps.min(timing.falling_delay_ps);
        let group = model.timing.grouping().group_of(step);
        CounterReference {
            chips: &model.reference.chips,
            offset: model.code_position(repetition, group, model.reference.len()) - whole_chips,
            delay_chips: part_chips + chips(first_edge_ps),
            lag_chips: chips((timing.rising_delay_ps - timing.falling_delay_ps).abs()),
            rising_lags: timing.rising_delay_ps > timing.falling_delay_ps,
            transition_chips: chips(timing.transition_ps),
        }
    }

    /// The level at a detection; `None` within the transition time of an edge.
    fn level(&self, detection: Detection) -> Option<bool> {
        let time = detection.fraction - self.delay_chips;
        let position = (detection.chip as i64 + self.offset).rem_euclid(self.chips.len() as i64);
        let before = self.level_at(position, time - self.transition_chips);
        let after = self.level_at(position, time + self.transition_chips);
        (before == after).then_some(before)
    }

    /// The level `time` chips after the start of the code's chip `position`, in
    /// the time frame of the undelayed reference.
    ///
    /// A rising edge that comes later by the lag leaves the level high only
    /// where the reference has been 1 for that long; a later falling edge keeps
    /// it high where it has been 1 at any time within the lag.
    fn level_at(&self, position: i64, time: f64) -> bool {
        let last = time.floor() as i64;
        let first = (time - self.lag_chips).floor() as i64;
        let mut within_lag = (first..=last).map(|offset| self.chip(position + offset));
        if self.rising_lags {
            within_lag.all(|chip| chip == 1)
        } else {
            within_lag.any(|chip| chip == 1)
        }
    }

    fn chip(&self, position: i64) -> u8 {
        // Within the code, as nearly always, no division is needed.
        match self.chips.get(usize::try_from(position).unwrap_or(usize::MAX)) {
            Some(&chip) => chip,
            None => self.chips[position.rem_euclid(self.chips.len() as i64) as usize],
        }
    }
}
