//! `goldtof reproduce`: the article's figures and claims.

use std::cell::RefCell;

use super::prelude::*;
use crate::shard;
use crate::study::reproduce::{MadeFigure, ReproduceOptions, Reproduction, reproduce};

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof reproduce --figure 8 --out out/article")]
pub(super) struct ReproduceArguments {
    #[command(flatten)]
    pub options: ReproduceOptions,
    /// Folder for the figures (SVG) and their data (CSV); created if missing, for
    /// example --out out/article
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Make one of N shards of the figures, for `goldtof merge` to join: --shard 3/12, or
    /// --shard task/12 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<JobPart>,
}

impl Command for ReproduceArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let options = ReproduceOptions { seed, ..self.options.clone() };
        if let Some(part) = self.shard {
            return ShardOrder { part, out: &self.out }.fulfil(Job::Reproduce(options), output);
        }
        let figures = options.figures.len() as u64;
        // Heard one after another.
        let progress = RefCell::new((Forecast::new(output, "all figures"), 0));
        let made = reproduce(&options, &output.folder(&self.out)?, |title| {
            let (forecast, done) = &mut *progress.borrow_mut();
            *done += 1;
            forecast.progress(*done, figures);
            output.note(title);
        })?;
        tell(&made, output)
    }
}

impl InShards for ReproduceOptions {
    fn part(
        &self,
        part: JobPart,
        _: &OutputFolder,
        output: &CommandOutput,
    ) -> anyhow::Result<Results> {
        let mut kept = Vec::new();
        for number in part.every(self.figures.len() as u64) {
            let figure = MadeFigure::new(self.figures[number as usize], self)?;
            output.note(&format!("{} ({:.1} s)", figure.title, figure.run_time_s));
            kept.push(figure);
        }
        Ok(Results::Reproduce(kept))
    }

    fn merge(
        &self,
        parts: PartResults,
        out: &Path,
        output: &CommandOutput,
    ) -> anyhow::Result<Ending> {
        let figures = shard::figures(self, parts)?;
        let folder = output.folder(out)?;
        for figure in &figures {
            figure.write(&folder)?;
        }
        tell(&Reproduction::of(self, figures), output)
    }
}

fn tell(made: &Reproduction, output: &CommandOutput) -> anyhow::Result<Ending> {
    output.answer(None, made, &made.to_text())?;
    Ok(if made.holds() { Ending::Done } else { Ending::DoesNotHold })
}
