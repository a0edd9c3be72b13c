//! From counts to a fit: start, one path, then whatever other light there is.

use std::sync::Arc;

use super::gauss_newton::Fitted;
use super::known_moments::KnownMoments;
use super::problem::{Problem, window};
use super::{FitError, ModelEstimate, OtherLight, search, start};
use crate::estimate::CountingTier;
use crate::photons::{DetectorModel, StepCount};
use crate::response::MeanCount;
use crate::scan::Step;
use crate::sensor::Sensor;

/// Fits the scans of one detector. Second moments that one scan needed are kept for
/// the next; what a scan gives does not depend on which came before.
#[derive(Debug)]
pub struct Fitter<'s> {
    sensor: &'s Sensor,
    detector: usize,
    tier: CountingTier,
    other: OtherLight,
    model: DetectorModel,
    moments: KnownMoments,
}

impl<'s> Fitter<'s> {
    /// A fitter for scans of detector `detector`.
    ///
    /// # Panics
    /// If the scene has no such detector.
    pub fn new(
        sensor: &'s Sensor,
        detector: usize,
        tier: CountingTier,
        other: OtherLight,
    ) -> Fitter<'s> {
        Fitter {
            sensor,
            detector,
            tier,
            other,
            model: DetectorModel::new(sensor, detector),
            moments: KnownMoments::default(),
        }
    }

    /// Fits the counts of one scan.
    ///
    /// Starts from the phase at the place that looks most like the code's peak,
    /// and the rate of detections; other light starts from where the residual of
    /// the fit so far correlates with its code.
    ///
    /// # Errors
    /// When the counts have no peak, or do not suffice for the unknowns, or the
    /// mean response cannot be had.
    pub fn fit(&self, counts: &[StepCount]) -> Result<ModelEstimate, FitError> {
        let counts: Vec<MeanCount> = counts
            .iter()
            .map(|count| MeanCount {
                signed: count.signed as f64,
                total: count.total as f64,
            })
            .collect();
        self.fit_means(&counts)
    }

    /// The same for counts that need not be whole, one per step of the scan.
    ///
    /// # Errors
    /// As [`Fitter::fit`].
    pub fn fit_means(&self, counts: &[MeanCount]) -> Result<ModelEstimate, FitError> {
        let (sensor, detector) = (self.sensor, self.detector);
        if counts.len() as u64 != sensor.timing().scan.steps {
            return Err(FitError::WrongNumberOfCounts {
                found: counts.len(),
                steps: sensor.timing().scan.steps,
            });
        }
        let start = start::start(sensor, detector, self.tier, counts)?;
        let first = Problem {
            model: &self.model,
            tier: self.tier,
            codes: vec![Arc::clone(
                &sensor.scene().sources[sensor.scene().detectors[detector].reference].code,
            )],
            steps: window(
                &sensor.timing().scan,
                sensor.clock().samples_per_chip,
                start.peak,
            ),
        };
        let wanted = search::wanted(sensor, detector, self.other)?;
        let mut fitted = Fitted::new(&first, &self.moments, start.parameters, counts)?;
        if wanted.is_empty() {
            return Ok(fitted.estimate(&first));
        }
        if !sensor.timing().scan.is_full() {
            return Err(FitError::NeedsWholeScan {
                steps: sensor.timing().scan.steps,
                steps_per_period: sensor.timing().scan.steps_per_period,
            });
        }
        let mut problem = Problem {
            steps: Step::all(sensor.timing().scan.steps).collect(),
            ..first
        };
        for candidates in wanted {
            let Some(found) = search::strongest(
                sensor,
                detector,
                &problem,
                &fitted.parameters,
                counts,
                &candidates,
            )?
            else {
                break;
            };
            problem.codes.push(found.code);
            let mut parameters = fitted.parameters.clone();
            parameters.add_path(found.path, &problem);
            fitted = Fitted::new(&problem, &self.moments, parameters, counts)?;
        }
        Ok(fitted.estimate(&problem))
    }
}
