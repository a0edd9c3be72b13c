//! The model estimator on a histogram: delay and strength of the path, and the constant
//! light, fitted to its bins.
//!
//! A bin is a Poisson number whose mean follows from the bins before it
//! ([`Innovations`]): this gives the likelihood of 16,376 bins in the time that it takes to read them,
//! and holds even if hardly any bin counts at all.

use super::error::FitError;
use super::likeliest::{Likeliest, PathSlopes, Scatter, likeliest, photons_that_tell};
use super::model_estimate::{Goodness, ModelEstimate};
use super::normal::Normal;
use super::parameters::{DELAY_STEP_CHIPS, FitParameters};
use super::problem::Problem;
use super::scoring::{Counts, Settling, Slopes, likeliest_of, settle};
use super::start;
use crate::estimate::dead_time::{dead_time, periods};
use crate::estimate::phase::first_maximum;
use crate::estimate::{CountingTier, coverage};
use crate::histogram::Histogram;
use crate::histogram::correction::{BinnedDetector, PrimaryLight};
use crate::histogram::correlation::HistogramCorrelator;
use crate::histogram::innovations::{Given, Innovations, deviance};
use crate::photons::DetectorModel;
use crate::response::{Light, MeanCount, MeanResponse};
use crate::scene::{DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// A fit whose chi-square is so many standard deviations too large is tried again from other
/// starts, so many chips from the first.
const RETRIED_SIGMAS: f64 = 2.0;
const OTHER_STARTS_CHIPS: [f64; 6] = [-0.25, 0.25, -0.5, 0.5, -1.0, 1.0];

/// Up to so many detections of a ready detector in a bin what a bin counts is linear in its light, and
/// derivatives by that need no other solution: a test holds those of somewhat less within a tenth.
const MOST_HAZARD: f64 = 0.2;

/// Bins by which a fit is moved to see whether that is likelier.
const OTHER_BINS: [f64; 6] = [-1.0, -0.5, -0.25, 0.25, 0.5, 1.0];

/// Where a fit has settled.
struct BinFit<'m> {
    estimate: ModelEstimate,
    place: Bins<'m>,
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
    correlator: HistogramCorrelator,
    dead_time: BinnedDetector,
    periods: f64,
}

/// Light that bins may come from.
struct Bins<'m> {
    parameters: FitParameters,
    response: MeanResponse<'m>,
    innovations: Innovations,
    means: Vec<f64>,
    given: Given,
    /// Standard deviations of the bins, given those before.
    stds: Vec<f64>,
}

/// A histogram that is fitted.
struct BinCounts<'f> {
    fitter: &'f BinFitter<'f>,
    problem: Problem<'f>,
    counts: &'f [f64],
}

impl<'f> Counts for BinCounts<'f> {
    type Point = Bins<'f>;
    type Error = FitError;

    fn residuals(&self, here: &Bins<'f>) -> Result<Vec<f64>, FitError> {
        Ok(in_stds(differences(self.counts, &here.given.expected), here))
    }

    fn misfit(&self, here: &Bins<'f>, _residuals: &[f64]) -> f64 {
        deviance(self.counts, &here.given.expected)
    }

    fn slopes(&mut self, here: &Bins<'f>, anew: bool) -> Result<Slopes, FitError> {
        let at = |chips| Ok::<_, FitError>(self.later(here, chips)?.mean_bins());
        let (early, late) = (at(-DELAY_STEP_CHIPS)?, at(DELAY_STEP_CHIPS)?);
        let by_delay = slopes(&early, &late, 2.0 * DELAY_STEP_CHIPS);
        let by_delay = here.innovations.growth(&here.given, &by_delay)?;
        let are_best = anew || here.innovations.most_hazard() > MOST_HAZARD;
        let [by_strength, by_constant] = match are_best {
            true => [self.light_column(here, 1)?, self.light_column(here, 2)?],
            false => {
                let constant = here.parameters.constant;
                let all = constant + here.parameters.paths[0].mean_rate();
                here.innovations.growth_by_light(&here.given, constant, all)?
            }
        };
        let columns = [by_delay, by_strength, by_constant].map(|column| in_stds(column, here));
        Ok(Slopes { columns: columns.into(), are_best })
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
    fn bins(&self, parameters: FitParameters) -> Result<Bins<'f>, FitError> {
        let response = self.problem.response(&parameters)?;
        let means = response.mean_bins();
        let (innovations, given) = self.given(&means)?;
        let stds = given.expected.iter().map(|mean| mean.sqrt()).collect();
        Ok(Bins { parameters, response, innovations, means, given, stds })
    }

    /// What every bin of some means is expected to count, given those before.
    fn given(&self, means: &[f64]) -> Result<(Innovations, Given), FitError> {
        let innovations = Innovations::new(self.fitter.dead_time, means, self.fitter.periods)?;
        let given = innovations.given(self.counts, &differences(self.counts, means))?;
        Ok((innovations, given))
    }

    /// The same light some chips later.
    fn later(&self, here: &Bins<'f>, chips: f64) -> Result<MeanResponse<'f>, FitError> {
        Ok(here.response.delayed(self.problem.clock().ps(chips))?)
    }

    /// What its bins are expected to count.
    fn expected_later(&self, here: &Bins<'f>, chips: f64) -> Result<Vec<f64>, FitError> {
        Ok(self.given(&self.later(here, chips)?.mean_bins())?.1.expected)
    }

    /// Derivative by the logarithm of the strength, or by the constant light, of any light.
    fn light_column(&self, here: &Bins, index: usize) -> Result<Vec<f64>, FitError> {
        let (nudged, step) = here.parameters.nudged(index, 1.0);
        let there = self.given(&self.problem.response(&nudged)?.mean_bins())?.1;
        Ok(slopes(&here.given.expected, &there.expected, step))
    }

    /// How far bins of light `chips` later are from what they are, in standard deviations of each.
    fn told_apart(&self, here: &Bins<'f>, chips: f64) -> Result<Vec<f64>, FitError> {
        let later = self.expected_later(here, chips)?;
        Ok(in_stds(differences(&later, &here.given.expected), here))
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
            correlator: HistogramCorrelator::new(code, sensor.clock().samples_per_chip),
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
    /// is that of the light without dead time and afterpulses, if it can be had. Phase steps
    /// count the same light here, so that the largest of them is the best match.
    fn start(
        &self,
        counts: &[f64],
        light: Option<PrimaryLight>,
    ) -> Result<FitParameters, FitError> {
        let total = counts.iter().sum();
        let signed = self.correlator.correlate(counts);
        let steps: Vec<MeanCount> =
            signed.iter().map(|&signed| MeanCount { signed, total }).collect();
        let corrected = light.map(|light| self.correlator.correlate(&light.per_period));
        let values = corrected.unwrap_or(signed);
        let peak = first_maximum(&values);
        let tier = CountingTier::Sampled;
        Ok(start::start(self.sensor, self.detector, tier, &steps, (&values, peak))?)
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
    fn likelier(&self, counts: &[f64], here: &BinFit) -> Result<Vec<FitParameters>, FitError> {
        let problem = self.counts(counts);
        let mut found = Vec::new();
        for bins in OTHER_BINS {
            let chips = bins * self.sensor.clock().sample_period_chips();
            if deviance(counts, &problem.expected_later(&here.place, chips)?) < here.misfit {
                found.push(here.place.parameters.later(chips));
            }
        }
        Ok(found)
    }

    fn settle<'f>(
        &'f self,
        counts: &'f [f64],
        start: FitParameters,
    ) -> Result<BinFit<'f>, FitError> {
        let mut counts = self.counts(counts);
        let start = counts.bins(start)?;
        let settled = settle(&mut counts, start, Settling::FINE)?;
        if !settled.has_settled {
            return Err(FitError::NotConverged { steps: settled.steps });
        }
        let place = settled.place;
        let deviations = differences(counts.counts, &place.means);
        let residuals = place.innovations.whitened(&deviations)?;
        let chi_square = residuals.iter().map(|r| r * r).sum();
        let fitted = place.parameters.moved(&settled.step);
        let found = Goodness {
            chi_square: self.chi_square_as_of_normal(chi_square, &place),
            degrees_of_freedom: place.means.len() - fitted.len(),
            steps: place.means.len(),
            iterations: settled.steps,
            most_correlated: 0.0,
        };
        let std = settled.normal.standard_deviations();
        let estimate = ModelEstimate::new(self.sensor.clock(), &fitted, &std, found);
        Ok(BinFit { estimate, place, misfit: settled.misfit })
    }

    fn counts<'f>(&'f self, counts: &'f [f64]) -> BinCounts<'f> {
        let problem = Problem {
            model: &self.model,
            tier: CountingTier::Sampled,
            steps: Vec::new(),
            moment_ps: 0.0,
        };
        BinCounts { fitter: self, problem, counts }
    }

    /// What the fit says of the expected histogram of the scene's own light, with the bias and
    /// standard deviation of [`BinFitter::scatter_chips`].
    ///
    /// # Errors
    /// As [`BinFitter::fit`].
    pub fn expected(&self) -> Result<ModelEstimate, FitError> {
        let fitted = self.fit_means(&MeanResponse::new(&self.model)?.mean_bins())?;
        Ok(fitted.scattered_by(self.sensor.clock(), self.scatter_chips()?.law))
    }

    /// How the likeliest delays scatter round the true one ([`likeliest`]), where its approximations
    /// hold.
    pub(in crate::estimate) fn scatter_chips(&self) -> Result<Likeliest, FitError> {
        let truth = FitParameters::of(&Light::of(&self.model));
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
        // A signed count's variance is the number of detections.
        coverage::check_slipping(&self.model, CountingTier::Sampled, means.iter().sum())?;
        let photons = photons_that_tell(&slopes.columns[0], &here.given.expected);
        coverage::enough_photons(photons).check()?;
        let scatter = Scatter::Poisson(&here.given.expected);
        let apart = |chips| counts.told_apart(&here, chips);
        let found_within = counts.problem.found_within_chips();
        let scatter =
            likeliest(&scatter, PathSlopes::of_path(slopes.columns, 0), found_within, apart)?;
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

/// Numbers of bins in standard deviations of each.
fn in_stds(mut numbers: Vec<f64>, here: &Bins) -> Vec<f64> {
    numbers.iter_mut().zip(&here.stds).for_each(|(number, std)| *number /= std);
    numbers
}

fn slopes(from: &[f64], to: &[f64], step: f64) -> Vec<f64> {
    differences(to, from).into_iter().map(|difference| difference / step).collect()
}

fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::SeedableRng;
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::scene::load_with;

    /// Held against differences of what scattered bins are expected to count in other light: dim, nearly as bright as
    /// `MOST_HAZARD`, and brighter, where derivatives by light are such differences.
    #[test]
    fn slopes_are_those_of_what_bins_are_expected_to_count() {
        for (power, most_off) in [("2 pW", 0.02), ("60 pW", 0.1), ("300 pW", 0.03)] {
            let settings = [
                "hardware.architecture=histogram".to_owned(),
                format!("source.mean_power={power}"),
            ];
            let settings: Vec<_> = settings.iter().map(|s| s.parse().expect("sound")).collect();
            let scene = load_with(Path::new("../scenes/quick.toml"), &settings).expect("sound");
            let sensor = Sensor::new(&scene);
            let fitter = BinFitter::new(&sensor, DetectorIndex(0)).expect("one path");
            let truth = FitParameters::of(&Light::of(&fitter.model));
            let response = fitter.counts(&[]).problem.response(&truth).expect("solved");
            // From one standard deviation below to one above.
            let scattered = |(bin, mean): (usize, f64)| {
                let by = f64::from(bin as u32 * 7_919 % 13) / 6.0 - 1.0;
                (mean + by * mean.sqrt()).max(0.0).round()
            };
            let counts: Vec<f64> =
                response.mean_bins().into_iter().enumerate().map(scattered).collect();
            let mut counts = fitter.counts(&counts);
            let here = counts.bins(truth.clone()).expect("there are some");
            let found = counts.slopes(&here, false).expect("there are some");
            assert_eq!(found.are_best, power == "300 pW");
            for (index, found) in found.columns.iter().enumerate() {
                let [below, above] = [-1.0, 1.0].map(|by| {
                    let (light, step) = truth.nudged(index, by);
                    (counts.bins(light).expect("there are some").given.expected, step)
                });
                let exact = slopes(&below.0, &above.0, above.1 - below.1).into_iter();
                let exact: Vec<f64> =
                    exact.zip(&here.given.expected).map(|(by, mean)| by / mean.sqrt()).collect();
                let norm = |of: &[f64]| of.iter().map(|x| x * x).sum::<f64>().sqrt();
                let off = norm(&differences(&exact, found)) / norm(&exact);
                assert!(off < most_off, "{power}, unknown {index}: {off}");
            }
        }
    }

    /// Of few code periods of bright light, and without background between a code's ones, some bins are expected to count
    /// less than nothing, given those before. They tell nothing of the delay: fits are about as precise as the bound.
    #[test]
    fn bins_that_cannot_count_tell_nothing() {
        let bright =
            ["source.code.degree=9", "source.mean_power=200 pW", "scan.integration=286.16 us"];
        let dark = [
            "source.code.degree=5",
            "source.mean_power=40 pW",
            "source.extinction_ratio=1e9",
            "detector.dark_count_rate=0 cps",
            "scan.integration=74.4 us",
        ];
        for settings in [&dark[..], &bright[..]] {
            fits_are_as_precise_as_the_bound(settings);
        }
    }

    fn fits_are_as_precise_as_the_bound(settings: &[&str]) {
        let settings = settings.iter().chain(&["hardware.architecture=histogram"]);
        let settings: Vec<_> = settings.map(|s| s.parse().expect("sound")).collect();
        let scene = Path::new("../scenes/paper-single.toml");
        let sensor = Sensor::new(&load_with(scene, &settings).expect("sound"));
        let fitter = BinFitter::new(&sensor, DetectorIndex(0)).expect("one path");
        let bound_m = fitter.expected().expect("there is a bound").std_m;
        let means = MeanResponse::new(&fitter.model).expect("solved").mean_bins();
        let bins = Innovations::new(fitter.dead_time, &means, fitter.periods).expect("sound");
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        for scan in 0..6 {
            let counts: Vec<f64> = bins.draw(&mut rng).into_iter().map(|n| n as f64).collect();
            let std_m = fitter.fit_means(&counts).expect("it settles").std_m;
            assert!((std_m / bound_m - 1.0).abs() < 0.25, "{scan}: {std_m} {bound_m}");
        }
    }
}
