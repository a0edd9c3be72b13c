//! Corners of the code's correlation, one at each phase step: where counts change unevenly with a delay, so that no one
//! slope says how precise it is.

use super::fit::LEAST_SHARE;
use super::fit::error::FitError;
use super::fit::normal::Normal;
use super::fit::parameters::{DerivativeColumn, FitParameters, PathParameters};
use super::fit::problem::{Problem, ResponseReading, Sides};
use super::fit::slipping::SlippingLight;
use super::{TheoryEffort, Work};
use crate::response::MeanResponse;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Slopes of the counts at a delay and to either side are compared over so many standard deviations, but no more than a phase
/// step: the code's correlation has a corner at each.
const COMPARED_STDS: f64 = 5.0;

/// Where one slope reads another one by so much as more or less than itself, the likelihood is looked at.
pub const MOST_APART: f64 = 0.05;

/// Where it reads it as less than this, or as more than its inverse, nothing is expected of light whose fit does not always
/// find the likeliest delay: pulses shorter than a sample are missed between two samples, in stretches of delay in which the
/// counts hardly change; and of fewer samples a chip than these either side of a tip has a peak of the likelihood. DESIGN.md
/// has how fits scatter there, and the command that shows it.
pub const LEAST_EVEN: f64 = 0.7;
const EVEN_SAMPLES: f64 = 4.0;

/// Of paths of one code that are nearer than so many chips the likelihood has several peaks with fewer samples a chip than these,
/// in any light: what one path gives away at its corner the other one takes.
const CLOSE_CHIPS: f64 = 1.25;
const SAMPLES_OF_CLOSE: f64 = 8.0;

/// Where a path's slopes say so many times as much scatter within that of the delays, no average says how fits scatter, and the
/// information at the scene's delays stands: paths less than some two phase steps apart are nearly one at some delays.
const MOST_CHANGED: f64 = 2.0;

/// Of so many samples a chip, corners change a fit's scatter by less than a tenth, and in bright light by 2 %. So they are
/// looked at only where that takes less than these seconds, which it does not where steps are many, as those of long codes are.
const MANY_SAMPLES: f64 = 8.0;
const SHORT_S: f64 = 0.2;

/// How corners of the code's correlation are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Corners {
    /// Not: where that takes longer than a bound may, and of [many](MANY_SAMPLES) samples a chip more than next to no time. A
    /// path that moves comes by every one, what steps that count the same light tell is [averaged](super::bound), and under
    /// light of other clocks a fit's scatter is drawn with what that adds.
    Unseen,
    /// Those of each path, which is [by itself](FitParameters::are_apart).
    Apart,
    /// Those of peaks that meet, all together.
    Meet,
}

impl Corners {
    pub fn of(
        sensor: &Sensor,
        detector: DetectorIndex,
        problem: &Problem,
        parameters: &FitParameters,
    ) -> Result<Corners, FitError> {
        let is_under_slipping_light = SlippingLight::of(problem.model).next().is_some();
        if parameters.walk.is_some() || problem.shares_light() || is_under_slipping_light {
            return Ok(Corners::Unseen);
        }
        let effort = TheoryEffort::of(sensor, detector)?;
        let is_short = match problem.samples_per_chip() < MANY_SAMPLES {
            true => effort.check(Work::Likelihood),
            false => effort.check_within(Work::Likelihood, SHORT_S),
        };
        Ok(match (is_short.is_ok(), parameters.are_apart()) {
            (false, _) => Corners::Unseen,
            (true, true) => Corners::Apart,
            (true, false) => Corners::Meet,
        })
    }
}

/// Refuses [close](CLOSE_CHIPS) paths of few samples a chip, of which a fit takes both.
pub fn check_close(problem: &Problem, parameters: &FitParameters) -> Result<(), FitError> {
    let samples_per_chip = problem.samples_per_chip();
    let are_both_lit = |[one, other]: [&PathParameters; 2]| {
        let [one, other] = [one.rate(), other.rate()];
        one.min(other) > LEAST_SHARE * (one + other)
    };
    let mut close = parameters.pairs_within(CLOSE_CHIPS);
    match samples_per_chip < SAMPLES_OF_CLOSE && close.any(are_both_lit) {
        true => Err(FitError::Close { samples_per_chip, chips: CLOSE_CHIPS }),
        false => Ok(()),
    }
}

/// Whether nothing may be expected of the scene, so that its slopes are compared.
pub fn may_be_uneven(
    problem: &Problem,
    parameters: &FitParameters,
    response: &MeanResponse,
) -> bool {
    let has_few_samples = problem.samples_per_chip() < EVEN_SAMPLES && !problem.shares_light();
    parameters.walk.is_none() && (response.misses_pulses() || has_few_samples)
}

/// What one slope of the counts reads another one as, of those to either side and at the delay the two that are farthest
/// apart, with all else unknown. Of whitened derivatives by all unknowns number `delay` is that by the delay.
pub fn most_uneven(
    problem: &Problem,
    columns: &[Vec<f64>],
    (delay, std_chips): (usize, f64),
    apart: impl Fn(f64) -> Result<Vec<f64>, FitError>,
) -> Result<f64, FitError> {
    let far = (COMPARED_STDS * std_chips).min(1.0 / problem.samples_per_chip());
    let to_side = |side: f64| {
        let apart = apart(side * far)?;
        Ok::<Vec<f64>, FitError>(apart.into_iter().map(|of| of / (side * far)).collect())
    };
    let slopes = [to_side(-1.0)?, columns[delay].clone(), to_side(1.0)?];
    let (mut columns, mut most) = (columns.to_vec(), 1.0_f64);
    for by in &slopes {
        columns[delay].clone_from(by);
        for of in &slopes {
            let read = Normal::of_whitened(&columns, of).map_or(0.0, |n| n.solution()[delay]);
            // Of a slope that reads another one the wrong way round nothing is farther.
            let far = |read: f64| read.max(0.0).ln().abs();
            if far(read) > far(most) {
                most = read;
            }
        }
    }
    Ok(most)
}

/// Standard deviations of the delays in chips where peaks meet, so that the information changes with each of the delays, and
/// within what they scatter: its inverse on average over the delays that estimates come from, by a cubature of the third
/// degree over their normal law, which is that of the `information` at the scene's. `None` where the
/// information changes too much within it.
pub fn averaged_over_delays(
    problem: &Problem,
    parameters: &FitParameters,
    information: &Normal,
    information_of: impl Fn(&[DerivativeColumn]) -> Result<Normal, FitError>,
) -> Result<Option<Vec<f64>>, FitError> {
    let paths = parameters.paths.len();
    let delays: Vec<usize> = (0..paths).map(|path| 2 * path).collect();
    let of_delays = |normal: &Normal| normal.standard_deviations().into_iter().step_by(2);
    let mut variances: Vec<f64> =
        of_delays(information).map(|std| std * std / 3.0).take(paths).collect();
    let (radius, weight) = ((1.5 * paths as f64).sqrt(), 1.0 / (3.0 * paths as f64));
    for direction in information.directions(&delays) {
        for side in [-radius, radius] {
            let mut there = parameters.clone();
            for (path, by) in there.paths.iter_mut().zip(&direction) {
                path.delay_chips += side * by;
            }
            let response = problem.response(&there)?;
            let jacobian =
                problem.jacobian(&there, &response, ResponseReading::Exact, Sides::Both)?;
            let Ok(there) = information_of(&jacobian) else { return Ok(None) };
            let stds = of_delays(&there).zip(of_delays(information)).zip(&mut variances);
            for ((std, here), variance) in stds {
                if std > MOST_CHANGED * here {
                    return Ok(None);
                }
                *variance += weight * std * std;
            }
        }
    }
    Ok(Some(variances.into_iter().map(f64::sqrt).collect()))
}
