//! What a stress case is: a measurement, and the bound that it must keep.

use std::error::Error;

use serde::{Deserialize, Serialize};

/// What a case is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Group")]
pub enum CaseGroup {
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
    pub group: CaseGroup,
    /// Whether it is in the fast subset.
    pub quick: bool,
    /// What is measured.
    pub what: &'static str,
    /// Why the bound is right.
    pub why: &'static str,
    /// Does the measurement with a seed, which those that draw nothing leave aside.
    pub run: fn(u64) -> Result<CaseMeasurement, CaseError>,
}

/// A table of cases: group, `quick` or `slow`, and name; what is measured; why the bound is
/// right; the measurement, which has the bound.
macro_rules! cases {
    ($($group:ident $speed:ident $name:literal: $what:expr, $why:expr, $run:expr;)*) => {
        &[$($crate::study::stress::case::Case {
            name: $name,
            group: $crate::study::stress::case::CaseGroup::$group,
            quick: $crate::study::stress::case::is_quick(stringify!($speed)),
            what: $what,
            why: $why,
            run: $run,
        }),*]
    };
}
pub(super) use cases;

/// Whether a table says so of a case.
pub(super) const fn is_quick(speed: &str) -> bool {
    match speed.as_bytes() {
        b"quick" => true,
        b"slow" => false,
        _ => panic!("a case is quick or slow"),
    }
}

/// Why a case has no measurement: what went wrong, or that what it rests on is not so.
pub type CaseError = Box<dyn Error>;

/// Ends a case whose measurement would rest on something that is not so.
macro_rules! ensure {
    ($condition:expr, $($message:tt)+) => {
        let holds: bool = $condition;
        if !holds {
            return Err(format!($($message)+).into());
        }
    };
}
pub(super) use ensure;

/// A measured number and the bound that it must keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaseMeasurement {
    /// The number.
    pub value: f64,
    /// Its unit, for people.
    pub unit: &'static str,
    /// What it must keep.
    pub bound: CaseBound,
}

/// What a number must keep. NaN keeps nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[schemars(rename = "Bound")]
pub struct CaseBound {
    /// Smallest value allowed.
    pub at_least: Option<f64>,
    /// Largest value allowed.
    pub at_most: Option<f64>,
}

impl CaseBound {
    /// This value and no other.
    pub fn exactly(value: f64) -> CaseBound {
        CaseBound { at_least: Some(value), at_most: Some(value) }
    }

    /// Whether `value` keeps the bound.
    pub fn holds(&self, value: f64) -> bool {
        !value.is_nan()
            && self.at_least.is_none_or(|least| value >= least)
            && self.at_most.is_none_or(|most| value <= most)
    }
}

impl CaseMeasurement {
    /// A number between two.
    pub(super) fn between(
        value: f64,
        unit: &'static str,
        [least, most]: [f64; 2],
    ) -> Result<CaseMeasurement, CaseError> {
        let bound = CaseBound { at_least: Some(least), at_most: Some(most) };
        Ok(CaseMeasurement { value, unit, bound })
    }

    /// The largest magnitude of some errors, each no more than `limit`. Of no errors it would
    /// say nothing.
    pub(super) fn largest(
        errors: impl IntoIterator<Item = f64>,
        unit: &'static str,
        limit: f64,
    ) -> Result<CaseMeasurement, CaseError> {
        CaseMeasurement::between(worst(errors), unit, [0.0, limit])
    }

    /// A number that must be exactly `expected`.
    pub(super) fn exactly(
        value: f64,
        unit: &'static str,
        expected: f64,
    ) -> Result<CaseMeasurement, CaseError> {
        Ok(CaseMeasurement { value, unit, bound: CaseBound::exactly(expected) })
    }

    /// Things that must not occur among `seen` of their kind, of which there must be some.
    pub(super) fn none(
        number: usize,
        seen: usize,
        unit: &'static str,
    ) -> Result<CaseMeasurement, CaseError> {
        ensure!(seen > 0, "nothing was seen in which there could be any {unit}");
        CaseMeasurement::exactly(number as f64, unit, 0.0)
    }

    /// Largest deviation from closed forms in standard errors, which must be at most
    /// four: by chance once in 16,000.
    pub(super) fn deviation(
        standard_errors: impl IntoIterator<Item = f64>,
    ) -> Result<CaseMeasurement, CaseError> {
        CaseMeasurement::largest(standard_errors, "standard errors", 4.0)
    }
}

/// The value of largest magnitude; NaN if one is NaN, or there is none.
pub(super) fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    values.into_iter().map(f64::abs).reduce(larger).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_value_is_the_largest_or_undefined() {
        assert_eq!(worst([0.5, -2.0, 1.0]), 2.0);
        assert!(worst([0.5, f64::NAN, 1.0]).is_nan());
        assert!(worst([]).is_nan() && worst([f64::NAN, 1.0]).is_nan());
    }
}
