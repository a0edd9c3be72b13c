//! Reading `counts.csv` and `bins.csv`: every mistake with its line and what would be right.

use std::collections::BTreeMap;
use std::path::Path;

use csv::StringRecord;

use super::{RecordedHistogram, RecordedScan};
use crate::estimate::{CountingTier, calibration_offset_ps, distance_m, possible_count};
use crate::files::read_text;
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::printable::{printable, printable_path};
use crate::scan::Step;
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;

/// Largest file that is read: 2^30 phase steps have some 30 bytes each, but no scan
/// that anyone records has more than some millions.
const MOST_BYTES: u64 = 1 << 30;
/// Distances are written to the micrometre; by people perhaps to the millimetre.
const DISTANCE_TOLERANCE_M: f64 = 1e-3;

/// What a file has a row of for each detector.
struct Layout {
    /// Columns that it may have, and those that it must, beside `detector` where there are several.
    columns: &'static [&'static str],
    needed: [&'static str; 2],
    /// What a row is of, and the rows of a detector together.
    row: &'static str,
    whole: &'static str,
    /// Words before the number of all rows, and before that of no column.
    all: &'static str,
    of: &'static str,
    /// What to do where rows are missing, or all of them.
    if_missing: &'static str,
    if_empty: &'static str,
}

const STEPS: Layout = Layout {
    columns: &["measurement", "phase_step", "distance_m", "count", "detector", "total_count"],
    needed: ["phase_step", "count"],
    row: "phase step",
    whole: "scan",
    all: "the scan's",
    of: "",
    if_missing: "write every step, narrow `scan.steps` to those taken, or name the scene that the \
                 counts are of",
    if_empty: "the file has no counts; write a line for each phase step",
};

const BINS: Layout = Layout {
    columns: &["bin", "count", "detector"],
    needed: ["bin", "count"],
    row: "bin",
    whole: "histogram",
    all: "the",
    of: " of bins",
    if_missing: "write every bin, with 0 where nothing was counted",
    if_empty: "the file has no bins; write a line for each bin",
};

/// Why a file of counts cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CountsError {
    /// The file cannot be read.
    #[error("{file}: cannot read the counts: {source}")]
    Unreadable {
        /// File as it was named by the caller.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// Something in it is wrong.
    #[error("{file}:{line}: {problem}")]
    Invalid {
        /// File as it was named by the caller.
        file: String,
        /// Line, 1-based.
        line: u64,
        /// What is wrong, and what would be right.
        problem: String,
    },
}

impl CountsError {
    pub(super) fn of(path: &Path, (line, problem): Wrong) -> CountsError {
        CountsError::Invalid {
            file: printable_path(path),
            line,
            problem: printable(&problem).into_owned(),
        }
    }
}

/// The text of a file.
pub(super) fn text_of(path: &Path) -> Result<String, CountsError> {
    read_text(path, MOST_BYTES)
        .map_err(|source| CountsError::Unreadable { file: printable_path(path), source })
}

/// A line's number, and what is wrong with it.
pub(super) type Wrong = (u64, String);

/// Whether a text is of bins, by its heading.
pub(super) fn has_bins(text: &str) -> bool {
    let heading = text.lines().next().unwrap_or_default();
    let heading = heading.trim_start_matches('\u{feff}');
    let mut names = heading.split(',');
    names.any(|name| name.trim().trim_matches('"') == BINS.needed[0])
}

/// The scans of a text: one of every detector that it names.
pub(super) fn scans(text: &str, sensor: &Sensor) -> Result<Vec<RecordedScan>, Wrong> {
    let scene = sensor.scene();
    let scan = &scene.scan;
    let of_row = |row: &CountsRow| step_count(row, sensor);
    let shown = |step: u64| scan.phase_step(Step(step));
    let file = read_rows(text, scene, &STEPS, (scan.steps, &shown), of_row)?;
    let has_totals = file.has_column("total_count");
    let scans = file.rows.into_iter();
    Ok(scans.map(|(detector, counts)| RecordedScan { detector, counts, has_totals }).collect())
}

/// The histograms of a text: one of every detector that it names.
pub(super) fn histograms(text: &str, sensor: &Sensor) -> Result<Vec<RecordedHistogram>, Wrong> {
    let Some(plan) = sensor.interface().histogram() else {
        let says = "bins are of a sensor that keeps a histogram, and this scene's correlates phase \
                    step by phase step; write hardware.architecture = \"histogram\", or the counts \
                    of its phase steps with the heading phase_step,count";
        return Err((1, says.to_owned()));
    };
    let of_row = |row: &CountsRow| bin_count(row, plan.bins(), plan.periods);
    let file = read_rows(text, sensor.scene(), &BINS, (plan.bins(), &|bin| bin), of_row)?;
    let histograms = file.rows.into_iter().map(|(detector, bins)| {
        let histogram = Histogram::new(bins, plan.row_bins, plan.periods);
        let histogram = histogram.map_err(|problem| (file.last_line, problem.to_string()))?;
        Ok(RecordedHistogram { detector, histogram })
    });
    histograms.collect()
}

/// A file that was read.
struct Whole<T> {
    heading: Heading,
    last_line: u64,
    /// What each detector's rows say, in their order.
    rows: Vec<(DetectorIndex, Vec<T>)>,
}

impl<T> Whole<T> {
    fn has_column(&self, name: &str) -> bool {
        self.heading.place(name).is_some()
    }
}

/// Reads a file that has for every detector that it names so many rows, each once; `shown` is a
/// row's number in the file, and `of_row` its place among them and what it says.
fn read_rows<T>(
    text: &str,
    scene: &Scene,
    layout: &'static Layout,
    (all, shown): (u64, &dyn Fn(u64) -> u64),
    of_row: impl Fn(&CountsRow) -> Result<(u64, T), String>,
) -> Result<Whole<T>, Wrong> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let Layout { row, whole, .. } = *layout;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let heading = reader.headers().map_err(|error| unreadable(&error))?;
    let heading = Heading::of(heading, layout, scene).map_err(|problem| (1, problem))?;
    // Of each detector: line of each row, and what it says.
    let mut found: Vec<BTreeMap<u64, (u64, T)>> = Vec::new();
    found.resize_with(scene.detectors.len(), BTreeMap::new);
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| unreadable(&error))? {
        let line = record.position().map_or(0, csv::Position::line);
        let read = || {
            let name = heading.place("detector").and_then(|place| record.get(place));
            let detector = detector_of(name, scene)?;
            let (place, says) =
                of_row(&CountsRow { record: &record, heading: &heading, detector })?;
            Ok((detector, place, says))
        };
        let (detector, place, says) = read().map_err(|problem| (line, problem))?;
        if let Some((first, _)) = found[detector.0].insert(place, (line, says)) {
            let problem = format!(
                "{row} {} of detector \"{}\" stands on line {first} already; a file has one \
                 {whole}, each {row} once",
                shown(place),
                scene.detectors[detector].name
            );
            return Err((line, problem));
        }
    }
    let last_line = text.lines().count().max(1) as u64;
    let mut rows = Vec::new();
    for (detector, found) in DetectorIndex::all().zip(found).filter(|(_, rows)| !rows.is_empty()) {
        let missing = all - found.len() as u64;
        if let Some(first) = (0..all).find(|place| !found.contains_key(place)) {
            let problem = format!(
                "the file ends with {missing} of {} {all} {row}s of detector \"{}\" missing, the \
                 first is {}; {}",
                layout.all,
                scene.detectors[detector].name,
                shown(first),
                layout.if_missing
            );
            return Err((last_line, problem));
        }
        rows.push((detector, found.into_values().map(|(_, says)| says).collect()));
    }
    match rows.is_empty() {
        true => Err((last_line, layout.if_empty.to_owned())),
        false => Ok(Whole { heading, last_line, rows }),
    }
}

/// What the reader says of a record that is none.
fn unreadable(error: &csv::Error) -> Wrong {
    let line = error.position().map_or(1, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => (
            line,
            format!("{len} fields here, the heading has {expected_len}; write one for each column"),
        ),
        _ => (line, format!("no row of CSV: {error}")),
    }
}

/// Where each column of a layout is.
struct Heading {
    layout: &'static Layout,
    places: Vec<Option<usize>>,
}

impl Heading {
    fn of(
        heading: &StringRecord,
        layout: &'static Layout,
        scene: &Scene,
    ) -> Result<Heading, String> {
        let Layout { columns, needed, of, .. } = *layout;
        let mut places = vec![None; columns.len()];
        for (place, name) in heading.iter().enumerate() {
            let Some(column) = columns.iter().position(|known| *known == name) else {
                return Err(format!(
                    "no column{of} is called \"{name}\"; the heading may name {}, and must name {}",
                    columns.join(", "),
                    needed.join(" and ")
                ));
            };
            if places[column].replace(place).is_some() {
                return Err(format!("two columns are called \"{name}\"; leave one out"));
            }
        }
        let found = Heading { layout, places };
        let several = scene.detectors.len() > 1;
        let needed: Vec<&str> = needed.into_iter().chain(several.then_some("detector")).collect();
        match needed.iter().find(|name| found.place(name).is_none()) {
            None => Ok(found),
            Some(name) => Err(format!(
                "the heading \"{}\" has no column {name}; write for example {}",
                heading.iter().collect::<Vec<_>>().join(","),
                needed.join(",")
            )),
        }
    }

    fn place(&self, name: &str) -> Option<usize> {
        let column = self.layout.columns.iter().position(|known| *known == name)?;
        self.places[column]
    }
}

/// A row of a file, and the detector that it is of.
struct CountsRow<'r> {
    record: &'r StringRecord,
    heading: &'r Heading,
    detector: DetectorIndex,
}

impl CountsRow<'_> {
    fn field(&self, name: &str) -> Option<&str> {
        self.record.get(self.heading.place(name)?)
    }

    fn whole(&self, name: &str) -> Result<i128, String> {
        whole(name, self.field(name))
    }
}

/// Which step a row is of, and what it counts.
fn step_count(row: &CountsRow, sensor: &Sensor) -> Result<(u64, StepCount), String> {
    let scene = sensor.scene();
    let phase_step = row.whole("phase_step")?;
    let step = step_of(phase_step, scene)?;
    if row.field("measurement").is_some() {
        let measurement = row.whole("measurement")?;
        if measurement != step.0 as i128 {
            return Err(format!(
                "phase step {phase_step} is measurement {} of this scene's scan, not \
                 {measurement}: these counts are of another scene",
                step.0
            ));
        }
    }
    if let Some(field) = row.field("distance_m") {
        check_distance(field, sensor, row.detector, step)?;
    }
    let signed = row.whole("count")?;
    let total = row.field("total_count").map(|field| whole("total_count", Some(field)));
    Ok((step.0, possible_count(scene, signed, total.transpose()?)?))
}

/// Which bin a row is of, and what it counts.
fn bin_count(row: &CountsRow, bins: u64, periods: u64) -> Result<(u64, u64), String> {
    let number = row.whole("bin")?;
    let bin = u64::try_from(number).ok().filter(|&bin| bin < bins).ok_or_else(|| {
        format!(
            "the scene's histogram has no bin {number}: it has {bins}, from 0 on, one for each \
             sample of the code period; these bins are of another scene"
        )
    })?;
    let number = row.whole("count")?;
    let count = u64::try_from(number).ok().filter(|&count| count <= periods);
    let count = count.ok_or_else(|| {
        format!(
            "bin {bin} counts {number}; each of the {periods} code periods of scan.integration \
             has it once, so that it is 0 to {periods}"
        )
    })?;
    Ok((bin, count))
}

fn detector_of(name: Option<&str>, scene: &Scene) -> Result<DetectorIndex, String> {
    let Some(name) = name else {
        return Ok(DetectorIndex(0));
    };
    let names = || scene.detectors.iter().map(|detector| detector.name.trim());
    names().position(|known| known == name).map(DetectorIndex).ok_or_else(|| {
        format!(
            "the scene has no detector \"{name}\"; it has \"{}\"",
            names().collect::<Vec<_>>().join("\", \"")
        )
    })
}

/// A whole number, of any size that has a meaning somewhere.
fn whole(name: &str, field: Option<&str>) -> Result<i128, String> {
    let field = field.unwrap_or_default();
    field.parse().map_err(|_| {
        let shown: String = field.chars().take(40).collect();
        format!("{name} is \"{shown}\"; write a whole number, for example 12")
    })
}

fn step_of(phase_step: i128, scene: &Scene) -> Result<Step, String> {
    let scan = &scene.scan;
    let period = scan.steps_per_period;
    let known = u64::try_from(phase_step).ok().filter(|&k| k < period);
    let step = known.map(|k| (k + period - scan.first_step) % period);
    step.filter(|&step| step < scan.steps).map(Step).ok_or_else(|| {
        format!(
            "the scene's scan has no phase step {phase_step}: it has {} from {} on, of {period} \
                 in a code period; these counts are of another scene, or `scan.steps` is not as \
                 they were taken",
            scan.steps, scan.first_step
        )
    })
}

fn check_distance(
    field: &str,
    sensor: &Sensor,
    detector: DetectorIndex,
    step: Step,
) -> Result<(), String> {
    let given: f64 = field
        .parse()
        .map_err(|_| format!("distance_m is \"{field}\"; write metres, for example 3.2"))?;
    let offset_ps = calibration_offset_ps(sensor, detector, CountingTier::Sampled);
    let expected = distance_m(sensor.timing().reference_delay_ps(step) - offset_ps);
    // Neither is one that is no number.
    if (given - expected).abs() <= DISTANCE_TOLERANCE_M {
        return Ok(());
    }
    Err(format!(
        "distance_m is {field}, in this scene the phase step stands for {expected:.6}: these \
         counts are of another scene, or its clock or detector.delay changed; leave the column \
         out if they are of this one"
    ))
}

#[cfg(test)]
mod tests;
