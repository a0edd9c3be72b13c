//! `goldtof fidelity`.

use std::time::Duration;

use super::Ending;
use super::arguments::FidelityArguments;
use super::output::Output;
use crate::fidelity::compare::compare;
use crate::printable::printable_path;
use crate::scene;

pub(super) fn run(
    arguments: &FidelityArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let scene = scene::load(&arguments.scene.scene)?;
    let budget = Duration::from_secs(arguments.budget_s);
    // Before the long work, so that a folder that cannot be had is told at once.
    let folder = match &arguments.out {
        Some(path) => Some(output.folder(path)?),
        None => None,
    };
    let report = compare(&scene, seed, budget, arguments.target_error)?;
    for tier in &report.domains {
        for warning in &tier.warnings {
            output.note(&format!("warning: {}: {warning}", tier.name));
        }
    }
    if let Some(folder) = folder {
        for name in report.write_files(&folder)? {
            output.note(&format!("wrote {}", printable_path(&folder.join(name))));
        }
    }
    output.answer(&report, &report.to_text())?;
    Ok(Ending::Done)
}

/// Reads a relative error: "1%" or "0.01".
pub(super) fn parse_error(text: &str) -> Result<f64, String> {
    let (number, scale) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value * scale < 1.0 => Ok(value * scale),
        _ => Err(format!(
            "\"{text}\" is no relative error between 0 and 1; write for example 1% or 0.01"
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
        for wrong in ["", "%", "0", "-1%", "100%", "nan", "one"] {
            assert!(parse_error(wrong).is_err(), "{wrong}");
        }
    }
}
