//! Units of a job of which each shard has every N-th.

use super::ShardError;
use super::job::Results;
use super::part::Part;

/// The units of all shards, in order. `of` gives those of a shard, `is_its` checks that a unit has
/// its number, and `reason` is the message if it has not.
pub(super) fn in_order<U>(
    units: usize,
    shards: Vec<(Part, Results)>,
    reason: &'static str,
    of: impl Fn(Results) -> Option<Vec<U>>,
    is_its: impl Fn(usize, &U) -> bool,
) -> Result<Vec<U>, ShardError> {
    let mut all: Vec<Option<U>> = (0..units).map(|_| None).collect();
    for (part, results) in shards {
        let unfit = || ShardError::Unfit { part, reason };
        let found = of(results).ok_or_else(unfit)?;
        let numbers: Vec<usize> = part.every(units as u64).map(|n| n as usize).collect();
        let are_its = numbers.iter().zip(&found).all(|(&number, unit)| is_its(number, unit));
        if numbers.len() != found.len() || !are_its {
            return Err(unfit());
        }
        for (number, unit) in numbers.into_iter().zip(found) {
            all[number] = Some(unit);
        }
    }
    Ok(all.into_iter().flatten().collect())
}
