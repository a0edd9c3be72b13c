//! The result of a fit.

use std::sync::Arc;

use super::parameters::FitParameters;
use crate::code::Code;
use crate::estimate::distance_m;
use crate::math::NormalLaw;
use crate::scan::Clock;

/// Chi-square this many standard deviations above its expectation is an alarm;
/// by chance less than one fit in 10,000 has it.
pub const ALARM_SIGMAS: f64 = 5.0;

/// The result of a fit.
#[derive(Debug, Clone)]
pub struct ModelEstimate {
    /// Time of flight of the strongest path of the reference, folded into
    /// 0 .. code period.
    pub delay_ps: f64,
    /// Half its optical path.
    pub distance_m: f64,
    /// Standard deviation of the distance, from the counts' covariances.
    pub std_m: f64,
    /// Speed of the path, and the moment that the distance refers to; `None` for paths at rest.
    pub velocity: Option<Velocity>,
    /// Every path of the fit, the strongest of the reference first.
    pub paths: Vec<FittedPath>,
    /// Primary rate of all light that is not modulated, dark counts included.
    pub constant_rate_hz: f64,
    /// Weighted sum of squared residuals: about `degrees_of_freedom`, with a
    /// standard deviation of sqrt(2 x that), unless the model lacks something.
    pub chi_square: f64,
    /// Two per step, less the number of unknowns.
    pub degrees_of_freedom: usize,
    /// Phase steps that took part.
    pub steps: usize,
    /// Own paths of the scene that the counts do not tell apart; none if all were
    /// found.
    pub untold: Option<Untold>,
    /// How many standard deviations the closest paths of one code are from being one: the root of what chi-square then rises
    /// by. Infinite without such.
    pub told_apart_by: f64,
    /// Gauss-Newton steps of the last fit.
    pub iterations: usize,
    /// Largest correlation of the signed and the total count of a step, of the moments that the counts were weighed with.
    pub most_correlated: f64,
}

/// How a path moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Velocity {
    /// Speed of the distance, positive away from the sensor.
    pub m_per_s: f64,
    /// Its standard deviation.
    pub std_m_per_s: f64,
    /// The moment that the distance is of, from the start of the scan.
    pub at_s: f64,
}

/// One path of a fit.
#[derive(Debug, Clone)]
pub struct FittedPath {
    /// Its code.
    pub code: Arc<Code>,
    /// Time of flight, folded into 0 .. code period.
    pub delay_ps: f64,
    /// Its standard deviation.
    pub delay_std_ps: f64,
    /// Primary rate that on-chips add.
    pub rate_hz: f64,
    /// Standard deviation of that rate, as a share of it.
    pub rate_relative_std: f64,
}

/// Paths of the scene that the counts do not show.
#[derive(Debug, Clone, PartialEq)]
pub struct Untold {
    /// How many of the detector's own source were not told apart.
    pub missing: usize,
    /// How many of other sources, whose codes are known.
    pub missing_of_others: usize,
    /// Two equal paths of the own source nearer to each other than this are told apart in
    /// less than 95 % of scans, with the light that was found. As a difference of
    /// distances; 0 where none is missing.
    pub resolution_m: f64,
}

impl FittedPath {
    /// How many standard deviations its light is above none.
    pub fn significance(&self) -> f64 {
        1.0 / self.rate_relative_std.max(f64::MIN_POSITIVE)
    }
}

impl std::fmt::Display for Untold {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.missing > 0 {
            write!(
                f,
                "{} more of the own source's paths cannot be told apart from what was found: they \
                 are too weak, or within {:.3} m of one (where two equal ones are told apart in \
                 95 % of scans); standard deviations take that in",
                self.missing, self.resolution_m
            )?;
        }
        if self.missing > 0 && self.missing_of_others > 0 {
            f.write_str("; ")?;
        }
        if self.missing_of_others > 0 {
            write!(
                f,
                "{} more of other sources' paths cannot be told apart from what was found: they \
                 are too weak, or too close to another of the same source",
                self.missing_of_others
            )?;
        }
        Ok(())
    }
}

/// How well unknowns fit.
pub(super) struct Goodness {
    pub chi_square: f64,
    pub degrees_of_freedom: usize,
    pub steps: usize,
    pub iterations: usize,
    pub most_correlated: f64,
}

impl ModelEstimate {
    /// Of unknowns, and their standard deviations. The speed of a path that moves is of the start
    /// of the scan.
    pub(super) fn new(
        clock: Clock,
        parameters: &FitParameters,
        std: &[f64],
        found: Goodness,
    ) -> ModelEstimate {
        let of_paths = parameters.paths.iter().zip(std.chunks(2));
        let paths: Vec<FittedPath> = of_paths
            .map(|(path, std)| FittedPath {
                code: Arc::clone(&path.code),
                delay_ps: clock.ps(path.delay_chips.rem_euclid(path.code.len() as f64)),
                delay_std_ps: clock.ps(std[0]),
                rate_hz: clock.hz(path.rate()),
                rate_relative_std: std[1],
            })
            .collect();
        let Goodness { chi_square, degrees_of_freedom, steps, iterations, most_correlated } = found;
        ModelEstimate {
            delay_ps: paths[0].delay_ps,
            distance_m: distance_m(paths[0].delay_ps),
            std_m: distance_m(paths[0].delay_std_ps),
            velocity: parameters.walk.map(|walk| Velocity {
                m_per_s: distance_m(1e12 * walk),
                std_m_per_s: distance_m(1e12 * std[2 * paths.len()]),
                at_s: 0.0,
            }),
            constant_rate_hz: clock.hz(parameters.constant),
            chi_square,
            degrees_of_freedom,
            steps,
            untold: None,
            told_apart_by: f64::INFINITY,
            iterations,
            most_correlated,
            paths,
        }
    }

    /// The same of fits of the only path whose delays, in chips, scatter round this one by a law.
    pub(super) fn scattered_by(self, clock: Clock, law: NormalLaw) -> ModelEstimate {
        let [bias_ps, std_ps] = [law.mean, law.std].map(|chips| clock.ps(chips));
        let mut scattered = ModelEstimate { std_m: distance_m(std_ps), ..self };
        scattered.paths[0].delay_ps += bias_ps;
        scattered.paths[0].delay_std_ps = std_ps;
        scattered
    }

    /// How many standard deviations chi-square is above its expectation: the
    /// alarm that the light or the detector is not as modelled.
    pub fn alarm_sigmas(&self) -> f64 {
        let degrees = self.degrees_of_freedom as f64;
        (self.chi_square - degrees) / (2.0 * degrees).sqrt()
    }
}
