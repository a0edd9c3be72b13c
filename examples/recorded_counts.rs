//! A program of a sensor's own host: counts come from the hardware, here from a run of its
//! Verilog, and become a distance.
//!
//! ```sh
//! cargo run --example recorded_counts
//! ```

use std::error::Error;
use std::path::Path;

use goldtof::photons::StepCount;
use goldtof::{EstimateOptions, Jobs as _, RunOptions, Sensor};

/// The distance that the counts give, and that of the target, in metres.
fn distances(folder: &Path) -> Result<(f64, f64), Box<dyn Error>> {
    let sensor = Sensor::load("scenes/quick.toml")?;
    sensor.run(&RunOptions { out: Some(folder.to_owned()), ..Default::default() })?;

    // Signed counts in the order of the phase steps: columns of counts.csv.
    let text = std::fs::read_to_string(folder.join("counts.csv"))?;
    let mut lines = text.lines();
    let heading: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let column = heading.iter().position(|name| *name == "count");
    let column = column.ok_or("counts.csv has no column count")?;
    let mut counts = Vec::new();
    for line in lines {
        let field = line.split(',').nth(column).ok_or("a line is too short")?;
        let signed = field.parse()?;
        // The phase needs no total counts.
        counts.push(StepCount { signed, total: 0 });
    }

    let estimate = sensor.estimate(&EstimateOptions::default(), &counts)?;
    let distance_m = estimate.distance_m.ok_or("the counts give no distance")?;
    Ok((distance_m, sensor.scene().paths[0].distance_m()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (distance_m, true_distance_m) = distances(Path::new("target/recorded_counts"))?;
    println!("{distance_m:.4} m, and the target is at {true_distance_m:.4} m");
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_target_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let (distance_m, true_distance_m) = super::distances(folder.path()).unwrap();
        assert_eq!(true_distance_m, 3.2);
        // A chip is 1.2 m, a phase step 0.15 m.
        assert!((distance_m - true_distance_m).abs() < 0.15, "{distance_m}");
    }
}
