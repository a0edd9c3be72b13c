//! Periodic correlation of codes.

use std::borrow::Borrow;
use std::collections::BTreeMap;

use goldtof_fft::num_complex::Complex;

/// Periodic correlation of two codes of the same length L, at every lag:
/// theta_ab\[k\] = sum over i = 0..L-1 of chi(a_i) chi(b_(i + k mod L)), where
/// chi is +1 for chip 1 and -1 for chip 0 (eq. 13 with its sum's end at L - 1).
///
/// By FFT, then rounded to the integers that the values are; should rounding
/// ever be in doubt, the sum is worked out as written.
///
/// # Panics
/// If `a` and `b` differ in length.
pub fn correlate(a: &[u8], b: &[u8]) -> Vec<i64> {
    assert_eq!(a.len(), b.len(), "only codes of one length correlate");
    nearest_integers(&correlate_fft(a, b)).unwrap_or_else(|| correlate_naive(a, b))
}

/// [`correlate`] by its definition, in L^2 steps: the slow truth.
///
/// # Panics
/// If `a` and `b` differ in length.
pub fn correlate_naive(a: &[u8], b: &[u8]) -> Vec<i64> {
    assert_eq!(a.len(), b.len(), "only codes of one length correlate");
    let length = a.len();
    (0..length).map(|k| (0..length).map(|i| chi(a[i]) * chi(b[(i + k) % length])).sum()).collect()
}

/// How often each value occurs, in ascending order of value.
pub fn value_counts(values: impl IntoIterator<Item = impl Borrow<i64>>) -> BTreeMap<i64, u64> {
    let mut counts = BTreeMap::new();
    for value in values {
        *counts.entry(*value.borrow()).or_insert(0) += 1;
    }
    counts
}

/// How often each value of the cross-correlation of two sequences occurs, over
/// all lags, where `v` is one period of an m-sequence of degree `degree`.
///
/// A lagged `v` is a linear function of its register's state, so all lags at
/// once are the Walsh-Hadamard transform of `u` written down by the states of
/// `v`: whole numbers, in little memory, but not in the order of the lags.
///
/// # Panics
/// If `u` and `v` have not 2^n - 1 chips.
pub fn cross_correlation_counts(u: &[u8], v: &[u8], degree: u32) -> BTreeMap<i64, u64> {
    let states = 1_usize << degree;
    assert!(u.len() == states - 1 && v.len() == states - 1);
    let mut values = vec![0_i32; states];
    let chip = |i: usize| usize::from(v[i % v.len()]);
    let mut state = (0..degree as usize).fold(0, |state, i| state << 1 | chip(i));
    for (i, &u) in u.iter().enumerate() {
        values[state] = 2 * i32::from(u) - 1;
        state = (state << 1 | chip(i + degree as usize)) & (states - 1);
    }
    for half in (0..degree).map(|bit| 1 << bit) {
        for block in values.chunks_exact_mut(2 * half) {
            let (left, right) = block.split_at_mut(half);
            for (a, b) in left.iter_mut().zip(right) {
                (*a, *b) = (*a + *b, *a - *b);
            }
        }
    }
    // The transform has (-1)^chip where the correlation has chi = -(-1)^chip.
    value_counts(values[1..].iter().map(|&value| -i64::from(value)))
}

/// +1 for chip 1, -1 for chip 0 (eq. 10).
fn chi(chip: u8) -> i64 {
    2 * i64::from(chip) - 1
}

fn correlate_fft(a: &[u8], b: &[u8]) -> Vec<f64> {
    let length = a.len();
    let [forward, inverse] = goldtof_fft::pair(length);
    let spectrum = |code: &[u8]| {
        let mut values: Vec<Complex<f64>> =
            code.iter().map(|&chip| Complex::new(chi(chip) as f64, 0.0)).collect();
        forward.process(&mut values);
        values
    };
    let mut product: Vec<Complex<f64>> = spectrum(a)
        .into_iter()
        .zip(spectrum(b))
        .map(|(a, b)| a.conj() * b / length as f64)
        .collect();
    inverse.process(&mut product);
    product.into_iter().map(|value| value.re).collect()
}

/// The nearest integers, or `None` if one of them is more than 1/4 away.
fn nearest_integers(values: &[f64]) -> Option<Vec<i64>> {
    values
        .iter()
        .map(|&value| ((value - value.round()).abs() < 0.25).then_some(value.round() as i64))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::super::Lfsr;
    use super::*;

    #[test]
    fn the_counts_of_all_lags_are_those_of_the_definition() {
        for (degree, pair) in [
            (3, [vec![3, 1, 0], vec![3, 2, 0]]),
            (5, [vec![5, 2, 0], vec![5, 4, 3, 2, 0]]),
            (8, [vec![8, 4, 3, 2, 0], vec![8, 6, 5, 3, 0]]),
            (9, [vec![9, 4, 0], vec![9, 4, 0]]),
        ] {
            let [u, v] = pair.map(|polynomial| {
                let register = Lfsr::new(degree, &polynomial, None).unwrap();
                register.chips((1 << degree) - 1)
            });
            assert_eq!(
                cross_correlation_counts(&u, &v, degree),
                value_counts(correlate_naive(&u, &v)),
                "degree {degree}"
            );
        }
    }

    #[test]
    fn doubtful_rounding_is_refused() {
        assert_eq!(nearest_integers(&[1.1, -2.9]), Some(vec![1, -3]));
        assert_eq!(nearest_integers(&[1.0, 2.4]), None);
        assert_eq!(nearest_integers(&[f64::NAN]), None);
    }

    #[test]
    fn the_lag_advances_the_second_code() {
        // b is a delayed by one chip, so advancing b by one makes them equal.
        assert_eq!(correlate(&[1, 0, 0, 0], &[0, 1, 0, 0]), [0, 4, 0, 0]);
    }
}
