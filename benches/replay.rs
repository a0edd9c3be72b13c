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
use rustix::time::{ClockId, clock_gettime};

const ROUNDS: usize = 5;
const PHOTONS: u64 = 20_000_000;

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
        let mut tags = Vec::new();
        while reader.read(&mut tags)? {}
        Ok(reader.records())
    })?;
    measure("replayed", records, || {
        let mut reader = TagReader::new(Cursor::new(&bytes), "bench", None)?;
        Ok(replay(&sensor, &mut reader, &options, |_| ())?.file.records)
    })
}

/// A HydraHarp's records: photons 200 ns apart on average, with a mark at each code period.
fn recording(period: u64) -> Vec<u8> {
    let tag = |name: &str, kind: u32, value: u64| {
        let mut tag = vec![0; 32];
        tag[..name.len()].copy_from_slice(name.as_bytes());
        tag.extend((-1_i32).to_le_bytes());
        tag.extend(kind.to_le_bytes());
        tag.extend(value.to_le_bytes());
        tag
    };
    let mut bytes = b"PQTTTR\0\x001.0.00\0\0".to_vec();
    bytes.extend(tag("MeasDesc_GlobalResolution", 0x2000_0008, 1e-12_f64.to_bits()));
    bytes.extend(tag("TTResultFormat_TTTRRecType", 0x1000_0008, 0x0101_0204));
    bytes.extend(tag("Header_End", 0xFFFF_0008, 0));
    let (mut random, mut ticks, mut mark, mut overflows) = (1_u64, 0_u64, 0_u64, 0_u64);
    let mut put = |ticks: u64, channel: u32| {
        if ticks >> 25 > overflows {
            bytes.extend((0xFE00_0000 | ((ticks >> 25) - overflows) as u32).to_le_bytes());
            overflows = ticks >> 25;
        }
        bytes.extend((channel << 25 | (ticks & 0x01FF_FFFF) as u32).to_le_bytes());
    };
    for _ in 0..PHOTONS {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        ticks += 14_000 + (random >> 33) % 372_000;
        while mark <= ticks {
            put(mark, 0x41);
            mark += period;
        }
        put(ticks, 0);
    }
    bytes
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
