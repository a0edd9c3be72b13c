//! Stiff, extreme and hostile cases: `goldtof stress`.
//!
//! Every case measures one number and states the bound that it must keep, and
//! why that bound is right: a closed form, exact arithmetic, saturation at one
//! count per dead time, a theorem, or equality by construction. The expectation
//! never comes from the code under test.

mod bench;
mod codes;
mod detectors;
mod hardware;
mod light;
mod modulation;
mod numbers;
mod report;
mod scenes;
mod statistics;
mod stiff;

use std::time::Instant;

use serde::Serialize;

pub use report::{CaseReport, StressReport};

use crate::cosim::error::CosimError;

/// What a case is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Group {
    /// Time scales many decades apart.
    Stiff,
    /// No light, too much light, unmodulated light.
    Light,
    /// Detectors at the ends of their parameters.
    Detectors,
    /// Codes and scans at the ends of theirs.
    Codes,
    /// Large, cancelling and unequal numbers.
    Numbers,
    /// The Verilog at its limits.
    Hardware,
}

/// A stress case.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Unique name, for `--case`.
    pub name: &'static str,
    /// What it is about.
    pub group: Group,
    /// Whether it is in the fast subset.
    pub quick: bool,
    /// What is measured.
    pub what: &'static str,
    /// Why the bound is right.
    pub why: &'static str,
    /// Does the measurement with a seed, which those that draw nothing leave aside.
    pub run: fn(u64) -> anyhow::Result<Measured>,
}

/// A measured number and the bound that it must keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// The number.
    pub value: f64,
    /// Its unit, for people.
    pub unit: &'static str,
    /// What it must keep.
    pub bound: Bound,
}

/// What a number must keep. NaN keeps nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bound {
    /// Smallest value allowed.
    pub at_least: Option<f64>,
    /// Largest value allowed.
    pub at_most: Option<f64>,
}

impl Bound {
    /// No more than `limit`.
    pub fn at_most(limit: f64) -> Bound {
        Bound {
            at_least: None,
            at_most: Some(limit),
        }
    }

    /// This value and no other.
    pub fn exactly(value: f64) -> Bound {
        Bound {
            at_least: Some(value),
            at_most: Some(value),
        }
    }

    /// Whether `value` keeps the bound.
    pub fn holds(&self, value: f64) -> bool {
        !value.is_nan()
            && self.at_least.is_none_or(|least| value >= least)
            && self.at_most.is_none_or(|most| value <= most)
    }
}

impl Measured {
    /// A number that must not exceed `limit`.
    fn at_most(value: f64, unit: &'static str, limit: f64) -> anyhow::Result<Measured> {
        Ok(Measured {
            value,
            unit,
            bound: Bound::at_most(limit),
        })
    }

    /// A number that must be exactly `expected`.
    fn exactly(value: f64, unit: &'static str, expected: f64) -> anyhow::Result<Measured> {
        Ok(Measured {
            value,
            unit,
            bound: Bound::exactly(expected),
        })
    }

    /// Things that must not occur.
    fn none(number: usize, unit: &'static str) -> anyhow::Result<Measured> {
        Measured::exactly(number as f64, unit, 0.0)
    }

    /// Deviation from a closed form in standard errors, which must be at most
    /// four: by chance once in 16,000.
    fn deviation(standard_errors: f64) -> anyhow::Result<Measured> {
        Measured::at_most(standard_errors.abs(), "standard errors", 4.0)
    }
}

/// Every case, group by group.
pub fn cases() -> Vec<Case> {
    [
        stiff::CASES,
        light::CASES,
        modulation::CASES,
        detectors::CASES,
        codes::CASES,
        numbers::CASES,
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
) -> anyhow::Result<StressReport> {
    let mut report = StressReport {
        seed,
        cases: Vec::new(),
    };
    for case in cases {
        let case = run_case(case, seed)?;
        on_case(&case);
        report.cases.push(case);
    }
    Ok(report)
}

fn run_case(case: &Case, seed: u64) -> anyhow::Result<CaseReport> {
    let started = Instant::now();
    let outcome = (case.run)(seed);
    let run_time_s = started.elapsed().as_secs_f64();
    match outcome {
        Ok(measured) => Ok(CaseReport::new(case, Ok(measured), run_time_s)),
        Err(error) => match error.downcast_ref::<CosimError>() {
            Some(tool) if tool.is_tool() => Err(error),
            _ => Ok(CaseReport::new(case, Err(error), run_time_s)),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(run: fn(u64) -> anyhow::Result<Measured>) -> Case {
        Case {
            name: "a-case",
            group: Group::Numbers,
            quick: true,
            what: "a number",
            why: "for the test",
            run,
        }
    }

    #[test]
    fn a_case_outside_its_bound_or_with_an_error_does_not_hold() {
        let outside = case(|_| Measured::at_most(2.5, "apples", 2.0));
        let failing = case(|_| anyhow::bail!("out of apples"));
        let undefined = case(|_| Measured::at_most(f64::NAN, "apples", 2.0));
        let inside = case(|_| Measured::at_most(2.0, "apples", 2.0));
        let report = run(&[outside, failing, undefined, inside], 1, |_| ()).unwrap();
        let holds: Vec<bool> = report.cases.iter().map(|case| case.holds).collect();
        assert_eq!(holds, [false, false, false, true]);
        assert!(!report.all_hold());
        assert_eq!(report.cases[1].error.as_deref(), Some("out of apples"));
        assert!(run(&[inside], 1, |_| ()).unwrap().all_hold());
    }

    #[test]
    fn cases_get_the_seed_and_the_report_says_it() {
        let seed = case(|seed| Measured::exactly(seed as f64, "", 7.0));
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
        let exactly = Bound::exactly(3.0);
        assert!(exactly.holds(3.0) && !exactly.holds(3.0000001) && !exactly.holds(2.9999999));
        assert!(!Bound::at_most(1.0).holds(f64::NAN));
    }

    #[test]
    fn names_are_unique_and_every_group_has_cases() {
        let cases = cases();
        let names: std::collections::HashSet<&str> = cases.iter().map(|c| c.name).collect();
        assert_eq!(names.len(), cases.len());
        for group in [
            Group::Stiff,
            Group::Light,
            Group::Detectors,
            Group::Codes,
            Group::Numbers,
            Group::Hardware,
        ] {
            assert!(cases.iter().any(|case| case.group == group && case.quick));
        }
    }
}
