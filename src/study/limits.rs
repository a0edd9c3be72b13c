//! What limits a sensor: where its light, its time and its bits go, and what each key of the scene
//! would bring if it alone were another. All of it is theory, without random numbers.
//!
//! ```
//! use std::path::Path;
//!
//! use goldtof::scene::SceneText;
//! use goldtof::study::limits::limits;
//!
//! let scene = SceneText::read(Path::new("scenes/quick.toml"), &[])?;
//! let limits = limits(&scene, None)?;
//! let doubled = limits.changes.iter().find(|change| change.setting == "source.mean_power=40 pW");
//! assert!(doubled.unwrap().bound_change_fraction.unwrap() < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use rayon::prelude::*;
use serde::Serialize;

use crate::door::{EstimateError, detector_named};
use crate::estimate::CountingTier;
use crate::estimate::bound::BoundKind;
use crate::estimate::report::{EstimateReport, Reporter};
use crate::photons::{DeadTime, DetectorModel};
use crate::plan::figures::Figures;
use crate::plan::link::LinkBudget;
use crate::response::MeanResponse;
use crate::scene::{
    DetectorIndex, Entry, EstimatorKind, PathIndex, SceneErrors, SceneText, Setting, Value,
    quantity_text,
};
use crate::sensor::Sensor;

/// What `goldtof explain` gives.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Limits {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// The detector's name.
    pub detector: String,
    /// The source that it ranges.
    pub source: String,
    /// The estimator whose errors are given.
    pub estimator: EstimatorKind,
    /// Distance of the path that is ranged, folded into the unambiguous range; none without a path.
    pub true_distance_m: Option<f64>,
    /// The detector's light and what it makes of it.
    pub light: LightUsed,
    /// The sensor in numbers.
    pub figures: Figures,
    /// Results of all detectors, in bits of the result stream.
    pub result_bits_per_s: f64,
    /// Share of the clocks at which the result stream has a result.
    pub stream_busy_fraction: f64,
    /// What the scene as it is lets one expect.
    pub expected: Performance,
    /// The same with one key changed, the largest gain first.
    pub changes: Vec<KeyChange>,
}

/// Where a detector's detections come from, and how long it is blind.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LightUsed {
    /// Photons of the ranged source that would fire a detector which is always ready.
    pub own_primary_hz: f64,
    /// Those of other sources.
    pub other_primary_hz: f64,
    /// Photons of the background that would.
    pub background_hz: f64,
    /// Avalanches without light.
    pub dark_counts_hz: f64,
    /// Detections, afterpulses among them; none where the mean response is not known.
    pub detected_rate_cps: Option<f64>,
    /// Share of the time in which the detector is dead.
    pub blind_fraction: Option<f64>,
}

/// What theory expects of a sensor.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Performance {
    /// Mean error of the estimator.
    pub expected_bias_m: Option<f64>,
    /// Its standard deviation.
    pub expected_std_m: Option<f64>,
    /// Share of scans that miss the peak, of which they are not; of a fit null where the phase misses one in a thousand at most.
    pub expected_missed_fraction: Option<f64>,
    /// Both together: root mean square of the error.
    pub expected_rms_m: Option<f64>,
    /// Least standard deviation of an estimate.
    pub bound_m: Option<f64>,
    /// What `bound_m` is; null without one.
    pub bound_kind: Option<BoundKind>,
    /// From the start of one scan to that of the next.
    pub frame_time_s: f64,
    /// Distance beyond which the code repeats.
    pub unambiguous_range_m: f64,
    /// Why something is missing.
    pub remark: Option<String>,
}

/// A part of the sensor that may limit it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// Too few photons are counted.
    Photons,
    /// Light and avalanches that are not the code's.
    Noise,
    /// The detector is blind for some time after each detection.
    DeadTime,
    /// Detections come at other times than their photons.
    Timing,
    /// Length and order of the code's chips.
    Code,
    /// Chips and samples.
    Clock,
    /// What becomes of the counts.
    Estimator,
}

/// One key, changed alone.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Change")]
pub struct KeyChange {
    /// What it is a matter of.
    pub limit: Limit,
    /// As `--set` takes it: `detector.dead_time=7 ns`.
    pub setting: String,
    /// What is expected then.
    pub expected: Performance,
    /// Relative change of the root mean square error: -0.5 halves it.
    pub rms_change_fraction: Option<f64>,
    /// The same of the bound.
    pub bound_change_fraction: Option<f64>,
}

/// How a key is changed.
enum To {
    /// Times a factor, each number of a list.
    Times(f64),
    /// What is there is taken away.
    Zero,
    /// Each number of a list is 1.
    Ones,
    /// The next number that the scene takes, of at most three.
    Next,
    /// This word.
    Word(&'static str),
}

/// Keys that are changed, one by one, where the scene has them. Those of the ranged source and of the
/// detector.
const CHANGES: [(Limit, &str, To); 21] = [
    (Limit::Photons, "source.mean_power", To::Times(2.0)),
    (Limit::Photons, "detector.photon_detection_probability", To::Times(2.0)),
    (Limit::Photons, "scan.integration", To::Times(4.0)),
    (Limit::Noise, "source.extinction_ratio", To::Times(10.0)),
    (Limit::Noise, "detector.background_rate", To::Zero),
    (Limit::Noise, "detector.background.filter_width", To::Times(0.5)),
    (Limit::Noise, "detector.dark_count_rate", To::Zero),
    (Limit::Noise, "detector.afterpulsing.probability", To::Zero),
    (Limit::DeadTime, "detector.dead_time", To::Times(0.5)),
    (Limit::Timing, "detector.jitter", To::Times(0.5)),
    (Limit::Timing, "detector.jitter_tail.share", To::Zero),
    (Limit::Timing, "source.rise_time", To::Times(0.5)),
    (Limit::Timing, "source.fall_time", To::Times(0.5)),
    (Limit::Timing, "source.duty_cycle_distortion", To::Zero),
    (Limit::Timing, "detector.sampler.second_pin_skew", To::Zero),
    (Limit::Timing, "detector.sampler.widths", To::Ones),
    (Limit::Code, "source.code.degree", To::Next),
    (Limit::Code, "source.code.interleave", To::Next),
    (Limit::Clock, "clock.chip_period", To::Times(0.5)),
    (Limit::Clock, "clock.samples_per_chip", To::Times(2.0)),
    (Limit::Estimator, "estimate.estimator", To::Word("model")),
];

/// Why nothing can be told.
#[derive(Debug, thiserror::Error)]
pub enum LimitsError {
    /// The scene is invalid.
    #[error("{0}")]
    Scene(#[from] SceneErrors),
    /// The scene has no such detector.
    #[error(transparent)]
    Detector(#[from] EstimateError),
}

/// What limits the detector of this name, or the scene's first.
///
/// Each change is read like a scene with that setting: one that the scene's reader refuses is left
/// out, and so is one of a key that is zero already.
///
/// # Errors
/// When the scene is invalid or has no such detector.
pub fn limits(text: &SceneText, detector: Option<&str>) -> Result<Limits, LimitsError> {
    let sensor = Sensor::new(&text.scene()?.summed());
    let scene = sensor.scene();
    let detector = detector_named(scene, detector)?;
    let source = scene.detectors[detector].reference;
    let index = |key: &str| match key.split_once('.') {
        Some(("source", rest)) if scene.sources.len() > 1 => format!("source[{source}].{rest}"),
        Some(("detector", rest)) if scene.detectors.len() > 1 => {
            format!("detector[{detector}].{rest}")
        }
        _ => key.to_owned(),
    };
    let as_it_is = Reporter::new(&sensor, detector).expected();
    let true_distance_m = as_it_is.true_distance_m;
    let now = Performance::of(&sensor, as_it_is);
    let changed: Vec<Option<KeyChange>> = CHANGES
        .par_iter()
        .map(|(limit, key, to)| {
            let (setting, sensor) = to.applied(text, &index(key))?;
            let expected = Performance::of(&sensor, Reporter::new(&sensor, detector).expected());
            Some(KeyChange {
                limit: *limit,
                setting,
                rms_change_fraction: change(now.expected_rms_m, expected.expected_rms_m),
                bound_change_fraction: change(now.bound_m, expected.bound_m),
                expected,
            })
        })
        .collect();
    let mut changes: Vec<KeyChange> = changed.into_iter().flatten().collect();
    let gain = |change: &KeyChange| {
        let known = change.rms_change_fraction.or(change.bound_change_fraction);
        known.unwrap_or(f64::INFINITY)
    };
    changes.sort_by(|a, b| gain(a).total_cmp(&gain(b)));
    let figures = Figures::of(&sensor);
    let results_per_s = figures.results as f64 / figures.frame_time_s;
    Ok(Limits {
        scene: scene.name.clone(),
        detector: scene.detectors[detector].name.clone(),
        source: scene.sources[source].name.clone(),
        estimator: scene.estimator,
        true_distance_m,
        light: LightUsed::of(&sensor, detector),
        result_bits_per_s: results_per_s * f64::from(figures.result_bits),
        stream_busy_fraction: results_per_s / figures.clock_hz,
        figures,
        expected: now,
        changes,
    })
}

fn change(now: Option<f64>, then: Option<f64>) -> Option<f64> {
    Some(then? / now.filter(|now| *now > 0.0)? - 1.0)
}

impl LightUsed {
    fn of(sensor: &Sensor, detector: DetectorIndex) -> LightUsed {
        let scene = sensor.scene();
        let (mut own_primary_hz, mut other_primary_hz) = (0.0, 0.0);
        let of_detector = |path: &PathIndex| scene.paths[*path].detector == detector;
        for path in PathIndex::of(&scene.paths).filter(of_detector) {
            let is_own = scene.paths[path].source == scene.detectors[detector].reference;
            let sum = if is_own { &mut own_primary_hz } else { &mut other_primary_hz };
            *sum += LinkBudget::of(scene, path).primary_hz;
        }
        let spad = &scene.detectors[detector];
        let model = DetectorModel::new(sensor, detector);
        let response = MeanResponse::of_tier(&model, CountingTier::Sampled).ok();
        let detected_rate_cps = response.map(|response| response.detection_rate_hz());
        let dead_time = DeadTime::of(spad, spad.dead_time_ps * 1e-12);
        let ready = |rate_cps| dead_time.ready_share(rate_cps);
        LightUsed {
            own_primary_hz,
            other_primary_hz,
            background_hz: spad.background_rate_cps * spad.photon_detection_probability,
            dark_counts_hz: spad.dark_count_rate_cps,
            detected_rate_cps,
            blind_fraction: detected_rate_cps.map(|rate_cps| 1.0 - ready(rate_cps)),
        }
    }
}

impl Performance {
    fn of(sensor: &Sensor, report: EstimateReport) -> Performance {
        let figures = Figures::of(sensor);
        let both = report.expected_bias_m.zip(report.expected_std_m);
        Performance {
            expected_bias_m: report.expected_bias_m,
            expected_std_m: report.expected_std_m,
            expected_missed_fraction: report.expected_missed_fraction,
            expected_rms_m: both.map(|(bias_m, std_m)| bias_m.hypot(std_m)),
            bound_m: report.bound_m,
            bound_kind: report.bound_kind,
            frame_time_s: figures.frame_time_s,
            unambiguous_range_m: figures.unambiguous_range_m,
            remark: report.remark.or(report.bound_remark),
        }
    }
}

impl To {
    /// The key's setting, and the sensor with it; none where the key is not there, would not change,
    /// or is refused.
    fn applied(&self, text: &SceneText, key: &str) -> Option<(String, Sensor)> {
        let value = Entry::of(&text.text, &text.settings, key).ok()?.value?;
        self.values(key, &value).into_iter().find_map(|to| {
            let setting = Setting::of(key, &to, "--set").ok()?;
            let mut scene = text.clone();
            scene.settings.push(setting);
            Some((format!("{key}={to}"), Sensor::new(&scene.scene().ok()?.summed())))
        })
    }

    /// What the key may become, the best first, as the scene writes it.
    fn values(&self, key: &str, value: &Value) -> Vec<String> {
        let written = |number: f64| match quantity_text(key, number) {
            Ok(Some(quantity)) => quantity,
            _ => number.to_string(),
        };
        let number = |value: &Value| match value {
            Value::Float(number) => Some(*number),
            Value::Integer(number) => Some(*number as f64),
            _ => None,
        };
        let isnt_nothing = |number: &f64| number.is_finite() && *number != 0.0;
        let changed = match (self, value) {
            (To::Times(factor), Value::Array(list)) => {
                let all = list.iter().map(|item| number(item).filter(isnt_nothing));
                all.collect::<Option<Vec<f64>>>().filter(|all| !all.is_empty()).map(|all| {
                    let all: Vec<_> =
                        all.iter().map(|n| format!("\"{}\"", written(n * factor))).collect();
                    vec![format!("[{}]", all.join(", "))]
                })
            }
            (To::Times(factor), one) => {
                let one = number(one).filter(isnt_nothing);
                one.map(|one| vec![written(one * factor)])
            }
            (To::Ones, Value::Array(list)) => Some(vec![format!("{:?}", vec![1; list.len()])]),
            (To::Ones, _) => None,
            (To::Zero, one) => number(one).filter(isnt_nothing).map(|_| vec![written(0.0)]),
            (To::Next, one) => {
                number(one).map(|one| (1..=3).map(|more| written(one + f64::from(more))).collect())
            }
            (To::Word(word), Value::String(now)) if now == word => None,
            (To::Word(word), _) => Some(vec![(*word).to_owned()]),
        };
        changed.unwrap_or_default()
    }
}
