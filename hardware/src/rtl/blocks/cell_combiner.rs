//! The level of a detector from those of its cells.
//!
//! Samples go side by side through gates that are as wide as a word. For an OR, an AND or an XOR there is
//! nothing else; between these, pulses are counted by full adders, each of which takes three words of one
//! weight and gives one of that weight and one of twice as much, until there is one of each (C. S. Wallace, "A suggestion for
//! a fast multiplier", 1964). Those of a round stand side by side, so that a round is two statements.
//!
//! Cost (ECP5, 8 samples, docs/resources.md): 2 LUTs for an OR of 4 cells, 22 for two of 4, 186 for two of 16; left out
//! where cells are combined before the FPGA.

use crate::rtl::front::prelude::*;
use crate::sensor::cells::{Cells, Gates};

#[block(cell_combiner)]
/// level of a detector, from those of its {count} cells
///
/// A sample of it shows a pulse where {about_level(&cells)}.
///
/// - Latency: none
pub struct CellCombiner {
    lanes: usize,
    cells: Cells,
    #[set(cells.count as usize)]
    count: usize,
    #[set(cells.gates() == Some(Gates::Xor))]
    is_xor: bool,
    #[set(cells.gates() == Some(Gates::Or))]
    is_or: bool,
    /// How pulses are counted, where some of them are asked for.
    #[set(match cells.gates() { Some(Gates::AtLeast(least)) => Adders::of(count, least), _ => Adders::default() })]
    adders: Adders,
    /// level of each cell, bit 0 earliest, cell 0 lowest
    #[width(lanes * count)]
    pub i_samples: Input<Word>,
    /// level of the detector, bit 0 earliest
    #[width(lanes)]
    pub o_level: Output<Word>,
    /// words that a round of adders takes: their first ones lowest, then their second and third
    #[each(round in adders.rounds.iter())]
    #[width(lanes * round.inputs() * round.adders.len())]
    addends: Vec<Local<Word>>,
    /// their sums, as far as these matter
    #[each(round in adders.rounds.iter().filter(|round| round.sums() > 0))]
    #[width(lanes * round.sums())]
    sum: Vec<Local<Word>>,
    /// and their carries
    #[each(round in adders.rounds.iter())]
    #[width(lanes * round.adders.len())]
    carry: Vec<Local<Word>>,
    /// digits of their number, from the lowest that matters
    #[each(_digit in adders.digits.iter())]
    #[width(lanes)]
    digit: Vec<Local<Word>>,
    #[width(lanes)]
    level: Local<Word>,
}

/// What is said of the level.
fn about_level(cells: &Cells) -> String {
    match cells.gates() {
        Some(Gates::Xor) => "an odd number of cells' samples do".to_owned(),
        None | Some(Gates::Or) => "any cell's sample does".to_owned(),
        Some(Gates::And) => "all cells' samples do".to_owned(),
        Some(Gates::AtLeast(least)) => format!("at least {least} cells' samples do"),
    }
}

/// Full and half adders that count words of one bit each.
#[derive(Debug, Clone, Default)]
struct Adders {
    rounds: Vec<Round>,
    /// The word of each digit, from the lowest that matters up, and whether the number that is asked for
    /// has it.
    digits: Vec<(Source, bool)>,
}

/// Adders that need no other's result.
#[derive(Debug, Clone, Default)]
struct Round {
    adders: Vec<Adder>,
}

/// What an adder takes: words of the same weight, a full one three, a half one two.
#[derive(Debug, Clone)]
struct Adder {
    words: Vec<Source>,
    /// Whether its sum matters.
    has_sum: bool,
}

/// Where a word comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Source {
    Cell(usize),
    /// Of a round, the sum of an adder.
    Sum(usize, usize),
    /// Of a round, the carry of an adder.
    Carry(usize, usize),
}

impl Source {
    /// The round that makes it.
    fn round(self) -> Option<usize> {
        match self {
            Source::Cell(_) => None,
            Source::Sum(round, _) | Source::Carry(round, _) => Some(round),
        }
    }
}

impl Round {
    /// Words that an adder takes: of half adders beside full ones the third is 0.
    fn inputs(&self) -> usize {
        self.adders.iter().map(|adder| adder.words.len()).max().unwrap_or(0)
    }

    /// Sums that matter.
    fn sums(&self) -> usize {
        self.adders.iter().filter(|adder| adder.has_sum).count()
    }

    /// Numbers of its adders as they stand side by side: those whose sum does not matter first.
    fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.adders.len()).collect();
        order.sort_by_key(|&number| self.adders[number].has_sum);
        order
    }

    /// What stands at a place among its addends; none for 0.
    fn source(&self, place: usize) -> Option<Source> {
        let adders = self.adders.len();
        self.adders[self.order()[place % adders]].words.get(place / adders).copied()
    }
}

impl Adders {
    /// A word's place among those of its kind that stand side by side.
    fn place(&self, source: Source) -> usize {
        let place = |round: usize, number| {
            self.rounds[round].order().iter().position(|&other| other == number).unwrap_or(0)
        };
        match source {
            Source::Cell(cell) => cell,
            Source::Sum(round, number) => {
                let of = &self.rounds[round];
                place(round, number) - (of.adders.len() - of.sums())
            }
            Source::Carry(round, number) => place(round, number),
        }
    }

    /// The bit of what an addend of a round comes from that is one of the addends' bits.
    fn bit(&self, round: usize, bit: usize, lanes: usize) -> usize {
        let source = self.rounds[round].source(bit / lanes);
        lanes * source.map_or(0, |source| self.place(source)) + bit % lanes
    }

    /// The round that an addend of a round comes from.
    fn made_in(&self, round: usize, place: usize) -> usize {
        self.rounds[round].source(place).and_then(Source::round).unwrap_or(0)
    }

    /// Which of the words of sums are a round's.
    fn sums_of(&self, round: usize) -> usize {
        self.rounds[..round].iter().filter(|round| round.sums() > 0).count()
    }

    /// Of so many cells, of which at least `least` are asked for, more than one and less than all.
    fn of(cells: usize, least: u32) -> Adders {
        let lowest = least.trailing_zeros() as usize;
        let mut adders = Adders::default();
        let mut of_weight: Vec<Source> = (0..cells).map(Source::Cell).collect();
        for digit in 0.. {
            let mut of_next = Vec::new();
            let mut at = 0;
            while at + 1 < of_weight.len() {
                let words = of_weight[at..of_weight.len().min(at + 3)].to_vec();
                let is_last = at + 3 >= of_weight.len();
                at += words.len();
                let has_sum = digit >= lowest || !is_last;
                let (round, number) = adders.add(Adder { words, has_sum });
                of_weight.extend(has_sum.then_some(Source::Sum(round, number)));
                of_next.push(Source::Carry(round, number));
            }
            if digit >= lowest {
                adders.digits.push((of_weight[at], least >> digit & 1 == 1));
            }
            if of_next.is_empty() {
                break;
            }
            of_weight = of_next;
        }
        adders
    }

    /// Adds words in the first round that has all of them: which round that is, and which of its adders.
    fn add(&mut self, adder: Adder) -> (usize, usize) {
        let made = adder.words.iter().filter_map(|word| word.round());
        let round = made.max().map_or(0, |made| made + 1);
        if round == self.rounds.len() {
            self.rounds.push(Round::default());
        }
        self.rounds[round].adders.push(adder);
        (round, self.rounds[round].adders.len() - 1)
    }
}

#[kernel]
impl Logic for CellCombiner {
    fn update(&mut self) {
        if self.adders.rounds.is_empty() {
            self.join();
        } else {
            self.count_pulses();
            self.compare();
        }
        self.o_level.next = self.level.val();
    }

    fn join(&mut self) {
        let lanes = self.lanes;
        self.level.next = self.i_samples.val().slice(0, lanes);
        for c in 1..self.count {
            if self.is_xor {
                self.level.next = self.level.val() ^ self.i_samples.val().slice(lanes * c, lanes);
            } else if self.is_or {
                self.level.next = self.level.val() | self.i_samples.val().slice(lanes * c, lanes);
            } else {
                self.level.next = self.level.val() & self.i_samples.val().slice(lanes * c, lanes);
            }
        }
    }

    /// A round after the other.
    fn count_pulses(&mut self) {
        let lanes = self.lanes;
        for r in 0..self.adders.rounds.len() {
            let count = lanes * self.adders.rounds[r].adders.len();
            let inputs = self.adders.rounds[r].inputs();
            self.addends[r].next = gather(inputs * count, |b| {
                if matches!(self.adders.rounds[r].source(b / lanes), Some(Source::Cell(_))) {
                    self.i_samples.val().get_bit(self.adders.bit(r, b, lanes))
                } else if matches!(self.adders.rounds[r].source(b / lanes), Some(Source::Sum(..))) {
                    self.sum[self.adders.sums_of(self.adders.made_in(r, b / lanes))]
                        .val()
                        .get_bit(self.adders.bit(r, b, lanes))
                } else if self.adders.rounds[r].source(b / lanes).is_some() {
                    self.carry[self.adders.made_in(r, b / lanes)]
                        .val()
                        .get_bit(self.adders.bit(r, b, lanes))
                } else {
                    false
                }
            });
            if inputs > 2 {
                self.add_three(r);
            } else {
                self.add_two(r);
            }
        }
    }

    fn add_three(&mut self, r: usize) {
        let count = self.lanes * self.adders.rounds[r].adders.len();
        let first = count - self.lanes * self.adders.rounds[r].sums();
        if count > first {
            self.sum[self.adders.sums_of(r)].next =
                self.addends[r].val().slice(first, count - first)
                    ^ self.addends[r].val().slice(count + first, count - first)
                    ^ self.addends[r].val().slice(2 * count + first, count - first);
        }
        self.carry[r].next = (self.addends[r].val().slice(0, count)
            & self.addends[r].val().slice(count, count))
            | (self.addends[r].val().slice(2 * count, count)
                & (self.addends[r].val().slice(0, count)
                    | self.addends[r].val().slice(count, count)));
    }

    fn add_two(&mut self, r: usize) {
        let count = self.lanes * self.adders.rounds[r].adders.len();
        let first = count - self.lanes * self.adders.rounds[r].sums();
        if count > first {
            self.sum[self.adders.sums_of(r)].next =
                self.addends[r].val().slice(first, count - first)
                    ^ self.addends[r].val().slice(count + first, count - first);
        }
        self.carry[r].next =
            self.addends[r].val().slice(0, count) & self.addends[r].val().slice(count, count);
    }

    /// Whether there are as many as asked for, from the lowest digit up.
    fn compare(&mut self) {
        let lanes = self.lanes;
        for d in 0..self.adders.digits.len() {
            let source = self.adders.digits[d].0;
            let low = lanes * self.adders.place(source);
            if matches!(source, Source::Sum(..)) {
                self.digit[d].next = self.sum[self.adders.sums_of(source.round().unwrap_or(0))]
                    .val()
                    .slice(low, lanes);
            } else {
                self.digit[d].next =
                    self.carry[source.round().unwrap_or(0)].val().slice(low, lanes);
            }
        }
        self.level.next = self.digit[0].val();
        for d in 1..self.adders.digits.len() {
            if self.adders.digits[d].1 {
                self.level.next = self.level.val() & self.digit[d].val();
            } else {
                self.level.next = self.level.val() | self.digit[d].val();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::*;

    /// Of all numbers of pulses, whichever cells have them; and no word is made that is not used, each once.
    #[test]
    fn adders_count_any_pulses() {
        for cells in 3..=64 {
            for least in 2..cells as u32 {
                let adders = Adders::of(cells, least);
                let mut uses: HashMap<Source, usize> = HashMap::new();
                let taken = adders.rounds.iter().flat_map(|round| &round.adders);
                let taken = taken.flat_map(|adder| adder.words.iter().copied());
                for word in taken.chain(adders.digits.iter().map(|(word, _)| *word)) {
                    *uses.entry(word).or_default() += 1;
                }
                let made: usize =
                    adders.rounds.iter().map(|round| round.sums() + round.adders.len()).sum();
                assert_eq!(uses.len(), cells + made, "{least} of {cells}");
                assert!(uses.values().all(|&uses| uses == 1), "{least} of {cells}: {uses:?}");
                for pulses in 0..=cells {
                    let mut words: HashMap<Source, bool> =
                        (0..cells).map(|cell| (Source::Cell(cell), false)).collect();
                    (0..pulses).for_each(|n| _ = words.insert(Source::Cell(n * 7 % cells), true));
                    let high = words.values().filter(|&&word| word).count();
                    for (number, round) in adders.rounds.iter().enumerate() {
                        for (place, adder) in round.adders.iter().enumerate() {
                            let ones = adder.words.iter().filter(|word| words[*word]).count();
                            if adder.has_sum {
                                words.insert(Source::Sum(number, place), ones % 2 == 1);
                            }
                            words.insert(Source::Carry(number, place), ones >= 2);
                        }
                    }
                    let level = adders.digits[1..].iter().fold(
                        words[&adders.digits[0].0],
                        |level, (word, is_one)| match is_one {
                            true => level & words[word],
                            false => level | words[word],
                        },
                    );
                    assert_eq!(level, high >= least as usize, "{least} of {cells}: {high}");
                }
            }
        }
    }
}
