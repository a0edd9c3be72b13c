//! Reading `bins.csv`: every mistake with its line and what would be right.

use csv::StringRecord;

use super::RecordedHistogram;
use super::csv_file::{Wrong, detector_of, read_records, whole};
use crate::histogram::Histogram;
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;

/// Columns that a file may have; all but the last it must.
const COLUMNS: [&str; 3] = ["bin", "count", "detector"];

/// Whether a text is of bins, by its heading.
pub(super) fn has_bins(text: &str) -> bool {
    let heading = text.lines().next().unwrap_or_default();
    let heading = heading.trim_start_matches('\u{feff}');
    let mut names = heading.split(',');
    names.any(|name| name.trim().trim_matches('"') == COLUMNS[0])
}

/// The histograms of a text: one of every detector that it names.
pub(super) fn parse(text: &str, sensor: &Sensor) -> Result<Vec<RecordedHistogram>, Wrong> {
    let scene = sensor.scene();
    let Some(plan) = sensor.interface().histogram else {
        let says = "bins are of a sensor that keeps a histogram, and this scene's correlates phase \
                    step by phase step; write hardware.architecture = \"histogram\", or the counts \
                    of its phase steps with the heading phase_step,count";
        return Err((1, says.to_owned()));
    };
    let begin = |heading: &StringRecord| {
        let columns = Columns::of(heading, scene)?;
        Ok((columns, vec![Found::default(); scene.detectors.len()]))
    };
    let ((_, found), last_line) = read_records(text, begin, |line, record, (columns, found)| {
        let row = Row::of(record, columns, scene, plan.bins(), plan.periods)?;
        found[row.detector.0].take(line, &row, scene)
    })?;
    let mut histograms = Vec::new();
    for (detector, found) in DetectorIndex::all().zip(found) {
        if found.lines.is_empty() {
            continue;
        }
        let bins = found
            .bins(plan.bins(), &scene.detectors[detector].name)
            .map_err(|problem| (last_line, problem))?;
        let histogram = Histogram::new(bins, plan.row_bins, plan.periods);
        histograms.push(RecordedHistogram {
            detector,
            histogram: histogram.map_err(|problem| (last_line, problem.to_string()))?,
        });
    }
    match histograms.is_empty() {
        true => Err((last_line, "the file has no bins; write a line for each bin".to_owned())),
        false => Ok(histograms),
    }
}

/// Where each column is.
struct Columns {
    places: [Option<usize>; COLUMNS.len()],
}

impl Columns {
    fn of(heading: &StringRecord, scene: &Scene) -> Result<Columns, String> {
        let several = scene.detectors.len() > 1;
        let example = if several { "bin,count,detector" } else { "bin,count" };
        let mut places = [None; COLUMNS.len()];
        for (place, name) in heading.iter().enumerate() {
            let Some(column) = COLUMNS.iter().position(|known| *known == name) else {
                return Err(format!(
                    "no column of bins is called \"{name}\"; write for example {example}"
                ));
            };
            if places[column].replace(place).is_some() {
                return Err(format!("two columns are called \"{name}\"; leave one out"));
            }
        }
        let needed = if several { 3 } else { 2 };
        match (0..needed).find(|&column| places[column].is_none()) {
            None => Ok(Columns { places }),
            Some(column) => {
                let heading: Vec<&str> = heading.iter().collect();
                Err(format!(
                    "the heading \"{}\" has no column {}; write for example {example}",
                    heading.join(","),
                    COLUMNS[column]
                ))
            }
        }
    }

    fn field<'r>(&self, record: &'r StringRecord, column: usize) -> Option<&'r str> {
        record.get(self.places[column]?)
    }
}

/// A row, checked for itself.
struct Row {
    detector: DetectorIndex,
    bin: u64,
    count: u64,
}

impl Row {
    fn of(
        record: &StringRecord,
        columns: &Columns,
        scene: &Scene,
        bins: u64,
        periods: u64,
    ) -> Result<Row, String> {
        let detector = detector_of(columns.field(record, 2), scene)?;
        let bin = whole(COLUMNS[0], columns.field(record, 0))?;
        let bin = u64::try_from(bin).ok().filter(|&bin| bin < bins);
        let Some(bin) = bin else {
            return Err(format!(
                "the scene's histogram has no bin {}: it has {bins}, from 0 on, one for each sample \
                 of the code period; these bins are of another scene",
                columns.field(record, 0).unwrap_or_default()
            ));
        };
        let count = whole(COLUMNS[1], columns.field(record, 1))?;
        let count = u64::try_from(count).ok().filter(|&count| count <= periods);
        let Some(count) = count else {
            return Err(format!(
                "bin {bin} counts {}; each of the {periods} code periods of scan.integration \
                 has it once, so that it is 0 to {periods}",
                columns.field(record, 1).unwrap_or_default()
            ));
        };
        Ok(Row { detector, bin, count })
    }
}

/// What was found of a detector.
#[derive(Clone, Default)]
struct Found {
    /// Line of each bin; 0 of those that are missing.
    lines: Vec<u64>,
    counts: Vec<u64>,
}

impl Found {
    fn take(&mut self, line: u64, row: &Row, scene: &Scene) -> Result<(), String> {
        let bin = row.bin as usize;
        if self.lines.len() <= bin {
            self.lines.resize(bin + 1, 0);
            self.counts.resize(bin + 1, 0);
        }
        if self.lines[bin] > 0 {
            return Err(format!(
                "bin {bin} of detector \"{}\" stands on line {} already; a file has one histogram, \
                 each bin once",
                scene.detectors[row.detector].name, self.lines[bin]
            ));
        }
        self.lines[bin] = line;
        self.counts[bin] = row.count;
        Ok(())
    }

    /// The counts, if none is missing.
    fn bins(mut self, bins: u64, detector: &str) -> Result<Vec<u64>, String> {
        self.lines.resize(bins as usize, 0);
        let missing = self.lines.iter().filter(|&&line| line == 0).count();
        match self.lines.iter().position(|&line| line == 0) {
            None => Ok(self.counts),
            Some(first) => Err(format!(
                "the file ends with {missing} of the {bins} bins of detector \"{detector}\" missing, \
                 the first is {first}; write every bin, with 0 where nothing was counted"
            )),
        }
    }
}

#[cfg(test)]
mod tests;
