//! The model estimator on a histogram: delay and strength of the path, and the constant
//! light, fitted to its bins.
//!
//! Whoever knows the bins before expects of a bin what its mean and their deviations say, and
//! what is beyond that is apart from all else ([`Innovations`]): weighted least squares of
//! 16,376 bins with their covariance, in as much time as the bins take to read.

use std::sync::Arc;

use super::error::FitError;
use super::gauss_newton::{CONVERGED_SIGMAS, bounded};
use super::model_estimate::{FittedPath, ModelEstimate};
use super::normal::Normal;
use super::parameters::{DELAY_STEP_CHIPS, Parameters};
use super::problem::Problem;
use super::start;
use crate::estimate::dead_time::{dead_time, periods};
use crate::estimate::path_bound::{Bound, PathBound};
use crate::estimate::phase::estimate_at;
use crate::estimate::{CountingTier, calibration_offset_ps, distance_m};
use crate::histogram::Histogram;
use crate::histogram::correction::{DeadTime, PrimaryLight};
use crate::histogram::correlation::Correlator;
use crate::histogram::innovations::Innovations;
use crate::photons::DetectorModel;
use crate::response::{Light, MeanCount, MeanResponse};
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Most Gauss-Newton steps.
const MOST_ITERATIONS: usize = 24;

/// From this many steps on they are halved: where a light's edge stands between two bins,
/// full ones may go to and fro.
const FULL_STEPS: usize = 8;

/// Fits histograms of one detector.
#[derive(Debug)]
pub struct BinFitter<'s> {
    sensor: &'s Sensor,
    detector: DetectorIndex,
    path: PathIndex,
    model: DetectorModel,
    correlator: Correlator,
    dead_time: DeadTime,
    periods: f64,
}

/// Where a fit stands.
struct Place<'m> {
    parameters: Parameters,
    response: MeanResponse<'m>,
    means: Vec<f64>,
    innovations: Innovations,
}

impl<'s> BinFitter<'s> {
    /// A fitter for histograms of detector `detector`, to which one path of its own source
    /// carries modulated light.
    ///
    /// # Errors
    /// When other modulated light reaches the detector, or a histogram does not show when
    /// it was blind.
    ///
    /// # Panics
    /// If the scene has no such detector.
    pub fn new(sensor: &'s Sensor, detector: DetectorIndex) -> Result<BinFitter<'s>, FitError> {
        let model = DetectorModel::new(sensor, detector);
        let own = sensor.scene().detectors[detector].reference;
        let paths: Vec<PathIndex> = model.modulated_paths().collect();
        let of_own = paths.iter().filter(|&&path| sensor.scene().paths[path].source == own);
        let path = match (paths.as_slice(), of_own.count()) {
            ([], _) => return Err(FitError::Dark),
            (&[path], 1) => path,
            (paths, own) => {
                let paths = paths.len();
                return Err(FitError::NotOnePath { paths, own });
            }
        };
        let code = sensor.reference(detector);
        Ok(BinFitter {
            correlator: Correlator::new(code, sensor.clock().samples_per_chip),
            dead_time: dead_time(sensor, detector)?,
            periods: periods(sensor),
            sensor,
            detector,
            path,
            model,
        })
    }

    /// Fits a histogram.
    ///
    /// # Errors
    /// When it has no peak, or cannot be of this detector, or the fit does not settle.
    ///
    /// # Panics
    /// If it has not one bin per sample of the code period.
    pub fn fit(&self, histogram: &Histogram) -> Result<ModelEstimate, FitError> {
        let counts: Vec<f64> = histogram.bins().iter().map(|&count| count as f64).collect();
        self.fit_from(&counts, self.dead_time.correct(histogram).ok())
    }

    /// The same for counts of bins that need not be whole.
    ///
    /// # Errors
    /// As [`BinFitter::fit`].
    ///
    /// # Panics
    /// As [`BinFitter::fit`].
    pub fn fit_means(&self, counts: &[f64]) -> Result<ModelEstimate, FitError> {
        let per_period: Vec<f64> = counts.iter().map(|count| count / self.periods).collect();
        let light = self.dead_time.correct_means(&per_period, self.periods);
        self.fit_from(counts, light.ok())
    }

    /// Where the fit starts: as that to counts of phase steps does, but for the delay, which
    /// is that of the light without dead time and afterpulses, if it can be had.
    fn start(&self, counts: &[f64], light: Option<PrimaryLight>) -> Result<Parameters, FitError> {
        let total = counts.iter().sum();
        let signed = self.correlator.correlate(counts).into_iter();
        let steps: Vec<MeanCount> = signed.map(|signed| MeanCount { signed, total }).collect();
        let tier = CountingTier::Sampled;
        let mut start = start::start(self.sensor, self.detector, tier, &steps)?;
        if let Some(light) = light {
            let values = self.correlator.correlate(&light.per_period);
            let offset_ps = calibration_offset_ps(self.sensor, self.detector, tier);
            let timing = self.sensor.timing();
            let phase = estimate_at(&values, start.peak.index(), timing, offset_ps);
            start.parameters.paths[0].delay_chips = self.sensor.clock().chips(phase.delay_ps);
        }
        Ok(start.parameters)
    }

    fn fit_from(
        &self,
        counts: &[f64],
        light: Option<PrimaryLight>,
    ) -> Result<ModelEstimate, FitError> {
        let start = self.start(counts, light)?;
        let problem = self.problem();
        let mut place = self.place(&problem, start)?;
        let mut known: Option<(Parameters, [Vec<f64>; 2])> = None;
        for iteration in 1..=MOST_ITERATIONS {
            let light = match known.take() {
                Some((at, light)) if !place.parameters.differ_from(&at) => (at, light),
                _ => (place.parameters.clone(), place.light_columns(&problem)?),
            };
            let delay = place.delay_column(&problem)?;
            let columns = [&delay, &light.1[0], &light.1[1]];
            let deviations = differences(counts, &place.means);
            let residuals = place.innovations.whitened(&deviations)?;
            let normal = self.normal(&place, &columns, &residuals)?;
            let share = if iteration > FULL_STEPS { 0.5 } else { 1.0 };
            let moved = place.parameters.moved(&bounded(&normal, &place.parameters), share);
            let step = moved.minus(&place.parameters);
            if normal.largest_step_sigmas(&step) < CONVERGED_SIGMAS {
                let chi_square = residuals.iter().map(|r| r * r).sum();
                let chi_square = self.chi_square_as_of_normal(chi_square, &place);
                return Ok(self.outcome(&moved, &normal, chi_square, iteration));
            }
            known = Some(light);
            place = self.place(&problem, moved)?;
        }
        Err(FitError::NotConverged { steps: MOST_ITERATIONS })
    }

    /// What the fit says of the expected histogram of the scene's own light.
    ///
    /// # Errors
    /// As [`BinFitter::fit`].
    pub fn expected(&self) -> Result<ModelEstimate, FitError> {
        self.fit_means(&MeanResponse::new(&self.model)?.mean_bins())
    }

    /// How precise any unbiased estimate from the bins can be: the inverse of what their
    /// means, with their covariance, tell of the unknowns.
    ///
    /// # Errors
    /// When the mean response cannot be had, or the bins do not determine all unknowns.
    pub fn bound(&self) -> Result<Bound, FitError> {
        let problem = self.problem();
        let place = self.place(&problem, Parameters::of(&Light::of(&self.model)))?;
        let [strength, constant] = place.light_columns(&problem)?;
        let delay = place.delay_column(&problem)?;
        let nothing = vec![0.0; place.means.len()];
        let normal = self.normal(&place, &[&delay, &strength, &constant], &nothing)?;
        let delay_std_chips = normal.standard_deviations()[0];
        Ok(Bound {
            paths: vec![PathBound {
                path: self.path,
                bound_m: distance_m(self.sensor.clock().ps(delay_std_chips)),
                velocity_bound_m_per_s: None,
            }],
            steps: place.means.len(),
        })
    }

    fn problem(&self) -> Problem<'_> {
        Problem {
            model: &self.model,
            tier: CountingTier::Sampled,
            codes: vec![Arc::clone(&self.model.reference)],
            steps: Vec::new(),
        }
    }

    fn place<'m>(
        &self,
        problem: &Problem<'m>,
        parameters: Parameters,
    ) -> Result<Place<'m>, FitError> {
        let response = problem.response(&parameters)?;
        let means = response.mean_bins();
        Ok(Place {
            innovations: Innovations::new(self.dead_time, &means, self.periods)?,
            parameters,
            response,
            means,
        })
    }

    fn normal(
        &self,
        place: &Place,
        columns: &[&Vec<f64>],
        residuals: &[f64],
    ) -> Result<Normal, FitError> {
        let whitened: Result<Vec<Vec<f64>>, _> =
            columns.iter().map(|column| place.innovations.whitened(column)).collect();
        let normal = Normal::of_whitened(&whitened?, residuals);
        normal.ok_or(FitError::Undetermined { steps: place.means.len(), unknowns: columns.len() })
    }

    /// Bins of few counts make chi-square scatter more than that of normal numbers does, by
    /// 1 / mean each. As many standard deviations from its expectation, in those of normal
    /// numbers.
    fn chi_square_as_of_normal(&self, chi_square: f64, place: &Place) -> f64 {
        let degrees = (place.means.len() - place.parameters.len()) as f64;
        let excess: f64 = place.innovations.means().iter().map(|mean| 1.0 / mean).sum();
        degrees + (chi_square - degrees) * (2.0 * degrees / (2.0 * degrees + excess)).sqrt()
    }

    fn outcome(
        &self,
        fitted: &Parameters,
        normal: &Normal,
        chi_square: f64,
        iterations: usize,
    ) -> ModelEstimate {
        let clock = self.sensor.clock();
        let std = normal.standard_deviations();
        let code = &self.model.reference;
        let path = fitted.paths[0];
        let delay_ps = clock.ps(path.delay_chips.rem_euclid(code.len() as f64));
        let bins = self.correlator.bins();
        ModelEstimate {
            velocity: None,
            delay_ps,
            distance_m: distance_m(delay_ps),
            std_m: distance_m(clock.ps(std[0])),
            paths: vec![FittedPath {
                code: Arc::clone(code),
                delay_ps,
                delay_std_ps: clock.ps(std[0]),
                rate_hz: clock.hz(path.ln_rate.exp()),
                rate_relative_std: std[1],
            }],
            constant_rate_hz: clock.hz(fitted.constant),
            chi_square,
            degrees_of_freedom: bins - fitted.len(),
            steps: bins,
            untold: None,
            iterations,
        }
    }
}

impl Place<'_> {
    /// Derivative of every bin's mean by the delay, from both sides.
    fn delay_column(&self, problem: &Problem) -> Result<Vec<f64>, FitError> {
        let at = |chips: f64| -> Result<Vec<f64>, FitError> {
            Ok(self.response.delayed(problem.clock().ps(chips))?.mean_bins())
        };
        let (early, late) = (at(-DELAY_STEP_CHIPS)?, at(DELAY_STEP_CHIPS)?);
        let slope = |d: f64| d / (2.0 * DELAY_STEP_CHIPS);
        Ok(differences(&late, &early).into_iter().map(slope).collect())
    }

    /// Derivatives by the logarithm of the strength, and by the constant light.
    fn light_columns(&self, problem: &Problem) -> Result<[Vec<f64>; 2], FitError> {
        let column = |index: usize| -> Result<Vec<f64>, FitError> {
            let (nudged, step) = self.parameters.nudged(index, 1.0);
            let means = problem.response(&nudged)?.mean_bins();
            Ok(differences(&means, &self.means).into_iter().map(|d| d / step).collect())
        };
        Ok([column(1)?, column(2)?])
    }
}

fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
