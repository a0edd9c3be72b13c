//! Points of a sweep, every N-th for each shard.

use std::collections::BTreeMap;

use super::ShardError;
use super::job::{PointRows, Results};
use super::part::Part;
use crate::study::sweep::{Store, StoreError, Sweep, Table};

/// The finished points of a part, from where they were kept.
///
/// # Errors
/// When one cannot be read.
pub fn rows(part: Part, sweep: &Sweep, store: &Store) -> Result<Vec<PointRows>, StoreError> {
    let of_point = |point: u64| {
        let rows_csv = store.point(point as usize)?;
        Ok(PointRows { point, rows_csv })
    };
    part.every(sweep.len() as u64).map(of_point).collect()
}

/// The table that all shards together are.
///
/// # Errors
/// When a shard's points are not those of its part.
pub fn table(sweep: &Sweep, shards: Vec<(Part, Results)>) -> Result<Table, ShardError> {
    let mut points = BTreeMap::new();
    for (part, results) in shards {
        let Results::Sweep(rows) = results else {
            let reason = "it has no points";
            return Err(ShardError::Unfit { part, reason });
        };
        let numbers = rows.iter().map(|rows| rows.point);
        if !numbers.eq(part.every(sweep.len() as u64)) {
            let reason = "it has other points";
            return Err(ShardError::Unfit { part, reason });
        }
        points.extend(rows.into_iter().map(|rows| (rows.point, (part, rows.rows_csv))));
    }
    let mut table = Table::new(&sweep.axes);
    for (part, rows_csv) in points.into_values() {
        let reason = "its rows have other columns";
        let read = table.read(&rows_csv);
        read.map_err(|_| ShardError::Unfit { part, reason })?;
    }
    Ok(table)
}
