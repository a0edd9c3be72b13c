//! Points of a sweep, every N-th for each shard.

use super::ShardError;
use super::every::in_order;
use super::job::{PointRows, Results};
use super::part::Part;
use crate::report::table::Table;
use crate::study::sweep::{Store, StoreError, Sweep, empty};

/// The finished points of a part, from where they were kept.
///
/// # Errors
/// When one cannot be read.
pub fn rows(part: Part, sweep: &Sweep, store: &Store) -> Result<Vec<PointRows>, StoreError> {
    let heading = empty(&sweep.options.over).heading();
    let of_point = |point: u64| {
        let rows_csv = heading.clone() + &store.rows_csv(point as usize)?;
        Ok(PointRows { point, rows_csv })
    };
    part.every(sweep.len() as u64).map(of_point).collect()
}

/// The rows of all shards, point by point.
///
/// # Errors
/// When a shard's points are not those of its part.
pub fn tables(sweep: &Sweep, shards: Vec<(Part, Results)>) -> Result<Vec<Table>, ShardError> {
    let read = |rows: PointRows| {
        let mut table = empty(&sweep.options.over);
        table.read_csv(&rows.rows_csv).ok()?;
        Some((rows.point, table))
    };
    let points = |results| match results {
        Results::Sweep(points) => points.into_iter().map(read).collect(),
        _ => None,
    };
    let is_its = |number: usize, (point, _): &(u64, Table)| *point == number as u64;
    let reason = "it has other points, or other columns";
    let points = in_order(sweep.len(), shards, reason, points, is_its)?;
    Ok(points.into_iter().map(|(_, table)| table).collect())
}
