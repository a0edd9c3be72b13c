//! Joint fits of many scans, path by path, and what is found beside them.

use rayon::prelude::*;

use crate::estimate::bound::bound;
use crate::estimate::distance_m;
use crate::estimate::fit::{ALARM_SIGMAS, ModelEstimate};
use crate::report::table::Table;
use crate::scene::{DetectorIndex, EstimatorKind, OtherLight, Scene};
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::repeat::Ranging;
use crate::simulate::scans::scans;
use crate::study::reproduce::phase::Errors;
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

impl Fits {
    /// Simulates `repetitions` scans by a tier, and fits them, told of all light that keeps
    /// the detector's clock.
    ///
    /// # Errors
    /// When the tier cannot do the scene.
    pub fn of(scene: &Scene, tier: Tier, seed: u64, repetitions: u64) -> Result<Fits, RunError> {
        let sensor = Sensor::new(&told_of_all(scene));
        let detector = DetectorIndex(0);
        let mut counted = Vec::new();
        scans(&sensor, detector, tier, seed, repetitions, |counts| {
            counted.push(counts.to_vec());
        })?;
        let ranging = Ranging::new(&sensor, detector, tier.counting());
        let bound = bound(&sensor, detector, tier.counting()).ok();
        let paths = ranging.paths.iter().map(|&path| PathFits {
            errors_m: Vec::new(),
            bound_m: bound.as_ref().and_then(|bound| bound.of_path(path)),
        });
        let paths = paths.collect();
        let mut fits = Fits { scans: repetitions, told: 0, wrong: 0, alarms: 0, paths };
        let fitted: Vec<_> =
            counted.par_iter().map(|counts| ranging.fitter.fit(counts).ok()).collect();
        fitted.iter().flatten().for_each(|fitted| fits.add(&ranging, fitted));
        Ok(fits)
    }

    /// Takes in what one fit says.
    fn add(&mut self, ranging: &Ranging, fitted: &ModelEstimate) {
        self.alarms += u64::from(fitted.alarm_sigmas() > ALARM_SIGMAS);
        let is_wrong = (0..fitted.paths.len()).any(|number| {
            let found = ranging.near(fitted, number).into_iter();
            let off = found.map(|(_, error_m)| error_m.abs()).fold(f64::INFINITY, f64::min);
            off > WRONG_SIGMAS * distance_m(fitted.paths[number].delay_std_ps)
        });
        self.wrong += u64::from(is_wrong);
        let matched = ranging.matched(fitted);
        // All of them, and nothing else.
        if matched.len() == self.paths.len() && fitted.paths.len() == self.paths.len() {
            self.told += 1;
            for (_, place, error_m) in matched {
                self.paths[place].errors_m.push(error_m);
            }
        }
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

/// The scene with a fit that is told of all light.
fn told_of_all(scene: &Scene) -> Scene {
    let (estimator, other_light) = (EstimatorKind::Model, OtherLight::Given);
    Scene { estimator, other_light, ..scene.clone() }
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

/// What an estimator finds of a light, where one quantity has the value `x`.
pub struct Found {
    /// Name of the series.
    pub series: String,
    /// The quantity.
    pub x: f64,
    /// Share of scans that find it.
    found: Measured,
    /// Mean error, in metres.
    pub bias_m: Option<Measured>,
    /// Standard deviation, in metres.
    pub std_m: Option<Measured>,
    /// Cramer-Rao bound, in metres.
    pub bound_m: Option<f64>,
}

impl Found {
    /// By the joint fit, of the path with a number.
    pub fn by_fit(series: String, x: f64, fits: &Fits, path: usize) -> Found {
        let path = &fits.paths[path];
        let (bias_m, std_m) = (path.bias_m(), path.std_m());
        Found { series, x, found: fits.told(), bias_m, std_m, bound_m: path.bound_m }
    }

    /// By the phase; nothing of fewer than two scans.
    pub fn by_phase(series: String, x: f64, errors: Option<Errors>) -> Found {
        let none = Measured::normal(0.0, 0.0);
        let found = errors.map_or(none, |errors| errors.correct_coarse());
        let (bias_m, std_m) = (errors.map(|e| e.bias_m), errors.map(|e| e.std_m));
        Found { series, x, found, bias_m, std_m, bound_m: None }
    }

    /// A row of each, over a column of x.
    pub fn table(x_column: &str, rows: &[Found]) -> Table {
        Table::of(rows)
            .column("series", |row| row.series.as_str())
            .column(x_column, |row| row.x)
            .interval("found", |row| row.found)
            .interval("bias_m", |row| row.bias_m)
            .interval("std_m", |row| row.std_m)
            .column("bound_m", |row| row.bound_m)
            .table()
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::estimate::fit::FittedPath;
    use crate::scene::PathIndex;
    use crate::study::reproduce::sensor::{CHIP_PERIOD_PS, Light, balanced_gold, sensor};

    fn scene() -> Scene {
        let own = balanced_gold(0, 0).expect("a Gold code");
        let other = balanced_gold(1, 0).expect("a Gold code");
        // Out of order, one next to the end of the code's period.
        let delays_chips = [(&own, 40.0), (&other, 7.0), (&own, 0.1)];
        let lights =
            delays_chips.map(|(code, chips)| Light::new(code, 1.0).at(chips * CHIP_PERIOD_PS));
        told_of_all(&sensor(&lights, 1e-3))
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

    /// What one fit says: of every path its error, if it tells them, and whether it is wrong.
    fn said(found: &[(usize, f64)]) -> (Vec<f64>, bool) {
        let scene = scene();
        let sensor = Sensor::new(&scene);
        let ranging = Ranging::new(&sensor, DetectorIndex(0), Tier::Events.counting());
        let paths = (0..3).map(|_| PathFits::default()).collect();
        let mut fits = Fits { scans: 1, told: 0, wrong: 0, alarms: 0, paths };
        fits.add(&ranging, &fitted(&scene, found));
        assert_eq!(fits.alarms, 0);
        (fits.paths.into_iter().flat_map(|path| path.errors_m).collect(), fits.wrong > 0)
    }

    #[test]
    fn paths_are_matched_by_code_and_order_round_the_period() {
        let (errors_m, is_wrong) = said(&[(0, 40.2), (1, 6.9), (2, 2047.0)]);
        assert_eq!((errors_m.len(), is_wrong), (3, false));
        for (error_m, chips) in errors_m.iter().zip([0.2, -0.1, -0.1]) {
            assert!((error_m - chips * distance_m(CHIP_PERIOD_PS)).abs() < 1e-9, "{errors_m:?}");
        }
    }

    #[test]
    fn what_is_missing_or_too_many_is_not_told_and_what_is_off_is_wrong() {
        let verdict = |found: &[(usize, f64)]| {
            let (errors_m, is_wrong) = said(found);
            (!errors_m.is_empty(), is_wrong)
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
