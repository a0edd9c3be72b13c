//! How long a simulation will take, from a short one of the same light.

use std::time::Instant;

use rand::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::scans::scans;
use super::{Tier, effort};
use crate::estimate::fit::{BinFitter, Fitter};
use crate::estimate::{TheoryEffort, Work};
use crate::photons::DetectorModel;
use crate::reference::stimulus::clocks_for_scans;
use crate::response::{MeanCount, MeanResponse};
use crate::scene::{Architecture, DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

/// Fits that are told to take no longer together are not tried.
const LEAST_FITS_S: f64 = 5.0;
/// Fits that are tried: the first, and some with its tables.
const TRIED_FITS: usize = 3;
/// Detections of the short simulation, about, and phase steps that it has at most.
const DETECTIONS: f64 = 2e5;
const STEPS: u64 = 64;
/// Chips of it at most.
const CHIPS: f64 = 4e6;
/// A simulation of no more times as much is not worth the measurement.
const LEAST_RATIO: f64 = 8.0;
/// Beyond so many detections before its first step the short simulation would be
/// long itself; then a detection is taken to last as long as it does elsewhere.
const MOST_WARM_UP: f64 = 5.0 * DETECTIONS;

/// Seconds that `repetitions` scans of every detector take, and what follows from
/// them; `None` where that is soon done, or not known.
pub fn seconds(sensor: &Sensor, tier: Tier, repetitions: u64) -> Option<f64> {
    let mut seconds = 0.0;
    for detector in DetectorIndex::of(&sensor.scene().detectors) {
        let effort = TheoryEffort::of(sensor, detector).ok();
        seconds += match tier {
            Tier::Expected => 0.0,
            Tier::Counts => effort.map_or(0.0, |effort| effort.seconds(Work::Draws)),
            Tier::Events | Tier::Sampled | Tier::Rtl => {
                repetitions as f64 * scan_s(sensor, detector, tier).unwrap_or(0.0)
            }
        };
        if sensor.scene().estimator == EstimatorKind::Model && tier.draws() {
            let told_s = effort.map_or(0.0, |effort| effort.seconds(Work::Fit));
            if repetitions as f64 * told_s > LEAST_FITS_S {
                seconds += fits_s(sensor, detector, tier, repetitions).unwrap_or(0.0);
            }
        }
    }
    (seconds > 0.0).then_some(seconds)
}

/// What the fits of all scans take, by how long the first few do; none where one fails.
fn fits_s(sensor: &Sensor, detector: DetectorIndex, tier: Tier, repetitions: u64) -> Option<f64> {
    let model = DetectorModel::new(sensor, detector);
    let counting = tier.counting(sensor);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut noisy = |mean: f64, variance: f64| -> f64 {
        let z: f64 = StandardNormal.sample(&mut rng);
        mean + z * variance.max(0.0).sqrt()
    };
    let took_s = if sensor.scene().hardware.architecture == Architecture::Histogram {
        let fitter = BinFitter::new(sensor, detector).ok()?;
        let bins = MeanResponse::of_tier(&model, counting).ok()?.mean_bins();
        trial(|| {
            let counts: Vec<f64> = bins.iter().map(|&bin| noisy(bin, bin).max(0.0)).collect();
            fitter.fit_means(&counts).is_ok()
        })
    } else {
        let fitter = Fitter::new(sensor, detector, counting, sensor.scene().other_light);
        let means = MeanResponse::of_tier(&model, counting).ok()?.mean_counts();
        trial(|| {
            let counts = means.iter().map(|mean| MeanCount {
                signed: noisy(mean.signed, mean.total),
                total: noisy(mean.total, mean.total).max(0.0),
            });
            fitter.fit_means(&counts.collect::<Vec<_>>()).is_ok()
        })
    };
    Some(all_fits_s(&took_s?, repetitions, rayon::current_num_threads()))
}

/// How long some fits take, one after another; none if one fails.
fn trial(mut fit: impl FnMut() -> bool) -> Option<Vec<f64>> {
    let one = |_| {
        let started = Instant::now();
        fit().then(|| started.elapsed().as_secs_f64())
    };
    (0..TRIED_FITS).map(one).collect()
}

/// How long so many fits take on some cores, by the first few. The first makes tables that
/// others find again: it is not part of their rate.
fn all_fits_s(took_s: &[f64], fits: u64, cores: usize) -> f64 {
    let Some((first_s, others_s)) = took_s.split_first() else { return 0.0 };
    let each_s = others_s.iter().sum::<f64>() / others_s.len().max(1) as f64;
    first_s + each_s * fits.saturating_sub(1) as f64 / cores.max(1) as f64
}

/// What one scan takes, by how long a short one of the same light does.
fn scan_s(sensor: &Sensor, detector: DetectorIndex, tier: Tier) -> Option<f64> {
    let model = DetectorModel::new(sensor, detector);
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        return (tier != Tier::Rtl).then(|| effort::scan_s(sensor, &model, tier));
    }
    let per_chip = model.most_work_per_chip();
    let warm_up = model.warm_up_chips() as f64;
    let groups = model.timing.groups() as f64;
    let chips_of = |groups: f64, integration: f64| groups * (warm_up + integration);
    let integration = sensor.timing().scan.integration_chips as f64;

    let timing = sensor.timing();
    let short_steps = (STEPS * u64::from(timing.parallel)).min(timing.scan.steps);
    let short_groups = short_steps.div_ceil(u64::from(timing.parallel)) as f64;
    let most = (DETECTIONS / per_chip.max(1e-9)).min(CHIPS) / short_groups;
    let short_integration = most.clamp(1.0, integration).floor();
    let short = sensor.with(|scene| {
        scene.scan.steps = short_steps;
        scene.scan.integration_chips = short_integration as u64;
    });
    if warm_up * per_chip * short_groups > MOST_WARM_UP {
        return Some(effort::scan_s(sensor, &model, tier));
    }
    // The Verilog is at best as quick as the model that it is compared with.
    let (tier, work) = match tier {
        Tier::Events => {
            (tier, chips_of(groups, integration) / chips_of(short_groups, short_integration))
        }
        _ => {
            let clocks = |sensor: &Sensor| clocks_for_scans(sensor.interface(), 1) as f64;
            (Tier::Sampled, clocks(sensor) / clocks(&short))
        }
    };
    if work < LEAST_RATIO {
        return None;
    }
    let started = Instant::now();
    scans(&short, detector, tier, 1, 1, |_| ()).ok()?;
    Some(work * started.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first fit of ten seconds, which is not the rate of the others.
    #[test]
    fn the_first_fits_tables_are_forecast_once() {
        let forecast_s = all_fits_s(&[10.0, 0.1, 0.3], 101, 2);
        assert!((forecast_s - 20.0).abs() < 1e-9, "{forecast_s}");
        assert!((all_fits_s(&[10.0], 101, 2) - 10.0).abs() < 1e-9);
    }
}
