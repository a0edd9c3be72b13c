//! A scene: what a sensor engineer writes down, read, checked and in base units.
//!
//! A scene is a TOML file; [`load`] reads one. Quantities are strings with a
//! number and a unit. Each key is declared once, beside its reader: what it may be, what it is when
//! it is left out, what it means. Fields, bounds, defaults, `docs/scene.md` and its schema follow
//! from that.
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

mod array;
mod budget;
mod catalogue;
mod companions;
mod declare;
mod detector;
mod error;
mod estimator;
#[doc(hidden)]
pub mod extreme;
mod hardware;
mod index;
mod keys;
mod lookup;
mod movement;
mod names;
mod origin;
mod read;
mod reader;
mod sampler;
mod scan;
mod setting;
mod source;
mod sunlight;
mod text;
mod units;
mod waveform;
mod whole;
mod wording;

use std::sync::Arc;

pub use array::{Array, Lens, MAX_PIXELS, PixelLight, PixelPath};
pub use catalogue::{reference, schema};
pub use detector::*;
pub use error::{SceneError, SceneErrors};
pub use estimator::{EstimatorKind, OtherLight, TotalsMissing};
pub use hardware::{
    Architecture, FpgaTarget, Hardware, LEAST_CHIPS_OF_ROWS, Polarity, Readout, Registers, Share,
};
pub use index::{DetectorIndex, PathIndex, SourceIndex};
pub use lookup::{Entry, quantity_text};
pub use movement::{Fluctuation, Movement};
pub use origin::{Origin, SceneReference};
pub use read::{load, load_with, parse, parse_with};
pub use setting::{MOST_KEY_PARTS, Setting};
pub use text::SceneText;
pub use toml::Value;
pub use waveform::{JitterTail, LaserResponse, WaveformCurve};

use crate::code::Code;
use crate::light::distance_m;
pub use crate::scan::Scan;
use crate::scan::{Clock, PERIODS_OF_PREPARATION, Timing};

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
    /// Light besides the strongest path that the model estimator looks for.
    pub other_light: OtherLight,
    /// Target and options of the hardware.
    pub hardware: Hardware,
    /// The array of which this is one pixel's sensor, whose light the paths are.
    pub array: Option<Arc<Array>>,
}

impl Scene {
    /// Chip period and samples per chip.
    pub fn clock(&self) -> Clock {
        Clock { chip_period_ps: self.chip_period_ps, samples_per_chip: self.samples_per_chip }
    }

    /// Its name in documents.
    pub fn reference(&self) -> SceneReference {
        SceneReference { name: self.name.clone(), origin: self.origin.clone() }
    }

    /// The paths from a detector's own source to it.
    ///
    /// # Panics
    /// If the scene has no such detector.
    pub fn own_paths(&self, detector: DetectorIndex) -> impl Iterator<Item = PathIndex> + '_ {
        let own = (detector, self.detectors[detector].reference);
        let paths = PathIndex::of(&self.paths);
        paths.filter(move |&path| (self.paths[path].detector, self.paths[path].source) == own)
    }

    /// The detectors before and after one, which hear its crosstalk.
    pub fn neighbours(
        &self,
        detector: DetectorIndex,
    ) -> impl Iterator<Item = DetectorIndex> + use<> {
        let after = (detector.0 + 1 < self.detectors.len()).then_some(detector.0 + 1);
        detector.0.checked_sub(1).into_iter().chain(after).map(DetectorIndex)
    }

    /// Whether crosstalk of other detectors fires one.
    pub fn hears_others(&self, detector: DetectorIndex) -> bool {
        self.neighbours(detector).any(|other| self.detectors[other].crosstalk().is_some())
    }

    /// Whether light of its source arrives over a path.
    pub fn is_lit(&self, path: &Path) -> bool {
        self.sources[path.source].emits() && path.transmission > 0.0
    }

    /// What follows from clock and scan.
    pub fn timing(&self) -> Timing {
        Timing {
            clock: self.clock(),
            scan: self.scan,
            preparation_chips: match self.hardware.registers {
                Registers::None => 0,
                Registers::Axi4Lite => {
                    PERIODS_OF_PREPARATION * self.scan.steps_per_period
                        / u64::from(self.samples_per_chip)
                }
            },
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
    /// Chips of a code period in which its light is on, ones that last longer included.
    pub fn lit_chips(&self, clock: Clock) -> f64 {
        let longer = clock.chips(self.response.longer_ps());
        self.code.weight() as f64 + self.code.runs() as f64 * longer
    }

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
