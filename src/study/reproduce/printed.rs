//! Eqs. 15 to 17 as the article prints them: for comparison only.

use std::f64::consts::PI;

use goldtof_fft::num_complex::Complex64;

use crate::estimate::distance_m;
use crate::scan::Step;
use crate::scene::Scene;

/// Distance, in metres and not calibrated, by eqs. 16 and 17 as printed: 2 S + 1
/// samples, half the fundamental, the absolute phase step in the exponent (T_s
/// there in units of itself), and a fine part of phi T_s / (2 pi).
///
/// The fine part is at most half a phase step whatever the counts are, so that
/// what is returned is the coarse grid. `None` for a peak at the scan's rim.
pub fn printed_distance_m(scene: &Scene, counts: &[i64]) -> Option<f64> {
    let samples = scene.samples_per_chip as usize;
    let step_ps = scene.clock().sample_period_ps();
    // The first of equals, as `estimate` has it.
    let peak = (0..counts.len()).rev().max_by_key(|&i| counts[i])?;
    let window = peak.checked_sub(samples)?..peak + samples + 1;
    let fundamental: Complex64 = counts
        .get(window.clone())?
        .iter()
        .zip(window)
        .map(|(&count, index)| {
            let k = scene.scan.phase_step(Step::at(index)) as f64;
            Complex64::from_polar(count as f64, -PI * k / (2 * samples) as f64)
        })
        .sum();
    let fine_ps = fundamental.arg() / (2.0 * PI) * step_ps;
    Some(distance_m(scene.scan.phase_step(Step::at(peak)) as f64 * step_ps + fine_ps))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::reproduce::sensor::{Light, gold, sensor};

    #[test]
    fn a_triangle_at_a_step_returns_that_step_and_its_own_number_as_phase() {
        let code = gold(0, 0).expect("a Gold code");
        let scene = sensor(&[Light::new(&code, 1.0)], 1e-4);
        for k0 in [10_i64, 20, 37] {
            let counts: Vec<i64> =
                (0..scene.scan.steps as i64).map(|k| 100 * (8 - (k - k0).abs()).max(0)).collect();
            // A real, even window turned by -pi k0 / 16: nothing but k0 in it.
            let turns = -(k0 as f64) / 32.0;
            let expected_ps = 1000.0 * (k0 as f64 + turns - turns.round());
            let found = printed_distance_m(&scene, &counts).expect("a peak inside");
            assert!((found - distance_m(expected_ps)).abs() < 1e-9, "{k0}");
        }
    }
}
