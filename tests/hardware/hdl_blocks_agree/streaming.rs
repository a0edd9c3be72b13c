//! Results on their way out.

use std::collections::VecDeque;

use goldtof::rtl::blocks::ResultStream;
use goldtof::rtl::front::Word;
use goldtof::sensor::interface::TotalCount;

use super::{CLOCKS, signed, wrapped};
use crate::hdl_support::block_testbench::{Case, Ports};
use crate::hdl_support::stimulus::Noise;

/// A queue of results: a group is taken in whole when nothing else waits, one
/// result leaves per clock.
/// With totals each count has its detector's above it.
pub fn result_stream(
    noise: &mut Noise,
    detectors: u32,
    steps: u32,
    last_steps: u32,
    has_totals: bool,
) -> Case {
    const BITS: u32 = 6;
    const TOTAL_BITS: u32 = 5;
    let totals = if has_totals { detectors as usize } else { 0 };
    let data_bits = if has_totals { 16 } else { 8 };
    let counts = (detectors * steps) as usize;
    let mut wait = 10;
    let mut hurry = 1;
    let mut arrivals = Vec::new();
    let inputs = noise.words(CLOCKS, |noise| {
        // Bursts in which groups come sooner than they can leave.
        if noise.below(100) == 0 {
            hurry = 1 + noise.below(3);
        }
        let comes = wait == 0;
        if comes {
            wait = 2 + noise.below(3 * counts as u64 / hurry + 1);
        }
        wait -= 1;
        arrivals.push(comes);
        let last = u128::from(noise.below(3) == 0);
        let mut input = vec![u128::from(comes), last, u128::from(noise.below(4) != 0)];
        input.extend((0..counts).map(|_| u128::from(noise.below(1 << BITS))));
        input.extend((0..totals).map(|_| u128::from(noise.below(1 << TOTAL_BITS))));
        input
    });
    let mut queue = VecDeque::new();
    let (mut shown, mut valid, mut overrun) = ((0, false), false, false);
    let mut expected: Vec<_> = (0..CLOCKS)
        .map(|clock| {
            let input = &inputs[clock];
            if clock < Case::RESET_CLOCKS {
                return Some(vec![0, 0, 0, 0]);
            }
            if valid && input[2] == 1 {
                valid = false;
            }
            if input[0] == 1 {
                if valid || !queue.is_empty() {
                    overrun = true;
                } else {
                    let sent = if input[1] == 1 { last_steps } else { steps };
                    for detector in 0..detectors {
                        for step in 0..sent {
                            let count = input[(3 + detector * steps + step) as usize];
                            let mut data = wrapped(signed(count, BITS), 8);
                            if has_totals {
                                data |= input[3 + counts + detector as usize] << 8;
                            }
                            let is_last = detector + 1 == detectors && step + 1 == sent;
                            queue.push_back((data, is_last && input[1] == 1));
                        }
                    }
                }
            }
            if !valid && let Some(next) = queue.pop_front() {
                shown = next;
                valid = true;
            }
            Some(vec![shown.0, u128::from(valid), u128::from(shown.1), u128::from(overrun)])
        })
        .collect();
    // The block is told of counts a clock before they come, if there are several.
    let several = counts > 1;
    let mut inputs = inputs;
    for (clock, input) in inputs.iter_mut().enumerate().filter(|_| several) {
        let early = arrivals.get(clock + 1).is_some_and(|&comes| comes);
        input.insert(0, u128::from(early));
    }
    expected.truncate(CLOCKS);
    // A vector of one port has no number.
    let numbered = |name: &str, number: usize, of: usize| match of {
        1 => name.to_owned(),
        _ => format!("{name}_{number}"),
    };
    let names: Vec<String> = (0..counts).map(|count| numbered("i_count", count, counts)).collect();
    let mut ports = match several {
        true => vec![("i_pre_counted", 1)],
        false => Vec::new(),
    };
    ports.extend([("i_counted", 1), ("i_last", 1), ("i_ready", 1)]);
    let total_names: Vec<String> =
        (0..totals).map(|total| numbered("i_total", total, totals)).collect();
    ports.extend(names.iter().map(|name| (name.as_str(), BITS)));
    ports.extend(total_names.iter().map(|name| (name.as_str(), TOTAL_BITS)));
    let total =
        has_totals.then_some(TotalCount { exact_bits: TOTAL_BITS, bits: TOTAL_BITS, first_bit: 8 });
    let (detectors, steps, last_steps) = (detectors as usize, steps as usize, last_steps as usize);
    Case::clocked(
        ResultStream::new(BITS, false, total, detectors, steps, last_steps, false),
        Ports::new(
            &ports,
            &[("o_data", data_bits), ("o_valid", 1), ("o_last", 1), ("o_overrun", 1)],
        ),
        inputs,
        expected,
        move |block, input| {
            let input = match input {
                [early, rest @ ..] if several => {
                    block.i_pre_counted.next = *early == 1;
                    rest
                }
                whole => whole,
            };
            block.i_counted.next = input[0] == 1;
            block.i_last.next = input[1] == 1;
            block.i_ready.next = input[2] == 1;
            for count in 0..counts {
                block.i_count[count].next = Word::new(input[3 + count], BITS);
            }
            for total in 0..totals {
                let value = Word::new(input[3 + counts + total], TOTAL_BITS);
                block.i_total[total].next = value;
            }
        },
        |block| {
            vec![
                block.o_data.val().value(),
                u128::from(block.o_valid.val()),
                u128::from(block.o_last.val()),
                u128::from(block.o_overrun.val()),
            ]
        },
    )
}
