//! The comparison in words.

use std::fmt::Write as _;

use super::{Comparison, Way};

impl Comparison {
    /// The comparison as a table.
    pub fn to_text(&self) -> String {
        let mut text = format!(
            "{}, path {} at {:.4} m, {:.3} million detections per second\n",
            self.scene,
            self.path,
            self.true_distance_m,
            self.detected_rate_cps / 1e6
        );
        for way in &self.ways {
            way.write(&mut text);
        }
        text += "Pareto: no sensor over the whole range has a smaller error in as little time\n";
        text
    }
}

impl Way {
    fn write(&self, text: &mut String) {
        let cells = match &self.resources {
            Some(resources) => resources.in_short(),
            None => "LUTs unknown".to_owned(),
        };
        let _ = writeln!(
            text,
            "\n{}: {} phase steps, {} at once, {cells}, {} kbit of memory{}",
            self.name,
            self.phase_steps,
            self.parallel,
            self.memory_bits.div_ceil(1024),
            if self.whole_range { "" } else { "; for a distance known to a chip" },
        );
        if !self.points.is_empty() {
            let _ = writeln!(
                text,
                "  {:9} {:>12} {:>14} {:>9} {:>9} {:>10} {:>13}",
                "estimator",
                "time ms",
                "frames per s",
                "bias mm",
                "std mm",
                "error mm",
                "missed below"
            );
        }
        for point in &self.points {
            let missed = match point.coarse_failure_bound_fraction {
                Some(share) => format!("{:.1e}", share),
                None => "-".to_owned(),
            };
            let _ = writeln!(
                text,
                "  {:9} {:>12.4} {:>14.2} {:>9.3} {:>9.3} {:>10.3} {:>13}{}",
                point.estimator.to_string(),
                point.measuring_time_s * 1e3,
                point.frame_rate_hz,
                point.bias_m * 1e3,
                point.std_m * 1e3,
                point.rms_error_m * 1e3,
                missed,
                if point.pareto { "  Pareto" } else { "" },
            );
        }
        for remark in &self.remarks {
            let _ = writeln!(text, "  {remark}");
        }
    }
}
