//! Coarse peak and fine phase (eqs. 15 to 17, in their working form).

use std::f64::consts::PI;

use goldtof_fft::num_complex::Complex64;
use serde::{Deserialize, Serialize};

use super::distance_m;
use super::unwrap::fold_distance;
use crate::scan::{Step, Timing};

/// A measured time of flight.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// Time of flight, folded into 0 .. code period.
    pub delay_ps: f64,
    /// Half the optical path.
    pub distance_m: f64,
    /// The phase step k of the largest count.
    pub coarse_step: u64,
    /// Why the estimate is only coarse; `None` for a fine one.
    pub coarse_only: Option<CoarseOnly>,
}

impl Estimate {
    /// Whether the phase has refined the coarse step.
    pub fn is_fine(&self) -> bool {
        self.coarse_only.is_none()
    }
}

/// Why an estimate is only as fine as a phase step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error, Serialize, Deserialize)]
pub enum CoarseOnly {
    /// S = 1: two samples on the triangle's base give no phase.
    #[error(
        "with one sample per chip the triangle has two samples, which give no phase: \
         use samples_per_chip = 2 or more"
    )]
    OneSamplePerChip,
    /// The peak is too near the rim of the scan.
    #[error(
        "the peak at step {peak} of the scan is too near its rim: the phase needs {before} steps \
         before it and {after} after it, the scan has {steps}"
    )]
    PeakAtRim {
        /// Number of the peak's step in the scan.
        peak: u64,
        /// Steps needed before it, S.
        before: u64,
        /// Steps needed after it, S - 1.
        after: u64,
        /// Steps of the scan.
        steps: u64,
    },
    /// A code of a single chip: the window is longer than the code period.
    #[error("the code period has fewer than {needed} phase steps")]
    PeriodTooShort {
        /// Steps of the window, 2 S.
        needed: u64,
    },
    /// The fundamental vanishes in the window.
    #[error("the counts round the peak have no fundamental")]
    NoFundamental,
}

/// Why there is not even a coarse estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum NoEstimate {
    /// Nothing that reaches the detector has its reference's code.
    #[error(
        "no light that its source modulates reaches the detector, so the largest count would be \
         chance"
    )]
    NotModulated,
    /// Hardly anything was detected, and none of it counted up.
    #[error(
        "no phase step counted above zero, and {zeros} of {steps} counted exactly that: the \
         correlation has no peak"
    )]
    NothingCountedUp {
        /// Steps that counted zero.
        zeros: usize,
        /// Steps of the scan.
        steps: usize,
    },
    /// All counts are equal (all zero, if nothing was detected).
    #[error("every phase step counted {count}: the correlation has no peak")]
    Flat {
        /// The count of every step.
        count: i64,
    },
}

/// Estimates the time of flight (eqs. 15 to 17 in their working form).
///
/// Coarse: the largest count over the scan, the first of equals. Fine: with the
/// window i = -S..S-1 round it, which is one base of the triangle,
/// phi = arg(sum of r\[k + i\] exp(-j pi i / S)) and t = k T_s - phi / pi T_c.
/// `calibration_offset_ps` is subtracted from t.
///
/// # Panics
/// If there are not `scan.steps` counts.
pub fn estimate(
    timing: &Timing,
    counts: &[i64],
    calibration_offset_ps: f64,
) -> Result<Estimate, NoEstimate> {
    if let Some(&first) = counts.first()
        && counts.iter().all(|&count| count == first)
    {
        return Err(NoEstimate::Flat { count: first });
    }
    // With so little light the first of many zeros is not a peak.
    let zeros = counts.iter().filter(|&&count| count == 0).count();
    if counts.iter().all(|&count| count <= 0) && 2 * zeros > counts.len() {
        return Err(NoEstimate::NothingCountedUp { zeros, steps: counts.len() });
    }
    // What all steps have in common cancels in the phase, exactly in whole numbers
    // but not in floating point.
    let least = counts.iter().copied().min().unwrap_or(0);
    let values: Vec<f64> = counts.iter().map(|&count| count.abs_diff(least) as f64).collect();
    let peak = first_maximum(&values);
    Ok(estimate_at(&values, peak, timing, calibration_offset_ps))
}

/// [`estimate`] for counts that need not be whole, such as those of light that was
/// corrected for dead time.
///
/// # Errors
/// If there is no peak; values that differ only by rounding are equal.
///
/// # Panics
/// If there are not `scan.steps` values.
pub fn estimate_values(
    timing: &Timing,
    values: &[f64],
    calibration_offset_ps: f64,
) -> Result<Estimate, NoEstimate> {
    let peak = first_maximum(values);
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.get(peak).copied().unwrap_or(0.0);
    if largest - least <= 1e-9 * largest.abs().max(least.abs()) {
        let count = largest.round() as i64;
        return Err(NoEstimate::Flat { count });
    }
    let values: Vec<f64> = values.iter().map(|value| value - least).collect();
    Ok(estimate_at(&values, peak, timing, calibration_offset_ps))
}

/// The same for values that need not be whole, such as expected counts, with the
/// coarse stage's answer given: timing number `peak`. Its sum of coarse and fine
/// is eq. 17.
pub(super) fn estimate_at(
    values: &[f64],
    peak: usize,
    timing: &Timing,
    calibration_offset_ps: f64,
) -> Estimate {
    let scan = &timing.scan;
    assert_eq!(values.len() as u64, scan.steps, "one count per phase step");
    let coarse_step = scan.phase_step(Step::at(peak));

    let chip_ps = timing.clock.chip_period_ps;
    let step_ps = timing.clock.sample_period_ps();
    let coarse_ps = coarse_step as f64 * step_ps;
    let (fine_ps, coarse_only) = match fundamental(values, peak, timing) {
        Ok(fundamental) => (-fundamental.arg() / PI * chip_ps, None),
        Err(reason) => (0.0, Some(reason)),
    };
    let code_period_ps = timing.code_period_ps();
    let delay_ps = fold_distance(coarse_ps + fine_ps - calibration_offset_ps, code_period_ps);
    Estimate { delay_ps, distance_m: distance_m(delay_ps), coarse_step, coarse_only }
}

/// Index of the largest value, the first of equals (eq. 15).
pub(super) fn first_maximum(values: &[f64]) -> usize {
    let mut peak = 0;
    for (index, &value) in values.iter().enumerate() {
        if value > values[peak] {
            peak = index;
        }
    }
    peak
}

/// Sum of values\[peak + i\] exp(-j pi i / S) over i = -S..S-1 (eq. 16 over one base
/// of the triangle).
pub(super) fn fundamental(
    values: &[f64],
    peak: usize,
    timing: &Timing,
) -> Result<Complex64, CoarseOnly> {
    let window = window_indices(peak, timing)?;
    let samples_per_chip = f64::from(timing.clock.samples_per_chip);
    let mut sum = Complex64::ZERO;
    let mut magnitude = 0.0;
    for (offset, index) in window {
        let value = values[index];
        sum += Complex64::from_polar(value, -PI * offset as f64 / samples_per_chip);
        magnitude += value.abs();
    }
    // Equal counts leave rounding errors only.
    if sum.norm() <= 1e-12 * magnitude {
        return Err(CoarseOnly::NoFundamental);
    }
    Ok(sum)
}

/// Whether a scan is one window: the phase of a period of two chips is the same wherever the largest count is.
pub(super) fn is_one_window(timing: &Timing) -> bool {
    let half = u64::from(timing.clock.samples_per_chip);
    half > 1 && timing.scan.is_full() && timing.scan.steps == 2 * half
}

/// Offsets -S..S-1 from the peak, with their indices in the scan.
pub(super) fn window_indices(
    peak: usize,
    timing: &Timing,
) -> Result<impl Iterator<Item = (i64, usize)> + use<>, CoarseOnly> {
    let half = i64::from(timing.clock.samples_per_chip);
    let steps = timing.scan.steps as i64;
    let peak = peak as i64;
    if half == 1 {
        return Err(CoarseOnly::OneSamplePerChip);
    }
    if timing.scan.is_full() {
        if steps < 2 * half {
            return Err(CoarseOnly::PeriodTooShort { needed: 2 * half as u64 });
        }
    } else if peak < half || peak + half > steps {
        return Err(CoarseOnly::PeakAtRim {
            peak: peak as u64,
            before: half as u64,
            after: half as u64 - 1,
            steps: steps as u64,
        });
    }
    Ok((-half..half).map(move |offset| (offset, (peak + offset).rem_euclid(steps) as usize)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::{Clock, Scan};

    const CHIP_PS: f64 = 8000.0;

    fn scan(first_step: u64, steps: u64, steps_per_period: u64) -> Scan {
        Scan {
            first_step,
            steps,
            steps_per_period,
            integration_chips: 1,
            requested_integration_ps: CHIP_PS,
        }
    }

    /// Triangle of base 2 T_c round `delay_ps`, scaled to whole counts.
    fn triangle(delay_ps: f64, scan: &Scan, samples_per_chip: u32) -> Vec<i64> {
        let step_ps = CHIP_PS / f64::from(samples_per_chip);
        let period_ps = scan.steps_per_period as f64 * step_ps;
        Step::all(scan.steps)
            .map(|step| {
                let lag = scan.phase_step(step) as f64 * step_ps - delay_ps;
                let lag = (lag - (lag / period_ps).round() * period_ps).abs();
                (1e9 * (1.0 - lag / CHIP_PS).max(0.0)).round() as i64
            })
            .collect()
    }

    fn run(counts: &[i64], scan: Scan, samples_per_chip: u32, offset_ps: f64) -> Estimate {
        let timing = timing(scan, samples_per_chip);
        estimate(&timing, counts, offset_ps).expect("there is a peak")
    }

    fn timing(scan: Scan, samples_per_chip: u32) -> Timing {
        Timing {
            clock: Clock { chip_period_ps: CHIP_PS, samples_per_chip },
            scan,
            parallel: 1,
            preparation_chips: 0,
        }
    }

    #[test]
    fn values_that_are_not_whole_say_what_their_multiples_do() {
        let scan = scan(0, 56, 56);
        let timing = timing(scan, 8);
        for tenth in 0..10 {
            let counts = triangle(20_000.0 + f64::from(tenth) * 100.0, &scan, 8);
            let shares: Vec<f64> = counts.iter().map(|&c| c as f64 / 1e9 - 0.3).collect();
            let whole = estimate(&timing, &counts, 250.0).expect("there is a peak");
            let found = estimate_values(&timing, &shares, 250.0).expect("there is a peak");
            assert!((found.delay_ps - whole.delay_ps).abs() < 1e-6);
            assert_eq!(found.coarse_step, whole.coarse_step);
        }
        let flat = [0.1 + 0.2; 56];
        assert_eq!(estimate_values(&timing, &flat, 0.0), Err(NoEstimate::Flat { count: 0 }));
    }

    #[test]
    fn a_triangle_on_the_grid_is_found_exactly_all_round_the_period() {
        let scan = scan(0, 56, 56);
        for k in 0..56 {
            let delay_ps = f64::from(k) * 1000.0;
            let found = run(&triangle(delay_ps, &scan, 8), scan, 8, 0.0);
            let error = super::super::delay_error_ps(found.delay_ps, delay_ps, 56_000.0);
            assert!(error.abs() < 1e-3, "{k}: {error}");
            assert!(found.is_fine());
            assert_eq!(found.coarse_step, k as u64);
        }
    }

    #[test]
    fn between_steps_only_the_circular_error_of_about_a_millimetre_is_left() {
        let scan = scan(0, 56, 56);
        for tenth in 0..100 {
            let delay_ps = 20_000.0 + f64::from(tenth) * 10.0;
            let found = run(&triangle(delay_ps, &scan, 8), scan, 8, 0.0);
            let error_m = found.distance_m - distance_m(delay_ps);
            assert!(error_m.abs() < 1.5e-3, "{delay_ps}: {error_m}");
        }
    }

    #[test]
    fn the_offset_is_subtracted_and_the_delay_folded() {
        let scan = scan(0, 56, 56);
        let found = run(&triangle(1000.0, &scan, 8), scan, 8, 1750.0);
        assert!((found.delay_ps - (56_000.0 - 750.0)).abs() < 1e-3);
    }

    #[test]
    fn a_window_scan_may_wrap_round_the_period() {
        let scan = scan(40, 32, 56);
        let found = run(&triangle(0.0, &scan, 8), scan, 8, 0.0);
        assert_eq!(found.coarse_step, 0);
        assert!(found.is_fine());
        assert!(super::super::delay_error_ps(found.delay_ps, 0.0, 56_000.0).abs() < 1e-3);
    }

    #[test]
    fn a_peak_at_the_rim_of_a_window_scan_gives_a_coarse_estimate() {
        for (first_step, fits) in [(12, true), (13, false), (5, true), (4, false)] {
            let scan = scan(first_step, 23, 56);
            let found = run(&triangle(20_000.0, &scan, 8), scan, 8, 0.0);
            assert_eq!(found.is_fine(), fits, "first step {first_step}");
            assert_eq!(found.coarse_step, 20);
            if !fits {
                assert_eq!(found.delay_ps, 20_000.0);
                assert_eq!(
                    found.coarse_only,
                    Some(CoarseOnly::PeakAtRim {
                        peak: 20 - first_step,
                        before: 8,
                        after: 7,
                        steps: 23
                    })
                );
            }
        }
    }

    #[test]
    fn one_sample_per_chip_gives_a_coarse_estimate() {
        let scan = scan(0, 7, 7);
        let found = run(&triangle(24_000.0, &scan, 1), scan, 1, 0.0);
        assert_eq!(found.coarse_only, Some(CoarseOnly::OneSamplePerChip));
        assert_eq!(found.delay_ps, 24_000.0);
    }

    #[test]
    fn equal_counts_give_no_estimate_and_equal_peaks_the_first() {
        let timing = timing(scan(0, 14, 14), 2);
        for count in [0, -7] {
            let counts = [count; 14];
            assert_eq!(estimate(&timing, &counts, 0.0), Err(NoEstimate::Flat { count }));
        }
        let mut counts = [0; 14];
        counts[3] = 5;
        counts[9] = 5;
        let found = estimate(&timing, &counts, 0.0).expect("there is a peak");
        assert_eq!(found.coarse_step, 3);
    }
}
