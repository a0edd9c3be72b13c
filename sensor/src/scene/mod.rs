//! A scene: what a sensor engineer writes down, read, checked and in base units.
//!
//! A scene is a TOML file; [`load`] reads one. Quantities are strings with a
//! number and a unit. `keys/tables.rs` has every key, what it may be, and what it is when it
//! is left out; `docs/scene.md` is made from it.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! # }
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
//! use std::path::Path;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! assert_eq!(scene.chip_period_ps, 8000.0);
//! assert_eq!(scene.paths[0].distance_m(), 3.2);
//!
//! let error = goldtof::scene::parse("my.toml", "clock.chip_period = 8").unwrap_err();
//! assert!(error.to_string().contains("8 has no unit; write for example"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod budget;
mod detector;
mod error;
#[doc(hidden)]
pub mod extreme;
mod index;
mod keys;
mod movement;
mod names;
mod origin;
mod read;
mod reader;
mod scan;
mod setting;
mod source;
mod sunlight;
mod totals;
mod units;
mod waveform;
mod whole;
mod wording;

use std::sync::Arc;

pub use detector::*;
pub use error::{SceneError, SceneErrors};
pub use index::{DetectorIndex, PathIndex, SourceIndex};
pub use keys::{reference, schema};
pub use movement::{Fluctuation, Movement};
pub use origin::{Origin, SceneReference};
pub use read::{load, load_with, load_with_text, parse, parse_with, read as read_scene_text};
pub use setting::{MOST_KEY_PARTS, Setting};
pub use totals::TotalsMissing;
pub use waveform::{Curve, JitterTail, LaserResponse};

use crate::code::Code;
use crate::light::distance_m;
pub use crate::scan::Scan;
use crate::scan::{Clock, Timing};

/// A checked scene. Every cross-reference is resolved to an index, every
/// quantity is in the unit its name carries, every default is filled in.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The file's stem, `paper-single` for `scenes/paper-single.toml`.
    pub name: String,
    /// The text that it was read from.
    pub origin: Origin,
    /// Chip period T_c; one clock cycle of the hardware.
    pub chip_period_ps: f64,
    /// Samples (phase steps) per chip, S = 2^zeta: 1, 2, 4, ...
    pub samples_per_chip: u32,
    /// Light sources, in the order of the file.
    pub sources: Vec<Source>,
    /// Detectors, in the order of the file.
    pub detectors: Vec<Detector>,
    /// Optical paths, in the order of the file.
    pub paths: Vec<Path>,
    /// Which phase steps are measured, and for how long.
    pub scan: Scan,
    /// Which estimator turns counts into distance.
    pub estimator: EstimatorKind,
    /// What the model estimator is told of light besides the strongest path.
    pub other_light: OtherLight,
    /// What the hardware is built for.
    pub hardware: Hardware,
}

impl Scene {
    /// Chip period and samples per chip.
    pub fn clock(&self) -> Clock {
        Clock { chip_period_ps: self.chip_period_ps, samples_per_chip: self.samples_per_chip }
    }

    /// What documents name it by.
    pub fn reference(&self) -> SceneReference {
        SceneReference::new(&self.name, &self.origin)
    }

    /// Whether light of its source arrives over a path.
    pub fn is_lit(&self, path: &Path) -> bool {
        self.sources[path.source].emits() && path.transmission > 0.0
    }

    /// Whether that light carries its source's code.
    pub fn carries_code(&self, path: &Path) -> bool {
        let source = &self.sources[path.source];
        self.is_lit(path) && source.extinction_ratio > 1.0 && source.code.weight() > 0
    }

    /// What follows from clock and scan.
    pub fn timing(&self) -> Timing {
        Timing {
            clock: self.clock(),
            scan: self.scan,
            parallel: match self.hardware.architecture {
                Architecture::UpDown => self.hardware.parallel,
                // Every hit serves every phase step.
                Architecture::Histogram => u32::try_from(self.scan.steps).unwrap_or(u32::MAX),
            },
        }
    }
}

/// An on-off-keyed laser.
#[derive(Debug, Clone)]
pub struct Source {
    /// Name that paths and detectors refer to.
    pub name: String,
    /// The code it repeats without end, interleaving included.
    pub code: Arc<Code>,
    /// Vacuum wavelength.
    pub wavelength_nm: f64,
    /// Optical power averaged over the code, at the source.
    pub mean_power_w: f64,
    /// On-rate over off-rate, at least 1; `f64::INFINITY` for a dark off-state.
    pub extinction_ratio: f64,
    /// How its light follows the code.
    pub response: LaserResponse,
    /// How its clock goes beside the detectors'.
    pub clock: SourceClock,
}

impl Source {
    /// Whether it has any light.
    pub fn emits(&self) -> bool {
        self.mean_power_w > 0.0
    }
}

/// How a source's clock goes beside that of the detectors, which are one sensor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SourceClock {
    /// Share by which it is faster, at the first scan's start.
    pub offset: f64,
    /// Change of that share per second.
    pub drift_per_s: f64,
}

impl SourceClock {
    /// Whether it is the detectors' own clock.
    pub fn is_shared(&self) -> bool {
        *self == SourceClock::default()
    }
}

/// Standard deviation of a sum of independent numbers, from theirs.
fn std_of_sum(deviations: &[f64]) -> f64 {
    deviations.iter().map(|s| s * s).sum::<f64>().sqrt()
}

/// One optical path from a source to a detector.
#[derive(Debug, Clone)]
pub struct Path {
    /// Index in [`Scene::sources`].
    pub source: SourceIndex,
    /// Index in [`Scene::detectors`].
    pub detector: DetectorIndex,
    /// Time of flight; of a path that moves, at the start of a scan.
    pub delay_ps: f64,
    /// Share of the source's photons that arrive, 0..=1.
    pub transmission: f64,
    /// How the time of flight changes; `None` for a path that stands still.
    pub movement: Option<Movement>,
}

impl Path {
    /// Distance (half the optical path) in metres, at the start of a scan.
    pub fn distance_m(&self) -> f64 {
        distance_m(self.delay_ps)
    }
}

/// Turns counts into distance.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
    clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub enum EstimatorKind {
    /// Coarse argmax, then the phase of the fundamental
    Fft,
    /// Weighted least squares against the exact mean response
    Model,
}

impl EstimatorKind {
    /// Each of them, under the name that scenes use.
    pub const NAMES: [(&'static str, EstimatorKind); 2] =
        [("fft", EstimatorKind::Fft), ("model", EstimatorKind::Model)];

    /// The one that this is not.
    pub fn other(self) -> EstimatorKind {
        match self {
            EstimatorKind::Fft => EstimatorKind::Model,
            EstimatorKind::Model => EstimatorKind::Fft,
        }
    }
}

impl std::fmt::Display for EstimatorKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = EstimatorKind::NAMES.iter().find_map(|(name, k)| (k == self).then_some(*name));
        f.write_str(name.unwrap_or_default())
    }
}

/// Which light besides the strongest path of its own source a detector's fit
/// looks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OtherLight {
    /// Of each code at most as many paths as the scene has for this detector; which
    /// there are, where, and how strong, is found in the scan.
    Given,
    /// Up to eight sensors with codes that are not known, of the reference's Gold set
    /// and of those of the scene's other sources; and up to four own paths.
    Search,
    /// None: everything else counts as constant.
    None,
}

impl OtherLight {
    /// Each of them, under the name that scenes use.
    pub const NAMES: [(&'static str, OtherLight); 3] =
        [("given", OtherLight::Given), ("search", OtherLight::Search), ("none", OtherLight::None)];
}

/// What the hardware is built for.
#[derive(Debug, Clone, PartialEq)]
pub struct Hardware {
    /// Target device.
    pub target: Target,
    /// What is counted.
    pub architecture: Architecture,
    /// Level of the samples while a detector's pulse lasts.
    pub polarity: Polarity,
    /// Phase steps correlated at once, of hardware that counts up and down.
    pub parallel: u32,
    /// Width of a count in the results; `None` gives the width at which no
    /// stimulus at all can overflow. A narrower count saturates and flags.
    pub counter_width: Option<u32>,
    /// Whether the hardware sends total counts beside the signed ones; `None`
    /// leaves it to the estimator. See [`Scene::sends_total_counts`].
    pub total_counts: Option<bool>,
    /// Whether the hardware finds the peak of a scan, beside sending its counts.
    pub peak_detector: bool,
    /// Histograms that each detector has memory for, 1 or 2.
    pub buffers: u32,
}

/// What the hardware counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Architecture {
    /// Hits up and down by the sign of the delayed reference (eq. 11), one phase step,
    /// or `parallel` of them, after another.
    #[default]
    UpDown,
    /// Hits by their time in the code period, a bin for each sample of it. Every phase
    /// step's up/down count follows from the same hits, so that a scan is as long as its
    /// integration time.
    Histogram,
}

impl Architecture {
    /// Each of them, under the name that scenes use.
    pub const NAMES: [(&'static str, Architecture); 2] =
        [("updown", Architecture::UpDown), ("histogram", Architecture::Histogram)];
}

/// Level of a detector's samples while its pulse lasts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Polarity {
    /// A hit is a rising edge.
    #[default]
    High,
    /// A hit is a falling edge, as from a comparator that inverts.
    Low,
}

impl Polarity {
    /// Each of them, under the name that scenes use.
    pub const NAMES: [(&'static str, Polarity); 2] =
        [("high", Polarity::High), ("low", Polarity::Low)];

    /// A word of so many samples, at most 64, without a pulse.
    pub fn rest(self, samples: u32) -> u64 {
        match self {
            Polarity::High => 0,
            Polarity::Low => u64::MAX >> (u64::BITS - samples),
        }
    }
}

/// FPGA targets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Lattice ECP5 25k, speed grade 6.
    Ecp525k6,
    /// Lattice iCE40 HX8K.
    Ice40Hx8k,
    /// AMD 7-series (synthesis only).
    Xc7,
}

impl Target {
    /// Each of them, under the name that scenes use.
    pub const NAMES: [(&'static str, Target); 3] =
        [("ecp5-25k-6", Target::Ecp525k6), ("ice40-hx8k", Target::Ice40Hx8k), ("xc7", Target::Xc7)];
}
