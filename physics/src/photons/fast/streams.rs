//! One random stream per lane, for one part of the model.

use rand_xoshiro::{SplitMix64, rand_core::Rng, rand_core::SeedableRng};

use super::arithmetic::{LANES, LaneWords};

/// One xoshiro128+ generator for each lane (Blackman and Vigna, "Scrambled
/// linear pseudorandom number generators", 2021), the one its authors recommend
/// for floating point: only the lowest bits are weak, and these decide nothing.
///
/// The stream of a lane is set by the phase step that the lane simulates, and
/// goes on by one word per iteration, whatever the other lanes do.
#[derive(Debug, Clone)]
pub struct LaneStreams([LaneWords; 4]);

impl LaneStreams {
    pub fn new() -> LaneStreams {
        LaneStreams([LaneWords::all(1); 4])
    }

    /// Starts the stream of one lane at a key.
    pub fn restart(&mut self, lane: usize, key: u64) {
        let mut words = SplitMix64::seed_from_u64(key);
        let (a, b) = (words.next_u64(), words.next_u64());
        let state = [a as u32, (a >> 32) as u32, b as u32, (b >> 32) as u32];
        for (words, state) in self.0.iter_mut().zip(state) {
            words[lane] = state;
        }
    }

    /// The next word of every lane.
    #[inline(always)]
    pub fn next(&mut self) -> LaneWords {
        let [s0, s1, s2, s3] = &mut self.0;
        let mut words = LaneWords::all(0);
        for lane in 0..LANES {
            words[lane] = s0[lane].wrapping_add(s3[lane]);
            let shifted = s1[lane] << 9;
            s2[lane] ^= s0[lane];
            s3[lane] ^= s1[lane];
            s1[lane] ^= s2[lane];
            s0[lane] ^= s3[lane];
            s2[lane] ^= shifted;
            s3[lane] = s3[lane].rotate_left(11);
        }
        words
    }
}

#[cfg(test)]
mod tests {
    use rand_xoshiro::Xoshiro128Plus;

    use super::*;

    #[test]
    fn each_lane_is_the_published_generator_on_its_own() {
        let mut streams = LaneStreams::new();
        streams.restart(3, 11);
        streams.restart(4, 12);
        let mut seed = [0; 16];
        SplitMix64::seed_from_u64(11).fill_bytes(&mut seed);
        let mut published = Xoshiro128Plus::from_seed(seed);
        for _ in 0..500 {
            assert_eq!(streams.next()[3], published.next_u32());
        }
        // Another lane's new stream changes nothing.
        streams.restart(4, 13);
        for _ in 0..500 {
            assert_eq!(streams.next()[3], published.next_u32());
        }
    }
}
