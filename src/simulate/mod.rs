//! Ways of simulating a sensor, from exact to cheap, and what they say.
//!
//! ```
//! use goldtof::simulate::Tier;
//! use goldtof::{Jobs as _, Sensor};
//!
//! let sensor = Sensor::load("scenes/quick.toml")?;
//! // Without random numbers, so that one repetition says it all.
//! let simulation = sensor.simulate(Tier::Expected.scans(1))?;
//! let path = &simulation.estimates[0];
//! assert_eq!(path.bias_m, path.expected_bias_m);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub(crate) mod domain;
pub mod effort;
mod expected;
pub mod forecast;
pub mod histograms;
mod options;
pub mod path_statistics;
pub mod pulses;
pub mod repeat;
mod run_up;
pub mod scans;
pub mod track;

use std::time::Instant;

pub use options::SimulateOptions;
use serde::{Deserialize, Serialize};

use crate::estimate::CountingTier;
use crate::progress::Progress;
use crate::scene::Architecture;
use crate::sensor::Sensor;
use repeat::{Simulated, Simulation};
use scans::{PreparedTier, ScansError};

/// [`Jobs::simulate`](crate::Jobs::simulate) with its progress in scans, of all detectors, in order.
/// If `on_progress` unwinds, the simulation ends there, and leaves nothing behind.
///
/// # Errors
/// As there.
pub fn simulate(
    sensor: &Sensor,
    options: SimulateOptions,
    mut on_progress: impl FnMut(Progress),
) -> Result<Simulation, ScansError> {
    let started = Instant::now();
    let sensor = sensor.with_estimator(options.estimator)?.summed();
    let prepared = PreparedTier::new(&sensor, options.fidelity, options.engine)?;
    let simulated = Simulated::new(&sensor, options)?;
    let simulation = simulated.simulate(&prepared, &mut on_progress)?;
    Ok(Simulation { run_time_s: started.elapsed().as_secs_f64(), ..simulation })
}

/// How much of the sensor a simulation goes through, from least to most.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Serialize,
    Deserialize,
    schemars::JsonSchema,
    clap::ValueEnum,
)]
#[serde(rename_all = "lowercase")]
pub enum Tier {
    /// No random numbers: the exact mean response of the sampled hardware, and the
    /// scatter that the counts' exact covariance gives.
    Expected,
    /// Counts drawn from their exact means and covariances, without photons.
    Counts,
    /// Every detection, and the article's continuous-time counter.
    Events,
    /// Every detection, sampled, through the bit-exact reference model.
    Sampled,
    /// The same through the Verilog, compared at every clock.
    Rtl,
}

impl Tier {
    /// Every tier.
    pub const ALL: [Tier; 5] =
        [Tier::Expected, Tier::Counts, Tier::Events, Tier::Sampled, Tier::Rtl];

    /// How this tier turns detections into counts.
    pub fn counting(self, sensor: &Sensor) -> CountingTier {
        match self {
            Tier::Events if sensor.scene().hardware.architecture == Architecture::Histogram => {
                CountingTier::Binned
            }
            Tier::Events => CountingTier::Events,
            Tier::Expected | Tier::Counts | Tier::Sampled | Tier::Rtl => CountingTier::Sampled,
        }
    }

    /// Whether the tier draws random numbers.
    pub fn draws(self) -> bool {
        self != Tier::Expected
    }
}

impl std::fmt::Display for Tier {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Tier::Expected => "expected",
            Tier::Counts => "counts",
            Tier::Events => "events",
            Tier::Sampled => "sampled",
            Tier::Rtl => "rtl",
        })
    }
}
