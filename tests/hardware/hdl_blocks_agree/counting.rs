//! From samples to counts.

use goldtof::rtl::blocks::{
    Accumulator, CountClamp, EdgeDetector, HitCounter, QuadCounter, UpdownCorrelator,
};
use goldtof::rtl::front::Word;
use goldtof::scene::Polarity;
use goldtof::sensor::interface::{CountSegments, TotalCount};

use super::{CLOCKS, bit, signed, wrapped};
use crate::hdl_support::block_testbench::{Case, Ports};
use crate::hdl_support::stimulus::Noise;

/// A high sample after a low one is a hit of its pair; its place is that of the
/// pair's earlier sample if that is high.
pub fn edge_detector(noise: &mut Noise) -> Case {
    let inputs = noise
        .words(CLOCKS, |noise| vec![u128::from(noise.below(256)), u128::from(noise.below(8) != 0)]);
    let mut before = false;
    let expected = inputs.iter().enumerate().map(|(clock, input)| {
        if clock < Case::RESET_CLOCKS {
            return Some(vec![0, 0]);
        }
        let (mut hits, mut early) = (0, 0);
        for sample in 0..8 {
            let high = bit(input[0], sample);
            if high && !before && input[1] == 1 {
                hits |= 1 << (sample / 2);
            }
            early |= u128::from(high && sample % 2 == 0) << (sample / 2);
            before = high;
        }
        Some(vec![hits, early])
    });
    let expected = expected.collect();
    Case::clocked(
        EdgeDetector::new(8, Polarity::High),
        Ports::new(&[("i_samples", 8), ("i_run", 1)], &[("o_hits", 4), ("o_early", 4)]),
        inputs,
        expected,
        |block, input| {
            block.i_samples.next = Word::new(input[0], 8);
            block.i_run.next = input[1] == 1;
        },
        |block| vec![block.o_hits.val().value(), block.o_early.val().value()],
    )
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
    Case::clocked(
        QuadCounter::new(),
        Ports::new(&[("i_hit", 4), ("i_down", 4)], &[("o_sum", 4)]),
        inputs,
        expected,
        |block, input| {
            block.i_hit.next = Word::new(input[0], 4);
            block.i_down.next = Word::new(input[1], 4);
        },
        |block| vec![block.o_sum.val().value()],
    )
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
    Case::clocked(
        Accumulator::new(9, 4, false, false),
        Ports::new(&[("i_addend", 4), ("i_dump", 1)], &[("o_count", 9)]),
        inputs,
        expected,
        |block, input| {
            block.i_addend.next = Word::new(input[0], 4);
            block.i_dump.next = input[1] == 1;
        },
        |block| vec![block.o_count.val().value()],
    )
}

/// Counts of phase steps of random lengths, with a total in three segments: a
/// word is in the total after four clocks.
pub fn updown_correlator(noise: &mut Noise) -> Case {
    const TO_TOTAL: usize = 4;
    let segments = CountSegments { count: 3, lower_bits: 4, top_bits: 3 };
    let mut dumps = vec![false; CLOCKS];
    let mut clock = 20;
    while clock < CLOCKS {
        dumps[clock] = true;
        clock += 6 + noise.below(60) as usize;
    }
    let mut clock = 0;
    let inputs = noise.words(CLOCKS, |noise| {
        let hits = u128::from(noise.below(16));
        let dump = (0..3).filter(|&s| clock >= s && dumps[clock - s]);
        let dump = dump.fold(0, |dump, s| dump | 1 << s);
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
    let mut expected = vec![None; CLOCKS];
    let mut from = Case::RESET_CLOCKS;
    let ends: Vec<usize> = (0..CLOCKS).filter(|&clock| dumps[clock]).collect();
    for (number, &end) in ends.iter().enumerate() {
        let until = end - TO_TOTAL + 1;
        let count: i128 = inputs[from..until].iter().map(of_word).sum();
        from = until;
        let next = ends.get(number + 1).copied().unwrap_or(CLOCKS);
        let complete = end + segments.clocks() as usize - 1;
        for shown in expected.iter_mut().take(next).skip(complete) {
            *shown = Some(vec![wrapped(count, segments.bits())]);
        }
    }
    Case::clocked(
        UpdownCorrelator::new(8, segments),
        Ports::new(
            &[("i_hits", 4), ("i_early", 4), ("i_reference", 8), ("i_dump", 3)],
            &[("o_count", 11)],
        ),
        inputs,
        expected,
        |block, input| {
            block.i_hits.next = Word::new(input[0], 4);
            block.i_early.next = Word::new(input[1], 4);
            block.i_reference.next = Word::new(input[2], 8);
            block.i_dump.next = Word::new(input[3], 3);
        },
        |block| vec![block.o_count.val().value()],
    )
}

/// Hits of phase steps of random lengths, whatever their sign, in as many bits as
/// are sent: a word is in the total a clock after its hits, and a clock later for
/// each halving of its pairs.
pub fn hit_counter(noise: &mut Noise, lanes: u32, segments: CountSegments, bits: u32) -> Case {
    let pairs = lanes.div_ceil(2);
    let to_total = 2 + pairs.ilog2() as usize;
    let exact_bits = segments.bits() - 1;
    let plan = TotalCount { exact_bits, bits, first_bit: 8 };
    let mut dumps = vec![false; CLOCKS];
    let mut clock = 20;
    while clock < CLOCKS {
        dumps[clock] = true;
        clock += 6 + noise.below(60) as usize;
    }
    let mut clock = 0;
    let inputs = noise.words(CLOCKS, |noise| {
        let dump =
            (0..segments.count).filter(|&s| clock >= s as usize && dumps[clock - s as usize]);
        let dump = dump.fold(0, |dump, s| dump | 1 << s);
        clock += 1;
        // Long stretches without a pause reach the most that there can be.
        let hits = match clock / 500 % 2 {
            0 => noise.below(1 << pairs),
            _ => (1 << pairs) - 1,
        };
        vec![u128::from(hits), dump]
    });
    let mut expected = vec![None; CLOCKS];
    let mut from = Case::RESET_CLOCKS;
    let ends: Vec<usize> = (0..CLOCKS).filter(|&clock| dumps[clock]).collect();
    let saturates = bits < exact_bits;
    for (number, &end) in ends.iter().enumerate() {
        let until = end - to_total + 1;
        let words = inputs[from..until].iter();
        let total: u32 = words.map(|input| input[0].count_ones()).sum();
        let most = (1 << bits) - 1;
        // What the counter is not wide enough for, an interface never sends it.
        let total = u128::from(total) % (1 << exact_bits);
        from = until;
        let next = ends.get(number + 1).copied().unwrap_or(CLOCKS);
        let complete = end + segments.clocks() as usize - 1;
        for shown in expected.iter_mut().take(next).skip(complete) {
            let mut outputs = vec![total.min(most)];
            outputs.extend(saturates.then_some(u128::from(total > most)));
            *shown = Some(outputs);
        }
    }
    let mut outputs = vec![("o_total", bits)];
    outputs.extend(saturates.then_some(("o_clamped", 1)));
    let count = segments.count;
    Case::clocked(
        HitCounter::new(lanes as usize, plan, segments),
        Ports::new(&[("i_hits", pairs), ("i_dump", count)], &outputs),
        inputs,
        expected,
        move |block, input| {
            block.i_hits.next = Word::new(input[0], pairs);
            block.i_dump.next = Word::new(input[1], count);
        },
        move |block| {
            let mut outputs = vec![block.o_total.val().value()];
            if saturates {
                outputs.push(u128::from(block.o_clamped.val()));
            }
            outputs
        },
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
    Case::combinational(
        CountClamp::new(12, 7),
        Ports::new(&[("i_count", 12)], &[("o_count", 7), ("o_clamped", 1)]),
        inputs,
        expected,
        |block, input| block.i_count.next = Word::new(input[0], 12),
        |block| vec![block.o_count.val().value(), u128::from(block.o_clamped.val())],
    )
}
