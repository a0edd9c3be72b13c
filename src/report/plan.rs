//! The plan for people: the sensor in numbers, what it takes, what is left out.

use super::columns::row;
use super::estimates::missed;
use super::prelude::*;
use crate::plan::figures::Figures;
use crate::plan::link::LinkBudget;
use crate::plan::overview::{ExpectedError, Overview};
use crate::plan::resources::{Basis, Resources};
use crate::plan::{Part, Plan, Saving};

/// Savings below this share of the time are within what measuring scatters by.
const LEAST_SHARE: f64 = 0.03;

/// A row of two or more cells.
type Row = Vec<String>;

/// A row of a name and a value.
pub(super) fn row(name: &str, value: impl Into<String>) -> Row {
    vec![name.to_owned(), value.into()]
}

/// Everything, in lines of no more than `width` characters where that is given.
pub fn text(overview: &Overview, width: Option<usize>) -> String {
    let mut text = format!("{}\n", overview.scene);
    let table = |title: &str, rows: &[Row]| match rows {
        [] => String::new(),
        _ => {
            format!("\n{}{}", paragraph(title, width), columns(rows, 2, width))
        }
    };
    text += &columns(&figures(&overview.figures), 2, width);
    for budget in link(&overview.link) {
        let cells = LINK_HEADINGS.iter().zip(&budget).skip(1);
        let rows: Vec<Row> = cells.map(|(what, rate)| row(what, rate)).collect();
        text += &table(&format!("Photons per second, {}", budget[0]), &rows);
    }
    for of_detector in overview.expected.chunks(2) {
        let title = expected_title(&of_detector[0], overview.added_scans);
        text += &table(&title, &expected(of_detector));
    }
    text += &table("FPGA", &resources(overview.resources.as_ref()));
    text += &parts(&overview.plan, width);
    text
}

/// The parts, kept and left out.
pub fn parts(plan: &Plan, width: Option<usize>) -> String {
    let mut text = String::new();
    for (title, parts) in [("Hardware", &plan.hardware), ("Simulation", &plan.simulation)] {
        let kept: Vec<Row> = (parts.iter().filter(|part| part.kept))
            .map(|part| vec![part.part.clone(), part.reason.clone()])
            .collect();
        let left_out: Vec<&Part> = parts.iter().filter(|part| !part.kept).collect();
        let saves = left_out.iter().any(|part| saving(part).is_some());
        let left_out: Vec<Row> = left_out
            .iter()
            .map(|part| {
                let mut row = vec![part.part.clone()];
                if saves {
                    row.push(saving(part).unwrap_or_default());
                }
                row.push(part.reason.clone());
                row
            })
            .collect();
        for (what, rows) in [("kept", kept), ("left out", left_out)] {
            if !rows.is_empty() {
                text += &format!("\n{title}, {what}\n{}", columns(&rows, 2, width));
            }
        }
    }
    if plan.not_measured > 0 {
        let note = format!(
            "What {} of the parts left out of the simulation would cost was not measured: too few \
             detections, or too much time.",
            plan.not_measured
        );
        text += &format!("\n{}", paragraph(note, width));
    }
    text
}

/// The sensor in numbers.
pub(super) fn figures(figures: &Figures) -> Vec<Row> {
    let (whole, result) = match figures.at_once {
        true => ("frame's", "first row"),
        false => ("phase step's", "count"),
    };
    vec![
        row!(
            "clock",
            "{}, a chip of {} per clock",
            frequency(figures.clock_hz),
            time(1.0 / figures.clock_hz)
        ),
        row!(
            "frame time",
            "{}: {} phase step{}{} of {}",
            time(figures.frame_time_s),
            number(figures.phase_steps),
            if figures.phase_steps == 1 { "" } else { "s" },
            if figures.at_once { " at once" } else { "" },
            time(figures.integration_s)
        ),
        row!(
            "latency",
            "{} clocks, {}, from a {whole} last sample to its {result}",
            figures.result_latency_clocks,
            time(figures.result_latency_s)
        ),
        row!(
            "range",
            "{} unambiguous (a code of {} chips), in phase steps of {}",
            length(figures.unambiguous_range_m),
            number(figures.code_period_chips),
            length(figures.phase_step_distance_m)
        ),
        row!(
            "results",
            "{}{} a frame, of {} bits",
            number(figures.results),
            if figures.at_once { " rows of the histogram" } else { "" },
            figures.result_bits
        ),
    ]
}

/// What the columns of [`link`] are.
pub(super) const LINK_HEADINGS: [&str; 7] =
    ["path", "emitted", "returned", "primary", "background", "dark counts", "signal to background"];

/// Photons per second of each path, and what else fires its detector.
pub(super) fn link(budgets: &[LinkBudget]) -> Vec<Row> {
    let row = |budget: &LinkBudget| {
        let (source, detector) = (&budget.source, &budget.detector);
        let rates = [
            budget.emitted_hz,
            budget.returned_hz,
            budget.primary_hz,
            budget.background_hz,
            budget.dark_counts_hz,
        ];
        let mut row = vec![format!("{source} to {detector}, {}", length(budget.distance_m))];
        row.extend(rates.map(|rate| format!("{rate:.3e}")));
        row.push(match budget.signal_to_background {
            Some(ratio) => format!("{ratio:.3}"),
            None => "no background".to_owned(),
        });
        row
    };
    budgets.iter().map(row).collect()
}

/// Whose errors, and where.
fn expected_title(expected: &ExpectedError, added_scans: u32) -> String {
    let at = expected.true_distance_m.map(|m| format!(" at {}", length(m))).unwrap_or_default();
    let of = if added_scans > 1 { format!(", sum of {added_scans} scans") } else { String::new() };
    format!("Expected error of {} ranging {}{at}{of}", expected.detector, expected.source)
}

/// Bias and scatter of each estimator, and the bound.
pub(super) fn expected(of_detector: &[ExpectedError]) -> Vec<Row> {
    let mut rows: Vec<Row> = of_detector
        .iter()
        .map(|expected| row(estimator_name(expected.estimator), error_of(expected)))
        .collect();
    let bound = |expected: &ExpectedError| expected.bound_m.zip(expected.bound_kind);
    if let Some((bound_m, kind)) = of_detector.iter().find_map(bound) {
        rows.push(row!(kind.name(), "{}, with total counts", millimetres(bound_m, false)));
    }
    rows
}

fn error_of(expected: &ExpectedError) -> String {
    let mut text = match (expected.expected_bias_m, expected.expected_std_m) {
        (Some(bias_m), Some(std_m)) => {
            format!("bias {}, scatter {}", millimetres(bias_m, true), millimetres(std_m, false))
        }
        _ => "not known".to_owned(),
    };
    text.extend(missed(expected.expected_missed_fraction).map(|missed| format!("; {missed}")));
    if !expected.has_its_counts {
        text += "; needs total counts, which this hardware does not send (total_counts = true)";
    }
    if let Some(remark) = &expected.remark {
        text += &format!("; {remark}");
    }
    text
}

/// What the hardware takes of an FPGA.
pub(super) fn resources(resources: Option<&Resources>) -> Vec<Row> {
    let Some(resources) = resources else {
        let why = "not known: none like it was among the synthesized sensors (docs/resources.md). \
                   Those have Gold codes, m-sequences or, without a histogram, square waves; histograms have one input for \
                   each detector, and 31 to 8,191 chips for an ECP5, 31 to 2,047 for an iCE40 HX8K, and 511 to 8,191 for \
                   7-series";
        return vec![row("cells", why)];
    };
    let about = about(resources);
    vec![
        row("family", resources.family),
        row!("LUTs", "{about}{} ({})", resources.cells.luts, resources.lut),
        row!("flip-flops", "{about}{}", resources.cells.flip_flops),
        row("block RAM", resources.block_rams.to_string()),
        row("basis", basis(&resources.basis)),
    ]
}

/// What stands before a number of cells.
pub(super) fn about(resources: &Resources) -> &'static str {
    if matches!(resources.basis, Basis::Measured) { "" } else { "about " }
}

fn basis(basis: &Basis) -> String {
    match basis {
        Basis::Measured => "this sensor was synthesized (docs/resources.md)".to_owned(),
        Basis::Fitted { builds, largest_relative_error, cross_validation_relative_error } => {
            format!(
                "fitted to {builds} synthesized sensors (docs/resources.md): off by {:.0} % at most for \
             these, {:.0} % rms for one that the fit has not seen",
                largest_relative_error * 100.0,
                cross_validation_relative_error * 100.0
            )
        }
    }
}

/// A part's name in words.
pub(super) fn spelled(part: &str) -> String {
    // A label in brackets is somebody's name.
    let (name, label) = part.split_at(part.find(" (").unwrap_or(part.len()));
    name.replace('_', " ") + label
}

/// What leaving a part out saves, where it is known and can be told from nothing.
pub(super) fn saving(part: &Part) -> Option<String> {
    let cells = part
        .saved_cells
        .map(|cells| format!("about {} LUTs, {} flip-flops", cells.luts, cells.flip_flops));
    let time = part.saving.as_ref().map(|Saving { time_fraction: share, .. }| match *share {
        share if share < LEAST_SHARE => "no time".to_owned(),
        share => format!("{:.0} % of the time", share * 100.0),
    });
    cells.or(time)
}
