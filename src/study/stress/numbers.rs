//! Large, cancelling and unequal numbers.

use std::f64::consts::PI;
use std::sync::Arc;

use goldtof_fft::num_complex::Complex;
use goldtof_fft::{Fft, FftNum, pair, single_pair};

use super::prelude::*;

pub(super) const CASES: &[Case] = cases! {
    Numbers quick "the-estimate-of-1e12-counts":
        "largest difference of the estimate from 128-bit fixed-point arithmetic, uneven peaks of \
         10^12 counts",
        "sixteen products and sums of doubles: some 10^-16 of the phase each",
        |_| CaseMeasurement::largest([estimate_errors(0)?], "chips", 1e-14);
    Numbers quick "near-cancelling-up-and-down-counts":
        "the same for peaks of 1,000 counts on 10^12 to 10^17 common to all steps, of either sign",
        "roots of unity sum to zero, so what all steps have in common must not matter at all: as \
         exact as without it",
        |_| near_cancelling();
    Numbers quick "sums-of-1e12-counts-drawn":
        "deviation of mean and variance of drawn totals of 10^12 counts, 100 Mcps for 3 hours \
         per step",
        "Poisson light without dead time: mean = variance = rate x time",
        drawn_totals;
    Numbers quick "expected-counts-of-hours":
        "largest relative difference of expected counts of 10^9 code periods from 10^9 times \
         those of one, all of Table I",
        "whole code periods all count the same",
        |_| hours_of_periods();
    Numbers quick "a-broken-period-after-hours":
        "largest error of the expected count of 10^9 code periods and 17 chips over that of 17 \
         chips and 10^9 times one period's, in counts",
        "additivity; 10^-16 of 10^8 counts, over some hundred additions",
        |_| broken_period();
    Numbers slow "fft-in-double-precision-is-exact":
        "largest distance from whole numbers, correlation of 1,048,575 chips by f64 FFT",
        "rounding grows as eps L log2 L at most, and 0.5 is where an integer would be lost",
        |_| CaseMeasurement::largest([fft_error(20, pair)?], "of 1", 1e-6);
    Numbers slow "fft-in-single-precision":
        "largest difference of the f32 from the f64 correlation of 1,048,575 chips, relative to \
         the peak",
        "single precision is good for eps_32 times a small multiple of log2 L = 20",
        |_| {
            let error = fft_error(20, single_pair)? / f64::from((1 << 20) - 1);
            CaseMeasurement::largest([error], "of the peak", 20.0 * f64::from(f32::EPSILON))
        };
    Numbers quick "fft-in-single-against-double-precision-degree-11":
        "the same for 2,047 chips",
        "single precision is good for eps_32 times a small multiple of log2 L = 11",
        |_| {
            let error = fft_error(11, single_pair)? / 2047.0;
            CaseMeasurement::largest([error], "of the peak", 11.0 * f64::from(f32::EPSILON))
        };
    Numbers quick "rates-15-decades-apart":
        "largest relative error of the part of 1 ncps dark counts in the expected total, and of \
         1 Mcps light beside them",
        "without dead time totals add; a double holds 15.9 decades, and the smaller part is \
         10^-15 of the sum",
        |_| rates_apart();
    Numbers quick "a-count-per-hour":
        "deviation of the mean count, 0.3 mcps of dark counts (one an hour) over 10^4 s a step",
        "Poisson process; 1.25 10^12 chips to a step, 4 10^11 between counts",
        rare_counts;
};

/// 1 in the fixed-point arithmetic.
const ONE: i128 = 1 << 60;

/// cos(pi i / 8) with 60 binary digits, by half-angle formulas and integer roots.
fn cosine(i: i64) -> i128 {
    let half = |cosine: i128, sign: i128| (((ONE + sign * cosine) as u128) << 59).isqrt() as i128;
    let of_pi_4 = (1u128 << 119).isqrt() as i128;
    let quarter = [ONE, half(of_pi_4, 1), of_pi_4, half(of_pi_4, -1), 0];
    match i.rem_euclid(16) as usize {
        i @ 0..=4 => quarter[i],
        i @ 5..=8 => -quarter[8 - i],
        i @ 9..=12 => -quarter[i - 8],
        i => quarter[16 - i],
    }
}

/// Largest error of the estimate over some uneven peaks of S = 8 and 1,000 or
/// more counts on `offset` common ones, in chips.
fn estimate_errors(offset: i64) -> Result<f64, CaseError> {
    let scene = ideal(GOLD_5, 8, 0.0, 310)?;
    let height = if offset == 0 { 1_000_000_000_000 } else { 1_000 };
    let mut errors = Vec::new();
    for shape in 1..200_i64 {
        let peak = shape % 248;
        let counts: Vec<i64> = (0..248)
            .map(|step| {
                let distance = (step - peak).rem_euclid(248);
                let signed = if distance > 124 { distance - 248 } else { distance };
                // A triangle with a slope to one side, within -8..8 of the peak.
                let triangle = (8 - signed.abs()).max(0) * (300 + shape * signed.signum());
                offset + triangle * height / 4_096 + (step * shape) % 3
            })
            .collect();
        let found = estimated(&scene, &counts)?;
        let coarse = found.coarse_step as i64;
        let (mut re, mut im) = (0_i128, 0_i128);
        for i in -8..8 {
            // Less the common part in whole numbers: it would cancel anyway.
            let count = i128::from(counts[(coarse + i).rem_euclid(248) as usize] - offset);
            re += count * cosine(i);
            im -= count * cosine(i - 4);
        }
        let fine_chips = -(im as f64).atan2(re as f64) / PI;
        let expected_chips = coarse as f64 / 8.0 + fine_chips;
        let turns = (found.delay_ps / 8e3 - expected_chips) / 31.0;
        errors.push((turns - turns.round()) * 31.0);
        ensure!(found.is_fine(), "{:?}", found.coarse_only);
    }
    // A delay of up to 31 chips is itself rounded to 3.6 10^-15.
    Ok(worst(errors))
}

fn near_cancelling() -> Result<CaseMeasurement, CaseError> {
    let mut errors = Vec::new();
    for offset in [1_000_000_000_000, 1_000_000_000_000_000, 100_000_000_000_000_000] {
        errors.push(estimate_errors(offset)?);
        errors.push(estimate_errors(-offset)?);
    }
    CaseMeasurement::largest(errors, "chips", 1e-14)
}

fn drawn_totals(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let scene = constant_light(1e8, 1_250_000_000_000, |_| ())?;
    let mean = 1e8 * step_s(&scene);
    let model = model(&scene);
    let response = MeanResponse::of_tier(&model, CountingTier::Events)?;
    let moments = SecondMoments::new(&response)?.of_step(Step(0));
    let sampler = CountSampler::new(&model, &[moments])?;
    let counts: Vec<_> = (0..20_000).flat_map(|scan| drawn(&sampler, 1, seed, scan)).collect();
    let totals = of_totals(&counts);
    CaseMeasurement::deviation([totals.z(mean), totals.variance_z(mean)])
}

/// Expected signed and total counts of Table I over `chips` chips a step.
fn expected_counts(chips: u64) -> Result<Vec<f64>, CaseError> {
    let mut scene = table_i(GOLD_11, 10e6, chips)?;
    window(&mut scene, 0, 40);
    let means = mean_counts(&scene)?;
    ensure!(means.iter().all(|mean| mean.total > 0.0) && !means.is_empty(), "nothing is expected");
    Ok(means.iter().flat_map(|m| [m.signed, m.total]).collect())
}

fn hours_of_periods() -> Result<CaseMeasurement, CaseError> {
    let one = expected_counts(2_047)?;
    let many = expected_counts(2_047_000_000_000)?;
    let differences = one.iter().zip(&many).map(|(one, many)| many / (one * 1e9) - 1.0);
    CaseMeasurement::largest(differences, "relative", 1e-12)
}

fn broken_period() -> Result<CaseMeasurement, CaseError> {
    // Only the first step starts with the code's first chip in all three.
    let first = |chips| -> Result<[f64; 2], CaseError> {
        let counts = expected_counts(chips)?;
        Ok([counts[0], counts[1]])
    };
    let periods = 1_000_000_000;
    let (one, part) = (first(2_047)?, first(17)?);
    let both = first(2_047 * periods + 17)?;
    let errors = (0..2).map(|i| both[i] - (one[i] * periods as f64 + part[i]));
    CaseMeasurement::largest(errors, "counts", 1e-4)
}

/// Largest distance of an FFT correlation in precision `T` of an m-sequence from
/// the theorem's whole numbers.
fn fft_error<T: FftNum + Into<f64>>(
    degree: u32,
    plan: impl Fn(usize) -> [Arc<dyn Fft<T>>; 2],
) -> Result<f64, CaseError> {
    let spec = CodeSpec { degree: Some(degree), ..CodeSpec::new(Family::MSequence) };
    let chips = spec.build()?.chips;
    let length = chips.len();
    let [forward, inverse] = plan(length);
    let number = |value: f64| T::from_f64(value).unwrap_or_else(T::zero);
    let mut values: Vec<Complex<T>> = chips
        .iter()
        .map(|&chip| Complex::new(number(2.0 * f64::from(chip) - 1.0), T::zero()))
        .collect();
    forward.process(&mut values);
    for value in &mut values {
        *value = Complex::new(value.norm_sqr(), T::zero());
    }
    inverse.process(&mut values);
    let values = numbers(values.iter().map(|value| value.re.into()).collect());
    let errors = values.iter().enumerate().map(|(lag, value)| {
        let expected = if lag == 0 { length as f64 } else { -1.0 };
        value / length as f64 - expected
    });
    Ok(worst(errors))
}

fn rates_apart() -> Result<CaseMeasurement, CaseError> {
    let total = |light_cps: f64, dark_cps: f64| -> Result<f64, CaseError> {
        let mut scene = ideal(GOLD_5, 8, light_cps, 31 * 1_000)?;
        scene.detectors[0].dark_count_rate_cps = dark_cps;
        Ok(mean_count(&scene, Step(0))?.total / step_s(&scene))
    };
    let errors = [
        total(0.0, 1e-9)? / 1e-9 - 1.0,
        total(1e6, 0.0)? / 1e6 - 1.0,
        total(1e6, 1e-9)? / 1e6 - 1.0,
    ];
    CaseMeasurement::largest(errors, "relative", 1e-13)
}

fn rare_counts(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene: Scene = ideal(GOLD_5, 8, 0.0, 1_250_000_000_000)?;
    scene.detectors[0].dark_count_rate_cps = 0.3e-3;
    // Three counts a step.
    CaseMeasurement::deviation([rate_z(&scene, 248, seed, 0.3e-3)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_point_cosines_have_sixty_binary_digits() {
        for i in -20..20 {
            let expected = (PI * i as f64 / 8.0).cos();
            assert!((cosine(i) as f64 / ONE as f64 - expected).abs() < 1e-15, "{i}");
        }
        let squares = cosine(1) * cosine(1) / ONE + cosine(3) * cosine(3) / ONE;
        assert!((squares - ONE).abs() < 8);
    }
}
