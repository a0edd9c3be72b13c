//! What the stress cases found: JSON and table.

use std::borrow::Cow;
use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use super::case::{Case, CaseBound, CaseError, CaseGroup, CaseMeasurement};
use crate::exact;

/// The JSON of `goldtof stress`.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct StressReport {
    /// Seed of all random numbers.
    pub seed: u64,
    /// The cases that were run, in their order.
    pub cases: Vec<CaseReport>,
}

/// One case's verdict.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct CaseReport {
    /// Its name.
    pub name: Cow<'static, str>,
    /// What it is about.
    pub group: CaseGroup,
    /// What was measured.
    pub what: Cow<'static, str>,
    /// The number; none when the measurement failed.
    #[serde(with = "exact")]
    #[schemars(with = "Option<exact::ExactNumber>")]
    pub measured: Option<f64>,
    /// Unit of measurement and bound.
    pub unit: String,
    /// What it must keep; none when the measurement failed.
    pub bound: Option<CaseBound>,
    /// Whether it keeps it.
    pub holds: bool,
    /// Why the bound is right.
    pub why: Cow<'static, str>,
    /// Why the measurement failed, if it did.
    pub error: Option<String>,
    /// Wall time.
    pub run_time_s: f64,
}

impl CaseReport {
    pub(super) fn new(
        case: &Case,
        outcome: Result<CaseMeasurement, CaseError>,
        run_time_s: f64,
    ) -> CaseReport {
        let (measured, error) = match outcome {
            Ok(measured) => (Some(measured), None),
            Err(error) => (None, Some(error.to_string())),
        };
        CaseReport {
            name: case.name.into(),
            group: case.group,
            what: case.what.into(),
            measured: measured.map(|m| m.value),
            unit: measured.map_or_else(String::new, |m| m.unit.to_owned()),
            bound: measured.map(|m| m.bound),
            holds: measured.is_some_and(|m| m.bound.holds(m.value)),
            why: case.why.into(),
            error,
            run_time_s,
        }
    }

    /// One line for people.
    pub fn line(&self) -> String {
        let verdict = if self.holds { "holds" } else { "FAILS" };
        let finding = match (self.measured, &self.bound, &self.error) {
            (Some(measured), Some(bound), _) => {
                format!("{} {} ({})", number(measured), self.unit, words(bound))
            }
            (_, _, error) => error.clone().unwrap_or_default(),
        };
        format!("{verdict}  {:<48} {finding}  {:.2} s", self.name, self.run_time_s)
    }
}

impl StressReport {
    /// Whether every case holds.
    pub fn all_hold(&self) -> bool {
        self.cases.iter().all(|case| case.holds)
    }

    /// The table in words: every case, and why for those that fail.
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for case in &self.cases {
            let _ = writeln!(text, "{}", case.line());
            if !case.holds {
                let _ = writeln!(text, "       {}; the bound: {}", case.what, case.why);
            }
        }
        let failing = self.cases.iter().filter(|case| !case.holds).count();
        let _ = writeln!(text, "{} cases, {failing} failing", self.cases.len());
        text
    }
}

fn words(bound: &CaseBound) -> String {
    match (bound.at_least, bound.at_most) {
        (Some(least), Some(most)) if least == most => format!("exactly {}", number(most)),
        (Some(least), Some(most)) => format!("{} to {}", number(least), number(most)),
        (Some(least), None) => format!("at least {}", number(least)),
        (None, Some(most)) => format!("at most {}", number(most)),
        (None, None) => "anything".to_owned(),
    }
}

/// Three digits, and an exponent where the number needs one.
fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == value.trunc() && magnitude < 1e6 {
        format!("{value}")
    } else if (1e-3..1e6).contains(&magnitude) {
        format!("{value:.3}")
    } else {
        format!("{value:.2e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_bounds_are_said() {
        assert_eq!(number(0.0), "0");
        assert_eq!(number(4.0), "4");
        assert_eq!(number(1.23456), "1.235");
        assert_eq!(number(3.2e-9), "3.20e-9");
        assert_eq!(words(&CaseBound::exactly(0.0)), "exactly 0");
        let between = CaseBound { at_least: Some(0.0), at_most: Some(0.5) };
        assert_eq!(words(&between), "0 to 0.500");
    }
}
