//! `goldtof sweep`: a scene over and over, with some of its keys otherwise.

use serde::Serialize;

use super::Ending;
use super::arguments::SweepArguments;
use super::output::Output;
use super::provenance::typed_command;
use super::warnings::warn_of_far_paths;
use crate::document::{Body, Document};
use crate::printable::printable_path;
use crate::scene;
use crate::study::sweep::{self, Definition, Store, Sweep};

const CSV: &str = "sweep.csv";
const PLOT: &str = "sweep.svg";

/// The JSON of `goldtof sweep`.
#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
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
        axes: arguments.over.clone(),
        repeat: arguments.repeat,
        fidelity: arguments.fidelity,
        estimator: arguments.estimator,
        seed,
    };
    sweep.check()?;
    // One warning is enough: that of the first point that is too far.
    for number in 0..sweep.len() {
        if warn_of_far_paths(&sweep.point(number)?.sensor, output) {
            break;
        }
    }
    let folder = output.folder(&arguments.out)?;
    let points = folder.subfolder("points", |path| output.waits(path))?;
    let store = Store::open(&folder, points, &Definition::of(&sweep, &typed_command()))?;
    let done_before = store.done()?.len();
    if done_before > 0 {
        let all = sweep.len();
        output.note(&format!("{done_before} of {all} points are done already"));
    }
    let bar = output.points(sweep.len());
    let table = sweep::run(&sweep, &store, |done| bar.set_position(done as u64))?;
    bar.finish_and_clear();
    let name = sweep.point(0)?.sensor.scene().name.clone();
    let (plot, left_out) = table.plot(&name, &sweep.axes)?;
    if left_out > 0 {
        output.note(&format!(
            "{PLOT} has no room for {left_out} more series; {CSV} has all"
        ));
    }
    folder.write(CSV, &table.csv())?;
    folder.write(PLOT, &plot)?;
    let text = format!(
        "{name}: {} points, {} rows in {}\n",
        sweep.len(),
        table.rows.len(),
        printable_path(&folder.join(CSV))
    );
    let report = SweepReport {
        points: sweep.len(),
        points_done_before: done_before,
        seed,
        rows: table.json(),
    };
    let document = Document {
        scene: Some(sweep.scene()),
        ..Document::new(report, typed_command(), None)
    };
    output.answer_document(&document, &text)?;
    Ok(Ending::Done)
}
