//! The tables and the plot of a sweep, whose rows are never held all at once.

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;

use serde::Serialize;

use crate::files::OutputFolder;
use crate::report::parquet::{self, ParquetFailed};
use crate::report::table::Table;
use crate::scene::SceneReference;
use crate::study::sweep::{Plot, StoreError, Sweep, SweepOptions, contradicted, empty};
use crate::version::VERSION;

/// Points whose rows are held at once, and stand together in the Parquet file.
const AT_ONCE: usize = 8192;

const CSV: &str = "sweep.csv";
const PARQUET: &str = "sweep.parquet";
const PLOT: &str = "sweep.svg";

/// The rows of a sweep's points: those of some at a time.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub sweep: &'a Sweep,
    /// Those of points that follow one another.
    pub of: &'a dyn Fn(Range<usize>) -> Result<Table, StoreError>,
}

/// What the Parquet file says of itself, as JSON.
#[derive(Serialize)]
struct About<'a> {
    goldtof: &'a str,
    scene: SceneReference,
    sweep: &'a SweepOptions,
    units: BTreeMap<&'a str, &'a str>,
}

fn about(sweep: &Sweep, columns: &Table) -> String {
    let about = About {
        goldtof: VERSION,
        scene: sweep.scene.reference(),
        sweep: &sweep.options,
        units: columns.units(),
    };
    // It is texts and numbers, which are always JSON.
    serde_json::to_string(&about).unwrap_or_default()
}

/// What was written.
pub(super) struct Written {
    /// Names of the CSV file, the Parquet file and the plot.
    pub names: [&'static str; 3],
    /// Rows of the tables.
    pub rows: usize,
    /// Those whose scans contradict what is expected of them.
    pub contradicted: usize,
    /// What the plot does not show.
    pub remarks: Vec<String>,
}

impl Rows<'_> {
    /// All of them, some at a time.
    fn tables(self) -> impl Iterator<Item = anyhow::Result<Table>> {
        let all = self.sweep.len();
        let firsts = (0..all).step_by(AT_ONCE);
        firsts.map(move |first| Ok((self.of)(first..all.min(first + AT_ONCE))?))
    }

    /// Writes both tables and the plot, all three or none.
    ///
    /// # Errors
    /// When a file cannot be written, or rows cannot be had.
    pub fn write(self, folder: &OutputFolder) -> anyhow::Result<Written> {
        let mut plot = Plot::of(self.sweep);
        let (mut rows, mut untrue) = (0, 0);
        let csv = folder.stage(CSV, |out| {
            out.write_all(empty(&self.sweep.options.over).heading().as_bytes())?;
            for table in self.tables() {
                let table = table.map_err(io::Error::other)?;
                out.write_all(table.rows_csv().as_bytes())?;
                plot.add(&table);
                rows += table.rows.len();
                untrue += contradicted(&table);
            }
            Ok(())
        })?;
        let binary = folder.stage(PARQUET, |out| {
            let columns = empty(&self.sweep.options.over);
            let about = about(self.sweep, &columns);
            let written = parquet::write(out, "sweep", &about, &columns, self.tables());
            written.map_err(|error| match error.is::<ParquetFailed>() {
                true => io::Error::other(format!("{error}; {CSV} has all of it")),
                false => io::Error::other(error),
            })
        })?;
        let name = &self.sweep.point(0)?.sensor.scene().name.clone();
        let svg = folder.stage(PLOT, |out| out.write_all(plot.svg(name).as_bytes()))?;
        folder.publish(vec![csv, binary, svg])?;
        let (names, remarks) = ([CSV, PARQUET, PLOT], plot.remarks(PLOT, CSV));
        Ok(Written { names, rows, contradicted: untrue, remarks })
    }
}

/// As JSON: every row as an object.
impl Serialize for Rows<'_> {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        use serde::ser::{Error as _, SerializeSeq as _};
        let mut rows = to.serialize_seq(None)?;
        for table in self.tables() {
            for row in table.map_err(S::Error::custom)?.json() {
                rows.serialize_element(&row)?;
            }
        }
        rows.end()
    }
}
