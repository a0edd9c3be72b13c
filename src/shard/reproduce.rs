//! Figures, every N-th for each shard.

use super::ShardError;
use super::every::in_order;
use super::job::Results;
use super::part::Part;
use crate::study::reproduce::{MadeFigure, ReproduceOptions};

/// The figures of all shards, in the order of the options.
///
/// # Errors
/// When a shard's figures are not those of its part.
pub fn figures(
    options: &ReproduceOptions,
    shards: Vec<(Part, Results)>,
) -> Result<Vec<MadeFigure>, ShardError> {
    let figures = |results| match results {
        Results::Reproduce(figures) => Some(figures),
        _ => None,
    };
    let is_its = |number: usize, figure: &MadeFigure| figure.id == options.figures[number];
    in_order(options.figures.len(), shards, "it has other figures", figures, is_its)
}
