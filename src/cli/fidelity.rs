//! `goldtof fidelity`.

use std::time::Duration;

use super::arguments::FidelityArguments;
use super::ending::Ending;
use super::forecast::announce;
use super::output::Output;
use super::warnings::warn_of_far_paths;
use crate::printable::printable_path;
use crate::sensor::Sensor;
use crate::study::fidelity::compare;

pub(super) fn run(
    arguments: &FidelityArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let scene = arguments.scene.load()?;
    warn_of_far_paths(&Sensor::new(&scene), output);
    let budget = Duration::from_secs(arguments.budget_s);
    // Before the long work, so that a folder that cannot be had is told at once.
    let folder = match &arguments.out {
        Some(path) => Some(output.folder(path)?),
        None => None,
    };
    announce(output, "the comparison", arguments.budget_s as f64);
    let report = compare(&scene, seed, budget, arguments.target_error)?;
    for tier in &report.domains {
        for warning in &tier.warnings {
            output.note(&format!("warning: {}: {warning}", tier.fidelity));
        }
    }
    if let Some(folder) = folder {
        for name in report.write_files(&folder)? {
            output.note(&format!("wrote {}", printable_path(&folder.join(name))));
        }
    }
    output.answer(Some(&scene), &report, &report.to_text())?;
    if let Some(refusal) = &report.refusal {
        output.note(&format!("refused: {refusal}"));
        return Ok(Ending::DoesNotHold);
    }
    let holds = report.reference.expectation_holds != Some(false);
    Ok(Ending::of_check(arguments.check.check, holds))
}
