//! `goldtof sweep`: a scene simulated over ranges of its keys.

use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;

use super::arguments::{CheckArgument, Order, SceneArgument};
use super::ending::Ending;
use super::output::Output;
use super::parquet::parquet;
use super::provenance::typed_command;
use super::values::parse_shard;
use super::warnings::warn_of_far_paths;
use crate::document::{Body, Document};
use crate::files::OutputFolder;
use crate::printable::printable_path;
use crate::report::table::Table;
use crate::scene;
use crate::shard::{self, Job, Part, Results, SceneText, SweepJob};
use crate::study::sweep::{self, Store, Sweep, SweepOptions};

const CSV: &str = "sweep.csv";
const PARQUET: &str = "sweep.parquet";
const PLOT: &str = "sweep.svg";

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof sweep scenes/quick.toml \
    --over 'source[0].mean_power=1 pW..64 pW x7' --over 'path.distance=1 m, 2 m' --out out/sweep\n\n\
    A sweep that was interrupted resumes when it is started again.")]
pub(super) struct SweepArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: SweepOptions,
    /// Folder for sweep.csv, sweep.parquet, sweep.svg and the finished points; made when
    /// missing, for example --out out/sweep
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    #[command(flatten)]
    pub check: CheckArgument,
    /// Simulate one of N shards of the points, for `goldtof merge` to join: --shard 3/20, or
    /// --shard task/20 in an array job (Slurm, HyperQueue)
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub shard: Option<Part>,
}

/// The JSON of `goldtof sweep`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct SweepReport {
    /// Points of the sweep: combinations of values.
    points: usize,
    /// Points that were done when this run began.
    points_done_before: usize,
    /// Seed of every point.
    seed: u64,
    /// The rows of sweep.csv: a field for each column, one row for each point, detector
    /// and path.
    rows: Vec<serde_json::Map<String, serde_json::Value>>,
}

impl Body for SweepReport {
    const NAME: &'static str = "sweep";
}

pub(super) fn run(
    arguments: &SweepArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let sweep = Sweep {
        file: printable_path(&arguments.scene.scene),
        text: scene::read_scene_text(&arguments.scene.scene)?,
        settings: arguments.scene.settings.clone(),
        options: SweepOptions { seed, ..arguments.options.clone() },
    };
    sweep.check_axes()?;
    if let Some(part) = arguments.shard {
        // Of ten thousand points every shard has only its own to look at.
        let own = part.every(sweep.len() as u64);
        check(&sweep, own.map(|number| number as usize), output)?;
        let out = &arguments.out;
        return some_points(&sweep, &Order { part, out }, arguments.check.check, output);
    }
    check(&sweep, 0..sweep.len(), output)?;
    let folder = output.folder(&arguments.out)?;
    let store = open_store(&sweep, &folder, output)?;
    let done_before = store.done()?.len();
    if done_before > 0 {
        let all = sweep.len();
        output.note(&format!("{done_before} of {all} points are done already"));
    }
    let bar = output.points(sweep.len());
    let table = sweep::run(&sweep, &store, |done| bar.set_position(done as u64))?;
    bar.finish_and_clear();
    tell(&sweep, &table, done_before, &folder, output)?;
    Ok(Ending::of_check(arguments.check.check, sweep::contradicted(&table) == 0))
}

/// Whether some points are scenes, before the first is simulated, and what is to be said of
/// them.
fn check(
    sweep: &Sweep,
    numbers: impl Iterator<Item = usize>,
    output: &Output,
) -> anyhow::Result<()> {
    let mut is_warned = false;
    for number in numbers {
        let sensor = sweep.point(number)?.sensor;
        // One warning is enough: that of the first point that is too far.
        is_warned = is_warned || warn_of_far_paths(&sensor, output);
    }
    Ok(())
}

fn open_store(sweep: &Sweep, folder: &OutputFolder, output: &Output) -> anyhow::Result<Store> {
    let definition = sweep.definition(&typed_command());
    Ok(Store::open(folder, &definition, |path| output.waits(path))?)
}

/// A part of the points. They are kept in a folder of the shard's own until all are done,
/// so that a part that was cut off goes on.
fn some_points(
    sweep: &Sweep,
    order: &Order,
    check: bool,
    output: &Output,
) -> anyhow::Result<Ending> {
    let job = Job::Sweep(SweepJob {
        scene: SceneText::new(&sweep.file, sweep.text.clone(), &sweep.settings),
        options: sweep.options.clone(),
        check,
    });
    let part = order.part;
    order.fulfil(job, output, |folder| {
        let store = open_store(sweep, folder, output)?;
        let numbers = || part.every(sweep.len() as u64).map(|number| number as usize);
        let bar = output.points(numbers().count());
        sweep::run_points(sweep, &store, numbers(), |done| {
            bar.set_position(done as u64);
        })?;
        bar.finish_and_clear();
        Ok(Results::Sweep(shard::rows(part, sweep, &store)?))
    })
}

/// The tables and the plot of all shards.
pub(super) fn merge(
    job: &SweepJob,
    shards: Vec<(Part, Results)>,
    out: &Path,
    output: &Output,
) -> anyhow::Result<Ending> {
    let sweep = job.sweep()?;
    sweep.check_axes()?;
    let table = shard::table(&sweep, shards)?;
    tell(&sweep, &table, sweep.len(), &output.folder(out)?, output)?;
    Ok(Ending::of_check(job.check, sweep::contradicted(&table) == 0))
}

/// Writes both tables and the plot, all three or none.
fn tell(
    sweep: &Sweep,
    table: &Table,
    done_before: usize,
    folder: &OutputFolder,
    output: &Output,
) -> anyhow::Result<()> {
    let name = sweep.point(0)?.sensor.scene().name.clone();
    let (plot, left_out) = sweep::plot(table, &name, &sweep.options.over);
    if left_out > 0 {
        output.note(&format!("{PLOT} has no room for {left_out} more series; {CSV} has all"));
    }
    let (csv, binary) = (table.csv(), parquet(table, sweep)?);
    folder.write_all([(CSV, csv.as_bytes()), (PARQUET, &binary), (PLOT, plot.as_bytes())])?;
    let text = format!(
        "{name}: {} points, {} rows in {}, {PARQUET} and {PLOT} beside it\n",
        sweep.len(),
        table.rows.len(),
        printable_path(&folder.join(CSV))
    );
    let report = SweepReport {
        points: sweep.len(),
        points_done_before: done_before,
        seed: sweep.options.seed,
        rows: table.json(),
    };
    let document =
        Document { scene: Some(sweep.scene()), ..Document::new(report, typed_command(), None) };
    output.answer_document(&document, &text)?;
    let untrue = sweep::contradicted(table);
    if untrue > 0 {
        let rows = table.rows.len();
        output.note(&format!(
            "warning: in {untrue} of {rows} rows the scans contradict what is expected of them \
             (expectation_holds)"
        ));
    }
    Ok(())
}
