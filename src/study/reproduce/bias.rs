//! A systematic error of both estimators: the phase's, with its exact curve, and
//! what the model estimator leaves of it.

use super::figure::Figure;
use super::run::{Run, RunError};
use super::statistics::Measured;
use crate::estimate::{CountingTier, predict};
use crate::report::chart::{Axis, Mark, Panel};
use crate::report::table::{Spread, Table};
use crate::scene::{DetectorIndex, EstimatorKind, PathIndex, Scene};
use crate::sensor::Sensor;
use crate::simulate::Tier;

/// How the model estimator's bias is simulated.
#[derive(Debug, Clone, Copy)]
pub struct ByModel {
    /// By which tier.
    pub tier: Tier,
    /// Scans behind each point.
    pub scans: u64,
}

/// A bias at points of one quantity.
pub struct Bias {
    label: String,
    /// x, the phase estimator's answer to exact mean counts, in metres.
    exact: Vec<(f64, f64)>,
    phase: Vec<(f64, Measured)>,
    model: Vec<(f64, Measured)>,
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
        let exact = fine
            .iter()
            .map(|&x| {
                Ok((
                    x,
                    predict(
                        &Sensor::new(&scene(x)),
                        DetectorIndex(0),
                        PathIndex(0),
                        CountingTier::Events,
                    )?
                    .bias_m,
                ))
            })
            .collect::<Result<_, RunError>>()?;
        let phase = coarse
            .iter()
            .map(|&x| Ok((x, run.errors(&scene(x))?.bias_m)))
            .collect::<Result<_, RunError>>()?;
        Ok(Bias { label: label.to_owned(), exact, phase, model: Vec::new() })
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
            let mut scene = scene(x);
            scene.estimator = EstimatorKind::Model;
            let bias_m = run.fitted_bias_m(&scene, by.tier, by.scans)?;
            self.model.push((x, bias_m));
        }
        Ok(self)
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
    let table = table(&frame.x.column, biases);
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

fn table(x_column: &str, biases: &[Bias]) -> Table {
    let rows = biases.iter().flat_map(|bias| {
        let exact = bias.exact.iter().map(|&(x, y)| (PHASE_EXACT, x, y.spread()));
        let phase = bias.phase.iter().map(|&(x, y)| (PHASE, x, y.spread()));
        let model = bias.model.iter().map(|&(x, y)| (MODEL, x, y.spread()));
        exact.chain(phase).chain(model).map(|row| (&bias.label, row))
    });
    Table::of(&rows.collect::<Vec<_>>())
        .column("series", |(label, (kind, ..))| format!("{label}{kind}"))
        .column(x_column, |(_, (_, x, _))| *x)
        .interval("bias_m", |(_, (.., bias))| *bias)
        .table()
}
