//! What people read: plots, tables, the report page.

pub mod chart;
pub mod page;
pub mod plot;

use crate::scene::Scene;
use std::fmt::Write as _;

/// The counts of a scan as CSV: number of the measurement, phase step, its
/// calibrated distance, count.
pub fn counts_csv(scene: &Scene, distances_m: &[f64], counts: &[i64]) -> String {
    let mut text = "measurement,phase_step,distance_m,count\n".to_owned();
    for (j, (distance_m, count)) in distances_m.iter().zip(counts).enumerate() {
        let step = scene.scan.step(j as u64);
        let _ = writeln!(text, "{j},{step},{distance_m:.6},{count}");
    }
    text
}
