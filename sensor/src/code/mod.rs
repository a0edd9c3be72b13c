//! Binary codes: m-sequences, Gold sets, square wave, given chips,
//! interleaving, and their correlation.
//!
//! [`CodeSpec`] is what a user asks for, [`Code`] what comes of it, with the
//! [`Generator`] from which hardware makes the same chips.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! # }
//! use goldtof::code::{CodeSpec, Family};
//!
//! let mut spec = CodeSpec::new(Family::Gold);
//! spec.degree = Some(5);
//! let code = spec.build()?;
//! assert_eq!(code.len(), 31);
//! // Off the peak a Gold code of degree 5 takes three values: -1 and -1 +- 2^3.
//! assert!(code.autocorrelation().skip(1).all(|value| [-9, -1, 7].contains(&value)));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod correlation;
mod error;
mod family;
mod gf2;
mod gold;
mod interleave;
mod lfsr;
mod report;
mod spec;
mod text;

pub use correlation::{correlate, correlate_naive, cross_correlation_counts, value_counts};
pub use error::CodeError;
pub use family::{Family, UnknownFamily};
pub use gold::{GoldSet, bound, default_pair, default_polynomial};
pub use interleave::interleave;
pub use lfsr::{Lfsr, is_maximal, polynomial_text};
pub use report::{Autocorrelation, CodesReport, GoldSetReport, report};
pub use spec::CodeSpec;
pub use text::{MalformedPolynomials, parse_polynomials, parse_seeds};

/// Smallest degree of a polynomial.
pub const MIN_DEGREE: u32 = 3;
/// Largest degree of a polynomial. Hardware sets its own, smaller limit.
pub const MAX_DEGREE: u32 = 20;
/// The largest degree that hardware is made for.
pub const MOST_HARDWARE_DEGREE: u32 = 16;
/// Largest interleaving depth nu.
pub const MAX_INTERLEAVE: u32 = 8;
/// Most chips per code period, L'. With at most 64 samples per chip this keeps
/// the K = S L' phase steps of a period below 2^31.
pub const MAX_CODE_CHIPS: u64 = 1 << 24;

/// What makes a code's chips, before interleaving.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Generator {
    /// One LFSR: an m-sequence, or index -2 (u) or -1 (v) of a Gold set.
    MSequence(Lfsr),
    /// XOR of two LFSRs. `v` is already advanced by the Gold index.
    Gold {
        /// First LFSR.
        u: Lfsr,
        /// Second LFSR, its seed advanced by the index.
        v: Lfsr,
    },
    /// Chips 1, 0: period 2.
    Square,
    /// Chips as given.
    Chips(Vec<u8>),
}

impl Generator {
    /// Chips per period, before interleaving.
    pub fn period(&self) -> u64 {
        match self {
            Generator::MSequence(lfsr) | Generator::Gold { u: lfsr, .. } => lfsr.period(),
            Generator::Square => 2,
            Generator::Chips(chips) => chips.len() as u64,
        }
    }

    /// The LFSR that chooses among codes of one period: a Gold code's second, or that of an m-sequence.
    pub fn last_lfsr(&self) -> Option<&Lfsr> {
        match self {
            Generator::MSequence(lfsr) | Generator::Gold { v: lfsr, .. } => Some(lfsr),
            Generator::Square | Generator::Chips(_) => None,
        }
    }

    /// The chips of one period, before interleaving.
    pub fn chips(&self) -> Vec<u8> {
        let period = self.period() as usize;
        match self {
            Generator::MSequence(lfsr) => lfsr.chips(period),
            Generator::Gold { u, v } => {
                let pairs = u.chips(period).into_iter().zip(v.chips(period));
                pairs.map(|(u, v)| u ^ v).collect()
            }
            Generator::Square => vec![1, 0],
            Generator::Chips(chips) => chips.clone(),
        }
    }
}

/// One code period, interleaving included.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Code {
    /// What makes the chips, before interleaving.
    pub generator: Generator,
    /// Interleaving depth nu (eq. 23).
    pub interleave: u32,
    /// The L' = 2^nu L chips of one period, each 0 or 1.
    pub chips: Vec<u8>,
}

impl Code {
    /// Makes the chips of `generator`, interleaved to depth `interleave`.
    ///
    /// # Errors
    /// If the depth or the period is too large, or all chips of the generator
    /// are alike.
    pub fn new(generator: Generator, interleave: u32) -> Result<Code, CodeError> {
        if interleave > MAX_INTERLEAVE {
            return Err(CodeError::InterleaveOutOfRange { interleave });
        }
        let length = generator.period() << interleave;
        if length > MAX_CODE_CHIPS {
            return Err(CodeError::TooLong { chips: length });
        }
        let chips = generator.chips();
        let first = *chips.first().ok_or(CodeError::MalformedChips)?;
        if chips.iter().all(|&chip| chip == first) {
            return Err(CodeError::ConstantCode { chip: first });
        }
        let length = chips.len();
        let comes_again = |period: &usize| {
            length.is_multiple_of(*period) && chips[*period..] == chips[..length - period]
        };
        if let Some(period) = (2..=length / 2).find(comes_again) {
            return Err(CodeError::RepeatedCode { period, length });
        }
        Ok(Code { chips: self::interleave(&chips, interleave), generator, interleave })
    }

    /// The same code with another seed and other taps ([`Lfsr::taps`]) of its [last LFSR](Generator::last_lfsr); the seed's
    /// first chip is in bit 0. Hardware may be given any: the LFSR begins anew with each code period, and of a Gold code
    /// the seed 0 leaves the first LFSR's m-sequence.
    pub fn with_last_lfsr(&self, seed: u64, taps: u64) -> Code {
        let other = |lfsr: &Lfsr| Lfsr {
            seed: (0..lfsr.degree).map(|chip| (seed >> chip & 1) as u8).collect(),
            ..lfsr.with_taps(taps)
        };
        let generator = match &self.generator {
            Generator::MSequence(lfsr) => Generator::MSequence(other(lfsr)),
            Generator::Gold { u, v } => Generator::Gold { u: u.clone(), v: other(v) },
            Generator::Square | Generator::Chips(_) => return self.clone(),
        };
        let chips = self::interleave(&generator.chips(), self.interleave);
        Code { generator, chips, interleave: self.interleave }
    }

    /// Chips per code period, L'.
    pub fn len(&self) -> u64 {
        self.chips.len() as u64
    }

    /// A code has at least one chip.
    pub fn is_empty(&self) -> bool {
        self.chips.is_empty()
    }

    /// Periodic autocorrelation, at lags 0..L'. That of an interleaved code
    /// follows from the code before interleaving: at lag q 2^nu + s it is
    /// (-1)^s ((2^nu - s) theta\[q\] + s theta\[q + 1\]) (eq. 24).
    pub fn autocorrelation(&self) -> impl Iterator<Item = i64> {
        let base = self.generator.chips();
        let theta = correlate(&base, &base);
        let copies = 1_i64 << self.interleave;
        (0..theta.len()).flat_map(move |q| {
            let (here, next) = (theta[q], theta[(q + 1) % theta.len()]);
            (0..copies).map(move |s| {
                let between = (copies - s) * here + s * next;
                if s % 2 == 0 { between } else { -between }
            })
        })
    }

    /// Amplitude of the decorrelation triangle over the peak, (theta\[0\] -
    /// theta\[1\]) / L' (eq. 22): 2 for the square wave, and for a code of low side
    /// lobes about 2 (1 - 2^-(nu + 1)) (eq. 25).
    pub fn decorrelation_amplitude(&self) -> f64 {
        let theta: Vec<i64> = self.autocorrelation().take(2).collect();
        let [peak, next] = [theta[0], theta[1 % theta.len()]];
        (peak - next) as f64 / self.len() as f64
    }

    /// Number of chips that are 1: w of eqs. 5 and 14.
    pub fn weight(&self) -> u64 {
        self.chips.iter().map(|&c| u64::from(c)).sum()
    }

    /// Number of runs of ones in a period: none of a code that is always 1.
    pub fn runs(&self) -> u64 {
        let before = self.chips.iter().cycle().skip(self.chips.len().saturating_sub(1));
        self.chips.iter().zip(before).filter(|(now, before)| **now == 1 && **before == 0).count()
            as u64
    }

    /// Whether ones and zeros are as equal in number as the length allows.
    pub fn is_balanced(&self) -> bool {
        self.len().abs_diff(2 * self.weight()) <= 1
    }
}

/// Chips as binary digits, first chip first.
pub fn chips_text(chips: &[u8]) -> String {
    chips.iter().map(|&chip| if chip == 1 { '1' } else { '0' }).collect()
}

/// Chips from at least one binary digit, first chip first; `None` if `text`
/// holds anything else.
pub fn parse_chips(text: &str) -> Option<Vec<u8>> {
    let chips: Option<Vec<u8>> = text
        .bytes()
        .map(|digit| match digit {
            b'0' => Some(0),
            b'1' => Some(1),
            _ => None,
        })
        .collect();
    chips.filter(|chips| !chips.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eq. 25 with the side lobe that it neglects: for an m-sequence, -1.
    #[test]
    fn interleaving_raises_the_triangle_as_eq_25_says() {
        let register = Lfsr::new(5, &[5, 2, 0], None).unwrap();
        for nu in 1..=4_u32 {
            let code = Code::new(Generator::MSequence(register.clone()), nu).unwrap();
            let halves = 0.5_f64.powi(nu as i32 + 1);
            let expected = 2.0 * (1.0 - halves) - 1.0 / code.len() as f64;
            assert!((code.decorrelation_amplitude() - expected).abs() < 1e-12);
        }
        let square = Code::new(Generator::Square, 0).unwrap();
        assert_eq!(square.decorrelation_amplitude(), 2.0);
    }

    #[test]
    fn the_autocorrelation_of_interleaved_codes_is_that_of_the_definition() {
        let register = Lfsr::new(4, &[4, 1, 0], None).unwrap();
        for generator in [
            Generator::MSequence(register),
            Generator::Square,
            Generator::Chips(vec![1, 0, 0, 1, 1, 1, 0]),
        ] {
            for interleave in 0..=4 {
                let code = Code::new(generator.clone(), interleave).unwrap();
                let theta: Vec<i64> = code.autocorrelation().collect();
                assert_eq!(theta, correlate_naive(&code.chips, &code.chips));
                let amplitude = (theta[0] - theta[1]) as f64 / theta.len() as f64;
                assert!((code.decorrelation_amplitude() - amplitude).abs() < 1e-12);
            }
        }
    }
}
