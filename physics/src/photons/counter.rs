//! The article's continuous-time up/down counter.

use rand::RngExt;

use super::detector::DetectorModel;
use super::random::{RandomStream, StreamRng};
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
    let mut transition = transition(model, seed, repetition, step);
    let detections = model.step(seed, repetition, group);
    count_detections(model, repetition, step, &mut transition, detections)
}

/// What decides where a detection is near an edge of a step's reference.
pub(crate) fn transition(
    model: &DetectorModel,
    seed: u64,
    repetition: u64,
    step: Step,
) -> StreamRng {
    let group = model.timing.grouping().group_of(step);
    model.key(seed, repetition, group).stream_of_step(step, RandomStream::Transition)
}

/// Counts detections of a step's group as [`count_step`] does.
pub(crate) fn count_detections(
    model: &DetectorModel,
    repetition: u64,
    step: Step,
    transition: &mut StreamRng,
    detections: impl Iterator<Item = Detection>,
) -> StepCount {
    let reference = CounterReference::new(model, repetition, step);
    let mut count = StepCount::ZERO;
    for detection in detections {
        count.total += 1;
        let up = reference.level(detection).unwrap_or_else(|| transition.random());
        count.signed += if up { 1 } else { -1 };
    }
    count
}

/// More than times are rounded by.
const ROUNDING_CHIPS: f64 = 1e-9;

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
    /// What of the delay is not whole chips.
    delay_part_chips: f64,
    /// Position of the chip that the whole ones lead to, and a period more.
    first: u64,
    /// Between which times into a chip no edge is near.
    certain: [f64; 2],
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
        let length = model.reference.len();
        let offset = model.code_position(repetition, group, length) - whole_chips;
        let delay_chips = part_chips + chips(first_edge_ps);
        let lag_chips = chips((timing.rising_delay_ps - timing.falling_delay_ps).abs());
        let transition_chips = chips(timing.transition_ps);
        let first = (offset - delay_chips.floor() as i64).rem_euclid(length as i64) as u64;
        let near = lag_chips + transition_chips + ROUNDING_CHIPS;
        CounterReference {
            chips: &model.reference.chips,
            offset,
            delay_chips,
            lag_chips,
            rising_lags: timing.rising_delay_ps > timing.falling_delay_ps,
            transition_chips,
            delay_part_chips: delay_chips - delay_chips.floor(),
            first: first + length,
            certain: [near, 1.0 - transition_chips - ROUNDING_CHIPS],
        }
    }

    /// The level at a detection; `None` within the transition time of an edge.
    #[inline]
    fn level(&self, detection: Detection) -> Option<bool> {
        let time = detection.fraction - self.delay_part_chips;
        let (time, earlier) = if time < 0.0 { (time + 1.0, 1) } else { (time, 0) };
        let [from, until] = self.certain;
        if time > from && time < until {
            let (place, length) = (detection.chip + self.first - earlier, self.chips.len());
            // A division of 32 bits is quicker.
            let place = match (u32::try_from(place), u32::try_from(length)) {
                (Ok(place), Ok(length)) => (place % length) as usize,
                _ => (place % length as u64) as usize,
            };
            return Some(self.chips[place] == 1);
        }
        self.level_near_an_edge(detection)
    }

    fn level_near_an_edge(&self, detection: Detection) -> Option<bool> {
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

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::{self, CounterTiming, DetectorIndex};
    use crate::sensor::Sensor;

    /// Far from edges and near them, wherever a step begins in the code.
    #[test]
    fn what_is_looked_up_is_the_level() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
        let scene = scene::load(&file).expect("the scene is sound");
        let chip_ps = scene.chip_period_ps;
        for (rising_delay_ps, falling_delay_ps, transition_ps) in [
            (0.0, 0.0, 0.0),
            (340.0, 390.0, 1.5),
            (2.3 * chip_ps, 0.4 * chip_ps, 0.2 * chip_ps),
            (0.9 * chip_ps, 1.7 * chip_ps, 0.6 * chip_ps),
        ] {
            let mut model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
            model.counter = CounterTiming { rising_delay_ps, falling_delay_ps, transition_ps };
            for step in [0, 1, 13, scene.scan.steps - 1] {
                let reference = CounterReference::new(&model, 3, Step(step));
                for number in 0..20_000_u64 {
                    let chip = number.wrapping_mul(7_919) % (1 << 34);
                    let fraction = (number as f64 * 0.618_033_988_75).fract();
                    let detection = Detection { chip, fraction };
                    let expected = reference.level_near_an_edge(detection);
                    assert_eq!(reference.level(detection), expected, "{step}, {detection:?}");
                }
            }
        }
    }
}
