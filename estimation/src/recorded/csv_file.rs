//! Reading `counts.csv` and `bins.csv`: every mistake with its line and what would be right.

mod dialect;

pub use dialect::Dialect;
use dialect::{Decoded, decoded, is_skipped};

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use csv::StringRecord;
use serde::Serialize;

use super::code_density::{DarkCounts, DarkParts};
use super::{RecordedCounts, RecordedHistogram, RecordedScan};
use crate::estimate::{CountingTier, calibration_offset_ps, distance_m, possible_count};
use crate::files::read_bytes;
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
    /// Columns that it may have, with what they are, and those that it must, beside `detector`
    /// where there are several.
    columns: &'static [(&'static str, &'static str)],
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
    columns: &[
        ("measurement", "number of the phase step in the scan, from 0; checked"),
        ("phase_step", "phase step, from 0 on in a code period"),
        ("distance_m", "distance that the phase step stands for, in metres; checked"),
        ("count", "signed count: hits up less hits down"),
        ("detector", "name of the detector"),
        ("total_count", "hits up and hits down together"),
        ("integration_chips", "chips for which a step's hits were counted; checked"),
    ],
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
    columns: &[
        ("bin", "samples from the start of the code period, from 0"),
        ("count", "hits in the bin"),
        ("detector", "name of the detector"),
    ],
    needed: ["bin", "count"],
    row: "bin",
    whole: "histogram",
    all: "the",
    of: " of bins",
    if_missing: "write every bin, with 0 where nothing was counted",
    if_empty: "the file has no bins; write a line for each bin",
};

const SAMPLES: Layout = Layout {
    columns: &[
        ("sample", "sample of the chip, from 0"),
        ("count", "hits at the sample"),
        ("detector", "name of the detector"),
        ("run", "number of the recording, from 0, where there are several"),
    ],
    needed: ["sample", "count"],
    row: "sample",
    whole: "count of each sample",
    all: "the",
    of: " of samples",
    if_missing: "write every sample of every run, with 0 where nothing was counted",
    if_empty: "the file has no counts; write a line for each sample of a chip",
};

/// Most recordings of a file.
const MOST_RUNS: i128 = 1 << 20;

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
    fn of(file: &str, (line, problem): Wrong) -> CountsError {
        CountsError::Invalid {
            file: file.to_owned(),
            line,
            problem: printable(&problem).into_owned(),
        }
    }
}

/// A line's number, and what is wrong with it.
pub(super) type Wrong = (u64, String);

/// A file of counts, and how it is read; only its form has been checked.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct CountsFile {
    /// File as it was named by the caller.
    pub file: String,
    /// How it is written.
    pub dialect: Dialect,
    /// Line of the heading, 1-based.
    pub heading_line: u64,
    /// The columns that the heading names.
    pub columns: Vec<CsvColumn>,
    /// Lines below the heading that are neither empty nor comments.
    pub rows: u64,
    /// Smallest phase step, or bin; null where there is none.
    pub first: Option<i64>,
    /// Largest phase step, or bin; null where there is none.
    pub last: Option<i64>,
    #[serde(skip)]
    text: String,
}

/// A column of a file of counts.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Column")]
pub struct CsvColumn {
    /// Its name in the heading.
    pub name: String,
    /// What it is read as; null for an unknown name.
    pub taken_for: Option<&'static str>,
}

impl CountsFile {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read, or is not text in columns.
    pub fn read(path: &Path) -> Result<CountsFile, CountsError> {
        let file = printable_path(path);
        match read_bytes(path, MOST_BYTES).and_then(decoded) {
            Ok(text) => CountsFile::of(&file, text).map_err(|wrong| CountsError::of(&file, wrong)),
            Err(source) => Err(CountsError::Unreadable { file, source }),
        }
    }

    fn of(file: &str, decoded: Decoded) -> Result<CountsFile, Wrong> {
        let (dialect, text) = Dialect::of(decoded)?;
        let mut reader = dialect.reader(&text);
        let heading = reader.headers().map_err(|error| unreadable(&text, &error))?.clone();
        let mut file = CountsFile {
            file: file.to_owned(),
            heading_line: line_at(&text, heading.position()),
            columns: Vec::new(),
            rows: 0,
            first: None,
            last: None,
            text: String::new(),
            dialect,
        };
        let is_of = |layout: &&&Layout| heading.iter().any(|name| name == layout.needed[0]);
        let layout = [&BINS, &SAMPLES].iter().find(is_of).copied().unwrap_or(&STEPS);
        for name in &heading {
            let known = layout.columns.iter().find(|(known, _)| *known == name);
            let taken_for = known.map(|(_, meaning)| *meaning);
            file.columns.push(CsvColumn { name: name.to_owned(), taken_for });
        }
        let place = heading.iter().position(|name| name == layout.needed[0]);
        let mut record = StringRecord::new();
        while let Ok(true) = reader.read_record(&mut record) {
            file.rows += u64::from(!is_blank(&record));
            let number = place.and_then(|place| file.dialect.whole(record.get(place)?));
            if let Some(number) = number.and_then(|number| i64::try_from(number).ok()) {
                file.first = file.first.min(Some(number)).or(Some(number));
                file.last = file.last.max(Some(number));
            }
        }
        file.text = text;
        Ok(file)
    }

    fn has(&self, layout: &Layout) -> bool {
        self.columns.iter().any(|column| column.name == layout.needed[0])
    }

    fn has_bins(&self) -> bool {
        self.has(&BINS)
    }

    /// Dark counts by sample of a chip, of each detector that the file names: bins of the code period
    /// of any number of periods, or counts by sample of one recording or several.
    ///
    /// # Errors
    /// If the file is not of either format, or is of another scene.
    pub fn dark_counts(&self, sensor: &Sensor) -> Result<Vec<DarkCounts>, CountsError> {
        dark_counts(self, sensor).map_err(|wrong| CountsError::of(&self.file, wrong))
    }

    /// The counts of one scan, or the bins of one histogram, as the heading says, of each detector
    /// that the file names.
    ///
    /// # Errors
    /// If the file is not of the format, or is of another scene.
    pub fn recorded(&self, sensor: &Sensor) -> Result<RecordedCounts, CountsError> {
        let recorded = match self.has_bins() {
            true => histograms(self, sensor).map(RecordedCounts::Histograms),
            false => scans(self, sensor).map(RecordedCounts::Scans),
        };
        recorded.map_err(|wrong| CountsError::of(&self.file, wrong))
    }
}

impl fmt::Display for CountsFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Dialect { encoding, byte_order_mark, delimiter, delimiter_line, decimal_sign } =
            &self.dialect;
        let mark = if *byte_order_mark { ", with a byte order mark" } else { "" };
        let named = if *delimiter_line { ", named on line 1" } else { "" };
        writeln!(f, "{} is understood as", self.file)?;
        writeln!(f, "  encoding      {encoding}{mark}")?;
        writeln!(f, "  delimiter     {delimiter}{named}")?;
        writeln!(f, "  decimal sign  {decimal_sign}")?;
        writeln!(f, "  heading       line {}", self.heading_line)?;
        let width = self.columns.iter().map(|column| column.name.len()).max().unwrap_or(0);
        for (place, CsvColumn { name, taken_for }) in (1..).zip(&self.columns) {
            let label = format!("column {place}");
            let taken_for = taken_for.unwrap_or("not known");
            writeln!(f, "  {label:12}  {name:width$}  {taken_for}")?;
        }
        write!(f, "  rows          {}", self.rows)?;
        let layouts = [&BINS, &SAMPLES];
        let row = layouts.iter().find(|layout| self.has(layout)).unwrap_or(&&STEPS).row;
        match self.first.zip(self.last) {
            Some((first, last)) => writeln!(f, ", {row}s {first} to {last}"),
            None => writeln!(f, ", no {row}s"),
        }
    }
}

/// The scans of a file: one of every detector that it names.
fn scans(file: &CountsFile, sensor: &Sensor) -> Result<Vec<RecordedScan>, Wrong> {
    let scene = sensor.scene();
    let scan = &scene.scan;
    let of_row = |row: &CountsRow| step_count(row, sensor);
    let shown = |step: u64| scan.phase_step(Step(step));
    let read = read_rows(file, scene, &STEPS, (scan.steps, &shown), of_row)?;
    let has_totals = file.columns.iter().any(|column| column.name == "total_count");
    let scans = read.into_iter();
    Ok(scans.map(|(detector, counts)| RecordedScan { detector, counts, has_totals }).collect())
}

/// The histograms of a file: one of every detector that it names.
fn histograms(file: &CountsFile, sensor: &Sensor) -> Result<Vec<RecordedHistogram>, Wrong> {
    let Some(plan) = sensor.interface().histogram() else {
        let says = "bins are of a sensor that keeps a histogram, and this scene's correlates phase \
                    step by phase step; write hardware.architecture = \"histogram\", or the counts \
                    of its phase steps with the heading phase_step,count";
        return Err((file.heading_line, says.to_owned()));
    };
    let of_row = |row: &CountsRow| bin_count(row, plan.bins(), plan.periods);
    let read = read_rows(file, sensor.scene(), &BINS, (plan.bins(), &|bin| bin), of_row)?;
    let histograms = read.into_iter().map(|(detector, bins)| {
        let histogram = Histogram::new(bins, plan.row_bins, plan.periods);
        let histogram = histogram.map_err(|problem| (file.heading_line, problem.to_string()))?;
        Ok(RecordedHistogram { detector, histogram })
    });
    histograms.collect()
}

/// The dark counts of a file: of every detector that it names.
fn dark_counts(file: &CountsFile, sensor: &Sensor) -> Result<Vec<DarkCounts>, Wrong> {
    let samples = u64::from(sensor.clock().samples_per_chip);
    let (parts, read) = if file.has_bins() {
        let bins = samples * sensor.timing().code_chips();
        let of_row = |row: &CountsRow| Ok((bin_of(row, bins)?, any_count(row)?));
        let read = read_rows(file, sensor.scene(), &BINS, (bins, &|bin| bin), of_row)?;
        (DarkParts::Chips, read)
    } else if file.has(&SAMPLES) {
        let of_row = |row: &CountsRow| sample_count(row, samples);
        let all = samples * runs(file)?;
        let shown = |place: u64| place % samples;
        (DarkParts::Runs, read_rows(file, sensor.scene(), &SAMPLES, (all, &shown), of_row)?)
    } else {
        let says = "dark counts are told by sample of the chip, with the heading sample,count, or by \
                    bin of the code period, with the heading bin,count, as goldtof replay --out writes \
                    them";
        return Err((file.heading_line, says.to_owned()));
    };
    let all = read.into_iter();
    Ok(all.map(|(detector, counts)| DarkCounts { detector, parts, counts }).collect())
}

/// How many recordings a file has.
fn runs(file: &CountsFile) -> Result<u64, Wrong> {
    let mut reader = file.dialect.reader(&file.text);
    let heading = reader.headers().map_err(|error| unreadable(&file.text, &error))?;
    let Some(place) = heading.iter().position(|name| name == "run") else { return Ok(1) };
    let mut last = 0;
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| unreadable(&file.text, &error))? {
        let run = record.get(place).and_then(|run| file.dialect.whole(run));
        // A wrong number is reported when its row is read.
        last = last.max(run.filter(|run| (0..MOST_RUNS).contains(run)).unwrap_or(0));
    }
    Ok(last as u64 + 1)
}

/// Reads a file that has for every detector that it names so many rows, each once; `shown` is a
/// row's number in the file, and `of_row` its place among them and what it says.
fn read_rows<T: PartialEq + Hits>(
    file: &CountsFile,
    scene: &Scene,
    layout: &'static Layout,
    (all, shown): (u64, &dyn Fn(u64) -> u64),
    of_row: impl Fn(&CountsRow) -> Result<(u64, T), String>,
) -> Result<Vec<(DetectorIndex, Vec<T>)>, Wrong> {
    let Layout { row, whole, .. } = *layout;
    let dialect = &file.dialect;
    let mut reader = dialect.reader(&file.text);
    let heading = reader.headers().map_err(|error| unreadable(&file.text, &error))?;
    let heading =
        Heading::of(heading, layout, scene).map_err(|problem| (file.heading_line, problem))?;
    // Of each detector: line of each row, and what it says.
    let mut found: Vec<BTreeMap<u64, (u64, T)>> = Vec::new();
    found.resize_with(scene.detectors.len(), BTreeMap::new);
    let mut record = StringRecord::new();
    while reader.read_record(&mut record).map_err(|error| unreadable(&file.text, &error))? {
        if is_blank(&record) {
            continue;
        }
        let line = line_at(&file.text, record.position());
        let read = || {
            let name = heading.place("detector").and_then(|place| record.get(place));
            let detector = detector_of(name, scene)?;
            let (place, says) =
                of_row(&CountsRow { record: &record, heading: &heading, detector, dialect })?;
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
    let last_line = file.text.lines().count().max(1) as u64;
    let mut rows: Vec<(DetectorIndex, Vec<T>)> = Vec::new();
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
        let says: Vec<T> = found.into_values().map(|(_, says)| says).collect();
        if let Some((other, _)) = rows.iter().find(|(_, other)| is_copy(other, &says)) {
            let [one, other] = [detector, *other].map(|detector| &scene.detectors[detector].name);
            let problem = format!(
                "detectors \"{other}\" and \"{one}\" have the same number in each of {all} {row}s, \
                 and photons scatter: these are the counts of one detector twice"
            );
            return Err((last_line, problem));
        }
        rows.push((detector, says));
    }
    match rows.is_empty() {
        true => Err((last_line, layout.if_empty.to_owned())),
        false => Ok(rows),
    }
}

/// What a row says of hits.
trait Hits {
    /// As many hits as the row has at least.
    fn hits(&self) -> u64;
}

impl Hits for u64 {
    fn hits(&self) -> u64 {
        *self
    }
}

impl Hits for StepCount {
    fn hits(&self) -> u64 {
        self.total.max(self.signed.unsigned_abs())
    }
}

/// Whether two detectors' rows are alike as two records of photons are not: no number has a greater
/// chance than about 1/sqrt(1 + m) where m hits are expected. The largest numbers, at which counters may
/// be clamped, and zeros say nothing of it.
fn is_copy<T: PartialEq + Hits>(one: &[T], other: &[T]) -> bool {
    /// Natural logarithm of a chance of 2e-9.
    const NO_CHANCE: f64 = -20.0;
    let most = one.iter().map(T::hits).max().unwrap_or(0);
    let scattered = one.iter().map(T::hits).filter(|&hits| hits < most);
    one == other && scattered.map(|hits| -0.5 * (hits as f64).ln_1p()).sum::<f64>() < NO_CHANCE
}

/// Line of a record that the reader found from a place of a text on.
fn line_at(text: &str, place: Option<&csv::Position>) -> u64 {
    let (byte, line) = place.map_or((0, 1), |place| (place.byte() as usize, place.line()));
    let lines = text.get(byte..).unwrap_or_default().lines();
    line + lines.take_while(|line| is_skipped(line)).count() as u64
}

/// Whether a record is of an empty line: of a spreadsheet it has its delimiters.
fn is_blank(record: &StringRecord) -> bool {
    record.iter().all(str::is_empty)
}

/// The reader's error for a malformed record.
fn unreadable(text: &str, error: &csv::Error) -> Wrong {
    let line = line_at(text, error.position());
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
            let Some(column) = columns.iter().position(|(known, _)| *known == name) else {
                let known: Vec<&str> = columns.iter().map(|(known, _)| *known).collect();
                return Err(format!(
                    "no column{of} is called \"{name}\"; the heading may name {}, and must name {}",
                    known.join(", "),
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
        let column = self.layout.columns.iter().position(|(known, _)| *known == name)?;
        self.places[column]
    }
}

/// A row of a file, and the detector that it is of.
struct CountsRow<'r> {
    record: &'r StringRecord,
    heading: &'r Heading,
    detector: DetectorIndex,
    dialect: &'r Dialect,
}

impl CountsRow<'_> {
    fn field(&self, name: &str) -> Option<&str> {
        self.record.get(self.heading.place(name)?)
    }

    /// A whole number, of any size that has a meaning somewhere.
    fn whole(&self, name: &str) -> Result<i128, String> {
        let field = self.field(name).unwrap_or_default();
        let refused = || self.refused(name, field, "a whole number, for example 12");
        self.dialect.whole(field).ok_or_else(refused)
    }

    fn refused(&self, name: &str, field: &str, right: &str) -> String {
        let shown: String = field.chars().take(40).collect();
        format!("{name} is \"{shown}\"{}; write {right}", self.dialect.doubt(field))
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
        check_distance(field, row, sensor, step)?;
    }
    if row.field("integration_chips").is_some() {
        check_integration(row.whole("integration_chips")?, scene)?;
    }
    let signed = row.whole("count")?;
    let total = row.field("total_count").map(|_| row.whole("total_count"));
    Ok((step.0, possible_count(scene, signed, total.transpose()?)?))
}

/// Counts of one scan are not those of the sums of several.
fn check_integration(chips: i128, scene: &Scene) -> Result<(), String> {
    let expected = scene.scan.integration_chips;
    if chips == expected.into() {
        return Ok(());
    }
    let integration_ns = scene.clock().ps(chips as f64) * 1e-3;
    Err(format!(
        "the count is of {chips} chips, and a step of this scene has {expected}, of all scans that are \
         added up; counts of one scan, as goldtof run writes them, are estimated with --set \
         hardware.accumulate=1 --set 'scan.integration={integration_ns} ns'"
    ))
}

/// Which bin a row is of, and what it counts.
fn bin_count(row: &CountsRow, bins: u64, periods: u64) -> Result<(u64, u64), String> {
    let bin = bin_of(row, bins)?;
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

fn bin_of(row: &CountsRow, bins: u64) -> Result<u64, String> {
    let number = row.whole("bin")?;
    u64::try_from(number).ok().filter(|&bin| bin < bins).ok_or_else(|| {
        format!(
            "the scene's histogram has no bin {number}: it has {bins}, from 0 on, one for each \
             sample of the code period; these bins are of another scene"
        )
    })
}

/// What a row counts of a recording that is as long as may be.
fn any_count(row: &CountsRow) -> Result<u64, String> {
    let number = row.whole("count")?;
    let count = u32::try_from(number);
    count.map(u64::from).map_err(|_| format!("count is {number}; a count is 0 to {}", u32::MAX))
}

/// Which sample of which recording a row is of, and what it counts.
fn sample_count(row: &CountsRow, samples: u64) -> Result<(u64, u64), String> {
    let number = row.whole("sample")?;
    let sample = u64::try_from(number).ok().filter(|&sample| sample < samples);
    let sample = sample.ok_or_else(|| {
        format!(
            "a chip of the scene has no sample {number}: it has {samples}, from 0 on; see \
             clock.samples_per_chip"
        )
    })?;
    let run = row.field("run").map(|_| row.whole("run")).transpose()?.unwrap_or(0);
    if !(0..MOST_RUNS).contains(&run) {
        return Err(format!("run is {run}; write the recording's number, from 0 on"));
    }
    Ok((run as u64 * samples + sample, any_count(row)?))
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

fn check_distance(field: &str, row: &CountsRow, sensor: &Sensor, step: Step) -> Result<(), String> {
    let refused = || row.refused("distance_m", field, "metres, for example 3.2");
    let given = row.dialect.number(field).ok_or_else(refused)?;
    let offset_ps = calibration_offset_ps(sensor, row.detector, CountingTier::Sampled);
    let expected = distance_m(sensor.timing().reference_delay_ps(step) - offset_ps);
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
