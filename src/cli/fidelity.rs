//! `goldtof fidelity`.

use std::time::Duration;

use super::Ending;
use super::arguments::FidelityArguments;
use super::forecast::announce;
use super::output::Output;
use super::warnings::warn_of_far_paths;
use crate::printable::printable_path;
use crate::sensor::Sensor;
use crate::study::fidelity::compare;

pub(super) fn run(
    arguments: &FidelityArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let scene = arguments.scene.load()?;
    warn_of_far_paths(&Sensor::new(&scene), output);
    let budget = Duration::from_secs(arguments.budget_s);
    // Before the long work, so that a folder that cannot be had is told at once.
    let folder = match &arguments.out {
        Some(path) => Some(output.folder(path)?),
        None => None,
    };
    announce(output, "the comparison", arguments.budget_s as f64);
    let report = compare(&scene, seed, budget, arguments.target_error)?;
    for tier in &report.domains {
        for warning in &tier.warnings {
            output.note(&format!("warning: {}: {warning}", tier.fidelity));
        }
    }
    if let Some(folder) = folder {
        for name in report.write_files(&folder)? {
            output.note(&format!("wrote {}", printable_path(&folder.join(name))));
        }
    }
    output.answer(Some(&scene), &report, &report.to_text())?;
    if let Some(refusal) = &report.refusal {
        output.note(&format!("refused: {refusal}"));
        return Ok(Ending::DoesNotHold);
    }
    Ok(Ending::Done)
}

/// The smallest error that scans can show: it takes 2 10^8 of them.
const LEAST_ERROR: f64 = 1e-4;
const MOST_ERROR: f64 = 0.99;

/// Reads a relative error: "1%" or "0.01".
pub(super) fn parse_error(text: &str) -> Result<f64, String> {
    let (number, scale) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if (LEAST_ERROR..=MOST_ERROR).contains(&(value * scale)) => Ok(value * scale),
        _ => Err(format!(
            "\"{text}\" is no relative error from 0.01% to 99%; write for example 1% or 0.01"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::parse_error;

    #[test]
    fn an_error_is_a_percentage_or_a_fraction() {
        assert_eq!(parse_error("1%"), Ok(0.01));
        assert_eq!(parse_error("0.25"), Ok(0.25));
        for wrong in [
            "", "%", "0", "-1%", "100%", "nan", "one", "1e-300", "0.001%",
        ] {
            assert!(parse_error(wrong).is_err(), "{wrong}");
        }
    }
}
