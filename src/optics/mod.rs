//! Light and detections: from a scene to the registered times of a SPAD.
//!
//! [`DetectorModel`] holds what one detector sees of a scene, in chips.
//! [`DetectorModel::step`] simulates one phase step, photon by photon, as an
//! iterator over [`Detection`]s; [`PulseStream`] turns the steps of a scan into
//! the sampled pulses that the hardware gets, and [`count_step`] counts a step
//! as the article's continuous-time counter does. [`MeanResponse`] gives what
//! the counts are on average, and their variance, without random numbers.
//!
//! Every step depends on nothing but the scene, the seed and its own number, so
//! steps may be made in any order, on any thread, or many side by side.

mod afterpulsing;
mod counter;
mod detector;
pub mod fast;
mod full;
mod light;
mod mean_response;
mod movement;
mod paths;
mod random;
mod reorder;
mod sampled;
mod step;
mod time;

pub use counter::{StepCount, count_step};
pub use detector::DetectorModel;
pub use full::OptionalPart;
pub use light::{LightRates, photon_rate_hz};
pub use mean_response::{
    CountMoments, CountSampler, CountingTier, Effort, GroupMoments, Light, LightPath, MeanCount,
    MeanResponse, MeanResponseError, SecondMoments, check_merging, merged_share,
};
pub(crate) use mean_response::{cholesky, in_parallel};
pub use sampled::{Pulse, PulseStream};
pub use step::{Detection, StepDetections};
