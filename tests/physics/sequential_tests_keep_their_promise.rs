//! The tests that draw until they have decided miss their fault as seldom as they say, and need few draws.

use optics_support::repeated;
use optics_support::sequential::{Scatter, Seldom};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

const TESTS: u64 = 1_000;

/// Of a thousand tests those that hold, and their draws on average. `test` gives whether it holds, and its draws.
fn holding(mut test: impl FnMut(&mut StdRng) -> (bool, u64)) -> (u64, f64) {
    let mut rng = StdRng::seed_from_u64(1);
    let all: Vec<(bool, u64)> = (0..TESTS).map(|_| test(&mut rng)).collect();
    let holding = all.iter().filter(|(holds, _)| *holds).count();
    let draws: u64 = all.iter().map(|(_, draws)| draws).sum();
    (holding as u64, draws as f64 / TESTS as f64)
}

#[test]
fn what_happens_seldom_is_told_from_what_happens_more_often() {
    let [(sound, draws), (missed, _)] = [0.01, 0.1].map(|share| {
        holding(|rng| {
            let mut test = Seldom::new(0.01, 0.1, 0.05);
            let mut draws = 0;
            while test.is_open() {
                test.take(rng.random::<f64>() < share);
                draws += 1;
            }
            (test.holds(), draws)
        })
    });
    assert!(sound == TESTS && missed <= 70, "{sound}, {missed}");
    assert!(draws < repeated(60, 200) as f64, "{draws}");
}

#[test]
fn errors_are_told_from_wider_narrower_and_biased_ones() {
    let of = |bias: f64, std: f64| {
        holding(|rng| {
            let mut test = Scatter::new(1.3, 0.5, 0.05);
            let mut draws = 0;
            while test.is_open() {
                // Twelve uniform numbers, less six: nearly normal.
                let normal = (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
                test.take(bias + std * normal);
                draws += 1;
            }
            (test.holds(), draws)
        })
    };
    let (sound, draws) = of(0.0, 1.0);
    assert!(sound == TESTS && draws < repeated(90, 280) as f64, "{sound}, {draws}");
    for [bias, std] in [[0.0, 1.3], [0.0, 1.0 / 1.3], [0.5, 1.0], [-0.5, 1.0]] {
        let (missed, _) = of(bias, std);
        assert!(missed <= 70, "{bias} {std}: {missed}");
    }
}
