//! What limits a sensor, in one screen.

use super::columns::{bit_rate, row};
use super::estimates::missed;
use super::plan::row;
use super::prelude::*;
use crate::study::limits::{KeyChange, Limit, Limits, Performance};

/// Changes of less are within what theory rounds.
const LEAST_CHANGE: f64 = 5e-4;

/// Everything, in lines of no more than `width` characters where that is given.
pub(crate) fn text(limits: &Limits, width: Option<usize>) -> String {
    let Limits { scene, detector, source, .. } = limits;
    let at = limits.true_distance_m.map(|m| format!(" at {}", length(m))).unwrap_or_default();
    let estimator = estimator_name(limits.estimator);
    let mut text =
        paragraph(format!("{scene}: {detector} ranging {source}{at}, {estimator}"), width);
    text += &columns(&uses(limits), 2, width);
    text += "\n";
    text += &paragraph(verdict(limits), width);
    let changes = changes(limits);
    if changes.len() > 1 {
        text += &format!("\nOne key changed, all else as it is\n{}", columns(&changes, 2, width));
    }
    text
}

/// Where light, time and bits go.
fn uses(limits: &Limits) -> Vec<Vec<String>> {
    let (light, figures, expected) = (&limits.light, &limits.figures, &limits.expected);
    let noise_hz = light.other_primary_hz + light.background_hz + light.dark_counts_hz;
    let share = light.own_primary_hz / (light.own_primary_hz + noise_hz).max(f64::MIN_POSITIVE);
    let what = if figures.at_once { "histogram" } else { "phase step" };
    let mut rows = vec![
        row!(
            "photons",
            "{} that would fire it, of the ranged light: {} of all; other light {}, background {}, dark \
                 counts {}",
            rate(light.own_primary_hz),
            percent(share),
            rate(light.other_primary_hz),
            rate(light.background_hz),
            rate(light.dark_counts_hz)
        ),
        row(
            "dead time",
            match light.detected_rate_cps.zip(light.blind_fraction) {
                Some((detected_cps, blind)) => format!(
                    "{} detected, {} in a {what}; blind for {} of the time",
                    rate(detected_cps),
                    number((detected_cps * figures.integration_s).round() as u64),
                    percent(blind)
                ),
                None => "the mean response is not known".to_owned(),
            },
        ),
        row!(
            "code",
            "{} chips: {} unambiguous",
            number(figures.code_period_chips),
            length(figures.unambiguous_range_m)
        ),
        row!(
            "clock",
            "chips of {}, phase steps of {}; a frame takes {}",
            time(1.0 / figures.clock_hz),
            length(figures.phase_step_distance_m),
            time(figures.frame_time_s)
        ),
        row!(
            "wire",
            "{} in results of {} bits, on average one in {} clocks",
            bit_rate(limits.result_bits_per_s),
            figures.result_bits,
            number((1.0 / limits.stream_busy_fraction) as u64)
        ),
    ];
    if let Some((bias_m, std_m)) = expected.expected_bias_m.zip(expected.expected_std_m) {
        let mut error =
            format!("bias {}, scatter {}", millimetres(bias_m, true), millimetres(std_m, false));
        if let Some((bound_m, kind)) = expected.bound_m.zip(expected.bound_kind) {
            error += &format!("; {} {}", kind.name(), millimetres(bound_m, false));
        }
        error.extend(missed(expected.expected_missed_fraction).map(|missed| format!("; {missed}")));
        rows.push(row("error", error));
    }
    rows
}

/// What is to be said first.
fn verdict(limits: &Limits) -> String {
    let expected = &limits.expected;
    let Some((bias_m, std_m)) = expected.expected_bias_m.zip(expected.expected_std_m) else {
        let why = expected.remark.as_deref().unwrap_or("there is no path to range");
        return format!("Nothing is expected of this scene: {why}.");
    };
    if bias_m.abs() > std_m {
        return format!(
            "The bias limits it: {} against a scatter of {}. More photons lower the scatter alone.",
            millimetres(bias_m, true),
            millimetres(std_m, false)
        );
    }
    let best = limits.changes.iter().find(|change| change.limit != Limit::Estimator);
    let gain = best.and_then(|best| Some((best, best.rms_change_fraction?)));
    match gain.filter(|(_, gain)| *gain < -LEAST_CHANGE) {
        Some((best, gain)) => format!(
            "{} first: {} takes {} off the error.",
            of_limit(best.limit),
            best.setting,
            percent(-gain)
        ),
        None => "None of these keys brings anything alone.".to_owned(),
    }
}

fn of_limit(limit: Limit) -> &'static str {
    match limit {
        Limit::Photons => "Photons limit it",
        Limit::Noise => "Noise limits it",
        Limit::DeadTime => "Dead time limits it",
        Limit::Timing => "The timing of light and detections limits it",
        Limit::Code => "The code limits it",
        Limit::Clock => "The clock limits it",
        Limit::Estimator => "The estimator limits it",
    }
}

/// Heading and rows: key, error, bound, and what else changes.
fn changes(limits: &Limits) -> Vec<Vec<String>> {
    let percent = |change: Option<f64>| match change {
        Some(change) if change.abs() < LEAST_CHANGE => "same".to_owned(),
        Some(change) => format!("{:+.1} %", change * 1e2),
        None => "-".to_owned(),
    };
    let heading = ["key", "bias", "scatter, mm", "error", "bound", "beside"].map(str::to_owned);
    let of_change = |change: &KeyChange| {
        let expected = &change.expected;
        let mm = |metres: Option<f64>, signed| match metres {
            Some(metres) => millimetres(metres, signed).replace(" mm", ""),
            None => "-".to_owned(),
        };
        vec![
            change.setting.clone(),
            mm(expected.expected_bias_m, true),
            mm(expected.expected_std_m, false),
            percent(change.rms_change_fraction),
            percent(change.bound_change_fraction),
            beside(&limits.expected, expected),
        ]
    };
    [heading.to_vec()].into_iter().chain(limits.changes.iter().map(of_change)).collect()
}

/// What a change costs or brings beside errors.
fn beside(now: &Performance, then: &Performance) -> String {
    let mut told = Vec::new();
    let differs = |now: f64, then: f64| (then / now - 1.0).abs() > 1e-3;
    if differs(now.frame_time_s, then.frame_time_s) {
        told.push(format!("frame {}", time(then.frame_time_s)));
    }
    if differs(now.unambiguous_range_m, then.unambiguous_range_m) {
        told.push(format!("range {}", length(then.unambiguous_range_m)));
    }
    told.join(", ")
}
