//! `goldtof reproduce`: the article's figures and claims.

use std::cell::RefCell;

use super::Ending;
use super::arguments::ReproduceArguments;
use super::forecast::Forecast;
use super::output::Output;
use crate::study::reproduce::{FigureId, Options, reproduce};

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
    let figures = options.figures.len() as u64;
    // Heard one after another.
    let progress = RefCell::new((Forecast::new(output, "all figures"), 0));
    let made = reproduce(&options, &output.folder(&arguments.out)?, |title| {
        let (forecast, done) = &mut *progress.borrow_mut();
        *done += 1;
        forecast.progress(*done, figures);
        output.note(title);
    })?;
    output.answer(None, &made, &made.to_text())?;
    Ok(if made.holds() {
        Ending::Done
    } else {
        Ending::DoesNotHold
    })
}
