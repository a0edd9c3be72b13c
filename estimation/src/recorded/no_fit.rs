//! Why a scene cannot be fitted to what was recorded.

use crate::estimate::histogram::Uncorrected;
use crate::histogram::correction::CorrectionError;
use crate::response::MeanResponseError;

/// Why a scene cannot be fitted.
#[derive(Debug, thiserror::Error)]
pub(super) enum NoFit {
    #[error(transparent)]
    Response(#[from] MeanResponseError),
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    #[error(transparent)]
    Uncorrected(#[from] Uncorrected),
    #[error("the counts do not determine what is unknown")]
    Undetermined,
}
