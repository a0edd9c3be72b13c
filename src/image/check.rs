//! Pixels, simulated photon by photon, beside theory.

use rand::SeedableRng as _;
use rand::seq::index::sample;
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use serde::Serialize;

use super::scans::{PixelScans, of_pixel};
use super::table::{ExpectedPixel, expected};
use super::{ImageError, ImageOptions, Lens, PIXEL, ScanMaps, Seen, TheoryMaps};
use crate::sensor::Sensor;
use crate::simulate::Tier;

/// Simulated pixels held against the interpolated theory of each.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Check {
    /// How they were simulated.
    pub fidelity: Tier,
    /// Pixels that were simulated and have an expectation.
    pub pixels: usize,
    /// Those that found their path.
    pub found: usize,
    /// Their z, (error - expected bias) / expected standard deviation: its mean.
    pub mean_deviation_in_std: Option<f64>,
    /// Its root mean square: 1 if theory is right.
    pub rms_deviation_in_std: Option<f64>,
    /// Its largest absolute value.
    pub largest_deviation_in_std: Option<f64>,
    /// Pixels that missed their path.
    pub missed: usize,
    /// Share of all that was expected to.
    pub expected_missed_fraction: f64,
}

/// One pixel in detail.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PixelReport {
    /// From the top.
    pub row: u32,
    /// From the left.
    pub column: u32,
    /// Distance of each surface that it sees, the nearest first.
    pub true_distances_m: Vec<f64>,
    /// Depth of the nearest, along the axis.
    pub true_depth_m: Option<f64>,
    /// Photons of its own source's nearest path that would fire a detector which is always ready.
    pub own_primary_hz: f64,
    /// Photons of the background that would.
    pub background_hz: f64,
    /// What theory expects of exactly this pixel: mean error.
    pub expected_bias_m: Option<f64>,
    /// Standard deviation.
    pub expected_std_m: Option<f64>,
    /// Share of scans that miss it.
    pub expected_missed_fraction: Option<f64>,
    /// The standard deviation that the image has, from the table.
    pub interpolated_std_m: Option<f64>,
    /// How it was simulated.
    pub fidelity: Tier,
    /// Every distance that its scan shows, the strongest path's first.
    pub distances_m: Vec<f64>,
    /// Error of the nearest path's distance, if the scan finds it.
    pub error_m: Option<f64>,
    /// That in standard deviations from what is expected.
    pub deviation_in_std: Option<f64>,
}

/// Holds pixels against theory: `options.check` of them simulated for it, or, of an image that is
/// simulated, all of its first frame.
pub(super) fn check(
    sensor: &Sensor,
    seen: &Seen,
    theory: Option<&TheoryMaps>,
    measured: &ScanMaps,
    options: &ImageOptions,
) -> Result<Option<Check>, ImageError> {
    let Some(theory) = theory else { return Ok(None) };
    let told: Vec<usize> = (0..seen.lights.len()).filter(|&p| theory.pixels[p].is_some()).collect();
    if options.fidelity != Tier::Expected {
        // Several frames are summed up, and a pixel's errors are no longer there one by one.
        if measured.frames > 1 {
            return Ok(None);
        }
        let errors = told.iter().filter_map(|&pixel| {
            let found = measured.found_fraction.values[pixel] > 0.0;
            Some((theory.pixels[pixel]?, found.then_some(measured.bias_m.values[pixel])))
        });
        return Ok(Some(Check::of(options.fidelity, errors)));
    }
    if options.check == 0 || told.is_empty() {
        return Ok(None);
    }
    let mut random = Xoshiro256PlusPlus::seed_from_u64(options.seed);
    let chosen = sample(&mut random, told.len(), told.len().min(options.check as usize));
    let mut chosen: Vec<usize> = chosen.into_iter().map(|place| told[place]).collect();
    chosen.sort_unstable();
    let scan = |&pixel: &usize| of_pixel(sensor, seen, pixel, options.photons(), (options.seed, 1));
    let scans: Vec<PixelScans> = chosen.par_iter().map(scan).collect::<Result<_, _>>()?;
    let errors = chosen.iter().zip(&scans).filter_map(|(&pixel, scans)| {
        Some((theory.pixels[pixel]?, scans.errors_m.first().copied()))
    });
    Ok(Some(Check::of(options.photons(), errors)))
}

impl Check {
    /// Of pixels with what is expected of each, and its error if it found its path.
    fn of(fidelity: Tier, errors: impl Iterator<Item = (ExpectedPixel, Option<f64>)>) -> Check {
        let (mut pixels, mut expected_missed) = (0_u32, 0.0);
        let mut z: Vec<f64> = Vec::new();
        for (expected, error_m) in errors {
            pixels += 1;
            if expected.missed_fraction.is_finite() {
                expected_missed += expected.missed_fraction;
            }
            z.extend(error_m.map(|error_m| (error_m - expected.bias_m) / expected.std_m));
        }
        let count = z.len() as f64;
        let some = |value: f64| (!z.is_empty()).then_some(value);
        Check {
            fidelity,
            pixels: pixels as usize,
            found: z.len(),
            mean_deviation_in_std: some(z.iter().sum::<f64>() / count),
            rms_deviation_in_std: some((z.iter().map(|z| z * z).sum::<f64>() / count).sqrt()),
            largest_deviation_in_std: some(z.iter().fold(0.0, |most: f64, z| most.max(z.abs()))),
            missed: pixels as usize - z.len(),
            expected_missed_fraction: expected_missed / f64::from(pixels.max(1)),
        }
    }
}

/// The pixels that were asked for.
pub(super) fn pixels(
    of_all: &Sensor,
    seen: &Seen,
    theory: Option<&TheoryMaps>,
    options: &ImageOptions,
) -> Result<Vec<PixelReport>, ImageError> {
    let scene = of_all.scene();
    let lens: Option<Lens> = scene.array.as_ref().map(|array| array.lens);
    let report = |place: &super::options::PixelPlace| {
        let columns = lens.map_or(0, |lens| lens.columns as usize);
        let pixel = place.row as usize * columns + place.column as usize;
        let light = &seen.lights[pixel];
        let spad = &scene.detectors[PIXEL];
        let tier = options.photons();
        let sensor = seen.sensor(of_all, pixel);
        let counting = options.fidelity.counting(of_all);
        let exact = (light.paths.len() == 1).then(|| expected(&sensor, counting).ok()).flatten();
        let scans = match seen.own_primary_hz[pixel] > 0.0 {
            true => of_pixel(of_all, seen, pixel, tier, (options.seed, 1))?,
            false => PixelScans::default(),
        };
        let error_m = scans.errors_m.first().copied();
        let background = light.background_rate_cps.unwrap_or(spad.background_rate_cps);
        let interpolated = theory.and_then(|theory| theory.pixels[pixel]);
        Ok(PixelReport {
            row: place.row,
            column: place.column,
            true_distances_m: light.distances_m.clone(),
            true_depth_m: Some(seen.true_depth_m(pixel)).filter(|depth| depth.is_finite()),
            own_primary_hz: seen.own_primary_hz[pixel],
            background_hz: background * spad.photon_detection_probability,
            expected_bias_m: exact.map(|expected| expected.bias_m),
            expected_std_m: exact.map(|expected| expected.std_m),
            expected_missed_fraction: exact
                .map(|expected| expected.missed_fraction)
                .filter(|share| share.is_finite()),
            interpolated_std_m: interpolated.map(|expected| expected.std_m),
            fidelity: tier,
            distances_m: scans.first_m,
            error_m,
            deviation_in_std: error_m
                .zip(exact)
                .map(|(error_m, expected)| (error_m - expected.bias_m) / expected.std_m),
        })
    };
    options.pixels.par_iter().map(report).collect()
}
