//! `--shard`: a part of a command's work. `super::merge` joins the parts.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::common::{Command, ShardOrder};
use super::output::{CommandOutput, Ending};
use super::provenance::typed_command;
use crate::files::OutputFolder;
use crate::printable::printable_path;
use crate::scene::SceneText;
use crate::shard::{Job, JobPart, PartResults, Results, Shard, ShardFolder, listed};
use crate::study::sweep::Store;

/// The JSON of a command with `--shard`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct ShardDone {
    /// Which shard it is, from 1.
    shard: u64,
    /// How many there are.
    shards: u64,
    /// Its file.
    file: String,
    /// Whether it was there when this run began.
    done_before: bool,
}

/// A job that its command can do in parts.
pub(super) trait InShards {
    /// Does one part. What is finished on the way may be kept in `folder`, which is gone in the end.
    fn part(
        &self,
        part: JobPart,
        folder: &OutputFolder,
        output: &CommandOutput,
    ) -> anyhow::Result<Results>;

    /// What all parts, in their order, are together: told, and its files written into `out`.
    fn merge(
        &self,
        parts: PartResults,
        out: &Path,
        output: &CommandOutput,
    ) -> anyhow::Result<Ending>;
}

/// What the command of a job makes of it.
pub(super) fn in_shards(job: &Job) -> &dyn InShards {
    match job {
        Job::Simulate(job) => job,
        Job::Sweep(job) => job,
        Job::Reproduce(job) => job,
        Job::Stress(job) => job,
        Job::Grade(job) => job,
        Job::Image(job) => job,
    }
}

impl ShardOrder<'_> {
    /// Does a part of a job, unless it is done already.
    pub fn fulfil(&self, job: Job, output: &CommandOutput) -> anyhow::Result<Ending> {
        let folder = ShardFolder::make(self.out)?;
        let scene = job.scene().map(SceneText::reference);
        let mut done_before = folder.has(self.part, &job)?;
        // A run that was killed behind its shard's file leaves its workplace.
        if !done_before || folder.has_workplace(self.part) {
            // Of two runs of one shard the second waits, and finds it done.
            let workplace = folder.workplace(self.part, |path| output.waits(path))?;
            done_before = folder.has(self.part, &job)?;
            if !done_before {
                let results = in_shards(&job).part(self.part, &workplace, output)?;
                folder.keep(self.part, &Shard::sealed(self.part, job, results, typed_command()))?;
            }
            Store::clear(&workplace)?;
            workplace.discard();
        }
        let file = printable_path(&folder.path_of(self.part));
        let was = if done_before { " was done already" } else { "" };
        let text = format!("shard {}{was}: {file}\n", self.part);
        let report =
            ShardDone { shard: self.part.number(), shards: self.part.of(), file, done_before };
        output.answer(scene, &report, &text)
    }
}

/// The JSON of `goldtof merge --missing`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct MissingShards {
    /// Number of shards of the job.
    shards: u64,
    /// Numbers of the missing shards.
    missing: Vec<u64>,
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
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let collected = ShardFolder::collect(&self.folder)?;
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
