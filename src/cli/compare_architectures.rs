//! `goldtof compare-architectures`.

use std::path::PathBuf;

use clap::Args;

use super::arguments::SceneArgument;
use super::ending::Ending;
use super::output::Output;
use super::warnings::warn_of_far_paths;
use crate::printable::printable_path;
use crate::sensor::Sensor;
use crate::study::architectures::compare;

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof compare-architectures scenes/quick.toml --out out/architectures"
)]
pub(super) struct CompareArchitecturesArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Folder for architectures.svg and architectures.csv; made when missing, for example
    /// --out out/architectures
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

pub(super) fn run(
    arguments: &CompareArchitecturesArguments,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let scene = arguments.scene.load()?;
    warn_of_far_paths(&Sensor::new(&scene), output);
    // Before the work, so that a folder that cannot be had is told at once.
    let folder = match &arguments.out {
        Some(path) => Some(output.folder(path)?),
        None => None,
    };
    let comparison = compare(&scene)?;
    if let Some(folder) = folder {
        for name in comparison.write_files(&folder)? {
            output.note(&format!("wrote {}", printable_path(&folder.join(name))));
        }
    }
    output.answer(Some(&scene), &comparison, &comparison.to_text())?;
    Ok(Ending::Done)
}
