//! From an avalanche to the time at which it is registered.

use rand_distr::{Distribution, StandardNormal};

use super::detector::{DetectorModel, JITTER_BOUND_SIGMAS};
use super::random::{RandomStream, StreamKey, StreamRng};
use super::time::ChipTime;

/// The registered time of a detection, relative to the start of its step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Whole chips.
    pub chip: u64,
    /// Offset inside the chip, 0 <= fraction < 1.
    pub fraction: f64,
}

/// Delay and jitter from the avalanche to its registered time.
#[derive(Debug, Clone)]
pub struct Registration<'m> {
    model: &'m DetectorModel,
    jitter: Option<StreamRng>,
    tail: Option<StreamRng>,
}

impl<'m> Registration<'m> {
    pub fn new(model: &'m DetectorModel, key: &StreamKey) -> Registration<'m> {
        Registration {
            model,
            jitter: model.jitter_chips.map(|_| key.stream(RandomStream::Jitter)),
            tail: model.tail.as_ref().map(|_| key.stream(RandomStream::Tail)),
        }
    }

    /// The registered time of an avalanche.
    #[inline]
    pub fn register(&mut self, avalanche: ChipTime) -> ChipTime {
        let mut shift = self.model.delay_chips;
        if let (Some(rng), Some(sigma)) = (&mut self.jitter, self.model.jitter_chips) {
            let normal: f64 = StandardNormal.sample(rng);
            shift += sigma * normal.clamp(-JITTER_BOUND_SIGMAS, JITTER_BOUND_SIGMAS);
        }
        if let (Some(rng), Some(tail)) = (&mut self.tail, &self.model.tail) {
            shift += tail.draw(rng);
        }
        avalanche.shifted(shift)
    }
}
