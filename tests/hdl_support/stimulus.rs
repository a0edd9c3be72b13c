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
}

/// `cycles` inputs that begin with a reset and have one more in the middle.
pub fn inputs(lanes: u32, cycles: usize, seed: u64) -> Vec<Inputs> {
    let mut noise = Noise::new(seed);
    let mask = (1u32 << lanes) - 1;
    let second_reset = cycles / 2 + noise.below(17) as usize;
    let mut mood = 0;
    (0..cycles)
        .map(|cycle| {
            if noise.below(40) == 0 {
                mood = noise.below(6);
            }
            let random = noise.next() as u32;
            let samples = match mood {
                0 => random,
                1 => random & noise.next() as u32 & noise.next() as u32,
                2 => 0x5555_5555,
                3 => mask * (random & 1),
                4 => 0xaaaa_aaaa,
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
