//! `goldtof stress`.

use std::fmt::Write as _;

use super::prelude::*;
use crate::shard;
use crate::study::stress::{Case, CaseGroup, StressOptions, StressReport, run as run_cases};

#[derive(Debug, Args)]
#[command(after_help = "Example: goldtof stress --quick")]
pub(super) struct StressArguments {
    #[command(flatten)]
    pub options: StressOptions,
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

/// A case that is named.
#[derive(Serialize, schemars::JsonSchema)]
struct ListedCase {
    /// Its name.
    name: &'static str,
    /// Its group.
    group: CaseGroup,
    /// What is measured.
    what: &'static str,
}

impl ListedCase {
    fn of(case: &Case) -> ListedCase {
        ListedCase { name: case.name, group: case.group, what: case.what }
    }
}

impl Command for StressArguments {
    fn run(&self, seed: u64, output: &CommandOutput) -> anyhow::Result<Ending> {
        let options = StressOptions { seed, ..self.options.clone() };
        let chosen = options.chosen()?;
        if self.list {
            let cases = chosen.iter().map(ListedCase::of).collect();
            let mut text = String::new();
            for case in &chosen {
                let _ = writeln!(text, "{:<52} {}", case.name, case.what);
            }
            return output.answer(None, &CaseList { cases }, &text);
        }
        if let Some(order) = self.shard.order() {
            return order.fulfil(Job::Stress(options.named(&chosen)), output);
        }
        tell(&watched(&chosen, seed, output)?, output)
    }
}

/// Runs cases, and says which are done.
fn watched(chosen: &[Case], seed: u64, output: &CommandOutput) -> anyhow::Result<StressReport> {
    let mut forecast = Forecast::new(output, "all cases");
    let mut done = 0;
    Ok(run_cases(chosen, seed, |case| {
        done += 1;
        forecast.progress(done, chosen.len() as u64);
        output.note(&format!("{:>6.2} s  {}", case.run_time_s, case.name));
    })?)
}

impl InShards for StressOptions {
    fn part(
        &self,
        part: JobPart,
        _: &OutputFolder,
        output: &CommandOutput,
    ) -> anyhow::Result<Results> {
        let chosen = self.chosen()?;
        let numbers = part.every(chosen.len() as u64);
        let some: Vec<Case> = numbers.map(|number| chosen[number as usize]).collect();
        Ok(Results::Stress(watched(&some, self.seed, output)?.cases))
    }

    fn merge(
        &self,
        parts: PartResults,
        _: &Path,
        output: &CommandOutput,
    ) -> anyhow::Result<Ending> {
        tell(&shard::stress_report(self, parts)?, output)
    }
}

fn tell(report: &StressReport, output: &CommandOutput) -> anyhow::Result<Ending> {
    output.answer(None, report, &report.to_text())?;
    Ok(if report.all_hold() { Ending::Done } else { Ending::DoesNotHold })
}
