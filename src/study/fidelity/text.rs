//! The comparison in words.

use std::fmt::Write as _;

use super::points::worst;
use super::{FidelityReference, FidelityReport, SensorPoint, TierPoint};
use crate::files::{FileError, OutputFolder};
use crate::report::chart::{Chart, ChartAxis, DrawingRole, Mark, Panel};
use crate::report::columns::Lines;
use crate::report::table::{Table, fields};
use crate::simulate::Tier;

impl FidelityReport {
    /// The report in words.
    pub fn to_text(&self) -> String {
        let mut text = self.heading();
        self.write_tiers(&mut text);
        self.write_recommendation(&mut text);
        self.write_sensor(&mut text);
        text.push('\n');
        for part in &self.left_out {
            let saving = part.saving.as_ref().map_or(String::new(), |saving| {
                format!(", saves {:.1} % of the time", saving.time_fraction * 100.0)
            });
            let _ = writeln!(text, "left out: {}{saving} ({})", part.part, part.reason);
        }
        text
    }

    fn heading(&self) -> String {
        let FidelityReport { scene, seed, reference: r, .. } = self;
        let FidelityReference { fidelity, repetitions, missed_fraction_ci95: [low, high], .. } = r;
        let [std, std_error, bias, bias_error] =
            [r.std_m, r.std_std_error_m, r.bias_m, r.bias_std_error_m].map(|metres| metres * 1e3);
        let [missed, low, high] = [r.missed_fraction, *low, *high].map(|share| share * 100.0);
        let remark = r.expectation_remark.as_ref();
        let remark = remark.map(|told| format!("the expectation does not hold: {told}\n"));
        let remark = remark.unwrap_or_default();
        format!(
            "{scene}, seed {seed}; reference: {fidelity} with {repetitions} scans, standard deviation \
             {std:.3} +- {std_error:.3} mm, bias {bias:.3} +- {bias_error:.3} mm, peak missed in \
             {missed:.2} % [{low:.2}, {high:.2}]\n{remark}\n"
        )
    }

    fn write_tiers(&self, text: &mut String) {
        let interval = |error: f64, ci: [f64; 2]| {
            format!(" {:+.2} % [{:+.2}, {:+.2}]", error * 100.0, ci[0] * 100.0, ci[1] * 100.0)
        };
        *text += &Lines::of(&self.tiers, "")
            .left("tier", 10, |tier| tier.fidelity.clone())
            .right("scans", 7, |tier| tier.repetitions.map_or("-".to_owned(), |n| n.to_string()))
            .right("time s", 10, |tier| format!("{:.4}", tier.run_time_s))
            .right("std mm", 9, |tier| format!("{:.3}", tier.std_m * 1e3))
            .right("bias mm", 9, |tier| format!("{:.3}", tier.bias_m * 1e3))
            .right("missed %", 8, |tier| percent(tier.missed_fraction))
            .right("error of std, 95 %", 25, |tier| {
                interval(tier.std_relative_error, tier.std_relative_error_ci95)
            })
            .right("of bias, in std", 25, |tier| {
                interval(tier.bias_error_in_std, tier.bias_error_in_std_ci95)
            })
            .right("of missed, of all scans", 25, |tier| {
                let missed = tier.missed_fraction_error.zip(tier.missed_fraction_error_ci95);
                missed.map_or("unknown".to_owned(), |(error, ci)| interval(error, ci))
            })
            .left("", 0, |tier| {
                format!("  {}{}", tier.verdict, if tier.pareto { ", Pareto" } else { "" })
            })
            .text();
        for tier in &self.domains {
            if let Some(build_time_s) = tier.build_time_s {
                let _ = writeln!(
                    text,
                    "{}: built in {build_time_s:.2} s, once for all scans of this scene",
                    tier.fidelity
                );
            }
        }
    }

    fn write_recommendation(&self, text: &mut String) {
        let Some(best) = &self.recommended else {
            if let Some(refusal) = &self.refusal {
                let _ = writeln!(text, "\nno tier is recommended: {refusal}");
            }
            return;
        };
        let scans = best.repetitions.map_or(String::new(), |n| format!(" with {n} scans"));
        let _ = writeln!(
            text,
            "\nfor an error of {} % (of standard deviation, bias and missed peaks): {}{scans}, {:.3} s (seen \
             to agree within {:.2} %)",
            best.target_error * 100.0,
            best.fidelity,
            best.run_time_s,
            best.shown_error * 100.0
        );
        if let Some(refusal) = &self.refusal {
            let _ = writeln!(text, "for less: {refusal}");
        }
    }

    fn write_sensor(&self, text: &mut String) {
        text.push('\n');
        *text += &Lines::of(&self.sensor, "")
            .left("     power", 0, |point| format!("{:>9}x", point.relative_power))
            .right("Mcps", 12, |point| format!("{:.3}", point.detected_rate_cps / 1e6))
            .right("integration us", 16, |point| format!("{:.1}", point.integration_s * 1e6))
            .right("std mm", 9, |point| format!("{:.3}", point.std_m * 1e3))
            .right("bias mm", 9, |point| format!("{:.3}", point.bias_m * 1e3))
            .right("missed %", 9, |point| percent(point.missed_fraction))
            .text();
    }
}

fn percent(share: Option<f64>) -> String {
    match share {
        Some(share) => format!("{:.2}", share * 100.0),
        None => "unknown".to_owned(),
    }
}

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
            Panel::new(ChartAxis::log("run_time_s", "run time (s)"), ChartAxis::log(column, label))
        };
        let mut front: Vec<&TierPoint> = self.tiers.iter().filter(|tier| tier.pareto).collect();
        front.sort_by(|a, b| a.run_time_s.total_cmp(&b.run_time_s));
        let corner =
            |tier: &&TierPoint| (tier.run_time_s, 100.0 * worst(tier.std_relative_error_ci95));
        let panels = [
            panel("std_error", "error of the standard deviation (%)").with(
                "Pareto front",
                DrawingRole::Truth,
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
            let x = ChartAxis::log("integration_s", "integration time per phase step (us)");
            Panel::new(x, ChartAxis::log(column, label)).curves(&drawn, Mark::LineAndDots)
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
    fields!(
        Table::of(points), point => point;
        relative_power, detected_rate_cps, integration_s, std_m, bias_m,
        coarse_failure_bound_fraction, missed_fraction
    )
    .table()
}
