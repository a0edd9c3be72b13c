//! What a measurement with its interval says of a claim.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::statistics::Measured;

/// Whether a claim's criterion is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(into = "VerdictFields", try_from = "VerdictFields")]
#[schemars(with = "VerdictFields")]
pub enum ClaimVerdict {
    /// The whole interval meets it.
    Holds,
    /// The whole interval misses it.
    DoesNotHold,
    /// The interval has values of either kind; more scans (`--repeat`) may decide.
    Undecided,
}

impl ClaimVerdict {
    /// Of what is exact.
    pub fn exact(met: bool) -> ClaimVerdict {
        if met { ClaimVerdict::Holds } else { ClaimVerdict::DoesNotHold }
    }

    /// That a value is below a limit.
    pub fn below(measured: Measured, limit: f64) -> ClaimVerdict {
        ClaimVerdict::between(measured, f64::NEG_INFINITY, limit)
    }

    /// That a value is at least a limit.
    pub fn at_least(measured: Measured, limit: f64) -> ClaimVerdict {
        ClaimVerdict::between(measured, limit, f64::INFINITY)
    }

    /// That a value is in a range.
    pub fn between(measured: Measured, least: f64, most: f64) -> ClaimVerdict {
        let inside = |end: f64| (least..=most).contains(&end);
        if inside(measured.low) && inside(measured.high) {
            ClaimVerdict::Holds
        } else if measured.low > most || measured.high < least {
            ClaimVerdict::DoesNotHold
        } else {
            ClaimVerdict::Undecided
        }
    }

    /// That two criteria are met, of which each has its verdict.
    pub fn and(self, other: ClaimVerdict) -> ClaimVerdict {
        match (self, other) {
            (ClaimVerdict::DoesNotHold, _) | (_, ClaimVerdict::DoesNotHold) => {
                ClaimVerdict::DoesNotHold
            }
            (ClaimVerdict::Undecided, _) | (_, ClaimVerdict::Undecided) => ClaimVerdict::Undecided,
            (ClaimVerdict::Holds, ClaimVerdict::Holds) => ClaimVerdict::Holds,
        }
    }

    /// In words, for people.
    pub fn text(self) -> &'static str {
        match self {
            ClaimVerdict::Holds => "holds",
            ClaimVerdict::DoesNotHold => "DOES NOT HOLD",
            ClaimVerdict::Undecided => "UNDECIDED",
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

impl From<ClaimVerdict> for VerdictFields {
    fn from(verdict: ClaimVerdict) -> VerdictFields {
        let name = match verdict {
            ClaimVerdict::Holds => "holds",
            ClaimVerdict::DoesNotHold => "does_not_hold",
            ClaimVerdict::Undecided => "undecided",
        };
        VerdictFields { holds: verdict == ClaimVerdict::Holds, verdict: name.into() }
    }
}

impl TryFrom<VerdictFields> for ClaimVerdict {
    type Error = String;

    fn try_from(fields: VerdictFields) -> Result<ClaimVerdict, String> {
        match &*fields.verdict {
            "holds" => Ok(ClaimVerdict::Holds),
            "does_not_hold" => Ok(ClaimVerdict::DoesNotHold),
            "undecided" => Ok(ClaimVerdict::Undecided),
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
        assert_eq!(ClaimVerdict::below(measured(1.2, 1.4), 1.5), ClaimVerdict::Holds);
        assert_eq!(ClaimVerdict::below(measured(1.4, 1.6), 1.5), ClaimVerdict::Undecided);
        assert_eq!(ClaimVerdict::below(measured(1.6, 1.7), 1.5), ClaimVerdict::DoesNotHold);
        assert_eq!(ClaimVerdict::at_least(measured(0.98, 1.0), 0.99), ClaimVerdict::Undecided);
        let range = |low, high| ClaimVerdict::between(measured(low, high), 2.9, 3.5);
        assert_eq!(range(3.0, 3.1), ClaimVerdict::Holds);
        assert_eq!(range(2.8, 3.1), ClaimVerdict::Undecided);
        assert_eq!(range(2.8, 3.6), ClaimVerdict::Undecided);
        assert_eq!(range(2.7, 2.8), ClaimVerdict::DoesNotHold);
    }

    #[test]
    fn of_two_criteria_the_worse_verdict_stays() {
        let all = [ClaimVerdict::Holds, ClaimVerdict::Undecided, ClaimVerdict::DoesNotHold];
        for (i, a) in all.into_iter().enumerate() {
            for (j, b) in all.into_iter().enumerate() {
                assert_eq!(a.and(b), all[i.max(j)]);
            }
        }
    }
}
