//! The level of a detector from those of its cells.
//!
//! Samples go side by side through gates that are as wide as a word. For an OR, an AND or an XOR there is
//! nothing else; between these, pulses are counted by full adders, each of which takes three words of one
//! weight and gives one of that weight and one of twice as much, until there is one of each.
//!
//! Cost (ECP5, 8 samples, docs/resources.md): 2 LUTs for an OR of 4 cells, 22 for two of 4, 186 for two of 16; left out
//! where cells are combined before the FPGA.

use crate::rtl::front::prelude::*;
use crate::scene::Polarity;
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
    /// A pulse is low.
    polarity: Polarity,
    #[set(polarity == Polarity::Low)]
    inverts: bool,
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
    /// high during a pulse
    #[width(lanes * count)]
    pulses: Local<Word>,
    /// pulses of cells; then sum and carry of each adder
    #[each(_word in 0..adders.words)]
    #[width(lanes)]
    word: Vec<Local<Word>>,
    /// high during a pulse
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
    list: Vec<Adder>,
    /// Words of all cells and adders.
    words: usize,
    /// The word of each digit, from the lowest that matters up, and whether the number that is asked for
    /// has it.
    digits: Vec<(usize, bool)>,
}

/// Words of the same weight that are added.
#[derive(Debug, Clone)]
struct Adder {
    first: usize,
    second: usize,
    third: Option<usize>,
    /// Their sum's word of that weight, if it matters.
    sum: Option<usize>,
    /// And of twice that weight.
    carry: usize,
}

impl Adders {
    /// Of so many cells, of which at least `least` are asked for, more than one and less than all.
    fn of(cells: usize, least: u32) -> Adders {
        let lowest = least.trailing_zeros() as usize;
        let mut adders = Adders { words: cells, ..Adders::default() };
        let mut of_weight: Vec<usize> = (0..cells).collect();
        for digit in 0.. {
            let mut of_next = Vec::new();
            let mut at = 0;
            while at + 1 < of_weight.len() {
                let third = of_weight.get(at + 2).copied();
                let is_last = at + 3 >= of_weight.len();
                let has_sum = digit >= lowest || !is_last;
                let carry = adders.words + usize::from(has_sum);
                let sum = has_sum.then_some(adders.words);
                let (first, second) = (of_weight[at], of_weight[at + 1]);
                adders.list.push(Adder { first, second, third, sum, carry });
                adders.words = carry + 1;
                at += if third.is_some() { 3 } else { 2 };
                of_weight.extend(sum);
                of_next.push(carry);
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
}

#[kernel]
impl Logic for CellCombiner {
    fn update(&mut self) {
        if self.inverts {
            self.pulses.next = !self.i_samples.val();
        } else {
            self.pulses.next = self.i_samples.val();
        }
        if self.adders.list.is_empty() {
            self.join();
        } else {
            self.count_pulses();
            self.compare();
        }
        if self.inverts {
            self.o_level.next = !self.level.val();
        } else {
            self.o_level.next = self.level.val();
        }
    }

    fn join(&mut self) {
        let lanes = self.lanes;
        self.level.next = self.pulses.val().slice(0, lanes);
        for c in 1..self.count {
            if self.is_xor {
                self.level.next = self.level.val() ^ self.pulses.val().slice(lanes * c, lanes);
            } else if self.is_or {
                self.level.next = self.level.val() | self.pulses.val().slice(lanes * c, lanes);
            } else {
                self.level.next = self.level.val() & self.pulses.val().slice(lanes * c, lanes);
            }
        }
    }

    fn count_pulses(&mut self) {
        let lanes = self.lanes;
        for c in 0..self.count {
            self.word[c].next = self.pulses.val().slice(lanes * c, lanes);
        }
        for a in 0..self.adders.list.len() {
            if self.adders.list[a].third.is_some() {
                self.add_three(a);
            } else {
                self.add_two(a);
            }
        }
    }

    fn add_three(&mut self, a: usize) {
        let first = self.adders.list[a].first;
        let second = self.adders.list[a].second;
        let third = self.adders.list[a].third.unwrap_or_default();
        if self.adders.list[a].sum.is_some() {
            let sum = self.adders.list[a].sum.unwrap_or_default();
            self.word[sum].next =
                self.word[first].val() ^ self.word[second].val() ^ self.word[third].val();
        }
        let carry = self.adders.list[a].carry;
        self.word[carry].next = (self.word[first].val() & self.word[second].val())
            | (self.word[third].val() & (self.word[first].val() | self.word[second].val()));
    }

    fn add_two(&mut self, a: usize) {
        let first = self.adders.list[a].first;
        let second = self.adders.list[a].second;
        if self.adders.list[a].sum.is_some() {
            let sum = self.adders.list[a].sum.unwrap_or_default();
            self.word[sum].next = self.word[first].val() ^ self.word[second].val();
        }
        let carry = self.adders.list[a].carry;
        self.word[carry].next = self.word[first].val() & self.word[second].val();
    }

    /// Whether there are as many as asked for, from the lowest digit up.
    fn compare(&mut self) {
        self.level.next = self.word[self.adders.digits[0].0].val();
        for d in 1..self.adders.digits.len() {
            if self.adders.digits[d].1 {
                self.level.next = self.level.val() & self.word[self.adders.digits[d].0].val();
            } else {
                self.level.next = self.level.val() | self.word[self.adders.digits[d].0].val();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of all numbers of pulses, whichever cells have them; and no word is made that is not used.
    #[test]
    fn adders_count_any_pulses() {
        for cells in 3..=64 {
            for least in 2..cells as u32 {
                let adders = Adders::of(cells, least);
                let mut uses = vec![0; adders.words];
                for adder in &adders.list {
                    let addends = [Some(adder.first), Some(adder.second), adder.third];
                    addends.into_iter().flatten().for_each(|word| uses[word] += 1);
                }
                adders.digits.iter().for_each(|(word, _)| uses[*word] += 1);
                assert!(uses.iter().all(|&uses| uses == 1), "{least} of {cells}: {uses:?}");
                for pulses in 0..=cells {
                    let mut words = vec![false; adders.words];
                    (0..pulses).for_each(|n| words[n * 7 % cells] = true);
                    let high = words.iter().filter(|&&word| word).count();
                    for adder in &adders.list {
                        let third = adder.third.is_some_and(|third| words[third]);
                        let addends = [words[adder.first], words[adder.second], third];
                        let ones = addends.iter().filter(|&&one| one).count();
                        if let Some(sum) = adder.sum {
                            words[sum] = ones % 2 == 1;
                        }
                        words[adder.carry] = ones >= 2;
                    }
                    let level = adders.digits[1..].iter().fold(
                        words[adders.digits[0].0],
                        |level, &(word, is_one)| match is_one {
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
