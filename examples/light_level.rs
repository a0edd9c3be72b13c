//! Bias and scatter of the distance over the light level, as simulated and as theory
//! expects: a table of one's own, without `goldtof sweep`.
//!
//! ```sh
//! cargo run --release --example light_level
//! ```

use std::error::Error;

use goldtof::scene::Setting;
use goldtof::simulate::Tier;
use goldtof::{Jobs as _, Sensor};

/// Mean optical powers of the source, in picowatts.
const POWERS_PW: [f64; 3] = [2.0, 8.0, 32.0];

/// One line of the table, in millimetres.
struct Line {
    power_pw: f64,
    bias_mm: f64,
    expected_bias_mm: f64,
    std_mm: f64,
    expected_std_mm: f64,
}

fn table(repetitions: u64) -> Result<Vec<Line>, Box<dyn Error>> {
    let mut lines = Vec::new();
    for power_pw in POWERS_PW {
        let power: Setting = format!("source[0].mean_power={power_pw} pW").parse()?;
        let sensor = Sensor::load_with("scenes/quick.toml", &[power])?;
        let simulation = sensor.simulate(Tier::Events.scans(repetitions))?;
        let path = &simulation.estimates[0];
        let millimetres = |metres: Option<f64>| metres.map_or(f64::NAN, |metres| 1e3 * metres);
        lines.push(Line {
            power_pw,
            bias_mm: millimetres(path.bias_m),
            expected_bias_mm: millimetres(path.expected_bias_m),
            std_mm: millimetres(path.std_m),
            expected_std_mm: millimetres(path.expected_std_m),
        });
    }
    Ok(lines)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("power      bias   expected       std   expected");
    for line in table(300)? {
        println!(
            "{:2} pW {:6.1} mm {:7.1} mm {:6.1} mm {:7.1} mm",
            line.power_pw, line.bias_mm, line.expected_bias_mm, line.std_mm, line.expected_std_mm
        );
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_simulated_is_what_theory_expects() {
        let repetitions = 200;
        let lines = super::table(repetitions).unwrap();
        for line in &lines {
            let std_error_mm = line.std_mm / (repetitions as f64).sqrt();
            let off = (line.bias_mm - line.expected_bias_mm).abs();
            assert!(off < 4.0 * std_error_mm, "{} pW: {off} mm", line.power_pw);
        }
        // Range walk: more light, earlier; and less scatter.
        assert!(lines[2].expected_bias_mm < lines[0].expected_bias_mm - 10.0);
        assert!(lines[2].std_mm < 0.7 * lines[0].std_mm);
    }
}
