//! The sensor in numbers that people compare: clock, frame time, latency, range.

use serde::Serialize;

use crate::light::distance_m;
use crate::sensor::Sensor;

/// What the hardware does in time and in space.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Figures {
    /// One clock cycle is one chip.
    pub clock_hz: f64,
    /// Chips of the reference's code period.
    pub code_period_chips: u64,
    /// Phase steps of a scan.
    pub phase_steps: u64,
    /// Phase steps of the code period.
    pub phase_steps_per_period: u64,
    /// Integration time of a phase step.
    pub integration_s: f64,
    /// From the start of one scan to that of the next: one distance of each detector.
    pub frame_time_s: f64,
    /// From a phase step's last sample to its count on the result stream.
    pub result_latency_clocks: u32,
    /// The same in seconds.
    pub result_latency_s: f64,
    /// Distance of a phase step: what the coarse stage tells apart.
    pub phase_step_distance_m: f64,
    /// Distance beyond which the code repeats.
    pub unambiguous_range_m: f64,
    /// Bits of a result.
    pub result_bits: u32,
    /// Results of a scan, of all detectors: counts, or rows of histograms.
    pub results: u64,
    /// Whether a histogram serves all phase steps at once.
    pub at_once: bool,
}

impl Figures {
    /// Those of a sensor.
    pub fn of(sensor: &Sensor) -> Figures {
        let (clock, timing, interface) = (sensor.clock(), sensor.timing(), sensor.interface());
        let seconds = |chips: f64| clock.ps(chips) * 1e-12;
        let latency = interface.result_latency_clocks;
        Figures {
            clock_hz: clock.frequency_hz(),
            code_period_chips: timing.code_chips(),
            phase_steps: timing.scan.steps,
            phase_steps_per_period: timing.scan.steps_per_period,
            integration_s: seconds(timing.scan.integration_chips as f64),
            frame_time_s: seconds(timing.scan_pitch_chips() as f64),
            result_latency_clocks: latency,
            result_latency_s: seconds(f64::from(latency)),
            phase_step_distance_m: distance_m(clock.sample_period_ps()),
            unambiguous_range_m: distance_m(timing.code_period_ps()),
            result_bits: interface.tdata_bits,
            results: match interface.histogram() {
                Some(_) => interface.beats_of_group(),
                None => timing.scan.steps * interface.reference_codes.len() as u64,
            },
            at_once: interface.histogram().is_some(),
        }
    }
}
