//! Why a scene's hardware cannot be emitted.

use std::path::PathBuf;

use thiserror::Error;

use super::back::Refusal;
use crate::model::reference::ReferenceError;

/// Why a scene's hardware cannot be emitted.
#[derive(Debug, Error)]
pub enum HdlError {
    /// Something that no block does yet.
    #[error("{what} is not built yet: {found} asked for, {limit} possible")]
    NotBuilt {
        /// What.
        what: &'static str,
        /// How many the scene asks for.
        found: u64,
        /// How many there can be.
        limit: &'static str,
    },
    /// A value beyond what the blocks are made for.
    #[error("{what} is {found}, but the hardware takes {limit}")]
    Limit {
        /// What.
        what: String,
        /// The scene's value.
        found: u64,
        /// What is possible.
        limit: &'static str,
    },
    /// A code whose parts do not agree.
    #[error("source `{source_name}`: {problem}")]
    Code {
        /// The source's name.
        source_name: String,
        /// What does not agree.
        problem: String,
    },
    /// The back end refused a block.
    #[error("the hardware description is not sound, please report it: {0}")]
    Refused(#[from] Refusal),
    /// The bench's vectors could not be made.
    #[error("no vectors for the bench: {0}")]
    Vectors(#[from] ReferenceError),
    /// A file could not be written.
    #[error("cannot write {}: {error}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        #[source]
        error: std::io::Error,
    },
}
