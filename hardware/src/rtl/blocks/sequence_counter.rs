//! Counting in the order of an LFSR, whose next state needs one gate.

use crate::code::Lfsr;

use super::lfsr::{lfsr_heading, state_at};

/// An LFSR that counts to a number known beforehand.
#[derive(Debug, Clone)]
pub(crate) struct SequenceCounter {
    lfsr: Lfsr,
}

impl SequenceCounter {
    /// A counter with a state of its own for each of `states` counts, which is
    /// at most 2^60.
    pub(crate) fn new(states: u64) -> SequenceCounter {
        let needed = 64 - states.max(3).leading_zeros();
        let taps = MAXIMAL_TAPS[needed as usize - 2];
        let mut exponents: Vec<u32> = taps.to_vec();
        exponents.push(0);
        SequenceCounter { lfsr: Lfsr { degree: needed, exponents, seed: vec![1; needed as usize] } }
    }

    /// What stands over the constants of `counter` in the Verilog.
    pub(super) fn heading(&self, counter: &str) -> String {
        lfsr_heading(counter, &self.lfsr)
    }

    pub(crate) fn width(&self) -> u32 {
        self.lfsr.degree
    }

    pub(crate) fn taps(&self) -> u128 {
        self.lfsr.taps().into()
    }

    /// The state that comes to the first by one count, and to which no count of
    /// the states asked for comes unless they are all there are.
    pub(crate) fn state_before_the_first(&self) -> u128 {
        self.state((1 << self.width()) - 2)
    }

    /// The state after `count` counts; the first is all ones.
    pub(crate) fn state(&self, count: u64) -> u128 {
        state_at(&self.lfsr, count)
    }
}

/// Exponents of a primitive polynomial for each degree from 2 to 61, without
/// the constant term; few terms, as in the tables of LFSR taps.
#[rustfmt::skip]
const MAXIMAL_TAPS: [&[u32]; 60] = [
    &[2, 1], &[3, 2], &[4, 3], &[5, 3], &[6, 5], &[7, 6], &[8, 6, 5, 4], &[9, 5], &[10, 7],
    &[11, 9], &[12, 6, 4, 1], &[13, 4, 3, 1], &[14, 5, 3, 1], &[15, 14], &[16, 15, 13, 4],
    &[17, 14], &[18, 11], &[19, 6, 2, 1], &[20, 17], &[21, 19], &[22, 21], &[23, 18],
    &[24, 23, 22, 17], &[25, 22], &[26, 6, 2, 1], &[27, 5, 2, 1], &[28, 25], &[29, 27],
    &[30, 6, 4, 1], &[31, 28], &[32, 22, 2, 1], &[33, 20], &[34, 27, 2, 1], &[35, 33],
    &[36, 25], &[37, 5, 4, 3, 2, 1], &[38, 6, 5, 1], &[39, 35], &[40, 38, 21, 19], &[41, 38],
    &[42, 41, 20, 19], &[43, 42, 38, 37], &[44, 43, 18, 17], &[45, 44, 42, 41],
    &[46, 45, 26, 25], &[47, 42], &[48, 47, 21, 20], &[49, 40], &[50, 49, 24, 23],
    &[51, 50, 36, 35], &[52, 49], &[53, 52, 38, 37], &[54, 53, 18, 17], &[55, 31],
    &[56, 55, 35, 34], &[57, 50], &[58, 39], &[59, 58, 38, 37], &[60, 59], &[61, 60, 46, 45],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The state `count` steps on, by squaring the one-step matrix.
    fn power_is_identity(counter: &SequenceCounter, mut count: u64) -> bool {
        let n = counter.width() as usize;
        let step = |state: u64| {
            let parity = u64::from((state & counter.taps() as u64).count_ones() % 2);
            state >> 1 | parity << (n - 1)
        };
        let apply = |matrix: &[u64], state: u64| {
            (0..n).filter(|bit| state >> bit & 1 == 1).fold(0, |sum, bit| sum ^ matrix[bit])
        };
        let mut square: Vec<u64> = (0..n).map(|bit| step(1 << bit)).collect();
        let mut product: Vec<u64> = (0..n).map(|bit| 1 << bit).collect();
        while count > 0 {
            if count & 1 == 1 {
                product = product.iter().map(|&column| apply(&square, column)).collect();
            }
            square = square.iter().map(|&column| apply(&square, column)).collect();
            count >>= 1;
        }
        (0..n).all(|bit| product[bit] == 1 << bit)
    }

    fn prime_factors(mut number: u64) -> Vec<u64> {
        let mut factors = Vec::new();
        let mut divisor = 2;
        while divisor * divisor <= number {
            if number.is_multiple_of(divisor) {
                factors.push(divisor);
                while number.is_multiple_of(divisor) {
                    number /= divisor;
                }
            }
            divisor += 1;
        }
        if number > 1 {
            factors.push(number);
        }
        factors
    }

    #[test]
    fn every_counter_passes_through_all_states_but_zero() {
        // 2^61 - 1 is prime, which trial division would take too long to find.
        for degree in 2..=60u32 {
            let counter = SequenceCounter::new((1 << degree) - 1);
            assert_eq!(counter.width(), degree);
            let period = (1u64 << degree) - 1;
            assert!(power_is_identity(&counter, period), "degree {degree}");
            for factor in prime_factors(period) {
                if factor < period {
                    assert!(
                        !power_is_identity(&counter, period / factor),
                        "degree {degree}, factor {factor}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_state_after_a_count_is_the_one_that_counting_reaches() {
        for states in [2, 3, 4, 100, 13_100, 1 << 33] {
            let counter = SequenceCounter::new(states);
            let width = counter.width();
            let mut state = (1u128 << width) - 1;
            for count in 0..200 {
                assert_eq!(counter.state(count % ((1 << width) - 1)), state);
                let parity = u128::from((state & counter.taps()).count_ones() % 2);
                state = state >> 1 | parity << (width - 1);
            }
        }
    }

    #[test]
    fn the_state_before_the_first_counts_to_it() {
        for states in [2, 3, 4, 100, 13_100, 1 << 33] {
            let counter = SequenceCounter::new(states);
            let before = counter.state_before_the_first();
            let parity = u128::from((before & counter.taps()).count_ones() % 2);
            assert_eq!(before >> 1 | parity << (counter.width() - 1), counter.state(0));
        }
    }
}
