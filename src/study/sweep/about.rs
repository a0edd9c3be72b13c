//! What the Parquet file of a sweep says of itself.

use std::collections::BTreeMap;

use serde::Serialize;

use super::points::Sweep;
use super::store::Definition;
use crate::report::parquet::ParquetFailed;
use crate::report::table::Table;
use crate::scene::SceneReference;
use crate::version::VERSION;

/// What is kept under `goldtof` for every reader, and where pandas keeps what it gives as
/// `DataFrame.attrs`.
const KEYS: [&str; 2] = ["goldtof", "PANDAS_ATTRS"];

/// What the file says of itself, as JSON.
#[derive(Serialize)]
struct About<'a> {
    goldtof: &'a str,
    scene: SceneReference,
    sweep: Definition,
    units: BTreeMap<&'a str, &'a str>,
}

/// The whole table as a Parquet file, the same bytes for the same sweep. Its metadata
/// have, as JSON under `goldtof` and as the attributes of a frame of pandas, what the
/// numbers are of and the unit of each column that has one.
///
/// # Errors
/// When a part grows beyond what the format can number.
pub fn parquet(table: &Table, sweep: &Sweep) -> Result<Vec<u8>, ParquetFailed> {
    let units = table.columns.iter().filter_map(|column| {
        let unit = column.unit.as_deref()?;
        Some((column.name.as_str(), unit))
    });
    let about = About {
        goldtof: VERSION,
        scene: sweep.scene(),
        sweep: Definition::new(sweep),
        units: units.collect(),
    };
    // It is texts and numbers, which are always JSON.
    table.parquet("sweep", &KEYS, &serde_json::to_string(&about).unwrap_or_default())
}
