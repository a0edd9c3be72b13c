//! Recorded photons: how many records a second are decoded, and replayed, on one core: read, put in order
//! of the code's epochs, folded.
//!
//! Prints millions of records a second of processor time, the best of some rounds.
//!
//!     cargo bench --bench replay

use std::error::Error;
use std::io::Cursor;
use std::path::Path;

use goldtof::replay::{ReplayOptions, replay};
use goldtof::scene;
use goldtof::sensor::Sensor;
use goldtof_tags::{Channel, TagReader};
use optics_support::recordings::Hydraharp;
use rustix::time::{ClockId, clock_gettime};

const ROUNDS: usize = 3;
/// Of 20 s, of which the first scan, whose pulses are kept, takes 1.7 s.
const PHOTONS: u64 = 100_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let sensor = Sensor::new(&scene::load(Path::new("scenes/paper-single.toml"))?);
    let bytes = recording(sensor.timing().code_period_ps() as u64);
    let records = (bytes.len() / 4) as f64;
    let options = ReplayOptions {
        photons: vec![Channel::Input(1)],
        epoch: Channel::Marker(1),
        epoch_periods: 1,
    };
    println!("{:.1} million records, 5 million photons a second", records / 1e6);
    measure("decoded", records, || {
        let mut reader = TagReader::new(Cursor::new(&bytes), "bench", None)?;
        let mut ticks = [const { Vec::new() }; 2];
        while reader.read_channels(&[options.photons[0], options.epoch], &mut ticks)? {
            ticks.iter_mut().for_each(Vec::clear);
        }
        Ok(reader.records())
    })?;
    measure("replayed", records, || {
        let mut reader = TagReader::new(Cursor::new(&bytes), "bench", None)?;
        Ok(replay(&sensor, &mut reader, &options, |_| ())?.file.records)
    })
}

/// Photons 200 ns apart on average, with a mark at each code period.
fn recording(period: u64) -> Vec<u8> {
    let mut file = Hydraharp::default();
    let (mut random, mut ticks, mut mark) = (1_u64, 0_u64, 0_u64);
    for _ in 0..PHOTONS {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ticks += 14_000 + (random >> 33) % 372_000;
        while mark <= ticks {
            file.put(mark, -1);
            mark += period;
        }
        file.put(ticks, 0);
    }
    file.file()
}

fn measure(
    what: &str,
    records: f64,
    job: impl Fn() -> Result<u64, Box<dyn Error>>,
) -> Result<(), Box<dyn Error>> {
    let now = || {
        let time = clock_gettime(ClockId::ProcessCPUTime);
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    };
    let mut best = f64::INFINITY;
    for _ in 0..ROUNDS {
        let begun = now();
        std::hint::black_box(job()?);
        best = best.min(now() - begun);
    }
    println!("{what:>9}: {:6.0} million records a second", records / best / 1e6);
    Ok(())
}
