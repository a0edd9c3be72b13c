//! The comparison in words.

use std::fmt::Write as _;

use super::{Comparison, Way};
use crate::report::columns::Lines;

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
            *text += &Lines::of(&self.points, "  ")
                .left("estimator", 9, |point| point.estimator.to_string())
                .right("time ms", 12, |point| format!("{:.4}", point.measuring_time_s * 1e3))
                .right("frames per s", 14, |point| format!("{:.2}", point.frame_rate_hz))
                .right("bias mm", 9, |point| format!("{:.3}", point.bias_m * 1e3))
                .right("std mm", 9, |point| format!("{:.3}", point.std_m * 1e3))
                .right("error mm", 10, |point| format!("{:.3}", point.rms_error_m * 1e3))
                .right("missed below", 13, |point| {
                    let missed = point.coarse_failure_bound_fraction;
                    missed.map_or("-".to_owned(), |share| format!("{share:.1e}"))
                })
                .left("", 0, |point| if point.pareto { "  Pareto" } else { "" }.to_owned())
                .text();
        }
        for remark in &self.remarks {
            let _ = writeln!(text, "  {remark}");
        }
    }
}
