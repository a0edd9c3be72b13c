//! `--shard`: a part of a command's work, and `goldtof merge`, which joins the parts.

use std::path::Path;

use serde::Serialize;

use super::arguments::MergeArguments;
use super::output::Output;
use super::provenance::typed_command;
use super::{Ending, grade, reproduce, simulate, stress, sweep};
use crate::document::{Body, Document};
use crate::files::OutputFolder;
use crate::printable::printable_path;
use crate::shard::{Folder, Job, Part, Results, SceneText, Shard, listed};

/// The JSON of a command with `--shard`.
#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
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

impl Body for ShardDone {
    const NAME: &'static str = "shard-done";
}

/// The JSON of `goldtof merge --missing`.
#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub(super) struct MissingShards {
    /// How many shards there are to be.
    shards: u64,
    /// Numbers of those that are not there.
    missing: Vec<u64>,
}

impl Body for MissingShards {
    const NAME: &'static str = "merge-missing";
}

/// Which part of the work, and where it goes.
pub(super) struct Order<'a> {
    /// Which part.
    pub part: Part,
    /// The folder of the job's shards is in this one.
    pub out: &'a Path,
}

impl Order<'_> {
    /// Does a part of a job with `work`, unless it is done already. `work` may keep what it
    /// has finished in a folder of the shard's own, and tidies that up in the end.
    pub fn fulfil(
        &self,
        job: Job,
        output: &Output,
        work: impl FnOnce(&OutputFolder) -> anyhow::Result<(Results, TidyUp)>,
    ) -> anyhow::Result<Ending> {
        let folder = Folder::make(self.out)?;
        let scene = job.scene().map(SceneText::reference);
        let mut done_before = folder.has(self.part, &job)?;
        if !done_before {
            // Of two runs of one shard the second waits, and finds it done.
            let workplace = folder.workplace(self.part, |path| output.waits(path))?;
            done_before = folder.has(self.part, &job)?;
            if !done_before {
                let (results, tidy_up) = work(&workplace)?;
                let shard = Document {
                    scene: scene.clone(),
                    ..Document::new(Shard::new(self.part, job, results), typed_command(), None)
                };
                folder.keep(self.part, &shard)?;
                tidy_up(&workplace)?;
            }
            workplace.discard();
        }
        let file = printable_path(&folder.path_of(self.part));
        let was = if done_before { " was done already" } else { "" };
        let text = format!("shard {}{was}: {file}\n", self.part);
        let report = ShardDone {
            shard: self.part.number(),
            shards: self.part.of(),
            file,
            done_before,
        };
        let document = Document {
            scene,
            ..Document::new(report, typed_command(), None)
        };
        output.answer_document(&document, &text)?;
        Ok(Ending::Done)
    }
}

/// Removes what was kept on the way to a shard's file, once that is there.
pub(super) type TidyUp = Box<dyn FnOnce(&OutputFolder) -> anyhow::Result<()>>;

/// What work that keeps nothing on the way gives.
pub(super) fn at_once(results: Results) -> (Results, TidyUp) {
    (results, Box::new(|_| Ok(())))
}

pub(super) fn merge(arguments: &MergeArguments, output: &mut Output) -> anyhow::Result<Ending> {
    let collected = Folder::collect(&arguments.folder)?;
    if arguments.missing {
        let missing = collected.missing();
        let text = match missing.is_empty() {
            true => String::new(),
            false => listed(&missing) + "\n",
        };
        let report = MissingShards {
            shards: collected.of,
            missing,
        };
        let document = Document {
            scene: collected.scene,
            ..Document::new(report, typed_command(), None)
        };
        output.answer_document(&document, &text)?;
        return Ok(Ending::Done);
    }
    let job = collected.job.clone();
    let shards = collected.whole()?;
    match &job {
        Job::Simulate(job) => simulate::merge(job, shards, output),
        Job::Sweep(job) => sweep::merge(job, shards, &arguments.folder, output),
        Job::Reproduce(job) => reproduce::merge(job, shards, &arguments.folder, output),
        Job::Stress(job) => stress::merge(job, shards, output),
        Job::Grade(job) => grade::merge(job, shards, output),
    }
}
