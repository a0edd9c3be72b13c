//! A simulation in words.

use std::fmt::Write as _;

use super::Simulation;
use crate::simulate::path_statistics::PathStatistics;

impl Simulation {
    /// The simulation in words.
    pub fn to_text(&self) -> String {
        let drawn = match self.fidelity.draws() {
            true => format!("{} scans, ", self.repetitions),
            false => String::new(),
        };
        let mut text = format!(
            "{}: {drawn}fidelity {}, estimator {}, seed {}, {:.3} s\n",
            self.scene, self.fidelity, self.estimator, self.seed, self.run_time_s
        );
        for estimate in &self.estimates {
            estimate.write(self, &mut text);
        }
        text
    }
}

impl PathStatistics {
    fn write(&self, simulation: &Simulation, text: &mut String) {
        let draws = simulation.fidelity.draws();
        let right = percent(self.correct_coarse_fraction);
        let of_scans = match draws {
            true => simulation.repetitions.to_string(),
            false => "all scans".to_owned(),
        };
        let _ = writeln!(
            text,
            "{}, path {} of {} at {:.4} m: bias {}, standard deviation {}, coarse stage right in \
             {right} of {of_scans}",
            self.detector,
            self.path,
            self.source,
            self.true_distance_m,
            with_error(self.bias_m, self.bias_std_error_m),
            with_error(self.std_m, self.std_std_error_m),
        );
        if let Some(at_s) = self.true_distance_at_s {
            let _ = writeln!(
                text,
                "  moving: the distance is that of {:.4} ms after the start of the scan",
                at_s * 1e3
            );
        }
        self.write_theory(draws, text);
        if let Some(share) = self.refused_fraction.filter(|&share| share > 0.0) {
            let _ = writeln!(
                text,
                "  `goldtof estimate` would refuse {} of the scans: their peak may be chance",
                percent(Some(share))
            );
        }
        if let Some(share) = self.chi_square_alarm_fraction {
            let _ = writeln!(text, "  chi-square alarm in {:.1} % of the fits", share * 100.0);
        }
        let _ =
            writeln!(text, "  {:.3} million detections per second", self.detected_rate_cps / 1e6);
        for remark in [&self.remark, &self.bound_remark].into_iter().flatten() {
            let _ = writeln!(text, "  {remark}");
        }
    }

    /// What is expected, beside what was drawn if anything was, and the bound.
    fn write_theory(&self, draws: bool, text: &mut String) {
        if draws && self.expected_bias_m.is_some() {
            let _ = writeln!(
                text,
                "  expected: bias {}, standard deviation {}, coarse stage right in {}",
                millimetres(self.expected_bias_m),
                millimetres(self.expected_std_m),
                percent(self.expected_missed_fraction.map(|missed| 1.0 - missed)),
            );
        }
        if let Some(remark) = &self.expectation_remark {
            let _ = writeln!(text, "  the expectation does not hold: {remark}");
        }
        if let Some(kind) = self.bound_kind {
            let _ = write!(text, "  {}: {}", kind.name(), millimetres(self.bound_m));
            let of = if draws { "measured" } else { "expected" };
            let _ = match self.std_over_bound {
                Some(ratio) => writeln!(text, "; {of} over it {ratio:.3}"),
                None => writeln!(text),
            };
        }
    }
}

fn millimetres(metres: Option<f64>) -> String {
    match metres {
        Some(metres) => format!("{:.2} mm", metres * 1e3),
        None => "none".to_owned(),
    }
}

fn with_error(metres: Option<f64>, error_m: Option<f64>) -> String {
    match error_m {
        Some(_) => format!("{} +- {}", millimetres(metres), millimetres(error_m)),
        None => millimetres(metres),
    }
}

fn percent(share: Option<f64>) -> String {
    match share {
        Some(share) => format!("{:.1} %", share * 100.0),
        None => "an unknown share".to_owned(),
    }
}
