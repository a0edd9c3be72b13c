//! Detectors at the ends of their parameters.

use super::prelude::*;
use super::stiff::quick_trap_behind_dead_time;
use crate::light::photon_rate_hz;
use crate::photons::{Level, PulseStream};
use crate::scan::{Sample, Sampler};
use crate::scene::{self, Combination, Crosstalk, Recharge};

pub(super) const CASES: &[Case] = cases! {
    Detectors quick "detection-probability-0":
        "deviation of the mean count in bright light from that of the dark counts",
        "no photon fires the detector: a Poisson process of the dark count rate is left",
        blind_detector;
    Detectors quick "detection-probability-1":
        "deviation of the mean count from the photons of 10 pW at 783 nm",
        "every photon counts: P T lambda / (h c), with CODATA's exact h and c",
        perfect_detector;
    Detectors quick "passive-recharge-past-its-maximum":
        "deviations of mean and variance of the counts, 50 and 200 Mcps behind a dead time of 14 \
         ns that each arrival begins anew",
        "paralyzable dead time: rate r = lambda exp(-lambda D), largest at lambda D = 1; the \
         pair density is r^2 beyond D and 0 within, so the variance of N counts in T is r T - \
         r^2 D (2 T - D)",
        passive_recharge;
    Detectors quick "passive-recharge-in-the-mean-response":
        "largest error of the expected mean and variance of the counts, 1, 50 and 1,000 Mcps behind a \
         dead time of 14 ns that each arrival begins anew, relative to them",
        "the same, without noise: nothing is averaged over the fold at lambda D = 1",
        |_| passive_recharge_expected();
    Detectors quick "sixteen-cells-in-each-combination":
        "deviations of the mean count of sixteen cells behind an OR, an XOR tree, a coincidence of two \
         and an adder, 20, 200 and 1,000 Mcps, pulses of 7 ns, dead times of 14 ns",
        "cells are independent renewal processes of rate m and high for q = m w: 16 m (1 - q)^15 edges \
         of an OR, 16 m of an XOR and of an adder, 240 m q (1 - q)^14 where two overlap",
        sixteen_cells;
    Detectors quick "crosstalk-of-probability-1-between-cells":
        "deviation of the mean count of two cells that fire one another at once, behind an OR and a \
         coincidence of both, 20 and 300 Mcps, dead time 14 ns",
        "both are one SPAD in the light of two: lambda / (1 + lambda D), and each pulse overlaps the \
         other's",
        certain_crosstalk_of_cells;
    Detectors quick "crosstalk-of-probability-1":
        "deviation of the mean count of one of two detectors that fire one another at once, 20 and \
         100 Mcps each behind 14 ns",
        "each avalanche is one of both, so that both are one detector in the light of two: rate = \
         lambda / (1 + lambda D) with lambda of both",
        certain_crosstalk;
    Detectors quick "afterpulsing-probability-0":
        "counts that differ between probability 0 with a time constant and no afterpulsing",
        "left out is left out, not changed: the same bits",
        no_afterpulses;
    Detectors quick "afterpulsing-0.99-behind-a-dead-time":
        "deviation of the mean count, p = 0.99, time constant 1 ps, dead time 14 ns, 1 Mcps",
        "4.6 afterpulses per avalanche, but those within the next dead time are lost: rate = \
         lambda / (1 - p + lambda D), up to tau / D = 10^-4 (D = 14 ns gives 0.58 of 1 / D)",
        |seed| quick_trap_behind_dead_time(1e6, 0.99, 200, seed);
    Detectors quick "afterpulsing-0.99-saturates":
        "largest count of a step times dead time over integration time, p = 0.99 at Table I",
        "avalanches are a dead time or more apart, however many afterpulses are pending; and \
         afterpulses only add to the lambda D / (1 + lambda D) = 0.219 without them",
        runaway_saturates;
    Detectors slow "afterpulsing-just-below-runaway":
        "deviation of the mean count, m = -ln(1 - p) = 0.9, no dead time",
        "branching process: rate = lambda / (1 - m), ten times the primary one",
        nearly_runaway;
    Detectors quick "runaway-is-refused-where-the-mean-diverges":
        "wrong verdicts of the scene on p = 0.63, 0.64, 0.99 without and with a dead time",
        "without dead time an avalanche begets m = -ln(1 - p) others on average, so the mean \
         diverges from m = 1 (p = 1 - 1/e = 0.632...) on; with one the rate stays below 1 / D",
        |_| runaway_refused();
    Detectors quick "bins-of-a-hundredth-and-of-nearly-a-chip":
        "deviations of the dark counts at each sample from its width, seven of 0.01 sample periods and \
         one of 7.93, dead time and afterpulses of Table I",
        "code-density test: dark counts know nothing of the clock, and dead time and afterpulses \
         shift along with time, so the share of the rising edges at a sample is its bin's width",
        narrow_bins;
    Detectors quick "bins-of-a-hundredth-in-the-mean-response":
        "largest error of the expected hits at each sample of constant light of 45 Mcps against its \
         width, relative to the widest",
        "the same, without noise",
        |_| narrow_bins_expected();
    Detectors quick "jitter-of-ten-chips":
        "largest deviation of signed counts from the triangle smeared by the jitter, three phase \
         steps",
        "without dead time jitter convolves the correlation with a Gaussian: summed numerically \
         from the definition",
        |seed| CaseMeasurement::deviation(smeared(seed)?.photons);
    Detectors quick "jitter-of-ten-chips-in-the-mean-response":
        "largest error of the expected signed counts against the same sum, relative to the \
         unsmeared peak",
        "the convolution is smooth over ten chips, so the sum over 64 points per chip is exact \
         to rounding",
        |seed| CaseMeasurement::largest(smeared(seed)?.expected, "of the peak", 1e-6);
};

fn blind_detector(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene = ideal(GOLD_5, 8, 1e9, 31_000)?;
    let spad = &mut scene.detectors[0];
    spad.photon_detection_probability = 0.0;
    spad.background_rate_cps = 1e9;
    spad.dark_count_rate_cps = 71e3;
    CaseMeasurement::deviation([rate_z(&scene, 248, seed, 71e3)])
}

fn perfect_detector(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene = ideal(GOLD_5, 8, 0.0, 31_000)?;
    scene.sources[0].mean_power_w = 1e-11;
    let expected = photon_rate_hz(1e-11, 783.0) * step_s(&scene);
    // 1 W at 1.239841984 um is one elementary charge's worth per volt: 1 eV each.
    let electron_volts = 1.239_841_984 / 0.783;
    let by_charge = 1e-11 / (electron_volts * 1.602_176_634e-19) * step_s(&scene);
    ensure!((expected / by_charge - 1.0).abs() < 1e-9, "photon energy");
    CaseMeasurement::deviation([totals(&scene, 248, seed).z(by_charge)])
}

fn no_afterpulses(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, 3_100)?;
    scene.detectors[0].afterpulsing_probability = 0.0;
    let with_constant = counts(&scene, 248, seed);
    scene.detectors[0].afterpulsing_time_constant_ps = 0.0;
    let without = counts(&scene, 248, seed);
    CaseMeasurement::none(differing(&with_constant, &without), seen(&without), "counts")
}

/// Simulated far beyond the rate at which a paralyzable detector counts most.
fn passive_recharge(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let dead_time_s = 14e-9;
    let mut deviations = Vec::new();
    for primary_cps in [50e6, 200e6] {
        let scene = constant_light(primary_cps, 2_000, |spad| {
            (spad.dead_time_ps, spad.recharge) = (14e3, Recharge::Passive);
        })?;
        let totals = totals(&scene, 248, seed);
        let (rate, time_s) = (primary_cps * (-primary_cps * dead_time_s).exp(), step_s(&scene));
        deviations.push(totals.z(rate * time_s));
        let fewer = rate * rate * dead_time_s * (2.0 * time_s - dead_time_s);
        deviations.push(totals.variance_z(rate * time_s - fewer));
    }
    CaseMeasurement::deviation(deviations)
}

fn passive_recharge_expected() -> Result<CaseMeasurement, CaseError> {
    let dead_time_s = 14e-9;
    let mut errors = Vec::new();
    for primary_cps in [1e6, 50e6, 1e9] {
        let scene = constant_light(primary_cps, 100, |spad| {
            (spad.dead_time_ps, spad.recharge) = (14e3, Recharge::Passive);
        })?;
        let [mean, variance] = moments_of_total(&scene, Step(0))?;
        let (rate, time_s) = (primary_cps * (-primary_cps * dead_time_s).exp(), step_s(&scene));
        let fewer = rate * rate * dead_time_s * (2.0 * time_s - dead_time_s);
        errors.push((mean / (rate * time_s) - 1.0).abs());
        errors.push((variance / (rate * time_s - fewer) - 1.0).abs());
    }
    CaseMeasurement::largest(errors, "of the moment", 1e-4)
}

/// Constant light seen through seven narrow bins and a wide one, and pulses that none of them misses.
fn narrow_bins_scene(rate_cps: f64) -> Result<Scene, CaseError> {
    let scene = constant_light(rate_cps, 31_000, |spad| {
        // Pulse and widest bin fit into the dead time.
        (spad.dead_time_ps, spad.pulse_width_ps) = (17e3, 8e3);
        (spad.afterpulsing_probability, spad.afterpulsing_time_constant_ps) = (0.137, 5e3);
        spad.sampler = Sampler::of_widths(&NARROW_BINS);
    })?;
    ensure!(scene.samples_per_chip == 8, "a width for each sample");
    Ok(scene)
}

const NARROW_BINS: [f64; 8] = [0.01, 0.01, 0.01, 7.93, 0.01, 0.01, 0.01, 0.01];

fn narrow_bins(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let scene = narrow_bins_scene(5e6)?;
    let model = model(&scene);
    let mut pulses = Vec::new();
    let samples = scene.scan.steps * scene.scan.integration_chips * 8;
    PulseStream::new(&model, seed, 0).advance(Sample(samples), &mut pulses);
    let mut level = Level::default();
    let mut hits = vec![0.0; 8];
    for pulse in &pulses {
        hits[(pulse.first.0 % 8) as usize] += f64::from(u8::from(level.rises(pulse)));
    }
    let hits = numbers(hits);
    let all: f64 = hits.iter().sum();
    CaseMeasurement::deviation(hits.iter().zip(NARROW_BINS).map(|(hits, width)| {
        let share = width / 8.0;
        (hits - all * share) / (all * share * (1.0 - share)).sqrt()
    }))
}

fn narrow_bins_expected() -> Result<CaseMeasurement, CaseError> {
    let scene = narrow_bins_scene(45e6)?;
    let model = model(&scene);
    let hits = numbers(MeanResponse::new(&model)?.hits_per_sample());
    let all: f64 = hits.iter().sum();
    let chips = hits.len() as f64 / 8.0;
    let errors = hits
        .iter()
        .zip(NARROW_BINS.iter().cycle())
        .map(|(hits, width)| (hits / all * chips * 8.0 / width - 1.0).abs() * width / 7.93);
    CaseMeasurement::largest(errors, "of the widest", 1e-9)
}

fn certain_crosstalk(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut deviations = Vec::new();
    for primary_cps in [20e6, 100e6] {
        let mut scene = constant_light(primary_cps, 2_000, |spad| {
            spad.dead_time_ps = 14e3;
            spad.crosstalk = Some(Crosstalk { probability: 1.0, delay_ps: 0.0 });
        })?;
        let second = scene::Detector { name: "second".to_owned(), ..scene.detectors[0].clone() };
        scene.detectors.push(second);
        let both_cps = 2.0 * primary_cps;
        deviations.push(rate_z(&scene, 248, seed, both_cps / (1.0 + both_cps * 14e-9)));
    }
    CaseMeasurement::deviation(deviations)
}

fn sixteen_cells(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut deviations = Vec::new();
    for primary_cps in [20e6, 200e6, 1e9] {
        let of_cell = primary_cps / 16.0 / (1.0 + primary_cps / 16.0 * 14e-9);
        let high: f64 = of_cell * 7e-9;
        for (combination, coincidence, rate) in [
            (Combination::Or, 1, 16.0 * of_cell * (1.0 - high).powi(15)),
            (Combination::Xor, 1, 16.0 * of_cell),
            (Combination::Adder, 1, 16.0 * of_cell),
            (Combination::Or, 2, 240.0 * of_cell * high * (1.0 - high).powi(14)),
        ] {
            let scene = constant_light(primary_cps, 31_000, |spad| {
                (spad.dead_time_ps, spad.pulse_width_ps, spad.cells) = (14e3, 7e3, 16);
                (spad.combination, spad.coincidence) = (combination, coincidence);
            })?;
            deviations.push(rate_z(&scene, 8, seed, rate));
        }
    }
    CaseMeasurement::deviation(deviations)
}

fn certain_crosstalk_of_cells(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut deviations = Vec::new();
    for primary_cps in [20e6, 300e6] {
        for coincidence in [1, 2] {
            let scene = constant_light(primary_cps, 2_000, |spad| {
                (spad.dead_time_ps, spad.cells, spad.coincidence) = (14e3, 2, coincidence);
                spad.cell_crosstalk = Some(Crosstalk { probability: 1.0, delay_ps: 0.0 });
            })?;
            let rate = primary_cps / (1.0 + primary_cps * 14e-9);
            deviations.push(rate_z(&scene, 248, seed, rate));
        }
    }
    CaseMeasurement::deviation(deviations)
}

fn runaway_saturates(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene = table_i(GOLD_5, 20e6, 3_100)?;
    scene.detectors[0].afterpulsing_probability = 0.99;
    let most = counts(&scene, 248, seed).iter().map(|c| c.total).max();
    let fit = step_s(&scene) / 14e-9;
    let per_fit = most.unwrap_or(0) as f64 / fit;
    CaseMeasurement::between(per_fit, "counts per dead time", [0.219, (fit + 2.0) / fit])
}

fn nearly_runaway(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let scene = constant_light(1e6, 250_000, |spad| {
        spad.afterpulsing_probability = 1.0 - (-0.9f64).exp();
        spad.afterpulsing_time_constant_ps = 5e3;
    })?;
    CaseMeasurement::deviation([rate_z(&scene, 400, seed, 10.0 * 1e6)])
}

fn runaway_refused() -> Result<CaseMeasurement, CaseError> {
    let is_refused = |probability: f64, dead_time: &str| -> Result<bool, CaseError> {
        let afterpulsing = format!("{{ probability = {probability}, time_constant = \"5 ns\" }}");
        let settings = [
            format!("detector.afterpulsing={afterpulsing}").parse()?,
            format!("detector.dead_time=\"{dead_time}\"").parse()?,
        ];
        Ok(verdict(ideal_with(GOLD_5, 8, 20e6, 1_250, &settings).is_err()))
    };
    let mut wrong = 0;
    for probability in [0.63, 0.64, 0.99] {
        let diverges = -f64::ln_1p(-probability) >= 1.0;
        wrong += usize::from(is_refused(probability, "0 ns")? != diverges);
        wrong += usize::from(is_refused(probability, "14 ns")?);
    }
    CaseMeasurement::none(wrong, 6, "verdicts")
}

struct Smeared {
    /// Deviations of simulated counts, in standard errors.
    photons: Vec<f64>,
    /// Errors of the expected counts, relative to the peak without jitter.
    expected: Vec<f64>,
}

const JITTER_CHIPS: f64 = 10.0;

fn smeared(seed: u64) -> Result<Smeared, CaseError> {
    let mut result = Smeared { photons: Vec::new(), expected: Vec::new() };
    for step in [0, 11, 100] {
        let mut scene = ideal(GOLD_5, 8, 20e6, 31 * 100)?;
        scene.detectors[0].jitter_ps = vec![JITTER_CHIPS * 8e3];
        window(&mut scene, step, 1);
        let photons = 20e6 * step_s(&scene);
        let mean = photons * smeared_correlation(&scene, step as f64 / 8.0);
        result.photons.push(signed_z(&scene, 400, seed, mean));
        let expected = mean_count(&scene, Step(0))?;
        result.expected.push((expected.signed - mean) / photons);
    }
    Ok(result)
}

/// Mean sign of a photon: on-light at time t, registered at t plus a normal
/// number, with the reference delayed by `lag_chips`; midpoint sums over t and
/// over the jitter.
fn smeared_correlation(scene: &Scene, lag_chips: f64) -> f64 {
    const POINTS: i64 = 64;
    let chips = &scene.sources[0].code.chips;
    let chip = |point: i64| chips[point.div_euclid(POINTS).rem_euclid(chips.len() as i64) as usize];
    let lag = (lag_chips * POINTS as f64).round() as i64;
    let points = POINTS * chips.len() as i64;
    // Mean sign for a fixed shift of the registered time, over all on-light.
    let signs: Vec<f64> = (0..points)
        .map(|shift| {
            let on = (0..points).filter(|&t| chip(t) == 1);
            let (mut sum, mut number) = (0.0, 0.0);
            for t in on {
                sum += 2.0 * f64::from(chip(t + shift - lag)) - 1.0;
                number += 1.0;
            }
            sum / number
        })
        .collect();
    let sigma = JITTER_CHIPS * POINTS as f64;
    let reach = (9.0 * sigma) as i64;
    let (mut sum, mut weight) = (0.0, 0.0);
    for shift in -reach..=reach {
        let density = (-0.5 * (shift as f64 / sigma).powi(2)).exp();
        sum += density * signs[shift.rem_euclid(points) as usize];
        weight += density;
    }
    sum / weight
}
