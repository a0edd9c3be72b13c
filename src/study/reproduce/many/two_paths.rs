//! Two paths of one code: how far apart they must be to be told apart, and how precisely
//! they are.

use std::sync::Arc;

use super::{Fits, PathFits};
use crate::study::reproduce::prelude::*;

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
    let at = |chips: f64, power_pw: f64| PathLight::new(code, power_pw).at(chips * CHIP_PERIOD_PS);
    let lights =
        [at(FIRST_CHIPS, strongest_pw), at(FIRST_CHIPS + apart_chips, ratio * strongest_pw)];
    sensor(&lights, INTEGRATION_S)
}

/// The figure of scatter against separation.
pub fn two_paths(run: &mut FigureScans) -> Result<Figure, FigureError> {
    let code = balanced_gold(0, 0)?;
    let mut curves = Vec::new();
    for (power_pw, level) in LEVELS {
        for ratio in RATIOS {
            let mut points = Vec::new();
            for apart_chips in APART_CHIPS {
                let scene = pair(&code, power_pw, ratio, apart_chips);
                points.push((apart_chips, Fits::of(run, &scene, Tier::Counts, MOST_SCANS)?));
            }
            curves.push(Curve { label: format!("{level}, 1 : {ratio}"), points });
        }
    }
    let table = table(&curves);
    let panels = vec![
        scatter(&table, 0, "standard deviation of the earlier path (mm)"),
        scatter(&table, 1, "standard deviation of the later path (mm)"),
        panel(ChartAxis::linear("told", "share of scans that tell both paths"))
            .curves(&of_path(&table, 0), Mark::LineAndDots),
    ];
    let title = "Two paths of one code, 1.04 ms per phase step: joint fit, and its bound (lines)";
    let notes = vec![most_wrong(&curves)];
    Ok(Figure { notes, ..Figure::new(title, table, panels) })
}

fn panel(y: ChartAxis) -> Panel {
    Panel::new(ChartAxis::log("apart_chips", "distance of the paths' delays (chips of 8 ns)"), y)
}

fn of_path(table: &Table, path: u64) -> Table {
    table.only(|table, row| table.value(row, "path").number() == Some(path as f64))
}

/// Standard deviations of one of the paths, and lines of its bound.
fn scatter(table: &Table, path: u64, label: &str) -> Panel {
    let told = of_path(table, path).only(|table, row| {
        table.value(row, "told").number().is_some_and(|told| told >= LEAST_TOLD)
    });
    panel(ChartAxis::log("std_m", label))
        .curves_of(&told, "bound_m", Mark::Line)
        .curves(&told, Mark::Dots)
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
    let rows = curves.iter().flat_map(|curve| {
        let points = curve.points.iter();
        points.flat_map(move |(apart, fits)| {
            let paths = (0..).zip(&fits.paths);
            paths.map(move |(number, path)| (&curve.label, *apart, fits, number, path))
        })
    });
    let rows: Vec<(&String, f64, &Fits, u32, &PathFits)> = rows.collect();
    Table::of(&rows)
        .column("series", |row| row.0.as_str())
        .column("path", |row| row.3)
        .column("apart_chips", |row| row.1)
        .interval("told", |row| row.2.told())
        .interval("wrong", |row| row.2.wrong())
        .interval("bias_m", |row| row.4.bias_m())
        .interval("std_m", |row| row.4.std_m())
        .column("bound_m", |row| row.4.bound_m)
        .table()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{CodeSpec, Family};
    use crate::study::reproduce::{FigureId, ReproduceOptions};

    /// At 0.6 chips both are found, at the bound, which 30 scans tell within 13 %; at a tenth
    /// of a chip nobody can tell.
    #[test]
    fn paths_are_told_apart_where_the_light_tells_and_nowhere_else() {
        let options = ReproduceOptions { seed: 5, repetitions: 30, figures: Vec::new() };
        let mut run = FigureScans::new(FigureId::TwoPaths, &options);
        // A short code, whose fits are quick.
        let spec = CodeSpec { degree: Some(7), index: Some(3), ..CodeSpec::new(Family::Gold) };
        let code = spec.build().map(Arc::new).expect("a Gold code");
        let mut fits = |apart: f64| {
            let scene = pair(&code, 4.1, 1.0, apart);
            Fits::of(&mut run, &scene, Tier::Counts, MOST_SCANS).expect("fits")
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
