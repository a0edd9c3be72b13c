//! Counts without hits, with too few of them, and without any light of the own source.

use super::super::Cause;
use super::super::hypothesis::{SceneChange, SceneFit, Unknown, fit};
use super::super::observed::Observed;
use super::{Diagnosis, Examination, FEWEST_HITS, TestOutcome, chance, critical, family};
use crate::estimate::CountingTier;
use crate::estimate::chance::{Darkness, chance_of_zeros};
use crate::estimate::fit::FitError;

impl Examination<'_> {
    /// The diagnosis of counts that are all 0, where the scene's light leaves some: of darkness if that has none, or
    /// of a detector that does not count.
    pub(super) fn without_hits(&self) -> Result<Option<(Diagnosis, SceneFit)>, FitError> {
        let (sensor, detector) = (self.sensor, self.observed.detector());
        let counts = self.observed.step_counts(sensor);
        if self.observed.values().iter().any(|&value| value != 0.0) {
            return Ok(None);
        }
        let start = SceneChange::default().start(sensor, self.observed)?;
        let nothing = fit(sensor, self.observed, &[], start)?;
        let groups = match self.observed {
            Observed::Steps(_) => counts.len() as f64,
            Observed::Bins(_) => 1.0,
        };
        let has_totals = self.observed.tells_light();
        if chance_of_zeros(nothing.expected.hits(), groups, has_totals) >= family().level() {
            return Ok(None);
        }
        let dark =
            Darkness::of_scene(sensor, detector, CountingTier::Sampled).as_bright_as(&counts);
        if dark.chance_of_zeros(counts.len(), has_totals) >= family().level() {
            return Ok(Some((self.darkness(), nothing)));
        }
        let sentence = "every count is 0, and the scene has hits even in darkness: the detector is off or not connected";
        Ok(Some((Diagnosis::new(&[Cause::NoHits], sentence), nothing)))
    }

    /// No diagnosis: the tests do not keep their level where hits are few.
    pub(super) fn too_few_hits(self, hits: f64) -> (Diagnosis, SceneFit) {
        let of = match self.observed {
            Observed::Steps(_) => "a step",
            Observed::Bins(_) => "all bins",
        };
        let reason = format!(
            "causes: {hits:.1} hits are expected in {of}; from {FEWEST_HITS} on the tests are \
             known to hold"
        );
        let nothing = Diagnosis::new(&[], "no diagnosis: the scan has too few hits");
        (Diagnosis { not_tested: vec![reason], ..nothing }, self.fitted)
    }

    /// The diagnosis of counts that a scene without any light of the own source explains, and better than
    /// the scene does: whatever else is freed would be fitted to noise.
    pub(super) fn without_light(&mut self) -> Option<(Diagnosis, SceneFit)> {
        let detector = self.observed.detector();
        let counts = self.observed.step_counts(self.sensor);
        let (dark, brighter_cps) = Darkness::of_scene(self.sensor, detector, CountingTier::Sampled)
            .as_bright_as(&counts)
            .sensor();
        let start = SceneChange::default().by(Unknown::Constant, brighter_cps);
        let start = start.start(&dark, self.observed).ok()?;
        // Signed counts alone do not tell the background but by their scatter.
        let unknowns: &[Unknown] =
            if self.observed.tells_light() { &[Unknown::Constant] } else { &[] };
        let fitted = fit(&dark, self.observed, unknowns, start).ok()?;
        let gain = self.fitted.agreement.deviance - fitted.agreement.deviance;
        let explains = fitted.p_value.is_none_or(|p| p >= family().level());
        if !explains || gain <= critical() {
            return None;
        }
        let test = TestOutcome::new(Cause::NoLight, gain, Some(chance(gain)), true);
        Some((Diagnosis { tests: vec![test], ..self.darkness() }, fitted))
    }

    /// The diagnosis of counts that a scene without the own light makes.
    fn darkness(&self) -> Diagnosis {
        let sentence = format!(
            "the counts are those of a scene without any light of \"{}\": the beam is blocked, the laser \
             off, or the target out of reach",
            self.scene.sources[self.own()].name
        );
        Diagnosis::new(&[Cause::NoLight], sentence)
    }
}
