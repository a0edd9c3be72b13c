//! `goldtof simulate`.

use std::path::PathBuf;

use clap::Args;

use super::common::{CheckArgument, Order, SceneArgument, ShardArguments};
use super::ending::Ending;
use super::forecast::announce;
use super::output::Output;
use super::warnings::warn;
use crate::files;
use crate::recorded::expected_csv;
use crate::scene::{SceneReference, SceneText};
use crate::sensor::Sensor;
use crate::shard::{self, Job, Part, Results, SimulateJob};
use crate::simulate::repeat::{Simulated, Simulation};
use crate::simulate::scans::Prepared;
use crate::simulate::{SimulateOptions, forecast, simulate};

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof simulate scenes/quick.toml --repeat 1000 --fidelity sampled"
)]
pub(super) struct SimulateArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: SimulateOptions,
    /// Write the expected count of each phase step, or bin of a histogram, and its
    /// standard deviation as CSV, for example --expected expected.csv
    #[arg(long, value_name = "FILE", conflicts_with = "shard")]
    pub expected: Option<PathBuf>,
    #[command(flatten)]
    pub check: CheckArgument,
    #[command(flatten)]
    pub shard: ShardArguments,
}

pub(super) fn run(
    arguments: &SimulateArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let text = arguments.scene.read()?;
    let options = SimulateOptions { seed, ..arguments.options };
    let scene = text.scene()?.with_estimator(options.estimator)?;
    let sensor = Sensor::new(&scene);
    warn(&sensor, output);
    let order = arguments.shard.order();
    let scans = order.as_ref().map_or(options.repetitions, |order| {
        let stretch = order.part.stretch(options.repetitions);
        stretch.end - stretch.start
    });
    if let Some(seconds) = forecast::seconds(&sensor, options.fidelity, scans) {
        announce(output, "the simulation", seconds);
    }
    if let Some(order) = order {
        return part(arguments, &options, &sensor, &text, &order, output);
    }
    if let Some(path) = &arguments.expected {
        let expected = expected_csv(&sensor, options.fidelity.counting())?;
        files::write(path, &expected)?;
    }
    let simulation = simulate(&sensor, options, |_| ())?;
    tell(text.reference(), &simulation, arguments.check.check, output)
}

/// Some of the scans.
fn part(
    arguments: &SimulateArguments,
    options: &SimulateOptions,
    sensor: &Sensor,
    text: &SceneText,
    order: &Order,
    output: &Output,
) -> anyhow::Result<Ending> {
    let tier = options.fidelity;
    anyhow::ensure!(
        tier.draws(),
        "the tier {tier} has no scans that could be shared out; leave out --shard"
    );
    let job = Job::Simulate(SimulateJob {
        scene: text.without_folder(),
        options: *options,
        check: arguments.check.check,
    });
    order.fulfil(job, output, |_| {
        let simulated = Simulated::new(sensor, *options)?;
        let scans = order.part.stretch(options.repetitions);
        let prepared = Prepared::new(sensor, tier, options.engine)?;
        Ok(Results::Simulate(simulated.gather(&prepared, scans, &mut |_| ())?))
    })
}

/// The simulation of all shards together.
pub(super) fn merge(
    job: &SimulateJob,
    shards: Vec<(Part, Results)>,
    output: &Output,
) -> anyhow::Result<Ending> {
    let scene = job.scene.scene()?.with_estimator(job.options.estimator)?;
    let sensor = Sensor::new(&scene);
    warn(&sensor, output);
    let simulation = shard::simulation(job, &sensor, shards)?;
    tell(job.scene.reference(), &simulation, job.check, output)
}

fn tell(
    scene: SceneReference,
    simulation: &Simulation,
    check: bool,
    output: &Output,
) -> anyhow::Result<Ending> {
    for warning in &simulation.warnings {
        output.note(&format!("warning: {warning}"));
    }
    output.answer(Some(scene), simulation, &simulation.to_text())?;
    Ok(Ending::of_check(check, simulation.is_as_expected()))
}
