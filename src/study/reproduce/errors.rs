//! Errors that the article leaves out: range walk and interference bias, by both estimators, and
//! failures of the search over a whole code period at low light.

use std::sync::Arc;

use super::extremes::Candidates;
use super::prelude::*;

/// Integration time of the phase estimator's biases.
const INTEGRATION_S: f64 = 1.04e-3;
/// Phase steps within this many chips of the target are scanned.
const HALF_WINDOW_CHIPS: u64 = 3;

/// Bias against light level, for three codes.
pub fn range_walk(run: &mut FigureScans) -> Result<Figure, FigureError> {
    /// Powers in picowatts are so many factors of two above half a picowatt.
    const OCTAVES: i32 = 8;
    let by_model = ByModel { tier: Tier::Events, scans: (run.repetitions() / 2).max(2) };
    let power_pw = |octaves: f64| 0.5 * octaves.exp2();
    let fine: Vec<f64> = (0..=4 * OCTAVES).map(|i| power_pw(f64::from(i) / 4.0)).collect();
    let coarse: Vec<f64> = (0..=OCTAVES).map(|i| power_pw(f64::from(i))).collect();
    let codes = [
        ("Gold code", balanced_gold(0, 0)?),
        ("interleaved once", balanced_gold(0, 1)?),
        ("square wave", square()?),
    ];
    let mut biases = Vec::new();
    for (label, code) in &codes {
        let scene = |power_pw: f64, integration_s: f64| {
            let scene = sensor(&[PathLight::new(code, power_pw)], integration_s);
            window(scene, TARGET_PS, HALF_WINDOW_CHIPS)
        };
        let bias = Bias::of_phase(run, label, &fine, &coarse, |p| scene(p, INTEGRATION_S))?;
        // A bias of tenths of a millimetre needs many photons at every level: as
        // many as ten times the usual integration has at the usual power.
        let equal_light = |p: f64| scene(p, 10.0 * INTEGRATION_S * (POWER_PW / p).max(0.1));
        biases.push(bias.and_model(run, by_model, &coarse, equal_light)?);
    }
    let frame = Frame {
        title: "Range walk: bias of the distance against the light level",
        x: ChartAxis::log("power_pw", "optical power at the detector (pW)"),
        limit_mm: 0.5,
    };
    Ok(figure(frame, &biases))
}

/// Bias against the delay of another code's light relative to the target's.
pub fn interference(run: &mut FigureScans) -> Result<Figure, FigureError> {
    /// Whole scans by single detections would take an hour.
    const BY_MODEL: ByModel = ByModel { tier: Tier::Counts, scans: 16 };
    let fine: Vec<f64> = (0..=64).map(|i| f64::from(i) / 2.0).collect();
    let coarse: Vec<f64> = (0..=8).map(|i| 4.0 * f64::from(i)).collect();
    let (own, other) = (balanced_gold(0, 0)?, balanced_gold(1, 0)?);
    let both = |chips: f64, integration_s: f64| {
        let later = TARGET_PS + chips * CHIP_PERIOD_PS;
        let lights = [PathLight::new(&own, POWER_PW), PathLight::new(&other, POWER_PW).at(later)];
        sensor(&lights, integration_s)
    };
    let bias = Bias::of_phase(run, "second Gold code", &fine, &coarse, |chips| {
        window(both(chips, INTEGRATION_S), TARGET_PS, HALF_WINDOW_CHIPS)
    })?
    .and_model(run, BY_MODEL, &coarse, |chips| both(chips, 100.0 * INTEGRATION_S))?;
    // The same light without modulation moves the mean as well: that is walk.
    let alone = Bias::of_phase(run, "no second source", &[0.0, 32.0], &[], |_| {
        let scene = sensor(&[PathLight::new(&own, POWER_PW)], INTEGRATION_S);
        window(scene, TARGET_PS, HALF_WINDOW_CHIPS)
    })?;
    let frame = Frame {
        title: "Interference: bias of the distance with another code of equal power, 4 pW each",
        x: ChartAxis::linear(
            "relative_delay_chips",
            "delay of the second source relative to the target's light (chips)",
        ),
        limit_mm: 1.0,
    };
    let mut figure = figure(frame, &[bias, alone]);
    let (table, panel, note) = all_delays(&own, &other)?;
    figure.table.append(table);
    figure.chart.panels.push(panel);
    figure.notes.push(note);
    Ok(figure)
}

/// Peak to peak of the phase estimator's bias over all relative delays, against the
/// light level; rows for the table, and the largest in words.
fn all_delays(own: &Arc<Code>, other: &Arc<Code>) -> Result<(Table, Panel, String), FigureError> {
    const POWERS_PW: [f64; 9] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0];
    let candidates = Candidates::of(own, other);
    let mut rows = Vec::new();
    let mut ranges_mm = Vec::new();
    let mut texts = Vec::new();
    for power_pw in POWERS_PW {
        let [least, most] = candidates.extremes(own, other, power_pw, INTEGRATION_S)?;
        rows.extend([("least", power_pw, least), ("largest", power_pw, most)]);
        let range_mm = 1e3 * (most.bias_m - least.bias_m);
        ranges_mm.push((power_pw, range_mm));
        texts.push(format!(
            "{range_mm:.1} at {power_pw} ({:.1} at {} chips to {:.1} at {} chips)",
            1e3 * least.bias_m,
            least.relative_delay_chips,
            1e3 * most.bias_m,
            most.relative_delay_chips,
        ));
    }
    let note = format!(
        "bias of the phase estimator over all relative delays of whole phase steps, peak to peak \
         in mm by power of each source in pW (exact at those 8 delays to either side that move a \
         linear detector's estimate most): {}",
        texts.join(", ")
    );
    let table = Table::of(&rows)
        .column("series", |(end, power_pw, _)| {
            format!("{end} of all delays, {power_pw} pW each, phase, exact")
        })
        .column("relative_delay_chips", |(.., end)| end.relative_delay_chips)
        .column("bias_m", |(.., end)| end.bias_m);
    let panel = Panel::new(
        ChartAxis::log("", "optical power at the detector, of each source (pW)"),
        ChartAxis::linear("", "phase estimator's bias over all delays, peak to peak (mm)"),
    );
    Ok((
        table.table(),
        panel.with("exact", DrawingRole::Expected, Mark::LineAndDots, ranges_mm),
        note,
    ))
}

/// How the model estimator's bias is simulated.
#[derive(Debug, Clone, Copy)]
pub struct ByModel {
    /// By which tier.
    pub tier: Tier,
    /// Scans behind each point.
    pub scans: u64,
}

/// A bias at points of one quantity: name of the series, x, and the bias in metres with its
/// interval.
pub struct Bias {
    label: String,
    rows: Vec<(String, f64, [Option<f64>; 3])>,
}

impl Bias {
    /// The phase estimator's bias, exact for each of `fine`, simulated for each of
    /// `coarse`; `scene` gives the scene for one value of x.
    pub fn of_phase(
        run: &mut FigureScans,
        label: &str,
        fine: &[f64],
        coarse: &[f64],
        scene: impl Fn(f64) -> Scene,
    ) -> Result<Bias, FigureError> {
        let mut bias = Bias { label: label.to_owned(), rows: Vec::new() };
        for &x in fine {
            bias.push(PHASE_EXACT, x, expected(&scene(x))?.bias_m);
        }
        for &x in coarse {
            bias.push(PHASE, x, run.errors(&scene(x))?.bias_m);
        }
        Ok(bias)
    }

    /// Adds the model estimator's bias for each of `coarse`.
    pub fn and_model(
        mut self,
        run: &mut FigureScans,
        by: ByModel,
        coarse: &[f64],
        scene: impl Fn(f64) -> Scene,
    ) -> Result<Bias, FigureError> {
        for &x in coarse {
            let scene = Scene { estimator: EstimatorKind::Model, ..scene(x) };
            self.push(MODEL, x, run.fitted_bias_m(&scene, by.tier, by.scans)?);
        }
        Ok(self)
    }

    fn push(&mut self, kind: &str, x: f64, bias_m: impl WithInterval) {
        self.rows.push((self.label.clone() + kind, x, bias_m.spread()));
    }
}

/// What a figure of biases says beside its data.
pub struct Frame<'a> {
    pub title: &'a str,
    pub x: ChartAxis,
    /// What the model estimator's bias is to stay below, in millimetres.
    pub limit_mm: f64,
}

/// The phase's biases to the left, the model's to the right.
pub fn figure(frame: Frame, biases: &[Bias]) -> Figure {
    let rows: Vec<_> = biases.iter().flat_map(|bias| &bias.rows).collect();
    let table = Table::of(&rows)
        .column("series", |row| row.0.as_str())
        .column(&frame.x.column, |row| row.1)
        .interval("bias_m", |row| row.2)
        .table();
    let part = |kind: &str| {
        let of_kind = table.only(|_, row| row.name.ends_with(kind));
        of_kind.named(|_, row| row.name.trim_end_matches(kind).to_owned())
    };
    let panel = |label: &str| Panel::new(frame.x.clone(), ChartAxis::linear("bias_m", label));
    let panels = vec![
        panel("bias of the phase estimator (mm); lines: exact")
            .curves(&part(PHASE_EXACT), Mark::Line)
            .curves(&part(PHASE), Mark::Dots),
        panel("bias of the model estimator (mm)")
            .curves(&part(MODEL), Mark::Dots)
            .limits(frame.limit_mm, "mm"),
    ];
    Figure::new(frame.title, table, panels)
}

/// What follows a bias's label in the name of its series.
const PHASE_EXACT: &str = ", phase, exact";
const PHASE: &str = ", phase, simulated";
const MODEL: &str = ", model, simulated";

/// How often the estimate of a whole code period is more than a chip off.
pub fn coarse_search(run: &mut FigureScans) -> Result<Figure, FigureError> {
    const POWERS_PW: [f64; 9] = [0.025, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8];
    const INTEGRATION_S: f64 = 104.8e-6;
    let mut rows = Vec::new();
    for (estimator, name) in [
        (EstimatorKind::Fft, "largest count (phase)"),
        (EstimatorKind::Model, "all counts (model)"),
    ] {
        for nu in 0..=1 {
            let code = balanced_gold(0, nu)?;
            for power_pw in POWERS_PW {
                let mut scene = sensor(&[PathLight::new(&code, power_pw)], INTEGRATION_S);
                scene.estimator = estimator;
                scene.other_light = OtherLight::None;
                let failures = run.search(&scene)?.complement();
                rows.push((format!("ν = {nu}, {name}"), power_pw, failures));
            }
        }
    }
    let table = Table::of(&rows)
        .column("series", |row| row.0.as_str())
        .column("power_pw", |row| row.1)
        .interval("failures", |row| row.2)
        .table();
    let panel = Panel::new(
        ChartAxis::log("power_pw", "optical power at the detector (pW)"),
        ChartAxis::linear("failures", "share of scans that miss the target"),
    );
    let title = "Global coarse search: failures at low light, 104.8 µs per phase step";
    let panel = panel.curves(&table, Mark::LineAndDots);
    Ok(Figure::new(title, table, vec![panel]))
}
