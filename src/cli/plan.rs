//! `goldtof plan`: what is kept and what is left out, and why.

use std::fmt::Write as _;

use super::Ending;
use super::arguments::SceneArgument;
use super::output::Output;
use crate::plan::{self, Part, Plan};
use crate::sensor::Sensor;

pub(super) fn run(arguments: &SceneArgument, output: &mut Output) -> anyhow::Result<Ending> {
    let sensor = Sensor::new(&arguments.load()?);
    let plan = plan::with_savings(plan::plan(&sensor), &sensor);
    output.answer(&plan, &to_text(&plan))?;
    Ok(Ending::Done)
}

/// The plan for people: one line per part.
pub fn to_text(plan: &Plan) -> String {
    let mut text = String::new();
    let parts = || plan.hardware.iter().chain(&plan.simulation);
    let width = parts()
        .map(|part| part.part.chars().count())
        .max()
        .unwrap_or(0);
    for (title, parts) in [
        ("Hardware", &plan.hardware),
        ("Simulation", &plan.simulation),
    ] {
        let _ = writeln!(text, "{title}");
        for part in parts {
            let Part {
                part,
                kept,
                reason,
                saving,
            } = part;
            let mark = if *kept { "kept    " } else { "left out" };
            let saving = saving.as_ref().map_or(String::new(), |saving| {
                format!(
                    "; saves {:.1} % of the time ({})",
                    saving.share * 100.0,
                    saving.basis
                )
            });
            let _ = writeln!(text, "  {mark}  {part:width$}  {reason}{saving}");
        }
    }
    if plan.not_measured > 0 {
        let _ = writeln!(
            text,
            "what {} of the parts left out save was not measured: it would take too long",
            plan.not_measured
        );
    }
    text
}
