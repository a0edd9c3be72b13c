//! One detector's way from counts to a time of flight, by the scene's estimator.

use std::sync::OnceLock;

use super::chance::Darkness;
use super::fit::{BinFitter, FitError, Fitter, ModelEstimate};
use super::histogram::{NoHistogramEstimate, PhaseOfHistogram};
use super::{
    CountingTier, Estimate, NoEstimate, TheoryEffort, Work, calibration_offset_ps, check_modulated,
    estimate,
};
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::scene::{Architecture, DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

/// The scene's estimator for scans of one detector. What follows from the scene alone is worked out
/// once, when a scan first asks for it; what a scan gives does not depend on which came before.
#[derive(Debug)]
pub struct Estimator<'s> {
    pub sensor: &'s Sensor,
    pub detector: DetectorIndex,
    /// What its hits are counted by.
    pub tier: CountingTier,
    /// Subtracted from the measured delay: everything constant that is not time of flight.
    pub offset_ps: f64,
    /// Whether any modulated light can give an estimate.
    modulated: Result<(), NoEstimate>,
    darkness: OnceLock<Darkness<'s>>,
    fitter: OnceLock<Fitter<'s>>,
    phase_of_bins: OnceLock<PhaseOfHistogram<'s>>,
    fitter_of_bins: OnceLock<Result<BinFitter<'s>, FitError>>,
}

/// What an estimate is made from.
#[derive(Debug, Clone, Copy)]
pub enum EstimatorInput<'c> {
    /// Counts of phase steps, of either architecture.
    Steps(&'c [StepCount]),
    /// The bins of a histogram.
    Bins(&'c Histogram),
}

/// What the scene's estimator says.
#[derive(Debug, Clone)]
pub enum Estimated {
    Phase(Estimate),
    Fit(ModelEstimate),
}

/// Why the scene's estimator says nothing of some counts.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotFound {
    #[error(transparent)]
    Phase(#[from] NoEstimate),
    #[error(transparent)]
    PhaseOfBins(#[from] NoHistogramEstimate),
    #[error(transparent)]
    Fit(#[from] FitError),
    /// Signed counts alone hardly tell how much light there is in all, and with it how far dead time
    /// moves them.
    #[error(
        "the fit needs total counts, and this hardware sends the signed ones alone; total_counts = \
         true, or estimator = \"model\", adds them"
    )]
    NoTotals,
    /// Counts of phase steps are not enough for a histogram sensor's fit.
    #[error("the bins of the histogram do not follow from the counts of phase steps")]
    NoBins,
}

impl<'s> Estimator<'s> {
    /// The estimator of detector `detector`, for counts of tier `tier`.
    pub fn new(sensor: &'s Sensor, detector: DetectorIndex, tier: CountingTier) -> Estimator<'s> {
        Estimator {
            sensor,
            detector,
            tier,
            offset_ps: calibration_offset_ps(sensor, detector, tier),
            modulated: check_modulated(sensor, detector),
            darkness: OnceLock::new(),
            fitter: OnceLock::new(),
            phase_of_bins: OnceLock::new(),
            fitter_of_bins: OnceLock::new(),
        }
    }

    /// With what counts would be without the own light, as another estimator of the same scans knows it.
    #[must_use]
    pub fn knowing_darkness(mut self, darkness: &Darkness) -> Estimator<'s> {
        self.darkness = darkness.of_sensor(self.sensor).into();
        self
    }

    /// Whether modulated light of the own source can reach the detector at all.
    ///
    /// # Errors
    /// Why no scan can give an estimate.
    pub fn check_modulated(&self) -> Result<(), NoEstimate> {
        self.modulated
    }

    /// Share of scans without any light of the own source that have as large counts; see
    /// [`Darkness::chance`].
    ///
    /// # Panics
    /// If a histogram has not one bin per sample of the code.
    pub fn chance(&self, counted: EstimatorInput) -> Option<f64> {
        let of_bins;
        let counts = match counted {
            EstimatorInput::Steps(counts) => counts,
            EstimatorInput::Bins(histogram) => {
                of_bins = self.phase_of_bins().step_counts(histogram);
                &of_bins
            }
        };
        let of_scene = || Darkness::of_scene(self.sensor, self.detector, self.tier);
        self.darkness.get_or_init(of_scene).as_bright_as(counts).chance(counts)
    }

    /// What fits counts of phase steps.
    pub fn fitter(&self) -> &Fitter<'s> {
        let other = self.sensor.scene().other_light;
        self.fitter.get_or_init(|| Fitter::new(self.sensor, self.detector, self.tier, other))
    }

    /// The phase of histograms.
    pub fn phase_of_bins(&self) -> &PhaseOfHistogram<'s> {
        self.phase_of_bins
            .get_or_init(|| PhaseOfHistogram::new(self.sensor, self.detector, self.tier))
    }

    fn fitter_of_bins(&self) -> Result<&BinFitter<'s>, FitError> {
        let fitter = || BinFitter::new(self.sensor, self.detector);
        self.fitter_of_bins.get_or_init(fitter).as_ref().map_err(Clone::clone)
    }

    pub(super) fn is_histogram(&self) -> bool {
        self.sensor.scene().hardware.architecture == Architecture::Histogram
    }

    /// What a scan's counts say.
    ///
    /// # Errors
    /// When they have no peak, or do not suffice.
    ///
    /// # Panics
    /// If a histogram has not one bin per sample of the code.
    pub fn answer(&self, counted: EstimatorInput) -> Result<Estimated, NotFound> {
        self.modulated?;
        let scene = self.sensor.scene();
        Ok(match (scene.estimator, counted) {
            (EstimatorKind::Fft, EstimatorInput::Bins(histogram)) => {
                Estimated::Phase(self.phase_of_bins().estimate(histogram)?)
            }
            (EstimatorKind::Fft, EstimatorInput::Steps(counts)) => {
                let signed: Vec<i64> = counts.iter().map(|count| count.signed).collect();
                Estimated::Phase(estimate(self.sensor.timing(), &signed, self.offset_ps)?)
            }
            (EstimatorKind::Model, EstimatorInput::Bins(histogram)) => {
                Estimated::Fit(self.fitter_of_bins()?.fit(histogram)?)
            }
            (EstimatorKind::Model, EstimatorInput::Steps(_)) if self.is_histogram() => {
                return Err(NotFound::NoBins);
            }
            (EstimatorKind::Model, EstimatorInput::Steps(_)) if !scene.sends_total_counts() => {
                return Err(NotFound::NoTotals);
            }
            (EstimatorKind::Model, EstimatorInput::Steps(counts)) => {
                Estimated::Fit(self.fitter().fit(counts)?)
            }
        })
    }

    /// The fit to the scene's expected counts: the mean of fits to scans, to first order in the noise.
    ///
    /// # Errors
    /// As those of a fit, and when it would take too long.
    pub fn expected_fit(&self) -> Result<ModelEstimate, FitError> {
        if !self.is_histogram() {
            return self.fitter().expected();
        }
        TheoryEffort::of(self.sensor, self.detector)?.check(Work::Histogram)?;
        self.fitter_of_bins()?.expected()
    }

    /// Why the phase leaves range walk in its answer to a histogram, or to its counts of phase steps
    /// (`of_steps`), if it does.
    pub fn walks(&self, of_steps: bool) -> Option<String> {
        if self.sensor.scene().estimator == EstimatorKind::Model || !self.is_histogram() {
            return None;
        }
        match of_steps {
            true => Some(NotFound::NoBins.to_string()),
            false => self.phase_of_bins().walks().map(|reason| reason.to_string()),
        }
    }
}
