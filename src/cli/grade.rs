//! `goldtof grade`.

use std::fmt::Write as _;

use clap::Args;

use super::common::{Order, SceneArgument, ShardArguments};
use super::cosim::CosimProgress;
use super::emit::command_line;
use super::ending::Ending;
use super::output::Output;
use crate::door::{grade, grade_some, sha256_of};
use crate::grade::{Grade, GradeOptions, GradeStimulus, Score};
use crate::printable::printable_lines;
use crate::report::quantities::percent;
use crate::scene::SceneReference;
use crate::sensor::Sensor;
use crate::shard::{self, GradeJob, Job, Part, Results};

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

pub(super) fn run(
    arguments: &GradeArguments,
    seed: u64,
    output: &Output,
) -> anyhow::Result<Ending> {
    let scene = arguments.scene.read()?;
    let made_by = command_line(&arguments.scene);
    let options = GradeOptions { seed, made_by, ..arguments.options.clone() };
    let sensor = Sensor::new(&scene.scene()?);
    if let Some(order) = arguments.shard.order() {
        let job = GradeJob {
            scene: scene.without_folder(),
            verilog_sha256: sha256_of(&sensor, &options)?,
            options,
        };
        return some_variants(job, &sensor, &order, output);
    }
    let mut progress = CosimProgress::new(output);
    let graded = grade(&sensor, &options, |so_far| progress.hear(so_far));
    progress.end();
    tell(&graded?, scene.reference(), output)
}

/// A part of the faults and mutants.
fn some_variants(
    job: GradeJob,
    sensor: &Sensor,
    order: &Order,
    output: &Output,
) -> anyhow::Result<Ending> {
    let options = job.options.clone();
    order.fulfil(Job::Grade(job), output, |_| {
        let mut progress = CosimProgress::new(output);
        let choose = |count| shard::variants(order.part, count);
        let graded = grade_some(sensor, &options, choose, |so_far| progress.hear(so_far));
        progress.end();
        Ok(Results::Grade(graded?))
    })
}

/// The grade by the faults and mutants of all shards.
pub(super) fn merge(
    job: &GradeJob,
    shards: Vec<(Part, Results)>,
    output: &Output,
) -> anyhow::Result<Ending> {
    tell(&shard::whole_grade(job, shards)?, job.scene.reference(), output)
}

fn tell(grade: &Grade, scene: SceneReference, output: &Output) -> anyhow::Result<Ending> {
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
    let mut text = format!(
        "{name}: {} of {} caught, {} not caught, {} undecided, {} proven equivalent: {} of those \
         that are not\n",
        score.caught,
        score.total,
        score.not_caught,
        score.undecided,
        score.proven_equivalent,
        percent(score.caught_fraction),
    );
    for survivor in score.survivors.iter().take(SHOWN) {
        let line = format!(
            "  {} {} ({}): {}",
            survivor.net,
            survivor.change,
            survivor.source,
            survivor.reason()
        );
        let _ = writeln!(text, "{}", printable_lines(&line));
    }
    if score.survivors.len() > SHOWN {
        let more = score.survivors.len() - SHOWN;
        let _ = writeln!(text, "  and {more} more (--json has all)");
    }
    text
}
