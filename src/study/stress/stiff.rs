//! Time scales many decades apart.

use super::prelude::*;
use crate::photons::Detection;

const NO_DRIFT: &str = "time is whole chips and an offset, and the code's position is taken modulo \
                        the code: the same random numbers must give the same detections, to the \
                        last bit, however late the step begins";

pub(super) const CASES: &[Case] = cases! {
    Stiff quick "no-drift-after-1e6-code-periods":
        "detections of a step that differ from those of the step begun 10^6 code periods earlier \
         (1 fs transition, 1 ps jitter)",
        NO_DRIFT,
        |seed| detections_moved_by(1_000_000, seed);
    Stiff quick "no-drift-after-1e12-code-periods":
        "detections of a step that differ from those of the step begun 10^12 code periods (69 \
         hours) earlier",
        NO_DRIFT,
        |seed| detections_moved_by(1_000_000_000_000, seed);
    Stiff quick "no-drift-of-counts-after-1e12-code-periods":
        "signed and total counts, of both photon engines, that differ from those 10^12 code \
         periods earlier",
        "counts of whole numbers from the same random numbers: exactly equal, reference included",
        counts_after_1e12_periods;
    Stiff quick "an-edge-of-the-light-stands-after-1e12-code-periods":
        "largest distance of 20,000 detections from the edge of the light that they follow, \
         10^12 code periods after the start",
        "with no light in the off-state none may come before the edge, and with a mean wait of \
         10 as none of 20,000 comes more than 1 fs behind it (probability 10^-39)",
        edge_after_1e12_periods;
    Stiff slow "afterpulsing-time-constants-1-ps-to-1-ms":
        "largest deviation of the mean count over the time constants 1 ps, 100 ps, 5 ns, 1 us, 1 \
         ms, without dead time",
        "without dead time afterpulses are a branching process: the rate is the primary rate \
         over 1 - m with m = -ln(1 - p), whatever the time constant",
        afterpulsing_time_constants;
    Stiff quick "a-quick-trap-refires-at-the-dead-time":
        "deviation of the mean count with time constant 1 ps, dead time 14 ns, p = 0.5",
        "afterpulses within picoseconds: an avalanche is followed by another with probability p, \
         so rate = lambda / (1 - p + lambda D), up to tau / D = 10^-4",
        |seed| quick_trap_behind_dead_time(5e6, 0.5, 400, seed);
    Stiff slow "a-slow-trap-is-constant-light":
        "deviation of the mean count with time constant 1 ms, dead time 14 ns, p = 0.137",
        "delays far beyond the mean interval make afterpulses a Poisson process: R = (lambda + m \
         R)(1 - R D)",
        slow_trap;
    Stiff quick "dead-times-from-0-to-many-code-periods":
        "largest deviation of the mean count over the dead times 0, 1 ps, 14 ns, 1 us (4 code \
         periods) at 50 Mcps",
        "renewal process: rate = lambda / (1 + lambda D)",
        |seed| CaseMeasurement::deviation(dead_times(seed)?.iter().map(|found| found[0]));
    Stiff quick "dead-times-quiet-the-counts":
        "largest deviation of the counts' variance over the same dead times",
        "equilibrium renewal process: variance = lambda T / m^3 + 1/6 + 1/(2 m^4) - 2/(3 m^3) \
         with m = 1 + lambda D (Cox, Renewal Theory, 1962)",
        |seed| CaseMeasurement::deviation(dead_times(seed)?.iter().map(|found| found[1]));
    Stiff quick "a-dead-time-of-4000-code-periods":
        "distance of the mean count of 1 s from T / (D + 1 / lambda), dead time 1 ms, 50 Mcps",
        "a renewal count differs from T over the mean interval by at most one, however it starts",
        millisecond_dead_time;
    Stiff quick "chip-periods-100-ps-to-1-ms":
        "largest relative change of the expected bias and scatter, in chips, when chip period \
         and every other time are scaled from 8 ns to 100 ps, 1 us and 1 ms",
        "dimensional analysis: nothing but ratios of times can matter",
        |_| chip_periods();
    Stiff quick "chip-periods-scaled-by-powers-of-two":
        "counts that change when every time is scaled by 2^-6 (125 ps chips) or 2^17 (1.05 ms \
         chips)",
        "dimensional analysis, and powers of two are exact: the same bits",
        scaled_by_powers_of_two;
};

/// Table I with a 1 fs transition and 1 ps of jitter.
fn stiff_sensor(integration_chips: u64) -> Result<Scene, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, integration_chips)?;
    scene.detectors[0].jitter_ps = vec![1.0];
    scene.detectors[0].counter.transition_ps = 1e-3;
    // Two steps: the second one begins an integration time after the first.
    window(&mut scene, 0, 2);
    Ok(scene)
}

/// The first detections of step 1, which begins `periods` code periods after step 0, compared
/// with those of a step that begins 1,000 periods after it, and lasts for more of them.
fn detections_moved_by(periods: u64, seed: u64) -> Result<CaseMeasurement, CaseError> {
    let start_of_step_1 = |periods: u64| -> Result<Vec<Detection>, CaseError> {
        Ok(detections(&stiff_sensor(31 * periods)?, 3_000, seed))
    };
    let early = start_of_step_1(1_000)?;
    let late = start_of_step_1(1_000 + periods)?;
    let differing = early.iter().zip(&late).filter(|(a, b)| a != b).count();
    let seen = early.iter().filter(|detection| detection.chip > 0).count();
    CaseMeasurement::none(differing + early.len().abs_diff(late.len()), seen, "detections")
}

fn counts_after_1e12_periods(seed: u64) -> Result<CaseMeasurement, CaseError> {
    // Scan number 1 begins where scan number 0 ended; a scan of many steps puts
    // it far away, with the same random numbers.
    let scan_1 = |periods: u64| -> Result<Vec<StepCount>, CaseError> {
        let mut scene = stiff_sensor(31)?;
        scene.scan.integration_chips = 31;
        scene.scan.steps = periods;
        scene.scan.steps_per_period = 31 * 8;
        let mut found = counts_of_scans(&scene, 1..2, 200, seed);
        found.extend(plain_counts(&scene, 1, 200, seed));
        Ok(found)
    };
    // Neither is the full scan of 248 steps.
    let early = scan_1(249)?;
    let late = scan_1(1_000_000_000_000)?;
    CaseMeasurement::none(differing(&early, &late), seen(&early), "counts")
}

fn edge_after_1e12_periods(seed: u64) -> Result<CaseMeasurement, CaseError> {
    const PERIODS: u64 = 1_000_000_000_000;
    // One on-chip in four, with photons 10 as apart; the dead time leaves the
    // first of them.
    let on_rate_cps = 1e17;
    let mut scene =
        ideal(r#"{ family = "chips", chips = "0100" }"#, 8, on_rate_cps / 4.0, 4 * PERIODS)?;
    scene.detectors[0].dead_time_ps = 2.0 * 8e3;
    let delay_chips = 0.3;
    scene.paths[0].delay_ps = delay_chips * 8e3;
    window(&mut scene, 0, 2);
    let detections = detections(&scene, 20_000, seed);
    let offsets_fs = detections.iter().map(|detection| {
        let offset_chips = (detection.chip % 4) as f64 + detection.fraction - 1.0 - delay_chips;
        offset_chips * 8e6
    });
    CaseMeasurement::largest(offsets_fs, "fs", 1.0)
}

fn afterpulsing_time_constants(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let (primary_cps, probability) = (1e6, 0.4);
    let expected_cps = primary_cps / (1.0 + f64::ln_1p(-probability));
    let mut deviations = Vec::new();
    for time_constant_ps in [1.0, 100.0, 5e3, 1e6, 1e9] {
        // Steps far longer than the longest time constant.
        let chips = if time_constant_ps > 1e8 { 1_250_000 } else { 50_000 };
        let scene = constant_light(primary_cps, chips, |spad| {
            spad.afterpulsing_probability = probability;
            spad.afterpulsing_time_constant_ps = time_constant_ps;
        })?;
        deviations.push(rate_z(&scene, 12_500_000 / chips * 4, seed, expected_cps));
    }
    CaseMeasurement::deviation(deviations)
}

/// Mean count when each avalanche is followed, with this probability, by another
/// at the very end of its dead time of 14 ns: lambda / (1 - p + lambda D).
pub(super) fn quick_trap_behind_dead_time(
    primary_cps: f64,
    probability: f64,
    scans: u64,
    seed: u64,
) -> Result<CaseMeasurement, CaseError> {
    let dead_time_s = 14e-9;
    let scene = constant_light(primary_cps, 20_000, |spad| {
        spad.dead_time_ps = dead_time_s * 1e12;
        spad.afterpulsing_probability = probability;
        spad.afterpulsing_time_constant_ps = 1.0;
    })?;
    let expected_cps = primary_cps / (1.0 - probability + primary_cps * dead_time_s);
    CaseMeasurement::deviation([rate_z(&scene, scans, seed, expected_cps)])
}

fn slow_trap(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let (primary_cps, dead_time_s) = (1e7, 14e-9);
    let mean = -f64::ln_1p(-0.137);
    let scene = constant_light(primary_cps, 250_000, |spad| {
        spad.dead_time_ps = dead_time_s * 1e12;
        spad.afterpulsing_probability = 0.137;
        spad.afterpulsing_time_constant_ps = 1e9;
    })?;
    // D m R^2 + (1 + D lambda - m) R - lambda = 0, its positive root.
    let (a, b) = (dead_time_s * mean, 1.0 + dead_time_s * primary_cps - mean);
    let expected_cps = ((b * b + 4.0 * a * primary_cps).sqrt() - b) / (2.0 * a);
    CaseMeasurement::deviation([rate_z(&scene, 40, seed, expected_cps)])
}

/// Deviations of mean and variance.
fn dead_times(seed: u64) -> Result<Vec<[f64; 2]>, CaseError> {
    let primary_cps = 50e6;
    [0.0, 1.0, 14e3, 1e6]
        .into_iter()
        .map(|dead_time_ps| {
            // At least some hundred dead times and counts in a step.
            let chips = if dead_time_ps > 1e5 { 400_000 } else { 2_500 };
            let scene =
                constant_light(primary_cps, chips, |spad| spad.dead_time_ps = dead_time_ps)?;
            let totals = totals(&scene, 1_000, seed);
            // In mean waits for light: mean interval, and share of its scatter.
            let interval = 1.0 + primary_cps * dead_time_ps * 1e-12;
            let scatter = 1.0 / interval;
            let primary = primary_cps * step_s(&scene);
            let of_whole_numbers = 1.0 / 6.0 + scatter.powi(4) / 2.0 - 2.0 * scatter.powi(3) / 3.0;
            Ok([
                totals.z(primary / interval),
                totals.variance_z(primary / interval.powi(3) + of_whole_numbers),
            ])
        })
        .collect()
}

fn millisecond_dead_time(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let scene = constant_light(50e6, 125_000_000, |spad| spad.dead_time_ps = 1e9)?;
    let expected = step_s(&scene) / (1e-3 + 1.0 / 50e6);
    CaseMeasurement::largest([totals(&scene, 10, seed).mean - expected], "counts", 1.0)
}

/// A scene with every time multiplied by a factor, and every rate divided.
fn scaled(scene: &Scene, factor: f64) -> Scene {
    let mut scene = scene.clone();
    scene.chip_period_ps *= factor;
    scene.scan.requested_integration_ps *= factor;
    for source in &mut scene.sources {
        source.mean_power_w /= factor;
    }
    for path in &mut scene.paths {
        path.delay_ps *= factor;
    }
    for spad in &mut scene.detectors {
        spad.dark_count_rate_cps /= factor;
        spad.background_rate_cps /= factor;
        let counter = &mut spad.counter;
        for time in [
            &mut spad.dead_time_ps,
            &mut spad.afterpulsing_time_constant_ps,
            &mut spad.pulse_width_ps,
            &mut spad.delay_ps,
            &mut counter.rising_delay_ps,
            &mut counter.falling_delay_ps,
            &mut counter.transition_ps,
        ] {
            *time *= factor;
        }
        spad.jitter_ps.iter_mut().for_each(|time| *time *= factor);
    }
    scene
}

fn chip_periods() -> Result<CaseMeasurement, CaseError> {
    let scene = table_i(GOLD_5, 20e6, 13_100)?;
    let in_chips = |scene: &Scene| -> Result<[f64; 2], CaseError> {
        let expected = predicted(scene, CountingTier::Events)?;
        Ok([expected.bias_m, expected.std_m].map(|metres| metres / scene.chip_period_ps))
    };
    let expected = in_chips(&scene)?;
    let mut changes = Vec::new();
    for chip_period_ps in [100.0, 1e6, 1e9] {
        let found = in_chips(&scaled(&scene, chip_period_ps / 8e3))?;
        changes.extend((0..2).map(|i| found[i] / expected[i] - 1.0));
    }
    // Cells of some hundred steps, each with rounding errors of a few 10^-16,
    // in a difference of counts that cancel to a thousandth.
    CaseMeasurement::largest(changes, "relative", 1e-9)
}

fn scaled_by_powers_of_two(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let scene = table_i(GOLD_5, 20e6, 3_100)?;
    let expected = counts(&scene, 248, seed);
    let wrong = [-6, 17].map(|exponent| {
        differing(&expected, &counts(&scaled(&scene, 2f64.powi(exponent)), 248, seed))
    });
    CaseMeasurement::none(wrong.iter().sum(), seen(&expected), "counts")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_step_of_another_phase_is_found_to_differ() {
        // One chip more than a whole number of periods.
        let first = |late| detections(&stiff_sensor(late).unwrap(), 100, 1);
        assert_ne!(first(31_000), first(31_001));
    }
}
