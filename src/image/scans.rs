//! Scans of every pixel.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::pixels::seed_of;
use super::{ImageOptions, Map, PIXEL, Seen};
use crate::estimate::distance_m;
use crate::estimate::estimator::EstimatorInput;
use crate::progress::Progress;
use crate::scene::PathIndex;
use crate::sensor::Sensor;
use crate::simulate::Tier;
use crate::simulate::repeat::Ranging;
use crate::simulate::scans::{PreparedTier, ScansError};

/// Pixels that threads share out at a time.
const AT_ONCE: usize = 1024;

/// What frames of an array show.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanMaps {
    /// Frames.
    pub frames: u32,
    /// Distance of the strongest path, in the first frame.
    pub distance_m: Map,
    /// That of the next one; only where pixels have several.
    pub second_distance_m: Option<Map>,
    /// First frame's error: measured less true distance, of the surfaces that the pixel sees the
    /// nearest to it, the shorter way round the range.
    pub error_m: Map,
    /// Mean error of the frames that find the pixel's own path; NaN where none does.
    pub bias_m: Map,
    /// Their standard deviation; NaN of fewer than two.
    pub std_m: Map,
    /// Share of frames that find the path.
    pub found_fraction: Map,
    /// Detections.
    pub detected_rate_cps: Map,
    /// Share of frames that do not tell all of the pixel's paths apart; only where pixels have
    /// several.
    pub untold_fraction: Option<Map>,
}

/// What the scans of one pixel say.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PixelScans {
    /// Distances of the first scan, the strongest path's first.
    pub first_m: Vec<f64>,
    /// Errors of the scans that find the path that is farthest in front.
    pub errors_m: Vec<f64>,
    /// Detections in all scans.
    pub detections: u64,
    /// Scans that do not tell all of its paths apart.
    pub untold: u32,
}

/// What the scans of a row of pixels say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct PixelRow {
    /// From the top.
    pub row: u32,
    /// Its pixels from the left; none of one that gets no light of its own laser.
    pub pixels: Vec<Option<PixelScans>>,
}

/// Simulates scans of one pixel.
pub(super) fn of_pixel(
    of_all: &Sensor,
    seen: &Seen,
    pixel: usize,
    tier: Tier,
    (seed, scans): (u64, u32),
) -> Result<PixelScans, ScansError> {
    let sensor = seen.sensor(of_all, pixel);
    let ranging = Ranging::new(&sensor, PIXEL, tier.counting(&sensor));
    let prepared = PreparedTier::new(&sensor, tier, Default::default())?;
    let front = front(&sensor, &ranging);
    let tolerance_m = ranging.tolerance_m();
    let mut told = PixelScans::default();
    let mut is_first = true;
    prepared.scans(&sensor, PIXEL, seed_of(seed, pixel), 0..u64::from(scans), &mut |counted| {
        told.detections += match counted {
            EstimatorInput::Steps(counts) => counts.iter().map(|count| count.total).sum(),
            EstimatorInput::Bins(histogram) => histogram.total(),
        };
        let answer = ranging.answer(counted);
        let found = answer.found.iter().find(|(place, _)| Some(*place) == front);
        let found = found.filter(|(_, error_m)| error_m.abs() <= tolerance_m);
        told.errors_m.extend(found.map(|(_, error_m)| error_m));
        told.untold += u32::from(answer.is_untold);
        if std::mem::take(&mut is_first) {
            told.first_m = answer.distances_m;
        }
    })?;
    Ok(told)
}

/// The place of the nearest own path.
fn front(sensor: &Sensor, ranging: &Ranging) -> Option<usize> {
    let scene = sensor.scene();
    let own: Vec<PathIndex> = scene.own_paths(PIXEL).collect();
    let places = (0..ranging.paths.len()).filter(|place| own.contains(&ranging.paths[*place]));
    places.min_by(|a, b| {
        let delay = |place: &usize| scene.paths[ranging.paths[*place]].delay_ps;
        delay(a).total_cmp(&delay(b))
    })
}

/// Simulates the lit pixels of some rows. Threads take pixels, each with random numbers of its
/// own, so that nothing depends on which thread takes which, nor on which rows are asked for.
pub(super) fn rows(
    sensor: &Sensor,
    seen: &Seen,
    options: &ImageOptions,
    rows: &[u32],
    on_progress: &mut impl FnMut(Progress),
) -> Result<Vec<PixelRow>, ScansError> {
    let columns = seen.columns as usize;
    let of_row = |row: u32| (0..columns).map(move |column| row as usize * columns + column);
    let all: Vec<usize> = rows.iter().copied().flat_map(of_row).collect();
    let order = (options.seed, options.repetitions);
    let mut told: Vec<Option<PixelScans>> = Vec::with_capacity(all.len());
    for some in all.chunks(AT_ONCE) {
        let of_pixel = |&pixel: &usize| match seen.own_primary_hz[pixel] > 0.0 {
            true => of_pixel(sensor, seen, pixel, options.fidelity, order).map(Some),
            false => Ok(None),
        };
        told.extend(some.par_iter().map(of_pixel).collect::<Result<Vec<_>, _>>()?);
        on_progress(Progress::Parts { done: told.len() as u64, of: all.len() as u64 });
    }
    let pixels = told.chunks(columns).map(<[_]>::to_vec);
    Ok(rows.iter().zip(pixels).map(|(&row, pixels)| PixelRow { row, pixels }).collect())
}

/// The maps of all rows, which are in order.
pub(super) fn maps(sensor: &Sensor, seen: &Seen, rows: Vec<PixelRow>, frames: u32) -> ScanMaps {
    let pixels: Vec<_> = rows.into_iter().flat_map(|row| row.pixels).collect();
    let map = |value: &dyn Fn(usize, &PixelScans) -> Option<f64>| {
        let value = |pixel: usize| pixels[pixel].as_ref().and_then(|told| value(pixel, told));
        seen.map(|pixel| value(pixel).unwrap_or(f64::NAN))
    };
    let range_m = distance_m(sensor.timing().code_period_ps());
    let mean = |errors: &[f64]| errors.iter().sum::<f64>() / errors.len() as f64;
    let std_m = |errors: &[f64]| {
        let squares: f64 = errors.iter().map(|error| (error - mean(errors)).powi(2)).sum();
        (errors.len() > 1).then(|| (squares / (errors.len() - 1) as f64).sqrt())
    };
    let several = seen.lit().any(|pixel| seen.lights[pixel].paths.len() > 1);
    let measured_s = scan_s(sensor) * f64::from(frames);
    let share = |count: f64| count / f64::from(frames);
    ScanMaps {
        frames,
        distance_m: map(&|_, told| told.first_m.first().copied()),
        second_distance_m: several.then(|| map(&|_, told| told.first_m.get(1).copied())),
        error_m: map(&|pixel, told| seen.error_m(pixel, *told.first_m.first()?, range_m)),
        bias_m: map(&|_, told| (!told.errors_m.is_empty()).then(|| mean(&told.errors_m))),
        std_m: map(&|_, told| std_m(&told.errors_m)),
        found_fraction: map(&|_, told| Some(share(told.errors_m.len() as f64))),
        detected_rate_cps: map(&|_, told| Some(told.detections as f64 / measured_s)),
        untold_fraction: several.then(|| map(&|_, told| Some(share(f64::from(told.untold))))),
    }
}

/// Seconds in which a scan counts.
fn scan_s(sensor: &Sensor) -> f64 {
    let timing = sensor.timing();
    let integrations = match sensor.scene().hardware.architecture {
        crate::scene::Architecture::UpDown => timing.scan.steps as f64,
        crate::scene::Architecture::Histogram => 1.0,
    };
    integrations * timing.integration_ps() * 1e-12
}
