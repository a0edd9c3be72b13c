//! Correlation against its definition, and codes against the theorems about
//! them.

use goldtof::code::{
    Code, CodeSpec, Family, GoldSet, correlate, correlate_naive, interleave, value_counts,
};
use proptest::prelude::*;

/// Degrees that have preferred pairs.
const GOLD_DEGREES: [u32; 13] = [3, 5, 6, 7, 9, 10, 11, 13, 14, 15, 17, 18, 19];

fn gold_spec(degree: u32, index: i64) -> CodeSpec {
    CodeSpec { degree: Some(degree), index: Some(index), ..CodeSpec::new(Family::Gold) }
}

fn gold_set(degree: u32) -> GoldSet {
    gold_spec(degree, 0).gold_set().unwrap()
}

fn m_sequence(degree: u32) -> Code {
    let spec = CodeSpec { degree: Some(degree), ..CodeSpec::new(Family::MSequence) };
    spec.build().unwrap()
}

/// Gold's three values, in ascending order, from the theorem's two cases.
fn gold_values(degree: u32) -> [i64; 3] {
    let t = if degree % 2 == 1 {
        2i64.pow(degree.div_ceil(2)) + 1
    } else {
        2i64.pow(degree / 2 + 1) + 1
    };
    [-t, -1, t - 2]
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn the_fast_correlation_equals_its_definition(
        pair in prop::collection::vec((0u8..2, 0u8..2), 1..300)
    ) {
        let (a, b): (Vec<u8>, Vec<u8>) = pair.into_iter().unzip();
        prop_assert_eq!(correlate(&a, &b), correlate_naive(&a, &b));
    }
}

#[test]
fn the_fast_correlation_equals_its_definition_for_long_codes() {
    let (a, b) = (gold_set(11).code(0).unwrap(), gold_set(11).code(77).unwrap());
    assert_eq!(correlate(&a.chips, &b.chips), correlate_naive(&a.chips, &b.chips));
}

#[test]
fn an_m_sequence_has_full_period_one_more_one_than_zero_and_a_flat_autocorrelation() {
    for degree in 3..=20 {
        let code = m_sequence(degree);
        let length = 2i64.pow(degree) - 1;
        assert_eq!(code.len() as i64, length, "degree {degree}");
        assert_eq!(code.weight() as i64, (length + 1) / 2, "degree {degree}");
        let theta = correlate(&code.chips, &code.chips);
        assert_eq!(theta[0], length, "degree {degree}");
        assert!(theta[1..].iter().all(|&value| value == -1), "degree {degree}");
    }
}

#[test]
fn eq_24_gives_the_interleaved_correlation_at_every_lag() {
    for degree in 5..=11 {
        // Where 4 divides the degree there is no Gold set: u and its reverse.
        let (a, b) = if degree % 4 == 0 {
            let u = m_sequence(degree).chips;
            let reversed = u.iter().rev().copied().collect();
            (u, reversed)
        } else {
            let set = gold_set(degree);
            (set.code(0).unwrap().chips, set.code(1).unwrap().chips)
        };
        let theta = correlate_naive(&a, &b);
        for nu in 0..=4 {
            let interleaved = correlate(&interleave(&a, nu), &interleave(&b, nu));
            assert_eq!(interleaved.len(), a.len() << nu);
            for (k, value) in interleaved.into_iter().enumerate() {
                let copies = 1usize << nu;
                let (xi, eta) = (k / copies, k % copies);
                let next = theta[(xi + 1) % theta.len()];
                let linear = (copies - eta) as i64 * theta[xi] + eta as i64 * next;
                // Depth 0 leaves the chips as they are: no alternating sign.
                let sign = if nu > 0 && k % 2 == 1 { -1 } else { 1 };
                assert_eq!(value, sign * linear, "degree {degree}, nu {nu}, lag {k}");
            }
        }
    }
}

#[test]
fn every_default_pair_has_golds_three_values() {
    for degree in GOLD_DEGREES {
        let set = gold_set(degree);
        let counts = value_counts(set.cross_correlation());
        let values: Vec<i64> = counts.keys().copied().collect();
        assert_eq!(values, gold_values(degree), "degree {degree}");
        // Parseval: the squares add up to L^2 + L - 1 for two m-sequences.
        let length = 2i64.pow(degree) - 1;
        let squares: i64 = counts.iter().map(|(v, &n)| v * v * n as i64).sum();
        assert_eq!(squares, length * length + length - 1, "degree {degree}");
    }
}

#[test]
fn all_correlations_of_small_gold_sets_take_golds_three_values() {
    for degree in [3, 5, 6, 7] {
        let set = gold_set(degree);
        let last = set.length() as i64 - 1;
        let codes: Vec<Code> = (-2..=last).map(|index| set.code(index).unwrap()).collect();
        assert_eq!(codes.len() as u64, set.members());
        let allowed = gold_values(degree);
        for (i, a) in codes.iter().enumerate() {
            for (j, b) in codes.iter().enumerate().skip(i) {
                let theta = correlate(&a.chips, &b.chips);
                let off_peak = if i == j { &theta[1..] } else { &theta[..] };
                assert!(
                    off_peak.iter().all(|value| allowed.contains(value)),
                    "degree {degree}, codes {i} and {j}"
                );
            }
        }
    }
}

#[test]
fn for_odd_degrees_one_more_than_half_of_a_gold_set_is_balanced() {
    for degree in GOLD_DEGREES.into_iter().filter(|degree| degree % 2 == 1) {
        assert_eq!(
            gold_set(degree).balanced_members(),
            2u64.pow(degree - 1) + 1,
            "degree {degree}"
        );
    }
}

#[test]
fn the_number_of_balanced_codes_is_that_of_the_codes_counted_one_by_one() {
    for degree in [3, 5, 6, 7, 9, 10] {
        let set = gold_set(degree);
        let last = set.length() as i64 - 1;
        let balanced = (-2..=last)
            .filter(|&index| set.code(index).unwrap().weight() == 2u64.pow(degree - 1))
            .count() as u64;
        assert_eq!(set.balanced_members(), balanced, "degree {degree}");
    }
}

#[test]
fn index_i_is_u_xor_v_advanced_by_i() {
    let set = gold_set(7);
    let (u, v) = (set.code(-2).unwrap().chips, set.code(-1).unwrap().chips);
    assert_eq!(u, set.u.chips(127));
    assert_eq!(v, set.v.chips(127));
    for index in [0usize, 1, 6, 7, 100, 126] {
        let expected: Vec<u8> = (0..127).map(|t| u[t] ^ v[(t + index) % 127]).collect();
        assert_eq!(set.code(index as i64).unwrap().chips, expected, "index {index}");
    }
}

#[test]
fn interleaved_codes_are_balanced_by_construction() {
    for nu in 1..=4 {
        let spec = CodeSpec { interleave: nu, ..gold_spec(6, 3) };
        let code = spec.build().unwrap();
        assert_eq!(2 * code.weight(), code.len(), "nu {nu}");
    }
}

#[test]
fn degrees_divisible_by_4_have_default_pairs_within_golds_bound_when_asked_for() {
    for degree in [4, 8, 12, 16, 20] {
        assert!(gold_spec(degree, 0).gold_set().is_err(), "degree {degree}");
        let spec = CodeSpec { allow_non_preferred: Some(true), ..gold_spec(degree, 0) };
        let counts = value_counts(spec.gold_set().unwrap().cross_correlation());
        let bound = 2i64.pow(degree / 2 + 1) + 1;
        assert!(counts.len() <= 4, "degree {degree}: {counts:?}");
        assert!(counts.keys().all(|v| v.abs() <= bound), "degree {degree}: {counts:?}");
    }
}
