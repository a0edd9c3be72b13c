//! From samples to counts.

use std::ops::Range;

use goldtof::rtl::blocks::{
    Accumulator, CellCombiner, CountClamp, EdgeDetector, HitCounter, QuadCounter, UpdownCorrelator,
};
use goldtof::scene::Combination;
use goldtof::sensor::cells::Cells;
use goldtof::sensor::interface::{CountSegments, TotalCount};

use super::{CLOCKS, bit, signed, wrapped};
use crate::hdl_support::block_testbench::Case;
use crate::hdl_support::stimulus::Noise;

/// A high sample after a low one is a hit of its pair; its place is that of the
/// pair's earlier sample if that is high.
///
/// Of several cells each has edges of its own.
pub fn edge_detector(noise: &mut Noise, lanes: usize, cells: usize) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        vec![u128::from(noise.below(1 << (lanes * cells))), u128::from(noise.below(8) != 0)]
    });
    let mut before = vec![false; cells];
    let pairs = lanes.div_ceil(2);
    let outputs = |hits, early| if lanes > 1 { vec![hits, early] } else { vec![hits] };
    let expected = inputs.iter().enumerate().map(|(clock, input)| {
        if clock < Case::RESET_CLOCKS {
            return Some(outputs(0, 0));
        }
        let (mut hits, mut early) = (0, 0);
        for (cell, before) in before.iter_mut().enumerate() {
            for sample in 0..lanes {
                let high = bit(input[0], lanes * cell + sample);
                let pair = pairs * cell + sample / 2;
                hits |= u128::from(high && !*before && input[1] == 1) << pair;
                early |= u128::from(high && sample % 2 == 0) << pair;
                *before = high;
            }
        }
        Some(outputs(hits, early))
    });
    let expected = expected.collect();
    Case::new(
        EdgeDetector::new(lanes, cells),
        (&["i_samples", "i_run"], if lanes > 1 { &["o_hits", "o_early"] } else { &["o_hits"] }),
        inputs,
        expected,
    )
}

/// The level of a detector is high in the samples at which as many of its cells have a pulse as asked for,
/// or of 0 an odd number of them.
pub fn cell_combiner(noise: &mut Noise, cells: u32, least: u32) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        let few = noise.below(2) == 0;
        let word = |noise: &mut Noise| u128::from(noise.next() & ((1 << (4 * cells)) - 1));
        vec![if few { word(noise) & word(noise) } else { word(noise) }]
    });
    let expected = inputs.iter().map(|input| {
        let has_pulse = |cell: &u32, sample: usize| bit(input[0], 4 * *cell as usize + sample);
        let level = (0..4).fold(0, |level, sample| {
            let pulses = (0..cells).filter(|cell| has_pulse(cell, sample)).count() as u32;
            let is_high = if least == 0 { pulses % 2 == 1 } else { pulses >= least };
            level | u128::from(is_high) << sample
        });
        Some(vec![level])
    });
    let expected = expected.collect();
    let combination = if least == 0 { Combination::Xor } else { Combination::Or };
    let law = Cells { count: cells, combination, coincidence: least.max(1) };
    Case::new(CellCombiner::new(4, law), (&["i_samples"], &["o_level"]), inputs, expected)
}

/// Hits less twice those that count down, two clocks later.
pub fn quad_counter(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        let hit = noise.below(16);
        vec![u128::from(hit), u128::from(hit & noise.below(16))]
    });
    let expected = (0..CLOCKS).map(|clock| {
        let sum = match clock.checked_sub(1).filter(|&c| c >= Case::RESET_CLOCKS) {
            Some(clock) => {
                let (hit, down) = (inputs[clock][0], inputs[clock][1]);
                i128::from(hit.count_ones()) - 2 * i128::from(down.count_ones())
            }
            None => 0,
        };
        Some(vec![wrapped(sum, 4)])
    });
    let expected = expected.collect();
    Case::new(QuadCounter::new(), (&["i_hit", "i_down"], &["o_sum"]), inputs, expected)
}

/// What the addends between two dumps come to.
pub fn accumulator(noise: &mut Noise) -> Case {
    let inputs = noise
        .words(CLOCKS, |noise| vec![u128::from(noise.below(16)), u128::from(noise.below(6) == 0)]);
    let (mut since_dump, mut count) = (0, 0);
    let expected = inputs.iter().enumerate().map(|(clock, input)| {
        if clock >= Case::RESET_CLOCKS {
            if input[1] == 1 {
                count = since_dump;
                since_dump = 0;
            }
            since_dump += signed(input[0], 4);
        }
        Some(vec![wrapped(count, 9)])
    });
    let expected = expected.collect();
    Case::new(
        Accumulator::new(9, 4, false, false),
        (&["i_addend", "i_dump"], &["o_count"]),
        inputs,
        expected,
    )
}

/// When the phase steps of a total in segments end.
struct Dumps {
    ends: Vec<usize>,
    segments: CountSegments,
}

impl Dumps {
    fn at_random(noise: &mut Noise, segments: CountSegments) -> Dumps {
        let mut ends = vec![20];
        while ends[ends.len() - 1] < CLOCKS {
            ends.push(ends[ends.len() - 1] + 6 + noise.below(60) as usize);
        }
        ends.pop();
        Dumps { ends, segments }
    }

    /// What the segments are told at a clock, each a clock behind the one below it.
    fn word(&self, clock: usize) -> u128 {
        let ends = |s: u32| clock.checked_sub(s as usize).is_some_and(|c| self.ends.contains(&c));
        (0..self.segments.count).filter(|&s| ends(s)).fold(0, |word, s| word | 1 << s)
    }

    /// What `of` makes of each step's words, while it is complete and not yet the next step's; a
    /// word is in the total after some clocks.
    fn shown(
        &self,
        to_total: usize,
        of: impl Fn(Range<usize>) -> Vec<u128>,
    ) -> Vec<Option<Vec<u128>>> {
        let mut shown = vec![None; CLOCKS];
        let mut from = Case::RESET_CLOCKS;
        for (number, &end) in self.ends.iter().enumerate() {
            let until = end - to_total + 1;
            let next = self.ends.get(number + 1).copied().unwrap_or(CLOCKS);
            let complete = end + self.segments.clocks() as usize - 1;
            let outputs = of(from..until);
            shown.iter_mut().take(next).skip(complete).for_each(|s| *s = Some(outputs.clone()));
            from = until;
        }
        shown
    }
}

/// Counts of phase steps of random lengths, with a total in three segments: a
/// word is in the total after four clocks.
pub fn updown_correlator(noise: &mut Noise) -> Case {
    const TO_TOTAL: usize = 4;
    let segments = CountSegments { count: 3, lower_bits: 4, top_bits: 3 };
    let dumps = Dumps::at_random(noise, segments);
    let mut clock = 0;
    let inputs = noise.words(CLOCKS, |noise| {
        let hits = u128::from(noise.below(16));
        let dump = dumps.word(clock);
        clock += 1;
        vec![hits, u128::from(noise.below(16)), u128::from(noise.below(256)), dump]
    });
    let of_word = |input: &Vec<u128>| -> i128 {
        let pairs = (0..4).filter(|&pair| bit(input[0], pair));
        pairs
            .map(|pair| {
                let sample = 2 * pair + usize::from(!bit(input[1], pair));
                if bit(input[2], sample) { 1 } else { -1 }
            })
            .sum()
    };
    let expected = dumps.shown(TO_TOTAL, |words| {
        let count: i128 = inputs[words].iter().map(of_word).sum();
        vec![wrapped(count, segments.bits())]
    });
    Case::new(
        UpdownCorrelator::new(8, 4, Some(segments)),
        (&["i_hits", "i_early", "i_reference", "i_dump"], &["o_count"]),
        inputs,
        expected,
    )
}

/// Hits of phase steps of random lengths, whatever their sign, in as many bits as
/// are sent: a word is in the total a clock after its hits, and a clock later for
/// each halving of its pairs.
pub fn hit_counter(noise: &mut Noise, pairs: u32, segments: CountSegments, bits: u32) -> Case {
    let to_total = 2 + pairs.next_power_of_two().ilog2() as usize;
    let exact_bits = segments.bits() - 1;
    let plan = TotalCount { exact_bits, bits, first_bit: 8 };
    let dumps = Dumps::at_random(noise, segments);
    let mut clock = 0;
    let inputs = noise.words(CLOCKS, |noise| {
        let dump = dumps.word(clock);
        clock += 1;
        // Long stretches without a pause reach the most that there can be.
        let hits = match clock / 500 % 2 {
            0 => noise.below(1 << pairs),
            _ => (1 << pairs) - 1,
        };
        vec![u128::from(hits), dump]
    });
    let saturates = bits < exact_bits;
    let expected = dumps.shown(to_total, |words| {
        let total: u32 = inputs[words].iter().map(|input| input[0].count_ones()).sum();
        let most = (1 << bits) - 1;
        // What the counter is not wide enough for, an interface never sends it.
        let total = u128::from(total) % (1 << exact_bits);
        let mut outputs = vec![total.min(most)];
        outputs.extend(saturates.then_some(u128::from(total > most)));
        outputs
    });
    let outputs: &[&str] = if saturates { &["o_total", "o_clamped"] } else { &["o_total"] };
    Case::new(
        HitCounter::new(pairs as usize, plan, segments),
        (&["i_hits", "i_dump"], outputs),
        inputs,
        expected,
    )
}

pub fn count_clamp(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| vec![u128::from(noise.below(1 << 12))]);
    let expected = inputs.iter().map(|input| {
        let exact = signed(input[0], 12);
        let saturated = exact.clamp(-64, 63);
        Some(vec![wrapped(saturated, 7), u128::from(saturated != exact)])
    });
    let expected = expected.collect();
    Case::new(CountClamp::new(12, 7), (&["i_count"], &["o_count", "o_clamped"]), inputs, expected)
}
