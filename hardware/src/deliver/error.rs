//! Why a scene's hardware cannot be emitted.

use std::borrow::Cow;

use thiserror::Error;

use crate::reference::predictor::ReferenceError;
use crate::rtl::back::FaultyDescription;

/// Why a scene's hardware cannot be emitted.
#[derive(Debug, Error)]
pub enum HdlError {
    /// Detectors whose references have periods of different lengths.
    #[error(
        "the detectors' reference codes have {found:?} chips per period; one scan walks all of \
         them, so they need one length"
    )]
    CodeLengths {
        /// Chips per period of each detector's reference.
        found: Vec<u64>,
    },
    /// A group of phase steps too short for the reference to go back.
    #[error(
        "the integration time is {chips} chips; with parallel = {parallel} and {lanes} samples per \
         chip the reference goes back by up to {needed} chips after each group, so integrate over \
         at least {needed} chips"
    )]
    ShortStep {
        /// Chips per phase step.
        chips: u64,
        /// Phase steps at once.
        parallel: u32,
        /// Samples per chip.
        lanes: u32,
        /// Chips that are needed.
        needed: u64,
    },
    /// A value beyond what the blocks are made for.
    #[error("{what} is {found}, but the hardware takes {limit}")]
    Limit {
        /// What.
        what: String,
        /// The scene's value.
        found: u64,
        /// What is possible.
        limit: Cow<'static, str>,
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
    Refused(#[from] FaultyDescription),
    /// The testbench's vectors could not be made.
    #[error("no vectors for the testbench: {0}")]
    Vectors(#[from] ReferenceError),
    /// The manifest could not be made.
    #[error("cannot make the manifest: {0}")]
    Manifest(serde_json::Error),
    /// The scene does not fit the board.
    #[error(transparent)]
    Board(#[from] super::board::BoardError),
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] crate::files::FileError),
}
