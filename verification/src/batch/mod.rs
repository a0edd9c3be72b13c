//! The reference model for testbenches of others: clocked in batches, sample words in,
//! every output port out ([`Model`]); and beside a design, every port compared at every
//! clock ([`Scoreboard`]).
//!
//! A clock is a rising edge of `i_clk`. Clock t has the inputs that stand before that
//! edge, and the outputs that show after it, so that the outputs of clock t are what a
//! testbench reads at the edge of clock t + 1.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! #     pub use goldtof_verification::*;
//! # }
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
//! use std::path::Path;
//!
//! use goldtof::batch::{BatchInputs, Model};
//! use goldtof::sensor::Sensor;
//! use goldtof::sensor::port::PortRole;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let mut model = Model::new(&Sensor::new(&scene))?;
//! // Two clocks of reset; then a hit in every other word of 8 samples.
//! let samples: Vec<u8> = [0, 0x10].into_iter().cycle().take(6000).collect();
//! let mut reset = vec![0; 6000];
//! reset[..2].fill(1);
//! let inputs = BatchInputs { samples: &samples, reset: &reset, ready: &[], host: &[] };
//! let mut outputs = Vec::new();
//! model.clock(&inputs, &mut outputs)?;
//! let valid = model.layout().outputs.field(PortRole::Valid);
//! let beats = outputs.iter().filter(|word| valid.low_word(&[**word]) == 1).count();
//! assert_eq!(beats, 2);
//! let results: Vec<_> = model.take_results().collect();
//! assert_eq!(results.len(), 2); // of 2,500 chips each
//! assert_eq!(results[0].total, 1250);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod edges;
mod error;
mod model;
mod ports;
mod record;
mod scoreboard;

pub use self::error::BatchError;
pub use self::model::{BatchInputs, Model};
pub use self::ports::PortValues;
pub use self::record::TestbenchPort;
pub use self::scoreboard::{Scoreboard, ScoreboardOptions, Summary};
pub use crate::reference::host_ports::HostInputs;
pub use crate::reference::predictor::StepResult;

use crate::cosim::asked_latency::MOST_CLOCKS;
use crate::cosim::latency::held_to_clocks;
use crate::sensor::Sensor;

/// The sensor with the latency that a design has: clocks from a group's last word to its
/// first result, and from a scan's last word to its peak, each the emitted design's if it
/// is not given, but that a peak moves by as much as the results.
///
/// # Errors
/// When a latency is beyond what any design is held to, or there is no peak.
pub fn held_to(
    sensor: &Sensor,
    result_clocks: Option<u32>,
    peak_clocks: Option<u32>,
) -> Result<Sensor, BatchError> {
    for clocks in [result_clocks, peak_clocks].into_iter().flatten() {
        if clocks > MOST_CLOCKS {
            return Err(BatchError::Latency { clocks, most: MOST_CLOCKS });
        }
    }
    if peak_clocks.is_some() && sensor.interface().peak().is_none() {
        return Err(BatchError::NoPeak);
    }
    let emitted = sensor.interface().result_latency_clocks;
    Ok(held_to_clocks(sensor, result_clocks.unwrap_or(emitted), peak_clocks))
}
