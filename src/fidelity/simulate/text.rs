//! A simulation in words.

use std::fmt::Write as _;

use super::{PathStatistics, Simulation};

impl Simulation {
    /// The simulation in words.
    pub fn to_text(&self) -> String {
        let mut text = format!(
            "{}: {} scans, fidelity {}, estimator {}, seed {}, {:.2} s\n",
            self.scene, self.repetitions, self.fidelity, self.estimator, self.seed, self.run_time_s
        );
        for estimate in &self.estimates {
            estimate.write(self.repetitions, &mut text);
        }
        text
    }
}

impl PathStatistics {
    fn write(&self, repetitions: u64, text: &mut String) {
        let millimetres = |value: Option<f64>| match value {
            Some(metres) => format!("{:.2} mm", metres * 1e3),
            None => "none".to_owned(),
        };
        let _ = writeln!(
            text,
            "{}, path {} of {} at {:.4} m: bias {} +- {}, standard deviation {} +- {}, coarse \
             stage right in {:.1} % of {repetitions}",
            self.detector,
            self.path,
            self.source,
            self.true_m,
            millimetres(self.bias_m),
            millimetres(self.std_error_m),
            millimetres(self.std_m),
            millimetres(self.std_std_error_m),
            self.correct_coarse_fraction * 100.0,
        );
        if let Some(at_s) = self.true_at_s {
            let _ = writeln!(
                text,
                "  moving: the distance is that of {:.4} ms after the start of the scan",
                at_s * 1e3
            );
        }
        if self.expected_bias_m.is_some() {
            let _ = writeln!(
                text,
                "  expected: bias {}, standard deviation {}",
                millimetres(self.expected_bias_m),
                millimetres(self.expected_std_m)
            );
        }
        if self.bound_m.is_some() {
            let _ = write!(
                text,
                "  Cramer-Rao bound of the standard deviation: {}",
                millimetres(self.bound_m)
            );
            let _ = match self.std_over_bound {
                Some(ratio) => writeln!(text, "; measured over bound {ratio:.3}"),
                None => writeln!(text),
            };
        }
        if let Some(share) = self.chi_square_alarm_fraction {
            let _ = writeln!(
                text,
                "  chi-square alarm in {:.1} % of the fits",
                share * 100.0
            );
        }
        let _ = writeln!(
            text,
            "  {:.3} million detections per second",
            self.detected_rate_cps / 1e6
        );
        for remark in [&self.remark, &self.bound_remark].into_iter().flatten() {
            let _ = writeln!(text, "  {remark}");
        }
    }
}
