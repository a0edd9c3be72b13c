//! Verilog and reference model under inputs that a case has decided.

use std::ops::Range;

use super::prelude::*;
use crate::cosim::build::{build, cache_dir};
use crate::cosim::exercised::missing;
use crate::cosim::lockstep::Lockstep;
use crate::cosim::source::sources_of;
use crate::cosim::verilated::Verilated;
use crate::cosim::window::Window;
use crate::cosim::{StimulusKind, TOP};
use crate::deliver::{self, Prefix};
use crate::photons::Pulse;
use crate::reference::adversarial::Adversarial;
use crate::reference::blocks::Records;
use crate::reference::exercise::Exercised;
use crate::reference::predictor::{ReferenceModel, StepResult};
use crate::reference::stimulus::{Drive, RESET_CLOCKS, Stimulus};
use crate::scan::Sampling;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;
use crate::sensor::port::PortRole;

/// Clocks of a run whose ports can be read.
const PORT_CLOCKS: u64 = 4000;

/// Inputs of a run, decided beforehand; reset for the first clocks comes by
/// itself.
#[derive(Debug, Clone, Default)]
pub(super) struct StimulusScript {
    /// For each detector, in order of their first sample.
    pub pulses: Vec<Vec<Pulse>>,
    /// Further resets, in order.
    pub resets: Vec<Range<u64>>,
    /// Clocks at which the consumer does not take, in order.
    pub stalls: Vec<Range<u64>>,
}

impl StimulusScript {
    /// One detector with these pulses, always taken.
    pub fn new(pulses: Vec<Pulse>) -> StimulusScript {
        StimulusScript { pulses: vec![pulses], ..StimulusScript::default() }
    }
}

/// A script that is being played.
struct Player<'a> {
    script: &'a StimulusScript,
    sampling: Sampling,
}

impl Stimulus for Player<'_> {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        let samples = self.sampling.samples(&clocks);
        for (script, pulses) in self.script.pulses.iter().zip(&mut drive.pulses) {
            let first = script.partition_point(|pulse| pulse.first < samples.start);
            let end = script.partition_point(|pulse| pulse.first < samples.end);
            pulses.extend_from_slice(&script[first..end]);
        }
        let reaches = |range: &&Range<u64>| range.start < clocks.end && range.end > clocks.start;
        let reset = 0..RESET_CLOCKS;
        let resets = std::iter::once(&reset).chain(&self.script.resets);
        drive.surroundings.resets.extend(resets.filter(reaches).cloned());
        let stalls = self.script.stalls.iter();
        drive.surroundings.stalls.extend(stalls.filter(reaches).cloned());
    }
}

/// A scene's hardware, built.
pub(super) struct CaseTestbench {
    pub interface: Interface,
    layout: Layout,
    model: Verilated,
}

/// What a run gave.
pub(super) struct BenchRun {
    /// Clocks at which a port of the Verilog differed from the reference model.
    pub mismatches: u64,
    /// Results of all steps, in order.
    pub results: Vec<StepResult>,
    records: Records,
    exercise: Exercised,
}

impl CaseTestbench {
    /// Emits and builds the Verilog of a scene.
    pub fn new(scene: &Scene) -> Result<CaseTestbench, CaseError> {
        let interface = Interface::of(scene);
        let layout = Layout::of(&interface);
        let sensor = Sensor::new(scene);
        let files = deliver::verilog(&sensor, &Prefix::default(), "goldtof stress")?;
        let sources = sources_of(&files);
        let library = build(TOP, &sources, &interface, &cache_dir()?)?;
        Ok(CaseTestbench { model: Verilated::load(&library, &layout)?, interface, layout })
    }

    /// Clock at which the word of the first scan's first chip is presented.
    pub fn first_clock(&self) -> u64 {
        RESET_CLOCKS + 1
    }

    /// Plays a script for some clocks.
    pub fn play(&mut self, script: &StimulusScript, clocks: u64) -> Result<BenchRun, CaseError> {
        let sampling = self.interface.timing.sampling();
        let run = self.run(&mut Player { script, sampling }, clocks)?;
        ensure!(
            hits_are_sent(&run.exercise),
            "a detector's results that came to the stream hold no hit"
        );
        Ok(run)
    }

    /// Sets the adversary on it.
    pub fn attack(&mut self, seed: u64, clocks: u64) -> Result<BenchRun, CaseError> {
        let mut adversary = Adversarial::new(&self.interface, seed);
        let run = self.run(&mut adversary, clocks)?;
        let names = self.interface.reference_codes.iter().map(|_| "spad");
        let exercised = run.exercise.clone().named(names);
        // Agreement on nothing is not what a case is for.
        let missing = missing(&exercised, &self.interface, StimulusKind::Adversarial);
        ensure!(missing.is_empty(), "{}", missing.join("; "));
        Ok(run)
    }

    fn run(&mut self, stimulus: &mut dyn Stimulus, clocks: u64) -> Result<BenchRun, CaseError> {
        let mut results = Vec::new();
        let outcome = Lockstep {
            model: &mut self.model,
            reference: &mut ReferenceModel::new(self.interface.clone())?,
            stimulus,
            layout: &self.layout,
            window: Window::Clocks(0..PORT_CLOCKS),
        }
        .run(clocks, |result| results.push(result), |_| ())?;
        Ok(BenchRun {
            mismatches: outcome.mismatches,
            results,
            records: outcome.asked.unwrap_or(outcome.found).records,
            exercise: outcome.exercise,
        })
    }

    /// The Verilog's value of a port at each of a run's first [`PORT_CLOCKS`] clocks.
    pub fn port<'a>(&'a self, run: &'a BenchRun, port: PortRole) -> impl Iterator<Item = u64> + 'a {
        let field = self.layout.outputs.field(port).clone();
        let records = run.records.got.values.chunks_exact(self.layout.outputs.words);
        records.map(move |record| field.low_word(record))
    }
}

/// Whether a hit of every detector has come to the stream: agreement on nothing is none.
fn hits_are_sent(exercise: &Exercised) -> bool {
    exercise.detectors.iter().map(|d| d.hits_up + d.hits_down).min() > Some(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::exercise::DetectorExercised;

    #[test]
    fn a_run_without_hits_shows_nothing() {
        let hit = DetectorExercised { results: 3, hits_down: 1, ..Default::default() };
        let of = |detectors| Exercised { detectors, results_taken: 6, ..Exercised::default() };
        assert!(hits_are_sent(&of(vec![hit.clone(), hit.clone()])));
        assert!(!hits_are_sent(&of(vec![
            hit,
            DetectorExercised { results: 3, ..Default::default() }
        ])));
        assert!(!hits_are_sent(&of(Vec::new())) && !hits_are_sent(&Exercised::default()));
    }
}
