//! What a co-simulation found, as it is told.

use std::path::PathBuf;

use serde::Serialize;

use super::engine::{Engine, EnginePart};
use super::exercised::{Exercised, missing};
use super::latency::HeldLatency;
use super::lockstep::LockstepOutcome;
use super::mismatch::FirstMismatch;
use super::shift::{PortDifference, differences};
use super::{CosimOptions, StimulusKind};
use crate::document::Body;
use crate::reference::adversarial::Means;
use crate::reference::cover_report::Coverage;
use crate::reference::coverage::CoverTable;
use crate::sensor::Sensor;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

/// What a co-simulation found; the JSON of `goldtof cosim`.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// What the comparison says.
    pub verdict: Verdict,
    /// Clocks compared.
    pub clocks: u64,
    /// Output ports compared at every clock.
    pub compared_ports: Vec<String>,
    /// Phase steps that ended within these clocks.
    pub phase_steps: u64,
    /// What the compared outputs have shown: a match says no more than that.
    pub exercised: Exercised,
    /// Why equal outputs say nothing of the sensor, and what would; with an
    /// inconclusive verdict.
    pub missing: Vec<String>,
    /// How much of what the sensor can be made to do has shown.
    pub coverage: Coverage,
    /// What else was not exercised.
    pub not_exercised: Vec<&'static str>,
    /// Clocks at which a port differed.
    pub mismatches: u64,
    /// The first difference.
    pub first_mismatch: Option<FirstMismatch>,
    /// Clocks per second of wall time, photons, reference model and comparison
    /// included, building excluded.
    pub clocks_per_s: f64,
    /// What the peak detector's ports showed at the end, detector by detector;
    /// none without a peak detector, or if no scan of a run without resets had
    /// come to its peak.
    pub peaks: Vec<PortPeak>,
    /// What drove both sides.
    pub stimulus: StimulusKind,
    /// Its seed.
    pub seed: u64,
    /// How each port differs round the first mismatch.
    pub differences: Vec<PortDifference>,
    /// The latency that the Verilog was held to, if not the emitted design's.
    pub latency: Option<HeldLatency>,
    /// What was ignored of the Verilog, or assumed.
    pub remarks: Vec<String>,
    /// What was done in lanes and what in lock-step.
    pub engines: Vec<EnginePart>,
    /// Why nothing was done in lanes, if that was asked for or left to goldtof.
    pub not_in_lanes: Option<String>,
    /// The waveform file, if one was written; bytes of its name that are no text are
    /// replaced in JSON.
    #[serde(serialize_with = "path_text")]
    #[schemars(with = "Option<String>")]
    pub vcd: Option<PathBuf>,
    /// The clocks in it.
    pub vcd_clocks: Option<VcdClocks>,
}

/// The clocks of a waveform file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct VcdClocks {
    /// The first clock, counted from the start of the run.
    pub from: u64,
    /// Number of clocks.
    pub clocks: u64,
}

impl Report {
    /// What was done in lanes and what in lock-step, in a few words.
    pub fn engines_text(&self) -> String {
        let part = |part: &EnginePart| {
            let drive = match part.stimulus {
                StimulusKind::Photons => "photons",
                StimulusKind::Adversarial => "adversarial stimulus",
            };
            match part.lanes {
                Some(lanes) => format!(
                    "{} clocks of {drive} in {lanes} lanes, each of which ends in every register as the \
                     next one starts, {} of them in Verilator's lanes, too",
                    part.clocks,
                    part.refereed_clocks.unwrap_or_default()
                ),
                None => format!("{} clocks of {drive} in lock-step", part.clocks),
            }
        };
        let mut text = self.engines.iter().map(part).collect::<Vec<String>>().join("; ");
        if let Some(why) = &self.not_in_lanes {
            text += &format!(" (not in lanes: {why})");
        }
        text
    }
}

impl Body for Report {
    const NAME: &'static str = "cosim";
}

/// What a comparison says of the Verilog.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every output was as expected at every clock, and the sensor has worked.
    Match,
    /// Some output was not.
    Mismatch,
    /// Every output was as expected, but too little has happened to tell.
    Inconclusive,
}

impl std::fmt::Display for Verdict {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Verdict::Match => "match",
            Verdict::Mismatch => "mismatch",
            Verdict::Inconclusive => "inconclusive",
        })
    }
}

/// A peak as the hardware's ports show it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct PortPeak {
    /// The detector's name.
    pub detector: String,
    /// Phase step k of a scan's largest count.
    pub phase_step: u64,
    /// That count.
    pub count: i64,
}

/// A path in JSON, which has no bytes that are not text.
fn path_text<S: serde::Serializer>(path: &Option<PathBuf>, json: S) -> Result<S::Ok, S::Error> {
    path.as_ref().map(|path| path.to_string_lossy()).serialize(json)
}

/// What is to be said of an outcome.
pub(super) fn report(
    sensor: &Sensor,
    options: &CosimOptions,
    outcome: &LockstepOutcome,
    layout: &Layout,
    coverage: Coverage,
) -> Report {
    let fields = &layout.outputs.fields;
    let detectors = sensor.scene().detectors.iter();
    let names = detectors.map(|detector| detector.name.as_str());
    let exercised = outcome.exercise.clone().named(names);
    let missing = match &outcome.first {
        Some(_) => Vec::new(),
        None => missing(&exercised, sensor.interface(), options.stimulus),
    };
    let mut report = Report {
        verdict: match &outcome.first {
            Some(_) => Verdict::Mismatch,
            None if missing.is_empty() => Verdict::Match,
            None => Verdict::Inconclusive,
        },
        clocks: outcome.clocks,
        compared_ports: fields.iter().map(|field| field.port.name.clone()).collect(),
        phase_steps: exercised.phase_steps,
        not_exercised: exercised.not_reached(sensor.interface()),
        exercised,
        coverage,
        missing,
        mismatches: outcome.mismatches,
        first_mismatch: outcome
            .first
            .as_ref()
            .map(|first| FirstMismatch::new(sensor, &fields[first.field], first)),
        clocks_per_s: outcome.clocks as f64 / outcome.elapsed.as_secs_f64(),
        peaks: Vec::new(),
        stimulus: options.stimulus,
        seed: options.seed,
        differences: match &outcome.first {
            Some(_) => differences(&outcome.found.records, layout, outcome.ignores_idle_payload),
            None => Vec::new(),
        },
        latency: HeldLatency::of(sensor),
        remarks: Vec::new(),
        engines: Vec::new(),
        not_in_lanes: None,
        vcd: None,
        vcd_clocks: None,
    };
    report.engines.push(part_of(&report));
    report
}

/// A run in lock-step.
pub(super) fn part_of(report: &Report) -> EnginePart {
    EnginePart {
        engine: Engine::Lockstep,
        stimulus: report.stimulus,
        clocks: report.clocks,
        lanes: None,
        refereed_clocks: None,
    }
}

/// How much of what can be covered an outcome has shown; `means` of an adversary.
pub(super) fn coverage(
    sensor: &Sensor,
    table: &CoverTable,
    outcome: &LockstepOutcome,
    means: Option<Means>,
) -> Coverage {
    let detectors = sensor.scene().detectors.iter();
    let names: Vec<String> = detectors.map(|detector| detector.name.clone()).collect();
    let covered = &outcome.exercise.covered;
    Coverage::new(sensor.interface(), table, covered, &names, means)
}

/// Reads the peak detector's ports, if there are any.
pub(super) fn peaks(sensor: &Sensor, layout: &Layout, outputs: &[u64]) -> Vec<PortPeak> {
    let Some(peak) = sensor.interface().peak() else {
        return Vec::new();
    };
    let [steps, counts] =
        [PortRole::PeakStep, PortRole::PeakCount].map(|port| layout.outputs.field(port));
    sensor
        .scene()
        .detectors
        .iter()
        .zip(0u32..)
        .map(|(detector, number)| {
            let unsigned = counts.bits(outputs, number * peak.count_bits, peak.count_bits);
            let unused = u64::BITS - peak.count_bits;
            PortPeak {
                detector: detector.name.clone(),
                phase_step: steps.bits(outputs, number * peak.step_bits, peak.step_bits),
                count: (unsigned << unused).cast_signed() >> unused,
            }
        })
        .collect()
}
