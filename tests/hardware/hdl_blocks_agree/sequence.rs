//! What happens when: codes, scans, and a channel that follows both.

use goldtof::code::Generator;
use goldtof::rtl::blocks::{CodeSource, DetectorChannel, ScanController, StateMatch};
use goldtof::scene::SourceIndex;
use goldtof::sensor::interface::Interface;
use goldtof::sensor::registers::Seed;

use super::{CLOCKS, bit, wrapped};
use crate::hdl_support::block_testbench::Case;
use crate::hdl_support::stimulus::Noise;
use crate::hdl_support::{Family, code, interleaved, recurrence, scene};

pub fn code_sources(noise: &mut Noise) -> Vec<Case> {
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
            vec![u128::from(noise.below(50) == 0), u128::from(noise.below(4) != 0)]
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
        cases.push(Case::new(
            CodeSource::new(&code, start, true),
            (&["i_load", "i_advance"], &["o_chip", "o_epoch"]),
            inputs,
            expected,
        ));
    }
    cases
}

/// Generators whose last LFSR has seed and taps from outside: an exponent e of its polynomial is bit n - e of the taps. It
/// begins anew with each period, whatever its own.
pub fn set_code_sources(noise: &mut Noise) -> Vec<Case> {
    const DEGREE: u32 = 5;
    const CHIPS: usize = 31;
    let mut cases = Vec::new();
    for (family, interleave) in [
        (Family::Gold(DEGREE), 0),
        (Family::Gold(DEGREE), 2),
        (Family::MSequence(DEGREE), 0),
        (Family::MSequence(DEGREE), 1),
    ] {
        let code = code(family, interleave, 9);
        let seed = Seed { source: SourceIndex(0), degree: DEGREE, bits: 2 * DEGREE };
        let mut setting = 0;
        let inputs: Vec<Vec<u128>> = (0..CLOCKS)
            .map(|clock| {
                let restarts = clock <= Case::RESET_CLOCKS || noise.below(400) == 0;
                if restarts {
                    setting = noise.below(1 << (2 * DEGREE)) | 1 << DEGREE;
                }
                let advances = noise.below(8) != 0;
                vec![u128::from(restarts), u128::from(advances), u128::from(setting)]
            })
            .collect();
        let (mut position, mut chips) = (0, code.chips.clone());
        let expected = inputs.iter().enumerate().map(|(clock, input)| {
            if clock < Case::RESET_CLOCKS {
                position = 0;
            } else if input[0] == 1 {
                position = 0;
                let bit = |place: u32| (input[2] >> place & 1) as u8;
                let first: Vec<u8> = (0..DEGREE).map(bit).collect();
                let taps = (0..DEGREE).filter(|&place| bit(DEGREE + place) == 1);
                let exponents: Vec<u32> = taps.map(|place| DEGREE - place).chain([0]).collect();
                let mut last = recurrence(&exponents, &first, CHIPS);
                if let Generator::Gold { u, .. } = &code.generator {
                    let u = recurrence(&u.exponents, &u.seed, CHIPS);
                    last.iter_mut().zip(u).for_each(|(chip, u)| *chip ^= u);
                }
                chips = interleaved(&last, interleave);
            } else {
                position = (position + input[1] as usize) % chips.len();
            }
            Some(vec![u128::from(chips[position]), u128::from(position == 0)])
        });
        let expected = expected.collect();
        cases.push(Case::new(
            CodeSource::seeded(&code, Some(seed)),
            (&["i_load", "i_advance", "i_seed"], &["o_chip", "o_epoch"]),
            inputs,
            expected,
        ));
    }
    cases
}

pub fn state_match(noise: &mut Noise) -> Case {
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
    Case::new(StateMatch::new(20), (&["i_state", "i_wanted"], &["o_matched"]), inputs, expected)
}

/// Steps of five chips, three to a scan, which begins with a code period; their
/// ends on their way to the totals and counts.
pub fn scan_controller(noise: &mut Noise) -> Case {
    const CHIPS: u64 = 5;
    const STEPS: u64 = 3;
    let inputs = noise.words(CLOCKS, |noise| vec![u128::from(noise.below(7) == 0)]);
    // Chip of the present scan, from which step and chip of the step follow.
    let mut present: Option<u64> = None;
    let is_step_end = |chip: Option<u64>| chip.is_some_and(|chip| chip % CHIPS == CHIPS - 1);
    let is_scan_end = |chip: Option<u64>| chip == Some(CHIPS * STEPS - 1);
    let mut history = Vec::new();
    let mut expected = Vec::new();
    for (clock, input) in inputs.iter().enumerate() {
        let epoch = input[0] == 1;
        let starts = |present: Option<u64>| epoch && (present.is_none() || is_scan_end(present));
        if clock >= Case::RESET_CLOCKS {
            present = match present {
                _ if starts(present) => Some(0),
                Some(chip) if chip + 1 < CHIPS * STEPS => Some(chip + 1),
                _ => None,
            };
        }
        history.push(present);
        let before = |clocks: usize| clock.checked_sub(clocks).and_then(|clock| history[clock]);
        let dump = (0..2).fold(0, |dump, segment| {
            dump | u128::from(is_step_end(before(4 + segment))) << segment
        });
        let step_ends = present.is_some_and(|chip| chip % CHIPS == CHIPS - 2);
        expected.push(Some(vec![
            u128::from(present.is_some()),
            u128::from(step_ends),
            u128::from(is_step_end(present)),
            u128::from(starts(present)),
            dump,
            u128::from(is_step_end(before(6))),
            u128::from(is_step_end(before(7))),
            u128::from(is_scan_end(before(7))),
        ]));
    }
    let outputs = [
        "o_run",
        "o_pre_last_chip",
        "o_last_chip",
        "o_start",
        "o_dump",
        "o_pre_counted",
        "o_counted",
        "o_scan_counted",
    ];
    // It realigns; four clocks to the dump of two segments, three more to the count.
    let block = ScanController::new(CHIPS, STEPS, true, 4, 2, 3, true);
    Case::new(block, (&["i_epoch"], &outputs), inputs, expected)
}

/// Six steps at once in two banks: hits with the sign of the reference, delayed
/// by 9 samples and more (eq. 11).
pub fn detector_channel(noise: &mut Noise) -> Case {
    const CHIPS: usize = 30;
    let code = code(Family::Gold(5), 1, 3);
    let mut scene = scene(std::slice::from_ref(&code), 0, 4, 9, Some(6), CHIPS as u64, None);
    scene.hardware.parallel = 6;
    let interface = Interface::of(&scene);
    let correlator = *interface.correlator().expect("it counts up and down");
    assert_eq!(correlator.banks, 2);
    let to_dump = interface.result_latency_clocks - 2;
    let mut starts = vec![10];
    while starts[starts.len() - 1] < CLOCKS {
        let pause = 12 + noise.below(20) as usize;
        starts.push(starts[starts.len() - 1] + CHIPS + pause);
    }
    let mut clock = 0;
    let inputs = noise.words(CLOCKS, |noise| {
        let since = |start: &usize| clock as i64 - *start as i64;
        let ends = CHIPS as i64;
        let is_at = |at: i64| u128::from(starts.iter().any(|start| since(start) == at));
        let runs = starts.iter().any(|start| (1..=ends).contains(&since(start)));
        let input = vec![
            u128::from(noise.below(16)),
            u128::from(runs),
            is_at(ends - 1),
            is_at(ends),
            is_at(0),
            is_at(ends + i64::from(to_dump)),
        ];
        clock += 1;
        input
    });
    let sample = |at: i64| bit(inputs[(at / 4) as usize][0], (at % 4) as usize);
    let mut expected = vec![None; CLOCKS];
    for pair in starts.windows(2) {
        // Sample 0 of the scan.
        let first = 4 * (pair[0] as i64 + 1);
        let complete = pair[0] + CHIPS + to_dump as usize + 1;
        if complete >= CLOCKS {
            break;
        }
        let counts = (9..15).map(|delay| {
            let hits =
                (0..4 * CHIPS as i64).filter(|i| sample(first + i) && !sample(first + i - 1));
            let signs = hits.map(|i| {
                let chip = (i - delay).div_euclid(4).rem_euclid(code.len() as i64);
                if code.chips[chip as usize] == 1 { 1 } else { -1 }
            });
            wrapped(signs.sum(), interface.count_bits())
        });
        let counts: Vec<u128> = counts.collect();
        let changes = pair[1] + CHIPS + to_dump as usize;
        for shown in expected.iter_mut().take(changes).skip(complete) {
            *shown = Some(counts.clone());
        }
    }
    let ports = ["i_samples", "i_run", "i_pre_last_chip", "i_last_chip", "i_start", "i_dump"];
    let block = DetectorChannel::new(interface, correlator, code);
    Case::new(block, (&ports, &["o_count"]), inputs, expected)
}
