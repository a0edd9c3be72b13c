//! Codes that explain the counts better than the scene's.

use std::sync::Arc;

use super::super::codes::{self, Candidate};
use super::super::hypothesis::{SceneChange, SceneFit, Unknown, fit};
use super::super::observed::{differences, response};
use super::{Examination, TestOutcome, critical};
use crate::estimate::{CountingTier, calibration_offset_ps};
use crate::photons::DetectorModel;
use crate::scene::SourceIndex;
use crate::sensor::Sensor;

impl Examination<'_> {
    /// The codes that explain the counts better than the scene's, if some do: the best, and
    /// those that do about as well.
    pub(super) fn other_codes(&mut self) -> Vec<(Candidate, SceneFit)> {
        let found =
            codes::search(self.scene, self.observed, &self.observed.step_counts(self.sensor));
        let (candidates, tried) = match found {
            Ok(found) => found,
            Err(reason) => {
                self.not_tested.push(format!("code: {reason}"));
                return Vec::new();
            }
        };
        // As many codes and as many places as were tried.
        let tried = tried as f64 * self.observed.phase_steps() as f64;
        let needed = critical() + 2.0 * tried.ln();
        let fit = |candidate: Candidate| {
            let fitted = self.with_code(&candidate)?;
            let gain = self.fitted.agreement.deviance - fitted.agreement.deviance;
            Some((gain, candidate, fitted))
        };
        let mut fits: Vec<_> = candidates.into_iter().filter_map(fit).collect();
        fits.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Some(best) = fits.first().map(|(gain, ..)| *gain) else {
            return Vec::new();
        };
        self.tests.push(TestOutcome::new(fits[0].1.cause, best, None, best > needed));
        let least = needed.max(best - critical());
        let as_good = fits.into_iter().take_while(|(gain, ..)| *gain > least || *gain == best);
        let as_good = as_good.filter(|_| best > needed);
        as_good.map(|(_, candidate, fitted)| (candidate, fitted)).collect()
    }

    /// The scene with other codes, fitted from where within a chip its means agree best.
    fn with_code(&self, candidate: &Candidate) -> Option<SceneFit> {
        let mut scene = self.scene.clone();
        let own = self.own();
        let mut light = scene.sources[own].clone();
        light.code = Arc::clone(&candidate.light);
        scene.sources[own].code = Arc::clone(&candidate.reference);
        scene.sources.push(light);
        let last = SourceIndex(scene.sources.len() - 1);
        for path in scene.paths.iter_mut().filter(|path| path.source == own) {
            path.source = last;
        }
        let sensor = Sensor::new(&scene);
        let step_ps = sensor.clock().sample_period_ps();
        let offset_ps =
            calibration_offset_ps(&sensor, self.observed.detector(), CountingTier::Sampled);
        let first = scene.paths.iter().find(|path| path.detector == self.observed.detector())?;
        let at_ps = candidate.at_step as f64 * step_ps - offset_ps - first.delay_ps;
        let model = DetectorModel::new(&sensor, self.observed.detector());
        let answer = response(&model).ok()?;
        let agreement = |chips: f64| {
            // The light level that was fitted with a wrong code is useless here.
            let delay_ps = at_ps + sensor.clock().ps(chips);
            let means = self.observed.means(&answer.delayed(delay_ps).ok()?);
            let whitening = self.fitted.expected.whitening(&means).ok()?;
            let residuals = differences(&self.observed.values(), &means);
            let squares = whitening.whitened(&residuals).ok()?.into_iter().map(|z| z * z);
            Some((squares.sum::<f64>(), SceneChange::later(delay_ps)))
        };
        let places = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];
        let agreements = places.into_iter().filter_map(agreement);
        let (_, start) = agreements.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let start = start.start(&sensor, self.observed).ok()?;
        fit(&sensor, self.observed, &[Unknown::Delay, Unknown::Light], start).ok()
    }
}
