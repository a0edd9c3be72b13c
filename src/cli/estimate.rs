//! `goldtof estimate`: the distance that recorded counts give.

use serde::Serialize;

use super::Ending;
use super::arguments::EstimateArguments;
use super::output::Output;
use crate::recorded::{Assessment, assess, read_counts, residual_plot};
use crate::sensor::Sensor;

/// The JSON of `goldtof estimate`.
#[derive(Serialize)]
struct Estimates<'a> {
    scene: &'a str,
    assessments: &'a [Assessment],
}

pub(super) fn run(arguments: &EstimateArguments, output: &mut Output) -> anyhow::Result<Ending> {
    let scene = arguments
        .scene
        .load()?
        .with_estimator(arguments.estimator)?;
    let sensor = Sensor::new(&scene);
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
        scene: &scene.name,
        assessments: &assessments,
    };
    output.answer(&document, &text)?;
    Ok(Ending::Done)
}
