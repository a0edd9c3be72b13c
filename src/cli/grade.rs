//! `goldtof grade`.

use std::fmt::Write as _;

use super::Ending;
use super::arguments::GradeArguments;
use super::emit::command_line;
use super::output::Output;
use crate::door::{GradeOptions, Rtl, grade};
use crate::grade::{Grade, GradeStimulus, Score};
use crate::printable::printable_lines;

/// Survivors that are printed; the JSON has all.
const SHOWN: usize = 20;

pub(super) fn run(
    arguments: &GradeArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let scene = arguments.scene.load()?;
    let options = GradeOptions {
        rtl: match arguments.own.rtl() {
            Some(own) => Rtl::Own(own),
            None => Rtl::Emitted {
                made_by: command_line(&arguments.scene),
            },
        },
        stimulus: arguments.stimulus,
        clocks: arguments.cycles,
        seed,
        mutants: arguments.mutants,
        proof_s: arguments.proof_time,
    };
    let progress = output.progress();
    let graded = grade(&scene, &options, |stage| progress.stage(stage));
    progress.end();
    let grade = graded?;
    output.answer(&grade, &text(&grade))?;
    let wanted = arguments.at_least.unwrap_or(0.0);
    if grade.share() >= wanted {
        return Ok(Ending::Done);
    }
    output.note(&format!(
        "{:.2} % are caught, {:.2} % are asked for",
        grade.share() * 100.0,
        wanted * 100.0
    ));
    Ok(Ending::DoesNotHold)
}

fn text(grade: &Grade) -> String {
    let stimulus = match grade.stimulus {
        GradeStimulus::Photons => "photons",
        GradeStimulus::Adversarial => "adversarial stimulus",
        GradeStimulus::Testbench => "the testbench",
    };
    let mut text = format!(
        "{} clocks of {stimulus}, seed {}\n",
        grade.clocks, grade.seed
    );
    text += &of_kind("stuck-at faults", &grade.faults);
    if let Some(mutants) = &grade.mutants {
        text += &of_kind("mutants", mutants);
    }
    text
}

fn of_kind(name: &str, score: &Score) -> String {
    let mut text = format!(
        "{name}: {} of {} caught, {} proven equivalent: {:.2} %; the last by clock {}\n",
        score.caught,
        score.total,
        score.equivalent,
        score.share * 100.0,
        score.last_caught_at
    );
    for survivor in score.survivors.iter().take(SHOWN) {
        let line = format!(
            "  {} {} ({}): {}",
            survivor.net, survivor.change, survivor.source, survivor.needs
        );
        let _ = writeln!(text, "{}", printable_lines(&line));
    }
    if score.survivors.len() > SHOWN {
        let _ = writeln!(
            text,
            "  and {} more (--json has all)",
            score.survivors.len() - SHOWN
        );
    }
    text
}

/// A share of all: `99%` or `0.99`.
pub(super) fn parse_share(text: &str) -> Result<f64, String> {
    let (number, scale) = match text.trim().strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text.trim(), 1.0),
    };
    let share = number.trim().parse::<f64>().map_or(f64::NAN, |n| n * scale);
    if (0.0..=1.0).contains(&share) {
        Ok(share)
    } else {
        Err("write a share from 0% to 100%, as 99% or 0.99".to_owned())
    }
}
