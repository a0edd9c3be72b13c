//! Standard deviation of the distance against optical power: Figs. 5, 6 and 8.

pub mod gold_square;
pub mod interleaving;
pub mod two_sources;

use super::figure::{Claim, Figure, Table, cells};
use super::run::{Errors, Run, RunError};
use super::sensor::{Light, TARGET_PS, sensor, window};
use super::statistics::{Measured, decibels};
use crate::estimate::{CountingTier, predict};
use crate::report::chart::{Axis, Chart, Legend, Mark, Panel, Point, Scale, Series};
use crate::scene::Scene;

/// Mean optical power at the detector, in picowatts: 0.6 to 78 million primary
/// detections per second.
const POWERS_PW: [f64; 8] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
/// The scan reaches this many chips to either side of the target.
const HALF_WINDOW_CHIPS: u64 = 3;
/// A standard deviation is compared only where this share of all scans is
/// within a chip of the target: elsewhere it is that of a selection.
const COMPARABLE_SHARE: f64 = 0.99;

/// Label of the horizontal axis, of one source.
const POWER: &str = "optical power at the detector (pW)";

/// Errors at each of [`POWERS_PW`].
struct Curve {
    label: String,
    errors: Vec<Errors>,
}

impl Curve {
    /// `lights` gives the light of one power; the first is the target's.
    fn measure(
        run: &mut Run,
        label: &str,
        integration_s: f64,
        lights: impl Fn(f64) -> Vec<Light>,
    ) -> Result<Curve, RunError> {
        Curve::of_scenes(run, label, |power_pw| {
            sensor(&lights(power_pw), integration_s)
        })
    }

    /// `scene` gives the sensor for one power.
    fn of_scenes(
        run: &mut Run,
        label: &str,
        scene: impl Fn(f64) -> Scene,
    ) -> Result<Curve, RunError> {
        let errors = POWERS_PW
            .iter()
            .map(|&power_pw| run.errors(&window(scene(power_pw), TARGET_PS, HALF_WINDOW_CHIPS)));
        Ok(Curve {
            label: label.to_owned(),
            errors: errors.collect::<Result<_, _>>()?,
        })
    }

    /// Decibels by which this curve's standard deviation is above another's, at
    /// each power where both can be compared.
    fn decibels_above(&self, other: &Curve) -> Vec<(f64, Measured)> {
        let comparable = |e: &Errors| e.correct_coarse.value >= COMPARABLE_SHARE;
        let pairs = self.errors.iter().zip(&other.errors);
        POWERS_PW
            .into_iter()
            .zip(pairs)
            .filter(|(_, (a, b))| comparable(a) && comparable(b))
            .map(|(power, (a, b))| (power, decibels(a.std_m, b.std_m)))
            .collect()
    }

    /// The least standard deviation, with its power and bias.
    fn best(&self) -> (f64, &Errors) {
        let std = |e: &Errors| e.std_m.value;
        POWERS_PW
            .into_iter()
            .zip(&self.errors)
            .filter(|(_, e)| e.correct_coarse.value >= COMPARABLE_SHARE)
            .min_by(|(_, a), (_, b)| std(a).total_cmp(&std(b)))
            .unwrap_or((
                POWERS_PW[POWERS_PW.len() - 1],
                &self.errors[POWERS_PW.len() - 1],
            ))
    }
}

/// Standard deviation that the exact moments give, where the coarse stage is
/// right.
fn exact_std_m(scene: Scene) -> Result<f64, RunError> {
    let scene = window(scene, TARGET_PS, HALF_WINDOW_CHIPS);
    Ok(predict(&scene, 0, 0, CountingTier::Events)?.std_m)
}

/// Standard deviation to the left, bias to the right, of every curve.
fn figure(title: &str, power_label: &str, curves: &[Curve], claims: Vec<Claim>) -> Figure {
    let mut table = Table::new(&[
        "series",
        "power_pw",
        "detected_rate_cps",
        "std_m",
        "std_low_m",
        "std_high_m",
        "bias_m",
        "bias_low_m",
        "bias_high_m",
        "correct_coarse",
        "correct_coarse_low",
        "correct_coarse_high",
    ]);
    for curve in curves {
        for (power, e) in POWERS_PW.iter().zip(&curve.errors) {
            let mut row = vec![Some(*power), Some(e.detected_rate_cps)];
            row.extend(cells(e.std_m));
            row.extend(cells(e.bias_m));
            row.extend(cells(e.correct_coarse));
            table.row(&curve.label, &row);
        }
    }
    let panel = |label: &str, scale, legend, value: fn(&Errors) -> Measured| {
        let series = curves.iter().enumerate().map(|(number, curve)| {
            let points = POWERS_PW.iter().zip(&curve.errors).map(|(&x, e)| {
                let shown = value(e).scaled(1e3);
                Point {
                    x,
                    y: shown.value,
                    interval: Some((shown.low, shown.high)),
                }
            });
            Series {
                label: curve.label.clone(),
                mark: Mark::LineAndDots,
                colour: number,
                points: points.collect(),
            }
        });
        Panel {
            x: Axis {
                label: power_label.to_owned(),
                scale: Scale::Log,
            },
            y: Axis {
                label: label.to_owned(),
                scale,
            },
            series: series.collect(),
            legend,
            headroom: 0.06,
        }
    };
    Figure {
        chart: Chart {
            title: title.to_owned(),
            panels: vec![
                panel(
                    "standard deviation (mm)",
                    Scale::Log,
                    Legend::UpperRight,
                    |e| e.std_m,
                ),
                panel("bias (mm)", Scale::Linear, Legend::LowerLeft, |e| e.bias_m),
            ],
        },
        table,
        claims,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn errors(std_m: f64) -> Errors {
        Errors {
            std_m: Measured::normal(std_m, 0.01 * std_m),
            bias_m: Measured::normal(0.0, 1e-6),
            correct_coarse: Measured::normal(1.0, 0.0),
            detected_rate_cps: 1e6,
        }
    }

    pub fn curve(std_m: f64) -> Curve {
        Curve {
            label: String::new(),
            errors: POWERS_PW.iter().map(|_| errors(std_m)).collect(),
        }
    }
}
