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

/// One of two words. By bits: of an `if` between words that are stored, the compiler may make one between
/// their places, lane by lane.
#[inline(always)]
pub fn choose(condition: bool, chosen: u32, other: u32) -> u32 {
    let mask = 0_u32.wrapping_sub(u32::from(condition));
    (chosen & mask) | (other & !mask)
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

/// A unit exponential in units of its half-life, from 32 random bits: -log2(i / 2^31) with i the upper
/// 31 bits, which reaches from 0 to 31, and 158 once in 2^31 draws, where i is 0.
///
/// Rounding i to 24 bits keeps the tail fine: the exponential's own resolution is about
/// 10^-7 at any length.
#[inline(always)]
pub fn half_lives(bits: u32) -> f32 {
    minus_log2((bits >> 1) as i32 as f32, 31)
}

/// A unit exponential, 31 bits: [`half_lives`] in its own unit.
#[inline(always)]
pub fn exponential(bits: u32) -> f32 {
    half_lives(bits) * std::f32::consts::LN_2
}

/// [`slight_exponential`] is exact up to here.
pub const SLIGHT: f64 = 0.25;

/// A unit exponential from 32 random bits, where only those up to [`SLIGHT`] matter: longer ones are
/// beyond it, too, but not so long.
///
/// -ln(1 - w) of the share w of 2^31 that the upper bits are, by its minimax polynomial, which is a
/// share of 4e-7 off at most.
#[inline(always)]
pub fn slight_exponential(bits: u32) -> f32 {
    let w = (bits >> 1) as i32 as f32 * (1.0 / 2_147_483_648.0);
    let mut q = 0.332_077_6_f32;
    q = q * w + 0.221_307_86;
    q = q * w + 0.335_748_76;
    q = q * w + 0.499_930_08;
    q = q * w + 1.000_000_4;
    q * w
}

/// -log2(x / 2^scale) for x > 0, within 2e-7 of the result or 4e-7, whichever is more; exactly 0 at
/// x = 2^scale. Zero gives a large number, anything else nonsense, but never a trap.
///
/// x = 2^e (1 + f) with 1 + f between sqrt(1/2) and sqrt(2), and the polynomial of degree 7 for
/// log2(1 + f) that is least off, 3.3e-7 at most, among those that are not off on average over
/// uniform x: a mean of exponentials is that of exact ones to 10^-8, and the density of a wait is so to
/// 7e-6, root mean square, which 10^10 of them do not show.
#[inline(always)]
pub fn minus_log2(x: f32, scale: i32) -> f32 {
    const SQRT_HALF_BITS: u32 = 0x3f35_04f3;
    let bits = x.to_bits();
    let exponent = (bits.wrapping_sub(SQRT_HALF_BITS) as i32) >> 23;
    let f = f32::from_bits(bits.wrapping_sub((exponent << 23) as u32)) - 1.0;
    let mut q = 0.168_824_29_f32;
    q = q * f - 0.271_666_74;
    q = q * f + 0.297_542_57;
    q = q * f - 0.359_130_4;
    q = q * f + 0.480_445_27;
    q = q * f - 0.721_368_8;
    q = q * f + 1.442_700_5;
    scale.wrapping_sub(exponent) as f32 - q * f
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
    let w = minus_log2(tail * (2.0 - tail), 0) * std::f32::consts::LN_2;
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
pub fn to_signed_ticks(shift: f32) -> i32 {
    let rounded = shift + if shift < 0.0 { -0.5 } else { 0.5 };
    // SAFETY: the caller's numbers are finite and far from the ends of 32 bits.
    unsafe { rounded.to_int_unchecked::<i32>() }
}

/// 2^x for x <= 0, within a share of 3e-7, and of 1 - 2^x; below 2^-100 it stays there.
///
/// The nearest whole number goes to the exponent; the rest, in -1/2..=1/2, through the polynomial of degree 5
/// that is 1 at 0 and least off as a share of the rest, 3e-7: so many short decays are as exact as a long one.
#[inline(always)]
pub fn exp2_of_negative(x: f32) -> f32 {
    /// Added to a number of up to 22 bits it leaves its nearest whole number in the last ones.
    const WHOLE: f32 = 12_582_912.0;
    let x = if x > -100.0 { x } else { -100.0 };
    let shifted = x + WHOLE;
    let f = x - (shifted - WHOLE);
    let mut q = 1.340_043_6e-3_f32;
    q = q * f + 9.666_373e-3;
    q = q * f + 5.550_333e-2;
    q = q * f + 0.240_223_48;
    q = q * f + std::f32::consts::LN_2;
    let mantissa = q * f + 1.0;
    f32::from_bits(mantissa.to_bits().wrapping_add(shifted.to_bits() << 23))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_agrees_with_the_library_over_all_exponentials() {
        for i in 1..2_000_000_u32 {
            let bits = i.wrapping_mul(2_654_435_761);
            let expected = -((f64::from(bits >> 1) + 0.5) / 2_f64.powi(31)).log2();
            let found = f64::from(half_lives(bits));
            // Half of the last of 31 bits, and what rounding them to 24 takes.
            let bound = 2e-7 * expected + 5e-7 + 0.72 / f64::from((bits >> 1).max(1));
            assert!((found - expected).abs() < bound, "{bits}: {found} {expected}");
        }
        assert_eq!(half_lives(u32::MAX), 0.0);
        assert!((half_lives(2) - 31.0).abs() < 1e-5);
        assert!(half_lives(0) > 31.0 && half_lives(1) < 200.0);
    }

    #[test]
    fn slight_exponentials_are_exact_as_far_as_they_matter() {
        for i in 0..2_000_000_u32 {
            let bits = i.wrapping_mul(2_654_435_761);
            let expected = -(-f64::from(bits >> 1) / 2_f64.powi(31)).ln_1p();
            let found = f64::from(slight_exponential(bits));
            match expected <= SLIGHT {
                true => assert!((found - expected).abs() <= 5e-7 * expected, "{bits}: {found}"),
                false => assert!(found > SLIGHT, "{bits}: {found}"),
            }
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
            let decayed = -(f64::from(x) * std::f64::consts::LN_2).exp_m1();
            assert!(x < -0.5 || (1.0 - found - decayed).abs() < 4e-7 * decayed + 1.2e-7, "{x}");
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
