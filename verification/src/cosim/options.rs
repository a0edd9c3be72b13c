//! What a co-simulation is asked for: the command line's options, and the library's.

use std::sync::Arc;

use super::asked_latency::Latency;
use super::engine::Engine;
use super::own::OwnRtl;
use super::window::Window;
use super::{MOST_CLOCKS, StimulusKind};
use crate::photons::Pulse;
use crate::version::MADE_BY;

/// What to compare, and how.
#[derive(Debug, Clone, clap::Args)]
pub struct CosimOptions {
    /// The Verilog; the emitted one if none is given
    #[command(flatten)]
    pub own: OwnRtl,
    /// What emitted files say that they were made by. A build is found again by its files, so
    /// that the same words spare another one
    #[arg(skip)]
    pub made_by: String,
    /// Latency of the Verilog's results in clocks: "auto" to measure it, N, or N,P with
    /// that of the peak, for example --latency 7 [default: the emitted design's]
    #[arg(long, value_name = "L", default_value = "", hide_default_value = true,
          value_parser = Latency::of_option)]
    pub latency: Latency,
    /// Clocks to run, reset included, 1 to 2^50, for example --clocks 100000 [default: one
    /// whole scan of photons, or as many as the adversarial stimulus needs]
    #[arg(long, alias = "cycles", value_name = "N",
          value_parser = clap::value_parser!(u64).range(1..=MOST_CLOCKS))]
    pub clocks: Option<u64>,
    /// Stimulus of both sides
    #[arg(long, value_enum, default_value_t)]
    pub stimulus: StimulusKind,
    /// Co-simulation engine: lanes run 64 or more time slices of the scan in parallel;
    /// auto takes them for long photon runs, and lock-step otherwise
    #[arg(long, value_name = "E", value_enum, default_value_t)]
    pub engine: Engine,
    /// Seed of all random numbers
    #[arg(skip)]
    pub seed: u64,
    /// The clocks to keep for waveforms
    #[arg(skip)]
    pub window: Window,
    /// Pulses of each detector in place of simulated ones, from the first scan's first sample on
    #[arg(skip)]
    pub recorded: Option<Arc<Vec<Vec<Pulse>>>>,
}

impl Default for CosimOptions {
    fn default() -> CosimOptions {
        CosimOptions {
            own: OwnRtl::default(),
            made_by: MADE_BY.to_owned(),
            latency: Latency::Emitted,
            clocks: None,
            stimulus: StimulusKind::Photons,
            engine: Engine::Auto,
            seed: 1,
            window: Window::Found,
            recorded: None,
        }
    }
}
