//! `goldtof pulses`.

use super::prelude::*;
use crate::files;
use crate::simulate::pulses::pulses;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof pulses build/board/scene.toml --out photons.bin")]
pub(super) struct PulsesArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// File for the pulses, 16 bytes each; a pipe is written as they come, for example --out photons.bin
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Scans, 1 to 1000000, each with light of its own, for example --scans 10
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub scans: u64,
}

impl Command for PulsesArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let sensor = self.scene.sensor(output)?;
        let mut report = None;
        let staged = files::stage(&self.out, |out| {
            report = Some(pulses(&sensor, seed, self.scans, out)?);
            Ok(())
        })?;
        staged.publish()?;
        if let Some(report) = report {
            let text = format!(
                "{} pulses in {}, {} samples of {} scan{}\n",
                report.pulses.iter().sum::<u64>(),
                printable_path(&self.out),
                report.samples,
                report.scans,
                if report.scans == 1 { "" } else { "s" },
            );
            output.answer(Some(sensor.scene().reference()), &report, &text)?;
        }
        Ok(Ending::Done)
    }
}
