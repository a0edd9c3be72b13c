//! Light, counts, and what more of either gains.

use maud::{Markup, html};

use super::Page;
use super::tables::table;
use crate::plan::link::link_budget;
use crate::report::chart::{Axis, Mark, Panel, decimate};
use crate::report::curves::{self, IntegrationCurves};
use crate::report::figure::Figure;
use crate::report::plan::{LINK_HEADINGS, link};
use crate::report::{DetectorCounts, geometry};
use crate::scene::{DetectorIndex, EstimatorKind, PathIndex};

/// Chips on either side of the largest count in the zoom.
const ZOOM_CHIPS: usize = 4;

/// Detectors of more than this have what is alike in all of them folded away.
const MOST_UNFOLDED: usize = 4;

pub(super) fn section(page: &Page) -> Markup {
    let budgets = link(&link_budget(page.sensor));
    let of_counts = page.counts.iter().filter_map(|counts| correlation(page, counts));
    let (whole, peaks): (Vec<Figure>, Vec<Figure>) = of_counts.unzip();
    let is_folded = page.counts.len() > MOST_UNFOLDED;
    html! {
        div.figures {
            (geometry::figure(page.sensor.scene()).markup())
            @if is_folded {
                @for figure in &peaks { (figure.markup()) }
            } @else {
                @for (whole, peak) in whole.iter().zip(&peaks) { (whole.markup()) (peak.markup()) }
            }
        }
        @if is_folded { (folded("Counts of all phase steps", &whole)) }
        @if !budgets.is_empty() {
            h3 { "Photons per second" }
            (table(&LINK_HEADINGS, &budgets))
        }
    }
}

/// Figures that are there for those who ask for them.
fn folded(summary: &str, figures: &[Figure]) -> Markup {
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

/// All counts, and those round the largest.
fn correlation(page: &Page, counts: &DetectorCounts) -> Option<(Figure, Figure)> {
    let points = points(counts);
    let peak = (0..points.len()).max_by(|&a, &b| points[a].1.total_cmp(&points[b].1))?;
    let half = ZOOM_CHIPS * page.sensor.clock().samples_per_chip as usize;
    let near = &points[peak.saturating_sub(half)..(peak + half + 1).min(points.len())];
    let detector = &page.sensor.scene().detectors[counts.detector].name;
    let described = |what: &str, shown: &[(f64, f64)]| {
        format!(
            "Signed counts of {what} against distance, {:.2} to {:.2} m. The largest is {} at {:.2} m.",
            shown.first().map_or(0.0, |p| p.0),
            shown.last().map_or(0.0, |p| p.0),
            points[peak].1,
            points[peak].0
        )
    };
    let panel = |mark, points: Vec<(f64, f64)>| {
        Panel::new(Axis::linear("", "distance (m)"), Axis::linear("", "count"))
            .with("", 0, mark, points)
    };
    let id = |part: &str| format!("counts-{}-{part}", counts.detector);
    let whole = panel(Mark::Line, decimate(&points)).figure(
        id("all"),
        format!("Counts of {detector}, all phase steps"),
        described("all phase steps", &points),
    );
    let marks = marks(page, counts.detector, near);
    let zoom = panel(Mark::LineAndDots, near.to_vec()).marked(marks).figure(
        id("peak"),
        format!("Counts of {detector}, round the peak"),
        described("the phase steps round the peak", near),
    );
    Some((whole, zoom))
}

/// Estimates and truth, as far as they lie in the zoom.
fn marks(page: &Page, detector: DetectorIndex, near: &[(f64, f64)]) -> Vec<(f64, &'static str)> {
    let estimates = [&page.estimates[detector], &page.other_estimates[detector]];
    let by = |kind: EstimatorKind| {
        let estimate = estimates.into_iter().find(|estimate| estimate.estimator == kind);
        estimate.and_then(|estimate| estimate.distance_m)
    };
    let marks = [
        (by(EstimatorKind::Fft), "phase"),
        (estimates[0].true_distance_m, "true distance"),
        (by(EstimatorKind::Model), "model fit"),
    ];
    let holds = |at: f64| {
        near.first().is_some_and(|first| first.0 <= at)
            && near.last().is_some_and(|last| at <= last.0)
    };
    let marks = marks.into_iter().filter_map(|(at, name)| Some((at?, name)));
    marks.filter(|(at, _)| holds(*at)).collect()
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
        match curves::integration(page.sensor, curves, phase_error(page, detector)) {
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
        @if !beyond.is_empty() { (folded("Error against integration time of the others", &beyond)) }
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

fn phase_error(page: &Page, detector: DetectorIndex) -> Option<f64> {
    let estimates = [&page.estimates[detector], &page.other_estimates[detector]];
    let phase = estimates.into_iter().find(|e| e.estimator == EstimatorKind::Fft);
    phase.and_then(|phase| phase.error_m)
}
