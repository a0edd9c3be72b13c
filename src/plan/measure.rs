//! What the parts of the simulation that were left out would cost.
//!
//! The fast photon engine counts some 100,000 detections of the scene's light,
//! with the part and without, in turns; the least time of each counts. A part
//! that is put back does the same to the counts as one that is left out, so only
//! the time differs.

use crate::scene::DetectorIndex;
use std::hint::black_box;
use std::time::{Duration, Instant};

use super::{Plan, Saving};
use crate::photons::fast::StepCounter;
use crate::photons::{DetectorModel, OptionalPart, StepCount};
use crate::response::Light;
use crate::sensor::Sensor;

/// Detections that are counted at a time, about.
const DETECTIONS: f64 = 1e5;
/// The time of fewer is that of everything else.
const LEAST_DETECTIONS: u64 = 10_000;
/// Phase steps that they are spread over: two for each lane of the engine.
const STEPS: u64 = 128;
/// Times that each is measured.
const ROUNDS: usize = 7;
/// Most detections before the steps, which make the detector forget its start.
const MOST_WARM_UP_DETECTIONS: f64 = 4.0 * DETECTIONS;
/// Measuring ends after so long.
const MOST_TIME: Duration = Duration::from_millis(1200);
/// The engine goes at least this often through its loop, per chip.
const ITERATIONS_PER_CHIP: f64 = 1e-3;

/// Adds to a plan what leaving out parts of the simulation saves: measured, in
/// some hundredths of a second, and so a little different each time. After
/// [`MOST_TIME`] no more is measured, nor where a detector takes so long to forget
/// its start that a few phase steps are too many.
pub fn with_savings(mut plan: Plan, sensor: &Sensor) -> Plan {
    let end = Instant::now() + MOST_TIME;
    let mut detectors: Vec<Option<Option<Bench>>> = Vec::new();
    detectors.resize_with(sensor.scene().detectors.len(), || None);
    let mut known: Vec<(DetectorIndex, OptionalPart, Saving)> = Vec::new();
    for part in plan.simulation.iter_mut().filter(|part| !part.kept) {
        let (name, label) = match part.part.split_once(" (") {
            Some((name, label)) => (name, label.strip_suffix(')')),
            None => (part.part.as_str(), None),
        };
        let Some(optional) = optional_part(name) else {
            continue;
        };
        // A source's part concerns every detector, and is measured at the first.
        let labelled = |spad: &crate::scene::Detector| Some(spad.name.as_str()) == label;
        let detector = sensor
            .scene()
            .detectors
            .iter()
            .position(labelled)
            .map_or(DetectorIndex(0), DetectorIndex);
        let saving = match known.iter().find(|k| (k.0, k.1) == (detector, optional)) {
            Some((_, _, saving)) => Some(saving.clone()),
            None if Instant::now() >= end => None,
            None => {
                let bench = &mut detectors[detector];
                let bench = bench.get_or_insert_with(|| Bench::new(sensor, detector));
                let bench = bench.as_ref();
                bench.and_then(|bench| bench.saving_of(optional, end))
            }
        };
        plan.not_measured += usize::from(saving.is_none());
        part.saving.clone_from(&saving);
        known.extend(saving.map(|saving| (detector, optional, saving)));
    }
    plan
}

/// What of the simulation a part of the plan is, if it costs anything there. A
/// dead time, a delay or a detection probability is one operation, neutral or not.
fn optional_part(name: &str) -> Option<OptionalPart> {
    match name {
        "modulated_light" | "interference" | "multipath" => Some(OptionalPart::OtherLight),
        "off_state_light" | "dark_counts" | "background" => Some(OptionalPart::ConstantLight),
        "afterpulsing" => Some(OptionalPart::Afterpulsing),
        "jitter" => Some(OptionalPart::Jitter),
        "moving_paths" => Some(OptionalPart::Movement),
        _ => None,
    }
}

/// One detector, over steps of a length that is soon counted.
struct Bench {
    model: DetectorModel,
    has_constant_light: bool,
}

impl Bench {
    /// `None` if its steps take too long.
    fn new(sensor: &Sensor, detector: DetectorIndex) -> Option<Bench> {
        let model = DetectorModel::new(sensor, detector);
        let light = Light::of(&model);
        let per_chip = model.most_work_per_chip() + ITERATIONS_PER_CHIP;
        let steps = STEPS.min(sensor.timing().scan.steps);
        let short = sensor.with(|scene| {
            scene.scan.steps = steps;
            scene.scan.integration_chips = (DETECTIONS / per_chip / STEPS as f64).ceil() as u64;
        });
        let model = DetectorModel::new(&short, detector);
        let warm_up = model.warm_up_chips() as f64 * per_chip * steps as f64;
        (warm_up <= MOST_WARM_UP_DETECTIONS)
            .then_some(Bench { has_constant_light: light.constant_per_chip > 0.0, model })
    }

    /// `None` if the time is up before anything is measured, or nothing is detected.
    fn saving_of(&self, part: OptionalPart, end: Instant) -> Option<Saving> {
        if part == OptionalPart::ConstantLight && self.has_constant_light {
            return Some(Saving {
                time_fraction: 0.0,
                basis: "all background is one process, which the scene has".to_owned(),
            });
        }
        let with = self.model.with_neutral(part);
        let models = [&self.model, &with];
        let counters = models.map(StepCounter::new);
        let mut least_s = [f64::INFINITY; 2];
        let mut detections = 0;
        for round in 0..ROUNDS {
            if Instant::now() >= end {
                if round == 0 {
                    return None;
                }
                break;
            }
            for (counter, least_s) in counters.iter().zip(&mut least_s) {
                let mut counts = vec![StepCount::ZERO; self.model.timing.scan.steps as usize];
                let started = Instant::now();
                counter.count(1, 0..1, 0..counts.len() as u64, black_box(&mut counts));
                *least_s = least_s.min(started.elapsed().as_secs_f64());
                detections = counts.iter().map(|count| count.total).sum();
            }
        }
        if detections < LEAST_DETECTIONS {
            return None;
        }
        let [without_s, with_s] = least_s;
        Some(Saving {
            time_fraction: (1.0 - without_s / with_s).max(0.0),
            basis: format!(
                "measured over {detections} detections of the events tier: {:.3} ms in place of \
                 {:.3} ms",
                without_s * 1e3,
                with_s * 1e3
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::load_with;

    /// 6.9 afterpulses an avalanche, none of them lost in a dead time of a picosecond: the
    /// detector fires as fast as it can, with millions of them pending.
    #[test]
    fn what_cannot_be_counted_soon_is_not_measured() {
        let bench = |settings: &[&str]| {
            let settings: Vec<_> = settings.iter().map(|s| s.parse().expect("sound")).collect();
            let scene = load_with(Path::new("scenes/quick.toml"), &settings).expect("sound");
            let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
            (Bench::new(&Sensor::new(&scene), DetectorIndex(0)).is_some(), model)
        };
        let afterpulsing =
            "detector.afterpulsing={ probability = 0.999, time_constant = \"1 us\" }";
        let (measured, model) = bench(&["detector.dead_time=1 ps", afterpulsing]);
        assert!(!measured);
        // One in a dead time: 8 ns by 1 ps.
        assert!((model.most_detections_per_chip() / 8000.0 - 1.0).abs() < 1e-12);
        assert!(bench(&[]).0);
        // Half an afterpulse an avalanche doubles the detections.
        let half =
            "detector.afterpulsing={ probability = 0.3934693402873666, time_constant = \"5 ns\" }";
        let (_, without) =
            bench(&["detector.afterpulsing={ probability = 0, time_constant = \"5 ns\" }"]);
        let (_, with) = bench(&[half]);
        let [a, b] = [without, with].map(|model| 1.0 / model.most_detections_per_chip());
        let primary = 1.0 / (a - 14.0 / 8.0);
        assert!((b * primary - (0.5 + primary * 14.0 / 8.0)).abs() < 1e-9);
    }
}
