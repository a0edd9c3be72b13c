//! The comparison in words.

use std::fmt::Write as _;

use super::FidelityReport;
use crate::report::columns::Lines;

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
        let r = &self.reference;
        let remark = r.expectation_remark.as_ref();
        let remark = remark.map(|told| format!("the expectation does not hold: {told}\n"));
        format!(
            "{}, seed {}; reference: {} with {} scans, standard deviation {:.3} +- {:.3} mm, bias \
             {:.3} +- {:.3} mm, peak missed in {:.2} % [{:.2}, {:.2}]\n{}\n",
            self.scene,
            self.seed,
            r.fidelity,
            r.repetitions,
            r.std_m * 1e3,
            r.std_std_error_m * 1e3,
            r.bias_m * 1e3,
            r.bias_std_error_m * 1e3,
            r.missed_fraction * 100.0,
            r.missed_fraction_ci95[0] * 100.0,
            r.missed_fraction_ci95[1] * 100.0,
            remark.unwrap_or_default(),
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
