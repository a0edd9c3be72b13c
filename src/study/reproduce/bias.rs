//! A systematic error of both estimators: the phase's, with its exact curve, and
//! what the model estimator leaves of it.

use super::figure::Figure;
use super::run::Run;
use super::run_error::RunError;
use super::sensor::expected;
use crate::report::chart::{Axis, Mark, Panel};
use crate::report::table::{Spread, Table};
use crate::scene::{EstimatorKind, Scene};
use crate::simulate::Tier;

/// How the model estimator's bias is simulated.
#[derive(Debug, Clone, Copy)]
pub struct ByModel {
    /// By which tier.
    pub tier: Tier,
    /// Scans behind each point.
    pub scans: u64,
}

/// A bias at points of one quantity: name of the series, x, and the bias in metres with its
/// interval.
pub struct Bias {
    label: String,
    rows: Vec<(String, f64, [Option<f64>; 3])>,
}

impl Bias {
    /// The phase estimator's bias, exact for each of `fine`, simulated for each of
    /// `coarse`; `scene` gives the scene for one value of x.
    pub fn of_phase(
        run: &mut Run,
        label: &str,
        fine: &[f64],
        coarse: &[f64],
        scene: impl Fn(f64) -> Scene,
    ) -> Result<Bias, RunError> {
        let mut bias = Bias { label: label.to_owned(), rows: Vec::new() };
        for &x in fine {
            bias.push(PHASE_EXACT, x, expected(&scene(x))?.bias_m);
        }
        for &x in coarse {
            bias.push(PHASE, x, run.errors(&scene(x))?.bias_m);
        }
        Ok(bias)
    }

    /// Adds the model estimator's bias for each of `coarse`.
    pub fn and_model(
        mut self,
        run: &mut Run,
        by: ByModel,
        coarse: &[f64],
        scene: impl Fn(f64) -> Scene,
    ) -> Result<Bias, RunError> {
        for &x in coarse {
            let scene = Scene { estimator: EstimatorKind::Model, ..scene(x) };
            self.push(MODEL, x, run.fitted_bias_m(&scene, by.tier, by.scans)?);
        }
        Ok(self)
    }

    fn push(&mut self, kind: &str, x: f64, bias_m: impl Spread) {
        self.rows.push((self.label.clone() + kind, x, bias_m.spread()));
    }
}

/// What a figure of biases says beside its data.
pub struct Frame<'a> {
    pub title: &'a str,
    pub x: Axis,
    /// What the model estimator's bias is to stay below, in millimetres.
    pub limit_mm: f64,
}

/// The phase's biases to the left, the model's to the right.
pub fn figure(frame: Frame, biases: &[Bias]) -> Figure {
    let rows: Vec<_> = biases.iter().flat_map(|bias| &bias.rows).collect();
    let table = Table::of(&rows)
        .column("series", |row| row.0.as_str())
        .column(&frame.x.column, |row| row.1)
        .interval("bias_m", |row| row.2)
        .table();
    let part = |kind: &str| {
        let of_kind = table.only(|_, row| row.name.ends_with(kind));
        of_kind.named(|_, row| row.name.trim_end_matches(kind).to_owned())
    };
    let panel = |label: &str| Panel::new(frame.x.clone(), Axis::linear("bias_m", label));
    let panels = vec![
        panel("bias of the phase estimator (mm); lines: exact")
            .curves(&part(PHASE_EXACT), Mark::Line)
            .curves(&part(PHASE), Mark::Dots),
        panel("bias of the model estimator (mm)")
            .curves(&part(MODEL), Mark::Dots)
            .limits(frame.limit_mm, "mm"),
    ];
    Figure::new(frame.title, table, panels)
}

/// What follows a bias's label in the name of its series.
const PHASE_EXACT: &str = ", phase, exact";
const PHASE: &str = ", phase, simulated";
const MODEL: &str = ", model, simulated";
