//! `goldtof simulate`.

use super::Ending;
use super::arguments::SimulateArguments;
use super::forecast::announce;
use super::output::Output;
use super::warnings::warn_of_far_paths;
use crate::files;
use crate::recorded::expected_csv;
use crate::sensor::Sensor;
use crate::simulate::forecast;
use crate::simulate::repeat::simulate_with;

pub(super) fn run(
    arguments: &SimulateArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let scene = arguments.scene.load()?;
    let scene = scene.with_estimator(arguments.estimator)?;
    let sensor = Sensor::new(&scene);
    warn_of_far_paths(&sensor, output);
    if let Some(seconds) = forecast::seconds(&sensor, arguments.fidelity, arguments.repeat) {
        announce(output, "the simulation", seconds);
    }
    if let Some(path) = &arguments.expected {
        let expected = expected_csv(&sensor, arguments.fidelity.counting())?;
        files::write(path, &expected)?;
    }
    let simulation = simulate_with(
        &sensor,
        arguments.fidelity,
        arguments.engine,
        seed,
        arguments.repeat,
    )?;
    for warning in &simulation.warnings {
        output.note(&format!("warning: {warning}"));
    }
    output.answer(Some(&scene), &simulation, &simulation.to_text())?;
    Ok(Ending::Done)
}
