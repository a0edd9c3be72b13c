//! Errors that the article leaves out, simulated beside their theory: dead-time
//! walk, interference bias, failures of the global coarse search.

use super::figure::{Figure, Table, cells};
use super::run::{Run, RunError};
use super::sensor::{CHIP_PERIOD_PS, Light, POWER_PW, TARGET_PS, gold, sensor, square, window};
use super::statistics::Measured;
use crate::estimate::{CountingTier, predict};
use crate::report::chart::{Axis, Chart, Legend, Mark, Panel, Point, Scale, Series};
use crate::scene::Scene;

/// Integration time of biases.
const INTEGRATION_S: f64 = 1.04e-3;
/// Phase steps within this many chips of the target are scanned.
const HALF_WINDOW_CHIPS: u64 = 3;

/// Simulated points and the exact curve of one bias. The curve is that of the
/// sampled correlator, whose edges do not differ in delay: rising and falling
/// edges 50 ps apart move the simulated points by a millimetre or two.
struct Bias {
    label: String,
    /// x, bias in metres.
    theory: Vec<(f64, f64)>,
    /// x, bias in metres.
    simulated: Vec<(f64, Measured)>,
}

impl Bias {
    /// `scene` gives the scene for one value of x; exact for each of `fine`,
    /// simulated for each of `coarse`.
    fn measure(
        run: &mut Run,
        label: &str,
        fine: &[f64],
        coarse: &[f64],
        scene: impl Fn(f64) -> Scene,
    ) -> Result<Bias, RunError> {
        let theory = fine
            .iter()
            .map(|&x| Ok((x, predict(&scene(x), 0, 0, CountingTier::Sampled)?.bias_m)))
            .collect::<Result<_, RunError>>()?;
        let simulated = coarse
            .iter()
            .map(|&x| Ok((x, run.errors(&scene(x))?.bias_m)))
            .collect::<Result<_, RunError>>()?;
        Ok(Bias {
            label: label.to_owned(),
            theory,
            simulated,
        })
    }

    fn series(&self, colour: usize) -> [Series; 2] {
        let millimetres = |m: f64| m * 1e3;
        let theory = self
            .theory
            .iter()
            .map(|&(x, y)| Point::new(x, millimetres(y)));
        let simulated = self.simulated.iter().map(|(x, bias)| {
            let bias = bias.scaled(1e3);
            Point {
                x: *x,
                y: bias.value,
                interval: Some((bias.low, bias.high)),
            }
        });
        [
            Series {
                label: format!("{}, exact mean counts", self.label),
                mark: Mark::Line,
                colour,
                points: theory.collect(),
            },
            Series {
                label: format!("{}, simulated", self.label),
                mark: Mark::Dots,
                colour,
                points: simulated.collect(),
            },
        ]
    }
}

fn figure(
    title: &str,
    x: Axis,
    x_column: &str,
    (legend, headroom): (Legend, f64),
    biases: &[Bias],
) -> Figure {
    let columns = ["series", x_column, "bias_m", "bias_low_m", "bias_high_m"];
    let mut table = Table::new(&columns);
    for bias in biases {
        for &(x, y) in &bias.theory {
            let series = format!("{} exact", bias.label);
            table.row(&series, &[Some(x), Some(y), None, None]);
        }
        for &(x, y) in &bias.simulated {
            let mut row = vec![Some(x)];
            row.extend(cells(y));
            table.row(&format!("{} simulated", bias.label), &row);
        }
    }
    let panel = Panel {
        x,
        y: Axis {
            label: "bias of the distance (mm)".to_owned(),
            scale: Scale::Linear,
        },
        series: biases
            .iter()
            .enumerate()
            .flat_map(|(number, bias)| bias.series(number))
            .collect(),
        legend,
        headroom,
    };
    Figure {
        chart: Chart {
            title: title.to_owned(),
            panels: vec![panel],
        },
        table,
        claims: Vec::new(),
    }
}

/// Bias against light level, for three codes.
pub fn dead_time_walk(run: &mut Run) -> Result<Figure, RunError> {
    let fine: Vec<f64> = (0..=28)
        .map(|i| 0.5 * 2f64.powf(f64::from(i) / 4.0))
        .collect();
    let coarse: Vec<f64> = (0..=7).map(|i| 0.5 * f64::from(1 << i)).collect();
    let codes = [
        ("Gold code", gold(0, 0)?),
        ("interleaved once", gold(0, 1)?),
        ("square wave", square()?),
    ];
    let mut biases = Vec::new();
    for (label, code) in &codes {
        biases.push(Bias::measure(run, label, &fine, &coarse, |power_pw| {
            let scene = sensor(&[Light::new(code, power_pw)], INTEGRATION_S);
            window(scene, TARGET_PS, HALF_WINDOW_CHIPS)
        })?);
    }
    let x = Axis {
        label: "optical power at the detector (pW)".to_owned(),
        scale: Scale::Log,
    };
    let title = "Dead-time walk: the phase estimate moves with the light level";
    Ok(figure(
        title,
        x,
        "power_pw",
        (Legend::LowerLeft, 0.06),
        &biases,
    ))
}

/// Bias against the delay of another code's light relative to the target's.
pub fn interference(run: &mut Run) -> Result<Figure, RunError> {
    let fine: Vec<f64> = (0..=64).map(|i| f64::from(i) / 2.0).collect();
    let coarse: Vec<f64> = (0..=8).map(|i| 4.0 * f64::from(i)).collect();
    let (own, other) = (gold(0, 0)?, gold(2, 0)?);
    let relative = |chips: f64| TARGET_PS + chips * CHIP_PERIOD_PS;
    let bias = Bias::measure(run, "second Gold code", &fine, &coarse, |chips| {
        let lights = [
            Light::new(&own, POWER_PW),
            Light::new(&other, POWER_PW).at(relative(chips)),
        ];
        window(sensor(&lights, INTEGRATION_S), TARGET_PS, HALF_WINDOW_CHIPS)
    })?;
    // The same light without modulation moves the mean as well: that is walk.
    let alone = Bias::measure(run, "no second source", &[0.0, 32.0], &[], |_| {
        let scene = sensor(&[Light::new(&own, POWER_PW)], INTEGRATION_S);
        window(scene, TARGET_PS, HALF_WINDOW_CHIPS)
    })?;
    let x = Axis {
        label: "delay of the second source relative to the target's light (chips)".to_owned(),
        scale: Scale::Linear,
    };
    let title = "Interference bias: another code of equal power, 4 pW each, 1.04 ms";
    let biases = [bias, alone];
    Ok(figure(
        title,
        x,
        "relative_delay_chips",
        (Legend::UpperLeft, 0.35),
        &biases,
    ))
}

/// How often the largest count of a whole code period is not the target's.
pub fn coarse_search(run: &mut Run) -> Result<Figure, RunError> {
    const POWERS_PW: [f64; 8] = [0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8];
    let mut table = Table::new(&[
        "series",
        "power_pw",
        "failures",
        "failures_low",
        "failures_high",
    ]);
    let mut series = Vec::new();
    for nu in 0..=1 {
        let code = gold(0, nu)?;
        let label = format!("ν = {nu}, {} phase steps", 8 * code.len());
        let mut points = Vec::new();
        for power_pw in POWERS_PW {
            let found = run.search(&sensor(&[Light::new(&code, power_pw)], 104.8e-6))?;
            let failed = Measured {
                value: 1.0 - found.value,
                low: 1.0 - found.high,
                high: 1.0 - found.low,
            };
            let mut row = vec![Some(power_pw)];
            row.extend(cells(failed));
            table.row(&label, &row);
            points.push(Point {
                x: power_pw,
                y: failed.value,
                interval: Some((failed.low, failed.high)),
            });
        }
        series.push(Series {
            label,
            mark: Mark::LineAndDots,
            colour: nu as usize,
            points,
        });
    }
    let panel = Panel {
        x: Axis {
            label: "optical power at the detector (pW)".to_owned(),
            scale: Scale::Log,
        },
        y: Axis {
            label: "share of scans that miss the target".to_owned(),
            scale: Scale::Linear,
        },
        series,
        legend: Legend::UpperRight,
        headroom: 0.06,
    };
    Ok(Figure {
        chart: Chart {
            title: "Global coarse search: failures at low light, 104.8 µs per phase step"
                .to_owned(),
            panels: vec![panel],
        },
        table,
        claims: Vec::new(),
    })
}
