//! Faults and mutants, every N-th of each kind for each shard.

use super::ShardError;
use super::job::{GradeJob, Results};
use super::part::Part;
use crate::grade::{Grade, Graded, Outcomes};

/// Numbers of a part's variants of a kind.
pub fn variants(part: Part, count: usize) -> Vec<usize> {
    part.every(count as u64).map(|number| number as usize).collect()
}

/// The grade by all shards together.
///
/// # Errors
/// When a shard's faults and mutants are not those of its part.
pub fn whole_grade(job: &GradeJob, shards: Vec<(Part, Results)>) -> Result<Grade, ShardError> {
    let mut all: Option<Graded> = None;
    for (part, results) in shards {
        let reason = "it has other faults or mutants";
        let unfit = || ShardError::Unfit { part, reason };
        let Results::Grade(graded) = results else {
            return Err(unfit());
        };
        let are_its = |outcomes: &Outcomes| {
            let numbers = outcomes.of.iter().map(|outcome| outcome.number as u64);
            numbers.eq(part.every(outcomes.total as u64))
        };
        if !are_its(&graded.faults) || !graded.mutants.iter().all(are_its) {
            return Err(unfit());
        }
        all = Some(match all {
            None => graded,
            Some(all) => joined(all, graded).ok_or_else(unfit)?,
        });
    }
    let all = all.ok_or_else(|| ShardError::NoJob { reason: "it has no shards".to_owned() })?;
    Ok(all.grade(&job.options))
}

/// Two shards, if they are of the same variants under the same stimulus.
fn joined(mut all: Graded, more: Graded) -> Option<Graded> {
    let is_same = all.clocks == more.clocks && all.faults.total == more.faults.total;
    all.faults.append(more.faults);
    match (&mut all.mutants, more.mutants) {
        (None, None) => {}
        (Some(mutants), Some(more)) if mutants.total == more.total => mutants.append(more),
        _ => return None,
    }
    is_same.then_some(all)
}
