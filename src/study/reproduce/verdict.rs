//! What a measurement with its interval says of a claim.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::statistics::Measured;

/// Whether a claim's criterion is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(into = "VerdictFields", try_from = "VerdictFields")]
#[schemars(with = "VerdictFields")]
pub enum Verdict {
    /// The whole interval meets it.
    Holds,
    /// The whole interval misses it.
    DoesNotHold,
    /// The interval has values of either kind; more scans (`--repeat`) may decide.
    Undecided,
}

impl Verdict {
    /// Of what is exact.
    pub fn exact(met: bool) -> Verdict {
        if met { Verdict::Holds } else { Verdict::DoesNotHold }
    }

    /// That a value is below a limit.
    pub fn below(measured: Measured, limit: f64) -> Verdict {
        Verdict::between(measured, f64::NEG_INFINITY, limit)
    }

    /// That a value is at least a limit.
    pub fn at_least(measured: Measured, limit: f64) -> Verdict {
        Verdict::between(measured, limit, f64::INFINITY)
    }

    /// That a value is in a range.
    pub fn between(measured: Measured, least: f64, most: f64) -> Verdict {
        let inside = |end: f64| (least..=most).contains(&end);
        if inside(measured.low) && inside(measured.high) {
            Verdict::Holds
        } else if measured.low > most || measured.high < least {
            Verdict::DoesNotHold
        } else {
            Verdict::Undecided
        }
    }

    /// That two criteria are met, of which each has its verdict.
    pub fn and(self, other: Verdict) -> Verdict {
        match (self, other) {
            (Verdict::DoesNotHold, _) | (_, Verdict::DoesNotHold) => Verdict::DoesNotHold,
            (Verdict::Undecided, _) | (_, Verdict::Undecided) => Verdict::Undecided,
            (Verdict::Holds, Verdict::Holds) => Verdict::Holds,
        }
    }

    /// In words, for people.
    pub fn text(self) -> &'static str {
        match self {
            Verdict::Holds => "holds",
            Verdict::DoesNotHold => "DOES NOT HOLD",
            Verdict::Undecided => "UNDECIDED",
        }
    }
}

/// A verdict in JSON.
#[derive(Serialize, Deserialize, schemars::JsonSchema)]
struct VerdictFields {
    /// Whether the criterion is known to be met.
    holds: bool,
    /// `holds`, `does_not_hold` or `undecided`.
    verdict: Cow<'static, str>,
}

impl From<Verdict> for VerdictFields {
    fn from(verdict: Verdict) -> VerdictFields {
        let name = match verdict {
            Verdict::Holds => "holds",
            Verdict::DoesNotHold => "does_not_hold",
            Verdict::Undecided => "undecided",
        };
        VerdictFields { holds: verdict == Verdict::Holds, verdict: name.into() }
    }
}

impl TryFrom<VerdictFields> for Verdict {
    type Error = String;

    fn try_from(fields: VerdictFields) -> Result<Verdict, String> {
        match &*fields.verdict {
            "holds" => Ok(Verdict::Holds),
            "does_not_hold" => Ok(Verdict::DoesNotHold),
            "undecided" => Ok(Verdict::Undecided),
            other => Err(format!("there is no verdict \"{other}\"")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn measured(low: f64, high: f64) -> Measured {
        Measured { value: 0.5 * (low + high), low, high }
    }

    #[test]
    fn an_interval_across_a_limit_decides_nothing() {
        assert_eq!(Verdict::below(measured(1.2, 1.4), 1.5), Verdict::Holds);
        assert_eq!(Verdict::below(measured(1.4, 1.6), 1.5), Verdict::Undecided);
        assert_eq!(Verdict::below(measured(1.6, 1.7), 1.5), Verdict::DoesNotHold);
        assert_eq!(Verdict::at_least(measured(0.98, 1.0), 0.99), Verdict::Undecided);
        let range = |low, high| Verdict::between(measured(low, high), 2.9, 3.5);
        assert_eq!(range(3.0, 3.1), Verdict::Holds);
        assert_eq!(range(2.8, 3.1), Verdict::Undecided);
        assert_eq!(range(2.8, 3.6), Verdict::Undecided);
        assert_eq!(range(2.7, 2.8), Verdict::DoesNotHold);
    }

    #[test]
    fn of_two_criteria_the_worse_verdict_stays() {
        let all = [Verdict::Holds, Verdict::Undecided, Verdict::DoesNotHold];
        for (i, a) in all.into_iter().enumerate() {
            for (j, b) in all.into_iter().enumerate() {
                assert_eq!(a.and(b), all[i.max(j)]);
            }
        }
    }
}
