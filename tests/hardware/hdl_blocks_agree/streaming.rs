//! Results on their way out.

use std::collections::VecDeque;

use goldtof::rtl::blocks::{Groups, ResultStream};
use goldtof::sensor::interface::TotalCount;

use super::{CLOCKS, signed, wrapped};
use crate::hdl_support::block_testbench::Case;
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
    let mut ports = vec!["i_counted", "i_last", "i_ready", "i_count"];
    ports.extend(has_totals.then_some("i_total"));
    if several {
        ports.insert(0, "i_pre_counted");
    }
    let total =
        has_totals.then_some(TotalCount { exact_bits: TOTAL_BITS, bits: TOTAL_BITS, first_bit: 8 });
    let groups = Groups {
        detectors: detectors as usize,
        steps: steps as usize,
        last_steps: last_steps as usize,
        back_to_back: false,
    };
    let block = ResultStream::new(BITS, false, total, groups, false);
    let outputs = ["o_data", "o_valid", "o_last", "o_overrun"];
    Case::new(block, (&ports, &outputs), inputs, expected)
}
