//! Several paths and sensors in one scan: what the joint fit says of them.

pub mod power_ratio;
pub mod two_paths;

use rayon::prelude::*;

use super::prelude::*;
use super::run::Errors;
use crate::estimate::bound::bound;
use crate::estimate::fit::{ALARM_SIGMAS, ModelEstimate};
use crate::simulate::repeat::Ranging;
use crate::simulate::scans::scans;

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
    /// Simulates scans by a tier, as many as were asked for and no more than `most`, and fits
    /// them, told of all light that keeps the detector's clock.
    ///
    /// # Errors
    /// When the tier cannot do the scene.
    pub fn of(
        run: &mut FigureScans,
        scene: &Scene,
        tier: Tier,
        most: u64,
    ) -> Result<Fits, FigureError> {
        let (seed, repetitions) = (run.next_seed(), run.repetitions().min(most));
        let sensor = Sensor::new(&told_of_all(scene));
        let detector = DetectorIndex(0);
        let mut counted = Vec::new();
        scans(&sensor, detector, tier, seed, repetitions, |counts| {
            counted.push(counts.to_vec());
        })?;
        let ranging = Ranging::new(&sensor, detector, tier.counting(&sensor));
        let bound = bound(&sensor, detector, tier.counting(&sensor)).ok();
        let paths = ranging.paths.iter().map(|&path| PathFits {
            errors_m: Vec::new(),
            bound_m: bound.as_ref().and_then(|bound| bound.of_path(path)),
        });
        let paths = paths.collect();
        let mut fits = Fits { scans: repetitions, told: 0, wrong: 0, alarms: 0, paths };
        let fitted: Vec<_> =
            counted.par_iter().map(|counts| ranging.estimator.fitter().fit(counts).ok()).collect();
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
pub struct FoundLight {
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

impl FoundLight {
    /// By the joint fit, of the path with a number.
    pub fn by_fit(series: String, x: f64, fits: &Fits, path: usize) -> FoundLight {
        let path = &fits.paths[path];
        let (bias_m, std_m) = (path.bias_m(), path.std_m());
        FoundLight { series, x, found: fits.told(), bias_m, std_m, bound_m: path.bound_m }
    }

    /// By the phase; nothing of fewer than two scans.
    pub fn by_phase(series: String, x: f64, errors: Option<Errors>) -> FoundLight {
        let none = Measured::normal(0.0, 0.0);
        let found = errors.map_or(none, |errors| errors.correct_coarse());
        let (bias_m, std_m) = (errors.map(|e| e.bias_m), errors.map(|e| e.std_m));
        FoundLight { series, x, found, bias_m, std_m, bound_m: None }
    }

    /// A row of each, over a column of x.
    pub fn table(x_column: &str, rows: &[FoundLight]) -> Table {
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

/// The phase's scans are one of so many shares of what is usual.
const SHARES: u64 = 5;
/// Most scans, of a whole code period, behind a point of the fit.
const MOST_SCANS: u64 = 40;

/// Names of a scene's two paths.
const LIGHTS: [&str; 2] = ["moving", "fixed"];

/// What both estimators say where the moving path is at several places.
#[derive(Default)]
pub struct MovingPathEstimates {
    rows: Vec<FoundLight>,
}

impl MovingPathEstimates {
    /// Ranges a scene of two paths, of which the first moves: by the phase in a window, in the
    /// scans whose distance is within a chip of it, by the fit in all of the scan.
    pub fn measure(
        &mut self,
        run: &mut FigureScans,
        at: f64,
        window: &Scene,
    ) -> Result<(), FigureError> {
        let mut whole = window.clone();
        whole.scan.first_step = 0;
        whole.scan.steps = whole.scan.steps_per_period;
        if let Some(errors) = run.errors_if_any(window, SHARES)? {
            let series = "article's estimator, moving light".to_owned();
            self.rows.push(FoundLight::by_phase(series, at, Some(errors)));
        }
        let fits = Fits::of(run, &whole, Tier::Counts, MOST_SCANS)?;
        let paths = LIGHTS.iter().enumerate();
        self.rows.extend(paths.map(|(path, name)| {
            FoundLight::by_fit(format!("joint fit, {name} light"), at, &fits, path)
        }));
        Ok(())
    }

    /// Biases, and standard deviations beside the bound.
    pub fn panels(&self) -> [Panel; 2] {
        let table = self.table();
        let panel = |y| {
            let x = ChartAxis::linear("delay_chips", "delay of the moving path (chips of 8 ns)");
            Panel::new(x, y).curves(&table, Mark::Dots)
        };
        [
            panel(ChartAxis::linear("bias_m", "bias of the distance (mm)")),
            panel(ChartAxis::log("std_m", "standard deviation of the distance (mm); lines: bound"))
                .curves_of(&table.with("bound_m"), "bound_m", Mark::Line),
        ]
    }

    /// A row for each estimator, light and place of the moving path.
    pub fn table(&self) -> Table {
        FoundLight::table("delay_chips", &self.rows)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::code::{CodeSpec, Family};
    use crate::estimate::fit::FittedPath;
    use crate::scene::PathIndex;
    use crate::study::reproduce::sensor::{
        CHIP_PERIOD_PS, PathLight, balanced_gold, sensor, window,
    };
    use crate::study::reproduce::{FigureId, ReproduceOptions};

    fn scene() -> Scene {
        let own = balanced_gold(0, 0).expect("a Gold code");
        let other = balanced_gold(1, 0).expect("a Gold code");
        // Out of order, one next to the end of the code's period.
        let delays_chips = [(&own, 40.0), (&other, 7.0), (&own, 0.1)];
        let lights =
            delays_chips.map(|(code, chips)| PathLight::new(code, 1.0).at(chips * CHIP_PERIOD_PS));
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
            told_apart_by: f64::INFINITY,
            most_correlated: 0.0,
            iterations: 1,
        }
    }

    /// What one fit says: of every path its error, if it tells them, and whether it is wrong.
    fn said(found: &[(usize, f64)]) -> (Vec<f64>, bool) {
        let scene = scene();
        let sensor = Sensor::new(&scene);
        let ranging = Ranging::new(&sensor, DetectorIndex(0), Tier::Events.counting(&sensor));
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

    /// Where two peaks overlap the phase is off by what is left of the second, and the joint
    /// fit by noise.
    #[test]
    fn the_joint_fit_is_unbiased_where_the_articles_estimator_is_not() {
        let spec = CodeSpec { degree: Some(7), index: Some(3), ..CodeSpec::new(Family::Gold) };
        let code = spec.build().map(Arc::new).expect("a Gold code");
        let moving_chips = 8.05;
        let at = |chips: f64| PathLight::new(&code, 2.0).at(chips * CHIP_PERIOD_PS);
        let scene = sensor(&[at(moving_chips), at(moving_chips + 1.25)], 1e-3);
        let scene = window(scene, moving_chips * CHIP_PERIOD_PS, 5);
        let options = ReproduceOptions { seed: 5, repetitions: 20, figures: Vec::new() };
        let mut run = FigureScans::new(FigureId::Fig11, &options);
        let mut beside = MovingPathEstimates::default();
        beside.measure(&mut run, moving_chips, &scene).expect("distances");
        let phase_m = beside.rows[0].bias_m.expect("some find it").value;
        assert!(phase_m > 0.05, "{phase_m}");
        for path in &beside.rows[1..] {
            let (bias, bound_m) = (path.bias_m.expect("many"), path.bound_m.expect("one"));
            assert!(bias.value.abs() < 1.2 * bound_m, "{bias:?} {bound_m}");
            assert!(bias.value.abs() < 0.3 * phase_m, "{bias:?} {phase_m}");
        }
        let csv = beside.table().csv();
        let rows: Vec<&str> = csv.lines().collect();
        assert_eq!(rows.len(), 4);
        assert!(rows[1].starts_with("\"article's estimator, moving light\",8.05,"));
        assert!(rows[3].starts_with("\"joint fit, fixed light\",8.05,"), "{}", rows[3]);
    }
}
