//! Reading `counts.csv`: every mistake with its line and what would be right.

use std::collections::BTreeMap;
use std::path::Path;

use csv::StringRecord;

use super::RecordedScan;
use crate::estimate::{CountingTier, calibration_offset_ps, distance_m, possible_count};
use crate::files::read_text;
use crate::photons::StepCount;
use crate::printable::{printable, printable_path};
use crate::scan::Step;
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;

/// Largest file that is read: 2^30 phase steps have some 30 bytes each, but no scan
/// that anyone records has more than some millions.
const MOST_BYTES: u64 = 1 << 30;
/// Columns that a file may have, and those that it must.
const COLUMNS: [&str; 6] =
    ["measurement", "phase_step", "distance_m", "count", "detector", "total_count"];
const NEEDED: [&str; 2] = ["phase_step", "count"];
/// Distances are written to the micrometre; by people perhaps to the millimetre.
const DISTANCE_TOLERANCE_M: f64 = 1e-3;

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

/// The scans of a text: one of every detector that it names.
pub(super) fn parse(text: &str, sensor: &Sensor) -> Result<Vec<RecordedScan>, Wrong> {
    let scene = sensor.scene();
    let begin = |heading: &StringRecord| {
        let columns = Columns::of(heading, scene)?;
        let table = Table::new(scene, &columns);
        Ok((columns, table))
    };
    let ((_, table), last_line) = read_records(text, begin, |line, record, (columns, table)| {
        table.take(line, Row::of(record, columns, sensor)?)
    })?;
    table.finish().map_err(|problem| (last_line, problem))
}

/// Reads the heading, which begins a table, then every record with its line into it; gives
/// the table and the last line.
pub(super) fn read_records<T>(
    text: &str,
    begin: impl FnOnce(&StringRecord) -> Result<T, String>,
    take: impl Fn(u64, &StringRecord, &mut T) -> Result<(), String>,
) -> Result<(T, u64), Wrong> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let heading = reader.headers().map_err(|error| unreadable(&error))?;
    let mut table = begin(heading).map_err(|problem| (1, problem))?;
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| unreadable(&error))? {
        let line = record.position().map_or(0, csv::Position::line);
        take(line, &record, &mut table).map_err(|problem| (line, problem))?;
    }
    Ok((table, text.lines().count().max(1) as u64))
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

/// Where each column is.
struct Columns {
    places: [Option<usize>; COLUMNS.len()],
}

impl Columns {
    fn of(heading: &StringRecord, scene: &Scene) -> Result<Columns, String> {
        let mut places = [None; COLUMNS.len()];
        for (place, name) in heading.iter().enumerate() {
            let Some(column) = COLUMNS.iter().position(|known| *known == name) else {
                return Err(format!(
                    "no column is called \"{name}\"; the heading may name {}, and must name {}",
                    COLUMNS.join(", "),
                    NEEDED.join(" and ")
                ));
            };
            if places[column].replace(place).is_some() {
                return Err(format!("two columns are called \"{name}\"; leave one out"));
            }
        }
        let columns = Columns { places };
        let several = scene.detectors.len() > 1;
        let needed = NEEDED.iter().chain(several.then_some(&"detector"));
        for name in needed {
            if columns.place(name).is_none() {
                let found: Vec<&str> = heading.iter().collect();
                return Err(format!(
                    "the heading \"{}\" has no column {name}; write for example \
                     phase_step,count{}",
                    found.join(","),
                    if several { ",detector" } else { "" }
                ));
            }
        }
        Ok(columns)
    }

    fn place(&self, name: &str) -> Option<usize> {
        let column = COLUMNS.iter().position(|known| *known == name)?;
        self.places[column]
    }

    /// A record's field of that column.
    fn field<'r>(&self, record: &'r StringRecord, name: &str) -> Option<&'r str> {
        record.get(self.place(name)?)
    }
}

/// A row, checked for itself.
struct Row {
    detector: DetectorIndex,
    step: Step,
    count: StepCount,
}

impl Row {
    fn of(record: &StringRecord, columns: &Columns, sensor: &Sensor) -> Result<Row, String> {
        let scene = sensor.scene();
        let detector = detector_of(columns.field(record, "detector"), scene)?;
        let phase_step = whole("phase_step", columns.field(record, "phase_step"))?;
        let step = step_of(phase_step, scene)?;
        if let Some(field) = columns.field(record, "measurement") {
            let measurement = whole("measurement", Some(field))?;
            if measurement != step.0 as i128 {
                return Err(format!(
                    "phase step {phase_step} is measurement {} of this scene's scan, not \
                     {measurement}: these counts are of another scene",
                    step.0
                ));
            }
        }
        if let Some(field) = columns.field(record, "distance_m") {
            check_distance(field, sensor, detector, step)?;
        }
        let signed = whole("count", columns.field(record, "count"))?;
        let total = columns
            .field(record, "total_count")
            .map(|field| whole("total_count", Some(field)))
            .transpose()?;
        let count = possible_count(scene, signed, total)?;
        Ok(Row { detector, step, count })
    }
}

pub(super) fn detector_of(name: Option<&str>, scene: &Scene) -> Result<DetectorIndex, String> {
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
pub(super) fn whole(name: &str, field: Option<&str>) -> Result<i128, String> {
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

/// The rows of a file in the places of their steps.
struct Table<'s> {
    scene: &'s Scene,
    has_totals: bool,
    /// Of each detector: line and count of each step that was found.
    found: Vec<BTreeMap<Step, (u64, StepCount)>>,
}

impl<'s> Table<'s> {
    fn new(scene: &'s Scene, columns: &Columns) -> Table<'s> {
        Table {
            scene,
            has_totals: columns.place("total_count").is_some(),
            found: vec![BTreeMap::new(); scene.detectors.len()],
        }
    }

    fn take(&mut self, line: u64, row: Row) -> Result<(), String> {
        let before = self.found[row.detector].insert(row.step, (line, row.count));
        match before {
            None => Ok(()),
            Some((first, _)) => Err(format!(
                "phase step {} of detector \"{}\" stands on line {first} already; a file has one \
                 scan, each phase step once",
                self.scene.scan.phase_step(row.step),
                self.scene.detectors[row.detector].name
            )),
        }
    }

    fn finish(self) -> Result<Vec<RecordedScan>, String> {
        let mut scans = Vec::new();
        for (detector, found) in DetectorIndex::all().zip(self.found) {
            if found.is_empty() {
                continue;
            }
            let scan = &self.scene.scan;
            let missing = scan.steps - found.len() as u64;
            if missing > 0 {
                let first = Step::all(scan.steps).find(|step| !found.contains_key(step));
                return Err(format!(
                    "the file ends with {missing} of the scan's {} phase steps of detector \"{}\" \
                     missing, the first is {}; write every step, narrow `scan.steps` to those taken, \
                     or name the scene that the counts are of",
                    scan.steps,
                    self.scene.detectors[detector].name,
                    first.map_or(0, |step| scan.phase_step(step))
                ));
            }
            scans.push(RecordedScan {
                detector,
                counts: found.into_values().map(|(_, count)| count).collect(),
                has_totals: self.has_totals,
            });
        }
        if scans.is_empty() {
            return Err("the file has no counts; write a line for each phase step".to_owned());
        }
        Ok(scans)
    }
}

#[cfg(test)]
mod tests;
