//! Figures, every N-th for each shard.

use super::ShardError;
use super::job::{ReproduceJob, Results};
use super::part::Part;
use crate::study::reproduce::{FigureId, MadeFigure, Options};

impl ReproduceJob {
    /// What is to be made.
    ///
    /// # Errors
    /// When there is no figure of a name.
    pub fn options(&self) -> Result<Options, ShardError> {
        let of_name = |name: &String| {
            let mut known = FigureId::ALL.into_iter();
            let found = known.find(|id| id.name() == name);
            found.ok_or_else(|| ShardError::NoJob {
                reason: format!("there is no figure \"{name}\""),
            })
        };
        Ok(Options {
            seed: self.seed,
            repetitions: self.repetitions,
            figures: self.figures.iter().map(of_name).collect::<Result<_, _>>()?,
        })
    }
}

/// The figures of all shards, in the order of the options.
///
/// # Errors
/// When a shard's figures are not those of its part.
pub fn figures(
    options: &Options,
    shards: Vec<(Part, Results)>,
) -> Result<Vec<MadeFigure>, ShardError> {
    let mut made: Vec<Option<MadeFigure>> = vec![None; options.figures.len()];
    for (part, results) in shards {
        let reason = "it has other figures";
        let unfit = || ShardError::Unfit { part, reason };
        let Results::Reproduce(kept) = results else {
            return Err(unfit());
        };
        let numbers: Vec<usize> = part.every(made.len() as u64).map(|n| n as usize).collect();
        if numbers.len() != kept.len() {
            return Err(unfit());
        }
        for (number, kept) in numbers.into_iter().zip(&kept) {
            let figure = kept.figure().ok_or_else(unfit)?;
            if figure.id != options.figures[number] {
                return Err(unfit());
            }
            made[number] = Some(figure);
        }
    }
    Ok(made.into_iter().flatten().collect())
}
