//! What the estimators say of a scan, side by side, for people.

use super::columns::Lines;
use super::prelude::*;
use crate::estimate::bound::BoundKind;
use crate::estimate::report::SELDOM;

/// Both estimators on one detector's counts.
#[derive(Debug, Clone, Copy)]
pub struct BothEstimates<'a> {
    /// The scene's own.
    pub own: &'a EstimateReport,
    /// The other one, on the same counts.
    pub other: &'a EstimateReport,
}

/// Expected biases below this are not worth an explanation, in metres.
const NOTABLE_BIAS_M: f64 = 0.5e-3;

/// What an expected bias of the phase is made of.
pub(super) const PHASE_BIAS: &str = "the phase's bias comes from dead time (range walk), other \
     light and the shape of the peak; averaging does not remove it, the model fit does";

/// A row of the table: estimator, distance or that there is none, its error, bias and scatter that
/// theory expects, and the error less the expected bias in expected standard deviations.
pub(super) type EstimateRow = [String; 5];

/// What an estimator is called in a table.
pub(super) fn estimator_name(kind: EstimatorKind) -> &'static str {
    match kind {
        EstimatorKind::Fft => "phase (article)",
        EstimatorKind::Model => "model fit",
    }
}

/// What bias and scatter leave out, unless that is seldom.
pub(super) fn missed(share: Option<f64>) -> Option<String> {
    share.filter(|share| *share > SELDOM).map(|share| {
        let percent = share * 100.0;
        format!("{percent:.2} % of the scans are expected to miss the peak, which bias and scatter leave out")
    })
}

fn row(estimate: &EstimateReport) -> EstimateRow {
    let or_dash = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
    let distance = estimate.distance_m.map(|distance_m| format!("{distance_m:.4} m"));
    let expected = estimate.expected_bias_m.zip(estimate.expected_std_m);
    let expected = expected.map(|(bias_m, std_m)| {
        let [bias, std] = [millimetres(bias_m, true), millimetres(std_m, false)];
        format!("{} +- {std}", bias.trim_end_matches(" mm"))
    });
    [
        estimator_name(estimate.estimator).to_owned(),
        distance.unwrap_or_else(|| "none".to_owned()),
        or_dash(estimate.error_m.map(|m| millimetres(m, true))),
        or_dash(expected),
        or_dash(estimate.deviation_in_std.map(|d| format!("{d:+.2}"))),
    ]
}

impl<'a> BothEstimates<'a> {
    /// The phase estimator's first.
    pub(super) fn in_order(&self) -> [&'a EstimateReport; 2] {
        match self.own.estimator {
            EstimatorKind::Fft => [self.own, self.other],
            EstimatorKind::Model => [self.other, self.own],
        }
    }

    /// Rows of the table, the phase estimator's first.
    pub(super) fn rows(&self) -> [EstimateRow; 2] {
        self.in_order().map(row)
    }

    /// What the table does not say: the bound, why something is missing, alarms.
    fn notes(&self) -> Vec<String> {
        let [phase, model] = self.in_order();
        let mut notes = Vec::new();
        if let Some(other) = self.other.true_distance_m
            && self.own.true_distance_m != Some(other)
        {
            notes.push(format!(
                "{}: its error is that against another path of {}, at {other:.4} m, which is the \
                 nearest to it",
                estimator_name(self.other.estimator),
                self.other.source
            ));
        }
        if let Some((bound_m, kind)) = phase.bound_m.zip(phase.bound_kind) {
            let bound = millimetres(bound_m, false);
            notes.push(match kind {
                BoundKind::CramerRao => format!(
                    "{}: no unbiased estimate from such counts, signed and total, scatters less than {bound}",
                    kind.name()
                ),
                BoundKind::MaximumLikelihood => {
                    format!("{} from such counts, signed and total: {bound}", kind.name())
                }
            });
        }
        notes.extend(phase.bound_remark.clone());
        if phase.expected_bias_m.is_some_and(|bias_m| bias_m.abs() > NOTABLE_BIAS_M) {
            notes.push(PHASE_BIAS.to_owned());
        }
        notes.extend(phase.folded.clone());
        let is_shared = phase.remark == model.remark;
        for estimate in [phase, model] {
            let name = estimator_name(estimate.estimator);
            notes.extend(
                missed(estimate.expected_missed_fraction).map(|missed| format!("{name}: {missed}")),
            );
            match &estimate.remark {
                Some(remark) if is_shared => notes.push(remark.clone()),
                Some(remark) => notes.push(format!("{name}: {remark}")),
                None => {}
            }
            let fit = estimate.fit.as_ref();
            let velocity = fit.and_then(|fit| fit.velocity_m_per_s.zip(fit.velocity_std_m_per_s));
            if let Some((velocity, std)) = velocity {
                notes.push(format!("model fit: the path moves at {velocity:+.2} +- {std:.2} m/s"));
            }
            if fit.is_some_and(|fit| fit.alarm) {
                notes.push(
                    "model fit: chi-square alarm, the light or the detector is not as the scene \
                     says"
                        .to_owned(),
                );
            }
        }
        notes.dedup();
        notes
    }

    /// A few lines for a terminal of so many characters: the table, and notes.
    fn text(&self, notes: &[String], width: Option<usize>) -> String {
        let truth = match self.own.true_distance_m {
            Some(distance_m) => format!(", true distance {distance_m:.4} m"),
            None => String::new(),
        };
        let mut text = format!("{} ranging {}{truth}\n", self.own.detector, self.own.source);
        let headings = ["estimator", "distance", "error", "expected error", "off by"];
        let mut rows = self.rows();
        for [.., off] in rows.iter_mut().filter(|[.., off]| off != "-") {
            off.push_str(" std");
        }
        let widest = |column: usize| {
            let cells = rows.iter().map(|row| row[column].as_str()).chain([headings[column]]);
            cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
        };
        let mut lines = Lines::of(&rows, "  ").left(headings[0], widest(0), |row| row[0].clone());
        for (column, heading) in headings.into_iter().enumerate().skip(1) {
            lines = lines.right(heading, widest(column) + 1, move |row| row[column].clone());
        }
        text += &lines.text();
        text + &note_lines(notes, 2, width)
    }
}

/// What is to be said of several detectors' estimates.
pub(super) struct Notes {
    /// Of one alone, detector by detector.
    pub own: Vec<Vec<String>>,
    /// Of at least half of them, if there are more than one: whose, and the note.
    pub shared: Vec<(String, String)>,
}

impl Notes {
    /// A note that at least half of the detectors have, once.
    pub fn of(all: &[BothEstimates]) -> Notes {
        let mut own: Vec<Vec<String>> = all.iter().map(BothEstimates::notes).collect();
        let mut shared: Vec<(String, Vec<&str>)> = Vec::new();
        for (both, notes) in all.iter().zip(&own) {
            for note in notes {
                match shared.iter_mut().find(|(known, _)| known == note) {
                    Some((_, whose)) => whose.push(&both.own.detector),
                    None => shared.push((note.clone(), vec![&both.own.detector])),
                }
            }
        }
        shared.retain(|(_, whose)| whose.len() > 1 && 2 * whose.len() >= all.len());
        for notes in &mut own {
            notes.retain(|note| shared.iter().all(|(known, _)| known != note));
        }
        let told = |(note, whose): (String, Vec<&str>)| match whose.len() == all.len() {
            true => ("all detectors".to_owned(), note),
            false => (whose.join(", "), note),
        };
        Notes { own, shared: shared.into_iter().map(told).collect() }
    }
}

/// Lines for a terminal of so many characters, detector by detector, and those that are
/// of more than one detector.
pub fn texts(all: &[BothEstimates], width: Option<usize>) -> (Vec<String>, String) {
    let notes = Notes::of(all);
    let own = all.iter().zip(&notes.own);
    let own = own.map(|(both, notes)| both.text(notes, width));
    let shared = notes.shared.iter();
    let shared: Vec<String> = shared.map(|(whose, note)| format!("{whose}: {note}")).collect();
    (own.collect(), note_lines(&shared, 0, width))
}

fn note_lines(notes: &[String], indent: usize, width: Option<usize>) -> String {
    let notes: Vec<Vec<String>> = notes.iter().map(|note| vec![note.clone()]).collect();
    columns(&notes, indent, width)
}

/// A length in millimetres, to hundredths.
pub(super) fn millimetres(metres: f64, signed: bool) -> String {
    // -0.00 is nothing.
    let rounded = (metres * 1e5).round() / 100.0 + 0.0;
    match signed {
        true => format!("{rounded:+.2} mm"),
        false => format!("{rounded:.2} mm"),
    }
}
