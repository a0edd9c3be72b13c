//! `goldtof simulate`.

use super::Ending;
use super::arguments::SimulateArguments;
use super::forecast::announce;
use super::output::Output;
use super::warnings::warn_of_far_paths;
use crate::scene;
use crate::sensor::Sensor;
use crate::simulate::forecast;
use crate::simulate::repeat::simulate;

pub(super) fn run(
    arguments: &SimulateArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let scene = scene::load(&arguments.scene.scene)?.with_estimator(arguments.estimator)?;
    let sensor = Sensor::new(&scene);
    warn_of_far_paths(&sensor, output);
    if let Some(seconds) = forecast::seconds(&sensor, arguments.fidelity, arguments.repeat) {
        announce(output, "the simulation", seconds);
    }
    let simulation = simulate(&sensor, arguments.fidelity, seed, arguments.repeat)?;
    for warning in &simulation.warnings {
        output.note(&format!("warning: {warning}"));
    }
    output.answer(&simulation, &simulation.to_text())?;
    Ok(Ending::Done)
}
