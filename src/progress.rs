//! How far a job is.

use std::fmt;

/// How far a job is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// What is being done, where nothing is counted.
    Stage(&'static str),
    /// Scans or clocks.
    Parts {
        /// Those that are done.
        done: u64,
        /// All.
        of: u64,
    },
}

impl fmt::Display for Progress {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Progress::Stage(what) => f.write_str(what),
            Progress::Parts { done, of } => write!(f, "{done} of {of}"),
        }
    }
}
