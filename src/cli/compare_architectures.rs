//! `goldtof compare-architectures`.

use super::prelude::*;
use crate::study::architectures::compare;

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof compare-architectures scenes/quick.toml --out out/architectures"
)]
pub(super) struct CompareArchitecturesArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for architectures.svg and architectures.csv; created if missing, for example
    /// --out out/architectures
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

impl Command for CompareArchitecturesArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let sensor = self.scene.sensor(output)?.summed();
        // Before the work, so that a folder that cannot be had is told at once.
        let folder = output.folder_if(self.out.as_deref())?;
        let comparison = compare(sensor.scene())?;
        if let Some(folder) = folder {
            output.wrote(&folder, &comparison.write_files(&folder)?);
        }
        output.answer(Some(sensor.scene().reference()), &comparison, &comparison.to_text())
    }
}
