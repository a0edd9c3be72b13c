//! Arithmetic of one lane, in plain operations that the compiler vectorises.
//!
//! Release builds check for overflow, which would keep the compiler from vectors, so
//! whole numbers in a loop over lanes wrap by name. Sums of times never do: waits and dead
//! times are at most 2^30 ticks (`places`), and no sum has more than two of them.
//! Random words, and differences that [`wrap`] and its like choose between, do.
//!
//! Nothing here is a library call or a fused multiply-add, so that a value is
//! the same, bit for bit, on every processor and at every vector width.

use std::ops::{Deref, DerefMut};

/// Lanes, each of which simulates a phase step of its own.
pub const LANES: usize = 64;

/// One value per lane, aligned to the widest vector: one that lies across two
/// cache lines costs twice.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(64))]
pub struct PerLane<T>([T; LANES]);

/// One 32-bit word per lane.
pub type LaneWords = PerLane<u32>;
/// One signed 32-bit word per lane.
pub type Integers = PerLane<i32>;
/// One number per lane.
pub type Floats = PerLane<f32>;

impl<T: Copy> PerLane<T> {
    /// The same value in every lane.
    #[inline(always)]
    pub fn all(value: T) -> PerLane<T> {
        PerLane([value; LANES])
    }
}

impl<T> Deref for PerLane<T> {
    type Target = [T; LANES];

    #[inline(always)]
    fn deref(&self) -> &[T; LANES] {
        &self.0
    }
}

impl<T> DerefMut for PerLane<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [T; LANES] {
        &mut self.0
    }
}

/// A table that all lanes look things up in, padded to a power of two.
#[derive(Debug, Clone)]
pub struct LookUp {
    entries: Box<[u32]>,
    /// One less than their number. Of a single word, the compiler would make a scalar
    /// operation for each lane.
    mask: LaneWords,
}

impl LookUp {
    /// A table of at least one entry and at most 2^31.
    pub fn new(entries: impl Iterator<Item = u32>) -> LookUp {
        let mut entries: Vec<u32> = entries.collect();
        entries.resize(entries.len().next_power_of_two(), 0);
        LookUp {
            mask: LaneWords::all((entries.len() - 1) as u32),
            entries: entries.into_boxed_slice(),
        }
    }

    /// The entries at one place per lane. A loop of its own, because the compiler
    /// makes vector loads of it only if nothing else is stored between them.
    #[inline(always)]
    pub fn at(&self, places: &LaneWords) -> LaneWords {
        let mut entries = LaneWords::all(0);
        for lane in 0..LANES {
            // That the place has 31 bits, gathers of words want to know.
            let place = (places[lane] & self.mask[lane] & 0x7fff_ffff) as usize;
            // SAFETY: the number of entries is a power of two, and the mask one less.
            entries[lane] = unsafe { *self.entries.get_unchecked(place) };
        }
        entries
    }
}

/// A number modulo `period`, for numbers below two periods and a period of at most
/// 2^31: the subtraction wraps round to a larger number if there is nothing to
/// subtract.
#[inline(always)]
pub fn wrap(number: u32, period: u32) -> u32 {
    number.min(number.wrapping_sub(period))
}

/// The longest wait in ticks; longer ones are cut to it.
pub const LONGEST_WAIT: u32 = 1 << 30;

/// A table of a size that the compiler knows, which spares its look-ups the mask.
#[derive(Debug, Clone)]
pub struct FixedTable<const N: usize>(Box<[u32; N]>);

impl<const N: usize> FixedTable<N> {
    /// A table that begins with `entries`, of which at most N fit.
    pub fn new(entries: impl Iterator<Item = u32>) -> FixedTable<N> {
        let mut table = Box::new([0; N]);
        for (place, entry) in table.iter_mut().zip(entries) {
            *place = entry;
        }
        FixedTable(table)
    }

    /// The entries at one place per lane, below N.
    #[inline(always)]
    pub fn at(&self, places: &LaneWords) -> LaneWords {
        let mut entries = LaneWords::all(0);
        for lane in 0..LANES {
            entries[lane] = self.0[(places[lane] % N as u32) as usize];
        }
        entries
    }
}

/// The nearest whole number, cut to 0..=[`LONGEST_WAIT`] (also if not a number).
///
/// Rounding, where truncation would do, matters for the rate: half a tick is
/// 10^-7 of the mean wait at ten million detections per second.
#[inline(always)]
pub fn to_ticks(wait: f32) -> u32 {
    let longest = LONGEST_WAIT as f32;
    let rounded = wait + 0.5;
    let below = if rounded < longest { rounded } else { longest };
    let within = if below > 0.0 { below } else { 0.0 };
    // SAFETY: finite, and from 0 to 2^30, as the two lines before make sure.
    unsafe { within.to_int_unchecked::<i32>() as u32 }
}

/// A unit exponential from 32 random bits: -ln((i + 1/2) / 2^31) with i the
/// upper 31 bits, which reaches from 0 to 22.
///
/// Rounding (i + 1/2) to 24 bits keeps the tail fine: the exponential's own
/// resolution is about 10^-7 at any length.
#[inline(always)]
pub fn exponential(bits: u32) -> f32 {
    let scaled = (bits >> 1) as i32 as f32 + 0.5;
    minus_ln(scaled, 31)
}

/// -ln(x / 2^scale) for x > 0, within 2e-7 of the result or 4e-8, whichever is
/// more. Zero gives a large number, anything else nonsense, but never a trap.
///
/// x = 2^e (1 + f) with 1 + f between sqrt(1/2) and sqrt(2), and the minimax
/// polynomial of degree 8 for ln(1 + f), which is 4e-8 off at most.
#[inline(always)]
pub fn minus_ln(x: f32, scale: i32) -> f32 {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let bits = x.to_bits();
    let exponent = (bits.wrapping_sub(SQRT_HALF_BITS) as i32) >> 23;
    let f = f32::from_bits(bits.wrapping_sub((exponent << 23) as u32)) - 1.0;
    let mut q = -0.100_345_19_f32;
    q = q * f + 0.163_356_27;
    q = q * f - 0.173_260_18;
    q = q * f + 0.198_882_79;
    q = q * f - 0.249_614_63;
    q = q * f + 0.333_352_6;
    q = q * f - 0.500_005_84;
    let ln_mantissa = q * (f * f) + f;
    scale.wrapping_sub(exponent) as f32 * std::f32::consts::LN_2 - ln_mantissa
}

/// Beyond every number that [`standard_normal`] makes.
pub const NORMAL_BOUND: f32 = 6.5;

/// A standard normal number from 32 random bits, by the inverse of its distribution: a bit
/// of sign, and a tail probability of 31 bits, which reaches 6.3 standard deviations.
///
/// The inverse has the form of Giles' ("Approximating the erfinv function", GPU Computing Gems,
/// 2012), whose polynomials end at a tail of 2^-24: the far one is fitted anew, over all tails
/// of 31 bits, to within a share of 5e-7.
#[inline(always)]
pub fn standard_normal(bits: u32) -> f32 {
    let tail = ((bits & 0x7fff_ffff) as i32 as f32 + 0.5) * (1.0 / 2_147_483_648.0);
    let w = minus_ln(tail * (2.0 - tail), 0);
    let x = w - 2.5;
    let mut centre = 2.810_226_4e-8_f32;
    centre = centre * x + 3.432_739_4e-7;
    centre = centre * x - 3.523_387_7e-6;
    centre = centre * x - 4.391_506_5e-6;
    centre = centre * x + 2.185_808_7e-4;
    centre = centre * x - 1.253_725e-3;
    centre = centre * x - 4.177_681_6e-3;
    centre = centre * x + 0.246_640_73;
    centre = centre * x + 1.501_409_4;
    let x = w.sqrt() - 3.0;
    let mut far = -1.006_532_1e-5_f32;
    far = far * x - 1.450_169_2e-4;
    far = far * x + 1.161_043_3e-3;
    far = far * x - 3.392_14e-3;
    far = far * x + 5.797_295_4e-3;
    far = far * x - 7.717_609e-3;
    far = far * x + 9.431_715e-3;
    far = far * x + 1.001_682_3;
    far = far * x + 2.832_977_3;
    let magnitude = if w < 5.0 { centre } else { far };
    let signed = f32::from_bits(magnitude.to_bits() ^ (bits & 0x8000_0000));
    signed * (1.0 - tail) * std::f32::consts::SQRT_2
}

/// The quantile of that number, in 2^31.
#[inline(always)]
pub fn quantile(bits: u32) -> u32 {
    let flipped = if bits >> 31 == 1 { 1 << 31 } else { u32::MAX };
    (bits ^ flipped) >> 1
}

/// Ticks by which jitter moves a detection.
#[inline(always)]
pub fn jitter(bits: u32, sigma_ticks: f32) -> i32 {
    to_signed_ticks(standard_normal(bits) * sigma_ticks)
}

/// The nearest whole number, for magnitudes up to 2^30.
#[inline(always)]
fn to_signed_ticks(shift: f32) -> i32 {
    let rounded = shift + if shift < 0.0 { -0.5 } else { 0.5 };
    // SAFETY: the caller's numbers are finite and far from the ends of 32 bits.
    unsafe { rounded.to_int_unchecked::<i32>() }
}

/// 2^x for x <= 0, within a share of 3e-7; below 2^-100 it stays there.
///
/// The whole part, cut towards zero, goes to the exponent; the rest, in -1..=0,
/// through the minimax polynomial of degree 5, which is 6e-8 off at most.
#[inline(always)]
pub fn exp2_of_negative(x: f32) -> f32 {
    let x = if x > -100.0 { x } else { -100.0 };
    let x = if x < 0.0 { x } else { 0.0 };
    // SAFETY: finite, and from -100 to 0, as the two lines before make sure.
    let whole = unsafe { x.to_int_unchecked::<i32>() };
    let f = x - whole as f32;
    let mut q = 9.542_653e-4_f32;
    q = q * f + 9.228_978e-3;
    q = q * f + 5.531_724e-2;
    q = q * f + 0.240_186_92;
    q = q * f + 0.693_144_45;
    let scale = f32::from_bits((whole.wrapping_add(127) << 23) as u32);
    (q * f + 1.0) * scale
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_agrees_with_the_library_over_all_exponentials() {
        for i in 0..2_000_000_u32 {
            let bits = i.wrapping_mul(2_654_435_761);
            let expected = -((f64::from(bits >> 1) + 0.5) / 2_f64.powi(31)).ln();
            let found = f64::from(exponential(bits));
            let bound = 2e-7 * expected + 1.2e-7;
            assert!((found - expected).abs() < bound, "{bits}: {found} {expected}");
        }
        for bits in [0, 1, 2, 3, u32::MAX] {
            let expected = -((f64::from(bits >> 1) + 0.5) / 2_f64.powi(31)).ln();
            assert!((f64::from(exponential(bits)) - expected).abs() < 4e-6, "{bits}");
        }
    }

    #[test]
    fn exponentials_have_the_unit_mean_and_second_moment() {
        // A grid of all bits' upper 20: the midpoint rule for the integrals of
        // -ln x and its square, 1 and 2, whose error is below 2^-18.
        let n = 1 << 20;
        let (mut mean, mut second) = (0.0, 0.0);
        for i in 0..n {
            let e = f64::from(exponential((i << 12) + (1 << 11)));
            mean += e / f64::from(n);
            second += e * e / f64::from(n);
        }
        assert!((mean - 1.0).abs() < 1e-6, "{mean}");
        assert!((second - 2.0).abs() < 3e-5, "{second}");
    }

    #[test]
    fn normal_numbers_have_the_normal_distribution() {
        for i in 0..200_000_u32 {
            let bits = i.wrapping_mul(2_654_435_761);
            let number = f64::from(standard_normal(bits));
            let tail = (f64::from(bits & 0x7fff_ffff) + 0.5) / 2_f64.powi(31);
            let found = 2.0 * crate::math::normal_cdf(-number.abs());
            // A number that is 1e-6 and 2e-6 of itself off, and the tail's 24 bits.
            let density = 2.0 * crate::math::normal_density(number);
            let bound = density * (1e-6 + 2e-6 * number.abs()) + 1e-7 * tail;
            assert!((found - tail).abs() < bound, "{bits}: {number} {found} {tail}");
            assert!(tail == 1.0 || (number < 0.0) == (bits >> 31 == 1));
        }
        for bits in [0, 1, u32::MAX, 1 << 31] {
            assert!(standard_normal(bits).abs() < NORMAL_BOUND);
        }
    }

    #[test]
    fn power_of_two_agrees_with_the_library() {
        for i in 0..1_000_000 {
            let x = -1e-4 * f64::from(i);
            let x = x as f32;
            let expected = f64::from(x).max(-100.0).exp2();
            let found = f64::from(exp2_of_negative(x));
            assert!((found / expected - 1.0).abs() < 3e-7, "{x}");
        }
        assert_eq!(exp2_of_negative(0.0), 1.0);
    }

    #[test]
    fn ticks_are_rounded_and_cut() {
        let cases = [(-3.0, 0), (0.4, 0), (0.6, 1), (7.5, 8), (2e9, LONGEST_WAIT)];
        for (wait, ticks) in cases {
            assert_eq!(to_ticks(wait), ticks, "{wait}");
        }
        assert_eq!(to_ticks(f32::NAN), LONGEST_WAIT);
        assert_eq!(to_ticks(f32::INFINITY), LONGEST_WAIT);
    }

    #[test]
    fn wrapping_is_the_modulus() {
        for (ticks, wrapped) in [(0, 0), (9, 9), (10, 0), (19, 9)] {
            assert_eq!(wrap(ticks, 10), wrapped);
        }
    }
}
