//! Guesses of the registers' values at the first word of any group.
//!
//! A short run from reset is watched there. Each bit is then compared with the bits of
//! what the sensor is known to have counted by then (`super::tally`), and, if it is none of
//! them, with the bits of the group's numbers ([`numbers`]), with what it was at each chip of a
//! code ([`CodePlace`]), and with linear recurrences over the groups. A guess may be wrong: nothing
//! rests on it, because every lane's end has to be the next one's start.

use std::collections::HashMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::design::LaneDesign;
use super::places::{CodePlace, numbers};
use super::planes::Planes;
use super::recurrence::Recurrence;
use super::slices::settling_clocks;
#[cfg(test)]
use super::tally::LaneTally;
use super::watch::{FIRST_GROUPS, Watch, Watched};
use super::{LaneRefusal, Unfit};
use crate::cosim::cache::{hash, once, write};
use crate::cosim::error::CosimError;
use crate::sensor::interface::Interface;

/// Bits of a register that have to change for it to count a number in binary.
const COUNTING_BITS: usize = 3;
/// Groups at the start in which little is counted, so that what is saturated, or else
/// changes once for good, does so later than what only waits for the reset's end.
const SETTLED_GROUPS: usize = 8;
const GUESSES: &str = "starts.json";
/// Changes with what this file and `super::watch` do.
const VERSION: &str = "10";

/// How a register's value is guessed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
enum Guess {
    /// A bit of what has been counted.
    Counted(CountedBit),
    /// A recurrence over the groups, from [`FIRST_GROUPS`] on.
    Recurrent(Recurrence),
    /// A bit of one of [`numbers`].
    Number(CountedBit),
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
        design: &LaneDesign,
        interface: &Interface,
        cache: &Path,
    ) -> Result<Starts, LaneRefusal> {
        if interface.timing.scan.integration_chips < 4 * settling_clocks(interface) {
            return Err(LaneRefusal::unfit(format!(
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
            let watched = Watch::new(design, interface)?.run()?;
            let starts = Evidence { design, interface, watched }.starts();
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
            Guess::Counted(place) if place.quantity == LaneTally::SIGNED => {
                Some(&mut place.inverted)
            }
            _ => None,
        });
        found.is_some_and(|inverted| {
            *inverted = !*inverted;
            true
        })
    }

    /// All registers of a model of so many lanes: lane i as at the first word of group
    /// `groups[i]`, where `counted[i]` has been counted. Groups are in order.
    pub(super) fn planes(
        &self,
        lanes: usize,
        interface: &Interface,
        groups: &[u64],
        counted: &[Vec<i64>],
    ) -> Planes {
        let places: Vec<u64> =
            groups.iter().map(|&group| group.saturating_sub(FIRST_GROUPS as u64)).collect();
        let values = |guess: &Guess| -> Vec<bool> {
            match guess {
                Guess::Settles => Vec::new(),
                Guess::Recurrent(recurrence) => recurrence.at(&places),
                Guess::Number(place) => {
                    let number = |&group: &u64| numbers(interface, group)[place.quantity];
                    groups.iter().map(|group| place.is_set(number(group).cast_signed())).collect()
                }
                Guess::Code(place, recurrence) => at_chips(*place, recurrence, interface, groups),
                Guess::Watched(history) => {
                    groups.iter().map(|&group| history.get(group as usize) == Some(&true)).collect()
                }
                Guess::Counted(place) => {
                    counted.iter().map(|counted| place.is_set(counted[place.quantity])).collect()
                }
            }
        };
        let mut planes = Planes::new(lanes, self.guesses.len());
        for (register, guess) in self.guesses.iter().enumerate() {
            for (lane, value) in values(guess).into_iter().enumerate() {
                planes.set(register, lane, value);
            }
        }
        planes
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

/// What the guesses are made of.
struct Evidence<'a> {
    design: &'a LaneDesign,
    interface: &'a Interface,
    watched: Watched,
}

impl Evidence<'_> {
    fn starts(&self) -> Starts {
        let Watched { histories, counted, .. } = &self.watched;
        let whole_run = counted.len() as u64 == self.interface.groups();
        let guesses = self.counted(&known_bits(counted));
        let binary = self.binary();
        let or_other = |(number, (guess, history)): (usize, (Option<Guess>, &Vec<bool>))| {
            let follows = self.design.follow_inputs[number];
            guess.unwrap_or_else(|| {
                if whole_run && !follows {
                    return Guess::Watched(history.clone());
                }
                let later = history.get(FIRST_GROUPS..).unwrap_or_default();
                let recurrent = || Recurrence::of(later).map(Guess::Recurrent);
                if follows {
                    return recurrent().unwrap_or(Guess::Settles);
                }
                let periodic = || Recurrence::periodic(later).map(Guess::Recurrent);
                let number_of = binary.get(number).copied().flatten().map(Guess::Number);
                let by_itself = || recurrent().or_else(periodic).unwrap_or(Guess::Settles);
                number_of.or_else(|| self.of_code(number, later)).unwrap_or_else(by_itself)
            })
        };
        Starts { guesses: guesses.into_iter().zip(histories).enumerate().map(or_other).collect() }
    }

    /// For each register the bit of a number, if its word has been that number, or a part of it.
    fn binary(&self) -> Vec<Option<CountedBit>> {
        let histories = &self.watched.histories;
        let mut words: HashMap<&str, Vec<usize>> = HashMap::new();
        for (number, register) in self.design.registers.iter().enumerate() {
            if !self.design.follow_inputs[number] {
                words.entry(&register.name.0).or_default().push(number);
            }
        }
        let groups = FIRST_GROUPS as u64..self.watched.counted.len() as u64;
        let values: Vec<Vec<u64>> = groups.map(|group| numbers(self.interface, group)).collect();
        let mut places = vec![None; histories.len()];
        for registers in words.values() {
            let later =
                |register: usize| histories[register].get(FIRST_GROUPS..).unwrap_or_default();
            let changes =
                |&&register: &&usize| later(register).windows(2).any(|two| two[0] != two[1]);
            if registers.iter().filter(changes).count() < COUNTING_BITS {
                continue;
            }
            let place = |quantity: usize, offset: u32, register: usize| CountedBit {
                quantity,
                bit: offset + self.design.registers[register].name.1,
                inverted: false,
            };
            let is = |place: CountedBit, register: usize| {
                let was = values.iter().zip(later(register));
                was.into_iter()
                    .all(|(of, &is)| place.is_set(of[place.quantity].cast_signed()) == is)
            };
            // The lowest bits are constant where steps are done several at once.
            let mut all = (0..values.first().map_or(0, Vec::len))
                .flat_map(|quantity| (0..8).map(move |offset| (quantity, offset)));
            let found = all.find(|&(quantity, offset)| {
                registers.iter().all(|&register| is(place(quantity, offset, register), register))
            });
            if let Some((quantity, offset)) = found {
                for &register in registers {
                    places[register] = Some(place(quantity, offset, register));
                }
            }
        }
        places
    }

    /// The guess that a register follows a code, if that was so in all groups.
    fn of_code(&self, register: usize, later: &[bool]) -> Option<Guess> {
        let chips = &self.watched.chips[register];
        let recurrence = Recurrence::of(chips).or_else(|| Recurrence::periodic(chips))?;
        let groups: Vec<u64> = (FIRST_GROUPS as u64..).take(later.len()).collect();
        let mut places = CodePlace::all(self.interface).into_iter();
        let place =
            places.find(|&place| at_chips(place, &recurrence, self.interface, &groups) == later)?;
        Some(Guess::Code(place, recurrence))
    }

    /// Guesses of the registers that have a bit of what has been counted.
    fn counted(&self, known: &Known) -> Vec<Option<Guess>> {
        let histories = &self.watched.histories;
        // Where the bits of a word lie among those of a quantity, from the bits that
        // are without doubt; then from any.
        let mut offsets: HashMap<&str, CountedBit> = HashMap::new();
        let mut guesses = vec![None; histories.len()];
        for certain in [true, false, false] {
            for (number, history) in histories.iter().enumerate() {
                if guesses[number].is_some() || !self.design.follow_inputs[number] {
                    continue;
                }
                let (word, bit) = &self.design.registers[number].name;
                let candidates = known.get(history).map_or(&[][..], Vec::as_slice);
                let beside = offsets
                    .get(word.as_str())
                    .map(|place| CountedBit { bit: place.bit + bit, ..*place });
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
                    offsets.entry(word).or_insert(CountedBit { bit: first_bit, ..place });
                }
                guesses[number] = Some(Guess::Counted(place));
            }
        }
        guesses
    }
}

/// A bit of what has been counted, or its inverse.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct CountedBit {
    quantity: usize,
    bit: u32,
    inverted: bool,
}

impl CountedBit {
    /// What a register is where the quantity is `value`.
    fn is_set(self, value: i64) -> bool {
        (value >> self.bit & 1 == 1) != self.inverted
    }
}

/// For each history of a bit, what has it.
type Known = HashMap<Vec<bool>, Vec<CountedBit>>;

fn known_bits(counted: &[Vec<i64>]) -> Known {
    let mut known = Known::new();
    for quantity in 0..counted[0].len() {
        for bit in 0..i64::BITS {
            for inverted in [false, true] {
                let history: Vec<bool> = counted
                    .iter()
                    .map(|values| CountedBit { quantity, bit, inverted }.is_set(values[quantity]))
                    .collect();
                known.entry(history).or_default().push(CountedBit { quantity, bit, inverted });
            }
        }
    }
    known
}
