//! `goldtof merge`: joins the shards of a command.

use std::path::PathBuf;

use clap::Args;
use serde::Serialize;

use super::command::Command;
use super::output::{Ending, Output};
use super::shards::in_shards;
use crate::document::Body;
use crate::shard::{Folder, listed};

/// The JSON of `goldtof merge --missing`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct MissingShards {
    /// Number of shards of the job.
    shards: u64,
    /// Numbers of the missing shards.
    missing: Vec<u64>,
}

impl Body for MissingShards {
    const NAME: &'static str = "merge-missing";
}

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof merge out/many")]
pub(super) struct MergeArguments {
    /// Output folder of the shards
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Only list the missing shards, in the format of `sbatch --array`
    #[arg(long)]
    pub missing: bool,
}

impl Command for MergeArguments {
    fn run(&self, _: u64, output: &Output) -> anyhow::Result<Ending> {
        let collected = Folder::collect(&self.folder)?;
        if self.missing {
            let missing = collected.missing();
            let text = match missing.is_empty() {
                true => String::new(),
                false => listed(&missing) + "\n",
            };
            let report = MissingShards { shards: collected.of, missing };
            return output.answer(collected.scene, &report, &text);
        }
        let job = collected.job.clone();
        let shards = collected.whole()?;
        in_shards(&job).merge(shards, &self.folder, output)
    }
}
