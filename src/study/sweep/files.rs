//! The tables and the plot of a sweep.

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;

use serde::Serialize;

use super::RunError;
use super::options::SweepOptions;
use super::plot::Plot;
use super::points::Sweep;
use super::table::{contradicted, empty};
use crate::files::OutputFolder;
use crate::report::parquet::ParquetFile;
use crate::report::table::Table;
use crate::scene::SceneReference;
use crate::version::VERSION;

/// Points whose rows are held at once, and stand together in the Parquet file.
const AT_ONCE: usize = 8192;

const CSV: &str = "sweep.csv";
const PARQUET: &str = "sweep.parquet";
const PLOT: &str = "sweep.svg";

/// What the Parquet file has for every reader, and where pandas keeps what it gives as
/// `DataFrame.attrs`.
const KEYS: [&str; 2] = ["goldtof", "PANDAS_ATTRS"];

/// What the Parquet file says of itself, as JSON.
#[derive(Serialize)]
struct About<'a> {
    goldtof: &'a str,
    scene: SceneReference,
    sweep: &'a SweepOptions,
    units: BTreeMap<&'a str, &'a str>,
}

/// The rows of a sweep's points: those of some at a time.
#[derive(Clone, Copy)]
pub struct Rows<'a> {
    sweep: &'a Sweep,
    of: &'a dyn Fn(Range<usize>) -> Result<Table, RunError>,
}

/// What was written.
pub struct Written {
    /// Names of the CSV file, the Parquet file and the plot.
    pub names: [&'static str; 3],
    /// Rows of the tables.
    pub rows: usize,
    /// Those whose scans contradict what is expected of them.
    pub contradicted: usize,
    /// What the plot does not show.
    pub remarks: Vec<String>,
}

impl<'a> Rows<'a> {
    /// The rows of `sweep`, as `of` has those of points that follow one another.
    pub fn new(
        sweep: &'a Sweep,
        of: &'a dyn Fn(Range<usize>) -> Result<Table, RunError>,
    ) -> Rows<'a> {
        Rows { sweep, of }
    }

    /// All of them, some at a time.
    pub fn tables(self) -> impl Iterator<Item = Result<Table, RunError>> {
        let all = self.sweep.len();
        (0..all).step_by(AT_ONCE).map(move |first| (self.of)(first..all.min(first + AT_ONCE)))
    }

    /// Writes both tables and the plot, all three or none. The memory that it takes does not
    /// depend on the number of points.
    ///
    /// # Errors
    /// When a file cannot be written, or rows cannot be had.
    pub fn write(self, folder: &OutputFolder) -> Result<Written, RunError> {
        let scene = self.sweep.point(0)?.sensor.scene().name.clone();
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
        let parquet = folder.stage(PARQUET, |out| self.parquet(out).map_err(io::Error::other))?;
        let svg = folder.stage(PLOT, |out| out.write_all(plot.svg(&scene).as_bytes()))?;
        folder.publish(vec![csv, parquet, svg])?;
        let remarks = plot.remarks(PLOT, CSV);
        Ok(Written { names: [CSV, PARQUET, PLOT], rows, contradicted: untrue, remarks })
    }

    /// The Parquet file: the same bytes for the same sweep. Its metadata have, as JSON under
    /// `goldtof` and as the attributes of a frame of pandas, what the numbers are of and the
    /// unit of each column that has one.
    fn parquet(self, out: &mut (dyn io::Write + Send)) -> Result<(), RunError> {
        let table = empty(&self.sweep.options.over);
        let units = table
            .columns
            .iter()
            .filter_map(|column| Some((&*column.name, column.unit.as_deref()?)));
        let about = About {
            goldtof: VERSION,
            scene: self.sweep.scene(),
            sweep: &self.sweep.options,
            units: units.collect(),
        };
        // It is texts and numbers, which are always JSON.
        let about = serde_json::to_string(&about).unwrap_or_default();
        let mut file = ParquetFile::new(out, &table, "sweep", &KEYS, &about)?;
        for table in self.tables() {
            file.add(&table?)?;
        }
        Ok(file.close()?)
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
