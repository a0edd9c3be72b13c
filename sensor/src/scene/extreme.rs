//! Scenes at the ends of every range, for the tests of several packages: what must end or be
//! refused.

use std::path::Path;

use super::{Scene, load_with};

/// A number between two, evenly by its logarithm, from the digits of the golden ratio.
fn between(number: &mut u64, [least, most]: [f64; 2]) -> f64 {
    *number = number.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(23).wrapping_add(1);
    let share = (*number >> 11) as f64 / 2_f64.powi(53);
    least * (most / least).powf(share)
}

/// Those of some scenes that are sound, each with its settings.
/// # Panics
/// Without the standard scenes of the source tree.
pub fn scenes(number: usize) -> impl Iterator<Item = (Vec<String>, Scene)> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
    let mut digits = 20_261_124;
    (0..number).filter_map(move |scene| {
        let mut log = |range| between(&mut digits, range);
        let mut settings = vec![
            format!("clock.chip_period={} ns", log([0.5, 1000.0])),
            format!("clock.samples_per_chip={}", [1, 2, 8][scene % 3]),
            format!("source.mean_power={} pW", log([1e-3, 1e4])),
            format!("source.extinction_ratio={}", log([1.001, 1e6])),
            format!("detector.dead_time={} ns", log([0.03, 1e3])),
            format!("detector.dark_count_rate={} cps", log([1.0, 1e8])),
            format!(
                "detector.afterpulsing={{ probability = {}, time_constant = \"{} ns\" }}",
                1.0 - log([1e-3, 1.0]),
                log([0.1, 1e4])
            ),
            format!("detector.jitter=[\"{} ns\"]", log([1e-3, 30.0])),
            format!("path.distance={} m", log([1e-3, 1e8])),
            format!("scan.integration={} us", log([10.0, 1e6])),
        ];
        if scene % 4 == 0 {
            let tail = format!("share = 0.3, time_constant = \"{} ns\"", log([1e-3, 1e4]));
            settings.push(format!("detector.jitter_tail={{ {tail} }}"));
        }
        let parsed: Vec<_> = settings.iter().map(|s| s.parse().expect("a setting")).collect();
        Some((settings, load_with(&file, &parsed).ok()?))
    })
}
