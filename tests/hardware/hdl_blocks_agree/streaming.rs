//! Results on their way out.

use std::collections::VecDeque;

use goldtof::hdl::blocks::{ResultStream, StreamPlan};
use goldtof::hdl::front::Word;

use super::{CLOCKS, signed, wrapped};
use crate::hdl_support::block_bench::{Case, Ports};
use crate::hdl_support::stimulus::Noise;

/// A queue of results: a group is taken in whole when nothing else waits, one
/// result leaves per clock.
pub fn result_stream(noise: &mut Noise, detectors: u32, steps: u32, last_steps: u32) -> Case {
    const BITS: u32 = 6;
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
                            let is_last = detector + 1 == detectors && step + 1 == sent;
                            queue.push_back((count, is_last && input[1] == 1));
                        }
                    }
                }
            }
            if !valid && let Some(next) = queue.pop_front() {
                shown = next;
                valid = true;
            }
            let data = wrapped(signed(shown.0, BITS), 8);
            Some(vec![
                data,
                u128::from(valid),
                u128::from(shown.1),
                u128::from(overrun),
            ])
        })
        .collect();
    // The block is told of counts a clock before they come.
    let mut inputs = inputs;
    for (clock, input) in inputs.iter_mut().enumerate() {
        let early = arrivals.get(clock + 1).is_some_and(|&comes| comes);
        input.insert(0, u128::from(early));
    }
    expected.truncate(CLOCKS);
    let names: Vec<String> = (0..counts)
        .map(|count| format!("i_count_{count}"))
        .collect();
    let mut ports = vec![
        ("i_counts", 1),
        ("i_counted", 1),
        ("i_last", 1),
        ("i_ready", 1),
    ];
    ports.extend(names.iter().map(|name| (name.as_str(), BITS)));
    let plan = StreamPlan {
        count_bits: BITS,
        saturates: false,
        total: None,
        data_bits: 8,
        detectors,
        steps,
        last_steps,
        back_to_back: false,
    };
    Case::clocked(
        ResultStream::new(plan),
        Ports::new(
            &ports,
            &[
                ("o_data", 8),
                ("o_valid", 1),
                ("o_last", 1),
                ("o_overrun", 1),
            ],
        ),
        inputs,
        expected,
        clock_and_reset!(),
        move |block, input| {
            block.i_counts[0].next = input[0] == 1;
            block.i_counted.next = input[1] == 1;
            block.i_last.next = input[2] == 1;
            block.i_ready.next = input[3] == 1;
            for count in 0..counts {
                block.i_count[count].next = Word::new(input[4 + count], BITS);
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
