//! What longer integration gains, and what longer simulation does.

use serde::{Deserialize, Serialize};

use super::prelude::*;
use crate::cosim;
use crate::estimate::bound::{BoundKind, bound_m};
use crate::estimate::report::{ExpectedOfPath, Reporter};
use crate::estimate::{CountingTier, Theory, TheoryEffort, Work, theory, theory_of_integrations};
use crate::scene::PathIndex;
use crate::simulate::{Tier, forecast};

/// Integration times, in powers of four of the scene's.
const POWERS: std::ops::RangeInclusive<i32> = -2..=2;
/// All points together take no longer.
const MOST_SECONDS: f64 = 2.0;
/// Scans of the longest simulation.
const MOST_SCANS: i32 = 5;

/// What theory expects of a path's distance at shorter and longer integration times. It
/// asks for nothing that a run finds, and can be worked out beside it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct IntegrationCurves {
    detector: DetectorIndex,
    path: PathIndex,
    points: Result<Points, String>,
    /// At the scene's own integration time.
    here: Option<Theory>,
    /// What is expected of the model estimator there.
    fit: Option<ExpectedOfPath>,
}

/// Pairs of integration time in us and error in mm.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Points {
    /// Bias and scatter of the phase.
    rms: Vec<(f64, f64)>,
    /// Its scatter alone.
    scatter: Vec<(f64, f64)>,
    /// The bound.
    bound: Vec<(f64, f64)>,
    /// What it is, of points of both kinds what it is at either.
    kind: Option<BoundKind>,
}

impl IntegrationCurves {
    /// Those of every detector's first path from its own source.
    pub fn of_first_paths(sensor: &Sensor) -> Vec<IntegrationCurves> {
        let scene = sensor.scene();
        let of_detector = |detector: DetectorIndex| {
            let path = scene.own_paths(detector).next()?;
            Some(IntegrationCurves::of(sensor, detector, path).with_fit(sensor))
        };
        DetectorIndex::of(&scene.detectors).filter_map(of_detector).collect()
    }

    /// Those of one path.
    pub(super) fn of(
        sensor: &Sensor,
        detector: DetectorIndex,
        path: PathIndex,
    ) -> IntegrationCurves {
        let (points, here) = match Points::of(sensor, detector, path) {
            Ok((points, here)) => (Ok(points), here),
            // Estimates are held against it all the same.
            Err(reason) => {
                (Err(reason), Some(theory(sensor, detector, &[path], CountingTier::Sampled)))
            }
        };
        IntegrationCurves { detector, path, points, here, fit: None }
    }

    /// With what is expected of the model estimator, where there is a theory.
    fn with_fit(mut self, sensor: &Sensor) -> IntegrationCurves {
        self.fit = self.here.as_ref().map(|theory| {
            let sensor = sensor.estimated_by(EstimatorKind::Model);
            let reporter = Reporter::new(&sensor, self.detector).knowing(self.path, theory.clone());
            reporter.expectation(self.path, are_of_steps(&sensor)).clone()
        });
        self
    }

    /// The same estimates' [`Reporter`], which need not work out again what the curves are made from.
    pub fn reporter<'s>(
        curves: &[IntegrationCurves],
        sensor: &'s Sensor,
        detector: DetectorIndex,
    ) -> Reporter<'s> {
        let mut reporter = Reporter::new(sensor, detector);
        for curves in curves.iter().filter(|curves| curves.detector == detector) {
            if let Some(theory) = &curves.here {
                reporter = reporter.knowing(curves.path, theory.clone());
            }
            let is_fit = sensor.scene().estimator == EstimatorKind::Model;
            if let Some(expected) = curves.fit.as_ref().filter(|_| is_fit) {
                let of_steps = are_of_steps(sensor);
                reporter = reporter.expecting(curves.path, of_steps, expected.clone());
            }
        }
        reporter
    }

    /// Whether they are a path's at a detector.
    pub(super) fn are_of(&self, detector: DetectorIndex, path: PathIndex) -> bool {
        (self.detector, self.path) == (detector, path)
    }
}

/// Whether estimates are of phase steps' counts.
fn are_of_steps(sensor: &Sensor) -> bool {
    sensor.interface().histogram().is_none()
}

impl Points {
    /// And the theory of the scene as it is.
    fn of(
        sensor: &Sensor,
        detector: DetectorIndex,
        path: PathIndex,
    ) -> Result<(Points, Option<Theory>), String> {
        let effort = TheoryEffort::of(sensor, detector).map_err(|reason| reason.to_string())?;
        let points = POWERS.count() as f64;
        let seconds = points * (effort.seconds(Work::Predictions(1)) + effort.seconds(Work::Bound));
        if seconds > MOST_SECONDS {
            return Err(format!("it would take {seconds:.0} s"));
        }
        let chips = sensor.timing().scan.integration_chips;
        // Counts keep to the widths that a scene may have.
        let chips = POWERS
            .map(|power| (chips as f64 * 4f64.powi(power)).round())
            .filter(|chips| (1.0..1e12).contains(chips));
        let chips: Vec<u64> = chips.map(|chips| chips as u64).collect();
        let tier = CountingTier::Sampled;
        let (mut points, mut here) = (Points::default(), None);
        for (at, theory) in theory_of_integrations(sensor, detector, &[path], tier, &chips) {
            let x = at.timing().integration_ps() * 1e-6;
            if let Some(Ok(phase)) = theory.predictions.first() {
                let rms_m = phase.bias_m.hypot(phase.std_m);
                points.rms.push((x, rms_m * 1e3));
                points.scatter.push((x, phase.std_m * 1e3));
            }
            let bound = bound_m(&at, path, tier, &theory.bound);
            if let Ok((bound_m, kind)) = bound {
                points.bound.push((x, bound_m * 1e3));
                points.kind = points.kind.max(Some(kind));
            }
            if at.timing() == sensor.timing() {
                here = Some(theory);
            }
        }
        match points.rms.is_empty() && points.bound.is_empty() {
            true => Err("theory expects nothing of this light".to_owned()),
            false => Ok((points, here)),
        }
    }
}

/// The error of a detector's distance against the integration time of what is measured at
/// once, a phase step or a histogram, as theory expects it. One run's error is not a mean of squares, and
/// has no place among them.
///
/// # Errors
/// Why it is not known.
pub(super) fn integration(sensor: &Sensor, curves: IntegrationCurves) -> Result<SvgFigure, String> {
    let detector = curves.detector;
    let Points { rms, scatter, bound, kind } = curves.points?;
    let here = sensor.timing().integration_ps() * 1e-6;
    let (of_what, along) = match sensor.interface().histogram() {
        Some(_) => ("a histogram", "integration time of a histogram (\u{b5}s)"),
        None => ("a phase step", "integration time of a phase step (\u{b5}s)"),
    };
    let detectors = &sensor.scene().detectors;
    let title = match detectors.len() {
        1 => "Error against integration time".to_owned(),
        _ => format!("Error against integration time, {}", detectors[detector].name),
    };
    let description = format!(
        "Expected error of one distance against the integration time of {of_what}, both axes \
         logarithmic. {}",
        words(&rms, &bound, here)
    );
    let fit = format!("model fit, {}", kind.unwrap_or(BoundKind::CramerRao).name());
    let panel = Panel::new(ChartAxis::log("", along), ChartAxis::log("", "error (mm)"))
        .with("phase, bias and scatter", DrawingRole::Phase, Mark::LineAndDots, rms)
        .with("phase, scatter alone", DrawingRole::Expected, Mark::LineAndDots, scatter)
        .with(&fit, DrawingRole::Bound, Mark::LineAndDots, bound);
    Ok(panel.figure(format!("integration-{detector}"), title, description))
}

fn words(rms: &[(f64, f64)], bound: &[(f64, f64)], here: f64) -> String {
    let at = |curve: &[(f64, f64)]| {
        let nearest = curve.iter().min_by(|a, b| (a.0 - here).abs().total_cmp(&(b.0 - here).abs()));
        nearest.map(|point| point.1)
    };
    match (at(rms), at(bound)) {
        (Some(rms), Some(bound)) => format!(
            "At {here:.1} \u{b5}s the phase estimator's is {rms:.2} mm, the model fit's {bound:.2} mm; \
             the phase's does not fall below its bias."
        ),
        _ => String::new(),
    }
}

/// How well a simulation knows the mean error after so long: its standard error against
/// run time, tier by tier. The Verilog's speed is that of this run.
pub(super) fn run_time(sensor: &Sensor, cosim: &cosim::Report, std_m: f64) -> Option<SvgFigure> {
    // What photons take, whatever becomes of their counts.
    let sensor = &sensor.estimated_by(EstimatorKind::Fft);
    let verilog_s = cosim.clocks as f64 / cosim.clocks_per_s;
    let is_timed = cosim.clocks_per_s > 0.0 && cosim.verdict == cosim::Verdict::Match;
    let tiers = [
        (
            "events (continuous time)",
            DrawingRole::Other(0),
            forecast::seconds(sensor, Tier::Events, 1),
        ),
        ("sampled", DrawingRole::Other(1), forecast::seconds(sensor, Tier::Sampled, 1)),
        ("Verilog (this run)", DrawingRole::Other(2), is_timed.then_some(verilog_s)),
    ];
    let mut panel = Panel::new(
        ChartAxis::log("", "run time (s)"),
        ChartAxis::log("", "standard error of the bias (mm)"),
    );
    let mut told = Vec::new();
    for (name, role, scan_s) in tiers {
        let Some(scan_s) = scan_s else { continue };
        let scans = (0..=MOST_SCANS).map(|decade| 10f64.powi(decade));
        let points = scans.map(|scans| (scans * scan_s, std_m / scans.sqrt() * 1e3));
        panel = panel.with(name, role, Mark::LineAndDots, points);
        told.push(format!("{name}: one scan takes {scan_s:.2e} s"));
    }
    let description = format!(
        "Standard error of the simulated mean against the time that simulating takes on this \
         machine, for 1 to 100,000 scans, both axes logarithmic. {}.",
        told.join("; ")
    );
    let title = "Simulated bias: error against run time".to_owned();
    (!told.is_empty()).then(|| panel.figure("run-time".to_owned(), title, description))
}
