//! Linear-feedback shift registers over GF(2).

use super::CodeError;
use super::gf2;

/// A linear-feedback shift register.
///
/// Polynomial exponents e give the recurrence
/// c\[t\] = XOR over e > 0 of c\[t - e\]; the seed is the first `degree` chips
/// in time order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lfsr {
    /// Degree n of the polynomial; the sequence has period 2^n - 1.
    pub degree: u32,
    /// Exponents in descending order, `degree` first, 0 last.
    pub exponents: Vec<u32>,
    /// The first `degree` chips, each 0 or 1.
    pub seed: Vec<u8>,
}

impl Lfsr {
    /// Checks `exponents` (descending, from `degree` to 0, primitive) and
    /// `seed` (`degree` binary digits, first chip first, not all zero; all-ones
    /// when not given).
    pub fn new(degree: u32, exponents: &[u32], seed: Option<&str>) -> Result<Lfsr, CodeError> {
        let example = || polynomial_text(&gf2::first_primitive(degree).unwrap_or_default());
        let descending = exponents.windows(2).all(|pair| pair[0] > pair[1]);
        if !descending || exponents.first() != Some(&degree) || exponents.last() != Some(&0) {
            return Err(CodeError::MalformedPolynomial {
                polynomial: polynomial_text(exponents),
                degree,
                example: example(),
            });
        }
        if !gf2::is_primitive(gf2::mask(exponents), degree) {
            return Err(CodeError::NotPrimitive {
                polynomial: polynomial_text(exponents),
                example: example(),
            });
        }
        Ok(Lfsr {
            degree,
            exponents: exponents.to_vec(),
            seed: match seed {
                Some(text) => parse_seed(degree, text)?,
                None => vec![1; degree as usize],
            },
        })
    }

    /// The first `count` chips.
    pub fn chips(&self, count: usize) -> Vec<u8> {
        // Bit i of the window is the chip i places after its oldest.
        let taps = self.taps();
        let mut window =
            self.seed.iter().rev().fold(0u64, |window, &chip| window << 1 | u64::from(chip));
        (0..count)
            .map(|_| {
                let chip = (window & 1) as u8;
                let next = u64::from((window & taps).count_ones() & 1);
                window = window >> 1 | next << (self.degree - 1);
                chip
            })
            .collect()
    }

    /// Chips whose XOR is the chip that comes `degree` chips after the first of them: bit i is set for the one i chips
    /// after it. c\[t + n\] is the XOR of c\[t + n - e\] over the exponents e > 0.
    pub fn taps(&self) -> u64 {
        let exponents = self.exponents.iter().filter(|&&e| e > 0);
        exponents.fold(0, |taps, e| taps | 1 << (self.degree - e))
    }

    /// The same LFSR with other taps, as [`Lfsr::taps`] has them: any, whose sequence need not have the period 2^n - 1.
    pub(super) fn with_taps(&self, taps: u64) -> Lfsr {
        let places = (0..self.degree).filter(|place| taps >> place & 1 == 1);
        let exponents = places.map(|place| self.degree - place).chain([0]).collect();
        Lfsr { exponents, ..self.clone() }
    }

    /// Chips per period, 2^n - 1.
    pub fn period(&self) -> u64 {
        (1 << self.degree) - 1
    }

    /// The same LFSR started `chips` chips later.
    pub fn advanced(&self, chips: u64) -> Lfsr {
        // As a shift operator x obeys x^n = sum of x^(n - e): the polynomial
        // with its exponents reversed. So c[t + chips] is the sum of c[t + i]
        // over the terms i of x^chips modulo it.
        let shift_polynomial =
            self.exponents.iter().fold(0u64, |mask, e| mask | 1 << (self.degree - e));
        let jump = gf2::power_of_x_mod(chips % self.period(), shift_polynomial, self.degree);
        let degree = self.degree as usize;
        let chips = self.chips(2 * degree);
        let seed = (0..degree)
            .map(|t| {
                (0..degree).filter(|i| jump >> i & 1 == 1).fold(0, |sum, i| sum ^ chips[t + i])
            })
            .collect();
        Lfsr { seed, ..self.clone() }
    }

    /// The seed as binary digits, first chip first.
    pub fn seed_text(&self) -> String {
        super::chips_text(&self.seed)
    }
}

/// Whether an LFSR of this degree with these taps, as [`Lfsr::taps`] has them, goes through all states but that of
/// zeros, so that its sequence has the period 2^n - 1.
pub fn is_maximal(degree: u32, taps: u64) -> bool {
    // The exponents' polynomial: that of the taps, reversed, and the constant term.
    let polynomial = (0..degree)
        .filter(|place| taps >> place & 1 == 1)
        .fold(1, |mask, place| mask | 1 << (degree - place));
    taps & 1 == 1 && gf2::is_primitive(polynomial, degree)
}

/// Exponents as the command line takes them: `11,2,0`.
pub fn polynomial_text(exponents: &[u32]) -> String {
    exponents.iter().map(u32::to_string).collect::<Vec<_>>().join(",")
}

fn parse_seed(degree: u32, text: &str) -> Result<Vec<u8>, CodeError> {
    let seed = super::parse_chips(text)
        .filter(|seed| seed.len() == degree as usize)
        .ok_or_else(|| CodeError::MalformedSeed { seed: text.to_owned(), degree })?;
    if seed.iter().all(|&chip| chip == 0) {
        return Err(CodeError::ZeroSeed { seed: text.to_owned() });
    }
    Ok(seed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The recurrence, written out.
    fn naive(exponents: &[u32], seed: &[u8], count: usize) -> Vec<u8> {
        let mut chips = seed.to_vec();
        for t in seed.len()..count {
            let next =
                exponents.iter().filter(|&&e| e > 0).map(|&e| chips[t - e as usize]).sum::<u8>()
                    % 2;
            chips.push(next);
        }
        chips.truncate(count);
        chips
    }

    #[test]
    fn chips_follow_the_recurrence() {
        let lfsr = Lfsr::new(10, &[10, 9, 8, 6, 3, 2, 0], Some("1000110101")).unwrap();
        let expected = naive(&lfsr.exponents, &lfsr.seed, 2100);
        assert_eq!(lfsr.chips(2100), expected);
        assert_eq!(expected[..10], [1, 0, 0, 0, 1, 1, 0, 1, 0, 1]);
        assert_eq!(expected[0..1000], expected[1023..2023]);
    }

    /// Of all taps of some degrees those that are told have the period 2^n - 1, and no others: counted.
    #[test]
    fn taps_are_maximal_if_all_states_follow_one_another() {
        for degree in 2..=9 {
            let first = Lfsr::new(degree, &gf2::first_primitive(degree).unwrap(), None).unwrap();
            for taps in 0..1 << degree {
                let (mut state, mut states) = (1_u64, 0);
                loop {
                    let next = u64::from((state & taps).count_ones() & 1);
                    state = state >> 1 | next << (degree - 1);
                    states += 1;
                    if state == 1 || states > first.period() {
                        break;
                    }
                }
                assert_eq!(
                    is_maximal(degree, taps),
                    states == first.period(),
                    "{degree} {taps:#b}"
                );
                assert_eq!(first.with_taps(taps).taps(), taps);
            }
            assert!(is_maximal(degree, first.taps()));
        }
    }

    #[test]
    fn an_advanced_lfsr_continues_the_sequence() {
        let lfsr = Lfsr::new(7, &[7, 3, 0], Some("0010110")).unwrap();
        let chips = lfsr.chips(3 * 127 + 40);
        for shift in [0, 1, 6, 7, 8, 63, 126, 127, 128, 300] {
            let advanced = lfsr.advanced(shift as u64);
            assert_eq!(advanced.chips(40), chips[shift..shift + 40], "shift {shift}");
        }
    }
}
