//! Two paths of one code: how far apart they must be to be told apart, and how precisely
//! they are.

use std::sync::Arc;

use super::fits::Fits;
use crate::code::Code;
use crate::report::chart::{Axis, Chart, Legend, Mark, Panel, Point, Scale, Series};
use crate::scene::Scene;
use crate::simulate::Tier;
use crate::study::reproduce::figure::{Figure, Table, cells};
use crate::study::reproduce::run::{Run, RunError};
use crate::study::reproduce::sensor::{CHIP_PERIOD_PS, Light, balanced_gold, sensor};
use crate::study::reproduce::statistics::Measured;

const INTEGRATION_S: f64 = 1.04e-3;
/// Most scans of a point: each is of a whole code period, and takes a quarter of a second.
const MOST_SCANS: u64 = 40;
/// Where the first path is: between two phase steps.
const FIRST_CHIPS: f64 = 10.0375;
const APART_CHIPS: [f64; 10] = [0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1.0, 1.5, 2.0, 3.0];
/// Power of both paths together, in picowatts, and in words.
const LEVELS: [(f64, &str); 2] = [(4.1, "5 Mcps"), (20.5, "20 Mcps")];
/// Strength of the later path beside the earlier one's.
const RATIOS: [f64; 2] = [1.0, 0.3];
/// Standard deviations of fewer scans than this share are those of a lucky few.
const LEAST_TOLD: f64 = 0.5;

/// A kind of pair at all separations.
struct Curve {
    label: String,
    points: Vec<(f64, Fits)>,
}

/// Two paths of a code, `apart_chips` from each other.
fn pair(code: &Arc<Code>, power_pw: f64, ratio: f64, apart_chips: f64) -> Scene {
    let strongest_pw = power_pw / (1.0 + ratio);
    let at = |chips: f64, power_pw: f64| Light::new(code, power_pw).at(chips * CHIP_PERIOD_PS);
    let lights =
        [at(FIRST_CHIPS, strongest_pw), at(FIRST_CHIPS + apart_chips, ratio * strongest_pw)];
    sensor(&lights, INTEGRATION_S)
}

/// The figure of scatter against separation.
pub fn two_paths(run: &mut Run) -> Result<Figure, RunError> {
    let code = balanced_gold(0, 0)?;
    let mut curves = Vec::new();
    for (power_pw, level) in LEVELS {
        for ratio in RATIOS {
            let mut points = Vec::new();
            for apart_chips in APART_CHIPS {
                let scene = pair(&code, power_pw, ratio, apart_chips);
                points.push((apart_chips, run.fits(&scene, Tier::Counts, MOST_SCANS)?));
            }
            curves.push(Curve { label: format!("{level}, 1 : {ratio}"), points });
        }
    }
    let wrong = most_wrong(&curves);
    Ok(Figure {
        table: table(&curves),
        chart: Chart {
            title:
                "Two paths of one code, 1.04 ms per phase step: joint fit, and its bound (lines)"
                    .to_owned(),
            panels: vec![
                scatter(&curves, 0, "standard deviation of the earlier path (mm)"),
                scatter(&curves, 1, "standard deviation of the later path (mm)"),
                shares(&curves),
            ],
        },
        claims: Vec::new(),
        notes: vec![wrong],
    })
}

fn axis() -> Axis {
    Axis { label: "distance of the paths' delays (chips of 8 ns)".to_owned(), scale: Scale::Log }
}

/// Standard deviations of one of the paths, and lines of its bound.
fn scatter(curves: &[Curve], path: usize, label: &str) -> Panel {
    let mut series = Vec::new();
    for (colour, curve) in curves.iter().enumerate() {
        let told = curve.points.iter();
        let told = told.filter(|(_, fits)| fits.told().value >= LEAST_TOLD);
        let bounds = told.clone().filter_map(|(apart, fits)| {
            let bound_m = fits.paths[path].bound_m?;
            Some(Point::new(*apart, 1e3 * bound_m))
        });
        series.push(Series {
            label: String::new(),
            mark: Mark::Line,
            colour,
            points: bounds.collect(),
        });
        let measured = told.filter_map(|(apart, fits)| {
            let std_mm = fits.paths[path].std_m()?.scaled(1e3);
            Some(dot(*apart, std_mm))
        });
        series.push(Series {
            label: curve.label.clone(),
            mark: Mark::Dots,
            colour,
            points: measured.collect(),
        });
    }
    Panel {
        x: axis(),
        y: Axis { label: label.to_owned(), scale: Scale::Log },
        series,
        legend: Legend::UpperRight,
        headroom: 0.06,
    }
}

/// Shares of scans that tell the paths apart.
fn shares(curves: &[Curve]) -> Panel {
    let numbered = curves.iter().enumerate();
    let series = numbered.map(|(colour, curve)| Series {
        label: curve.label.clone(),
        mark: Mark::LineAndDots,
        colour,
        points: curve.points.iter().map(|(apart, fits)| dot(*apart, fits.told())).collect(),
    });
    Panel {
        x: axis(),
        y: Axis { label: "share of scans that tell both paths".to_owned(), scale: Scale::Linear },
        series: series.collect(),
        legend: Legend::UpperLeft,
        headroom: 0.35,
    }
}

fn dot(x: f64, shown: Measured) -> Point {
    Point { x, y: shown.value, interval: Some((shown.low, shown.high)) }
}

/// The largest share of confident wrong answers, in words.
fn most_wrong(curves: &[Curve]) -> String {
    let points =
        curves.iter().flat_map(|curve| curve.points.iter().map(move |point| (&curve.label, point)));
    let worst =
        points.max_by(|(_, (_, a)), (_, (_, b))| a.wrong().value.total_cmp(&b.wrong().value));
    match worst {
        Some((label, (apart, fits))) => format!(
            "scans with a path more than 4 of its standard deviations off: at most {:.1} % ({:.1} \
             to {:.1}), of {label} at {apart} chips",
            100.0 * fits.wrong().value,
            100.0 * fits.wrong().low,
            100.0 * fits.wrong().high,
        ),
        None => "no scans".to_owned(),
    }
}

fn table(curves: &[Curve]) -> Table {
    let mut table = Table::new(&[
        "series",
        "path",
        "apart_chips",
        "told",
        "told_low",
        "told_high",
        "wrong",
        "wrong_low",
        "wrong_high",
        "bias_m",
        "bias_low_m",
        "bias_high_m",
        "std_m",
        "std_low_m",
        "std_high_m",
        "bound_m",
    ]);
    for curve in curves {
        for (apart, fits) in &curve.points {
            for (number, path) in fits.paths.iter().enumerate() {
                let mut row = vec![Some(number as f64), Some(*apart)];
                row.extend(cells(fits.told()));
                row.extend(cells(fits.wrong()));
                row.extend(path.bias_m().map_or([None; 3], cells));
                row.extend(path.std_m().map_or([None; 3], cells));
                row.push(path.bound_m);
                table.row(&curve.label, &row);
            }
        }
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{CodeSpec, Family};
    use crate::study::reproduce::{FigureId, Options};

    /// At 0.6 chips both are found, at the bound, which 30 scans tell within 13 %; at a tenth
    /// of a chip nobody can tell.
    #[test]
    fn paths_are_told_apart_where_the_light_tells_and_nowhere_else() {
        let options = Options { seed: 5, repetitions: 30, figures: Vec::new() };
        let mut run = Run::new(FigureId::TwoPaths, &options);
        // A short code, whose fits are quick.
        let spec = CodeSpec { degree: Some(7), index: Some(3), ..CodeSpec::new(Family::Gold) };
        let code = spec.build().map(Arc::new).expect("a Gold code");
        let mut fits = |apart: f64| {
            let scene = pair(&code, 4.1, 1.0, apart);
            run.fits(&scene, Tier::Counts, MOST_SCANS).expect("fits")
        };
        let far = fits(0.6);
        assert!(far.told().value > 0.95, "{:?}", far.told());
        for path in &far.paths {
            let (std_m, bound_m) = (path.std_m().expect("many"), path.bound_m.expect("one"));
            let ratio = std_m.value / bound_m;
            assert!((0.6..1.6).contains(&ratio), "{ratio}");
            let bias_m = path.bias_m().expect("many").value;
            assert!(bias_m.abs() < bound_m, "{bias_m} {bound_m}");
        }
        let near = fits(0.1);
        assert!(near.told().value < 0.2, "{:?}", near.told());
        assert!(near.wrong().value < 0.05, "{:?}", near.wrong());
    }
}
