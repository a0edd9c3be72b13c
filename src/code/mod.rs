//! Binary codes: m-sequences, Gold sets, square wave, given chips,
//! interleaving, and their correlation.

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
    /// Chips per code period, L'.
    pub fn len(&self) -> u64 {
        self.chips.len() as u64
    }

    /// A code has at least one chip.
    pub fn is_empty(&self) -> bool {
        self.chips.is_empty()
    }

    /// Number of chips that are 1.
    pub fn weight(&self) -> u64 {
        self.chips.iter().map(|&c| u64::from(c)).sum()
    }
}
