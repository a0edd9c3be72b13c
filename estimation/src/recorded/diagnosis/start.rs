//! Where the tests begin: at the delay at which the scene agrees best with the counts.

use super::super::hypothesis::{ExpectedChange, SceneChange, SceneFit, Unknown, fit, fit_unknowns};
use super::super::observed::{ExpectedNumbers, Observed, response};
use super::critical;
use crate::estimate::coverage::steps_outside;
use crate::estimate::fit::FitError;
use crate::estimate::{CountingTier, calibration_offset_ps};
use crate::photons::DetectorModel;
use crate::response::MeanResponse;
use crate::sensor::Sensor;

/// The scene with its delay fitted, from the best of some delays; without an unknown if the counts do
/// not determine the delay.
pub(in crate::recorded) fn fit_of_scene(
    sensor: &Sensor,
    observed: Observed,
    delays_ps: &[f64],
) -> Result<SceneFit, FitError> {
    let start = best_delay(sensor, observed, delays_ps, None)?;
    let fitted = fit(sensor, observed, &[Unknown::Delay], start.clone());
    fitted.or_else(|_| fit(sensor, observed, &[], start))
}

/// How much later than the scene's the light comes, as [`fit_of_scene`] finds it, and the standard deviation. Of the
/// scene `as_it_is` the expectation may be known.
pub(in crate::recorded) fn delay_of_scene(
    sensor: &Sensor,
    observed: Observed,
    delays_ps: &[f64],
    as_it_is: Option<&ExpectedNumbers>,
) -> Result<[f64; 2], FitError> {
    let start = best_delay(sensor, observed, delays_ps, as_it_is)?;
    let (change, errors) = fit_unknowns(sensor, observed, &[Unknown::Delay], &start)?;
    Ok([change.value(Unknown::Delay), errors[0].1])
}

/// Longest code whose peak is looked for outside of a scan: sidelobes of longer ones are small.
const MOST_CHIPS_OUTSIDE: u64 = 511;

/// A delay at which the scan does not come by the peak, if its sidelobes fit the counts better than any peak within
/// the scan: light of any level, in any background, half a chip apart over the code period.
fn delay_outside(sensor: &Sensor, observed: Observed) -> Result<Option<f64>, FitError> {
    let Observed::Steps(scan) = observed else { return Ok(None) };
    let (clock, detector) = (sensor.clock(), observed.detector());
    let code = sensor.reference(detector);
    if sensor.timing().scan.is_full() || code.len() > MOST_CHIPS_OUTSIDE {
        return Ok(None);
    }
    let Some(own) = sensor.scene().own_paths(detector).next() else { return Ok(None) };
    let offset_ps = calibration_offset_ps(sensor, detector, CountingTier::Sampled);
    let here_ps = sensor.scene().paths[own].delay_ps + offset_ps;
    let model = DetectorModel::new(sensor, detector);
    let response = MeanResponse::of_tier(&model, CountingTier::Sampled)?;
    let signed: Vec<f64> = scan.counts.iter().map(|count| count.signed as f64).collect();
    let variance = observed.expected(sensor, 0.0)?.each()[0][1].powi(2);
    // The gain of twice the log-likelihood, and the delay: of the best within the scan, and outside.
    let mut best = [(0.0, 0.0); 2];
    for half_chips in 0..2 * code.len() {
        let delay_ps = clock.ps(0.5 * half_chips as f64);
        let means = response.delayed(delay_ps)?.mean_counts();
        let means: Vec<f64> = means.iter().map(|mean| mean.signed).collect();
        let gain = gain_of_shape(&signed, &means) / variance;
        let is_outside = steps_outside(sensor, here_ps + delay_ps) > 0.0;
        let of_place = &mut best[usize::from(is_outside)];
        if gain > of_place.0 {
            *of_place = (gain, delay_ps);
        }
    }
    let [(within, _), (outside, delay_ps)] = best;
    let needed = critical() + 2.0 * (2.0 * code.len() as f64).ln();
    Ok((outside - within > needed).then_some(delay_ps))
}

/// By how much the sum of squares falls if counts have a constant and a positive multiple of a shape, beside a constant
/// alone.
fn gain_of_shape(counts: &[f64], shape: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (count, level) = (mean(counts), mean(shape));
    let product: f64 = counts.iter().zip(shape).map(|(y, m)| (y - count) * (m - level)).sum();
    let square: f64 = shape.iter().map(|m| (m - level).powi(2)).sum();
    if product > 0.0 && square > 0.0 { product * product / square } else { 0.0 }
}

/// Of some delays, the one at which the scene agrees best with the recorded counts.
fn best_delay(
    sensor: &Sensor,
    observed: Observed,
    delays_ps: &[f64],
    as_it_is: Option<&ExpectedNumbers>,
) -> Result<ExpectedChange, FitError> {
    if let Some(delay_ps) = delay_outside(sensor, observed)? {
        return SceneChange::later(delay_ps).start(sensor, observed);
    }
    let values = observed.values();
    let as_it_is = as_it_is
        .map(|known| ExpectedChange { change: SceneChange::default(), expected: known.clone() });
    let model = DetectorModel::new(sensor, observed.detector());
    let answer = as_it_is.as_ref().map(|_| response(&model)).transpose()?;
    let mut best: Option<(f64, ExpectedChange)> = None;
    for &delay_ps in delays_ps {
        let change = SceneChange::later(delay_ps);
        let start = match as_it_is.as_ref().zip(answer.as_ref()) {
            Some((known, _)) if delay_ps == 0.0 => known.clone(),
            Some((known, answer)) => known.delayed(answer, change)?,
            None => change.start(sensor, observed)?,
        };
        let deviance = start.expected.judge(&values)?.deviance;
        if deviance < best.as_ref().map_or(f64::INFINITY, |(least, _)| *least) {
            best = Some((deviance, start));
        }
    }
    best.map_or_else(|| SceneChange::default().start(sensor, observed), |(_, start)| Ok(start))
}
