//! Stiff, extreme and hostile cases: `goldtof stress`.
//!
//! Every case measures one number and states the bound that it must keep, and
//! why that bound is right: a closed form, exact arithmetic, saturation at one
//! count per dead time, a theorem, or equality by construction. The expectation
//! never comes from the code under test.

mod case;
mod codes;
mod detectors;
mod hardware;
mod light;
mod modulation;
mod numbers;
mod prelude;
mod ranging;
mod reading;
mod report;
mod stiff;
mod testbench;

use std::time::Instant;

pub use case::{Case, CaseBound, CaseError, CaseGroup, CaseMeasurement};
pub use report::{CaseReport, StressReport};
use serde::{Deserialize, Serialize};

use crate::cosim::error::CosimError;
use crate::simulate::scans::ScansError;

/// Every case, group by group.
pub fn cases() -> Vec<Case> {
    [
        stiff::CASES,
        light::CASES,
        modulation::CASES,
        detectors::CASES,
        codes::CASES,
        numbers::CASES,
        ranging::CASES,
        hardware::CASES,
    ]
    .concat()
}

/// Runs some cases, one after another, each with the same seed. `on_case` gets
/// each as it is done.
///
/// # Errors
/// When an external tool is missing or fails; every other failure is a case that
/// does not hold.
pub fn run(
    cases: &[Case],
    seed: u64,
    mut on_case: impl FnMut(&CaseReport),
) -> Result<StressReport, CosimError> {
    let mut report = StressReport { seed, cases: Vec::new() };
    for case in cases {
        let case = run_case(case, seed)?;
        on_case(&case);
        report.cases.push(case);
    }
    Ok(report)
}

fn run_case(case: &Case, seed: u64) -> Result<CaseReport, CosimError> {
    let started = Instant::now();
    let outcome = (case.run)(seed);
    let run_time_s = started.elapsed().as_secs_f64();
    let outcome = match outcome.map_err(of_tool) {
        Err(Ok(tool)) => return Err(tool),
        Err(Err(other)) => Err(other),
        Ok(measured) => Ok(measured),
    };
    Ok(CaseReport::new(case, outcome, run_time_s))
}

/// The error of an external tool, if it is one.
fn of_tool(error: CaseError) -> Result<CosimError, CaseError> {
    let error = match error.downcast() {
        Ok(scans) => match *scans {
            ScansError::Cosim(error) => error.into(),
            other => other.into(),
        },
        Err(other) => other,
    };
    let error: Box<CosimError> = error.downcast()?;
    if error.is_tool() { Ok(*error) } else { Err(error) }
}

/// Stress cases.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema, clap::Args)]
pub struct StressOptions {
    /// One case, for example --case no-light-at-all [default: all]
    #[arg(long = "case", value_name = "NAME", conflicts_with = "quick", num_args = 1,
          action = clap::ArgAction::Set)]
    #[schemars(description = "Names of the cases; all of them without any")]
    pub cases: Vec<String>,
    /// The fast subset
    #[arg(long)]
    #[serde(skip)]
    pub quick: bool,
    /// Seed of each case
    #[arg(skip)]
    pub seed: u64,
}

impl Default for StressOptions {
    fn default() -> StressOptions {
        StressOptions { cases: Vec::new(), quick: false, seed: 1 }
    }
}

/// There is no case of that name.
#[derive(Debug, thiserror::Error)]
#[error(
    "there is no case \"{name}\"; did you mean \"{nearest}\"? `goldtof stress --list` names all of \
     them"
)]
pub struct UnknownCase {
    /// The name.
    name: String,
    /// The case whose name is most like it.
    nearest: &'static str,
}

impl StressOptions {
    /// The cases, in their order.
    ///
    /// # Errors
    /// When a name is unknown.
    pub fn chosen(&self) -> Result<Vec<Case>, UnknownCase> {
        let mut all = cases();
        if self.cases.is_empty() {
            all.retain(|case| case.quick || !self.quick);
            return Ok(all);
        }
        let of_name = |name: &String| {
            let likeness = |case: &&Case| strsim::jaro(case.name, name);
            let nearest = all.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
            let nearest = nearest.map_or("", |case| case.name);
            let found = all.iter().find(|case| case.name == name);
            found.copied().ok_or_else(|| UnknownCase { name: name.clone(), nearest })
        };
        self.cases.iter().map(of_name).collect()
    }

    /// The same with each case named, as a shard records them.
    pub fn named(&self, chosen: &[Case]) -> StressOptions {
        let cases = chosen.iter().map(|case| case.name.to_owned());
        StressOptions { cases: cases.collect(), quick: false, seed: self.seed }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(run: fn(u64) -> Result<CaseMeasurement, CaseError>) -> Case {
        Case {
            name: "a-case",
            group: CaseGroup::Numbers,
            quick: true,
            what: "a number",
            why: "for the test",
            run,
        }
    }

    #[test]
    fn a_case_outside_its_bound_or_with_an_error_does_not_hold() {
        let outside = case(|_| CaseMeasurement::largest([-2.5], "apples", 2.0));
        let failing = case(|_| Err("out of apples".into()));
        let undefined = case(|_| CaseMeasurement::largest([1.0, f64::NAN], "apples", 2.0));
        let of_none = case(|_| CaseMeasurement::largest([], "apples", 2.0));
        let none_seen = case(|_| CaseMeasurement::none(0, 0, "worms"));
        let inside = case(|_| CaseMeasurement::largest([1.0, -2.0], "apples", 2.0));
        let report =
            run(&[outside, failing, undefined, of_none, none_seen, inside], 1, |_| ()).unwrap();
        let holds: Vec<bool> = report.cases.iter().map(|case| case.holds).collect();
        assert_eq!(holds, [false, false, false, false, false, true]);
        assert!(!report.all_hold());
        assert_eq!(report.cases[1].error.as_deref(), Some("out of apples"));
        assert!(run(&[inside], 1, |_| ()).unwrap().all_hold());
    }

    #[test]
    fn cases_get_the_seed_and_the_report_says_it() {
        let seed = case(|seed| CaseMeasurement::exactly(seed as f64, "", 7.0));
        let report = run(&[seed], 7, |_| ()).unwrap();
        assert!(report.all_hold() && report.seed == 7);
        assert!(!run(&[seed], 8, |_| ()).unwrap().all_hold());
    }

    #[test]
    fn a_missing_tool_is_an_error_and_not_a_verdict() {
        let missing = case(|_| {
            Err(CosimError::MissingTool {
                tool: "Verilator",
                program: "verilator".to_owned(),
                reason: std::io::ErrorKind::NotFound.into(),
                install: "apt-get install verilator",
            }
            .into())
        });
        assert!(run(&[missing], 1, |_| ()).is_err());
    }

    #[test]
    fn a_bound_holds_on_its_rim_only_as_far_as_it_goes() {
        let exactly = CaseBound::exactly(3.0);
        assert!(exactly.holds(3.0) && !exactly.holds(3.0000001) && !exactly.holds(2.9999999));
        assert!(!exactly.holds(f64::NAN));
    }

    /// A program that counts nothing, expects nothing and says nothing passes no case; what the
    /// Verilog sends is looked at by `testbench`.
    #[test]
    fn no_case_holds_of_nothing() {
        use reading::{NOTHING, Nothing};
        let mut passed = Vec::new();
        for nothing in [Nothing::Zeros, Nothing::Undefined, Nothing::Empty] {
            for case in cases().iter().filter(|case| case.group != CaseGroup::Hardware) {
                NOTHING.set(Some(nothing));
                // A panic is not a verdict either.
                let outcome = std::panic::catch_unwind(|| (case.run)(1));
                NOTHING.set(None);
                if let Ok(Ok(measured)) = outcome
                    && measured.bound.holds(measured.value)
                {
                    passed.push((case.name, nothing));
                }
            }
        }
        assert!(passed.is_empty(), "{passed:#?}");
    }

    #[test]
    fn names_are_unique_and_every_group_has_cases() {
        let cases = cases();
        let names: std::collections::HashSet<&str> = cases.iter().map(|c| c.name).collect();
        assert_eq!(names.len(), cases.len());
        for group in [
            CaseGroup::Stiff,
            CaseGroup::Light,
            CaseGroup::Detectors,
            CaseGroup::Codes,
            CaseGroup::Numbers,
            CaseGroup::Hardware,
        ] {
            assert!(cases.iter().any(|case| case.group == group && case.quick));
        }
    }
}
