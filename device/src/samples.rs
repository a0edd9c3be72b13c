//! Hits by sample of the chip, recorded for `goldtof calibrate`.

use std::io::{Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use goldtof::Sensor;
use goldtof_device::{Device, DeviceError, Line};
use goldtof_system::files;
use goldtof_system::printable::printable_path;
use goldtof_wire::Identity;

use crate::{Failed, description, job};

/// A count goes round after 2^32 hits, of which a chip has at most one at each sample: 10 s at 400 MHz.
const READ_EVERY: Duration = Duration::from_secs(10);

/// Counts for `seconds`, `runs` times over, and writes what `goldtof calibrate` reads: `run,sample,count`, and
/// the name of a detector before them where there are several.
pub(crate) fn record(line: &Line, out: &Path, seconds: f64, runs: u32) -> Result<(), Failed> {
    let length = Duration::try_from_secs_f64(seconds)
        .ok()
        .filter(|length| !length.is_zero())
        .ok_or("--seconds: write a length of time above 0, such as 60")?;
    if runs == 0 {
        return Err("--runs: write a number of recordings, 1 or more".into());
    }
    let (mut device, identity) = line.open()?;
    println!("{}", description(&identity));
    let names = match (identity.detectors, &line.scene) {
        (1, _) => vec![String::new()],
        (_, Some(path)) => {
            let sensor = Sensor::load(path)?;
            let names = sensor.scene().detectors.iter();
            names.map(|detector| format!("{},", detector.name)).collect()
        }
        (several, None) => {
            let told = format!(
                "the device has {several} detectors, whose names are in its scene: name it by --scene"
            );
            return Err(told.into());
        }
    };
    job::check_free(out)?;
    let heading = if identity.detectors == 1 { "" } else { "detector," };
    let mut text = format!("{heading}run,sample,count\n");
    let (mut total, mut before) = (0, device.hits(&identity)?);
    for run in 0..runs {
        let hits = count(&mut device, &identity, length, &mut before)?;
        let detectors = hits.chunks(identity.samples_per_chip.into());
        for (name, hits) in names.iter().zip(detectors) {
            for (sample, hits) in hits.iter().enumerate() {
                text += &format!("{name}{run},{sample},{hits}\n");
                total += hits;
            }
        }
    }
    files::write(out, &text)?;
    println!("{total} hits in {}", printable_path(out));
    Ok(())
}

/// Hits of each sample from `before`, which is moved on, until `length` is over.
fn count<P: Read + Write>(
    device: &mut Device<P>,
    identity: &Identity,
    length: Duration,
    before: &mut Vec<u32>,
) -> Result<Vec<u64>, DeviceError> {
    let mut sums = vec![0; before.len()];
    let ends = Instant::now() + length;
    loop {
        let next = ends.min(Instant::now() + READ_EVERY);
        while Instant::now() < next {
            // Results go by.
            device.next_event()?;
        }
        let hits = device.hits(identity)?;
        for ((sum, now), before) in sums.iter_mut().zip(&hits).zip(&*before) {
            *sum += u64::from(now.wrapping_sub(*before));
        }
        *before = hits;
        if Instant::now() >= ends {
            return Ok(sums);
        }
    }
}
