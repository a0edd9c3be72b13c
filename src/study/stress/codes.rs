//! Codes and scans at the ends of their parameters.

use super::prelude::*;
use crate::estimate::CoarseOnly;
use crate::estimate::report::Reporter;

pub(super) const CASES: &[Case] = cases! {
    Codes slow "degree-3-to-20-correlations":
        "lags of m-sequences of degrees 3 to 20 whose correlation is not the theorem's",
        "an m-sequence correlates with itself to L at lag 0 and to -1 at every other",
        |_| wrong_m_sequence_lags(3..=20);
    Codes quick "degree-3-to-12-correlations":
        "lags of m-sequences of degrees 3 to 12 whose correlation is not the theorem's",
        "an m-sequence correlates with itself to L at lag 0 and to -1 at every other",
        |_| wrong_m_sequence_lags(3..=12);
    Codes quick "degree-3-in-simulation":
        "largest deviation of the mean signed count, peak and one chip off it, degree 3",
        "ideal detector, off-light zero: r = photons (theta + 2 w - L) / (2 w), eq. 14 in \
         brackets",
        |seed| simulated_m_sequence(3, 3_500, seed);
    Codes slow "degree-20-in-simulation":
        "largest deviation of the mean signed count, peak and one chip off it, degree 20",
        "ideal detector, off-light zero: r = photons (theta + 2 w - L) / (2 w), eq. 14 in \
         brackets",
        |seed| simulated_m_sequence(20, 1_048_575, seed);
    Codes quick "interleaving-0-to-8":
        "lags, over nu = 0..8 of a Gold code of 127 chips, that break the closed form",
        "lag 2^nu q + s: (-1)^s ((2^nu - s) theta[q] + s theta[q + 1]), from eq. 23 directly",
        |_| interleaving();
    Codes quick "interleaving-0-to-8-in-simulation":
        "largest deviation of the mean signed count, peak and one chip off it, over nu = 0..8 of \
         a Gold code of 7 chips",
        "ideal detector, off-light zero: r = photons (theta + 2 w - L') / (2 w) with theta from \
         the definition",
        interleaving_in_simulation;
    Codes quick "samples-per-chip-1-to-64-in-simulation":
        "largest deviation of the mean signed count for light half a phase step before the \
         peak's, S = 1..64",
        "linear between whole chips: theta = L - (L + 1) / (2 S) for an m-sequence",
        samples_per_chip_in_simulation;
    Codes quick "samples-per-chip-2-to-64":
        "largest error over phase step, exact triangles at 640 delays per S = 2..64",
        "the fine estimate must never be worse than the coarse one, which is half a step off",
        |_| samples_per_chip();
    Codes quick "triangles-on-the-grid":
        "largest error of the estimate for triangles centred on a phase step, S = 2..64",
        "a symmetric window has the phase 0 exactly",
        |_| centred_triangles();
    Codes quick "one-sample-per-chip-is-coarse-only":
        "scans with S = 1 whose estimate is fine, or off by more than half a phase step",
        "two samples on the triangle's base hold no phase: only a coarse estimate is possible",
        |_| one_sample_per_chip();
    Codes quick "a-scan-of-one-step-gives-no-estimate":
        "estimates from scans of a single phase step, counts -1,000 to 1,000",
        "a single count cannot be a peak",
        |_| one_step();
    Codes quick "a-scan-that-wraps-round-the-period":
        "largest relative difference of expected counts between a window over the period's end \
         and the same steps of the full scan",
        "with whole code periods per step a count does not depend on when its step comes",
        |_| wrapping_scan();
    Codes quick "the-estimate-of-a-wrapping-scan":
        "error of the estimate from an exact triangle across the period's end",
        "steps repeat with the period, so the window's neighbours are those of the circle",
        |_| wrapping_estimate();
    Codes quick "a-scan-longer-than-the-period-is-refused":
        "scans of 249, 1,000 and 2^62 of 248 phase steps that are accepted",
        "a phase step twice in one scan has no place in it",
        |_| overlong_scan();
    Codes quick "delays-beyond-the-range-fold":
        "counts that change when a path of 0.75 chips gets 1, 1,000 or 10^6 code periods longer",
        "the light repeats with the code period: the same bits",
        folded_delays;
    Codes quick "folding-is-said":
        "reports of a path beyond the unambiguous range that do not say that it is folded",
        "a distance that is off by whole ranges must not pass for the truth",
        folding_is_said;
};

fn m_sequence(degree: u32) -> Result<Vec<u8>, CaseError> {
    let spec = CodeSpec { degree: Some(degree), ..CodeSpec::new(Family::MSequence) };
    Ok(spec.build()?.chips)
}

fn wrong_m_sequence_lags(
    degrees: std::ops::RangeInclusive<u32>,
) -> Result<CaseMeasurement, CaseError> {
    let (mut wrong, mut seen) = (0, 0);
    for degree in degrees {
        let chips = m_sequence(degree)?;
        let expected = |lag| if lag == 0 { chips.len() as i64 } else { -1 };
        let found = correlation(&chips, &chips);
        let lags = found.iter().enumerate();
        wrong += lags.filter(|&(lag, &theta)| theta != expected(lag)).count();
        wrong += chips.len().abs_diff(found.len());
        seen += found.len();
    }
    CaseMeasurement::none(wrong, seen, "lags")
}

/// Deviation of the signed counts of a scene of one phase step from that of a correlation of
/// `theta` chips.
fn correlation_z(scene: &Scene, theta: f64, seed: u64) -> f64 {
    let code = &scene.sources[0].code;
    let (length, weight) = (code.len() as f64, code.weight() as f64);
    let photons = 10e6 * step_s(scene);
    signed_z(scene, 100, seed, photons * (theta + 2.0 * weight - length) / (2.0 * weight))
}

fn simulated_m_sequence(
    degree: u32,
    integration_chips: u64,
    seed: u64,
) -> Result<CaseMeasurement, CaseError> {
    let code = format!("{{ family = \"m-sequence\", degree = {degree} }}");
    let length = f64::from((1 << degree) - 1);
    let mut deviations = Vec::new();
    for (chip, theta) in [(0, length), (1, -1.0)] {
        // Far out on the code, so that every chip number gets its turn.
        let delay_chips = (1_u64 << degree) - 3;
        let mut scene = lit_step(&code, 8, integration_chips, (delay_chips - chip) * 8)?;
        scene.paths[0].delay_ps = 8e3 * delay_chips as f64;
        deviations.push(correlation_z(&scene, theta, seed));
    }
    CaseMeasurement::deviation(deviations)
}

fn interleaving_in_simulation(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut deviations = Vec::new();
    for nu in 0..=8 {
        let code = format!("{{ family = \"gold\", degree = 3, interleave = {nu} }}");
        for lag in [0, 1] {
            let scene = lit_step(&code, 8, 7 << nu.max(6), 8 * lag)?;
            let chips = &scene.sources[0].code.chips;
            let sign = |i: usize| 2.0 * f64::from(chips[i % chips.len()]) - 1.0;
            let theta: f64 = (0..chips.len()).map(|i| sign(i) * sign(i + lag as usize)).sum();
            deviations.push(correlation_z(&scene, theta, seed));
        }
    }
    CaseMeasurement::deviation(deviations)
}

fn samples_per_chip_in_simulation(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut deviations = Vec::new();
    for samples in [1, 2, 4, 8, 16, 32, 64] {
        let step = 11 * u64::from(samples) / 2;
        let code = r#"{ family = "m-sequence", degree = 5 }"#;
        let mut scene = lit_step(code, samples, 3_100, step)?;
        let step_chips = 1.0 / f64::from(samples);
        scene.paths[0].delay_ps = 8e3 * (step as f64 - 0.5) * step_chips;
        deviations.push(correlation_z(&scene, 31.0 - 0.5 * step_chips * 32.0, seed));
    }
    CaseMeasurement::deviation(deviations)
}

fn interleaving() -> Result<CaseMeasurement, CaseError> {
    let code = |interleave| {
        CodeSpec { degree: Some(7), interleave, ..CodeSpec::new(Family::Gold) }.build()
    };
    let base = correlation(&code(0)?.chips, &code(0)?.chips);
    let mut wrong = usize::from(base.first() != Some(&127));
    for nu in 0..=8 {
        let chips = code(nu)?.chips;
        let found = correlation(&chips, &chips);
        wrong += chips.len().abs_diff(found.len());
        let depth = 1i64 << nu;
        for (lag, &theta) in found.iter().enumerate() {
            let (q, s) = (lag >> nu, lag as i64 % depth);
            let sign = if s % 2 == 0 { 1 } else { -1 };
            let next = base[(q + 1) % base.len()];
            wrong += usize::from(theta != sign * ((depth - s) * base[q] + s * next));
        }
    }
    CaseMeasurement::none(wrong, base.len(), "lags")
}

/// A scene without light whose scan covers 31 chips with S samples each.
fn scan_of(samples_per_chip: u32) -> Result<Scene, CaseError> {
    Ok(ideal(GOLD_5, samples_per_chip, 0.0, 310)?)
}

/// Counts of a triangle of base 2 T_c round `delay_steps`, 10^12 high.
fn triangle(scene: &Scene, delay_steps: f64) -> Vec<i64> {
    let period = scene.scan.steps_per_period as f64;
    let base = f64::from(scene.samples_per_chip);
    Step::all(scene.scan.steps)
        .map(|step| {
            let turns = (scene.scan.phase_step(step) as f64 - delay_steps) / period;
            let distance = (turns - turns.round()).abs() * period;
            ((1.0 - distance / base).max(0.0) * 1e12).round() as i64
        })
        .collect()
}

/// Error of the estimate from an exact triangle, in phase steps.
fn triangle_error(scene: &Scene, delay_steps: f64) -> Result<f64, CaseError> {
    let counts = triangle(scene, delay_steps);
    let found = estimated(scene, &counts)?;
    ensure!(found.is_fine(), "{:?}", found.coarse_only);
    let step_ps = scene.clock().sample_period_ps();
    let period = scene.scan.steps_per_period as f64;
    let turns = (found.delay_ps / step_ps - delay_steps) / period;
    Ok((turns - turns.round()) * period)
}

fn samples_per_chip() -> Result<CaseMeasurement, CaseError> {
    let mut errors = Vec::new();
    for samples in [2, 4, 8, 16, 32, 64] {
        let scene = scan_of(samples)?;
        for n in 0..640 {
            errors.push(triangle_error(&scene, 3.0 * f64::from(n) / 64.0)?);
        }
    }
    CaseMeasurement::largest(errors, "phase steps", 0.5)
}

fn centred_triangles() -> Result<CaseMeasurement, CaseError> {
    let mut errors = Vec::new();
    for samples in [2, 4, 8, 16, 32, 64] {
        let scene = scan_of(samples)?;
        for step in 0..scene.scan.steps {
            errors.push(triangle_error(&scene, step as f64)?);
        }
    }
    CaseMeasurement::largest(errors, "phase steps", 1e-9)
}

fn one_sample_per_chip() -> Result<CaseMeasurement, CaseError> {
    let scene = scan_of(1)?;
    let mut wrong = 0;
    for n in 0..310 {
        let delay_steps = f64::from(n) / 10.0;
        let found = estimated(&scene, &triangle(&scene, delay_steps))?;
        let turns = (found.delay_ps / 8e3 - delay_steps) / 31.0;
        let error = (turns - turns.round()).abs() * 31.0;
        let is_right = found.coarse_only == Some(CoarseOnly::OneSamplePerChip);
        wrong += usize::from(!is_right || error > 0.5 + 1e-9);
    }
    CaseMeasurement::none(wrong, 310, "scans")
}

fn one_step() -> Result<CaseMeasurement, CaseError> {
    let mut scene = scan_of(8)?;
    window(&mut scene, 17, 1);
    let estimates = (-1_000..=1_000)
        .filter(|&count| estimated(&scene, &[count]) != Err(NoEstimate::Flat { count }))
        .count();
    CaseMeasurement::none(estimates, 2_001, "estimates")
}

fn wrapping_scan() -> Result<CaseMeasurement, CaseError> {
    let full = table_i(GOLD_5, 20e6, 31 * 100)?;
    let mut wrapped = full.clone();
    window(&mut wrapped, 240, 30);
    let (full_means, means) = (mean_counts(&full)?, mean_counts(&wrapped)?);
    let differences = means.iter().enumerate().map(|(j, mean)| {
        let same = full_means[(240 + j) % 248];
        (mean.signed - same.signed) / same.total
    });
    CaseMeasurement::largest(differences, "of the total count", 1e-12)
}

fn wrapping_estimate() -> Result<CaseMeasurement, CaseError> {
    let mut scene = scan_of(8)?;
    window(&mut scene, 230, 40);
    let errors = [triangle_error(&scene, 0.0)?, triangle_error(&scene, 247.0)?];
    CaseMeasurement::largest(errors, "phase steps", 1e-9)
}

fn overlong_scan() -> Result<CaseMeasurement, CaseError> {
    let is_accepted = |steps: u64| -> Result<bool, CaseError> {
        let steps = format!("scan.steps={{ first = 3, count = {steps} }}").parse()?;
        Ok(verdict(ideal_with(GOLD_5, 8, 20e6, 1_250, &[steps]).is_ok()))
    };
    ensure!(is_accepted(248)?, "a whole period was refused");
    let accepted = [is_accepted(249)?, is_accepted(1_000)?, is_accepted(1 << 62)?];
    let accepted = accepted.into_iter().filter(|&is_accepted| is_accepted);
    CaseMeasurement::none(accepted.count(), 3, "scans")
}

/// Table I with a path of 0.75 chips and a number of code periods.
fn folded(periods: u64) -> Result<Scene, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, 3_100)?;
    // Three quarters of a chip and whole chips are exact in binary.
    scene.paths[0].delay_ps = 6e3 + 248e3 * periods as f64;
    Ok(scene)
}

fn folded_delays(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let near = counts(&folded(0)?, 248, seed);
    let mut wrong = 0;
    for periods in [1, 1_000, 1_000_000] {
        wrong += differing(&near, &counts(&folded(periods)?, 248, seed));
    }
    CaseMeasurement::none(wrong, seen(&near), "counts")
}

fn folding_is_said(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let scene = folded(3)?;
    let found = counts(&scene, 248, seed);
    let report = Reporter::new(&Sensor::new(&scene), DetectorIndex(0)).scan(&found);
    let says_so = report.folded.is_some_and(|folded| folded.contains("unambiguous range"));
    CaseMeasurement::none(usize::from(!says_so), seen(&found), "reports")
}
