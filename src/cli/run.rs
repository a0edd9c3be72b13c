//! `goldtof run`: the main job, with its progress and summary.

use std::fmt::Write as _;

use super::common::VcdWindow;
use super::cosim::{CosimProgress, ending, exercised, score, text as cosim_text, with_junit};
use super::emit::{command_line, text as emit_text};
use super::prelude::*;
use super::provenance::provenance;
use super::{grade, junit};
use crate::cosim::Verdict;
use crate::cosim::build::file_identity;
use crate::report::estimates::{BothEstimates, texts};
use crate::run::{REPORT, Run, RunEvent, RunOptions, run as main_job};
use crate::version::VERSION;

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof run scenes/quick.toml")]
pub(super) struct RunArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: RunOptions,
    #[command(flatten)]
    pub check: CheckArgument,
    /// With either of these waves.vcd is written, too
    #[command(flatten)]
    pub vcd_window: VcdWindow,
    /// Also write the result of the co-simulation as a JUnit report, for example
    /// --junit run.xml
    #[arg(long, value_name = "FILE")]
    pub junit: Option<PathBuf>,
}

impl Command for RunArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let text = self.scene.read()?;
        let scene = text.scene()?;
        let sensor = Sensor::new(&scene);
        warn(&sensor, output);
        let options = RunOptions {
            seed,
            made_by: command_line(&self.scene),
            window: self.vcd_window.clocks(),
            // The file that runs, even if another has taken its place.
            program: file_identity(Path::new("/proc/self/exe"))
                .ok()
                .map(|file| format!("{VERSION} {file}")),
            provenance: provenance(text.text)?,
            ..self.options.clone()
        };
        let mut progress = CosimProgress::new(output);
        let ended = main_job(&sensor, &options, |event| match event {
            RunEvent::Waits(path) => output.waits(path),
            RunEvent::Emitted(emission, rtl) => {
                output.note(first_line(&emit_text(emission, rtl)));
                progress.build();
            }
            RunEvent::Progress(so_far) => progress.hear(so_far),
            RunEvent::Compared(report) => {
                progress.end();
                let told = cosim_text(report);
                output.note(match report.verdict {
                    // The summary has the rest.
                    Verdict::Match => first_line(&told),
                    Verdict::Mismatch | Verdict::Inconclusive => told.trim_end(),
                });
            }
        });
        progress.end();
        let run = with_junit(self.junit.as_deref(), &scene.name, ended)?;
        if let Some(path) = &self.junit {
            junit::write_report(path, &scene.name, &run.cosim)?;
        }
        let chips = scene.scan.integration_chips;
        output.answer(
            Some(scene.reference()),
            &run,
            &summary(&run, chips, &options.folder(&scene)),
        )?;
        Ok(match ending(run.cosim.verdict) {
            Ending::Done => {
                let holds = run.estimates.iter().all(|own| own.expectation_holds != Some(false));
                Ending::of_check(self.check.check, holds)
            }
            other => other,
        })
    }
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

/// The end of the run in a few lines.
fn summary(run: &Run, chips: u64, out: &Path) -> String {
    let mut text = format!(
        "{}: co-simulation {}: {} clocks, {} phase steps of {} chips\n",
        run.scene, run.cosim.verdict, run.cosim.clocks, run.cosim.phase_steps, chips,
    );
    text += &exercised(&run.cosim);
    let both = run.estimates.iter().zip(&run.other_estimates);
    let both: Vec<BothEstimates> = both.map(|(own, other)| BothEstimates { own, other }).collect();
    let (of_one, of_several) = texts(&both, terminal_width());
    for (detector, told) in of_one.iter().enumerate() {
        text += told;
        if let Some(peak) = run.cosim.peaks.get(detector) {
            let _ = writeln!(
                text,
                "{}: peak of the hardware at phase step {}, count {}",
                peak.detector, peak.phase_step, peak.count
            );
        }
    }
    text += &of_several;
    let _ = writeln!(text, "report: {}", printable_path(&out.join(REPORT)));
    text += &score(&run.cosim);
    if let Some(graded) = &run.grade {
        let _ = write!(text, "graded: {}", grade::faults(graded));
    }
    text
}
