//! Distances of two lights in one scan by the joint fit, beside the article's estimator.

use super::fits::Found;
use crate::report::chart::{Axis, Mark, Panel};
use crate::report::table::Table;
use crate::scene::Scene;
use crate::simulate::Tier;
use crate::study::reproduce::run::Run;
use crate::study::reproduce::run_error::RunError;

/// The phase's scans are one of so many shares of what is usual.
const SHARES: u64 = 5;
/// Most scans, of a whole code period, behind a point of the fit.
const MOST_SCANS: u64 = 40;

/// Names of a scene's two paths.
const LIGHTS: [&str; 2] = ["moving", "fixed"];

/// What both estimators say where the moving path is at several places.
#[derive(Default)]
pub struct Beside {
    rows: Vec<Found>,
}

impl Beside {
    /// Ranges a scene of two paths, of which the first moves: by the phase in a window, in the
    /// scans whose distance is within a chip of it, by the fit in all of the scan.
    pub fn measure(&mut self, run: &mut Run, at: f64, window: &Scene) -> Result<(), RunError> {
        let mut whole = window.clone();
        whole.scan.first_step = 0;
        whole.scan.steps = whole.scan.steps_per_period;
        if let Some(errors) = run.errors_if_any(window, SHARES)? {
            let series = "article's estimator, moving light".to_owned();
            self.rows.push(Found::by_phase(series, at, Some(errors)));
        }
        let fits = run.fits(&whole, Tier::Counts, MOST_SCANS)?;
        let paths = LIGHTS.iter().enumerate();
        self.rows.extend(paths.map(|(path, name)| {
            Found::by_fit(format!("joint fit, {name} light"), at, &fits, path)
        }));
        Ok(())
    }

    /// Biases, and standard deviations beside the bound.
    pub fn panels(&self) -> [Panel; 2] {
        let table = self.table();
        let panel = |y| {
            let x = Axis::linear("delay_chips", "delay of the moving path (chips of 8 ns)");
            Panel::new(x, y).curves(&table, Mark::Dots)
        };
        [
            panel(Axis::linear("bias_m", "bias of the distance (mm)")),
            panel(Axis::log("std_m", "standard deviation of the distance (mm); lines: bound"))
                .curves_of(&table.with("bound_m"), "bound_m", Mark::Line),
        ]
    }

    /// A row for each estimator, light and place of the moving path.
    pub fn table(&self) -> Table {
        Found::table("delay_chips", &self.rows)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::code::{CodeSpec, Family};
    use crate::study::reproduce::sensor::{CHIP_PERIOD_PS, Light, sensor, window};
    use crate::study::reproduce::{FigureId, ReproduceOptions};

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
        let options = ReproduceOptions { seed: 5, repetitions: 20, figures: Vec::new() };
        let mut run = Run::new(FigureId::Fig11, &options);
        let mut beside = Beside::default();
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
