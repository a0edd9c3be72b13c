//! Situations that show whether a board is right, and how often each came up.

use goldtof_wire::REQUEST_BYTES;
use serde::Serialize;

use super::model::{Facts, MOST_PLACES};

/// A situation that shows whether a board is right.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[schemars(rename = "CoverPoint")]
pub struct BoardCoverPoint {
    /// What comes up.
    pub name: String,
    /// How often it did.
    pub reached: u64,
}

/// Those of a board.
pub(super) struct Cover(pub Vec<BoardCoverPoint>);

/// Of each byte of a request from this one on.
const OF_BYTES: [(&str, usize); 3] = [
    ("a request with a wrong bit in byte", 0),
    ("a request that is torn before byte", 1),
    ("a byte without its stop bit before byte", 1),
];

/// Hits of a sample beyond what half of its counter holds.
pub(super) const MANY_HITS: &str = "more than 65535 hits of a sample are counted";

/// A place that the last result of the sensor's own scans has.
pub(super) const LAST_PLACE: &str = "a place as large as the sensor's scans have";

/// A loss that has to wait until the one before it has been told.
pub(super) const LOSS_BEHIND_LOSS: &str = "results are lost less than half a FIFO behind a loss";

/// A situation, and the boards on which it has to come up.
type Point = (&'static str, fn(&Facts) -> bool);

const POINTS: [Point; 36] = [
    ("a pause within a request", |_| true),
    ("a request of an unknown kind", |_| true),
    ("a request while one is answered", |_| true),
    ("a block of the scene's text", |facts| !facts.text.is_empty()),
    ("a write that is answered with OKAY", |facts| facts.has_registers),
    ("a write that is answered with SLVERR", |facts| facts.has_registers),
    ("a write that is answered with DECERR", |facts| facts.has_registers),
    ("a read that is answered with OKAY", |facts| facts.has_registers),
    ("a read that is answered with SLVERR", |facts| facts.has_registers),
    ("a read that is answered with DECERR", |facts| facts.has_registers),
    ("an answer between frames of results", |_| true),
    ("a frame of one result", |facts| facts.sums.is_none()),
    // The first frame of a sum takes some of its results.
    ("a frame of 255 results", |facts| facts.sums.is_none() || facts.results_of_scan > 300),
    ("a frame that ends a scan", |_| true),
    ("a frame within a scan", |_| true),
    ("the sequence number has its top bit", |_| true),
    ("the sequence number goes round", |facts| facts.sums.is_none()),
    ("places beyond 8 bits", |facts| facts.sums.is_none() || facts.results_of_scan > 256),
    (LAST_PLACE, |facts| {
        facts.loses() && facts.sums.is_none() && facts.results_of_scan <= MOST_PLACES
    }),
    ("the FIFO's places go round", |facts| facts.sums.is_none()),
    ("results are lost", Facts::loses),
    (LOSS_BEHIND_LOSS, |facts| facts.loses() && facts.sums.is_none()),
    ("a reset before a loss is told", |facts| facts.loses() && facts.sums.is_none()),
    ("a reset behind a loss that was told", |facts| facts.loses() && facts.sums.is_none()),
    ("a scan is whole behind a loss", Facts::loses),
    ("a scan is lost with the FIFO more than half full", Facts::loses),
    ("a scan is taken with the FIFO less than half full", Facts::loses),
    ("the number of lost results goes round", Facts::loses_a_round),
    ("the core waits for the line", |facts| facts.packing.waits),
    ("o_overrun is told", |_| true),
    ("o_saturated is told", |facts| facts.has_saturated),
    (MANY_HITS, |facts| facts.identity.counts_samples),
    ("a reset within a frame", |_| true),
    ("a reset that the line's clock may miss", |_| true),
    ("results of the board's own core", |_| true),
    ("registers of the board's own core", |facts| facts.has_registers),
];

impl Cover {
    /// Those that have to come up on a board, none of which has.
    pub(super) fn of(facts: &Facts) -> Cover {
        let of_bytes = OF_BYTES.iter().flat_map(|(name, first)| {
            (*first..REQUEST_BYTES).map(move |byte| format!("{name} {byte}"))
        });
        let meant = POINTS.iter().filter(|(_, is_meant)| is_meant(facts));
        let hits = (0..facts.places_of_hits()).map(|k| format!("hits of sample {k} are counted"));
        let names = of_bytes.chain(meant.map(|(name, _)| (*name).to_owned())).chain(hits);
        Cover(names.map(|name| BoardCoverPoint { name, reached: 0 }).collect())
    }

    /// Counts a situation; one that is not among them is of no interest for this board.
    pub(super) fn reach(&mut self, name: &str) {
        if let Some(point) = self.0.iter_mut().find(|point| point.name == name) {
            point.reached += 1;
        }
    }

    /// Whether each has come up.
    pub(super) fn is_whole(&self) -> bool {
        self.0.iter().all(|point| point.reached > 0)
    }
}
