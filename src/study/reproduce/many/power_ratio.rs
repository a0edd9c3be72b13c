//! The own sensor under another one that is brighter: how far off its distance is, with
//! clocks that are one and clocks that are not.

use super::{Fits, FoundLight};
use crate::study::reproduce::prelude::*;

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

/// How the two clocks go.
const KINDS: [&str; 2] = ["synchronised", "20 ppm apart"];

/// The own sensor's light under `ratio` times as much of another's, over the whole code
/// period.
fn scene(ratio: f64, clock_offset: f64) -> Result<Scene, FigureError> {
    let (own, other) = (balanced_gold(0, 0)?, balanced_gold(1, 0)?);
    let lights = [
        PathLight::new(&own, OTHER_PW / ratio).at(OWN_CHIPS * CHIP_PERIOD_PS),
        PathLight::new(&other, OTHER_PW).at(OTHER_CHIPS * CHIP_PERIOD_PS),
    ];
    let mut scene = sensor(&lights, INTEGRATION_S);
    scene.sources[1].clock.offset = clock_offset;
    Ok(scene)
}

/// The steps round the own path.
fn round_own(scene: Scene) -> Scene {
    window(scene, OWN_CHIPS * CHIP_PERIOD_PS, HALF_WINDOW_CHIPS)
}

/// The figure of error against power ratio.
pub fn power_ratio(run: &mut FigureScans) -> Result<Figure, FigureError> {
    let (mut rows, mut notes) = (Vec::new(), vec![LOOKED_FOR.to_owned()]);
    for ratio in RATIOS {
        let one_clock = scene(ratio, 0.0)?;
        let two_clocks = round_own(scene(ratio, CLOCK_OFFSET)?);
        let fits = [
            // Light that is found by its code shows in the whole scan only.
            Fits::of(run, &one_clock, Tier::Counts, MOST_WHOLE_SCANS)?,
            // Its counts are no longer those of a step's mean light, but of photons.
            Fits::of(run, &two_clocks, Tier::Events, MOST_SCANS)?,
        ];
        let windows = [round_own(one_clock), two_clocks];
        for ((kind, fits), scene) in KINDS.iter().zip(&fits).zip(&windows) {
            rows.push(FoundLight::by_fit(format!("joint fit, {kind}"), ratio, fits, 0));
            let phase = run.errors_if_any(scene, SHARES)?;
            rows.push(FoundLight::by_phase(format!("phase, {kind}"), ratio, phase));
        }
        notes.push(note(ratio, &fits));
    }
    let table = FoundLight::table("other_over_own", &rows);
    let errors = Table::of(&rows)
        .column("series", |row| row.series.as_str())
        .column("other_over_own", |row| row.x)
        .interval("rms_m", |row| row.bias_m.zip(row.std_m).map(root_mean_square))
        .column("bound_m", |row| row.bound_m)
        .table();
    let panel = |y| {
        Panel::new(
            ChartAxis::log(
                "other_over_own",
                "power of the other sensor's light over that of the own",
            ),
            y,
        )
    };
    let rms = "root mean square error of the distances found (mm); thin: bound of the joint fit";
    let panels = vec![
        panel(ChartAxis::log("rms_m", rms)).curves(&errors, Mark::LineAndDots).curves_of(
            &errors.with("bound_m"),
            "bound_m",
            Mark::Line,
        ),
        panel(ChartAxis::linear("found", "share of scans that find the own path"))
            .curves(&table, Mark::LineAndDots),
    ];
    let title = "Own sensor under another one of 22 pW (21 Mcps), 1.04 ms per phase step; clocks \
                 that are one, and 20 ppm apart";
    Ok(Figure { notes, ..Figure::new(title, table, panels) })
}

/// Root of the mean square error, with its interval from bias and scatter.
fn root_mean_square((bias, std): (Measured, Measured)) -> Measured {
    let rms = bias.value.hypot(std.value);
    let parts = [bias, std].map(|part| part.value * part.standard_error());
    let error = parts[0].hypot(parts[1]) / rms.max(f64::MIN_POSITIVE);
    Measured::normal(rms, error)
}

/// What the counts of clocks that are apart do to chi-square.
fn note(ratio: f64, [one, two]: &[Fits; 2]) -> String {
    format!(
        "1 : {ratio}: more than 4 of its standard deviations off in {} of scans synchronised, {} with \
         clocks apart; alarms in {} and {}",
        in_percent(one.wrong()),
        in_percent(two.wrong()),
        in_percent(one.alarms()),
        in_percent(two.alarms()),
    )
}
