//! Jobs in parts, on one machine or many.
//!
//! A [`JobPart`] of a job is a run of its own, which writes a file of its own into the job's
//! [`ShardFolder`]; runs are independent. A file ([`Shard`]) holds the job's complete definition
//! ([`Job`]) and the part's results: all parts together equal one run, bit for bit. Seeds follow
//! from the place in the job, and sums that depend on their order are formed at the end.

mod file;
mod folder;
mod job;
mod join;
mod part;

pub use file::Shard;
pub use folder::{Collected, ShardFolder, listed};
pub use job::{GradeJob, ImageJob, Job, PartResults, PointRows, Results, SimulateJob, SweepJob};
pub use join::{
    figures, pixel_rows, rows, simulation, stress_report, tables, variants, whole_grade,
};
pub use part::JobPart;

use crate::files::FileError;
use crate::scene::SceneErrors;
use crate::simulate::scans::ScansError;

/// Why a shard cannot be written, or shards not be merged.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    /// A file or folder cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// A file is not a shard.
    #[error("{path}: cannot be read as a shard: {reason}; remove it and do that shard again")]
    Unreadable {
        /// The file.
        path: String,
        /// Why not.
        reason: String,
    },
    /// A shard of another job has the name of one that is to be made.
    #[error(
        "{path} is of another job: {differences} (there: in that file); name another folder with \
         --out, or remove this one to begin anew"
    )]
    Taken {
        /// The file.
        path: String,
        /// What differs.
        differences: String,
    },
    /// Shards of several jobs.
    #[error(
        "{path} is not of the same job as {first}: {differences} (there: in the second); keep the \
         shards of one job in a folder"
    )]
    Other {
        /// A file.
        path: String,
        /// The first.
        first: String,
        /// What differs.
        differences: String,
    },
    /// A folder without shards.
    #[error("{path} has no shards; a command with --shard I/N and --out writes them there")]
    None {
        /// The folder.
        path: String,
    },
    /// Not all shards are there.
    #[error(
        "{path} has {found} of {of} shards; {missing} missing: give the command again with \
         --shard {example}/{of}, and so on"
    )]
    Missing {
        /// The folder.
        path: String,
        /// How many are there.
        found: usize,
        /// How many there should be.
        of: u64,
        /// Their numbers.
        missing: String,
        /// One of them.
        example: u64,
    },
    /// A shard's results are of another part of the job.
    #[error("shard {part} does not hold its part of the job: {reason}; do it again")]
    Unfit {
        /// Which one.
        part: JobPart,
        /// What is wrong.
        reason: &'static str,
    },
    /// The job in the shards is invalid.
    #[error("the shards are of a job that cannot be done: {reason}; do all shards again")]
    NoJob {
        /// What is wrong.
        reason: String,
    },
    /// The job's scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneErrors),
    /// Nothing can be concluded from the scans.
    #[error(transparent)]
    Scans(#[from] ScansError),
}
