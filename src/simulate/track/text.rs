//! A tracked target in words.

use std::fmt::Write as _;

use super::TrackReport;

impl TrackReport {
    /// The report in words.
    pub fn to_text(&self) -> String {
        let mut text = format!(
            "{}: {} targets at {} m/s, fidelity {}, seed {}, {:.3} s\n",
            self.scene,
            self.targets,
            self.velocity_m_per_s,
            self.fidelity,
            self.seed,
            self.run_time_s
        );
        let _ = writeln!(
            text,
            "window of {} phase steps, gain {}, threshold {}: {:.1} updates a second",
            self.window_steps, self.gain, self.threshold, self.update_rate_hz
        );
        let _ = writeln!(
            text,
            "  acquired          {} of {}; locked after {} on average, {} at most; expected {}",
            self.acquired,
            self.targets,
            milliseconds(self.time_to_lock_s),
            milliseconds(self.longest_time_to_lock_s),
            milliseconds(Some(self.expected_time_to_lock_s)),
        );
        let _ = writeln!(
            text,
            "  bias              {} +- {}; expected {}",
            millimetres(self.bias_m),
            millimetres(self.bias_std_error_m),
            self.expected_bias_m
                .map_or_else(|| "no hold".to_owned(), |bias| millimetres(Some(bias)))
        );
        let _ = writeln!(
            text,
            "  standard deviation {} +- {}; expected {}",
            millimetres(self.std_m),
            millimetres(self.std_std_error_m),
            self.expected_std_m.map_or_else(|| "no hold".to_owned(), |std| millimetres(Some(std))),
        );
        let _ = write!(
            text,
            "  Cramer-Rao bound  {} of one window ({} with total counts, too), {} at this gain",
            millimetres(Some(self.window_bound_m)),
            millimetres(Some(self.window_bound_with_totals_m)),
            millimetres(Some(self.bound_m))
        );
        let _ = match self.std_over_bound {
            Some(ratio) => writeln!(text, "; measured over bound {ratio:.3}"),
            None => writeln!(text),
        };
        let _ = writeln!(
            text,
            "  lost              {} of {} that were there; of {} taken away {} were told within two updates{}",
            self.lost,
            self.acquired,
            self.taken_away,
            self.told_in_time,
            match self.most_updates_to_tell {
                Some(most) => format!(", all within {most}"),
                None => String::new(),
            }
        );
        let _ = writeln!(
            text,
            "  false alarms      {} of {} windows; expected share {:.1e}",
            self.false_alarms, self.lit_windows, self.expected_false_alarm_fraction
        );
        let _ = writeln!(
            text,
            "  fastest           {:.1} m/s held; expected {:.1} m/s",
            self.fastest_m_per_s, self.expected_fastest_m_per_s
        );
        if !self.expectation_holds {
            text.push_str("  the expectation does not hold\n");
        }
        text
    }
}

fn millimetres(metres: Option<f64>) -> String {
    metres.map_or_else(|| "none".to_owned(), |metres| format!("{:.2} mm", metres * 1e3))
}

fn milliseconds(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| "never".to_owned(), |seconds| format!("{:.3} ms", seconds * 1e3))
}
