//! Photons and reference model against the sensor itself.
//!
//! One core makes the detections of paper-single, at ten million a second, their
//! sample words, and the expected value of every output port at every clock.
//! Prints seconds of that work per second of sensor time (below 1 is asked for),
//! and nanoseconds per detection.
//!
//!     cargo bench --bench reference

use goldtof::scene::DetectorIndex;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

use goldtof::photons::DetectorModel;
use goldtof::reference::blocks::{Block, BlockMaker};
use goldtof::reference::photons::Photons;
use goldtof::reference::predictor::ReferenceModel;
use goldtof::scene;
use goldtof::sensor::Sensor;
use goldtof::sensor::interface::Interface;
use goldtof::sensor::layout::Layout;

const CLOCKS: u64 = 25_000_000;
const ROUNDS: usize = 7;
const DETECTIONS_PER_S: f64 = 10e6;

fn main() -> Result<(), Box<dyn Error>> {
    let mut scene = scene::load(Path::new("scenes/paper-single.toml"))?;
    let mut ratios: Vec<(f64, f64)> = Vec::new();
    for round in 0..ROUNDS {
        // The dead time stands between light and hits, so the light is found by
        // what the round before counted.
        if let Some(&(_, hits_per_s)) = ratios.last() {
            scene.sources[0].mean_power_w *= DETECTIONS_PER_S / hits_per_s;
        }
        let interface = Interface::of(&scene);
        let layout = Layout::of(&interface);
        let detectors = [DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0))];
        let mut reference = ReferenceModel::new(interface.clone())?;
        let mut photons = Photons::new(&detectors, &interface, round as u64);
        let mut maker = BlockMaker::new(&mut reference, &mut photons, &layout, CLOCKS);
        let mut block = Block::default();
        let mut hits = 0;
        let started = Instant::now();
        while maker.make(&mut block) {
            hits += maker.hits()[0].len();
        }
        let work_s = started.elapsed().as_secs_f64();
        let sensor_s = CLOCKS as f64 * scene.chip_period_ps * 1e-12;
        let rate = hits as f64 / sensor_s;
        println!(
            "{:5.2} million hits/s: {:.3} s per second of sensor time, {:.1} ns per hit",
            rate / 1e6,
            work_s / sensor_s,
            work_s / hits as f64 * 1e9
        );
        ratios.push((work_s / sensor_s, rate));
    }
    // The first two rounds only find the light.
    let mut seconds: Vec<f64> = ratios[2..].iter().map(|r| r.0).collect();
    seconds.sort_by(f64::total_cmp);
    println!("median {:.3} s of one core per second of sensor time", seconds[seconds.len() / 2]);
    Ok(())
}
