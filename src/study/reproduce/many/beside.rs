//! Distances of two lights in one scan by the joint fit, beside the article's estimator.

use super::fits::Fits;
use crate::report::chart::{Axis, Legend, Mark, Panel, Point, Scale, Series};
use crate::scene::Scene;
use crate::simulate::Tier;
use crate::study::reproduce::figure::{Table, cells};
use crate::study::reproduce::phase::Errors;
use crate::study::reproduce::run::{Run, RunError};
use crate::study::reproduce::statistics::Measured;

/// Columns of a table, behind those of its own.
pub const COLUMNS: [&str; 10] = [
    "found",
    "found_low",
    "found_high",
    "bias_m",
    "bias_low_m",
    "bias_high_m",
    "std_m",
    "std_low_m",
    "std_high_m",
    "bound_m",
];

/// The phase's scans are one of so many shares of what is usual.
const SHARES: u64 = 5;
/// Most scans, of a whole code period, behind a point of the fit.
const MOST_SCANS: u64 = 40;

/// Names of a scene's two paths.
const LIGHTS: [&str; 2] = ["moving", "fixed"];

/// What both estimators say where the moving path is at several places.
#[derive(Default)]
pub struct Beside {
    rows: Vec<Row>,
}

struct Row {
    moving_chips: f64,
    /// Of the moving path, in the scans whose distance is within a chip of it.
    phase: Option<Errors>,
    fits: Fits,
}

impl Beside {
    /// Ranges a scene of two paths, of which the first moves: by the phase in a window, by
    /// the fit in all of the scan.
    pub fn measure(
        &mut self,
        run: &mut Run,
        moving_chips: f64,
        window: &Scene,
    ) -> Result<(), RunError> {
        let mut whole = window.clone();
        whole.scan.first_step = 0;
        whole.scan.steps = whole.scan.steps_per_period;
        self.rows.push(Row {
            moving_chips,
            phase: match run.share_of_errors(window, SHARES) {
                Err(RunError::NoStatistics { .. }) => None,
                errors => Some(errors?),
            },
            fits: run.fits(&whole, Tier::Counts, MOST_SCANS)?,
        });
        Ok(())
    }

    /// Biases, and standard deviations beside the bound.
    pub fn panels(&self) -> [Panel; 2] {
        let bias = self.series(|errors| errors.bias_m, |fits, path| fits.paths[path].bias_m());
        let mut std = self.series(|errors| errors.std_m, |fits, path| fits.paths[path].std_m());
        for (number, name) in LIGHTS.iter().enumerate() {
            let points = self.rows.iter().filter_map(|row| {
                let bound_m = row.fits.paths[number].bound_m?;
                Some(Point::new(row.moving_chips, 1e3 * bound_m))
            });
            std.push(Series {
                label: format!("bound, {name} light"),
                mark: Mark::Line,
                colour: number + 1,
                points: points.collect(),
            });
        }
        let panel = |series, label: &str, scale| Panel {
            x: Axis {
                label: "delay of the moving path (chips of 8 ns)".to_owned(),
                scale: Scale::Linear,
            },
            y: Axis { label: label.to_owned(), scale },
            series,
            legend: Legend::UpperLeft,
            headroom: 0.45,
        };
        [
            panel(bias, "bias of the distance (mm)", Scale::Linear),
            panel(std, "standard deviation of the distance (mm)", Scale::Log),
        ]
    }

    fn series(
        &self,
        phase: impl Fn(&Errors) -> Measured,
        joint: impl Fn(&Fits, usize) -> Option<Measured>,
    ) -> Vec<Series> {
        let dots = |label: String, colour, value: &dyn Fn(&Row) -> Option<Measured>| {
            let points = self.rows.iter().filter_map(|row| {
                let shown = value(row)?.scaled(1e3);
                Some(Point {
                    x: row.moving_chips,
                    y: shown.value,
                    interval: Some((shown.low, shown.high)),
                })
            });
            Series { label, mark: Mark::Dots, colour, points: points.collect() }
        };
        let mut series = vec![dots("article's, moving light".to_owned(), 0, &|row| {
            row.phase.as_ref().map(&phase)
        })];
        for (number, name) in LIGHTS.iter().enumerate() {
            let label = format!("joint fit, {name} light");
            series.push(dots(label, number + 1, &|row| joint(&row.fits, number)));
        }
        series
    }

    /// Rows of a table that has `before` columns between the moving path's delay and
    /// [`COLUMNS`].
    pub fn fill(&self, table: &mut Table, before: usize) {
        for row in &self.rows {
            let mut add = |series: &str, found, bias, std, bound_m| {
                let mut values = vec![Some(row.moving_chips)];
                values.extend(vec![None; before]);
                for measured in [found, bias, std] {
                    values.extend(Option::<Measured>::map_or(measured, [None; 3], cells));
                }
                values.push(bound_m);
                table.row(series, &values);
            };
            if let Some(errors) = &row.phase {
                let (bias, std) = (Some(errors.bias_m), Some(errors.std_m));
                let found = Some(errors.correct_coarse());
                add("article's estimator, moving light", found, bias, std, None);
            }
            for (path, name) in row.fits.paths.iter().zip(LIGHTS) {
                let series = format!("joint fit, {name} light");
                let told = Some(row.fits.told());
                add(&series, told, path.bias_m(), path.std_m(), path.bound_m);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::code::{CodeSpec, Family};
    use crate::study::reproduce::sensor::{CHIP_PERIOD_PS, Light, sensor, window};
    use crate::study::reproduce::{FigureId, Options};

    /// Where two peaks overlap the phase is off by what is left of the second, and the joint
    /// fit by noise.
    #[test]
    fn the_joint_fit_is_unbiased_where_the_articles_estimator_is_not() {
        let spec = CodeSpec { degree: Some(7), index: Some(3), ..CodeSpec::new(Family::Gold) };
        let code = spec.build().map(Arc::new).expect("a Gold code");
        let moving_chips = 8.05;
        let at = |chips: f64| Light::new(&code, 2.0).at(chips * CHIP_PERIOD_PS);
        let scene = sensor(&[at(moving_chips), at(moving_chips + 1.25)], 1e-3);
        let scene = window(scene, moving_chips * CHIP_PERIOD_PS, 5);
        let options = Options { seed: 5, repetitions: 20, figures: Vec::new() };
        let mut run = Run::new(FigureId::Fig11, &options);
        let mut beside = Beside::default();
        beside.measure(&mut run, moving_chips, &scene).expect("distances");
        let row = &beside.rows[0];
        let phase_m = row.phase.expect("some find it").bias_m.value;
        assert!(phase_m > 0.05, "{phase_m}");
        for path in &row.fits.paths {
            let (bias, bound_m) = (path.bias_m().expect("many"), path.bound_m.expect("one"));
            assert!(bias.value.abs() < 1.2 * bound_m, "{bias:?} {bound_m}");
            assert!(bias.value.abs() < 0.3 * phase_m, "{bias:?} {phase_m}");
        }
        let mut table = Table::new(&[&["series", "delay_chips", "count"][..], &COLUMNS].concat());
        beside.fill(&mut table, 1);
        let rows: Vec<&str> = table.csv().lines().collect();
        assert_eq!(rows.len(), 4);
        assert!(rows[1].starts_with("\"article's estimator, moving light\",8.05,,"));
        assert!(rows[3].starts_with("\"joint fit, fixed light\",8.05,,"), "{}", rows[3]);
    }
}
