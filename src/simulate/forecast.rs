//! How long a simulation will take, from a short one of the same light.

use std::time::Instant;

use super::scans::scans;
use super::{Tier, effort};
use crate::estimate::TheoryEffort;
use crate::photons::DetectorModel;
use crate::reference::stimulus::clocks_for_scans;
use crate::scene::{Architecture, DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

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
            Tier::Counts => effort.map_or(0.0, |effort| effort.draws_s()),
            Tier::Events | Tier::Sampled | Tier::Rtl => {
                repetitions as f64 * scan_s(sensor, detector, tier).unwrap_or(0.0)
            }
        };
        if sensor.scene().estimator == EstimatorKind::Model && tier.draws() {
            seconds += repetitions as f64 * effort.map_or(0.0, |effort| effort.fit_s());
        }
    }
    (seconds > 0.0).then_some(seconds)
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
