//! What a command does, and how it ends.

use super::output::Output;

/// What a command line asks for.
pub(super) trait Command {
    /// Does it, with the seed of all random numbers.
    fn run(&self, seed: u64, output: &Output) -> anyhow::Result<Ending>;
}

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
