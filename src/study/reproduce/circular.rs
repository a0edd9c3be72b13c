//! The circular error of the fine stage against the sub-step delay, by both
//! estimators: a detector without faults, and an m-sequence, whose side lobes are
//! flat.

use std::sync::Arc;

use super::prelude::*;
use crate::code::{CodeSpec, Family};
use crate::estimate::{calibration_offset_ps, delay_error_ps, estimate};
use crate::photons::DetectorModel;
use crate::response::MeanResponse;
use crate::scan::Step;

/// Degree of the code.
const DEGREE: u32 = 11;
/// So many code periods that rounding a mean count to a whole number moves no
/// distance by a nanometre.
const PERIODS_WITHOUT_NOISE: u64 = 1_000_000_000;
/// So many that a scan scatters by some tens of micrometres: 160 s a step.
const PERIODS_WITH_NOISE: u64 = 10_000_000;
/// Scans behind each point of the model estimator.
const SCANS: u64 = 20;
/// What the model estimator's error is to stay below.
const LIMIT_MM: f64 = 0.05;

/// An error at a delay, in phase steps beyond a whole one.
struct ErrorAt {
    series: String,
    delay: f64,
    error: [Option<f64>; 3],
}

/// The circular error for zeta = 0..4.
pub fn circular_error(run: &mut FigureScans) -> Result<Figure, FigureError> {
    let spec = CodeSpec { degree: Some(DEGREE), ..CodeSpec::new(Family::MSequence) };
    let code = spec.build().map(Arc::new)?;
    let mut rows = Vec::new();
    for zeta in 0..=4 {
        phase_errors(&code, zeta, &mut rows)?;
        model_errors(run, &code, zeta, &mut rows)?;
    }
    let table = Table::of(&rows)
        .column("series", |row| row.series.as_str())
        .column("sub_step_delay", |row| row.delay)
        .column("error_m", |row| row.error[0])
        .column("low_m", |row| row.error[1])
        .column("high_m", |row| row.error[2])
        .table();
    let of = |estimator: &str| {
        // Zero has no place on a logarithmic axis: what is left there is below
        // the counts' rounding.
        let size = |table: &Table, row: &_| table.value(row, "error_m").number().map(f64::abs);
        let is_shown = |size: f64| estimator == "model " || size > 1e-8;
        table
            .only(|table, row| {
                row.name.starts_with(estimator) && size(table, row).is_some_and(is_shown)
            })
            .named(|_, row| row.name.replace(estimator, ""))
    };
    let panel = |y| {
        Panel::new(
            ChartAxis::linear("sub_step_delay", "delay beyond a whole phase step (of T_s)"),
            y,
        )
    };
    let panels = vec![
        panel(ChartAxis::log("error_m", "size of the phase estimator's error (mm)"))
            .curves(&of("phase "), Mark::Line),
        panel(ChartAxis::linear("error_m", "error of the model estimator (mm)"))
            .curves(&of("model "), Mark::Dots)
            .limits(LIMIT_MM, "mm"),
    ];
    let title = "Circular error of the fine stage, ideal detector, S = 2^ζ";
    Ok(Figure::new(title, table, panels))
}

/// The phase estimator's errors with 2^zeta phase steps of a chip.
fn phase_errors(code: &Arc<Code>, zeta: u32, rows: &mut Vec<ErrorAt>) -> Result<(), FigureError> {
    for sixtieth in 0..=60 {
        let delay = f64::from(sixtieth) / 60.0;
        let error = phase_error_m(code, 1 << zeta, delay)?.spread();
        rows.push(ErrorAt { series: format!("phase ζ = {zeta}"), delay, error });
    }
    Ok(())
}

/// The model estimator's errors in scans with noise.
fn model_errors(
    run: &mut FigureScans,
    code: &Arc<Code>,
    zeta: u32,
    rows: &mut Vec<ErrorAt>,
) -> Result<(), FigureError> {
    for sixth in 0..=6 {
        // Side by side in the drawing.
        let delay = (f64::from(sixth) + (f64::from(zeta) - 2.0) * 0.06) / 6.0;
        let mut scene = ideal_scene(code, 1 << zeta, delay, PERIODS_WITH_NOISE);
        scene.estimator = EstimatorKind::Model;
        let error = run.fitted_bias_in_continuous_time_m(&scene, SCANS)?.spread();
        rows.push(ErrorAt { series: format!("model ζ = {zeta}"), delay, error });
    }
    Ok(())
}

/// An ideal detector, with light `delay` phase steps beyond five chips.
fn ideal_scene(code: &Arc<Code>, samples_per_chip: u32, delay: f64, periods: u64) -> Scene {
    let step_ps = CHIP_PERIOD_PS / f64::from(samples_per_chip);
    let delay_ps = 5.0 * CHIP_PERIOD_PS + delay * step_ps;
    let mut scene = sensor(&[PathLight::new(code, POWER_PW).at(delay_ps)], 1e-3);
    scene.samples_per_chip = samples_per_chip;
    scene.sources[0].extinction_ratio = f64::INFINITY;
    scene.scan.steps = u64::from(samples_per_chip) * code.len();
    scene.scan.steps_per_period = scene.scan.steps;
    scene.scan.integration_chips = periods * code.len();
    let spad = &mut scene.detectors[0];
    spad.dark_count_rate_cps = 0.0;
    spad.dead_time_ps = 0.0;
    spad.afterpulsing_probability = 0.0;
    spad.delay_ps = 0.0;
    spad.jitter_ps.clear();
    spad.counter.rising_delay_ps = 0.0;
    spad.counter.falling_delay_ps = 0.0;
    spad.counter.transition_ps = 0.0;
    window(scene, delay_ps, 3)
}

/// Error of the phase estimate from mean counts.
fn phase_error_m(
    code: &Arc<Code>,
    samples_per_chip: u32,
    delay: f64,
) -> Result<Option<f64>, FigureError> {
    let scene = ideal_scene(code, samples_per_chip, delay, PERIODS_WITHOUT_NOISE);
    let sensor = Sensor::new(&scene);
    let model = DetectorModel::new(&sensor, DetectorIndex(0));
    // Of an ideal counter: samples would let pulses merge.
    let tier = CountingTier::Events;
    let response = MeanResponse::of_tier(&model, tier)?;
    let counts: Vec<i64> = Step::all(scene.scan.steps)
        .map(|step| response.expected_count(step).round() as i64)
        .collect();
    let offset_ps = calibration_offset_ps(&sensor, DetectorIndex(0), tier);
    let period_ps = sensor.timing().code_period_ps();
    let estimate = estimate(sensor.timing(), &counts, offset_ps).ok();
    let delay_ps = scene.paths[0].delay_ps;
    Ok(estimate.map(|e| distance_m(delay_error_ps(e.delay_ps, delay_ps, period_ps))))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::estimate::fit::{OtherLight, fit_means};
    use crate::response::MeanCount;

    #[test]
    fn the_circular_error_is_that_of_a_sampled_triangle() {
        let spec = CodeSpec { degree: Some(5), ..CodeSpec::new(Family::MSequence) };
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
                let error_m = phase_error_m(&code, samples, delay)
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
        let spec = CodeSpec { degree: Some(5), ..CodeSpec::new(Family::MSequence) };
        let code = spec.build().map(Arc::new).expect("an m-sequence");
        let error_m = phase_error_m(&code, 1, 0.25).expect("a mean response");
        let expected_m = distance_m(-0.25 * CHIP_PERIOD_PS);
        assert!((error_m.expect("an estimate") - expected_m).abs() < 1e-9);
    }

    /// A triangle of half-base S on flat ground, by definition, through the fit.
    #[test]
    fn the_model_estimator_finds_a_triangle_between_steps() {
        let spec = CodeSpec { degree: Some(5), ..CodeSpec::new(Family::MSequence) };
        let code = spec.build().map(Arc::new).expect("an m-sequence");
        for samples in [1_u32, 2, 8, 16] {
            for delay in [-0.02, 0.1, 0.25, 0.5, 0.98] {
                let scene = ideal_scene(&code, samples, delay, 100_000);
                let s = f64::from(samples);
                let counts: Vec<MeanCount> = Step::all(scene.scan.steps)
                    .map(|step| {
                        let lag = scene.scan.phase_step(step) as f64 - 5.0 * s - delay;
                        let height = (1.0 - lag.abs() / s).max(0.0);
                        // In step every detection counts up; a chip off, the
                        // 16 on-chips meet 8 chips of either sign.
                        let total = 1e9;
                        MeanCount { signed: total * height, total }
                    })
                    .collect();
                let tier = CountingTier::Events;
                let found = fit_means(
                    &Sensor::new(&scene),
                    DetectorIndex(0),
                    tier,
                    &counts,
                    OtherLight::None,
                )
                .expect("it fits");
                let error_ps = found.delay_ps - scene.paths[0].delay_ps;
                let error_mm = 1e3 * distance_m(error_ps);
                assert!(error_mm.abs() < 1e-3, "S = {samples}, {delay}: {error_mm}");
            }
        }
    }
}
