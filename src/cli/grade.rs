//! `goldtof grade`.

use std::fmt::Write as _;

use super::cosim::CosimProgress;
use super::emit::command_line;
use super::prelude::*;
use crate::door::{grade, grade_some, sha256_of};
use crate::grade::{Grade, GradeOptions, GradeStimulus, Judged, Score};
use crate::report::columns::percent;
use crate::shard::{self, GradeJob};

/// Survivors that are printed; the JSON has all.
const SHOWN: usize = 20;

#[derive(Debug, Args)]
#[command(
    after_help = "Example: goldtof grade scenes/quick.toml --stimulus testbench --at-least 98%"
)]
pub(super) struct GradeArguments {
    #[command(flatten)]
    pub scene: SceneArgument,
    #[command(flatten)]
    pub options: GradeOptions,
    #[command(flatten)]
    pub shard: ShardArguments,
}

impl Command for GradeArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let scene = self.scene.read()?;
        let made_by = command_line(&self.scene);
        let options = GradeOptions { seed, made_by, ..self.options.clone() };
        let sensor = Sensor::new(&scene.scene()?);
        if let Some(order) = self.shard.order() {
            let job = GradeJob {
                scene: scene.without_folder(),
                verilog_sha256: sha256_of(&sensor, &options)?,
                options,
            };
            return order.fulfil(Job::Grade(job), output);
        }
        let mut progress = CosimProgress::new(output);
        let graded = grade(&sensor, &options, |so_far| progress.hear(so_far));
        progress.end();
        tell(&graded?, scene.reference(), output)
    }
}

impl InShards for GradeJob {
    fn part(
        &self,
        part: JobPart,
        _: &OutputFolder,
        output: &CommandOutput,
    ) -> anyhow::Result<Results> {
        let sensor = Sensor::new(&self.scene.scene()?);
        let mut progress = CosimProgress::new(output);
        let choose = |count| shard::variants(part, count);
        let graded = grade_some(&sensor, &self.options, choose, |so_far| progress.hear(so_far));
        progress.end();
        Ok(Results::Grade(graded?))
    }

    fn merge(
        &self,
        parts: PartResults,
        _: &Path,
        output: &CommandOutput,
    ) -> anyhow::Result<Ending> {
        tell(&shard::whole_grade(self, parts)?, self.scene.reference(), output)
    }
}

fn tell(grade: &Grade, scene: SceneReference, output: &CommandOutput) -> anyhow::Result<Ending> {
    output.answer(Some(scene), grade, &text(grade))?;
    Ok(match grade.asked_fraction {
        Some(asked) if grade.caught_fraction < asked => Ending::BelowThreshold,
        _ => Ending::Done,
    })
}

fn text(grade: &Grade) -> String {
    let mut text = faults(grade);
    let _ = write!(text, "score: {}", percent(grade.caught_fraction));
    if let Some(asked) = grade.asked_fraction {
        let verdict = match grade.caught_fraction < asked {
            true => "less than",
            false => "at least",
        };
        let _ = write!(text, ", {verdict} the {} asked for", percent(asked));
    }
    text + "\n"
}

/// Outcome of faults and mutants.
pub(super) fn faults(grade: &Grade) -> String {
    let stimulus = match grade.stimulus {
        GradeStimulus::Photons => "photons",
        GradeStimulus::Adversarial => "adversarial stimulus",
        GradeStimulus::Testbench => "the testbench",
    };
    let mut text = format!("{} clocks of {stimulus}, seed {}\n", grade.clocks, grade.seed);
    text += &of_kind("stuck-at faults", &grade.faults);
    if let Some(mutants) = &grade.mutants {
        text += &of_kind("mutants", mutants);
    }
    text
}

fn of_kind(name: &str, score: &Score) -> String {
    let Score { total, caught, not_caught, undecided, proven_equivalent, .. } = score;
    let mut text = format!(
        "{name}: {caught} of {total} caught, {not_caught} not caught, {undecided} undecided, \
         {proven_equivalent} proven equivalent: {} of those that are not\n",
        percent(score.caught_fraction),
    );
    for survivor in score.survivors.iter().take(SHOWN) {
        let Judged { net, change, source, .. } = survivor;
        let line = format!("  {net} {change} ({source}): {}", survivor.reason());
        let _ = writeln!(text, "{}", printable_lines(&line));
    }
    if score.survivors.len() > SHOWN {
        let more = score.survivors.len() - SHOWN;
        let _ = writeln!(text, "  and {more} more (--json has all)");
    }
    text
}
