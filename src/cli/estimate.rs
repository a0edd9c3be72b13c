//! `goldtof estimate`: the distance that recorded counts give.

use super::prelude::*;
use crate::door::EstimateOptions;
use crate::recorded::{
    Assessment, CountsFile, RecordedCounts, RecordedHistogram, RecordedScan, assess,
    assess_histogram,
};
use crate::report::residual_plot;
use crate::scene::DetectorIndex;

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof estimate scenes/quick.toml out/quick/counts.csv --out out/residuals"
)]
pub(super) struct EstimateArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    /// Counts of one scan, as `run` writes them: columns phase_step, count, optionally
    /// detector and total_count; or of one histogram: bin, count, detector
    pub counts: PathBuf,
    #[command(flatten)]
    pub options: EstimateOptions,
    /// Folder for the residuals of each detector as CSV and as a plot; created if missing,
    /// for example --out out/residuals
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// First show how the file was read: encoding, delimiter, decimal sign, columns, rows
    #[arg(long)]
    pub explain: bool,
    #[command(flatten)]
    pub check: CheckArgument,
}

/// The JSON of `goldtof estimate`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct Estimates<'a> {
    /// How the file was understood.
    file: &'a CountsFile,
    /// What each detector's scan says.
    assessments: &'a [Assessment],
}

impl Command for EstimateArguments {
    fn run(&self, _: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let scene = self.scene.read()?.scene()?.with_estimator(self.options.estimator)?.summed();
        let sensor = Sensor::new(&scene);
        warn(&sensor, output);
        let file = CountsFile::read(&self.counts)?;
        if self.explain {
            output.note(file.to_string().trim_end());
        }
        let assessments: Vec<(DetectorIndex, Assessment)> = match file.recorded(&sensor)? {
            RecordedCounts::Scans(scans) => {
                let assessed = |scan: &RecordedScan| (scan.detector, assess(&sensor, scan));
                scans.iter().map(assessed).collect()
            }
            RecordedCounts::Histograms(histograms) => {
                let assessed =
                    |one: &RecordedHistogram| (one.detector, assess_histogram(&sensor, one));
                histograms.iter().map(assessed).collect()
            }
        };
        if let Some(out) = &self.out {
            let folder = output.folder(out)?;
            for (number, assessment) in &assessments {
                folder.write(&format!("residuals-{number}.csv"), &assessment.residuals_csv())?;
                folder.write(&format!("residuals-{number}.svg"), &residual_plot(assessment))?;
            }
        }
        let assessments: Vec<Assessment> = assessments.into_iter().map(|(_, one)| one).collect();
        let text: String = assessments.iter().map(Assessment::to_string).collect();
        let document = Estimates { file: &file, assessments: &assessments };
        output.answer(Some(scene.reference()), &document, &text)?;
        let holds = assessments.iter().all(Assessment::holds);
        Ok(Ending::of_check(self.check.check, holds))
    }
}
