//! The comparison in words.

use std::fmt::Write as _;

use super::FidelityReport;

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
        let _ = writeln!(
            text,
            "{:10} {:>7} {:>10} {:>9} {:>9} {:>8}  {:>24}  {:>24}  {:>24}",
            "tier",
            "scans",
            "time s",
            "std mm",
            "bias mm",
            "missed %",
            "error of std, 95 %",
            "of bias, in std",
            "of missed, of all scans"
        );
        for tier in &self.tiers {
            let missed = tier.missed_fraction_error.zip(tier.missed_fraction_error_ci95);
            let scans = tier.repetitions.map_or("-".to_owned(), |n| n.to_string());
            let _ = writeln!(
                text,
                "{:10} {:>7} {:>10.4} {:>9.3} {:>9.3} {:>8}  {:>24}  {:>24}  {:>24}  {}{}",
                tier.fidelity,
                scans,
                tier.run_time_s,
                tier.std_m * 1e3,
                tier.bias_m * 1e3,
                percent(tier.missed_fraction),
                interval(tier.std_relative_error, tier.std_relative_error_ci95),
                interval(tier.bias_error_in_std, tier.bias_error_in_std_ci95),
                missed.map_or("unknown".to_owned(), |(error, ci)| interval(error, ci)),
                tier.verdict,
                if tier.pareto { ", Pareto" } else { "" },
            );
        }
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
        if let Some(refusal) = &self.refusal {
            let _ = writeln!(text, "\nno tier is recommended: {refusal}");
        }
        let Some(best) = &self.recommended else {
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
    }

    fn write_sensor(&self, text: &mut String) {
        let _ = writeln!(
            text,
            "\n{:>10} {:>12} {:>16} {:>9} {:>9} {:>9}",
            "power", "Mcps", "integration us", "std mm", "bias mm", "missed %"
        );
        for point in &self.sensor {
            let _ = writeln!(
                text,
                "{:>9}x {:>12.3} {:>16.1} {:>9.3} {:>9.3} {:>9}",
                point.relative_power,
                point.detected_rate_cps / 1e6,
                point.integration_s * 1e6,
                point.std_m * 1e3,
                point.bias_m * 1e3,
                percent(point.missed_fraction)
            );
        }
    }
}

fn percent(share: Option<f64>) -> String {
    match share {
        Some(share) => format!("{:.2}", share * 100.0),
        None => "unknown".to_owned(),
    }
}

fn interval(error: f64, ci: [f64; 2]) -> String {
    format!("{:+.2} % [{:+.2}, {:+.2}]", error * 100.0, ci[0] * 100.0, ci[1] * 100.0)
}
