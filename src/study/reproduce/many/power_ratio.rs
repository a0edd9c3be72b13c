//! The own sensor under another one that is brighter: how far off its distance is, with
//! clocks that are one and clocks that are not.

use super::fits::{Fits, PathFits};
use crate::report::chart::{Axis, Chart, Legend, Mark, Panel, Point, Scale, Series};
use crate::scene::Scene;
use crate::simulate::Tier;
use crate::study::reproduce::figure::{Figure, Table, cells};
use crate::study::reproduce::phase::Errors;
use crate::study::reproduce::run::{Run, RunError};
use crate::study::reproduce::sensor::{CHIP_PERIOD_PS, Light, balanced_gold, sensor, window};
use crate::study::reproduce::statistics::Measured;

const INTEGRATION_S: f64 = 1.04e-3;
/// Power of the other sensor's light at the detector.
const OTHER_PW: f64 = 22.0;
const OWN_CHIPS: f64 = 80.0375;
const OTHER_CHIPS: f64 = 187.6375;
/// How many times the other sensor is brighter.
const RATIOS: [f64; 7] = [1.0, 3.0, 10.0, 20.0, 30.0, 50.0, 100.0];
/// By how much another clock is faster: the two crystals' tolerance.
const CLOCK_OFFSET: f64 = 20e-6;
/// Most scans of a whole code period, and of a window, behind a point.
const MOST_WHOLE_SCANS: u64 = 40;
const MOST_SCANS: u64 = 200;
/// The phase's scans are one of so many shares of what is usual.
const SHARES: u64 = 5;
/// Scanned to either side of the own path where a window is enough.
const HALF_WINDOW_CHIPS: u64 = 5;

/// The shares of scans that find the path are not of one kind.
const LOOKED_FOR: &str = "the own path is looked for in the whole code period where clocks are one, in \
                          5 chips to either side of it where they are not";

/// What was measured at one power ratio.
struct Row {
    ratio: f64,
    /// By the joint fit: clocks that are one, and clocks that are not.
    fits: [Fits; 2],
    /// By the phase in the same light.
    phase: [Option<Errors>; 2],
}

/// How the two clocks go.
const KINDS: [&str; 2] = ["synchronised", "20 ppm apart"];

/// The own sensor's light under `ratio` times as much of another's, over the whole code
/// period.
fn scene(ratio: f64, clock_offset: f64) -> Result<Scene, RunError> {
    let (own, other) = (balanced_gold(0, 0)?, balanced_gold(1, 0)?);
    let lights = [
        Light::new(&own, OTHER_PW / ratio).at(OWN_CHIPS * CHIP_PERIOD_PS),
        Light::new(&other, OTHER_PW).at(OTHER_CHIPS * CHIP_PERIOD_PS),
    ];
    let mut scene = sensor(&lights, INTEGRATION_S);
    scene.sources[1].clock.offset = clock_offset;
    Ok(scene)
}

/// The steps round the own path.
fn round_own(scene: Scene) -> Scene {
    window(scene, OWN_CHIPS * CHIP_PERIOD_PS, HALF_WINDOW_CHIPS)
}

fn measure(run: &mut Run, ratio: f64) -> Result<Row, RunError> {
    let one_clock = scene(ratio, 0.0)?;
    let two_clocks = round_own(scene(ratio, CLOCK_OFFSET)?);
    let fits = [
        // Light that is found by its code shows in the whole scan only.
        run.fits(&one_clock, Tier::Counts, MOST_WHOLE_SCANS)?,
        // Its counts are no longer those of a step's mean light, but of photons.
        run.fits(&two_clocks, Tier::Events, MOST_SCANS)?,
    ];
    let mut phase = |scene: &Scene| match run.share_of_errors(scene, SHARES) {
        Err(RunError::NoStatistics { .. }) => Ok(None),
        errors => errors.map(Some),
    };
    Ok(Row { ratio, phase: [phase(&round_own(one_clock))?, phase(&two_clocks)?], fits })
}

/// The figure of error against power ratio.
pub fn power_ratio(run: &mut Run) -> Result<Figure, RunError> {
    let rows: Vec<Row> =
        RATIOS.into_iter().map(|ratio| measure(run, ratio)).collect::<Result<_, _>>()?;
    Ok(Figure {
        table: table(&rows),
        chart: Chart {
            title: "Own sensor under another one of 22 pW (21 Mcps), 1.04 ms per phase step; \
                    clocks that are one, and 20 ppm apart"
                .to_owned(),
            panels: vec![errors(&rows), shares(&rows)],
        },
        claims: Vec::new(),
        notes: std::iter::once(LOOKED_FOR.to_owned()).chain(rows.iter().map(note)).collect(),
    })
}

/// Root of the mean square error, with its interval from bias and scatter.
fn root_mean_square(bias: Measured, std: Measured) -> Measured {
    let rms = bias.value.hypot(std.value);
    let parts = [bias, std].map(|part| part.value * part.standard_error());
    let error = parts[0].hypot(parts[1]) / rms.max(f64::MIN_POSITIVE);
    Measured::normal(rms, error)
}

fn of_fit(path: &PathFits) -> Option<Measured> {
    Some(root_mean_square(path.bias_m()?, path.std_m()?))
}

fn axis() -> Axis {
    Axis {
        label: "power of the other sensor's light over that of the own".to_owned(),
        scale: Scale::Log,
    }
}

fn errors(rows: &[Row]) -> Panel {
    let mut series = Vec::new();
    for (colour, kind) in KINDS.iter().enumerate() {
        let bounds = rows.iter().filter_map(|row| {
            let bound_m = row.fits[colour].paths[0].bound_m?;
            Some(Point::new(row.ratio, 1e3 * bound_m))
        });
        series.push(Series {
            label: format!("bound, {kind}"),
            mark: Mark::Line,
            colour,
            points: bounds.collect(),
        });
        series.push(dots(format!("joint fit, {kind}"), colour, rows, |row| {
            of_fit(&row.fits[colour].paths[0]).map(|m| m.scaled(1e3))
        }));
        series.push(dots(format!("phase, {kind}"), colour + 3, rows, |row| {
            let errors = row.phase[colour]?;
            Some(root_mean_square(errors.bias_m, errors.std_m).scaled(1e3))
        }));
    }
    Panel {
        x: axis(),
        y: Axis {
            label: "root mean square error of the distances found (mm)".to_owned(),
            scale: Scale::Log,
        },
        series,
        legend: Legend::UpperLeft,
        headroom: 0.45,
    }
}

fn shares(rows: &[Row]) -> Panel {
    let mut series = Vec::new();
    for (colour, kind) in KINDS.iter().enumerate() {
        series.push(dots(format!("joint fit, {kind}"), colour, rows, |row| {
            Some(row.fits[colour].told())
        }));
        series.push(dots(format!("phase, {kind}"), colour + 3, rows, |row| {
            Some(row.phase[colour].map_or_else(none_found, |errors| errors.correct_coarse()))
        }));
    }
    Panel {
        x: axis(),
        y: Axis { label: "share of scans that find the own path".to_owned(), scale: Scale::Linear },
        series,
        legend: Legend::LowerLeft,
        headroom: 0.06,
    }
}

/// Fewer than two scans.
fn none_found() -> Measured {
    Measured::normal(0.0, 0.0)
}

fn dots(
    label: String,
    colour: usize,
    rows: &[Row],
    value: impl Fn(&Row) -> Option<Measured>,
) -> Series {
    let points = rows.iter().filter_map(|row| {
        let shown = value(row)?;
        Some(Point { x: row.ratio, y: shown.value, interval: Some((shown.low, shown.high)) })
    });
    Series { label, mark: Mark::LineAndDots, colour, points: points.collect() }
}

/// What the counts of clocks that are apart do to chi-square.
fn note(row: &Row) -> String {
    let share = |measured: Measured| {
        format!(
            "{:.1} % ({:.1} to {:.1})",
            100.0 * measured.value,
            100.0 * measured.low,
            100.0 * measured.high
        )
    };
    let [one, two] = &row.fits;
    format!(
        "1 : {}: more than 4 of its standard deviations off in {} of scans synchronised, {} with \
         clocks apart; alarms in {} and {}",
        row.ratio,
        share(one.wrong()),
        share(two.wrong()),
        share(one.alarms()),
        share(two.alarms()),
    )
}

fn table(rows: &[Row]) -> Table {
    let mut table = Table::new(&[
        "series",
        "other_over_own",
        "found",
        "found_low",
        "found_high",
        "bias_m",
        "bias_low_m",
        "bias_high_m",
        "std_m",
        "std_low_m",
        "std_high_m",
        "bound_m",
    ]);
    for row in rows {
        for (number, kind) in KINDS.iter().enumerate() {
            let fits = &row.fits[number];
            let path = &fits.paths[0];
            let mut values = vec![Some(row.ratio)];
            values.extend(cells(fits.told()));
            values.extend(path.bias_m().map_or([None; 3], cells));
            values.extend(path.std_m().map_or([None; 3], cells));
            values.push(path.bound_m);
            table.row(&format!("joint fit, {kind}"), &values);
            let phase = row.phase[number];
            let found = phase.map_or_else(none_found, |errors| errors.correct_coarse());
            let mut values = vec![Some(row.ratio)];
            values.extend(cells(found));
            values.extend(phase.map_or([None; 3], |errors| cells(errors.bias_m)));
            values.extend(phase.map_or([None; 3], |errors| cells(errors.std_m)));
            values.push(None);
            table.row(&format!("phase, {kind}"), &values);
        }
    }
    table
}
