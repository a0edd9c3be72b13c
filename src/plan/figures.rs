//! The sensor in numbers that people compare: clock, frame time, latency, range.

use serde::Serialize;

use crate::estimate::distance_m;
use crate::reference::stimulus::scan_start;
use crate::scene::Scene;
use crate::sensor::contract::Contract;

/// What the hardware does in time and in space.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// One clock cycle is one chip.
    pub clock_hz: f64,
    /// Chips of the reference's code period.
    pub code_period_chips: u64,
    /// Phase steps of a scan.
    pub steps: u64,
    /// Phase steps of the code period.
    pub steps_per_period: u64,
    /// Integration time of a phase step.
    pub integration_s: f64,
    /// From the start of one scan to that of the next: one distance of each detector.
    pub frame_time_s: f64,
    /// From a phase step's last sample to its count on the result stream.
    pub result_latency_clocks: u32,
    /// The same in seconds.
    pub result_latency_s: f64,
    /// Distance of a phase step: what the coarse stage tells apart.
    pub phase_step_m: f64,
    /// Distance beyond which the code repeats.
    pub unambiguous_range_m: f64,
    /// Bits of a result.
    pub result_bits: u32,
    /// Results of a scan, of all detectors.
    pub results: u64,
}

impl Figures {
    /// Those of a scene's sensor.
    pub fn of(scene: &Scene) -> Figures {
        let contract = Contract::of(scene);
        let chip_s = scene.chip_period_ps * 1e-12;
        let code_period_chips = contract.reference_codes[0].len();
        let clocks = |clocks: u64| clocks as f64 * chip_s;
        Figures {
            clock_hz: 1e12 / scene.chip_period_ps,
            code_period_chips,
            steps: scene.scan.steps,
            steps_per_period: scene.scan.steps_per_period,
            integration_s: clocks(scene.scan.integration_chips),
            frame_time_s: clocks(scan_start(&contract, 1)),
            result_latency_clocks: contract.result_latency_clocks,
            result_latency_s: clocks(u64::from(contract.result_latency_clocks)),
            phase_step_m: distance_m(scene.chip_period_ps / f64::from(contract.lanes)),
            unambiguous_range_m: distance_m(scene.chip_period_ps * code_period_chips as f64),
            result_bits: contract.tdata_bits,
            results: scene.scan.steps * contract.reference_codes.len() as u64,
        }
    }
}
