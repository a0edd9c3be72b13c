//! Joint fits of many scans, path by path.

use rayon::prelude::*;

use crate::estimate::bound::bound;
use crate::estimate::fit::{ALARM_SIGMAS, FittedPath, Fitter, ModelEstimate};
use crate::estimate::{CountingTier, delay_error_ps, distance_m, tolerance_ps};
use crate::scene::{DetectorIndex, OtherLight, Path, PathIndex, Scene};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::scans::scans;
use crate::study::reproduce::run_error::RunError;
use crate::study::reproduce::statistics::{Measured, rate, sample_mean_of, sample_std};

/// An error of more than so many of the fit's own standard deviations is wrong: noise makes
/// one in 16,000.
const WRONG_SIGMAS: f64 = 4.0;

/// What the fits of a scene's scans say.
#[derive(Debug)]
pub struct Fits {
    /// Scans that were fitted.
    scans: u64,
    /// Those that found every path, each with its code and within a chip.
    told: u64,
    /// Those with a path farther from all true ones of its code than its standard
    /// deviation lets one expect.
    wrong: u64,
    /// Those whose chi-square says that something is not as modelled.
    alarms: u64,
    /// Distances of the scans that found every path, in the scene's order.
    pub paths: Vec<PathFits>,
}

/// What they say of one path.
#[derive(Debug, Default)]
pub struct PathFits {
    errors_m: Vec<f64>,
    /// Cramer-Rao bound, in metres, where there is one.
    pub bound_m: Option<f64>,
}

/// What one fit says.
struct Verdict {
    /// Errors of all paths, if all were found.
    errors_m: Option<Vec<f64>>,
    is_wrong: bool,
    has_alarm: bool,
}

impl Fits {
    /// Simulates `repetitions` scans by a tier, and fits them, told of all light that keeps
    /// the detector's clock.
    ///
    /// # Errors
    /// When the tier cannot do the scene.
    pub fn of(scene: &Scene, tier: Tier, seed: u64, repetitions: u64) -> Result<Fits, RunError> {
        let sensor = Sensor::new(scene);
        let (detector, counting) = (DetectorIndex(0), tier.counting());
        let mut counted = Vec::new();
        scans(&sensor, detector, tier, seed, repetitions, |counts| {
            counted.push(counts.to_vec());
        })?;
        let fitter = Fitter::new(&sensor, detector, counting, OtherLight::Given);
        let truths = Truths::of(&sensor);
        let verdicts: Vec<Option<Verdict>> = counted
            .par_iter()
            .map(|counts| Some(truths.verdict(&fitter.fit(counts).ok()?)))
            .collect();
        let mut fits = Fits {
            scans: repetitions,
            told: 0,
            wrong: 0,
            alarms: 0,
            paths: truths.bounds(&sensor, counting),
        };
        for verdict in verdicts.into_iter().flatten() {
            fits.wrong += u64::from(verdict.is_wrong);
            fits.alarms += u64::from(verdict.has_alarm);
            let Some(errors_m) = verdict.errors_m else {
                continue;
            };
            fits.told += 1;
            for (path, error_m) in fits.paths.iter_mut().zip(errors_m) {
                path.errors_m.push(error_m);
            }
        }
        Ok(fits)
    }

    /// Share of scans that found every path.
    pub fn told(&self) -> Measured {
        rate(self.told, self.scans)
    }

    /// Share of scans with a confident wrong answer.
    pub fn wrong(&self) -> Measured {
        rate(self.wrong, self.scans)
    }

    /// Share of scans whose chi-square raised the alarm.
    pub fn alarms(&self) -> Measured {
        rate(self.alarms, self.scans)
    }
}

impl PathFits {
    /// Mean error, in metres; `None` of fewer than two scans.
    pub fn bias_m(&self) -> Option<Measured> {
        self.of_two_or_more(sample_mean_of)
    }

    /// Standard deviation, in metres; `None` of fewer than two scans.
    pub fn std_m(&self) -> Option<Measured> {
        self.of_two_or_more(sample_std)
    }

    fn of_two_or_more(&self, of: impl Fn(&[f64]) -> Measured) -> Option<Measured> {
        (self.errors_m.len() >= 2).then(|| of(&self.errors_m))
    }
}

/// The paths of a scene that a fit is to find.
struct Truths<'a> {
    scene: &'a Scene,
    paths: Vec<&'a Path>,
    period_ps: f64,
    tolerance_ps: f64,
}

impl<'a> Truths<'a> {
    fn of(sensor: &'a Sensor) -> Truths<'a> {
        let scene = sensor.scene();
        let period_ps = sensor.timing().code_period_ps();
        let has_delay = |path: &&Path| scene.sources[path.source].clock.is_shared();
        Truths {
            paths: scene.paths.iter().filter(has_delay).collect(),
            tolerance_ps: tolerance_ps(scene.chip_period_ps, period_ps),
            period_ps,
            scene,
        }
    }

    fn bounds(&self, sensor: &Sensor, counting: CountingTier) -> Vec<PathFits> {
        let bound = bound(sensor, DetectorIndex(0), counting).ok();
        let of_path = |number: usize| bound.as_ref()?.of_path(PathIndex(number));
        let numbered = self.scene.paths.iter().enumerate();
        let with_delay = numbered.filter(|(_, path)| {
            let source = &self.scene.sources[path.source];
            source.clock.is_shared()
        });
        with_delay
            .map(|(number, _)| PathFits { errors_m: Vec::new(), bound_m: of_path(number) })
            .collect()
    }

    fn has_code(&self, path: &Path, fitted: &FittedPath) -> bool {
        self.scene.sources[path.source].code.chips == fitted.code.chips
    }

    fn error_ps(&self, path: &Path, fitted: &FittedPath) -> f64 {
        delay_error_ps(fitted.delay_ps, path.delay_ps, self.period_ps)
    }

    fn verdict(&self, fitted: &ModelEstimate) -> Verdict {
        let is_wrong = |found: &FittedPath| {
            let of_code = self.paths.iter().filter(|path| self.has_code(path, found));
            let off = of_code.map(|path| self.error_ps(path, found).abs());
            off.fold(f64::INFINITY, f64::min) > WRONG_SIGMAS * found.delay_std_ps
        };
        Verdict {
            errors_m: self.errors_m(fitted),
            is_wrong: fitted.paths.iter().any(is_wrong),
            has_alarm: fitted.alarm_sigmas() > ALARM_SIGMAS,
        }
    }

    /// Errors of all paths; `None` unless all were found, and nothing else.
    fn errors_m(&self, fitted: &ModelEstimate) -> Option<Vec<f64>> {
        if fitted.paths.len() != self.paths.len() {
            return None;
        }
        let mut errors_m = vec![None; self.paths.len()];
        for number in 0..self.paths.len() {
            if errors_m[number].is_none() {
                for (number, error_ps) in self.errors_like_ps(self.paths[number], fitted)? {
                    errors_m[number] = Some(distance_m(error_ps));
                }
            }
        }
        errors_m.into_iter().collect()
    }

    /// Numbers and errors of the paths that have the code of `like`. Of the matchings that
    /// keep the order of delays round the code's period the one whose largest error is
    /// least; `None` if that is beyond a chip.
    fn errors_like_ps(&self, like: &Path, fitted: &ModelEstimate) -> Option<Vec<(usize, f64)>> {
        let chips = &self.scene.sources[like.source].code.chips;
        let is_like = |path: &Path| &self.scene.sources[path.source].code.chips == chips;
        let mut numbers: Vec<usize> =
            (0..self.paths.len()).filter(|&number| is_like(self.paths[number])).collect();
        numbers.sort_by(|&a, &b| self.paths[a].delay_ps.total_cmp(&self.paths[b].delay_ps));
        let of_code = fitted.paths.iter().filter(|path| &path.code.chips == chips);
        let mut found: Vec<&FittedPath> = of_code.collect();
        if found.len() != numbers.len() {
            return None;
        }
        found.sort_by(|a, b| a.delay_ps.total_cmp(&b.delay_ps));
        let turned = (0..found.len()).map(|turn| {
            let pairs = numbers.iter().enumerate();
            let errors = pairs.map(|(place, &number)| {
                let fitted = found[(place + turn) % found.len()];
                (number, self.error_ps(self.paths[number], fitted))
            });
            errors.collect::<Vec<_>>()
        });
        let largest = |errors: &[(usize, f64)]| {
            let sizes = errors.iter().map(|(_, error)| error.abs());
            sizes.fold(0.0, f64::max)
        };
        let best = turned.min_by(|a, b| largest(a).total_cmp(&largest(b)))?;
        (largest(&best) <= self.tolerance_ps).then_some(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::reproduce::sensor::{CHIP_PERIOD_PS, Light, balanced_gold, sensor};
    use std::sync::Arc;

    fn scene() -> Scene {
        let own = balanced_gold(0, 0).expect("a Gold code");
        let other = balanced_gold(1, 0).expect("a Gold code");
        // Out of order, one next to the end of the code's period.
        let delays_chips = [(&own, 40.0), (&other, 7.0), (&own, 0.1)];
        let lights =
            delays_chips.map(|(code, chips)| Light::new(code, 1.0).at(chips * CHIP_PERIOD_PS));
        sensor(&lights, 1e-3)
    }

    fn fitted(scene: &Scene, found: &[(usize, f64)]) -> ModelEstimate {
        let paths: Vec<FittedPath> = found
            .iter()
            .map(|&(path, delay_chips)| FittedPath {
                code: Arc::clone(&scene.sources[scene.paths[PathIndex(path)].source].code),
                delay_ps: delay_chips * CHIP_PERIOD_PS,
                delay_std_ps: 0.05 * CHIP_PERIOD_PS,
                rate_hz: 1e6,
                rate_relative_std: 0.1,
            })
            .collect();
        ModelEstimate {
            delay_ps: paths[0].delay_ps,
            distance_m: 0.0,
            std_m: 0.0,
            velocity: None,
            paths,
            constant_rate_hz: 0.0,
            chi_square: 100.0,
            degrees_of_freedom: 100,
            steps: 60,
            untold: None,
            iterations: 1,
        }
    }

    #[test]
    fn paths_are_matched_by_code_and_order_round_the_period() {
        let scene = scene();
        let sensor = Sensor::new(&scene);
        let truths = Truths::of(&sensor);
        let all = fitted(&scene, &[(0, 40.2), (1, 6.9), (2, 2047.0)]);
        let verdict = truths.verdict(&all);
        let chip_m = distance_m(CHIP_PERIOD_PS);
        let errors_m = verdict.errors_m.expect("all were found");
        for (error_m, chips) in errors_m.iter().zip([0.2, -0.1, -0.1]) {
            assert!((error_m - chips * chip_m).abs() < 1e-9, "{errors_m:?}");
        }
        assert!(!verdict.is_wrong && !verdict.has_alarm);
    }

    #[test]
    fn what_is_missing_or_too_many_is_not_told_and_what_is_off_is_wrong() {
        let scene = scene();
        let sensor = Sensor::new(&scene);
        let truths = Truths::of(&sensor);
        let verdict = |found: &[(usize, f64)]| {
            let verdict = truths.verdict(&fitted(&scene, found));
            (verdict.errors_m.is_some(), verdict.is_wrong)
        };
        assert_eq!(verdict(&[(0, 40.0), (1, 7.0)]), (false, false));
        let more = [(0, 40.0), (0, 41.0), (1, 7.0), (2, 0.1)];
        assert_eq!(verdict(&more), (false, true));
        // The other code's light at an own path's place.
        assert_eq!(verdict(&[(0, 40.0), (2, 7.0), (2, 0.1)]), (false, true));
        // 4.4 standard deviations off, and yet within a chip.
        assert_eq!(verdict(&[(0, 40.22), (1, 7.0), (2, 0.1)]), (true, true));
    }
}
