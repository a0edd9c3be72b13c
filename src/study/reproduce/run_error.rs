//! Why a figure could not be made.

use crate::code::CodeError;
use crate::estimate::PredictionError;
use crate::response::MeanResponseError;
use crate::simulate::scans::ScansError;

/// Why a figure could not be made.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A code could not be made.
    #[error(transparent)]
    Code(#[from] CodeError),
    /// Scans could not be simulated.
    #[error(transparent)]
    Scans(#[from] ScansError),
    /// The mean response could not be had.
    #[error(transparent)]
    MeanResponse(#[from] MeanResponseError),
    /// The estimator's mean answer could not be had.
    #[error(transparent)]
    Prediction(#[from] PredictionError),
    /// No statistics came of the scans.
    #[error("fewer than two of {scans} scans found the target; use more --repeat")]
    NoStatistics {
        /// Scans simulated.
        scans: u64,
    },
}
