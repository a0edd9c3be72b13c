//! `goldtof reproduce`: the article's figures and claims.

use std::cell::RefCell;
use std::path::Path;

use super::arguments::{Order, ReproduceArguments};
use super::ending::Ending;
use super::forecast::Forecast;
use super::output::Output;
use crate::shard::{self, Job, Part, ReproduceJob, Results};
use crate::study::reproduce::{FigureId, MadeFigure, Options, Reproduction, reproduce};

pub(super) fn run(
    arguments: &ReproduceArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let options = Options {
        seed,
        repetitions: arguments.repeat,
        figures: match arguments.figure {
            Some(figure) => vec![figure],
            None => FigureId::ALL.to_vec(),
        },
    };
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
fn some_figures(options: &Options, order: &Order, output: &Output) -> anyhow::Result<Ending> {
    let job = Job::Reproduce(ReproduceJob {
        figures: options.figures.clone(),
        repetitions: options.repetitions,
        seed: options.seed,
    });
    order.fulfil(job, output, |_| {
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
    job: &ReproduceJob,
    shards: Vec<(Part, Results)>,
    out: &Path,
    output: &Output,
) -> anyhow::Result<Ending> {
    let options = job.options();
    let figures = shard::figures(&options, shards)?;
    let folder = output.folder(out)?;
    for figure in &figures {
        figure.write(&folder)?;
    }
    tell(&Reproduction::of(&options, figures), output)
}

fn tell(made: &Reproduction, output: &Output) -> anyhow::Result<Ending> {
    output.answer(None, made, &made.to_text())?;
    Ok(if made.holds() { Ending::Done } else { Ending::DoesNotHold })
}
