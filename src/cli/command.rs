//! What a command does.

use super::output::{Ending, Output};

/// What a command line asks for.
pub(super) trait Command {
    /// Does it, with the seed of all random numbers.
    fn run(&self, seed: u64, output: &Output) -> anyhow::Result<Ending>;
}
