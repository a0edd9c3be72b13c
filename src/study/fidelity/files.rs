//! The comparison as figures and tables.

use super::points::worst;
use super::{FidelityReport, SensorPoint, TierPoint};
use crate::files::{FileError, OutputFolder};
use crate::report::chart::{Axis, Chart, Mark, Panel, Role};
use crate::report::table::Table;
use crate::simulate::Tier;

impl FidelityReport {
    /// Writes `fidelity.svg`, `sensor-trade.svg` and their data as CSV; gives
    /// their names.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write_files(&self, folder: &OutputFolder) -> Result<Vec<&'static str>, FileError> {
        let sensor = sensor_table(&self.sensor);
        let files = [
            ("fidelity.svg", self.tiers_chart().svg()),
            ("fidelity.csv", tiers_table(&self.tiers).csv()),
            ("sensor-trade.svg", self.sensor_chart(&sensor).svg()),
            ("sensor-trade.csv", sensor.csv()),
        ];
        folder.write_all(files)
    }

    /// Error against run time: of the standard deviation, of the bias, and of the share of
    /// missed peaks. Largest errors that the confidence intervals hold, with bars down to the
    /// errors that were found.
    fn tiers_chart(&self) -> Chart {
        let limit = |found: f64, interval: [f64; 2]| {
            [worst(interval), found.abs().max(1e-6), worst(interval)].map(Some)
        };
        let in_order = Tier::ALL.iter().flat_map(|tier| {
            self.tiers.iter().filter(move |point| point.fidelity == tier.to_string())
        });
        let tiers: Vec<&TierPoint> = in_order.collect();
        let drawn = Table::of(&tiers)
            .column("tier", |tier| tier.fidelity.as_str())
            .column("run_time_s", |tier| tier.run_time_s)
            .interval("std_error", |t| limit(t.std_relative_error, t.std_relative_error_ci95))
            .interval("bias_error", |t| limit(t.bias_error_in_std, t.bias_error_in_std_ci95))
            .interval("missed_error", |t| {
                let missed = t.missed_fraction_error.zip(t.missed_fraction_error_ci95);
                // Of a tier that cannot tell, and of the reference against itself.
                let shown = missed.filter(|(_, interval)| worst(*interval) > 0.0);
                shown.map(|(found, interval)| limit(found, interval))
            })
            .table();
        let panel = |column: &str, label: &str| {
            Panel::new(Axis::log("run_time_s", "run time (s)"), Axis::log(column, label))
        };
        let mut front: Vec<&TierPoint> = self.tiers.iter().filter(|tier| tier.pareto).collect();
        front.sort_by(|a, b| a.run_time_s.total_cmp(&b.run_time_s));
        let corner =
            |tier: &&TierPoint| (tier.run_time_s, 100.0 * worst(tier.std_relative_error_ci95));
        let panels = [
            panel("std_error", "error of the standard deviation (%)").with(
                "Pareto front",
                Role::Truth,
                Mark::Line,
                front.iter().map(corner),
            ),
            panel("bias_error", "error of the bias (% of the standard deviation)"),
            panel("missed_error", "error of the share of missed peaks (% of all scans)"),
        ];
        Chart {
            title: format!(
                "{}: error against {} scans of the sampled tier (upper 95 % limit; bars down to \
                 what was found)",
                self.scene, self.reference.repetitions
            ),
            panels: panels.map(|panel| panel.curves(&drawn, Mark::Dots)).into(),
        }
    }

    /// Standard deviation over integration time, a line per light level, and the
    /// size of the bias that stays.
    fn sensor_chart(&self, table: &Table) -> Chart {
        let drawn = table.named(|table, row| {
            let at = |column: &str| table.value(row, column).number().unwrap_or_default();
            let power = at("relative_power");
            // That of the power's first point.
            let first = self.sensor.iter().find(|point| point.relative_power == power);
            let rate = first.map_or(0.0, |point| point.detected_rate_cps / 1e6);
            format!("{power} x power, {rate:.2} Mcps")
        });
        let panel = |column: &str, label: &str| {
            let x = Axis::log("integration_s", "integration time per phase step (us)");
            Panel::new(x, Axis::log(column, label)).curves(&drawn, Mark::LineAndDots)
        };
        Chart {
            title: format!("{}: expected error of the phase estimate", self.scene),
            panels: vec![
                panel("std_m", "standard deviation (mm)"),
                panel("bias_m", "size of the bias (mm)"),
            ],
        }
    }
}

fn tiers_table(tiers: &[TierPoint]) -> Table {
    let with = |value: f64, [low, high]: [f64; 2]| [value, low, high].map(Some);
    Table::of(tiers)
        .column("tier", |tier| tier.fidelity.as_str())
        .column("scans", |tier| tier.repetitions)
        .column("run_time_s", |tier| tier.run_time_s)
        .column("std_m", |tier| tier.std_m)
        .column("bias_m", |tier| tier.bias_m)
        .interval("std_error", |tier| with(tier.std_relative_error, tier.std_relative_error_ci95))
        .interval("bias_error", |tier| with(tier.bias_error_in_std, tier.bias_error_in_std_ci95))
        .column("pareto", |tier| tier.pareto)
        .column("missed_fraction", |tier| tier.missed_fraction)
        .interval("missed_error", |tier| {
            let ci = tier.missed_fraction_error_ci95;
            [tier.missed_fraction_error, ci.map(|ci| ci[0]), ci.map(|ci| ci[1])]
        })
        .column("verdict", |tier| tier.verdict.to_string())
        .table()
}

fn sensor_table(points: &[SensorPoint]) -> Table {
    Table::of(points)
        .column("relative_power", |p| p.relative_power)
        .column("detected_rate_cps", |p| p.detected_rate_cps)
        .column("integration_s", |p| p.integration_s)
        .column("std_m", |p| p.std_m)
        .column("bias_m", |p| p.bias_m)
        .column("coarse_failure_bound_fraction", |p| p.coarse_failure_bound_fraction)
        .column("missed_fraction", |p| p.missed_fraction)
        .table()
}
