//! Standard deviation of the distance against optical power: Figs. 5, 6 and 8.

pub mod gold_square;
pub mod interleaving;
pub mod two_sources;

use super::prelude::*;
use super::run::Errors;

/// Mean optical power at the detector, in picowatts: 0.6 to 78 million primary
/// detections per second.
const POWERS_PW: [f64; 8] = [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];

/// Label of the horizontal axis, of one source.
const POWER: &str = "optical power at the detector (pW)";

/// Mean over the powers of the decibels by which one curve is above another; none
/// where nothing can be compared.
fn mean_loss(above: &ErrorCurve, below: &ErrorCurve) -> Option<Measured> {
    let losses = above.decibels_above(below);
    let values: Vec<Measured> = losses.iter().map(|(_, loss)| *loss).collect();
    (!values.is_empty()).then(|| mean(&values))
}

/// Value and interval with two decimals, without unit.
fn with_interval(measured: Measured) -> String {
    format!("{:.2} ({:.2} to {:.2})", measured.value, measured.low, measured.high)
}

/// Where targets stand beyond the usual one, in phase steps. What a scan scatters
/// by depends on it where the coarse stage wavers between two steps.
pub const POSITIONS: [f64; 4] = [0.0, 0.25, 0.5, 0.75];
/// The scan reaches this many chips to either side of the target.
const HALF_WINDOW_CHIPS: u64 = 3;
/// A standard deviation is compared only where this share of all scans is
/// within a chip of the target: elsewhere it is that of a selection.
const COMPARABLE_SHARE: f64 = 0.99;
/// The coarse stage wavers where scans scatter by more than this, in what they
/// would scatter by if it always stood at the step that it should.
const WAVERING: f64 = 1.1;
/// And where no fewer than this share of them stand at another step.
const WAVERING_SHARE: f64 = 0.01;

/// The scan of `scene` round a target `position` phase steps beyond the usual one,
/// with all light so much later.
pub fn at_position(mut scene: Scene, position: f64) -> Scene {
    let later_ps = position * CHIP_PERIOD_PS / f64::from(SAMPLES_PER_CHIP);
    for path in &mut scene.paths {
        path.delay_ps += later_ps;
    }
    window(scene, TARGET_PS + later_ps, HALF_WINDOW_CHIPS)
}

/// Standard deviation that the exact moments give for a coarse stage that stands
/// still, in metres.
pub fn steady_std_m(scene: &Scene) -> Result<f64, FigureError> {
    Ok(expected(scene)?.std_m)
}

/// Errors at one of [`POSITIONS`].
#[derive(Debug, Clone, Copy)]
pub struct PositionErrors {
    /// As simulated.
    pub errors: Errors,
    /// What scans would scatter by at one coarse step, in metres.
    pub steady_std_m: f64,
}

impl PositionErrors {
    /// Whether scans scatter because the coarse stage wavers between steps.
    pub fn wavers(&self) -> bool {
        self.errors.elsewhere.value >= WAVERING_SHARE
            && self.errors.std_m.low > WAVERING * self.steady_std_m
    }
}

/// Errors at one power.
#[derive(Debug, Clone)]
pub struct PowerPoint {
    /// Mean power of each source at the detector.
    pub power_pw: f64,
    /// At each of [`POSITIONS`].
    pub positions: Vec<PositionErrors>,
}

impl PowerPoint {
    /// From one of `shares` of the scans at each position.
    pub fn measure(
        run: &mut FigureScans,
        power_pw: f64,
        shares: u64,
        scene: impl Fn(f64) -> Scene,
    ) -> Result<PowerPoint, FigureError> {
        let positions = POSITIONS.iter().map(|&position| {
            let scene = at_position(scene(power_pw), position);
            Ok(PositionErrors {
                errors: run.share_of_errors(&scene, shares)?,
                steady_std_m: steady_std_m(&scene)?,
            })
        });
        Ok(PowerPoint { power_pw, positions: positions.collect::<Result<_, FigureError>>()? })
    }

    fn each<T>(&self, value: impl Fn(&Errors) -> T) -> Vec<T> {
        self.positions.iter().map(|p| value(&p.errors)).collect()
    }

    /// Standard deviation round the mean of each position: the root of their mean
    /// square, in metres.
    pub fn std_m(&self) -> Measured {
        root_mean_square(&self.each(|e| e.std_m))
    }

    /// Mean of the positions' biases, in metres.
    pub fn bias_m(&self) -> Measured {
        mean(&self.each(|e| e.bias_m))
    }

    /// Share of all scans within a chip of the target.
    pub fn correct_coarse(&self) -> Measured {
        let found = self.each(|e| e.found).iter().sum();
        rate(found, self.each(|e| e.scans).iter().sum())
    }

    /// Detections per second.
    pub fn detected_rate_cps(&self) -> f64 {
        self.each(|e| e.detected_rate_cps).iter().sum::<f64>() / self.positions.len() as f64
    }

    /// Whether the coarse stage wavers at any position.
    pub fn wavers(&self) -> bool {
        self.positions.iter().any(PositionErrors::wavers)
    }

    /// Whether its standard deviation is that of all scans.
    pub fn is_comparable(&self) -> bool {
        self.correct_coarse().value >= COMPARABLE_SHARE
    }
}

/// Errors at each of some powers.
pub struct ErrorCurve {
    /// Name of the series.
    pub label: String,
    /// By power.
    pub points: Vec<PowerPoint>,
}

impl ErrorCurve {
    /// `scene` gives the sensor for one power; the scans are shared among the
    /// positions.
    pub fn measure(
        run: &mut FigureScans,
        label: &str,
        powers_pw: &[f64],
        scene: impl Fn(f64) -> Scene,
    ) -> Result<ErrorCurve, FigureError> {
        let points = powers_pw
            .iter()
            .map(|&power_pw| PowerPoint::measure(run, power_pw, POSITIONS.len() as u64, &scene));
        Ok(ErrorCurve { label: label.to_owned(), points: points.collect::<Result<_, _>>()? })
    }

    /// Decibels by which this curve's standard deviation is above another's, at
    /// each power where both can be compared.
    pub fn decibels_above(&self, other: &ErrorCurve) -> Vec<(f64, Measured)> {
        let mut losses = Vec::new();
        for above in &self.points {
            let same_power = other.points.iter().find(|p| p.power_pw == above.power_pw);
            let below = same_power.filter(|p| p.is_comparable() && above.is_comparable());
            losses.extend(below.map(|p| (above.power_pw, decibels(above.std_m(), p.std_m()))));
        }
        losses
    }

    /// The power at which comparable scans scatter least; the last one, if none are
    /// comparable.
    pub fn best(&self) -> Option<&PowerPoint> {
        let comparable = self.points.iter().filter(|p| p.is_comparable());
        comparable.min_by(|a, b| a.std_m().value.total_cmp(&b.std_m().value)).or(self.points.last())
    }
}

/// The data of curves: a row for each power and position.
pub fn table(curves: &[ErrorCurve]) -> Table {
    let rows = curves.iter().flat_map(|curve| {
        curve.points.iter().flat_map(|point| {
            let positions = POSITIONS.iter().zip(&point.positions);
            positions.map(|(position, at)| (&curve.label, point.power_pw, *position, at))
        })
    });
    let rows: Vec<(&String, f64, f64, &PositionErrors)> = rows.collect();
    Table::of(&rows)
        .column("series", |row| row.0.as_str())
        .column("power_pw", |row| row.1)
        .column("position_steps", |row| row.2)
        .column("detected_rate_cps", |row| row.3.errors.detected_rate_cps)
        .interval("std_m", |row| row.3.errors.std_m)
        .column("one_step_std_m", |row| row.3.steady_std_m)
        .interval("bias_m", |row| row.3.errors.bias_m)
        .interval("correct_coarse", |row| row.3.errors.correct_coarse())
        .interval("other_step", |row| row.3.errors.elsewhere)
        .column("wavers", |row| u32::from(row.3.wavers()))
        .table()
}

/// A panel over powers.
pub fn panel(power_label: &str, y: ChartAxis) -> Panel {
    Panel::new(ChartAxis::log("power_pw", power_label), y)
}

/// Standard deviations over all positions, with rings where the coarse stage wavers, and
/// biases, each the mean over all positions.
pub fn panels(power_label: &str, curves: &[ErrorCurve]) -> [Panel; 2] {
    let rows = curves.iter().flat_map(|curve| curve.points.iter().map(|at| (&curve.label, at)));
    let rows: Vec<(&String, &PowerPoint)> = rows.collect();
    let drawn = Table::of(&rows)
        .column("series", |(label, _)| label.as_str())
        .column("power_pw", |(_, point)| point.power_pw)
        .interval("std_m", |(_, point)| point.std_m())
        .interval("bias_m", |(_, point)| point.bias_m())
        .column("wavers", |(_, point)| u32::from(point.wavers()))
        .table();
    let std = panel(power_label, ChartAxis::log("std_m", "standard deviation (mm)"));
    let bias = panel(power_label, ChartAxis::linear("bias_m", "bias (mm)"));
    [ringed(std.curves(&drawn, Mark::LineAndDots), &drawn), bias.curves(&drawn, Mark::LineAndDots)]
}

/// One curve's standard deviations position by position, with rings where the
/// coarse stage wavers, and lines at some limits.
pub fn positions_panel(power_label: &str, curve: &ErrorCurve, limits_mm: &[f64]) -> Panel {
    let drawn = table(std::slice::from_ref(curve)).named(|table, row| {
        let position = table.value(row, "position_steps").text();
        format!("{}, target + {position} T_s", row.name)
    });
    let y = ChartAxis::log("std_m", "standard deviation (mm), by position of the target");
    let mut panel = panel(power_label, y).curves(&drawn, Mark::LineAndDots);
    for limit_mm in limits_mm {
        panel = panel.level(&format!("{limit_mm} mm"), *limit_mm);
    }
    ringed(panel, &drawn)
}

/// Adds rings where the coarse stage wavers.
fn ringed(panel: Panel, drawn: &Table) -> Panel {
    let wavers = drawn.only(|table, row| table.value(row, "wavers").number() == Some(1.0));
    panel.curves(&wavers.named(|_, _| "coarse stage wavers".to_owned()), Mark::Rings)
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// Scans that scatter by so much at every position.
    fn position(std_m: f64, steady_std_m: f64, elsewhere: u64) -> PositionErrors {
        PositionErrors {
            errors: Errors {
                std_m: Measured::normal(std_m, 0.01 * std_m),
                bias_m: Measured::normal(0.0, 1e-6),
                found: 1000,
                scans: 1000,
                elsewhere: rate(elsewhere, 1000),
                detected_rate_cps: 1e6,
            },
            steady_std_m,
        }
    }

    pub fn curve(std_m: f64) -> ErrorCurve {
        let point = |power_pw| PowerPoint {
            power_pw,
            positions: vec![position(std_m, std_m, 0); POSITIONS.len()],
        };
        ErrorCurve {
            label: String::new(),
            points: [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0].map(point).into(),
        }
    }

    #[test]
    fn a_coarse_stage_wavers_where_scans_at_other_steps_widen_the_scatter() {
        assert!(position(2.0, 1.0, 300).wavers());
        // As many at other steps, which say the same.
        assert!(!position(1.0, 1.0, 300).wavers());
        // Wide for another reason.
        assert!(!position(2.0, 1.0, 0).wavers());
    }

    #[test]
    fn scans_that_miss_the_target_are_not_compared() {
        let (mut above, below) = (curve(2.0), curve(1.0));
        assert_eq!(above.decibels_above(&below).len(), 8);
        for position in &mut above.points[0].positions {
            position.errors.found = 980;
        }
        let losses = above.decibels_above(&below);
        assert_eq!(losses.len(), 7);
        assert!((losses[0].1.value - 3.0103).abs() < 1e-4);
        assert_eq!(above.best().map(|p| p.power_pw), Some(1.0));
    }
}
