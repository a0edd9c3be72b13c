//! `--shard`: a part of a command's work. `super::merge` joins the parts.

use serde::Serialize;

use super::common::Order;
use super::ending::Ending;
use super::output::Output;
use super::provenance::typed_command;
use crate::document::Body;
use crate::files::OutputFolder;
use crate::printable::printable_path;
use crate::scene::SceneText;
use crate::shard::{Folder, Job, Results, Shard};
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

impl Body for ShardDone {
    const NAME: &'static str = "shard-done";
}

impl Order<'_> {
    /// Does a part of a job with `work`, unless it is done already. `work` may keep what it
    /// has finished in a folder of the shard's own, which is gone in the end.
    pub fn fulfil(
        &self,
        job: Job,
        output: &Output,
        work: impl FnOnce(&OutputFolder) -> anyhow::Result<Results>,
    ) -> anyhow::Result<Ending> {
        let folder = Folder::make(self.out)?;
        let scene = job.scene().map(SceneText::reference);
        let mut done_before = folder.has(self.part, &job)?;
        // A run that was killed behind its shard's file leaves its workplace.
        if !done_before || folder.has_workplace(self.part) {
            // Of two runs of one shard the second waits, and finds it done.
            let workplace = folder.workplace(self.part, |path| output.waits(path))?;
            done_before = folder.has(self.part, &job)?;
            if !done_before {
                let results = work(&workplace)?;
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
        output.answer(scene, &report, &text)?;
        Ok(Ending::Done)
    }
}
