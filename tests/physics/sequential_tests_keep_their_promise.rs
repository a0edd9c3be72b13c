//! The tests that draw until they have decided miss their fault as seldom as they say, and need few draws.

use optics_support::repeated;
use optics_support::sequential::{Scatter, Seldom};
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};

/// Of a thousand tests each: those that a fault passes, and the draws, on average, of those of what is
/// sound. `test` is asked for one of either kind, and gives whether it holds, and its draws.
fn missed(mut test: impl FnMut(&mut StdRng, bool) -> (bool, u64)) -> (usize, f64) {
    let mut rng = StdRng::seed_from_u64(1);
    let sound: Vec<(bool, u64)> = (0..1000).map(|_| test(&mut rng, false)).collect();
    assert!(sound.iter().all(|(holds, _)| *holds));
    let missed = (0..1000).filter(|_| test(&mut rng, true).0).count();
    (missed, sound.iter().map(|(_, draws)| *draws as f64).sum::<f64>() / 1000.0)
}

#[test]
fn what_happens_seldom_is_told_from_what_happens_more_often() {
    let (missed, draws) = missed(|rng, is_faulty| {
        let mut test = Seldom::new(0.01, 0.1, 0.05);
        let mut draws = 0;
        while test.is_open() {
            test.take(rng.random::<f64>() < if is_faulty { 0.1 } else { 0.01 });
            draws += 1;
        }
        (test.holds(), draws)
    });
    assert!(missed <= 70 && draws < repeated(60, 200) as f64, "{missed}, {draws}");
}

#[test]
fn errors_are_told_from_wider_narrower_and_biased_ones() {
    for [bias, std] in [[0.0, 1.3], [0.0, 1.0 / 1.3], [0.5, 1.0], [-0.5, 1.0]] {
        let (missed, draws) = missed(|rng, is_faulty| {
            let mut test = Scatter::new(1.3, 0.5, 0.05);
            let mut draws = 0;
            while test.is_open() {
                // Twelve uniform numbers, less six: nearly normal.
                let normal = (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
                test.take(if is_faulty { bias + std * normal } else { normal });
                draws += 1;
            }
            (test.holds(), draws)
        });
        assert!(
            missed <= 70 && draws < repeated(90, 280) as f64,
            "{bias} {std}: {missed}, {draws}"
        );
    }
}
