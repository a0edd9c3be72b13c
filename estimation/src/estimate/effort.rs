//! The effort of theory: what would take too long is refused before the work.

use super::fit::likeliest::DELAYS as LIKELIEST_DELAYS;
use super::fit::moments::few_steps;
use super::fit::problem::STEPS_ONE_BY_ONE;
use crate::photons::DetectorModel;
use crate::response::{Effort, Light, MeanResponseError};
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Predictions of all detectors of a scene take no longer than this on one core,
/// and bounds no longer again.
const LIMIT_S: f64 = 2.0;
/// A fit of one scan that is expected to take longer on one core is refused. Under light
/// that all but blinds a detector it has taken up to three times what is expected.
const LONGEST_FIT_S: f64 = 20.0;
/// Most memory that is taken.
const LIMIT_BYTES: f64 = 1e9;
/// One step's part in a path's prediction beside its moments.
const STEP_OF_PATH_S: f64 = 60e-9;
/// Turns of a fit until it settles, about.
const TURNS: f64 = 6.0;
/// One product of two derivatives.
const DERIVATIVES_S: f64 = 4e-9;

/// A piece of work.
#[derive(Debug, Clone, Copy)]
pub enum Work {
    /// One response, and the mean counts.
    Response,
    /// The phase's predictions for so many paths.
    Predictions(usize),
    /// The Cramer-Rao bound.
    Bound,
    /// The likelihood of other delays beside it.
    Likelihood,
    /// A fit.
    Fit,
    /// A histogram's expectation, its phase and a fit to it.
    Histogram,
    /// What counts are drawn from.
    Draws,
}

/// The effort of theory for one detector.
#[derive(Debug, Clone, Copy)]
pub struct TheoryEffort {
    effort: Effort,
    steps: f64,
    samples_per_chip: f64,
    /// Paths with modulated light.
    paths: f64,
    /// Paths with light that fluctuate.
    fluctuating: f64,
    moves: bool,
    /// Steps that count the same light.
    parallel: f64,
    limit_s: f64,
}

impl TheoryEffort {
    /// What it takes with the scene's own light.
    ///
    /// # Errors
    /// As for the mean response.
    pub fn of(sensor: &Sensor, detector: DetectorIndex) -> Result<TheoryEffort, MeanResponseError> {
        let still = sensor.still_at(0.0);
        let model = DetectorModel::new(&still, detector);
        let light = Light::of(&model).of_cell(&model);
        let of_detector = || sensor.scene().paths.iter().filter(|p| p.detector == detector);
        Ok(TheoryEffort {
            effort: Effort::of(&model, &light)?,
            steps: sensor.timing().scan.steps as f64,
            samples_per_chip: f64::from(sensor.clock().samples_per_chip),
            paths: light.paths.len() as f64,
            fluctuating: of_detector().filter(|p| p.delay_std_ps() > 0.0).count() as f64,
            moves: of_detector().any(|p| p.movement.is_some()),
            parallel: f64::from(sensor.timing().parallel),
            limit_s: LIMIT_S / sensor.scene().detectors.len() as f64,
        })
    }

    /// Seconds that some work takes of one core; of the bound, beside the predictions.
    pub fn seconds(&self, work: Work) -> f64 {
        let of = &self.effort;
        let unknowns = 2.0 * self.paths + 1.0;
        let products_s = self.steps * unknowns * unknowns * DERIVATIVES_S;
        match work {
            Work::Response => of.response_s + of.counts_s,
            Work::Predictions(paths) => self.predictions_s(paths as f64),
            Work::Fit if self.moves => {
                TURNS * self.moving_s() + of.moments_s + self.covariances_s()
            }
            // Some turns, and the second moments.
            Work::Fit => {
                TURNS * ((unknowns + 1.0) * (of.response_s + of.counts_s) + products_s)
                    + of.moments_s
                    + self.covariances_s()
            }
            Work::Bound if self.moves => self.moving_s() + of.moments_s + self.covariances_s(),
            Work::Bound => {
                2.0 * unknowns * (of.response_s + of.counts_s) + self.covariances_s() + products_s
            }
            Work::Likelihood => {
                // With other light beside it no response is another one's, delayed.
                let response_s = if self.paths > 1.0 { of.response_s } else { of.delayed_s };
                let delays = self.paths * f64::from(LIKELIEST_DELAYS);
                delays * (response_s + of.counts_s + products_s)
            }
            Work::Histogram => {
                let delayed_s = f64::from(LIKELIEST_DELAYS) * of.counts_s;
                (unknowns + TURNS) * of.response_s + delayed_s + of.moments_s + of.step_s
            }
            Work::Draws => of.response_s + of.moments_s + of.scan_s,
        }
    }

    fn predictions_s(&self, paths: f64) -> f64 {
        let of = &self.effort;
        let window = 2.0 * self.samples_per_chip;
        let solution_s = of.response_s + of.counts_s + of.moments_s;
        let path_s = self.steps * STEP_OF_PATH_S + (window + 1.0) * of.step_s;
        if !self.moves {
            let steps = (paths * (window + 1.0)).min(self.steps);
            return solution_s + steps * of.step_s + paths * self.steps * STEP_OF_PATH_S;
        }
        // Each step of the window has a response of its own, and two for each
        // path that fluctuates.
        let step_s = of.response_s + of.moments_s + of.step_s;
        let nudged_s = 2.0 * self.fluctuating * (of.response_s + of.count_s);
        let true_delay_s = 2.0 * self.steps * STEP_OF_PATH_S;
        paths * (true_delay_s + solution_s + path_s + window * (step_s + nudged_s))
    }

    /// Seconds that the covariances of fit and bound take.
    fn covariances_s(&self) -> f64 {
        let of = &self.effort;
        let (samples, parallel) = (self.samples_per_chip, self.parallel);
        let is_long = self.steps > STEPS_ONE_BY_ONE as f64;
        let steps = match (is_long, parallel <= 1.0) {
            _ if self.moves => 3.0 * samples,
            (false, true) => return of.scan_s,
            (false, false) => self.steps,
            (true, _) => few_steps(samples as u32, parallel as u32, self.paths).min(self.steps),
        };
        let pairs = 0.5 * steps * (parallel - 1.0).min(steps);
        steps * of.step_s + pairs * of.pair_s
    }

    /// Seconds that expectation and derivatives of a path that moves take: two places of
    /// each step, five times.
    fn moving_s(&self) -> f64 {
        let of = &self.effort;
        let steps = 2.0 * 3.0 * self.samples_per_chip;
        5.0 * (of.response_s + steps * (of.delayed_s + of.count_s))
    }

    /// Refuses what takes too long, or too much memory.
    ///
    /// # Errors
    /// With how long it would take, and the limit.
    pub fn check(&self, work: Work) -> Result<(), MeanResponseError> {
        self.check_within(work, self.limit_s)
    }

    /// The same with a limit of its own.
    ///
    /// # Errors
    /// As there.
    pub fn check_within(&self, work: Work, limit_s: f64) -> Result<(), MeanResponseError> {
        if self.effort.bytes > LIMIT_BYTES {
            return Err(MeanResponseError::TooMuchMemory {
                gigabytes: self.effort.bytes / 1e9,
                limit_gigabytes: LIMIT_BYTES / 1e9,
            });
        }
        let seconds = self.seconds(work);
        match seconds > limit_s {
            true => Err(MeanResponseError::TooMuchWork { seconds, limit_s }),
            false => Ok(()),
        }
    }

    /// How long a fit of one scan takes and the longest that is done, if it takes longer.
    pub fn too_long_fit(&self) -> Option<(f64, f64)> {
        let seconds = self.seconds(Work::Fit);
        (seconds > LONGEST_FIT_S).then_some((seconds, LONGEST_FIT_S))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::CountingTier;
    use crate::estimate::fit::{Fitter, OtherLight};
    use crate::estimate::theory;
    use crate::photons::StepCount;
    use crate::scene::{PathIndex, Scene, extreme, load, load_with};

    /// Scenes at the ends of every range: what they take is said at once, in finite numbers, and
    /// what is said to be little ends.
    #[test]
    fn theory_of_extreme_scenes_ends() {
        let (mut refused, mut solved) = (0, 0);
        for (settings, scene) in extreme::scenes(200) {
            let sensor = Sensor::new(&scene);
            let Ok(effort) = TheoryEffort::of(&sensor, DetectorIndex(0)) else {
                refused += 1;
                continue;
            };
            let seconds = effort.seconds(Work::Predictions(1)) + effort.seconds(Work::Bound);
            assert!(seconds.is_finite() && effort.effort.bytes.is_finite(), "{settings:?}");
            if effort.check(Work::Predictions(1)).is_err() {
                refused += 1;
            } else if seconds < 0.05 {
                solved += 1;
                let theory =
                    theory(&sensor, DetectorIndex(0), &[PathIndex(0)], CountingTier::Sampled);
                for prediction in theory.predictions.iter().flatten() {
                    assert!(prediction.std_m.is_finite() && prediction.std_m >= 0.0);
                }
            }
        }
        assert!(refused > 20 && solved > 20, "{refused} {solved}");
    }

    /// The range of a path's delay does not change what theory takes.
    #[test]
    fn far_paths_take_as_long_as_near_ones() {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
        let bytes = ["3 m", "20 km", "1e9 m"].map(|distance| {
            let setting = format!("path.distance={distance}").parse().expect("a setting");
            let scene = load_with(&file, &[setting]).expect("it is sound");
            let effort = TheoryEffort::of(&Sensor::new(&scene), DetectorIndex(0));
            effort.expect("a response").effort.bytes
        });
        assert!(bytes.iter().all(|found| (found / bytes[0] - 1.0).abs() < 0.5), "{bytes:?}");
    }

    /// The article's sensor, under so many times its light.
    fn brighter(times: f64) -> Scene {
        let file =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/paper-single.toml");
        let mut scene = load(&file).expect("it is sound");
        scene.sources[0].mean_power_w *= times;
        scene
    }

    /// With 4.9 million primary detections a second: a thousand million are fitted, as slow
    /// as that is, and a blinding light is refused.
    #[test]
    fn fits_are_done_up_to_a_stated_time() {
        let of = |times: f64| {
            let effort = TheoryEffort::of(&Sensor::new(&brighter(times)), DetectorIndex(0));
            effort.expect("a response")
        };
        for times in [1.0, 200.0, 600.0] {
            assert_eq!(of(times).too_long_fit(), None, "{times}");
        }
        let (seconds, limit_s) = of(1500.0).too_long_fit().expect("it is refused");
        assert!(seconds > 2.0 * limit_s && limit_s == 20.0, "{seconds} {limit_s}");
    }

    /// The fit itself says so, before any work.
    #[test]
    fn a_fit_to_blinding_light_is_refused_at_once() {
        let sensor = Sensor::new(&brighter(1500.0));
        let fitter =
            Fitter::new(&sensor, DetectorIndex(0), CountingTier::Sampled, OtherLight::Given);
        let count = StepCount { signed: 3, total: 5 };
        let counts = vec![count; sensor.timing().scan.steps as usize];
        let refused = fitter.fit(&counts).expect_err("it is refused").to_string();
        assert!(refused.contains("no more than 20 s is spent"), "{refused}");
    }
}
