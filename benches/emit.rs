//! How long `emit` takes, for every standard scene: reading the scene, making
//! its codes, and writing the Verilog as text (below 50 ms is asked for).
//!
//!     cargo bench --bench emit

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use goldtof::sensor::Sensor;
use goldtof::{deliver, scene};

const ROUNDS: usize = 21;
const SCENES: &[&str] =
    &["paper-single", "paper-square", "paper-interleaved", "dual-view", "multipath", "quick"];

fn main() -> Result<(), Box<dyn Error>> {
    for name in SCENES {
        let path = format!("scenes/{name}.toml");
        let mut load_ms = Vec::new();
        let mut all_ms = Vec::new();
        for _ in 0..ROUNDS {
            let started = Instant::now();
            let scene = scene::load(Path::new(&path))?;
            load_ms.push(started.elapsed().as_secs_f64() * 1e3);
            deliver::emit(&Sensor::new(&scene), "goldtof emit")?;
            all_ms.push(started.elapsed().as_secs_f64() * 1e3);
        }
        let median = |values: &mut Vec<f64>| {
            values.sort_by(f64::total_cmp);
            values[ROUNDS / 2]
        };
        let (load, all) = (median(&mut load_ms), median(&mut all_ms));
        println!(
            "{name:18} {all:6.2} ms, {:.2} of 50 ms (of which reading the scene {load:.2} ms)",
            all / 50.0
        );
    }
    Ok(())
}
