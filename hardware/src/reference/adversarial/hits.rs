//! Pulses for a group of phase steps, sample by sample.

use crate::scene::DetectorIndex;
use std::ops::Range;

use rand::{Rng, RngExt};

use crate::photons::Pulse;
use crate::reference::planned::Hits;
use crate::reference::predictor::{GroupSigns, ReferenceModel, SampleSigns};
use crate::scan::{Sample, Sampling};
use crate::sensor::layout::mask;

/// Most chips of a group that hits with an aim are looked for in.
const MOST_CHIPS: u64 = 1 << 16;

/// How much more a step weighs behind a hit that counts against it.
const GROWTH: f64 = 1.1;

/// What one detector's samples do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pattern {
    /// High on every other sample: the most hits there can be.
    EveryOther { odd: bool },
    /// High throughout: no hit but the first.
    AllHigh,
    /// Low throughout.
    AllLow,
    /// Edges at word borders only, every other word high.
    WordBorders,
    /// Rising edge on the first lane of every word, high until the last but one.
    FirstLane,
    /// Rising edge on the last lane of every word.
    LastLane,
    /// Every hit where the present reference has one sign: the largest count.
    OneSided {
        up: bool,
        /// Which of the steps at once, so that each has its turn.
        step: u64,
    },
    /// Runs of random length.
    Random { longest: u64 },
}

/// A length between 1 and `longest`, each decade as likely as another.
pub(super) fn length(rng: &mut impl Rng, longest: u64) -> u64 {
    let decades: f64 = rng.random();
    (longest as f64).powf(decades) as u64
}

impl Pattern {
    /// One by chance.
    pub fn random(rng: &mut impl Rng, lanes: u64, parallel: u64) -> Pattern {
        match rng.random_range(0..12) {
            0 => Pattern::EveryOther { odd: false },
            1 => Pattern::EveryOther { odd: true },
            2 => Pattern::AllHigh,
            3 => Pattern::AllLow,
            4 => Pattern::WordBorders,
            5 => Pattern::FirstLane,
            6 => Pattern::LastLane,
            7 | 8 => Pattern::OneSided { up: rng.random(), step: rng.random_range(0..parallel) },
            _ => Pattern::Random { longest: 1 + length(rng, 3 * lanes) },
        }
    }
}

/// Samples of some words of a group, as seen by the correlators.
pub(super) struct GroupWords<'a> {
    reference: &'a ReferenceModel,
    signs: GroupSigns<'a>,
    sampling: Sampling,
    /// Clock of the group's first word.
    origin: u64,
    /// Words, counted from there.
    chips: Range<u64>,
}

impl<'a> GroupWords<'a> {
    /// Of one detector: `chips` are counted from the group's first word, at clock `origin`.
    pub fn new(
        reference: &'a ReferenceModel,
        detector: DetectorIndex,
        origin: u64,
        chips: Range<u64>,
    ) -> Self {
        let sampling = reference.interface().timing.sampling();
        GroupWords {
            reference,
            signs: reference.group_signs(detector, sampling.first_sample(origin)),
            sampling,
            origin,
            chips,
        }
    }

    fn lanes(&self) -> u64 {
        self.sampling.samples_of(1)
    }

    /// The clocks.
    fn clocks(&self) -> Range<u64> {
        self.origin + self.chips.start..self.origin + self.chips.end
    }

    /// The samples.
    fn samples(&self) -> Range<Sample> {
        self.sampling.samples(&self.clocks())
    }

    /// The first sample that a hit may be on for certain: whether the level was low before
    /// the group is not known.
    fn first_certain(&self) -> Sample {
        let second = self.sampling.first_sample(self.origin) + 1;
        second.max(self.samples().start)
    }

    /// Single samples on which `wanted` is true, with a low one between two of them.
    fn singles(&self, mut wanted: impl FnMut(Sample, SampleSigns) -> bool, out: &mut Vec<Pulse>) {
        let samples = self.samples();
        let mut next = samples.start;
        for (sample, signs) in self.signs.along(samples) {
            if sample >= next && wanted(sample, signs) {
                out.push(Pulse::of_one(sample));
                next = sample + 2;
            }
        }
    }

    /// Paints a pattern.
    pub fn pattern(&self, pattern: Pattern, rng: &mut impl Rng, out: &mut Vec<Pulse>) {
        let lanes = self.lanes();
        let (clocks, samples) = (self.clocks(), self.samples());
        let first_of = |clock| self.sampling.first_sample(clock);
        let mut pulse = |first: Sample, end: Sample| out.push(Pulse { first, end });
        match pattern {
            Pattern::EveryOther { odd } => (samples.start.0 + u64::from(odd)..samples.end.0)
                .step_by(2)
                .for_each(|s| pulse(Sample(s), Sample(s + 1))),
            Pattern::AllHigh => pulse(samples.start, samples.end),
            Pattern::AllLow => {}
            Pattern::WordBorders => {
                clocks.step_by(2).for_each(|c| pulse(first_of(c), first_of(c + 1)))
            }
            Pattern::FirstLane => {
                clocks.for_each(|c| pulse(first_of(c), first_of(c) + (lanes - 1).max(1)));
            }
            Pattern::LastLane => {
                clocks.for_each(|c| pulse(first_of(c) + (lanes - 1), first_of(c + 1)));
            }
            Pattern::OneSided { up, step } => {
                self.singles(|_, signs| signs.count_up(step) == up, out);
            }
            Pattern::Random { longest } => {
                let mut s = samples.start + rng.random_range(0..=longest);
                while s < samples.end {
                    let end = s + rng.random_range(1..=longest);
                    pulse(s, end);
                    s = end + rng.random_range(1..=longest);
                }
            }
        }
    }

    /// Ends the pulses a sample before these words do, if asked to.
    pub fn clip(&self, is_asked: bool, pulses: &mut Vec<Pulse>) {
        if is_asked {
            let last = Sample(self.samples().end.0 - 1);
            pulses.iter_mut().for_each(|pulse| pulse.end = pulse.end.min(last));
            pulses.retain(|pulse| pulse.first < pulse.end);
        }
    }

    /// Paints hits with an aim into a group that ends with these words. None where they
    /// cannot be had.
    pub fn aimed(&self, hits: Hits, out: &mut Vec<Pulse>) -> Option<()> {
        let parallel = u64::from(self.reference.interface().parallel());
        let lane_of = |sample| u64::from(self.sampling.lane_of(sample));
        let last = Sample(self.samples().end.0.checked_sub(1)?);
        let all_count =
            |signs: SampleSigns, up| (0..parallel).all(|step| signs.count_up(step) == up);
        let certain = || self.signs.along(self.first_certain()..self.samples().end);
        match hits {
            Hits::EveryOther => self.singles(|_, _| true, out),
            Hits::Lane { lane, .. } => self.singles(|s, _| lane_of(s) == lane, out),
            Hits::BeyondLimitAtEnd { lane, age, .. } => {
                let plan = self.reference.interface().histogram()?;
                let end = self.origin + plan.rows * plan.periods;
                let periods = mask(plan.bin_bits) + 1;
                let is_wanted = |s, _: SampleSigns| {
                    let behind = end - 1 - self.sampling.clock_of(s);
                    lane_of(s) == lane && behind % plan.rows == age && behind / plan.rows < periods
                };
                self.singles(is_wanted, out);
            }
            Hits::OneSided { step, up } => {
                self.singles(|_, signs| signs.count_up(step) == up, out);
            }
            Hits::AllSteps { up } => {
                self.singles(|_, signs| all_count(signs, up), out);
                if out.is_empty() {
                    self.together(up, out);
                }
            }
            Hits::OneForAll { up, .. } => {
                let (found, _) = certain().find(|(_, signs)| all_count(*signs, up))?;
                out.push(Pulse::of_one(found));
            }
            Hits::One { step, lane, up, .. } => {
                let (found, _) = certain()
                    .find(|(s, signs)| lane_of(*s) == lane && signs.count_up(step) == up)?;
                out.push(Pulse::of_one(found));
            }
            Hits::Border { first: true } => {
                out.push(Pulse::of_one(self.sampling.first_sample(self.origin)));
            }
            Hits::Border { first: false } => out.push(Pulse::of_one(last)),
            Hits::BeforeCut { age } => {
                let word = self.chips.end.checked_sub(age + 1)?;
                let first = self.sampling.first_sample(self.origin + word);
                out.push(Pulse::of_one(first + self.lanes() / 2));
            }
            Hits::Count { step, count, .. } => {
                let samples = self.count(step, count)?;
                out.extend(samples.into_iter().map(Pulse::of_one));
            }
            Hits::Total { hits, .. } => {
                let samples = self.total(hits)?;
                out.extend(samples.into_iter().map(Pulse::of_one));
            }
            Hits::None | Hits::Random => {}
        }
        Some(())
    }

    /// Single samples whose hits make the counts of all steps large, where none counts for all of them: the less a
    /// step has come to have, the more it weighs in the choice.
    fn together(&self, up: bool, out: &mut Vec<Pulse>) {
        let mut weights = vec![1.0; self.reference.interface().parallel() as usize];
        let helps = |_, signs: SampleSigns| {
            let helped = |(step, weight): (u64, &f64)| match signs.count_up(step) == up {
                true => *weight,
                false => -weight,
            };
            if (0..).zip(&weights).map(helped).sum::<f64>() <= 0.0 {
                return false;
            }
            for (step, weight) in (0..).zip(&mut weights) {
                *weight *= if signs.count_up(step) == up { 1.0 / GROWTH } else { GROWTH };
            }
            let largest = weights.iter().copied().fold(0.0, f64::max);
            weights.iter_mut().for_each(|weight| *weight /= largest);
            true
        };
        self.singles(helps, out);
    }

    /// Samples whose hits make a count in one step and less in every other: as many at once as cells have.
    fn count(&self, step: u64, count: i64) -> Option<Vec<Sample>> {
        let up = count > 0;
        let parallel = u64::from(self.reference.interface().parallel());
        let at_once = self.reference.interface().input_cells.edges() as usize;
        // Other steps that would have the same count.
        let mut alike: Vec<u64> = (0..parallel).filter(|&other| other != step).collect();
        let mut chosen = Vec::new();
        let mut next = self.sampling.first_sample(self.origin) + 2;
        let samples = self.samples();
        let half = samples.start + (samples.end - samples.start) / 2;
        for (sample, signs) in self.signs.along(samples.clone()) {
            if chosen.len() as u64 == count.unsigned_abs() {
                break;
            }
            if sample < next {
                continue;
            }
            if signs.count_up(step) != up {
                continue;
            }
            let differs = |other: &u64| signs.count_up(*other) != up;
            // Those beside it are those that hardly ever differ.
            let is_near = |other: &u64| other.abs_diff(step) == 1;
            let mut near = alike.iter().filter(|other| is_near(other)).peekable();
            let helps = match near.peek() {
                Some(_) => near.any(differs),
                None => alike.is_empty() || alike.iter().any(differs),
            };
            if !helps && sample < half {
                continue;
            }
            alike.retain(|other| !differs(other));
            let left = count.unsigned_abs() as usize - chosen.len();
            chosen.extend(std::iter::repeat_n(sample, left.min(at_once)));
            next = sample + 2;
        }
        (alike.is_empty() && chosen.len() as u64 == count.unsigned_abs()).then_some(chosen)
    }

    /// Samples of so many hits that no step's count comes near its limit.
    fn total(&self, hits: u64) -> Option<Vec<Sample>> {
        let interface = self.reference.interface();
        let at_once = interface.input_cells.edges();
        let most = (1i64 << (interface.count_bits() - 1)) - 2;
        let mut counts = vec![0i64; interface.parallel() as usize];
        let mut chosen = Vec::new();
        let mut next = self.sampling.first_sample(self.origin) + 2;
        let samples = self.samples();
        for (sample, signs) in self.signs.along(samples.clone()) {
            if chosen.len() as u64 == hits {
                break;
            }
            if sample < next {
                continue;
            }
            let sign = |step| if signs.count_up(step) { 1 } else { -1 };
            for _ in 0..at_once {
                let stays = |(step, count): (u64, &i64)| (count + sign(step)).abs() <= most;
                if chosen.len() as u64 == hits || !(0..).zip(&counts).all(stays) {
                    break;
                }
                (0..).zip(&mut counts).for_each(|(step, count)| *count += sign(step));
                chosen.push(sample);
                next = sample + 2;
            }
        }
        (chosen.len() as u64 == hits).then_some(chosen)
    }
}

impl Hits {
    /// The detector that has them, if the others have none.
    pub fn detector(self) -> Option<DetectorIndex> {
        match self {
            Hits::One { detector, .. }
            | Hits::OneForAll { detector, .. }
            | Hits::Lane { detector, .. }
            | Hits::BeyondLimitAtEnd { detector, .. }
            | Hits::Count { detector, .. }
            | Hits::Total { detector, .. } => Some(detector),
            _ => None,
        }
    }

    /// Chips that they need of a group of `chips`.
    pub fn chips(self, reference: &ReferenceModel, origin: u64, chips: u64) -> u64 {
        let Some(detector) = self.detector() else {
            return 0;
        };
        let words = GroupWords::new(reference, detector, origin, 0..chips.min(MOST_CHIPS));
        let mut pulses = Vec::new();
        match words.aimed(self, &mut pulses) {
            Some(()) => {
                pulses.last().map_or(0, |pulse| words.sampling.clock_of(pulse.end) - origin + 2)
            }
            None => 0,
        }
    }
}
