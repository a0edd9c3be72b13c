//! Mean avalanches of a detector, by the law that it has.

use super::chain::{Chain, states_needed};
use super::forward::{self, AllAndMerged};
use super::grid::Grid;
use super::{MAX_STATES, MeanResponseError, paralyzable, poisson, with_states};
use crate::photons::DetectorModel;

/// Mean detections of one code period.
pub(super) fn detections(
    model: &DetectorModel,
    grid: &Grid,
) -> Result<AllAndMerged, MeanResponseError> {
    if model.dead_time_chips <= 0.0 {
        return Ok(poisson::solve(grid).0);
    }
    if model.is_paralyzable {
        return Ok(paralyzable::solve(grid));
    }
    let needed = states_needed(model.afterpulsing, model.dead_time_chips);
    if needed > MAX_STATES {
        return Err(MeanResponseError::TooManyAfterpulses { limit: MAX_STATES });
    }
    Ok(with_states!(needed, M => {
        let chain = Chain::<M>::new(model.afterpulsing, model.dead_time_chips);
        forward::solve(grid, &chain, grid.round(), None)
    }))
}
