//! One random stream per part of the model, found by number, not by order.

use crate::scan::{Group, Step};
use rand::SeedableRng;
use rand_xoshiro::{SplitMix64, Xoshiro256PlusPlus, rand_core::Rng};

/// The generator of every stream.
pub type StreamRng = Xoshiro256PlusPlus;

/// A part of the model that draws random numbers of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RandomStream {
    /// Off-light, background and dark counts, which are one Poisson process.
    ConstantLight,
    /// Numbers and delays of afterpulses.
    Afterpulsing,
    /// Timing jitter of the registered time.
    Jitter,
    /// The counter's sign near an edge.
    Transition,
    /// Counts drawn as such, without photons.
    Counts,
    /// When a detector that is nearly always blind is first ready.
    Start,
    /// What detections are late beside jitter.
    Tail,
    /// Which of its avalanches other detectors hear.
    Crosstalk,
    /// Which of several cells, or detectors, light falls on.
    Member,
    /// The on-light of one path, by its number ([`paths_to`](super::paths::paths_to)).
    Path(u64),
}

impl RandomStream {
    fn number(self) -> u64 {
        match self {
            RandomStream::ConstantLight => 0,
            RandomStream::Afterpulsing => 1,
            RandomStream::Jitter => 2,
            RandomStream::Transition => 3,
            RandomStream::Counts => 4,
            RandomStream::Start => 5,
            RandomStream::Tail => 7,
            RandomStream::Crosstalk => 8,
            RandomStream::Member => 9,
            // As good as random: none of the above.
            RandomStream::Path(number) => scatter(6, number),
        }
    }
}

/// Which light of which detector is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamKey {
    /// The user's seed.
    pub seed: u64,
    /// The number of the detector's name.
    pub detector: u64,
    /// The steps that share the light.
    pub group: Group,
    /// Number of the scan, from 0.
    pub repetition: u64,
}

impl StreamKey {
    /// The stream of one part: the same for the same key, whatever else exists.
    pub fn stream(&self, part: RandomStream) -> StreamRng {
        StreamRng::seed_from_u64(self.hash(part))
    }

    /// The number that a part's stream is seeded with.
    pub fn hash(&self, part: RandomStream) -> u64 {
        self.hash_of(self.group.0, part)
    }

    /// The stream of a part that every step of the group has for itself.
    pub fn stream_of_step(&self, step: Step, part: RandomStream) -> StreamRng {
        StreamRng::seed_from_u64(self.hash_of_step(step, part))
    }

    /// The number that this stream is seeded with.
    pub fn hash_of_step(&self, step: Step, part: RandomStream) -> u64 {
        self.hash_of(step.0, part)
    }

    fn hash_of(&self, number: u64, part: RandomStream) -> u64 {
        [self.detector, number, self.repetition, part.number()]
            .into_iter()
            .fold(mix(self.seed), scatter)
    }

    /// The number that a path's movement is drawn by: the same for every detector
    /// and group of a scan, because it is the scene that moves.
    pub fn hash_of_movement(&self, path: u64) -> u64 {
        let of_scan = StreamKey {
            // No detector and no group has this number.
            detector: u64::MAX,
            group: Group(u64::MAX),
            ..*self
        };
        of_scan.hash(RandomStream::Path(path))
    }
}

/// A number that is as good as random, for each `word` another one.
pub fn scatter(hash: u64, word: u64) -> u64 {
    mix(hash ^ word)
}

/// One step of SplitMix64: a bijection of 64-bit words that scatters
/// neighbours.
fn mix(word: u64) -> u64 {
    SplitMix64::from_seed(word.to_le_bytes()).next_u64()
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn neighbouring_keys_have_different_streams() {
        let mut first_words = HashSet::new();
        for seed in 0..4 {
            for detector in 0..2 {
                for step in 0..16 {
                    for repetition in 0..4 {
                        let key = StreamKey { seed, detector, group: Group(step), repetition };
                        for part in [
                            RandomStream::ConstantLight,
                            RandomStream::Afterpulsing,
                            RandomStream::Jitter,
                            RandomStream::Transition,
                            RandomStream::Path(0),
                            RandomStream::Path(1),
                        ] {
                            first_words.insert(key.stream(part).next_u64());
                        }
                    }
                }
            }
        }
        assert_eq!(first_words.len(), 4 * 2 * 16 * 4 * 6);
    }
}
