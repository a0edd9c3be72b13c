//! One random stream per part of the model, found by number, not by order.

use rand::SeedableRng;
use rand_xoshiro::{SplitMix64, Xoshiro256PlusPlus, rand_core::Rng};

/// The generator of every stream.
pub type StreamRng = Xoshiro256PlusPlus;

/// A part of the model that draws random numbers of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
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
    /// The on-light of one path, by its index in the scene.
    Path(usize),
}

impl Part {
    fn number(self) -> u64 {
        match self {
            Part::ConstantLight => 0,
            Part::Afterpulsing => 1,
            Part::Jitter => 2,
            Part::Transition => 3,
            // Beyond any index of a path.
            Part::Counts => u64::MAX,
            Part::Start => u64::MAX - 1,
            Part::Path(index) => 4 + index as u64,
        }
    }
}

/// Which phase step of which detector is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StreamKey {
    /// The user's seed.
    pub seed: u64,
    /// Index of the detector in the scene.
    pub detector: u64,
    /// Number of the phase step in the scan, from 0.
    pub step: u64,
    /// Number of the scan, from 0.
    pub repetition: u64,
}

impl StreamKey {
    /// The stream of one part: the same for the same key, whatever else exists.
    pub fn stream(&self, part: Part) -> StreamRng {
        StreamRng::seed_from_u64(self.hash(part))
    }

    /// The number that a part's stream is seeded with.
    pub fn hash(&self, part: Part) -> u64 {
        [self.detector, self.step, self.repetition, part.number()]
            .into_iter()
            .fold(mix(self.seed), scatter)
    }

    /// The number that a path's movement is drawn by: the same for every detector
    /// and phase step of a scan, because it is the scene that moves.
    pub fn hash_of_movement(&self, path: usize) -> u64 {
        let of_scan = StreamKey {
            // No detector and no step has this number.
            detector: u64::MAX,
            step: u64::MAX,
            ..*self
        };
        of_scan.hash(Part::Path(path))
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
                        let key = StreamKey {
                            seed,
                            detector,
                            step,
                            repetition,
                        };
                        for part in [
                            Part::ConstantLight,
                            Part::Afterpulsing,
                            Part::Jitter,
                            Part::Transition,
                            Part::Path(0),
                            Part::Path(1),
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
