//! What the joint fit makes of many scans of one scene.

use std::time::Instant;

use goldtof::code::Code;
use goldtof::estimate::bound::bound;
use goldtof::estimate::fit::{
    ALARM_SIGMAS, FitError, FittedPath, Fitter, ModelEstimate, OtherLight,
};
use goldtof::estimate::{delay_error_ps, distance_m};
use goldtof::photons::{DetectorModel, StepCount};
use goldtof::response::{CountSampler, MeanResponse, SecondMoments};
use goldtof::scene::{DetectorIndex, PathIndex, Scene};
use goldtof::sensor::Sensor;
use goldtof::simulate::{self, Tier};
use rayon::prelude::*;

use crate::{Outcome, TIER};

/// An error of more than so many of the fit's own standard deviations is wrong.
const WRONG_SIGMAS: f64 = 4.0;

/// Scans behind each line: GOLDTOF_SCANS, 40 where that is not said.
pub fn scans() -> u64 {
    let asked = std::env::var("GOLDTOF_SCANS").ok();
    asked.and_then(|asked| asked.parse().ok()).unwrap_or(40)
}

/// What the fits of one scene's scans say.
pub struct Told {
    scans: u64,
    /// No estimate at all: for want of own light, or for another reason.
    not_seen: u64,
    refused: u64,
    /// Those that say that a path is missing.
    pub untold: u64,
    /// Those that found light that is not there.
    more: u64,
    /// Those with a path off by more than noise.
    wrong: u64,
    alarms: u64,
    milliseconds: f64,
    pub paths: Vec<PathTold>,
}

/// What they say of one path.
#[derive(Default)]
pub struct PathTold {
    errors_m: Vec<f64>,
    /// Errors of scans that do not say that a path is missing, and squares of the fits' own
    /// standard deviations.
    unwarned: Vec<[f64; 2]>,
    bound_m: Option<f64>,
}

impl Told {
    /// Fits scans of exact moments.
    pub fn of(scene: &Scene, other: OtherLight, scans: u64) -> Outcome<Told> {
        let sensor = Sensor::new(scene);
        let model = DetectorModel::new(&sensor, DetectorIndex(0));
        let response = MeanResponse::of_tier(&model, TIER)?;
        let second = SecondMoments::new(&response)?;
        let sampler = CountSampler::of(&model, &second).expect("finite moments");
        Told::of_scans(scene, other, scans, |scan| sampler.scan(7, scan))
    }

    /// Fits scans of photons.
    pub fn of_photons(scene: &Scene, other: OtherLight, scans: u64) -> Outcome<Told> {
        let sensor = Sensor::new(scene);
        let mut counted = Vec::new();
        simulate::scans::scans(&sensor, DetectorIndex(0), Tier::Events, 7, scans, |counts| {
            counted.push(counts.to_vec());
        })?;
        Told::of_scans(scene, other, scans, |scan| counted[scan as usize].clone())
    }

    fn of_scans(
        scene: &Scene,
        other: OtherLight,
        scans: u64,
        counts: impl Fn(u64) -> Vec<StepCount> + Sync,
    ) -> Outcome<Told> {
        let sensor = Sensor::new(scene);
        let fitter = Fitter::new(&sensor, DetectorIndex(0), TIER, other);
        let start = Instant::now();
        let fits: Vec<Result<ModelEstimate, FitError>> =
            (0..scans).into_par_iter().map(|scan| fitter.fit(&counts(scan))).collect();
        let threads = rayon::current_num_threads() as f64;
        // A bound of very bright light is refused; errors are then without a measure.
        let bound = bound(&sensor, DetectorIndex(0), TIER).ok();
        let of_path = |path: PathIndex| PathTold {
            bound_m: bound.as_ref().and_then(|bound| bound.of_path(path)),
            ..PathTold::default()
        };
        let mut told = Told {
            scans,
            not_seen: 0,
            refused: 0,
            untold: 0,
            more: 0,
            wrong: 0,
            alarms: 0,
            milliseconds: start.elapsed().as_secs_f64() * 1e3 * threads / scans as f64,
            paths: PathIndex::of(&scene.paths).map(of_path).collect(),
        };
        for fitted in fits {
            match fitted {
                Ok(fitted) => told.take(scene, &sensor, &fitted),
                Err(FitError::OwnNotSeen { .. }) => told.not_seen += 1,
                Err(_) => told.refused += 1,
            }
        }
        Ok(told)
    }

    fn take(&mut self, scene: &Scene, sensor: &Sensor, fitted: &ModelEstimate) {
        let period_ps = sensor.timing().code_period_ps();
        let code_of = |path: PathIndex| -> &Code { &scene.sources[scene.paths[path].source].code };
        let error_ps = |path: PathIndex, found: &FittedPath| {
            delay_error_ps(found.delay_ps, scene.paths[path].delay_ps, period_ps)
        };
        self.untold += u64::from(fitted.untold.is_some());
        self.more += u64::from(fitted.paths.len() > scene.paths.len());
        self.alarms += u64::from(fitted.alarm_sigmas() > ALARM_SIGMAS);
        let is_wrong = |found: &FittedPath| {
            let of_code = PathIndex::of(&scene.paths)
                .filter(|&path| code_of(path).chips == found.code.chips)
                .map(|path| error_ps(path, found).abs());
            of_code.fold(f64::INFINITY, f64::min) > WRONG_SIGMAS * found.delay_std_ps
        };
        self.wrong += u64::from(fitted.paths.iter().any(is_wrong));
        let mut found = fitted.paths.clone();
        found.sort_by(|a, b| a.delay_ps.total_cmp(&b.delay_ps));
        let mut order: Vec<PathIndex> = PathIndex::of(&scene.paths).collect();
        order.sort_by(|&a, &b| {
            let [a, b] = [a, b].map(|path| scene.paths[path].delay_ps);
            a.total_cmp(&b)
        });
        for path in order {
            let place = found.iter().position(|found| {
                found.code.chips == code_of(path).chips
                    && error_ps(path, found).abs() < scene.chip_period_ps
            });
            if let Some(place) = place {
                let found = found.remove(place);
                let told = &mut self.paths[path.0];
                let error_m = distance_m(error_ps(path, &found));
                told.errors_m.push(error_m);
                if fitted.untold.is_none() {
                    let variance_m2 = distance_m(found.delay_std_ps).powi(2);
                    told.unwarned.push([error_m, variance_m2]);
                }
            }
        }
    }

    /// Two lines and more for people.
    pub fn print(&self, name: &str) {
        println!(
            "  {name}: {} scans: own not seen {}, refused {}, untold {}, with more light {}, wrong \
             by 4 sigmas {}, alarms {}; {:.0} ms",
            self.scans,
            self.not_seen,
            self.refused,
            self.untold,
            self.more,
            self.wrong,
            self.alarms,
            self.milliseconds
        );
        for (number, path) in self.paths.iter().enumerate() {
            path.print(number);
        }
    }
}

impl PathTold {
    /// Scans that found it.
    pub fn found(&self) -> u64 {
        self.errors_m.len() as u64
    }

    /// Scatter over the standard deviation that the fits say, and its standard error, of
    /// scans that do not say that a path is missing.
    pub fn scatter_over_own(&self) -> [f64; 2] {
        let errors_m: Vec<f64> = self.unwarned.iter().map(|[error_m, _]| *error_m).collect();
        let n = errors_m.len() as f64;
        let own = self.unwarned.iter().map(|[_, variance]| variance);
        let ratio = mean_and_std(&errors_m)[1] / (own.sum::<f64>() / n).sqrt();
        [ratio, ratio / (2.0 * n).sqrt()]
    }

    fn print(&self, number: usize) {
        let n = self.errors_m.len() as f64;
        let bound_m = self.bound_m.unwrap_or(f64::NAN);
        let [bias_m, std_m] = mean_and_std(&self.errors_m);
        let ratio = std_m / bound_m;
        println!(
            "    path {number}: found in {n}, bias {:.2} +- {:.2} bounds, std / bound {ratio:.3} \
             +- {:.3}, std / own {:.3}, bound {:.2} mm",
            bias_m / bound_m,
            ratio / n.sqrt(),
            ratio / (2.0 * n).sqrt(),
            self.scatter_over_own()[0],
            bound_m * 1e3,
        );
    }
}

fn mean_and_std(values: &[f64]) -> [f64; 2] {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares = values.iter().map(|value| (value - mean).powi(2));
    [mean, (squares.sum::<f64>() / (n - 1.0)).sqrt()]
}
