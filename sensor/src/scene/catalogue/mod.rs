//! Every table of a scene, and the documents made of them: `docs/scene.md` ([`reference()`]) and
//! `docs/scene.schema.json` ([`schema()`]).
//!
//! Bounds are what the arithmetic keeps precise, or what is physical, whichever is narrower; each
//! key says why.
//!
//! - Time in a simulation is whole chips in 64 bits and an offset within the chip:
//!   2^-53 of a chip at any time. Delays are read as one double, which keeps 2 fs
//!   (0.3 um of distance) up to 10 s, and at the shortest chip period still counts
//!   10^13 chips of the 9 10^15 that a double holds.
//! - Sample numbers are 64 bits: a scan has at most 2^60 samples.
//! - Counts are 64 bits: no more than one per two samples.
//!
//! Bounds that depend on several keys are checked where these are read, and stand
//! at the end of the document.

mod document;
mod schema;

pub use document::reference;
pub use schema::schema;

use super::array::{AMBIENT, ARRAY, LIGHT, PLANE, SPHERE};
use super::budget::{BACKGROUND, LINK};
use super::detector::{AFTERPULSING, CELL_CROSSTALK, COUNTER, CROSSTALK, DETECTOR, JITTER_TAIL};
use super::estimator::ESTIMATE;
use super::hardware::HARDWARE;
use super::keys::KeyTable;
use super::movement::FLUCTUATION;
use super::sampler::SAMPLER;
use super::scan::{SCAN, STEPS};
use super::source::{CODE, PATH, SOURCE};
use super::whole::CLOCK;

/// Every table of a scene.
pub(super) const TABLES: [&KeyTable; 23] = [
    &CLOCK,
    &SOURCE,
    &CODE,
    &DETECTOR,
    &BACKGROUND,
    &AFTERPULSING,
    &JITTER_TAIL,
    &COUNTER,
    &SAMPLER,
    &CROSSTALK,
    &CELL_CROSSTALK,
    &PATH,
    &LINK,
    &FLUCTUATION,
    &SCAN,
    &STEPS,
    &ESTIMATE,
    &HARDWARE,
    &ARRAY,
    &AMBIENT,
    &PLANE,
    &SPHERE,
    &LIGHT,
];

#[cfg(test)]
mod tests;
