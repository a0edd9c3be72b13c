//! The model estimator on a histogram: delay and strength of the path, and the constant
//! light, fitted to its bins.
//!
//! A bin is a Poisson number whose mean follows from the bins before it
//! ([`Innovations`]): this gives the likelihood of 16,376 bins in the time that it takes to read them,
//! and holds even if hardly any bin counts at all.

use super::error::FitError;
use super::likeliest::{Likeliest, Scatter, likeliest};
use super::model_estimate::{Goodness, ModelEstimate};
use super::normal::Normal;
use super::parameters::{DELAY_STEP_CHIPS, Parameters};
use super::problem::Problem;
use super::scoring::{Counts, Settling, Slopes, likeliest_of, settle};
use super::start;
use crate::estimate::dead_time::{dead_time, periods};
use crate::estimate::phase::estimate_at;
use crate::estimate::{CountingTier, calibration_offset_ps, coverage, distance_m};
use crate::histogram::Histogram;
use crate::histogram::correction::{DeadTime, PrimaryLight};
use crate::histogram::correlation::Correlator;
use crate::histogram::innovations::{Innovations, deviance};
use crate::photons::DetectorModel;
use crate::response::{Light, MeanCount, MeanResponse};
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// A fit whose chi-square is so many standard deviations too large is tried again from other
/// starts, so many chips from the first.
const RETRIED_SIGMAS: f64 = 2.0;
const OTHER_STARTS_CHIPS: [f64; 6] = [-0.25, 0.25, -0.5, 0.5, -1.0, 1.0];

/// Bins by which a fit is moved to see whether that is likelier.
const OTHER_BINS: [f64; 6] = [-1.0, -0.5, -0.25, 0.25, 0.5, 1.0];

/// Where a fit has settled.
struct BinFit {
    estimate: ModelEstimate,
    parameters: Parameters,
    misfit: f64,
}

/// Fits histograms of one detector.
#[derive(Debug)]
pub struct BinFitter<'s> {
    sensor: &'s Sensor,
    detector: DetectorIndex,
    /// The path that carries modulated light.
    pub(in crate::estimate) path: PathIndex,
    model: DetectorModel,
    correlator: Correlator,
    dead_time: DeadTime,
    periods: f64,
}

/// Light that bins may come from.
struct Bins<'m> {
    parameters: Parameters,
    response: MeanResponse<'m>,
    innovations: Innovations,
    means: Vec<f64>,
    /// What every bin is expected to count, given those before.
    expected: Vec<f64>,
}

/// A histogram that is fitted.
struct BinCounts<'f> {
    fitter: &'f BinFitter<'f>,
    problem: Problem<'f>,
    counts: &'f [f64],
    /// Derivatives by strength and background, and where they are of.
    light: Option<(Parameters, [Vec<f64>; 2])>,
}

impl<'f> Counts for BinCounts<'f> {
    type Point = Bins<'f>;
    type Error = FitError;

    fn residuals(&self, here: &Bins<'f>) -> Result<Vec<f64>, FitError> {
        let bins = self.counts.iter().zip(&here.expected);
        Ok(bins.map(|(count, mean)| (count - mean) / mean.sqrt()).collect())
    }

    fn misfit(&self, here: &Bins<'f>) -> Result<f64, FitError> {
        Ok(deviance(self.counts, &here.expected))
    }

    fn slopes(&mut self, here: &Bins<'f>, anew: bool) -> Result<Slopes, FitError> {
        let is_good = |(of, _): &(Parameters, [Vec<f64>; 2])| match anew {
            true => &here.parameters == of,
            false => !here.parameters.differ_from(of),
        };
        let (of, light) = match self.light.take().filter(is_good) {
            Some(known) => known,
            None => {
                let light = [self.light_column(here, 1)?, self.light_column(here, 2)?];
                (here.parameters.clone(), light)
            }
        };
        let are_best = of == here.parameters;
        let columns = [self.delay_column(here)?, light[0].clone(), light[1].clone()];
        self.light = Some((of, light));
        let of_unit = |column: Vec<f64>| {
            let bins = column.into_iter().zip(&here.expected);
            bins.map(|(slope, mean)| slope / mean.sqrt()).collect()
        };
        Ok(Slopes { columns: columns.map(of_unit).into(), are_best })
    }

    fn step(&self, here: &Bins<'f>, normal: &Normal) -> Vec<f64> {
        here.parameters.step(normal, self.problem.most_walk())
    }

    fn moved(&self, here: &Bins<'f>, step: &[f64]) -> Result<Bins<'f>, FitError> {
        self.bins(here.parameters.moved(step))
    }

    fn weigh(&mut self, _here: &Bins<'f>, _fall: f64) -> Result<bool, FitError> {
        Ok(false)
    }

    fn undetermined(&self, here: &Bins<'f>) -> FitError {
        FitError::Undetermined { steps: here.means.len(), unknowns: here.parameters.len() }
    }
}

impl<'f> BinCounts<'f> {
    fn bins(&self, parameters: Parameters) -> Result<Bins<'f>, FitError> {
        let response = self.problem.response(&parameters)?;
        let means = response.mean_bins();
        let (innovations, expected) = self.expected(&means)?;
        Ok(Bins { parameters, response, innovations, means, expected })
    }

    /// What every bin of some means is expected to count, given those before.
    fn expected(&self, means: &[f64]) -> Result<(Innovations, Vec<f64>), FitError> {
        let innovations = Innovations::new(self.fitter.dead_time, means, self.fitter.periods)?;
        let expected = innovations.expected(self.counts, &differences(self.counts, means))?;
        Ok((innovations, expected))
    }

    /// Derivative of what bins are expected to count by the delay, from both sides.
    fn delay_column(&self, here: &Bins) -> Result<Vec<f64>, FitError> {
        let at = |chips: f64| -> Result<Vec<f64>, FitError> {
            let delayed = here.response.delayed(self.problem.clock().ps(chips))?;
            Ok(self.expected(&delayed.mean_bins())?.1)
        };
        let (early, late) = (at(-DELAY_STEP_CHIPS)?, at(DELAY_STEP_CHIPS)?);
        Ok(slopes(&early, &late, 2.0 * DELAY_STEP_CHIPS))
    }

    /// How far bins of light `chips` later are from what they are, in standard deviations of each.
    fn told_apart(&self, here: &Bins<'f>, chips: f64) -> Result<Vec<f64>, FitError> {
        let later = here.response.delayed(self.problem.clock().ps(chips))?;
        let expected = self.expected(&later.mean_bins())?.1.into_iter().zip(&here.expected);
        Ok(expected.map(|(later, now)| (later - now) / now.sqrt()).collect())
    }

    /// Derivative by the logarithm of the strength, or by the constant light.
    fn light_column(&self, here: &Bins, index: usize) -> Result<Vec<f64>, FitError> {
        let (nudged, step) = here.parameters.nudged(index, 1.0);
        let means = self.problem.response(&nudged)?.mean_bins();
        Ok(slopes(&here.expected, &self.expected(&means)?.1, step))
    }
}

impl<'s> BinFitter<'s> {
    /// A fitter for histograms of detector `detector`, to which one path of its own source
    /// carries modulated light.
    ///
    /// # Errors
    /// When other modulated light reaches the detector, or a histogram does not show when
    /// it was blind.
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

    /// The fit from the phase's delay. Few counts put that half a chip off, and between each two
    /// bins the likelihood has a peak of its own: the likeliest is taken of those from all
    /// starts that may lead to a better one.
    fn fit_from(
        &self,
        counts: &[f64],
        light: Option<PrimaryLight>,
    ) -> Result<ModelEstimate, FitError> {
        let start = self.start(counts, light)?;
        let first = self.settle(counts, start.clone());
        let fits_badly = |settled: &BinFit| settled.estimate.alarm_sigmas() >= RETRIED_SIGMAS;
        let others = match &first {
            Ok(first) if !fits_badly(first) => self.likelier(counts, first)?,
            _ => OTHER_STARTS_CHIPS.iter().map(|&by| start.later(by)).collect(),
        };
        let others = others.into_iter().map(|there| self.settle(counts, there));
        Ok(likeliest_of(first, others, |settled| settled.misfit)?.estimate)
    }

    /// Light that comes up to a bin earlier or later, where that is likelier.
    fn likelier(&self, counts: &[f64], here: &BinFit) -> Result<Vec<Parameters>, FitError> {
        let counts = self.counts(counts);
        let mut found = Vec::new();
        for bins in OTHER_BINS {
            let there = here.parameters.later(bins * self.sensor.clock().sample_period_chips());
            let place = counts.bins(there)?;
            if counts.misfit(&place)? < here.misfit {
                found.push(place.parameters);
            }
        }
        Ok(found)
    }

    fn settle(&self, counts: &[f64], start: Parameters) -> Result<BinFit, FitError> {
        let mut counts = self.counts(counts);
        let start = counts.bins(start)?;
        let settled = settle(&mut counts, start, Settling::FINE)?;
        if !settled.has_settled {
            return Err(FitError::NotConverged { steps: settled.steps });
        }
        let place = &settled.place;
        let deviations = differences(counts.counts, &place.means);
        let residuals = place.innovations.whitened(&deviations)?;
        let chi_square = residuals.iter().map(|r| r * r).sum();
        let fitted = place.parameters.moved(&settled.step);
        let found = Goodness {
            chi_square: self.chi_square_as_of_normal(chi_square, place),
            degrees_of_freedom: place.means.len() - fitted.len(),
            steps: place.means.len(),
            iterations: settled.steps,
        };
        let std = settled.normal.standard_deviations();
        let estimate = ModelEstimate::new(self.sensor.clock(), &fitted, &std, found);
        Ok(BinFit { estimate, parameters: fitted, misfit: settled.misfit })
    }

    fn counts<'f>(&'f self, counts: &'f [f64]) -> BinCounts<'f> {
        let problem = Problem {
            model: &self.model,
            tier: CountingTier::Sampled,
            steps: Vec::new(),
            moment_ps: 0.0,
        };
        BinCounts { fitter: self, problem, counts, light: None }
    }

    /// What the fit says of the expected histogram of the scene's own light, with the bias and
    /// standard deviation of [`BinFitter::scatter_chips`].
    ///
    /// # Errors
    /// As [`BinFitter::fit`].
    pub fn expected(&self) -> Result<ModelEstimate, FitError> {
        let mut fitted = self.fit_means(&MeanResponse::new(&self.model)?.mean_bins())?;
        let scatter = self.scatter_chips()?;
        let [bias_ps, std_ps] =
            [scatter.law.mean, scatter.law.std].map(|c| self.sensor.clock().ps(c));
        fitted.std_m = distance_m(std_ps);
        fitted.paths[0].delay_ps += bias_ps;
        fitted.paths[0].delay_std_ps = std_ps;
        Ok(fitted)
    }

    /// How the likeliest delays scatter round the true one ([`likeliest`]), where its approximations
    /// hold.
    pub(in crate::estimate) fn scatter_chips(&self) -> Result<Likeliest, FitError> {
        let truth = Parameters::of(&Light::of(&self.model));
        let counts = self.counts(&[]);
        let means = counts.problem.response(&truth)?.mean_bins();
        let mut counts = self.counts(&means);
        let here = counts.bins(truth)?;
        let slopes = counts.slopes(&here, true)?;
        let per_period: Vec<f64> = means.iter().map(|mean| mean / self.periods).collect();
        // Where the dead time cannot be taken out, the fit does not need to.
        if let Ok(light) = self.dead_time.correct_means(&per_period, self.periods) {
            coverage::ready_for_fit(&light.ready, self.periods).check()?;
        }
        coverage::enough_photons(&slopes.columns[0], &here.expected).check()?;
        let scatter = Scatter::Poisson(&here.expected);
        let apart = |chips| counts.told_apart(&here, chips);
        let scatter = likeliest(&scatter, slopes.columns, apart)?;
        let scatter = scatter.ok_or_else(|| counts.undetermined(&here))?;
        coverage::of_one_peak(scatter.law.std).check()?;
        Ok(scatter)
    }

    /// Bins of few counts make chi-square scatter more than that of normal numbers does, by
    /// 1 / mean each. As many standard deviations from its expectation, in those of normal
    /// numbers.
    fn chi_square_as_of_normal(&self, chi_square: f64, place: &Bins) -> f64 {
        let degrees = (place.means.len() - place.parameters.len()) as f64;
        let excess: f64 = place.innovations.means().iter().map(|mean| 1.0 / mean).sum();
        degrees + (chi_square - degrees) * (2.0 * degrees / (2.0 * degrees + excess)).sqrt()
    }
}

fn slopes(from: &[f64], to: &[f64], step: f64) -> Vec<f64> {
    differences(to, from).into_iter().map(|difference| difference / step).collect()
}

fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}
