//! `goldtof reproduce`: the article's figures and claims.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::Order;
use super::ending::Ending;
use super::forecast::Forecast;
use super::output::Output;
use super::values::parse_shard;
use crate::shard::{self, Job, Part, Results};
use crate::study::reproduce::{MadeFigure, ReproduceOptions, Reproduction, reproduce};

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof reproduce --figure 8 --out out/article")]
pub(super) struct ReproduceArguments {
    #[command(flatten)]
    pub options: ReproduceOptions,
    /// Folder for the figures (SVG) and their data (CSV); made when missing, for
    /// example --out out/article
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Make one of N shards of the figures, for `goldtof merge` to join: --shard 3/12, or
    /// --shard task/12 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Part>,
}

pub(super) fn run(
    arguments: &ReproduceArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let options = ReproduceOptions { seed, ..arguments.options.clone() };
    if let Some(part) = arguments.shard {
        let out = &arguments.out;
        return some_figures(&options, &Order { part, out }, output);
    }
    let figures = options.figures.len() as u64;
    // Heard one after another.
    let progress = RefCell::new((Forecast::new(output, "all figures"), 0));
    let made = reproduce(&options, &output.folder(&arguments.out)?, |title| {
        let (forecast, done) = &mut *progress.borrow_mut();
        *done += 1;
        forecast.progress(*done, figures);
        output.note(title);
    })?;
    tell(&made, output)
}

/// A part of the figures.
fn some_figures(
    options: &ReproduceOptions,
    order: &Order,
    output: &Output,
) -> anyhow::Result<Ending> {
    order.fulfil(Job::Reproduce(options.clone()), output, |_| {
        let mut kept = Vec::new();
        for number in order.part.every(options.figures.len() as u64) {
            let figure = MadeFigure::new(options.figures[number as usize], options)?;
            output.note(&format!("{} ({:.1} s)", figure.title, figure.run_time_s));
            kept.push(figure);
        }
        Ok(Results::Reproduce(kept))
    })
}

/// The figures and claims of all shards.
pub(super) fn merge(
    options: &ReproduceOptions,
    shards: Vec<(Part, Results)>,
    out: &Path,
    output: &Output,
) -> anyhow::Result<Ending> {
    let figures = shard::figures(options, shards)?;
    let folder = output.folder(out)?;
    for figure in &figures {
        figure.write(&folder)?;
    }
    tell(&Reproduction::of(options, figures), output)
}

fn tell(made: &Reproduction, output: &Output) -> anyhow::Result<Ending> {
    output.answer(None, made, &made.to_text())?;
    Ok(if made.holds() { Ending::Done } else { Ending::DoesNotHold })
}
