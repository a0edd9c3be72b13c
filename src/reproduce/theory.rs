//! What needs no photons: correlations of codes (Fig. 3) and the estimator's
//! circular error.

use std::sync::Arc;

use super::figure::{Claim, Figure, Table};
use super::run::{Run, RunError};
use super::sensor::{CHIP_PERIOD_PS, Light, POWER_PW, gold, sensor, square, window};
use super::statistics::Measured;
use crate::code::{Code, CodeError, CodeSpec, Family, bound, correlate};
use crate::estimate::{
    CountingTier, Measurement, calibration_offset_ps, delay_error_ps, distance_m, estimate,
};
use crate::optics::{DetectorModel, MeanResponse};
use crate::report::chart::{Axis, Chart, Legend, Mark, Panel, Point, Scale, Series};

/// Degree of the article's codes.
const DEGREE: u32 = 11;
/// A target near the end of the unambiguous range of 2.45 km: 2.4 km.
const FAR_TARGET_PS: f64 = 16_011_076.6;

/// Fig. 3, which decides C5 and C8.
pub fn code_correlation(run: &mut Run) -> Result<Figure, RunError> {
    let mut table = Table::new(&["series", "lag_chips", "correlation"]);
    let (mut whole, mut near) = (Vec::new(), Vec::new());
    for nu in 0..=2 {
        let code = gold(0, nu)?;
        let label = format!("ν = {nu}");
        let points = normalised(&code);
        for point in &points {
            table.row(&label, &[Some(point.x), Some(point.y)]);
        }
        near.push(Series {
            label: label.clone(),
            mark: Mark::LineAndDots,
            colour: nu as usize,
            points: points
                .iter()
                .copied()
                .filter(|p| p.x.abs() <= 10.0)
                .collect(),
        });
        whole.push(Series {
            label,
            mark: Mark::Line,
            colour: nu as usize,
            points,
        });
    }
    // The longest at the back, where it hides nothing.
    whole.reverse();
    let panel = |series, label: &str| Panel {
        x: Axis {
            label: label.to_owned(),
            scale: Scale::Linear,
        },
        y: Axis {
            label: "autocorrelation, share of the peak".to_owned(),
            scale: Scale::Linear,
        },
        series,
        legend: Legend::UpperRight,
        headroom: 0.06,
    };
    let near = panel(near, "lag (chips), near the peak");
    let whole = panel(whole, "lag (chips), the whole period");
    Ok(Figure {
        chart: Chart {
            title: "Fig. 3: autocorrelation of Gold code and interleaved codes, L = 2047"
                .to_owned(),
            panels: vec![whole, near],
        },
        table,
        claims: vec![unambiguous_range(run)?, side_lobes()?],
    })
}

/// Autocorrelation over its peak, by lag in chips from minus to plus half a
/// period.
fn normalised(code: &Code) -> Vec<Point> {
    let theta = correlate(&code.chips, &code.chips);
    let length = theta.len() as i64;
    let half = length / 2;
    (-half..=(length - 1) / 2)
        .map(|lag| {
            let value = theta[lag.rem_euclid(length) as usize];
            Point::new(lag as f64, value as f64 / theta[0] as f64)
        })
        .collect()
}

/// The smallest lag above 0 at which a code equals itself, in chips.
fn period_chips(code: &Code) -> u64 {
    let theta = correlate(&code.chips, &code.chips);
    let repeats = (1..theta.len()).find(|&lag| theta[lag] == theta[0]);
    repeats.unwrap_or(theta.len()) as u64
}

/// C5, with scans of a target near the end of the range.
fn unambiguous_range(run: &mut Run) -> Result<Claim, RunError> {
    let (code, square) = (gold(0, 0)?, square()?);
    let range_m = |code: &Code| distance_m(period_chips(code) as f64 * CHIP_PERIOD_PS);
    let times = range_m(&code) / range_m(&square);
    let light = Light::new(&code, POWER_PW).at(FAR_TARGET_PS);
    let found: Measured = run.search(&sensor(&[light], 104.8e-6))?;
    Ok(Claim {
        id: "C5",
        article: "unambiguous range up a thousandfold, 2.45 km for n = 11 at 8 ns",
        criterion: "the code's smallest period, as a distance, is 2.45 km and at least 1000 times \
                    the square wave's; every scan finds a target at 2.4 km",
        measured: range_m(&code),
        unit: "m",
        ci: None,
        holds: (range_m(&code) - 2450.0).abs() < 5.0 && times >= 1000.0 && found.value >= 1.0,
        remark: format!(
            "{times:.1} times the square wave's {:.2} m. Scans over the whole range at {POWER_PW} \
             pW and 104.8 us find the target at 2.4 km in {:.1} % ({:.1} to {:.1}); at low light \
             the search fails (figure coarse)",
            range_m(&square),
            found.value * 100.0,
            found.low * 100.0,
            found.high * 100.0,
        ),
    })
}

/// C8: every code's autocorrelation, and code 0 against every other.
fn side_lobes() -> Result<Claim, CodeError> {
    // t(n) = 2^((n + 1) / 2) + 1 for odd n.
    let t = bound(DEGREE);
    let allowed = [-1, -t, t - 2];
    let first = gold(0, 0)?;
    let (mut codes, mut lobes, mut outside, mut largest) = (0_u64, 0_u64, 0_u64, 0);
    for index in -2..first.len() as i64 {
        let code = gold(index, 0)?;
        let auto = correlate(&code.chips, &code.chips);
        let cross = correlate(&first.chips, &code.chips);
        let cross = if index == 0 { &[][..] } else { &cross[..] };
        for value in auto[1..].iter().chain(cross) {
            lobes += 1;
            outside += u64::from(!allowed.contains(value));
            largest = largest.max(value.abs());
        }
        codes += 1;
    }
    Ok(Claim {
        id: "C8",
        article: "side lobes within Gold's three values",
        criterion: "no autocorrelation side lobe of any code of the set, and no cross-correlation \
                    of code 0 with another, is any other value than -1, -65, 63",
        measured: outside as f64,
        unit: "other values",
        ci: None,
        holds: outside == 0,
        remark: format!(
            "{lobes} side lobes of {codes} codes; the largest is {largest}, {:.1} % of the peak. \
             Integrating other than whole code periods (13,100 chips are 6.4) adds side lobes of \
             partial correlation, and interleaving adds the near peaks of eq. 24",
            100.0 * largest as f64 / first.len() as f64
        ),
    })
}

/// The circular error of the fine stage, for zeta = 0..4: a detector without
/// faults, exact mean counts, and an m-sequence, whose side lobes are flat.
pub fn circular_error() -> Result<Figure, RunError> {
    let spec = CodeSpec {
        degree: Some(DEGREE),
        ..CodeSpec::new(Family::MSequence)
    };
    let code = spec.build().map(Arc::new)?;
    let mut table = Table::new(&["series", "sub_step_delay", "error_m"]);
    let mut series = Vec::new();
    for zeta in 0..=4_usize {
        let label = format!("ζ = {zeta}");
        let mut points = Vec::new();
        for sixtieth in 0..=60 {
            let delay = f64::from(sixtieth) / 60.0;
            let error_m = circular_error_m(&code, 1 << zeta, delay)?;
            table.row(&label, &[Some(delay), error_m]);
            points.extend(error_m.map(|m| Point::new(delay, m.abs() * 1e3)));
        }
        // Zero has no place on a logarithmic axis: what is left there is below
        // the counts' rounding.
        points.retain(|point| point.y > 1e-5);
        series.push(Series {
            label,
            mark: Mark::Line,
            colour: zeta,
            points,
        });
    }
    Ok(Figure {
        chart: Chart {
            title: "Circular error of the fine stage, ideal detector, S = 2^ζ".to_owned(),
            panels: vec![Panel {
                x: Axis {
                    label: "delay beyond a whole phase step (of T_s)".to_owned(),
                    scale: Scale::Linear,
                },
                y: Axis {
                    label: "size of the distance error (mm)".to_owned(),
                    scale: Scale::Log,
                },
                series,
                legend: Legend::UpperRight,
                headroom: 0.3,
            }],
        },
        table,
        claims: Vec::new(),
    })
}

/// Error of the estimate from mean counts, at `delay` phase steps beyond five
/// chips.
fn circular_error_m(
    code: &Arc<Code>,
    samples_per_chip: u32,
    delay: f64,
) -> Result<Option<f64>, RunError> {
    /// So many code periods that rounding a mean count to a whole number moves
    /// no distance by a nanometre.
    const PERIODS: u64 = 1_000_000_000;
    let step_ps = CHIP_PERIOD_PS / f64::from(samples_per_chip);
    let delay_ps = 5.0 * CHIP_PERIOD_PS + delay * step_ps;
    let mut scene = sensor(&[Light::new(code, POWER_PW).at(delay_ps)], 1e-3);
    scene.samples_per_chip = samples_per_chip;
    scene.sources[0].extinction_ratio = f64::INFINITY;
    scene.scan.steps = u64::from(samples_per_chip) * code.len();
    scene.scan.steps_per_period = scene.scan.steps;
    scene.scan.integration_chips = PERIODS * code.len();
    let spad = &mut scene.detectors[0];
    spad.dark_count_rate_cps = 0.0;
    spad.dead_time_ps = 0.0;
    spad.afterpulsing_probability = 0.0;
    spad.delay_ps = 0.0;
    spad.jitter_ps.clear();
    spad.counter.rising_delay_ps = 0.0;
    spad.counter.falling_delay_ps = 0.0;
    let scene = window(scene, delay_ps, 3);

    let model = DetectorModel::new(&scene, 0);
    let response = MeanResponse::new(&model)?;
    let counts: Vec<i64> = (0..scene.scan.steps)
        .map(|step| response.expected_count(step).round() as i64)
        .collect();
    let offset_ps = calibration_offset_ps(&scene, 0, CountingTier::Sampled);
    let period_ps = CHIP_PERIOD_PS * code.len() as f64;
    let estimate = estimate(&Measurement::new(&scene, &counts), offset_ps).ok();
    Ok(estimate.map(|e| distance_m(delay_error_ps(e.delay_ps, delay_ps, period_ps))))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn the_circular_error_is_that_of_a_sampled_triangle() {
        let spec = CodeSpec {
            degree: Some(5),
            ..CodeSpec::new(Family::MSequence)
        };
        let code = spec.build().map(Arc::new).expect("an m-sequence");
        for samples in [2_u32, 4, 8, 16] {
            for delay in [0.0, 0.1, 0.25, 0.4] {
                // A triangle of half-base S about `delay`, by definition.
                let s = f64::from(samples);
                let (mut re, mut im) = (0.0, 0.0);
                for i in -(samples as i32)..samples as i32 {
                    let value = (s - (f64::from(i) - delay).abs()).max(0.0);
                    re += value * (PI * f64::from(i) / s).cos();
                    im -= value * (PI * f64::from(i) / s).sin();
                }
                let steps = -im.atan2(re) / PI * s - delay;
                let expected_m = distance_m(steps * CHIP_PERIOD_PS / s);
                let error_m = circular_error_m(&code, samples, delay)
                    .expect("a mean response")
                    .expect("an estimate");
                assert!(
                    (error_m - expected_m).abs() < 1e-7,
                    "S = {samples}, {delay}: {error_m} against {expected_m}"
                );
            }
        }
    }

    #[test]
    fn one_sample_per_chip_is_off_by_up_to_half_a_chip() {
        let spec = CodeSpec {
            degree: Some(5),
            ..CodeSpec::new(Family::MSequence)
        };
        let code = spec.build().map(Arc::new).expect("an m-sequence");
        let error_m = circular_error_m(&code, 1, 0.25).expect("a mean response");
        let expected_m = distance_m(-0.25 * CHIP_PERIOD_PS);
        assert!((error_m.expect("an estimate") - expected_m).abs() < 1e-9);
    }

    #[test]
    fn a_gold_code_repeats_after_all_its_chips_and_a_square_wave_after_two() {
        assert_eq!(period_chips(&gold(0, 0).expect("a Gold code")), 2047);
        assert_eq!(period_chips(&square().expect("a square wave")), 2);
    }
}
