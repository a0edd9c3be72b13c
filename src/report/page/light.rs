//! Light, counts, and what more of either gains.

use rayon::prelude::*;

use super::{Page, table};
use crate::photons::StepCount;
use crate::plan::link::link_budget;
use crate::recorded::{RecordedScan, against_scene, histogram_against_scene};
use crate::report::chart::decimate;
use crate::report::curves::{self, IntegrationCurves};
use crate::report::plan::{LINK_HEADINGS, link};
use crate::report::prelude::*;
use crate::report::residuals::Residuals;
use crate::report::{DetectorCounts, geometry, offsets};
use crate::scene::PathIndex;

/// Chips on either side of the largest count in the zoom.
const ZOOM_CHIPS: usize = 4;

/// Bins, and residuals, that are shown at most.
const BINS_SHOWN: usize = 200;
const RESIDUALS_SHOWN: usize = 400;

/// Detectors of more than this have what is alike in all of them folded away.
const MOST_UNFOLDED: usize = 4;

pub(super) fn section(page: &Page) -> Markup {
    let budgets = link(&link_budget(page.sensor));
    let of_detectors: Vec<OfDetector> =
        page.counts.par_iter().filter_map(|counts| OfDetector::of(page, counts)).collect();
    let is_folded = page.counts.len() > MOST_UNFOLDED;
    let unknown = of_detectors.iter().filter_map(|of| Some((&of.name, of.unknown.as_ref()?)));
    html! {
        div.figures {
            (geometry::figure(page.sensor.scene()).markup())
            @for of_detector in &of_detectors {
                @if !is_folded { (of_detector.whole.markup()) }
                @for figure in &of_detector.near { (figure.markup()) }
            }
        }
        @for (name, reason) in unknown {
            p.soft { "Expected counts of " (name) ": not known, " (reason) "." }
        }
        @if is_folded {
            (folded("Counts of all phase steps", of_detectors.iter().map(|of| &of.whole)))
        }
        @if !budgets.is_empty() {
            h3 { "Photons per second" }
            (table(&LINK_HEADINGS, &budgets))
        }
    }
}

/// Figures that are there for those who ask for them.
fn folded<'f>(summary: &str, figures: impl Iterator<Item = &'f SvgFigure>) -> Markup {
    html! {
        details {
            summary { (summary) ", detector by detector" }
            div.figures { @for figure in figures { (figure.markup()) } }
        }
    }
}

/// (distance, count) in order of distance, also for a window that wraps round the
/// code period.
fn points(counts: &DetectorCounts) -> Vec<(f64, f64)> {
    let values = counts.counts.iter().map(|&count| count as f64);
    let mut points: Vec<(f64, f64)> = counts.distances_m.iter().copied().zip(values).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// A detector's figures.
struct OfDetector {
    name: String,
    /// All counts.
    whole: SvgFigure,
    /// Those round the largest over what is expected, what is left, and bins of a histogram.
    near: Vec<SvgFigure>,
    /// Why nothing is expected.
    unknown: Option<String>,
}

impl OfDetector {
    fn of(page: &Page, counts: &DetectorCounts) -> Option<OfDetector> {
        let points = points(counts);
        let peak = (0..points.len()).max_by(|&a, &b| points[a].1.total_cmp(&points[b].1))?;
        let half = ZOOM_CHIPS * page.sensor.clock().samples_per_chip as usize;
        let near = &points[peak.saturating_sub(half)..(peak + half + 1).min(points.len())];
        let (from, to) = (near.first()?.0, near.last()?.0);
        let name = page.sensor.scene().detectors[counts.detector].name.clone();
        let id = |part: &str| format!("counts-{}-{part}", counts.detector);
        let panel =
            |mark, points: Vec<(f64, f64)>| {
                Panel::new(ChartAxis::linear("", "distance (m)"), ChartAxis::linear("", "count"))
                    .with("", DrawingRole::Counts, mark, points)
            };
        let whole = panel(Mark::Line, decimate(&points)).figure(
            id("all"),
            format!("Counts of {name}, all phase steps"),
            format!(
                "Signed counts of all phase steps against distance. The largest is {} at {:.2} m.",
                points[peak].1, points[peak].0
            ),
        );
        let expected = Expected::of(page, counts);
        let zoom = match &expected {
            Expected::OfSteps(comparison) => comparison.counts(from, to, "this run"),
            _ => panel(Mark::LineAndDots, near.to_vec()),
        };
        let marks = marks(page, counts.detector, near);
        let zoom = zoom.marked(marks).figure(
            id("peak"),
            format!("Counts of {name}, round the peak"),
            format!("Signed counts of the phase steps from {from:.2} to {to:.2} m."),
        );
        let mut figures = vec![zoom];
        if let Expected::OfBins(comparison) = &expected {
            let (from, to) = comparison.near(BINS_SHOWN);
            let where_from = match comparison.chi_square().1 > BINS_SHOWN {
                true => ", where they are farthest from expected",
                false => "",
            };
            figures.push(comparison.counts(from, to, "this run").figure(
                id("bins"),
                format!("Bins of {name}{where_from}"),
                format!("Counts of bins {from} to {to} over those that the scene lets one expect."),
            ));
        }
        if let Expected::OfSteps(comparison) | Expected::OfBins(comparison) = &expected {
            figures.push(residuals(comparison, &name, id("residuals")));
        }
        let (estimates, others) = (page.estimates, page.other_estimates);
        let both =
            BothEstimates { own: &estimates[counts.detector], other: &others[counts.detector] };
        figures.extend(offsets::figure(counts.detector, &both));
        let unknown = match expected {
            Expected::Unknown(reason) => Some(reason),
            _ => None,
        };
        Some(OfDetector { name, whole, near: figures, unknown })
    }
}

/// What is left of all counts, or of as many as there is room for.
fn residuals(comparison: &Residuals, name: &str, id: String) -> SvgFigure {
    let (chi_square, number) = comparison.chi_square();
    let (from, to) = comparison.near(RESIDUALS_SHOWN);
    comparison.residuals(from, to).figure(
        id,
        format!("Residuals of {name}: chi-square {chi_square:.0} for {number}"),
        format!(
            "Counts less what the scene lets one expect, in standard deviations. The squares of all {number} \
             sum up to {chi_square:.1}."
        ),
    )
}

/// Counts beside what the scene as it is lets one expect.
enum Expected {
    OfSteps(Residuals),
    OfBins(Residuals),
    /// Why nothing is.
    Unknown(String),
}

impl Expected {
    fn of(page: &Page, counts: &DetectorCounts) -> Expected {
        let mine = page.histograms.iter().find(|one| one.detector == counts.detector);
        let expected = match mine {
            Some(histogram) => histogram_against_scene(page.sensor, histogram)
                .map(|bins| Expected::OfBins(Residuals::of_bins(&bins))),
            None => against_scene(page.sensor, &scan(counts), &page.as_it_is[counts.detector])
                .map(|steps| Expected::OfSteps(Residuals::of_steps(&steps))),
        };
        expected.unwrap_or_else(Expected::Unknown)
    }
}

/// The scan that was counted.
fn scan(counts: &DetectorCounts) -> RecordedScan {
    let total = |step: usize| counts.totals.as_ref().map_or(0, |totals| totals[step]);
    let signed = counts.counts.iter().enumerate();
    let counted = signed.map(|(step, &signed)| StepCount { signed, total: total(step) });
    RecordedScan {
        detector: counts.detector,
        counts: counted.collect(),
        has_totals: counts.totals.is_some(),
    }
}

/// Estimates and truth, as far as they lie in the zoom.
fn marks(
    page: &Page,
    detector: DetectorIndex,
    near: &[(f64, f64)],
) -> Vec<(f64, &'static str, DrawingRole)> {
    let estimates = [&page.estimates[detector], &page.other_estimates[detector]];
    let by = |kind: EstimatorKind| {
        let estimate = estimates.into_iter().find(|estimate| estimate.estimator == kind);
        estimate.and_then(|estimate| estimate.distance_m)
    };
    let marks = [
        (estimates[0].true_distance_m, "true distance", DrawingRole::Truth),
        (by(EstimatorKind::Fft), "phase", DrawingRole::Phase),
        (by(EstimatorKind::Model), "model fit", DrawingRole::Fit),
    ];
    let holds = |at: f64| {
        near.first().is_some_and(|first| first.0 <= at)
            && near.last().is_some_and(|last| at <= last.0)
    };
    let marks = marks.into_iter().filter_map(|(at, name, role)| Some((at?, name, role)));
    marks.filter(|(at, ..)| holds(*at)).collect()
}

/// Error against integration time, and against run time.
pub(super) fn trades(page: &Page) -> Markup {
    let detectors = DetectorIndex::of(page.estimates);
    let std_m = page.estimates.iter().find_map(|estimate| estimate.expected_std_m);
    let mut figures = Vec::new();
    let mut unknown: Vec<(String, Vec<&str>)> = Vec::new();
    for detector in detectors {
        let estimate = &page.estimates[detector];
        let Some(path) = estimate.path else { continue };
        let curves = curves_of(page, detector, path);
        match curves::integration(page.sensor, curves) {
            Ok(figure) => figures.push(figure),
            Err(reason) => match unknown.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, whose)) => whose.push(&estimate.detector),
                None => unknown.push((reason, vec![&estimate.detector])),
            },
        }
    }
    let beyond = figures.split_off(figures.len().min(MOST_UNFOLDED));
    html! {
        div.figures {
            @for figure in &figures { (figure.markup()) }
            @if page.provenance.reproducible {
                p.soft { "Error against run time is left out: it is another each time." }
            } @else if let Some(std_m) = std_m {
                @if let Some(figure) = curves::run_time(page.sensor, page.cosim, std_m) { (figure.markup()) }
            }
        }
        @for (reason, whose) in &unknown {
            p.soft { "Error against integration time, " (whose.join(", ")) ": not known, " (reason) "." }
        }
        @if !beyond.is_empty() { (folded("Error against integration time of the others", beyond.iter())) }
        p.soft {
            "Averaging longer lowers the scatter of both estimators and leaves the bias of the phase. "
            code { "goldtof fidelity" } " measures the errors of every tier of simulation."
        }
    }
}

fn curves_of(page: &Page, detector: DetectorIndex, path: PathIndex) -> IntegrationCurves {
    let known = page.curves.iter().find(|c| c.are_of(detector, path));
    let anew = || IntegrationCurves::of(page.sensor, detector, path);
    known.cloned().unwrap_or_else(anew)
}
