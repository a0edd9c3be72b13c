//! `goldtof estimate`: the distance that recorded counts give.

use serde::Serialize;

use super::Ending;
use super::arguments::EstimateArguments;
use super::output::Output;
use super::warnings::warn_of_far_paths;
use crate::document::Body;
use crate::recorded::{Assessment, assess, read_counts, residual_plot};
use crate::sensor::Sensor;

/// The JSON of `goldtof estimate`.
#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub(super) struct Estimates<'a> {
    /// What each detector's scan says.
    assessments: &'a [Assessment],
}

impl Body for Estimates<'_> {
    const NAME: &'static str = "estimate";
}

pub(super) fn run(arguments: &EstimateArguments, output: &mut Output) -> anyhow::Result<Ending> {
    let scene = arguments
        .scene
        .load()?
        .with_estimator(arguments.estimator)?;
    let sensor = Sensor::new(&scene);
    warn_of_far_paths(&sensor, output);
    let scans = read_counts(&arguments.counts, &sensor)?;
    let assessments: Vec<Assessment> = scans.iter().map(|scan| assess(&sensor, scan)).collect();
    if let Some(out) = &arguments.out {
        let folder = output.folder(out)?;
        for (scan, assessment) in scans.iter().zip(&assessments) {
            let number = scan.detector;
            folder.write(
                &format!("residuals-{number}.csv"),
                &assessment.residuals_csv(),
            )?;
            folder.write(
                &format!("residuals-{number}.svg"),
                &residual_plot(assessment)?,
            )?;
        }
    }
    let text: String = assessments.iter().map(Assessment::to_string).collect();
    let document = Estimates {
        assessments: &assessments,
    };
    output.answer(Some(&scene), &document, &text)?;
    Ok(Ending::Done)
}
