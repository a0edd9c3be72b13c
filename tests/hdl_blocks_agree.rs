//! Block by block: the rust-hdl simulation, Verilator on the emitted Verilog and
//! a description of what the block is for agree at every clock under random
//! inputs.

mod hdl_support;

use goldtof::hdl::blocks::{
    Accumulator, CodeSource, CountChoice, CountClamp, CountComparison, CountPiece, EdgeDetector,
    PeakDetector, Place, QuadCounter, ResultStream, StateMatch, StreamPlan, UpdownCorrelator,
};
use goldtof::hdl::front::Word;
use goldtof::model::contract::CountSegments;
use goldtof::model::peak::PeakPlan;
use hdl_support::block_bench::{Case, Ports, run_in_verilator};
use hdl_support::stimulus::Noise;
use hdl_support::{Family, code};

const CLOCKS: usize = 3000;

/// Bit `index` of a value.
fn bit(value: u128, index: usize) -> bool {
    value >> index & 1 == 1
}

/// A two's complement number of `bits` bits.
fn signed(value: u128, bits: u32) -> i128 {
    ((value << (128 - bits)) as i128) >> (128 - bits)
}

/// The lowest `bits` bits of a number.
fn wrapped(value: i128, bits: u32) -> u128 {
    value as u128 & (u128::MAX >> (128 - bits))
}

fn code_sources(noise: &mut Noise) -> Vec<Case> {
    let families = [
        (Family::Gold(6), 0),
        (Family::MSequence(5), 0),
        (Family::Square, 2),
        (Family::Chips(13), 1),
        (Family::Gold(5), 3),
    ];
    let mut cases = Vec::new();
    for (family, interleave) in families {
        let code = code(family, interleave, 9);
        let start = noise.below(code.len());
        let inputs = noise.words(CLOCKS, |noise| {
            vec![
                u128::from(noise.below(50) == 0),
                u128::from(noise.below(4) != 0),
            ]
        });
        let mut position = start;
        let expected = inputs.iter().enumerate().map(|(clock, input)| {
            let restarts = clock < Case::RESET_CLOCKS || input[0] == 1;
            position = match restarts {
                true => start,
                false => (position + input[1] as u64) % code.len(),
            };
            let chip = u128::from(code.chips[position as usize]);
            Some(vec![chip, u128::from(position == start)])
        });
        let expected = expected.collect();
        cases.push(Case::clocked(
            CodeSource::new(&code, start, true),
            Ports::new(
                &[("i_load", 1), ("i_advance", 1)],
                &[("o_chip", 1), ("o_epoch", 1)],
            ),
            inputs,
            expected,
            |block, clock, reset| {
                block.i_clk.next = clock;
                block.i_rst.next = reset;
            },
            |block, input| {
                block.i_load[0].next = input[0] == 1;
                block.i_advance.next = input[1] == 1;
            },
            |block| {
                vec![
                    u128::from(block.o_chip.val()),
                    u128::from(block.o_epoch.val()),
                ]
            },
        ));
    }
    cases
}

/// Clocks and resets a block that has the usual names for both.
macro_rules! clock_and_reset {
    () => {
        |block, clock, reset| {
            block.i_clk.next = clock;
            block.i_rst.next = reset;
        }
    };
}

/// A high sample after a low one is a hit of its pair; its place is that of the
/// pair's earlier sample if that is high.
fn edge_detector(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        vec![
            u128::from(noise.below(256)),
            u128::from(noise.below(8) != 0),
        ]
    });
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
        EdgeDetector::new(8),
        Ports::new(
            &[("i_samples", 8), ("i_run", 1)],
            &[("o_hits", 4), ("o_early", 4)],
        ),
        inputs,
        expected,
        clock_and_reset!(),
        |block, input| {
            block.i_samples.next = Word::new(input[0], 8);
            block.i_run.next = input[1] == 1;
        },
        |block| vec![block.o_hits.val().value(), block.o_early[0].val().value()],
    )
}

/// Hits less twice those that count down, two clocks later.
fn quad_counter(noise: &mut Noise) -> Case {
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
        clock_and_reset!(),
        |block, input| {
            block.i_hit.next = Word::new(input[0], 4);
            block.i_down.next = Word::new(input[1], 4);
        },
        |block| vec![block.o_sum.val().value()],
    )
}

/// What the addends between two dumps come to.
fn accumulator(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        vec![u128::from(noise.below(16)), u128::from(noise.below(6) == 0)]
    });
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
    let place = Place {
        has_lower: false,
        has_higher: false,
    };
    Case::clocked(
        Accumulator::new(9, 4, place),
        Ports::new(&[("i_addend", 4), ("i_dump", 1)], &[("o_count", 9)]),
        inputs,
        expected,
        clock_and_reset!(),
        |block, input| {
            block.i_addend.next = Word::new(input[0], 4);
            block.i_dump.next = input[1] == 1;
        },
        |block| vec![block.o_count.val().value()],
    )
}

/// Counts of phase steps of random lengths, with a total in three segments: a
/// word is in the total after four clocks.
fn updown_correlator(noise: &mut Noise) -> Case {
    const TO_TOTAL: usize = 4;
    let segments = CountSegments {
        count: 3,
        lower_bits: 4,
        top_bits: 3,
    };
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
        vec![
            hits,
            u128::from(noise.below(16)),
            u128::from(noise.below(256)),
            dump,
        ]
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
            &[
                ("i_hits", 4),
                ("i_early", 4),
                ("i_reference", 8),
                ("i_dump", 3),
            ],
            &[("o_count", 11)],
        ),
        inputs,
        expected,
        clock_and_reset!(),
        |block, input| {
            block.i_hits.next = Word::new(input[0], 4);
            block.i_early[0].next = Word::new(input[1], 4);
            block.i_reference.next = Word::new(input[2], 8);
            block.i_dump.next = Word::new(input[3], 3);
        },
        |block| vec![block.o_count.val().value()],
    )
}

fn count_clamp(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| vec![u128::from(noise.below(1 << 12))]);
    let expected = inputs.iter().map(|input| {
        let exact = signed(input[0], 12);
        let clamped = exact.clamp(-64, 63);
        Some(vec![wrapped(clamped, 7), u128::from(clamped != exact)])
    });
    let expected = expected.collect();
    Case::combinational(
        CountClamp::new(12, 7),
        Ports::new(&[("i_count", 12)], &[("o_count", 7), ("o_clamped", 1)]),
        inputs,
        expected,
        |block, input| block.i_count.next = Word::new(input[0], 12),
        |block| {
            vec![
                block.o_count.val().value(),
                u128::from(block.o_clamped.val()),
            ]
        },
    )
}

fn count_choice(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        let turn = match noise.below(4) {
            3 => 0,
            turn => 1 << turn,
        };
        let mut input = vec![turn];
        input.extend((0..3).map(|_| u128::from(noise.below(1 << 10))));
        input
    });
    let expected = inputs.iter().enumerate().map(|(clock, input)| {
        let turn = (0..3).find(|&turn| bit(input[0], turn));
        let turn = turn.filter(|_| clock >= Case::RESET_CLOCKS);
        Some(vec![turn.map_or(0, |turn| input[1 + turn])])
    });
    let expected = expected.collect();
    Case::clocked(
        CountChoice::new(10, 3),
        Ports::new(
            &[
                ("i_turn", 3),
                ("i_count_0", 10),
                ("i_count_1", 10),
                ("i_count_2", 10),
            ],
            &[("o_count", 10)],
        ),
        inputs,
        expected,
        clock_and_reset!(),
        |block, input| {
            block.i_turn.next = Word::new(input[0], 3);
            for count in 0..3 {
                block.i_count[count].next = Word::new(input[1 + count], 10);
            }
        },
        |block| vec![block.o_count.val().value()],
    )
}

fn count_piece(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        let draw = |noise: &mut Noise| u128::from(noise.below(8));
        vec![draw(noise), draw(noise), u128::from(noise.below(2))]
    });
    let expected = inputs.iter().enumerate().map(|(clock, input)| {
        let is_greater = input[0] > input[1] || (input[0] == input[1] && input[2] == 1);
        Some(vec![u128::from(is_greater && clock >= Case::RESET_CLOCKS)])
    });
    let expected = expected.collect();
    Case::clocked(
        CountPiece::new(3, true),
        Ports::new(
            &[("i_count", 3), ("i_other", 3), ("i_below", 1)],
            &[("o_greater", 1)],
        ),
        inputs,
        expected,
        clock_and_reset!(),
        |block, input| {
            block.i_count.next = Word::new(input[0], 3);
            block.i_other.next = Word::new(input[1], 3);
            block.i_below[0].next = input[2] == 1;
        },
        |block| vec![u128::from(block.o_greater.val())],
    )
}

fn peak_plan(count_bits: u32, pieces: u32, parallel: u32) -> PeakPlan {
    PeakPlan {
        step_bits: 5,
        count_bits,
        pieces,
        parallel,
        last_steps: parallel.div_ceil(2),
        choosing_clocks: if parallel > 1 { 2 } else { 0 },
        first_step: 17,
        wraps_after: Some(22),
        least_chips: 0,
        latency_clocks: 0,
    }
}

/// Both counts stand still for some clocks; the comparison is right from the
/// third on, because there are three pieces.
fn count_comparison(noise: &mut Noise) -> Case {
    const BITS: u32 = 11;
    let mut held = vec![0, 0];
    let mut age = 0;
    let mut ages = Vec::new();
    let inputs = noise.words(CLOCKS, |noise| {
        age += 1;
        if age > 3 && noise.below(3) == 0 {
            let count = noise.below(1 << BITS);
            let other = match noise.below(3) {
                0 => count ^ 1 << noise.below(u64::from(BITS)),
                1 => count,
                _ => noise.below(1 << BITS),
            };
            held = vec![u128::from(count), u128::from(other)];
            age = 1;
        }
        ages.push(age);
        held.clone()
    });
    let expected = inputs
        .iter()
        .zip(&ages)
        .enumerate()
        .map(|(clock, (input, &age))| {
            let is_greater = signed(input[0], BITS) > signed(input[1], BITS);
            (clock > 10 && age >= 3).then(|| vec![u128::from(is_greater)])
        });
    let expected = expected.collect();
    Case::clocked(
        CountComparison::new(&peak_plan(BITS, 3, 1)),
        Ports::new(&[("i_count", BITS), ("i_other", BITS)], &[("o_greater", 1)]),
        inputs,
        expected,
        clock_and_reset!(),
        |block, input| {
            block.i_count.next = Word::new(input[0], BITS);
            block.i_other.next = Word::new(input[1], BITS);
        },
        |block| vec![u128::from(block.o_greater.val())],
    )
}

fn state_match(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        let state = noise.below(1 << 20);
        let wanted = match noise.below(3) {
            0 => state,
            1 => state ^ 1 << noise.below(20),
            _ => noise.below(1 << 20),
        };
        vec![u128::from(state), u128::from(wanted)]
    });
    let expected = inputs.iter().enumerate().map(|(clock, input)| {
        let matched = input[0] == input[1] && clock >= Case::RESET_CLOCKS;
        Some(vec![u128::from(matched)])
    });
    let expected = expected.collect();
    Case::clocked(
        StateMatch::new(20),
        Ports::new(&[("i_state", 20), ("i_wanted", 20)], &[("o_matched", 1)]),
        inputs,
        expected,
        clock_and_reset!(),
        |block, input| {
            block.i_state.next = Word::new(input[0], 20);
            block.i_wanted.next = Word::new(input[1], 20);
        },
        |block| vec![u128::from(block.o_matched.val())],
    )
}

/// The largest of a scan's counts, groups of which come at random; the first of
/// equal ones, whose step follows from its place.
fn peak_detector(noise: &mut Noise, parallel: u32) -> Case {
    const BITS: u32 = 4;
    const GROUPS: usize = 3;
    let plan = peak_plan(BITS, 2, parallel);
    let (steps, last_steps) = (plan.parallel as usize, plan.last_steps as usize);
    let least = u64::from(plan.parallel * plan.clocks_per_count()) + 1;
    let mut counts = vec![0; steps];
    let (mut wait, mut group) = (10, 0);
    let mut scan: Vec<u128> = Vec::new();
    let mut peaks = Vec::new();
    let mut clock = 0;
    let inputs = noise.words(CLOCKS, |noise| {
        let comes = wait == 0;
        let last = group == GROUPS - 1;
        if comes {
            wait = least + noise.below(10);
            counts = (0..steps)
                .map(|_| u128::from(noise.below(1 << BITS)))
                .collect();
            scan.extend(&counts[..if last { last_steps } else { steps }]);
            group = (group + 1) % GROUPS;
            if last {
                let largest = scan.iter().map(|&count| signed(count, BITS)).max();
                let place = scan
                    .iter()
                    .position(|&count| Some(signed(count, BITS)) == largest);
                let place = place.expect("a scan has counts");
                // Steps 17 to 22, then from 0 on.
                let step = (17 + place as u128) % 23;
                peaks.push((
                    clock + plan.clocks_to_peak() as usize - 1,
                    step,
                    scan[place],
                ));
                scan.clear();
            }
        }
        wait -= 1;
        clock += 1;
        let mut input = vec![u128::from(comes), u128::from(last)];
        input.extend(&counts);
        input
    });
    let mut expected = vec![Some(vec![0, 0, 0]); CLOCKS];
    for &(clock, step, count) in &peaks {
        for (number, shown) in expected.iter_mut().enumerate().skip(clock) {
            *shown = Some(vec![step, count, u128::from(number == clock)]);
        }
    }
    assert!(peaks.len() > 20, "{} peaks", peaks.len());
    let names: Vec<String> = match steps {
        1 => vec!["i_count".to_owned()],
        _ => (0..steps).map(|step| format!("i_count_{step}")).collect(),
    };
    let mut ports = vec![("i_counted", 1), ("i_last", 1)];
    ports.extend(names.iter().map(|name| (name.as_str(), BITS)));
    Case::clocked(
        PeakDetector::new(&plan, 1),
        Ports::new(&ports, &[("o_step", 5), ("o_count", BITS), ("o_valid", 1)]),
        inputs,
        expected,
        clock_and_reset!(),
        move |block, input| {
            block.i_counted.next = input[0] == 1;
            block.i_last.next = input[1] == 1;
            for step in 0..steps {
                block.i_count[step].next = Word::new(input[2 + step], BITS);
            }
        },
        |block| {
            vec![
                block.o_step.val().value(),
                block.o_count.val().value(),
                u128::from(block.o_valid.val()),
            ]
        },
    )
}

/// A queue of results: a group is taken in whole when nothing else waits, one
/// result leaves per clock.
fn result_stream(noise: &mut Noise, detectors: u32, steps: u32, last_steps: u32) -> Case {
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
    let mut queue = std::collections::VecDeque::new();
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

#[test]
fn every_block_does_in_rust_hdl_and_in_verilator_what_it_is_for() {
    let noise = &mut Noise::new(31);
    let mut cases = code_sources(noise);
    cases.extend([
        edge_detector(noise),
        quad_counter(noise),
        accumulator(noise),
        updown_correlator(noise),
        count_clamp(noise),
        count_choice(noise),
        count_piece(noise),
        count_comparison(noise),
        state_match(noise),
        peak_detector(noise, 1),
        peak_detector(noise, 5),
        result_stream(noise, 1, 2, 1),
        result_stream(noise, 1, 5, 2),
        result_stream(noise, 3, 4, 3),
    ]);
    let verilog = run_in_verilator(&cases);
    for (case, verilog) in cases.iter().zip(&verilog) {
        case.agrees_with(verilog);
    }
}
