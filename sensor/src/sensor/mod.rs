//! A scene's sensor, worked out once: when it does what ([`Timing`]), what its
//! hardware promises at its ports ([`interface`]), and how the ports lie in a record
//! ([`layout`]).
//!
//! Every part that emits, predicts, simulates or estimates is handed a [`Sensor`].
//! Of all that, emitter and reference model share the interface and nothing else.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! # }
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
//! use goldtof::sensor::Sensor;
//!
//! let sensor = Sensor::load("scenes/quick.toml")?;
//! let ports = sensor.interface().ports();
//! let samples = ports.iter().find(|port| port.name == "i_samples").unwrap();
//! assert_eq!(samples.width, 8); // all samples of a chip in one clock
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod block_ram;
pub mod cells;
pub mod histogram;
pub mod interface;
pub mod layout;
pub mod peak;
pub mod port;
pub mod registers;
pub mod rows;
pub mod track;

use std::path::Path;

use self::interface::{Correlator, Counting, Interface};
use crate::code::Code;
use crate::scan::{Clock, Timing};
use crate::scene::{
    self, DetectorIndex, EstimatorKind, PathIndex, Scene, SceneErrors, Setting, TotalsMissing,
};

/// A scene, and what follows from it for every other part.
#[derive(Debug, Clone)]
pub struct Sensor {
    scene: Scene,
    timing: Timing,
    interface: Interface,
}

impl Sensor {
    /// The sensor of a scene that has been checked.
    pub fn new(scene: &Scene) -> Sensor {
        Sensor { timing: scene.timing(), interface: Interface::of(scene), scene: scene.clone() }
    }

    /// The sensor of the scene in a file.
    ///
    /// # Errors
    /// If it cannot be read, and everything that is wrong with it.
    pub fn load(path: impl AsRef<Path>) -> Result<Sensor, SceneErrors> {
        Sensor::load_with(path, &[])
    }

    /// [`Sensor::load`], with some keys of the file overridden.
    ///
    /// ```
    /// # mod goldtof {
    /// #     pub use goldtof_sensor::*;
    /// # }
    /// # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
    /// use goldtof::sensor::Sensor;
    ///
    /// let settings = ["path.distance=5 m".parse()?];
    /// let sensor = Sensor::load_with("scenes/quick.toml", &settings)?;
    /// assert_eq!(sensor.scene().paths[0].distance_m(), 5.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As there.
    pub fn load_with(path: impl AsRef<Path>, settings: &[Setting]) -> Result<Sensor, SceneErrors> {
        Ok(Sensor::new(&scene::load_with(path.as_ref(), settings)?))
    }

    /// The sensor of this scene with a change.
    pub fn with(&self, change: impl FnOnce(&mut Scene)) -> Sensor {
        let mut scene = self.scene.clone();
        change(&mut scene);
        Sensor::new(&scene)
    }

    /// The same sensor with hardware whose results, and peaks, come after so many clocks.
    pub fn with_latency(&self, result_clocks: u32, peak_clocks: u32) -> Sensor {
        let mut sensor = self.clone();
        sensor.interface.result_latency_clocks = result_clocks;
        if let Counting::Correlator(Correlator { peak: Some(peak), .. }) =
            &mut sensor.interface.counting
        {
            peak.latency_clocks = peak_clocks;
        }
        sensor
    }

    /// The sensor with another estimator, and with the hardware that it needs, as far as the
    /// scene leaves that open; the same for `None`.
    ///
    /// # Errors
    /// When the scene's hardware leaves out what the estimator needs.
    pub fn with_estimator(
        &self,
        estimator: Option<EstimatorKind>,
    ) -> Result<Sensor, TotalsMissing> {
        Ok(Sensor::new(&self.scene.clone().with_estimator(estimator)?))
    }

    /// What a host gets of it: [`Scene::summed`].
    #[must_use]
    pub fn summed(&self) -> Sensor {
        Sensor::new(&self.scene.clone().summed())
    }

    /// The same hardware and light with another estimator.
    pub fn estimated_by(&self, estimator: EstimatorKind) -> Sensor {
        Sensor::new(&self.scene.estimated_by(estimator))
    }

    /// What was written down of it.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// When it does what.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// Chip and sample period.
    pub fn clock(&self) -> Clock {
        self.timing.clock
    }

    /// What its hardware promises at its ports.
    pub fn interface(&self) -> &Interface {
        &self.interface
    }

    /// The code that a detector's sign follows.
    pub fn reference(&self, detector: DetectorIndex) -> &Code {
        let source = self.scene.detectors[detector].reference;
        &self.scene.sources[source].code
    }

    /// Period of the code that modulates the light of a path.
    pub fn code_period_of_path_ps(&self, path: PathIndex) -> f64 {
        let source = self.scene.paths[path].source;
        self.clock().ps(self.scene.sources[source].code.len() as f64)
    }

    /// The sensor with every path standing still where it is, without its
    /// fluctuation, at a time after the start of a scan.
    pub fn still_at(&self, time_ps: f64) -> Sensor {
        Sensor::new(&self.scene.still_at(time_ps))
    }
}
