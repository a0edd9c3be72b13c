//! A frame drawn from theory.

use rand::{RngExt as _, SeedableRng as _};
use rand_distr::{Distribution as _, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::pixels::seed_of;
use super::{PIXEL, ScanMaps, Seen, TheoryMaps};
use crate::estimate::unwrap::fold_distance;
use crate::estimate::{CountingTier, calibration_offset_ps, distance_m};
use crate::sensor::Sensor;

/// One frame: of each pixel an error with the bias and the scatter that theory expects, or, in as
/// many pixels as it expects to miss, a distance anywhere in the scan.
pub(super) fn frame(sensor: &Sensor, seen: &Seen, theory: &TheoryMaps, seed: u64) -> ScanMaps {
    let range_m = distance_m(sensor.timing().code_period_ps());
    let scan = &sensor.timing().scan;
    let step_ps = sensor.clock().sample_period_ps();
    let offset_ps = calibration_offset_ps(sensor, PIXEL, CountingTier::Sampled);
    let measured = |pixel: usize| {
        let expected = theory.pixels[pixel].as_ref()?;
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed_of(seed, pixel));
        let normal: f64 = StandardNormal.sample(&mut random);
        let is_missed = random.random::<f64>() < expected.missed_fraction;
        let anywhere = scan.first_step as f64 + random.random::<f64>() * scan.steps as f64;
        let distance_m = match is_missed {
            false => seen.true_distance_m(pixel) + expected.bias_m + expected.std_m * normal,
            true => distance_m(anywhere * step_ps - offset_ps),
        };
        Some(fold_distance(distance_m, range_m))
    };
    let distance_m = seen.map(|pixel| measured(pixel).unwrap_or(f64::NAN));
    let error_m = seen.map(|pixel| {
        let measured_m = Some(distance_m.values[pixel]).filter(|m| m.is_finite());
        measured_m.and_then(|m| seen.error_m(pixel, m, range_m)).unwrap_or(f64::NAN)
    });
    let columns = seen.columns;
    ScanMaps {
        frames: 1,
        distance_m,
        second_distance_m: None,
        error_m,
        bias_m: theory.map(columns, |expected| expected.bias_m),
        std_m: theory.map(columns, |expected| expected.std_m),
        found_fraction: theory.map(columns, |expected| 1.0 - expected.missed_fraction),
        detected_rate_cps: theory.map(columns, |expected| expected.detected_rate_cps),
        untold_fraction: None,
    }
}
