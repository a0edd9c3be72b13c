//! Ranges of numbers, in words.

use std::ops::RangeInclusive;

/// A range that a number must lie in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Bounds {
    /// Either sign.
    Any,
    /// 0 or more.
    NotNegative,
    /// Above 0.
    Positive,
    /// 0 to 1, both included.
    Share,
    /// 0 included, 1 not.
    ProperShare,
}

impl Bounds {
    /// Whether it holds `value`.
    pub(super) fn contains(self, value: f64) -> bool {
        match self {
            Bounds::Any => true,
            Bounds::NotNegative => value >= 0.0,
            Bounds::Positive => value > 0.0,
            Bounds::Share => (0.0..=1.0).contains(&value),
            Bounds::ProperShare => (0.0..1.0).contains(&value),
        }
    }

    /// The range in words.
    pub(super) fn text(self) -> &'static str {
        match self {
            Bounds::Any => "finite",
            Bounds::NotNegative => "0 or more",
            Bounds::Positive => "greater than 0",
            Bounds::Share => "from 0 to 1",
            Bounds::ProperShare => "from 0 to less than 1",
        }
    }
}

/// What is wrong with a number that `range` does not hold; `None` is one that 64
/// bits do not hold either. No end beyond which nothing is counted is named.
pub(super) fn outside(number: Option<i64>, range: &RangeInclusive<i64>) -> String {
    const ENDLESS: i64 = i64::MAX / 4;
    let (least, most) = (*range.start(), *range.end());
    if most < ENDLESS {
        format!("outside {least} to {most}")
    } else if number.is_some_and(|number| number < least) {
        format!("less than {least}")
    } else {
        "beyond what can be counted".to_owned()
    }
}
