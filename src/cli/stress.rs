//! `goldtof stress`.

use std::fmt::Write as _;

use clap::Args;
use serde::Serialize;

use super::arguments::{Order, ShardArguments};
use super::ending::Ending;
use super::forecast::Forecast;
use super::output::Output;
use crate::document::Body;
use crate::shard::{self, Job, Part, Results, StressJob};
use crate::study::stress::{Case, Group, StressReport, cases, run as run_cases};

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof stress --quick")]
pub(super) struct StressArguments {
    /// One case, for example --case no-light-at-all [default: all]
    #[arg(long, value_name = "NAME", conflicts_with = "quick")]
    pub case: Option<String>,
    /// The fast subset
    #[arg(long)]
    pub quick: bool,
    /// List the cases without running them
    #[arg(long, conflicts_with = "shard")]
    pub list: bool,
    #[command(flatten)]
    pub shard: ShardArguments,
}

/// The JSON of `goldtof stress --list`.
#[derive(Serialize, schemars::JsonSchema)]
pub(super) struct CaseList {
    /// The cases, in their order.
    cases: Vec<ListedCase>,
}

impl Body for CaseList {
    const NAME: &'static str = "stress-list";
}

/// A case that is named.
#[derive(Serialize, schemars::JsonSchema)]
struct ListedCase {
    /// Its name.
    name: &'static str,
    /// Its group.
    group: Group,
    /// What is measured.
    what: &'static str,
}

impl ListedCase {
    fn of(case: &Case) -> ListedCase {
        ListedCase { name: case.name, group: case.group, what: case.what }
    }
}

pub(super) fn run(
    arguments: &StressArguments,
    seed: u64,
    output: &mut Output,
) -> anyhow::Result<Ending> {
    let chosen = choose(arguments)?;
    if arguments.list {
        let cases = chosen.iter().map(ListedCase::of).collect();
        let mut text = String::new();
        for case in &chosen {
            let _ = writeln!(text, "{:<52} {}", case.name, case.what);
        }
        output.answer(None, &CaseList { cases }, &text)?;
        return Ok(Ending::Done);
    }
    if let Some(order) = arguments.shard.order() {
        return some_cases(&chosen, seed, &order, output);
    }
    tell(&watched(&chosen, seed, output)?, output)
}

/// Runs cases, and says which are done.
fn watched(chosen: &[Case], seed: u64, output: &Output) -> anyhow::Result<StressReport> {
    let mut forecast = Forecast::new(output, "all cases");
    let mut done = 0;
    Ok(run_cases(chosen, seed, |case| {
        done += 1;
        forecast.progress(done, chosen.len() as u64);
        output.note(&format!("{:>6.2} s  {}", case.run_time_s, case.name));
    })?)
}

/// A part of the cases.
fn some_cases(
    chosen: &[Case],
    seed: u64,
    order: &Order,
    output: &Output,
) -> anyhow::Result<Ending> {
    let job = Job::Stress(StressJob {
        cases: chosen.iter().map(|case| case.name.to_owned()).collect(),
        seed,
    });
    order.fulfil(job, output, |_| {
        let numbers = order.part.every(chosen.len() as u64);
        let some: Vec<Case> = numbers.map(|number| chosen[number as usize]).collect();
        Ok(Results::Stress(watched(&some, seed, output)?.cases))
    })
}

/// The cases of all shards.
pub(super) fn merge(
    job: &StressJob,
    shards: Vec<(Part, Results)>,
    output: &Output,
) -> anyhow::Result<Ending> {
    tell(&shard::stress_report(job, shards)?, output)
}

fn tell(report: &StressReport, output: &Output) -> anyhow::Result<Ending> {
    output.answer(None, report, &report.to_text())?;
    Ok(if report.all_hold() { Ending::Done } else { Ending::DoesNotHold })
}

/// The cases that the command line asks for.
fn choose(arguments: &StressArguments) -> anyhow::Result<Vec<Case>> {
    let all = cases();
    let Some(name) = &arguments.case else {
        let mut chosen = all;
        chosen.retain(|case| case.quick || !arguments.quick);
        return Ok(chosen);
    };
    match all.iter().find(|case| case.name == name) {
        Some(&case) => Ok(vec![case]),
        None => {
            let nearest = all
                .iter()
                .max_by(|a, b| {
                    let likeness = |case: &Case| strsim::jaro(case.name, name);
                    likeness(a).total_cmp(&likeness(b))
                })
                .map_or("", |case| case.name);
            anyhow::bail!(
                "there is no case \"{name}\"; did you mean \"{nearest}\"? \
                 `goldtof stress --list` names all of them"
            )
        }
    }
}
