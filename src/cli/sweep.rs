//! `goldtof sweep`: a scene simulated over ranges of its keys.

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;

use rayon::prelude::*;

use super::common::{is_far, warn_of_far_paths};
use super::prelude::*;
use crate::report::parquet::{self, ParquetFailed};
use crate::report::table::Table;
use crate::shard::{self, SweepJob};
use crate::study::sweep::{
    self, Plot, Store, StoreError, Sweep, SweepError, SweepOptions, contradicted, empty,
};
use crate::version::VERSION;

/// Points that are looked at side by side.
const CHECKED_AT_ONCE: usize = 1024;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof sweep scenes/quick.toml \
    --over 'source[0].mean_power=1 pW..64 pW x7' --over 'path.distance=1 m, 2 m' --out out/sweep\n\n\
    An interrupted sweep resumes when started again.")]
pub(super) struct SweepArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: SweepOptions,
    /// Folder for sweep.csv, sweep.parquet, sweep.svg and the finished points; created if
    /// missing, for example --out out/sweep
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub check: CheckArgument,
    /// Simulate one of N shards of the points, for `goldtof merge` to join: --shard 3/20, or
    /// --shard task/20 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<JobPart>,
}

/// The JSON of `goldtof sweep`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct SweepReport<'a> {
    /// Points of the sweep: combinations of values.
    points: usize,
    /// Points that were done when this run began.
    points_done_before: usize,
    /// Seed of every point.
    seed: u64,
    /// The rows of sweep.csv: a field for each column, one row for each point, detector
    /// and path.
    #[schemars(with = "Vec<serde_json::Map<String, serde_json::Value>>")]
    rows: Rows<'a>,
}

impl Command for SweepArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let sweep = Sweep {
            scene: self.scene.read()?,
            options: SweepOptions { seed, ..self.options.clone() },
        };
        sweep.check_axes()?;
        if let Some(part) = self.shard {
            // Of ten thousand points every shard has only its own to look at.
            let own = part.every(sweep.len() as u64);
            check(&sweep, own.map(|number| number as usize), output)?;
            let of_all = Sweep { scene: sweep.scene.without_folder(), ..sweep };
            let job = Job::Sweep(SweepJob { sweep: of_all, check: self.check.check });
            return ShardOrder { part, out: &self.out }.fulfil(job, output);
        }
        check(&sweep, 0..sweep.len(), output)?;
        let folder = output.folder(&self.out)?;
        let mut store = Store::open(&folder, &sweep, &typed_command())?;
        let done_before = store.done();
        if done_before > 0 {
            let all = sweep.len();
            output.note(&format!("{done_before} of {all} points are done already"));
        }
        let bar = output.points(sweep.len());
        sweep::run(&sweep, &mut store, 0..sweep.len(), |done| bar.set_position(done as u64))?;
        bar.finish_and_clear();
        let rows = Rows { sweep: &sweep, of: &|numbers| store.table(&sweep, numbers) };
        tell(&sweep, rows, done_before, self.check.check, &folder, output)
    }
}

/// Whether some points are scenes, before the first is simulated, and what is to be said of
/// them.
fn check(
    sweep: &Sweep,
    mut numbers: impl Iterator<Item = usize>,
    output: &CommandOutput,
) -> anyhow::Result<()> {
    let mut is_warned = false;
    loop {
        let some: Vec<usize> = numbers.by_ref().take(CHECKED_AT_ONCE).collect();
        if some.is_empty() {
            return Ok(());
        }
        let sensors: Vec<_> = some
            .into_par_iter()
            .map(|number| {
                let sensor = sweep.point(number)?.sensor;
                Ok::<_, SweepError>(is_far(&sensor).then_some(sensor))
            })
            .collect();
        for sensor in sensors {
            // One warning is enough: that of the first point that is too far.
            if let (Some(sensor), false) = (sensor?, is_warned) {
                is_warned = warn_of_far_paths(&sensor, output);
            }
        }
    }
}

impl InShards for SweepJob {
    /// Points are kept in the shard's folder until all are done, so that a part that was cut off
    /// goes on.
    fn part(
        &self,
        part: JobPart,
        folder: &OutputFolder,
        output: &CommandOutput,
    ) -> anyhow::Result<Results> {
        let sweep = &self.sweep;
        let mut store = Store::open(folder, sweep, &typed_command())?;
        let numbers = || part.every(sweep.len() as u64).map(|number| number as usize);
        let bar = output.points(numbers().count());
        sweep::run(sweep, &mut store, numbers(), |done| bar.set_position(done as u64))?;
        bar.finish_and_clear();
        Ok(Results::Sweep(shard::rows(part, sweep, &store)?))
    }

    fn merge(
        &self,
        parts: PartResults,
        out: &Path,
        output: &CommandOutput,
    ) -> anyhow::Result<Ending> {
        let sweep = &self.sweep;
        sweep.check_axes()?;
        let tables = shard::tables(sweep, parts)?;
        let rows = Rows { sweep, of: &|numbers| Ok(Table::joined(&tables[numbers])) };
        tell(sweep, rows, sweep.len(), self.check, &output.folder(out)?, output)
    }
}

/// Writes both tables and the plot, all three or none.
fn tell(
    sweep: &Sweep,
    rows: Rows,
    done_before: usize,
    check: bool,
    folder: &OutputFolder,
    output: &CommandOutput,
) -> anyhow::Result<Ending> {
    let written = rows.write(folder)?;
    for remark in &written.remarks {
        output.note(remark);
    }
    let name = sweep.point(0)?.sensor.scene().name.clone();
    let (points, [csv, parquet, plot]) = (sweep.len(), written.names);
    let text = format!(
        "{name}: {points} points, {} rows in {}, {parquet} and {plot} beside it\n",
        written.rows,
        printable_path(&folder.join(csv))
    );
    let seed = sweep.options.seed;
    let report = SweepReport { points, points_done_before: done_before, seed, rows };
    output.answer(Some(sweep.scene.reference()), &report, &text)?;
    if written.contradicted > 0 {
        output.note(&format!(
            "warning: in {} of {} rows the scans contradict what is expected of them \
             (expectation_holds)",
            written.contradicted, written.rows
        ));
    }
    Ok(Ending::of_check(check, written.contradicted == 0))
}

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
