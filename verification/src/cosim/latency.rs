//! Designs whose results come at other clocks than the emitted design's.
//!
//! The interface leaves open how many clocks a design takes from a step's last word to its
//! result; the emitted design's latency is one of many that are right. The reference model
//! is simply told another one, and everything that depends on it (stream, overrun,
//! saturation, peak) follows, whatever the receiver does. Nothing is shifted afterwards.

use serde::Serialize;

use super::asked_latency::{Latency, MOST_CLOCKS};
use super::engine::Engine;
use super::error::CosimError;
use super::shift::PortDifference;
use super::source::Verilog;
use super::{CosimOptions, Cosimulation, StimulusKind, cosimulate};
use crate::reference::stimulus::{RESET_CLOCKS, clocks_for_scans};
use crate::sensor::Sensor;
use crate::sensor::interface::Interface;
use crate::sensor::port::PortRole;

/// Clocks behind the expected result in which it is looked for.
const PATIENCE: u64 = 1_000;
/// Runs that look for latencies: one for the stream, one for the peak, one to see that
/// both are right.
const MOST_RUNS: usize = 3;

/// The latency that a design was held to, where it is not the emitted design's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct HeldLatency {
    /// Clocks from a group's last word to its first result.
    pub result_clocks: u32,
    /// The emitted design's.
    pub emitted_result_clocks: u32,
    /// Clocks from a scan's last word to its peak, with a peak detector.
    pub peak_clocks: Option<u32>,
    /// The emitted design's.
    pub emitted_peak_clocks: Option<u32>,
}

impl HeldLatency {
    /// What a sensor is held to, if that is not what is emitted for it.
    pub fn of(sensor: &Sensor) -> Option<HeldLatency> {
        let (held, emitted) = (sensor.interface(), Interface::of(sensor.scene()));
        let peak = |interface: &Interface| interface.peak().map(|peak| peak.latency_clocks);
        let latency = HeldLatency {
            result_clocks: held.result_latency_clocks,
            emitted_result_clocks: emitted.result_latency_clocks,
            peak_clocks: peak(held),
            emitted_peak_clocks: peak(&emitted),
        };
        let is_other = latency.result_clocks != latency.emitted_result_clocks
            || latency.peak_clocks != latency.emitted_peak_clocks;
        is_other.then_some(latency)
    }

    /// In one line.
    pub fn text(&self) -> String {
        let compared = |what: &str, held: u32, emitted: u32| {
            let than = match held.abs_diff(emitted) {
                0 => return format!("{what} after {held} clocks, as the emitted design's"),
                by if held > emitted => format!("{by} later"),
                by => format!("{by} earlier"),
            };
            format!("{what} after {held} clocks, {than} than the emitted design's")
        };
        let results = compared("results", self.result_clocks, self.emitted_result_clocks);
        match (self.peak_clocks, self.emitted_peak_clocks) {
            (Some(held), Some(emitted)) => {
                format!("{results}; {}", compared("the peak", held, emitted))
            }
            _ => results,
        }
    }
}

/// The sensor with the latency that a design is to be held to.
///
/// # Errors
/// As a co-simulation, which shows a design's own.
pub(super) fn held_to(
    sensor: &Sensor,
    verilog: &Verilog,
    options: &CosimOptions,
) -> Result<Sensor, CosimError> {
    match options.latency {
        Latency::Emitted => Ok(sensor.clone()),
        Latency::Clocks { result, peak } => Ok(held_to_clocks(sensor, result, peak)),
        Latency::Auto => found(sensor, verilog, options),
    }
}

/// The sensor whose results come after so many clocks; without a peak's own latency it
/// moves by as much as theirs.
pub(crate) fn held_to_clocks(sensor: &Sensor, result: u32, peak: Option<u32>) -> Sensor {
    let moved = i64::from(result) - i64::from(sensor.interface().result_latency_clocks);
    let shifted = shifted(sensor, moved, moved);
    match peak {
        Some(peak) => shifted.with_latency(result, peak),
        None => shifted,
    }
}

/// The latency that a run of photons shows, in which the receiver takes everything at once.
fn found(sensor: &Sensor, verilog: &Verilog, options: &CosimOptions) -> Result<Sensor, CosimError> {
    let mut held = sensor.clone();
    for _ in 0..MOST_RUNS {
        let options = CosimOptions {
            latency: Latency::Emitted,
            stimulus: StimulusKind::Photons,
            engine: Engine::Lockstep,
            clocks: Some(clocks_to_see(held.interface())),
            ..options.clone()
        };
        let run = cosimulate(&held, verilog, &options, |_, _| ())?;
        let Some(next) = adjusted(&held, &run) else {
            break;
        };
        held = next;
    }
    Ok(held)
}

/// Clocks in which the first result, and the first peak, are there.
fn clocks_to_see(interface: &Interface) -> u64 {
    let chips = interface.timing.scan.integration_chips + interface.lead_clocks();
    let beats = interface.beats_of_group();
    let results = chips + u64::from(interface.result_latency_clocks) + RESET_CLOCKS + beats;
    let all = match interface.peak() {
        Some(_) => clocks_for_scans(interface, 1).max(results),
        None => results,
    };
    all.saturating_add(PATIENCE)
}

/// The sensor with the latency that a run's first difference shows, if it shows one.
fn adjusted(sensor: &Sensor, run: &Cosimulation) -> Option<Sensor> {
    let late = |port: PortRole| {
        let of_port = |difference: &&PortDifference| difference.port == port.name();
        run.report.differences.iter().find(of_port)?.clocks_late
    };
    if let Some(late) = late(PortRole::Valid) {
        return Some(shifted(sensor, late, late));
    }
    late(PortRole::PeakValid).map(|late| shifted(sensor, 0, late))
}

fn shifted(sensor: &Sensor, result: i64, peak: i64) -> Sensor {
    let interface = sensor.interface();
    let by =
        |clocks: u32, late: i64| (i64::from(clocks) + late).clamp(0, i64::from(MOST_CLOCKS)) as u32;
    let of_peak = interface.peak_latency_clocks();
    sensor.with_latency(by(interface.result_latency_clocks, result), by(of_peak, peak))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_latency_is_a_word_or_one_number_or_two() {
        assert_eq!("auto".parse(), Ok(Latency::Auto));
        let clocks = |result, peak| Ok(Latency::Clocks { result, peak });
        assert_eq!("7".parse(), clocks(7, None));
        assert_eq!("7,31".parse(), clocks(7, Some(31)));
        for text in ["", "-1", "7,", "4097", "1,2,3", "Auto", "1.5"] {
            assert!(text.parse::<Latency>().is_err(), "{text}");
        }
    }
}
