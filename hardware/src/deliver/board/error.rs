//! Why a scene does not fit a board.

use thiserror::Error;

/// Why a scene does not fit a board, and what would: nobody has to tell one reason from another, and each
/// stands where it is found.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct BoardError(pub(super) String);
