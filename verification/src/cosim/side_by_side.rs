//! A run of the Verilog itself beside the reference model, from the stimulus to the report.

use std::sync::Arc;

use super::build::Built;
use super::error::{CosimError, When};
use super::lockstep::{Lockstep, LockstepOutcome};
use super::report::{coverage, peaks, report};
use super::sent::SentCount;
use super::verilated::Verilated;
use super::window::Window;
use super::{CosimOptions, Cosimulation, StimulusKind};
use crate::photons::DetectorModel;
use crate::reference::adversarial::{Adversarial, LONGEST_DEFAULT, Means};
use crate::reference::photons::{Photons, RecordedPulses};
use crate::reference::predictor::ReferenceModel;
use crate::reference::stimulus::{Stimulus, clocks_for_scans};
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;
use crate::sensor::layout::Layout;

/// Runs built Verilog and reference model side by side, clock by clock.
///
/// # Errors
/// When the model fails, or ends the simulation.
pub(super) fn run(
    sensor: &Sensor,
    mut reference: ReferenceModel,
    built: &Built,
    options: &CosimOptions,
    on_progress: &mut dyn FnMut(u64, u64),
) -> Result<Cosimulation, CosimError> {
    let interface = sensor.interface();
    let layout = Layout::of(interface);
    let mut model = Verilated::load(built, &layout)?;
    let detectors: Vec<DetectorModel> = DetectorIndex::of(&sensor.scene().detectors)
        .map(|detector| DetectorModel::new(sensor, detector))
        .collect();
    let means = Means::cosim(built.registers.is_some());
    let (mut stimulus, clocks) = stimulus(sensor, &detectors, options, means)?;
    let mut counts: Vec<Vec<SentCount>> = vec![Vec::new(); sensor.scene().detectors.len()];
    let mut hits: Vec<Vec<u64>> = vec![Vec::new(); counts.len()];
    let outcome = Lockstep {
        model: &mut model,
        reference: &mut reference,
        stimulus: stimulus.as_mut(),
        layout: &layout,
        window: options.window.clone(),
    }
    .run_and_read(
        clocks,
        &mut |result| {
            if result.scan == 0 {
                hits[result.detector].push(result.total);
            }
        },
        &mut |sent| {
            if sent.scan == 0 {
                counts[sent.detector].push(sent);
            }
        },
        &mut |done| on_progress(done, clocks),
    )?;
    finish(&mut model, &outcome)?;
    let means = (options.stimulus == StimulusKind::Adversarial).then_some(means);
    let coverage = coverage(sensor, reference.cover_table(), &outcome, means);
    let mut report = report(sensor, options, &outcome, &layout, coverage);
    if options.stimulus == StimulusKind::Photons && outcome.clocks >= clocks_for_scans(interface, 1)
    {
        report.peaks = peaks(sensor, &layout, &outcome.last_outputs);
    }
    Ok(Cosimulation { report, counts, hits, outcome, layout, clock: sensor.clock() })
}

/// Where the inputs come from, and for how many clocks: as many as asked for, or one scan of
/// photons, or all that an adversary needs.
fn stimulus<'d>(
    sensor: &'d Sensor,
    detectors: &'d [DetectorModel],
    options: &CosimOptions,
    means: Means,
) -> Result<(Box<dyn Stimulus + 'd>, u64), CosimError> {
    let interface = sensor.interface();
    let (stimulus, clocks): (Box<dyn Stimulus + 'd>, u64) = match options.stimulus {
        StimulusKind::Photons => {
            let clocks = options.clocks;
            let clocks = clocks.unwrap_or_else(|| clocks_for_scans(interface, 1));
            match &options.recorded {
                Some(pulses) => {
                    (Box::new(RecordedPulses::new(Arc::clone(pulses), interface)), clocks)
                }
                None => (Box::new(Photons::new(detectors, interface, options.seed)), clocks),
            }
        }
        StimulusKind::Adversarial => {
            let adversarial = Adversarial::with_means(interface, options.seed, means)?;
            let clocks = options.clocks;
            let clocks =
                clocks.unwrap_or_else(|| adversarial.clone().clocks_of_a_run(LONGEST_DEFAULT));
            (Box::new(adversarial), clocks)
        }
    };
    match &options.window {
        Window::Clocks(asked) if asked.start >= clocks => {
            Err(CosimError::BeyondTheRun { asked: asked.start, clocks })
        }
        _ => Ok((stimulus, clocks)),
    }
}

/// Runs the final blocks; they have no say where a port differs already.
fn finish(model: &mut Verilated, outcome: &LockstepOutcome) -> Result<(), CosimError> {
    let when = When::End;
    match model.finish() {
        Err(reason) if outcome.first.is_none() => Err(CosimError::Halted { when, reason }),
        _ => Ok(()),
    }
}
