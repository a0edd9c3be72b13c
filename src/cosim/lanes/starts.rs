//! Guesses of the registers' values at the first word of any group.
//!
//! A short run from reset is watched there. Each bit is then compared with the bits of
//! what the sensor is known to have counted by then ([`Tally`]), and, if it is none of
//! them, with linear recurrences over the number of the group, and with what it was at each chip
//! of a code ([`CodePlace`]). A guess may be wrong: nothing rests on it, because every lane's end
//! has to be the next one's start.

use std::collections::HashMap;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use serde::{Deserialize, Serialize};

use super::design::Design;
use super::model::{BLOCK_CLOCKS, LaneBlock, LaneModel, Table, halted};
use super::places::CodePlace;
use super::recurrence::{Recurrence, SPARE_SAMPLES};
use super::slices::{FIRST_WORD, settling_clocks};
use super::tally::Tally;
use super::{Refusal, Unfit};
use crate::cosim::cache::{hash, once, write};
use crate::cosim::error::CosimError;
use crate::reference::canvas::Changes;
use crate::reference::predictor::{Reference, Surroundings};
use crate::reference::stimulus::RESET_CLOCKS;
use crate::scan::{Group, Sample};
use crate::sensor::interface::Interface;

/// Clocks that are watched, unless these are more groups than are of use, or too few.
const CLOCKS: u64 = 4_000_000;
/// Most groups that are watched.
const MOST_GROUPS: u64 = 600;
/// Least groups that are watched: so many tell a thermometer of 16 places.
const LEAST_GROUPS: u64 = 40;
/// Most clocks at which the registers are read one after another, in the first group.
const MOST_CHIPS: u64 = 4_200;
/// First groups: what the reset left is still on its way.
const FIRST_GROUPS: usize = 2;
/// Groups at the start in which little is counted, so that what is saturated, or else
/// changes once for good, does so later than what only waits for the reset's end.
const SETTLED_GROUPS: usize = 8;
const QUIET_GROUPS: u64 = 12;
/// Most hits of a detector in a quiet group.
const QUIET_HITS: usize = 2;
const GUESSES: &str = "starts.json";
/// Changes with what this file does.
const VERSION: &str = "7";

/// How a register's value is guessed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
enum Guess {
    /// A bit of what has been counted.
    Counted(Place),
    /// A recurrence over the groups, from [`FIRST_GROUPS`] on.
    Recurrent(Recurrence),
    /// A recurrence over the chips of a code, from the one on that stands [`settling_clocks`]
    /// behind the first group's first word.
    Code(CodePlace, Recurrence),
    /// What it was when the whole run was watched.
    Watched(Vec<bool>),
    /// It settles while the lane warms up.
    Settles,
}

/// Guesses for all registers of a design.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Starts {
    guesses: Vec<Guess>,
}

impl Starts {
    /// Watches a design, or finds what was found when it was watched before.
    ///
    /// # Errors
    /// When a phase step is too short to be watched, or the model fails.
    pub(super) fn of(
        design: &Design,
        interface: &Interface,
        cache: &Path,
    ) -> Result<Starts, Refusal> {
        if interface.timing.scan.integration_chips < 4 * settling_clocks(interface) {
            return Err(Refusal::unfit(format!(
                "a phase step has {} chips, and what it counted is on its way for {} clocks",
                interface.timing.scan.integration_chips,
                settling_clocks(interface)
            )));
        }
        // The codes and the scan are what the registers follow.
        let scan = format!("{:?} {}", interface.timing.scan, interface.parallel());
        let codes: Vec<String> = interface
            .reference_codes
            .iter()
            .map(|code| code.chips.iter().map(|&chip| char::from(b'0' + chip)).collect())
            .collect();
        let mut parts = vec!["starts", VERSION, design.identity.as_str(), scan.as_str()];
        parts.extend(codes.iter().map(String::as_str));
        let name = format!("starts-{}", hash(&parts));
        let bytes = once(cache, &name, GUESSES, |folder| {
            let starts = Watch::new(design, interface)?.run()?;
            let text = serde_json::to_string(&starts).map_err(|error| CosimError::Cache {
                path: folder.join(GUESSES),
                source: error.into(),
            })?;
            write(&folder.join(GUESSES), &text)
        })?;
        serde_json::from_slice(&bytes)
            .map_err(|error| Unfit::new(format!("the kept start states: {error}")).into())
    }

    /// Makes one guess wrong that rests on what has been counted; false if there is none.
    #[cfg(test)]
    pub(super) fn spoil_a_count(&mut self) -> bool {
        let mut guesses = self.guesses.iter_mut();
        let found = guesses.find_map(|guess| match guess {
            Guess::Counted(place) if place.quantity == Tally::SIGNED => Some(&mut place.inverted),
            _ => None,
        });
        found.is_some_and(|inverted| {
            *inverted = !*inverted;
            true
        })
    }

    /// The planes of all registers: lane i as at the first word of group `groups[i]`,
    /// where `counted[i]` has been counted. Groups are in order.
    pub(super) fn planes(
        &self,
        interface: &Interface,
        groups: &[u64],
        counted: &[Vec<i64>],
    ) -> Vec<u64> {
        let places: Vec<u64> =
            groups.iter().map(|&group| group.saturating_sub(FIRST_GROUPS as u64)).collect();
        let plane =
            |guess: &Guess| match guess {
                Guess::Settles => 0,
                Guess::Recurrent(recurrence) => bits(recurrence.at(&places).into_iter()),
                Guess::Code(place, recurrence) => {
                    bits(at_chips(*place, recurrence, interface, groups).into_iter())
                }
                Guess::Watched(history) => {
                    bits(groups.iter().map(|&group| history.get(group as usize) == Some(&true)))
                }
                Guess::Counted(place) => bits(counted.iter().map(|counted| {
                    (counted[place.quantity] >> place.bit & 1 == 1) != place.inverted
                })),
            };
        self.guesses.iter().map(plane).collect()
    }
}

/// What a register that follows a code is at the first words of some groups, in any order.
fn at_chips(
    place: CodePlace,
    recurrence: &Recurrence,
    interface: &Interface,
    groups: &[u64],
) -> Vec<bool> {
    let first_chip = settling_clocks(interface);
    let chip = |&group: &u64| place.chip(interface, group, first_chip);
    let chips: Vec<u64> = groups.iter().map(chip).collect();
    let mut in_order = chips.clone();
    in_order.sort_unstable();
    in_order.dedup();
    let values = recurrence.at(&in_order);
    let value = |chip: &u64| in_order.binary_search(chip).is_ok_and(|place| values[place]);
    chips.iter().map(value).collect()
}

fn bits(values: impl Iterator<Item = bool>) -> u64 {
    values.enumerate().fold(0, |plane, (lane, value)| plane | u64::from(value) << lane)
}

/// A run that is watched.
struct Watch<'a> {
    design: &'a Design,
    interface: &'a Interface,
    /// Groups that are watched.
    groups: u64,
    /// Of each register what it was at the clocks that were watched one by one.
    chips: Vec<Vec<bool>>,
    model: LaneModel,
    rng: Xoshiro256PlusPlus,
}

impl<'a> Watch<'a> {
    fn new(design: &'a Design, interface: &'a Interface) -> Result<Watch<'a>, CosimError> {
        let tables: Vec<Table> =
            (0..design.tables).map(|output| Table { output, planes: vec![0].into() }).collect();
        let groups = interface.groups();
        // An LFSR that counts all groups is told by twice its bits.
        let counter_bits = groups.next_power_of_two().ilog2() as usize;
        let least = (FIRST_GROUPS + 2 * counter_bits + SPARE_SAMPLES) as u64;
        Ok(Watch {
            design,
            interface,
            groups: (CLOCKS / interface.timing.scan.integration_chips)
                .clamp(least.max(LEAST_GROUPS), MOST_GROUPS)
                .min(groups),
            chips: vec![Vec::new(); design.registers.len()],
            model: LaneModel::load(design, &tables)?,
            rng: Xoshiro256PlusPlus::seed_from_u64(1),
        })
    }

    /// All registers, and all that has been counted, at the first words of the first
    /// groups.
    fn run(mut self) -> Result<Starts, CosimError> {
        let group_clocks = self.interface.timing.scan.integration_chips;
        let mut reference = Reference::new(self.interface.clone())?;
        let mut tally = Tally::new(self.interface);
        let power_up = self.design.power_up(0);
        self.model.set_registers(&power_up).map_err(halted)?;
        let mut samples = vec![0; FIRST_WORD as usize * self.design.samples];
        self.clock(&samples[..RESET_CLOCKS as usize * self.design.samples], u64::MAX)?;
        self.clock(&samples[RESET_CLOCKS as usize * self.design.samples..], 0)?;
        let mut clock = 0;
        let mut watched = Vec::new();
        let mut counted = Vec::new();
        for group in 0..self.groups {
            watched.push(self.model.registers().map_err(halted)?);
            counted.push(tally.values());
            let end = FIRST_WORD + (group + 1) * group_clocks;
            let hits = self.stimulate(group, &mut samples);
            let surroundings = Surroundings {
                clocks: clock..end,
                resets: std::iter::once(0..RESET_CLOCKS).collect(),
                stalls: Vec::new(),
                skips: Vec::new(),
            };
            reference.predict_changes(&surroundings, &hits, &mut Changes::default());
            clock = end;
            let rest = if group == 0 { self.watch_chips(&samples)? } else { &samples[..] };
            self.clock(rest, 0)?;
            for result in reference.take_finished() {
                tally.add(&result);
            }
        }
        Ok(self.guess(&watched, &counted))
    }

    /// Clocks a part of the first group clock by clock: a code's period, if it is not too long.
    /// Gives the samples of the rest.
    fn watch_chips<'s>(&mut self, samples: &'s [u64]) -> Result<&'s [u64], CosimError> {
        let settling = settling_clocks(self.interface);
        let periods = CodePlace::all(self.interface).into_iter().map(|place| place.period);
        let wanted = periods.max().unwrap_or_default() + SPARE_SAMPLES as u64;
        let quiet = self.interface.timing.scan.integration_chips - 2 * settling;
        let (before, rest) = samples.split_at(settling as usize * self.design.samples);
        self.clock(before, 0)?;
        let watched = wanted.min(MOST_CHIPS).min(quiet) as usize;
        let (watched, rest) = rest.split_at(watched * self.design.samples);
        for word in watched.chunks(self.design.samples) {
            let planes = self.model.registers().map_err(halted)?;
            for (register, plane) in self.chips.iter_mut().zip(planes) {
                register.push(plane & 1 == 1);
            }
            self.clock(word, 0)?;
        }
        Ok(rest)
    }

    /// Clocks all lanes with the samples of lane 0.
    fn clock(&mut self, samples: &[u64], reset: u64) -> Result<(), CosimError> {
        for part in samples.chunks(BLOCK_CLOCKS as usize * self.design.samples) {
            let block = LaneBlock {
                clocks: (part.len() / self.design.samples) as u64,
                reset,
                watched: 0,
                samples: part.to_vec(),
                events: Vec::new(),
                phases: vec![0; self.design.tables],
            };
            self.model.submit(&block).map_err(halted)?;
            self.model.collect().map_err(halted)?;
        }
        Ok(())
    }

    /// Pulses of one sample for a group, for each detector of one sign or of both, and
    /// none at its end, so that all are counted when it is over.
    fn stimulate(&mut self, group: u64, samples: &mut Vec<u64>) -> Vec<Vec<Sample>> {
        let interface = self.interface;
        let lanes = u64::from(interface.lanes());
        let clocks = interface.timing.scan.integration_chips;
        let loud = (clocks - settling_clocks(interface)) * lanes;
        samples.clear();
        samples.resize(clocks as usize * self.design.samples, 0);
        let sampling = interface.timing.sampling();
        let first = sampling.first_sample(FIRST_WORD + group * clocks);
        let step = interface.grouping().step_of(Group(group), 0);
        let phase_step = interface.timing.scan.phase_step(step);
        let mut all = Vec::new();
        for (detector, code) in interface.reference_codes.iter().enumerate() {
            let period = code.len() * lanes;
            let delay = period - phase_step % period;
            let sign = self.rng.random_range(0..4u8);
            let most = self.most_hits(group, loud, sign == 0);
            let mut hits = Vec::new();
            // At even and odd samples, so that neighbouring phase steps count differently.
            let mut sample = self.rng.random_range(0..2);
            while sample < loud && hits.len() < most {
                let chip = (group * clocks * lanes + sample + delay) % period / lanes;
                let up = code.chips[chip as usize] == 1;
                let wanted = match sign {
                    0 => up,
                    1 => !up,
                    _ => true,
                };
                if wanted {
                    let (clock, lane) = (sample / lanes, sample % lanes);
                    let plane = detector * interface.lanes() as usize + lane as usize;
                    samples[clock as usize * self.design.samples + plane] = u64::MAX;
                    hits.push(first + sample);
                }
                sample += self.rng.random_range(2..4);
            }
            all.push(hits);
        }
        all
    }

    /// Most hits of a group: few at first, then of any order of magnitude. Where all are
    /// counted up it grows slowly, so that the largest count does in many steps and
    /// comes to saturation long after a count below zero has.
    fn most_hits(&mut self, group: u64, loud: u64, are_up: bool) -> usize {
        if group < QUIET_GROUPS {
            return QUIET_HITS;
        }
        let octaves = (loud as f64 / 2.0).log2().max(1.0);
        let grown = (group - QUIET_GROUPS) as f64 / (self.groups as f64 / 2.0);
        let most = if are_up { grown.min(1.0) } else { 1.0 };
        self.rng.random_range(0.0..=(octaves * most).max(0.1)).exp2() as usize
    }

    fn guess(&self, watched: &[Vec<u64>], counted: &[Vec<i64>]) -> Starts {
        let histories: Vec<Vec<bool>> = (0..self.design.registers.len())
            .map(|register| {
                let planes = watched.iter().map(|planes| planes[register]);
                planes.map(|plane| plane & 1 == 1).collect()
            })
            .collect();
        let whole_run = watched.len() as u64 == self.interface.groups();
        let guesses = self.counted(&histories, &known_bits(counted));
        let or_other = |(number, (guess, history)): (usize, (Option<Guess>, &Vec<bool>))| {
            let follows = self.design.follow_inputs[number];
            guess.unwrap_or_else(|| {
                if whole_run && !follows {
                    return Guess::Watched(history.clone());
                }
                let later = history.get(FIRST_GROUPS..).unwrap_or_default();
                // What takes the fewest samples to tell comes first.
                let recurrent = Recurrence::of(later).map(Guess::Recurrent);
                let of_code = || self.of_code(number, later).filter(|_| !follows);
                let periodic = || Recurrence::periodic(later).map(Guess::Recurrent);
                recurrent.or_else(of_code).or_else(periodic).unwrap_or(Guess::Settles)
            })
        };
        Starts { guesses: guesses.into_iter().zip(&histories).enumerate().map(or_other).collect() }
    }

    /// The guess that a register follows a code, if that was so in all groups.
    fn of_code(&self, register: usize, later: &[bool]) -> Option<Guess> {
        let chips = &self.chips[register];
        let recurrence = Recurrence::of(chips).or_else(|| Recurrence::periodic(chips))?;
        let groups: Vec<u64> = (FIRST_GROUPS as u64..).take(later.len()).collect();
        let mut places = CodePlace::all(self.interface).into_iter();
        let place =
            places.find(|&place| at_chips(place, &recurrence, self.interface, &groups) == later)?;
        Some(Guess::Code(place, recurrence))
    }

    /// Guesses of the registers that have a bit of what has been counted.
    fn counted(&self, histories: &[Vec<bool>], known: &Known) -> Vec<Option<Guess>> {
        // Where the bits of a word lie among those of a quantity, from the bits that
        // are without doubt.
        let mut offsets: HashMap<&str, Place> = HashMap::new();
        let mut guesses = vec![None; histories.len()];
        for certain in [true, false] {
            for (number, history) in histories.iter().enumerate() {
                if guesses[number].is_some() || !self.design.follow_inputs[number] {
                    continue;
                }
                let (word, bit) = &self.design.registers[number].name;
                let candidates = known.get(history).map_or(&[][..], Vec::as_slice);
                let beside = offsets
                    .get(word.as_str())
                    .map(|place| Place { bit: place.bit + bit, ..*place });
                // What the reset alone brings about is over by then.
                let mut later = history.windows(2).skip(SETTLED_GROUPS);
                let moves = later.any(|pair| pair[0] != pair[1]);
                let chosen = match (certain, candidates) {
                    (true, [only]) if moves => Some(*only),
                    (true, _) => None,
                    (false, _) => beside
                        .filter(|place| candidates.contains(place))
                        .or_else(|| candidates.first().copied().filter(|_| moves)),
                };
                let Some(place) = chosen else {
                    continue;
                };
                if let Some(first_bit) = place.bit.checked_sub(*bit) {
                    offsets.entry(word).or_insert(Place { bit: first_bit, ..place });
                }
                guesses[number] = Some(Guess::Counted(place));
            }
        }
        guesses
    }
}

/// A bit of what has been counted, or its inverse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Place {
    quantity: usize,
    bit: u32,
    inverted: bool,
}

/// For each history of a bit, what has it.
type Known = HashMap<Vec<bool>, Vec<Place>>;

fn known_bits(counted: &[Vec<i64>]) -> Known {
    let mut known = Known::new();
    for quantity in 0..counted[0].len() {
        for bit in 0..i64::BITS {
            for inverted in [false, true] {
                let history: Vec<bool> = counted
                    .iter()
                    .map(|values| (values[quantity] >> bit & 1 == 1) != inverted)
                    .collect();
                known.entry(history).or_default().push(Place { quantity, bit, inverted });
            }
        }
    }
    known
}
