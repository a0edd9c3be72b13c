//! `goldtof reproduce`: the article's figures and claims.

use super::Ending;
use super::arguments::ReproduceArguments;
use super::output::Output;
use crate::reproduce::{FigureId, Options, reproduce};

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
    let made = reproduce(&options, &output.folder(&arguments.out)?, |title| {
        output.note(title)
    })?;
    output.answer(&made, &made.to_text())?;
    Ok(if made.holds() {
        Ending::Done
    } else {
        Ending::DoesNotHold
    })
}
