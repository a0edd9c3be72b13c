//! Outcome of a command, and its exit status.

/// How a command that did its work ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// Exit status 0.
    Done,
    /// Exit status 1: what was checked does not hold.
    DoesNotHold,
    /// Exit status 4: a score is below what was asked for.
    BelowThreshold,
}

impl Ending {
    /// That of a command with `--check`, or without it, whose scans bear their expectations out
    /// or do not.
    pub fn of_check(check: bool, holds: bool) -> Ending {
        if check && !holds { Ending::DoesNotHold } else { Ending::Done }
    }
}
