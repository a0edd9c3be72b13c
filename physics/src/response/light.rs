//! The light that a mean response is worked out for.

use std::sync::Arc;

use super::MeanResponseError;
use crate::code::Code;
use crate::photons::{DetectorModel, PulseShape};

/// Primary rates at a detector: the modulated light of each path, and one
/// constant rate that holds everything else.
#[derive(Debug, Clone)]
pub struct Light {
    /// Modulated light, one entry per path that has any.
    pub paths: Vec<LightPath>,
    /// Off-light, background and dark counts, per chip.
    pub constant_per_chip: f64,
}

/// The modulated light of one path.
#[derive(Debug, Clone)]
pub struct LightPath {
    /// The code that keys it.
    pub code: Arc<Code>,
    /// What an on-chip adds to the primary rate, per chip.
    pub rate_per_chip: f64,
    /// Time of flight in chips.
    pub delay_chips: f64,
    /// How the light follows the code.
    pub shape: Arc<PulseShape>,
}

impl Light {
    /// The light that the scene says reaches the detector, path by path in the
    /// scene's order, without those that carry no modulated light. Light of sources
    /// whose clock runs away within a scan is constant on average.
    pub fn of(model: &DetectorModel) -> Light {
        let paths = model.synchronised().map(|light| LightPath {
            code: Arc::clone(&light.code),
            rate_per_chip: light.rate_per_chip,
            delay_chips: light.delay(),
            shape: Arc::clone(&light.shape),
        });
        Light {
            paths: paths.collect(),
            constant_per_chip: model.constant_per_chip + model.slipping_per_chip(),
        }
    }

    /// What one of a detector's cells has of its light, where hits of cells are added up; of any other
    /// detector all.
    #[must_use]
    pub fn of_cell(mut self, model: &DetectorModel) -> Light {
        let share = 1.0 / f64::from(model.added_cells());
        self.constant_per_chip *= share;
        self.paths.iter_mut().for_each(|path| path.rate_per_chip *= share);
        self
    }

    /// Whether every rate and delay is a number that light can have.
    pub(super) fn check(&self) -> Result<(), MeanResponseError> {
        let is_rate = |rate: f64| rate.is_finite() && rate >= 0.0;
        let is_light =
            |path: &LightPath| is_rate(path.rate_per_chip) && path.delay_chips.is_finite();
        match is_rate(self.constant_per_chip) && self.paths.iter().all(is_light) {
            true => Ok(()),
            false => Err(MeanResponseError::NotFinite),
        }
    }

    /// Largest primary rate, with every path's chip on.
    pub fn brightest_per_chip(&self) -> f64 {
        self.constant_per_chip + self.paths.iter().map(|p| p.rate_per_chip).sum::<f64>()
    }
}
