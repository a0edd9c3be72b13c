//! `goldtof grade`.

use std::fmt::Write as _;

use super::arguments::{GradeArguments, Order};
use super::emit::rtl;
use super::ending::Ending;
use super::output::Output;
use super::provenance::typed_command;
use crate::document::Document;
use crate::door::{Rtl, grade, grade_some};
use crate::grade::{Grade, GradeOptions, GradeStimulus, Score};
use crate::printable::{printable_lines, printable_path};
use crate::report::quantities::percent;
use crate::scene::{Scene, SceneReference};
use crate::shard::{self, GradeJob, Job, Part, Results, SceneText};

/// Survivors that are printed; the JSON has all.
const SHOWN: usize = 20;

pub(super) fn run(
    arguments: &GradeArguments,
    seed: u64,
    output: &Output,
) -> anyhow::Result<Ending> {
    let (scene, scene_text) = arguments.scene.load_with_text()?;
    let options = GradeOptions { seed, ..arguments.options };
    let rtl = rtl(&arguments.own, &arguments.scene);
    if let Some(order) = arguments.shard.order() {
        let job = GradeJob {
            scene: SceneText::new(
                &printable_path(&arguments.scene.scene),
                scene_text,
                &arguments.scene.settings,
            ),
            verilog_sha256: rtl.sha256(&scene)?,
            options,
        };
        return some_variants(job, &scene, &rtl, &order, output);
    }
    let progress = output.progress();
    let graded = grade(&scene, &rtl, &options, |stage| progress.stage(stage));
    progress.end();
    tell(&graded?, scene.reference(), output)
}

/// A part of the faults and mutants.
fn some_variants(
    job: GradeJob,
    scene: &Scene,
    rtl: &Rtl,
    order: &Order,
    output: &Output,
) -> anyhow::Result<Ending> {
    let options = job.options;
    order.fulfil(Job::Grade(job), output, |_| {
        let progress = output.progress();
        let choose = |count| shard::variants(order.part, count);
        let graded = grade_some(scene, rtl, &options, choose, |stage| progress.stage(stage));
        progress.end();
        Ok(Results::Grade(graded?))
    })
}

/// What the faults and mutants of all shards say.
pub(super) fn merge(
    job: &GradeJob,
    shards: Vec<(Part, Results)>,
    output: &Output,
) -> anyhow::Result<Ending> {
    tell(&shard::whole_grade(job, shards)?, job.scene.reference(), output)
}

fn tell(grade: &Grade, scene: SceneReference, output: &Output) -> anyhow::Result<Ending> {
    let document = Document { scene: Some(scene), ..Document::new(grade, typed_command(), None) };
    output.answer_document(&document, &text(grade))?;
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

/// What became of the faults and mutants.
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
