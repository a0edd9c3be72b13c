//! Sample words that try the hardware: noise, bursts, long levels, resets.

use super::naive_sensor::Inputs;

/// A small generator of its own, so that a failing case can be repeated from
/// its seed alone.
pub struct Noise(u64);

impl Noise {
    pub fn new(seed: u64) -> Noise {
        Noise(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    pub fn below(&mut self, bound: u64) -> u64 {
        (self.next() >> 11) % bound
    }

    /// Inputs for `clocks` clocks, each drawn by `draw`.
    pub fn words(
        &mut self,
        clocks: usize,
        mut draw: impl FnMut(&mut Noise) -> Vec<u128>,
    ) -> Vec<Vec<u128>> {
        (0..clocks).map(|_| draw(self)).collect()
    }
}

/// `cycles` inputs of `lanes` samples, all inputs together, that begin with
/// a reset and have one more in the middle.
pub fn inputs(lanes: u32, cycles: usize, seed: u64) -> Vec<Inputs> {
    let mut noise = Noise::new(seed);
    let mask = u128::MAX >> (128 - lanes);
    let second_reset = cycles / 2 + noise.below(17) as usize;
    let mut mood = 0;
    (0..cycles)
        .map(|cycle| {
            if noise.below(40) == 0 {
                mood = noise.below(6);
            }
            let mut wide = || u128::from(noise.next()) << 64 | u128::from(noise.next());
            let random = wide();
            let samples = match mood {
                0 => random,
                1 => random & wide() & wide(),
                2 => u128::MAX / 3,
                3 => mask * (random & 1),
                4 => u128::MAX / 3 * 2,
                _ => mask,
            };
            Inputs {
                reset: cycle < 3 || (second_reset..second_reset + 2).contains(&cycle),
                ready: noise.below(8) != 0,
                samples: samples & mask,
            }
        })
        .collect()
}
