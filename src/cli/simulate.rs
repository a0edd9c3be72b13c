//! `goldtof simulate`.

use super::forecast::announce;
use super::prelude::*;
use crate::files;
use crate::recorded::expected_csv;
use crate::shard::{self, SimulateJob};
use crate::simulate::repeat::{Simulated, Simulation};
use crate::simulate::scans::PreparedTier;
use crate::simulate::track::Tracking;
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
    /// Acquire --repeat targets and follow each for 64 updates, for example --track --repeat 24, or for
    /// so many, --track=200
    #[arg(long, value_name = "UPDATES", num_args = 0..=1, require_equals = true, default_missing_value = "64",
        value_parser = clap::value_parser!(u64).range(1..=1_000_000), conflicts_with_all = ["shard", "expected"])]
    pub track: Option<u64>,
    /// With --track, draw the fastest target over the gain (SVG), for example --speeds speeds.svg
    #[arg(long, value_name = "FILE", requires = "track")]
    pub speeds: Option<PathBuf>,
    #[command(flatten)]
    pub check: CheckArgument,
    #[command(flatten)]
    pub shard: ShardArguments,
}

impl Command for SimulateArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let text = self.scene.read()?;
        let options = SimulateOptions { seed, ..self.options };
        let scene = text.scene()?.with_estimator(options.estimator)?.summed();
        let sensor = Sensor::new(&scene);
        warn(&sensor, output);
        if let Some(updates) = self.track {
            return self.track(&sensor, &options, updates, text.reference(), output);
        }
        let order = self.shard.order();
        let scans = order.as_ref().map_or(options.repetitions, |order| {
            let stretch = order.part.stretch(options.repetitions);
            stretch.end - stretch.start
        });
        if let Some(seconds) = forecast::seconds(&sensor, options.fidelity, scans) {
            announce(output, "the simulation", seconds);
        }
        if let Some(order) = order {
            let tier = options.fidelity;
            anyhow::ensure!(
                tier.draws(),
                "the tier {tier} has no scans that could be shared out; leave out --shard"
            );
            let (scene, check) = (text.without_folder(), self.check.check);
            return order.fulfil(Job::Simulate(SimulateJob { scene, options, check }), output);
        }
        if let Some(path) = &self.expected {
            let expected = expected_csv(&sensor, options.fidelity.counting(&sensor))?;
            files::write(path, &expected)?;
        }
        let simulation = simulate(&sensor, options, |_| ())?;
        tell(text.reference(), &simulation, self.check.check, output)
    }
}

impl SimulateArguments {
    /// Targets, acquired and followed.
    fn track(
        &self,
        sensor: &Sensor,
        options: &SimulateOptions,
        updates: u64,
        scene: SceneReference,
        output: &CommandOutput,
    ) -> anyhow::Result<Ending> {
        let tracking = Tracking::new(sensor, options)?;
        let report = tracking.track(options.repetitions, updates)?;
        if let Some(path) = &self.speeds {
            files::write(path, &tracking.speeds_svg()?)?;
        }
        output.answer(Some(scene), &report, &report.to_text())?;
        Ok(Ending::of_check(self.check.check, report.expectation_holds))
    }
}

impl InShards for SimulateJob {
    fn part(&self, part: JobPart, _: &OutputFolder, _: &CommandOutput) -> anyhow::Result<Results> {
        let options = self.options;
        let sensor = Sensor::new(&self.scene.scene()?.with_estimator(options.estimator)?.summed());
        let simulated = Simulated::new(&sensor, options)?;
        let scans = part.stretch(options.repetitions);
        let prepared = PreparedTier::new(&sensor, options.fidelity, options.engine)?;
        Ok(Results::Simulate(simulated.gather(&prepared, scans, &mut |_| ())?))
    }

    fn merge(
        &self,
        parts: PartResults,
        _: &Path,
        output: &CommandOutput,
    ) -> anyhow::Result<Ending> {
        let sensor =
            Sensor::new(&self.scene.scene()?.with_estimator(self.options.estimator)?.summed());
        warn(&sensor, output);
        let simulation = shard::simulation(self, &sensor, parts)?;
        tell(self.scene.reference(), &simulation, self.check, output)
    }
}

fn tell(
    scene: SceneReference,
    simulation: &Simulation,
    check: bool,
    output: &CommandOutput,
) -> anyhow::Result<Ending> {
    for warning in &simulation.warnings {
        output.note(&format!("warning: {warning}"));
    }
    output.answer(Some(scene), simulation, &simulation.to_text())?;
    Ok(Ending::of_check(check, simulation.is_as_expected()))
}
