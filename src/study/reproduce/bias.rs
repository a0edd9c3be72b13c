//! A systematic error of both estimators: the phase's, with its exact curve, and
//! what the model estimator leaves of it.

use super::figure::{Figure, Table, cells};
use super::run::{Run, RunError};
use super::statistics::Measured;
use crate::estimate::{CountingTier, predict};
use crate::report::chart::{Axis, Chart, Legend, Mark, Panel, Point, Scale, Series};
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
    /// Column of x in the table.
    pub x_column: &'a str,
    pub legend: Legend,
    /// Free space above the data, for the phase's legend.
    pub headroom: f64,
    /// What the model estimator's bias is to stay below, in millimetres.
    pub limit_mm: f64,
}

/// The phase's biases to the left, the model's to the right.
pub fn figure(frame: &Frame, biases: &[Bias]) -> Figure {
    let panel = |series, label: &str, legend, headroom| Panel {
        x: frame.x.clone(),
        y: Axis { label: label.to_owned(), scale: Scale::Linear },
        series,
        legend,
        headroom,
    };
    let numbered = || biases.iter().enumerate();
    let phase = numbered().flat_map(|(number, bias)| {
        [
            line(format!("{}, exact", bias.label), number, &bias.exact),
            dots(format!("{}, simulated", bias.label), number, &bias.phase),
        ]
    });
    let mut model: Vec<Series> =
        numbered().map(|(number, bias)| dots(bias.label.clone(), number, &bias.model)).collect();
    model.extend(limits(frame.limit_mm, &model));
    Figure {
        chart: Chart {
            title: frame.title.to_owned(),
            panels: vec![
                panel(
                    phase.filter(|series| !series.points.is_empty()).collect(),
                    "bias of the phase estimator (mm)",
                    frame.legend,
                    frame.headroom,
                ),
                panel(model, "bias of the model estimator (mm)", Legend::UpperLeft, 0.35),
            ],
        },
        table: table(frame.x_column, biases),
        claims: Vec::new(),
        notes: Vec::new(),
    }
}

/// Level lines at plus and minus a limit over the range of other series.
pub fn limits(limit_mm: f64, series: &[Series]) -> [Series; 2] {
    let places = || series.iter().flat_map(|s| &s.points).map(|point| point.x);
    let ends = [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)];
    [level(format!("±{limit_mm} mm"), limit_mm, ends), level(String::new(), -limit_mm, ends)]
}

/// A level line from one x to another.
pub fn level(label: String, y: f64, ends: [f64; 2]) -> Series {
    Series {
        label,
        mark: Mark::Line,
        colour: LIMIT_COLOUR,
        points: ends.map(|x| Point::new(x, y)).to_vec(),
    }
}

/// Black, which no data have.
const LIMIT_COLOUR: usize = 6;

fn line(label: String, colour: usize, points: &[(f64, f64)]) -> Series {
    Series {
        label,
        mark: Mark::Line,
        colour,
        points: points.iter().map(|&(x, metres)| Point::new(x, metres * 1e3)).collect(),
    }
}

/// Measured lengths, in millimetres, with their intervals.
pub fn dots(label: String, colour: usize, points: &[(f64, Measured)]) -> Series {
    let points = points.iter().map(|(x, metres)| {
        let shown = metres.scaled(1e3);
        Point { x: *x, y: shown.value, interval: Some((shown.low, shown.high)) }
    });
    Series { label, mark: Mark::Dots, colour, points: points.collect() }
}

fn table(x_column: &str, biases: &[Bias]) -> Table {
    let columns = ["series", x_column, "bias_m", "bias_low_m", "bias_high_m"];
    let mut table = Table::new(&columns);
    for bias in biases {
        for &(x, y) in &bias.exact {
            let series = format!("{}, phase, exact", bias.label);
            table.row(&series, &[Some(x), Some(y), None, None]);
        }
        for (estimator, points) in [("phase", &bias.phase), ("model", &bias.model)] {
            for &(x, y) in points {
                let mut row = vec![Some(x)];
                row.extend(cells(y));
                table.row(&format!("{}, {estimator}, simulated", bias.label), &row);
            }
        }
    }
    table
}
