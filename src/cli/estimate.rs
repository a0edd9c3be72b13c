//! `goldtof estimate`: the distance that recorded counts give.

use serde::Serialize;

use super::arguments::EstimateArguments;
use super::ending::Ending;
use super::output::Output;
use super::warnings::warn_of_far_paths;
use crate::document::Body;
use crate::recorded::{
    Assessment, Recorded, RecordedHistogram, RecordedScan, assess, assess_histogram, read_recorded,
};
use crate::report::residual_plot;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// The JSON of `goldtof estimate`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct Estimates<'a> {
    /// What each detector's scan says.
    assessments: &'a [Assessment],
}

impl Body for Estimates<'_> {
    const NAME: &'static str = "estimate";
}

pub(super) fn run(arguments: &EstimateArguments, output: &mut Output) -> anyhow::Result<Ending> {
    let scene = arguments.scene.load()?.with_estimator(arguments.estimator)?;
    let sensor = Sensor::new(&scene);
    warn_of_far_paths(&sensor, output);
    let assessments: Vec<(DetectorIndex, Assessment)> =
        match read_recorded(&arguments.counts, &sensor)? {
            Recorded::Scans(scans) => {
                let assessed = |scan: &RecordedScan| (scan.detector, assess(&sensor, scan));
                scans.iter().map(assessed).collect()
            }
            Recorded::Histograms(histograms) => {
                let assessed =
                    |one: &RecordedHistogram| (one.detector, assess_histogram(&sensor, one));
                histograms.iter().map(assessed).collect()
            }
        };
    if let Some(out) = &arguments.out {
        let folder = output.folder(out)?;
        for (number, assessment) in &assessments {
            folder.write(&format!("residuals-{number}.csv"), &assessment.residuals_csv())?;
            folder.write(&format!("residuals-{number}.svg"), &residual_plot(assessment))?;
        }
    }
    let assessments: Vec<Assessment> = assessments.into_iter().map(|(_, one)| one).collect();
    let text: String = assessments.iter().map(Assessment::to_string).collect();
    let document = Estimates { assessments: &assessments };
    output.answer(Some(&scene), &document, &text)?;
    let holds = assessments.iter().all(|one| one.estimate.expectation_holds != Some(false));
    Ok(Ending::of_check(arguments.check.check, holds))
}
