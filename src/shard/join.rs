//! What the shards of a job are together.

use super::ShardError;
use super::job::{GradeJob, PartResults, PointRows, Results, SimulateJob};
use super::part::JobPart;
use crate::grade::{Grade, Graded, Outcomes};
use crate::image::PixelRow;
use crate::report::table::Table;
use crate::sensor::Sensor;
use crate::simulate::repeat::{Gathered, ScanTally, Simulated, Simulation};
use crate::study::reproduce::{MadeFigure, ReproduceOptions};
use crate::study::stress::{CaseReport, StressOptions, StressReport, UnknownCase};
use crate::study::sweep::{Store, StoreError, Sweep, empty};

/// Results of one kind, if they are of it.
macro_rules! of_kind {
    ($kind:ident, $results:expr) => {
        match $results {
            Results::$kind(found) => Some(found),
            _ => None,
        }
    };
}

/// The units of all shards of which each has every N-th, in order. `of` gives those of a shard,
/// `is_its` checks that a unit has its number, and `reason` is the message if it has not.
fn in_order<U>(
    units: usize,
    shards: PartResults,
    reason: &'static str,
    of: impl Fn(Results) -> Option<Vec<U>>,
    is_its: impl Fn(usize, &U) -> bool,
) -> Result<Vec<U>, ShardError> {
    let mut all: Vec<Option<U>> = (0..units).map(|_| None).collect();
    for (part, results) in shards {
        let unfit = || ShardError::Unfit { part, reason };
        let found = of(results).ok_or_else(unfit)?;
        let numbers: Vec<usize> = part.every(units as u64).map(|n| n as usize).collect();
        let are_its = numbers.iter().zip(&found).all(|(&number, unit)| is_its(number, unit));
        if numbers.len() != found.len() || !are_its {
            return Err(unfit());
        }
        for (number, unit) in numbers.into_iter().zip(found) {
            all[number] = Some(unit);
        }
    }
    Ok(all.into_iter().flatten().collect())
}

/// The figures of all shards, in the order of the options.
///
/// # Errors
/// When a shard's figures are not those of its part.
pub fn figures(
    options: &ReproduceOptions,
    shards: PartResults,
) -> Result<Vec<MadeFigure>, ShardError> {
    let is_its = |number: usize, figure: &MadeFigure| figure.id == options.figures[number];
    let figures = |results| of_kind!(Reproduce, results);
    in_order(options.figures.len(), shards, "it has other figures", figures, is_its)
}

/// The report that all shards together are.
///
/// # Errors
/// When a shard's cases are not those of its part.
pub fn stress_report(
    options: &StressOptions,
    shards: PartResults,
) -> Result<StressReport, ShardError> {
    let unknown = |error: UnknownCase| ShardError::NoJob { reason: error.to_string() };
    let cases = options.chosen().map_err(unknown)?;
    let is_its = |number: usize, report: &CaseReport| report.name == cases[number].name;
    let reports = |results| of_kind!(Stress, results);
    let cases = in_order(cases.len(), shards, "it has other cases", reports, is_its)?;
    Ok(StressReport { seed: options.seed, cases })
}

/// The finished points of a part, from where they were kept.
///
/// # Errors
/// When one cannot be read.
pub fn rows(part: JobPart, sweep: &Sweep, store: &Store) -> Result<Vec<PointRows>, StoreError> {
    let heading = empty(&sweep.options.over).heading();
    let of_point = |point: u64| {
        let rows_csv = heading.clone() + &store.rows_csv(point as usize)?;
        Ok(PointRows { point, rows_csv })
    };
    part.every(sweep.len() as u64).map(of_point).collect()
}

/// The rows of all shards, point by point.
///
/// # Errors
/// When a shard's points are not those of its part.
pub fn tables(sweep: &Sweep, shards: PartResults) -> Result<Vec<Table>, ShardError> {
    let read = |rows: PointRows| {
        let mut table = empty(&sweep.options.over);
        table.read_csv(&rows.rows_csv).ok()?;
        Some((rows.point, table))
    };
    let points = |results| of_kind!(Sweep, results)?.into_iter().map(read).collect();
    let is_its = |number: usize, (point, _): &(u64, Table)| *point == number as u64;
    let reason = "it has other points, or other columns";
    let points = in_order(sweep.len(), shards, reason, points, is_its)?;
    Ok(points.into_iter().map(|(_, table)| table).collect())
}

/// The rows of pixels of all shards, from the top, of an array of `rows` rows of `columns`.
///
/// # Errors
/// When a shard's rows are not those of its part.
pub fn pixel_rows(
    [rows, columns]: [u32; 2],
    shards: PartResults,
) -> Result<Vec<PixelRow>, ShardError> {
    let is_its = |number: usize, row: &PixelRow| {
        row.row as usize == number && row.pixels.len() == columns as usize
    };
    let of_pixels = |results| of_kind!(Image, results);
    in_order(rows as usize, shards, "it has other rows of pixels", of_pixels, is_its)
}

/// Numbers of a part's faults or mutants of a kind.
pub fn variants(part: JobPart, count: usize) -> Vec<usize> {
    part.every(count as u64).map(|number| number as usize).collect()
}

/// The grade by all shards together.
///
/// # Errors
/// When a shard's faults and mutants are not those of its part.
pub fn whole_grade(job: &GradeJob, shards: PartResults) -> Result<Grade, ShardError> {
    let mut all: Option<Graded> = None;
    for (part, results) in shards {
        let unfit = || ShardError::Unfit { part, reason: "it has other faults or mutants" };
        let graded = of_kind!(Grade, results).ok_or_else(unfit)?;
        let are_its = |outcomes: &Outcomes| {
            let numbers = outcomes.of.iter().map(|outcome| outcome.number as u64);
            numbers.eq(part.every(outcomes.total as u64))
        };
        if !are_its(&graded.faults) || !graded.mutants.iter().all(are_its) {
            return Err(unfit());
        }
        all = Some(match all {
            None => graded,
            Some(all) => joined(all, graded).ok_or_else(unfit)?,
        });
    }
    let all = all.ok_or_else(|| ShardError::NoJob { reason: "it has no shards".to_owned() })?;
    Ok(all.grade(&job.options))
}

/// Two shards, if they are of the same variants under the same stimulus.
fn joined(mut all: Graded, more: Graded) -> Option<Graded> {
    let is_same = all.clocks == more.clocks && all.faults.total == more.faults.total;
    all.faults.append(more.faults);
    match (&mut all.mutants, more.mutants) {
        (None, None) => {}
        (Some(mutants), Some(more)) if mutants.total == more.total => mutants.append(more),
        _ => return None,
    }
    is_same.then_some(all)
}

/// The simulation that all shards together are, each of a stretch of the scans.
///
/// # Errors
/// When a shard's results are not those of its scans, or the tier cannot do the scene.
pub fn simulation(
    job: &SimulateJob,
    sensor: &Sensor,
    shards: PartResults,
) -> Result<Simulation, ShardError> {
    let simulated = Simulated::new(sensor, job.options)?;
    let mut all = simulated.nothing();
    for (part, results) in shards {
        let unfit = |reason| ShardError::Unfit { part, reason };
        let gathered = of_kind!(Simulate, results).ok_or_else(|| unfit("it has no scans"))?;
        let stretch = part.stretch(job.options.repetitions);
        check(stretch.end - stretch.start, &all, &gathered).map_err(unfit)?;
        all.append(gathered);
    }
    Ok(simulated.conclude(all)?)
}

/// Whether results are of so many scans; `nothing` has as many detectors and paths.
fn check(scans: u64, nothing: &Gathered, gathered: &Gathered) -> Result<(), &'static str> {
    if gathered.tallies.len() != nothing.tallies.len() {
        return Err("the scene has another number of detectors");
    }
    for (tally, of_none) in gathered.tallies.iter().zip(&nothing.tallies) {
        if tally.scans != scans {
            return Err("it has another number of scans");
        }
        if tally.errors_m.len() != of_none.errors_m.len() || !is_sound(tally) {
            return Err("its estimates are not those of so many scans");
        }
    }
    Ok(())
}

/// Whether nothing was counted more often than there are scans.
fn is_sound(tally: &ScanTally) -> bool {
    let errors = tally.errors_m.iter().map(|errors_m| errors_m.len() as u64);
    let mut of_paths = errors.zip(&tally.found);
    tally.found.len() == tally.errors_m.len()
        && of_paths.all(|(errors, &found)| found <= errors && errors <= tally.scans)
        && tally.alarms <= tally.fits
        && tally.fits <= tally.scans
        && tally.refused <= tally.scans
        && tally.remarks <= tally.scans
}
