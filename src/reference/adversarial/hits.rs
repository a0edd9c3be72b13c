//! Pulses for a group of phase steps, sample by sample.

use crate::scene::DetectorIndex;
use std::ops::Range;

use rand::{Rng, RngExt};

use super::plan::Hits;
use crate::photons::Pulse;
use crate::reference::predictor::{GroupSigns, Reference};

/// Most chips of a group that hits with an aim are looked for in.
const MOST_CHIPS: u64 = 1 << 16;

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
            7 | 8 => Pattern::OneSided {
                up: rng.random(),
                step: rng.random_range(0..parallel),
            },
            _ => Pattern::Random {
                longest: 1 + length(rng, 3 * lanes),
            },
        }
    }
}

/// Samples of some words of a group, as seen by the correlators.
pub(super) struct Words<'a> {
    reference: &'a Reference,
    signs: GroupSigns<'a>,
    /// Clock of the group's first word.
    origin: u64,
    /// Words, counted from there.
    chips: Range<u64>,
}

impl<'a> Words<'a> {
    /// Of one detector: `chips` are counted from the group's first word, at clock `origin`.
    pub fn new(
        reference: &'a Reference,
        detector: DetectorIndex,
        origin: u64,
        chips: Range<u64>,
    ) -> Self {
        Words {
            reference,
            signs: reference.group_signs(detector),
            origin,
            chips,
        }
    }

    fn lanes(&self) -> u64 {
        u64::from(self.reference.interface().lanes())
    }

    /// Whether a step counts a hit on a sample, counted from the group's first, up.
    fn counts_up(&self, step: u64, sample: u64) -> bool {
        self.signs.counts_up(step, sample)
    }

    /// A pulse of one sample, counted from the group's first.
    fn one(&self, sample: u64) -> Pulse {
        let first = self.origin * self.lanes() + sample;
        Pulse {
            first,
            end: first + 1,
        }
    }

    /// The samples, counted from the group's first.
    fn samples(&self) -> Range<u64> {
        self.chips.start * self.lanes()..self.chips.end * self.lanes()
    }

    /// Single samples on which `wanted` is true, with a low one between two of them.
    fn singles(&self, mut wanted: impl FnMut(u64) -> bool, out: &mut Vec<Pulse>) {
        let samples = self.samples();
        let mut sample = samples.start;
        while sample < samples.end {
            if wanted(sample) {
                out.push(self.one(sample));
                sample += 1;
            }
            sample += 1;
        }
    }

    /// Paints a pattern.
    pub fn pattern(&self, pattern: Pattern, rng: &mut impl Rng, out: &mut Vec<Pulse>) {
        let lanes = self.lanes();
        let clocks = self.origin + self.chips.start..self.origin + self.chips.end;
        let samples = clocks.start * lanes..clocks.end * lanes;
        let mut pulse = |first: u64, end: u64| out.push(Pulse { first, end });
        match pattern {
            Pattern::EveryOther { odd } => (samples.start + u64::from(odd)..samples.end)
                .step_by(2)
                .for_each(|s| pulse(s, s + 1)),
            Pattern::AllHigh => pulse(samples.start, samples.end),
            Pattern::AllLow => {}
            Pattern::WordBorders => clocks
                .step_by(2)
                .for_each(|c| pulse(c * lanes, (c + 1) * lanes)),
            Pattern::FirstLane => {
                clocks.for_each(|c| pulse(c * lanes, c * lanes + (lanes - 1).max(1)));
            }
            Pattern::LastLane => clocks.for_each(|c| pulse((c + 1) * lanes - 1, (c + 1) * lanes)),
            Pattern::OneSided { up, step } => {
                self.singles(|s| self.counts_up(step, s) == up, out);
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
            let last = (self.origin + self.chips.end) * self.lanes() - 1;
            pulses
                .iter_mut()
                .for_each(|pulse| pulse.end = pulse.end.min(last));
            pulses.retain(|pulse| pulse.first < pulse.end);
        }
    }

    /// Paints hits with an aim into a group that ends with these words. None where they
    /// cannot be had.
    pub fn aimed(&self, hits: Hits, out: &mut Vec<Pulse>) -> Option<()> {
        let parallel = u64::from(self.reference.interface().parallel());
        let last = self.samples().end.checked_sub(1)?;
        match hits {
            Hits::EveryOther => self.singles(|_| true, out),
            Hits::Lane { lane, .. } => self.singles(|s| s % self.lanes() == lane, out),
            Hits::OneSided { step, up } => self.singles(|s| self.counts_up(step, s) == up, out),
            Hits::AllSteps { up } => {
                let all = |s| (0..parallel).all(|step| self.counts_up(step, s) == up);
                self.singles(all, out);
            }
            Hits::One { step, lane, up, .. } => {
                // Not the first of all: whether the level was low before is not known.
                let found = (1.max(self.samples().start)..=last)
                    .find(|&s| s % self.lanes() == lane && self.counts_up(step, s) == up)?;
                out.push(self.one(found));
            }
            Hits::Border { first } => out.push(self.one(if first { 0 } else { last })),
            Hits::BeforeCut { age } => {
                let word = self.chips.end.checked_sub(age + 1)?;
                out.push(self.one(word * self.lanes() + self.lanes() / 2));
            }
            Hits::Count { step, count, .. } => {
                let samples = self.count(step, count)?;
                out.extend(samples.into_iter().map(|s| self.one(s)));
            }
            Hits::Total { hits, .. } => {
                let samples = self.total(hits)?;
                out.extend(samples.into_iter().map(|s| self.one(s)));
            }
            Hits::None | Hits::Random => {}
        }
        Some(())
    }

    /// Samples whose hits make a count in one step and less in every other.
    fn count(&self, step: u64, count: i64) -> Option<Vec<u64>> {
        let up = count > 0;
        let parallel = u64::from(self.reference.interface().parallel());
        // Other steps that would have the same count.
        let mut alike: Vec<u64> = (0..parallel).filter(|&other| other != step).collect();
        let mut chosen = Vec::new();
        let mut next = 2;
        let samples = self.samples();
        let half = samples.start + (samples.end - samples.start) / 2;
        for sample in samples {
            if chosen.len() as u64 == count.unsigned_abs() {
                break;
            }
            if sample < next || self.counts_up(step, sample) != up {
                continue;
            }
            let differs = |other: &u64| self.counts_up(*other, sample) != up;
            let helps = alike.is_empty() || alike.iter().any(differs);
            if !helps && sample < half {
                continue;
            }
            alike.retain(|other| !differs(other));
            chosen.push(sample);
            next = sample + 2;
        }
        (alike.is_empty() && chosen.len() as u64 == count.unsigned_abs()).then_some(chosen)
    }

    /// Samples of so many hits that no step's count comes near its limit.
    fn total(&self, hits: u64) -> Option<Vec<u64>> {
        let interface = self.reference.interface();
        let most = (1i64 << (interface.count_bits - 1)) - 2;
        let mut counts = vec![0i64; interface.parallel() as usize];
        let mut chosen = Vec::new();
        let mut next = 2;
        for sample in self.samples() {
            if chosen.len() as u64 == hits {
                break;
            }
            if sample < next {
                continue;
            }
            let after = |(step, count): (u64, &i64)| {
                count + if self.counts_up(step, sample) { 1 } else { -1 }
            };
            let counted: Vec<i64> = (0..).zip(&counts).map(after).collect();
            if counted.iter().all(|count| count.abs() <= most) {
                counts = counted;
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
            | Hits::Lane { detector, .. }
            | Hits::Count { detector, .. }
            | Hits::Total { detector, .. } => Some(detector),
            _ => None,
        }
    }

    /// Chips that they need of a group of `chips`.
    pub fn chips(self, reference: &Reference, origin: u64, chips: u64) -> u64 {
        let Some(detector) = self.detector() else {
            return 0;
        };
        let words = Words::new(reference, detector, origin, 0..chips.min(MOST_CHIPS));
        let mut pulses = Vec::new();
        let lanes = words.lanes();
        match words.aimed(self, &mut pulses) {
            Some(()) => pulses
                .last()
                .map_or(0, |pulse| pulse.end / lanes - origin + 2),
            None => 0,
        }
    }
}
