//! `goldtof fidelity`.

use super::forecast::announce;
use super::prelude::*;
use crate::study::fidelity::{FidelityOptions, compare};

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof fidelity scenes/quick.toml --target-error 5% --out out/fidelity"
)]
pub(super) struct FidelityArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: FidelityOptions,
    /// Folder for fidelity.svg, sensor-trade.svg and their data as CSV; created if
    /// missing, for example --out out/fidelity
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    #[command(flatten)]
    pub check: CheckArgument,
}

impl Command for FidelityArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let sensor = self.scene.sensor(output)?.summed();
        let options = FidelityOptions { seed, ..self.options.clone() };
        // Before the long work, so that a folder that cannot be had is told at once.
        let folder = output.folder_if(self.out.as_deref())?;
        announce(output, "the comparison", options.budget_s as f64);
        let report = compare(sensor.scene(), &options)?;
        for tier in &report.domains {
            for warning in &tier.warnings {
                output.note(&format!("warning: {}: {warning}", tier.fidelity));
            }
        }
        if let Some(folder) = folder {
            output.wrote(&folder, &report.write_files(&folder)?);
        }
        output.answer(Some(sensor.scene().reference()), &report, &report.to_text())?;
        if let (Some(refusal), None) = (&report.refusal, &report.recommended) {
            output.note(&format!("refused: {refusal}"));
            return Ok(Ending::DoesNotHold);
        }
        let holds = report.reference.expectation_holds != Some(false);
        Ok(Ending::of_check(self.check.check, holds))
    }
}
