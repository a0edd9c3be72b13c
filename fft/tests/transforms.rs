//! The transforms against what is known of them: a tone, its length.

use goldtof_fft::pair;
use rustfft::num_complex::Complex64;

#[test]
fn a_tone_is_one_line_and_comes_back_times_the_length() {
    let length = 31;
    let tone = |i: usize| Complex64::cis(2.0 * std::f64::consts::PI * 3.0 * i as f64 / 31.0);
    let mut values: Vec<Complex64> = (0..length).map(tone).collect();
    let [forward, inverse] = pair(length);
    forward.process(&mut values);
    for (frequency, value) in values.iter().enumerate() {
        let expected = if frequency == 3 { 31.0 } else { 0.0 };
        assert!((value - expected).norm() < 1e-12, "{frequency}: {value}");
    }
    inverse.process(&mut values);
    for (i, value) in values.iter().enumerate() {
        assert!((value - 31.0 * tone(i)).norm() < 1e-11);
    }
}
