//! The peak among counts.

use goldtof::rtl::blocks::{CountChoice, CountComparison, CountPiece, PeakDetector};
use goldtof::sensor::peak::PeakPlan;

use super::{CLOCKS, bit, signed};
use crate::hdl_support::block_testbench::Case;
use crate::hdl_support::stimulus::Noise;

pub fn count_choice(noise: &mut Noise) -> Case {
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
    Case::new(CountChoice::new(10, 3), (&["i_turn", "i_count"], &["o_count"]), inputs, expected)
}

pub fn count_piece(noise: &mut Noise) -> Case {
    let inputs = noise.words(CLOCKS, |noise| {
        let draw = |noise: &mut Noise| u128::from(noise.below(8));
        vec![draw(noise), draw(noise), u128::from(noise.below(2))]
    });
    let expected = inputs.iter().enumerate().map(|(clock, input)| {
        let is_greater = input[0] > input[1] || (input[0] == input[1] && input[2] == 1);
        Some(vec![u128::from(is_greater && clock >= Case::RESET_CLOCKS)])
    });
    let expected = expected.collect();
    Case::new(
        CountPiece::new(3),
        (&["i_count", "i_other", "i_below"], &["o_greater"]),
        inputs,
        expected,
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
pub fn count_comparison(noise: &mut Noise) -> Case {
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
    let expected = inputs.iter().zip(&ages).enumerate().map(|(clock, (input, &age))| {
        let is_greater = signed(input[0], BITS) > signed(input[1], BITS);
        (clock > 10 && age >= 3).then(|| vec![u128::from(is_greater)])
    });
    let expected = expected.collect();
    Case::new(
        CountComparison::new(peak_plan(BITS, 3, 1)),
        (&["i_count", "i_other"], &["o_greater"]),
        inputs,
        expected,
    )
}

/// The largest of a scan's counts, groups of which come at random; the first of
/// equal ones, whose step follows from its place.
pub fn peak_detector(noise: &mut Noise, parallel: u32) -> Case {
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
            counts = (0..steps).map(|_| u128::from(noise.below(1 << BITS))).collect();
            scan.extend(&counts[..if last { last_steps } else { steps }]);
            group = (group + 1) % GROUPS;
            if last {
                let largest = scan.iter().map(|&count| signed(count, BITS)).max();
                let place = scan.iter().position(|&count| Some(signed(count, BITS)) == largest);
                let place = place.expect("a scan has counts");
                // Steps 17 to 22, then from 0 on.
                let step = (17 + place as u128) % 23;
                peaks.push((clock + plan.clocks_to_peak() as usize - 1, step, scan[place]));
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
    Case::new(
        PeakDetector::new(plan, 1),
        (&["i_counted", "i_last", "i_count"], &["o_step", "o_count", "o_valid"]),
        inputs,
        expected,
    )
}
