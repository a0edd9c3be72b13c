//! The comparison as figures and tables.

use std::fmt::Write as _;

use super::points::worst;
use super::{FidelityReport, TierPoint};
use crate::files::{FileError, OutputFolder};
use crate::report::chart::ChartError;
use crate::report::chart::{Axis, Chart, Legend, Mark, Panel, Point, Scale, Series};
use crate::simulate::Tier;

/// Colour of the Pareto front: the last, black.
const FRONT_COLOUR: usize = 6;

/// Why a comparison could not be written.
#[derive(Debug, thiserror::Error)]
pub enum FilesError {
    /// A figure could not be drawn.
    #[error(transparent)]
    Plot(#[from] ChartError),
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl FidelityReport {
    /// Writes `fidelity.svg`, `sensor-trade.svg` and their data as CSV; gives
    /// their names.
    ///
    /// # Errors
    /// When a file cannot be written, or a figure not be drawn.
    pub fn write_files(&self, folder: &OutputFolder) -> Result<Vec<&'static str>, FilesError> {
        let files = [
            ("fidelity.svg", self.tiers_chart().svg()?),
            ("fidelity.csv", self.tiers_csv()),
            ("sensor-trade.svg", self.sensor_chart().svg()?),
            ("sensor-trade.csv", self.sensor_csv()),
        ];
        let mut written = Vec::new();
        for (name, text) in files {
            folder.write(name, &text)?;
            written.push(name);
        }
        Ok(written)
    }

    /// Error against run time: of the standard deviation, and of the bias.
    fn tiers_chart(&self) -> Chart {
        let of_std = |tier: &TierPoint| (tier.std_relative_error, tier.std_relative_error_ci95);
        let of_bias = |tier: &TierPoint| (tier.bias_error_in_std, tier.bias_error_in_std_ci95);
        let of_missed = |tier: &TierPoint| {
            (
                tier.missed_fraction_error.unwrap_or(f64::NAN),
                tier.missed_fraction_error_ci95.unwrap_or([f64::NAN; 2]),
            )
        };
        let mut missed = self.tier_series(of_missed);
        for series in &mut missed {
            // Of a tier that cannot tell, and of the reference against itself.
            series.points.retain(|point| point.y > 0.0);
        }
        let mut std_series = self.tier_series(of_std);
        let mut front: Vec<&TierPoint> = self.tiers.iter().filter(|tier| tier.pareto).collect();
        front.sort_by(|a, b| a.run_time_s.total_cmp(&b.run_time_s));
        let corner = |tier: &&TierPoint| {
            Point::new(tier.run_time_s, 100.0 * worst(tier.std_relative_error_ci95))
        };
        std_series.insert(
            0,
            Series {
                label: "Pareto front".to_owned(),
                mark: Mark::Line,
                colour: FRONT_COLOUR,
                points: front.iter().map(corner).collect(),
            },
        );
        let panel = |label: &str, series| Panel {
            x: axis("run time (s)"),
            y: axis(label),
            series,
            legend: Legend::UpperRight,
            headroom: 0.5,
        };
        Chart {
            title: format!(
                "{}: error against {} scans of the sampled tier (upper 95 % limit; bars down to \
                 what was found)",
                self.scene, self.reference.repetitions
            ),
            panels: vec![
                panel("error of the standard deviation (%)", std_series),
                panel("error of the bias (% of the standard deviation)", self.tier_series(of_bias)),
                panel("error of the share of missed peaks (% of all scans)", missed),
            ],
        }
    }

    /// A series per tier, of the largest errors that the confidence intervals
    /// hold, with bars down to the errors that were found.
    fn tier_series(&self, error: impl Fn(&TierPoint) -> (f64, [f64; 2])) -> Vec<Series> {
        let series = |(colour, tier): (usize, &Tier)| {
            let name = tier.to_string();
            let points = self.tiers.iter().filter(|point| point.fidelity == name);
            Series {
                mark: Mark::Dots,
                colour,
                points: points
                    .map(|point| {
                        let (found, interval) = error(point);
                        let limit = 100.0 * worst(interval);
                        Point {
                            x: point.run_time_s,
                            y: limit,
                            interval: Some((100.0 * found.abs().max(1e-4), limit)),
                        }
                    })
                    .collect(),
                label: name,
            }
        };
        Tier::ALL.iter().enumerate().map(series).collect()
    }

    /// Standard deviation over integration time, a line per light level, and the
    /// size of the bias that stays.
    fn sensor_chart(&self) -> Chart {
        let mut powers: Vec<f64> = self.sensor.iter().map(|p| p.relative_power).collect();
        powers.dedup();
        let lines = |value: &dyn Fn(&super::SensorPoint) -> f64| -> Vec<Series> {
            let line = |(colour, &power): (usize, &f64)| {
                let points = || self.sensor.iter().filter(|p| p.relative_power == power);
                let rate = points().next().map_or(0.0, |p| p.detected_rate_cps / 1e6);
                Series {
                    label: format!("{power} x power, {rate:.2} Mcps"),
                    mark: Mark::LineAndDots,
                    colour,
                    points: points().map(|p| Point::new(p.integration_s * 1e6, value(p))).collect(),
                }
            };
            powers.iter().enumerate().map(line).collect()
        };
        let panel = |label: &str, series, legend| Panel {
            x: axis("integration time per phase step (us)"),
            y: axis(label),
            series,
            legend,
            headroom: 0.45,
        };
        Chart {
            title: format!("{}: expected error of the phase estimate", self.scene),
            panels: vec![
                panel("standard deviation (mm)", lines(&|p| p.std_m * 1e3), Legend::UpperRight),
                panel(
                    "size of the bias (mm)",
                    lines(&|p| p.bias_m.abs() * 1e3),
                    Legend::UpperRight,
                ),
            ],
        }
    }

    fn tiers_csv(&self) -> String {
        let mut text = "tier,scans,run_time_s,std_m,bias_m,std_error,std_error_low,std_error_high,\
                        bias_error,bias_error_low,bias_error_high,pareto,missed_fraction,missed_error,\
                        missed_error_low,missed_error_high,verdict\n"
            .to_owned();
        for tier in &self.tiers {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                tier.fidelity,
                tier.repetitions.map_or(String::new(), |n| n.to_string()),
                tier.run_time_s,
                tier.std_m,
                tier.bias_m,
                tier.std_relative_error,
                tier.std_relative_error_ci95[0],
                tier.std_relative_error_ci95[1],
                tier.bias_error_in_std,
                tier.bias_error_in_std_ci95[0],
                tier.bias_error_in_std_ci95[1],
                tier.pareto,
                cell(tier.missed_fraction),
                cell(tier.missed_fraction_error),
                cell(tier.missed_fraction_error_ci95.map(|ci| ci[0])),
                cell(tier.missed_fraction_error_ci95.map(|ci| ci[1])),
                tier.verdict
            );
        }
        text
    }

    fn sensor_csv(&self) -> String {
        let mut text = "relative_power,detected_rate_cps,integration_s,std_m,bias_m,\
                        coarse_failure_bound_fraction,missed_fraction\n"
            .to_owned();
        for p in &self.sensor {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{}",
                p.relative_power,
                p.detected_rate_cps,
                p.integration_s,
                p.std_m,
                p.bias_m,
                p.coarse_failure_bound_fraction,
                cell(p.missed_fraction)
            );
        }
        text
    }
}

/// A number, or nothing, of a table.
fn cell(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}

fn axis(label: &str) -> Axis {
    Axis { label: label.to_owned(), scale: Scale::Log }
}
