//! No light, and too much of it.

use super::prelude::*;
use crate::estimate::Estimate;
use crate::photons::fast::StepCounter;

/// Photons per second that reach the detector, a factor of 1,000 apart.
const INCIDENT_CPS: [f64; 4] = [1e3, 1e6, 1e9, 1e12];

pub(super) const CASES: &[Case] = cases! {
    Light quick "no-light-at-all":
        "estimates from 20 scans of a dark, noiseless sensor, by photons and by sampled pulses",
        "without counts there is nothing to estimate: \"no estimate\", neither 0 nor NaN",
        no_light;
    Light quick "one-photon-counted-up-in-the-whole-scan":
        "distance of the estimate from the one phase step that counted, largest over all steps",
        "one sample of the triangle is its centre: the phase of a single term is zero",
        |_| one_photon_up();
    Light quick "one-photon-counted-down-in-the-whole-scan":
        "phase steps for which a single photon counted down gives an estimate",
        "all other steps share the largest count, zero: the correlation has no peak",
        |_| one_photon_down();
    Light quick "constant-light-1e3-to-1e12-photons-per-second":
        "largest deviation of the mean count from the closed form, detection probability 0.31, \
         dead time 14 ns",
        "renewal process: rate = lambda / (1 + lambda D), which saturates at 1 / D",
        constant_light_saturates;
    Light quick "no-rate-beyond-one-count-per-dead-time":
        "largest detection rate of a step times dead time, all of Table I, 10^3 to 10^12 photons \
         per second",
        "avalanches are a dead time or more apart: one count more than T / D at most, and lambda \
         D / (1 + lambda D) of them in the brightest light at least, which is all but 1",
        saturation;
    Light slow "photons-agree-with-the-state-equation-in-saturation":
        "largest deviation of signed and total counts over 40 phase steps from the mean \
         response, all of Table I, 10^6 to 10^10 photons per second",
        "photons one by one against the detector's state equation, two constructions of one \
         process; the largest of 320 normal deviations is below 4.5 in all but 1 of 460 draws",
        photons_against_state_equation;
    Light slow "the-estimate-in-saturation":
        "difference of the simulated from the expected bias at 10^9 photons per second (0.97 of \
         saturation)",
        "the mean response gives the walk of a nearly saturated detector; the estimate follows it",
        estimate_in_saturation;
    Light quick "too-much-light-for-the-mean-response-is-refused":
        "lights within 1 % below the limit that are refused, or above it that are not or without \
         both rates, dead times 14 ns and 40 ns, 14 ns with 1 us chips; and 256 detections in a \
         dead time of 1 ms, solved for hours",
        "the documented limits: 256 detections in a dead time, 128 in a chip, 2^22 chips to \
         forget",
        |_| too_much_light();
    Light quick "too-little-light-for-the-lanes-is-said":
        "wrong verdicts on light of one photon in 10,500, 10,600 and 10^12 chips, and on none, \
         for a code of 31 chips",
        "the documented limit: one photon in ten periods of the tables, which are the code's \
         times 34 (1,024 chips at least)",
        |_| too_little_light();
};

fn no_light(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let [dark, lit] = [ideal(GOLD_5, 8, 0.0, 310)?, ideal(GOLD_5, 8, 1e8, 310)?];
    let (mut estimates, mut of_light) = (0, 0);
    for tier in [Tier::Events, Tier::Sampled] {
        of_light += simulated(&lit, tier, seed, 20)?.estimates[0].estimates;
        for path in simulated(&dark, tier, seed, 20)?.estimates {
            estimates += path.estimates;
            for value in [path.mean_distance_m, path.bias_m, path.std_m, path.expected_bias_m] {
                estimates += u64::from(value.is_some());
            }
        }
    }
    CaseMeasurement::none(estimates as usize, of_light as usize, "estimates")
}

/// Estimate from a scan of one photon in one step.
fn one_photon(scene: &Scene, step: usize, sign: i64) -> Result<Estimate, NoEstimate> {
    let mut counts = vec![0; scene.scan.steps as usize];
    counts[step] = sign;
    estimated(scene, &counts)
}

fn one_photon_up() -> Result<CaseMeasurement, CaseError> {
    let scene = ideal(GOLD_5, 8, 0.0, 310)?;
    let errors_ps: Result<Vec<f64>, NoEstimate> = (0..scene.scan.steps as usize)
        .map(|step| Ok(one_photon(&scene, step, 1)?.delay_ps - 1000.0 * step as f64))
        .collect();
    CaseMeasurement::largest(errors_ps?, "ps", 1e-9)
}

fn one_photon_down() -> Result<CaseMeasurement, CaseError> {
    let scene = ideal(GOLD_5, 8, 0.0, 310)?;
    let estimates = |sign: i64| {
        let steps = 0..scene.scan.steps as usize;
        steps.filter(|&step| one_photon(&scene, step, sign).is_ok()).count()
    };
    // One that is counted up does give an estimate.
    CaseMeasurement::none(estimates(-1), estimates(1), "estimates")
}

fn constant_light_saturates(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let dead_time_s = 14e-9;
    let mut deviations = Vec::new();
    for incident_cps in INCIDENT_CPS {
        let chips = if incident_cps < 1e5 { 12_500_000 } else { 20_000 };
        let scene = constant_light(incident_cps, chips, |spad| {
            spad.photon_detection_probability = 0.31;
            spad.dead_time_ps = dead_time_s * 1e12;
        })?;
        let primary_cps = 0.31 * incident_cps;
        let expected = primary_cps * step_s(&scene) / (1.0 + primary_cps * dead_time_s);
        let totals = totals(&scene, 200, seed);
        // A saturated detector's counts hardly scatter; its mean count is within
        // one of the closed form, however the step starts.
        let scale = totals.standard_error().max(0.25);
        deviations.push((totals.mean - expected) / scale);
    }
    CaseMeasurement::deviation(deviations)
}

fn saturation(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut most = 0.0_f64;
    let mut limit = 0.0_f64;
    for incident_cps in INCIDENT_CPS {
        let scene = table_i(GOLD_5, 0.31 * incident_cps, 20_000)?;
        let per_step = counts(&scene, 50, seed).iter().map(|c| c.total).max();
        let fit = step_s(&scene) / 14e-9;
        most = most.max(per_step.unwrap_or(0) as f64 / fit);
        // Jitter may bring one more over either rim.
        limit = limit.max((fit + 2.0) / fit);
    }
    CaseMeasurement::between(most, "counts per dead time", [0.99, limit])
}

fn photons_against_state_equation(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut deviations = Vec::new();
    for incident_cps in [1e6, 1e8, 1e9, 1e10] {
        let scene = table_i(GOLD_5, 0.31 * incident_cps, 3_100)?;
        let means = mean_counts(&scene)?;
        let steps = 40;
        let found = counts_of_scans(&scene, 0..400, steps as u64, seed);
        for (step, mean) in means.iter().enumerate().take(steps) {
            let of_step = || found.iter().skip(step).step_by(steps);
            let signed = SampleStatistics::of(of_step().map(|c| c.signed as f64));
            let total = SampleStatistics::of(of_step().map(|c| c.total as f64));
            deviations.push(signed.z(mean.signed));
            deviations.push(total.z(mean.total));
        }
    }
    CaseMeasurement::largest(deviations, "standard errors", 4.5)
}

fn estimate_in_saturation(seed: u64) -> Result<CaseMeasurement, CaseError> {
    let mut scene = table_i(GOLD_11, 0.31e9, 131_000)?;
    window(&mut scene, 0, 48);
    let simulation = simulated(&scene, Tier::Events, seed, 60)?;
    let path = &simulation.estimates[0];
    let (Some(bias_m), Some(error_m), Some(expected_m)) =
        (path.bias_m, path.bias_std_error_m, path.expected_bias_m)
    else {
        return Err(format!("no estimates: {:?}", path.remark).into());
    };
    CaseMeasurement::deviation([(bias_m - expected_m) / error_m])
}

fn too_much_light() -> Result<CaseMeasurement, CaseError> {
    let mut wrong = 0;
    for (dead_time_ps, chip_period_ps) in [(14e3, 8e3), (40e3, 8e3), (14e3, 1e6)] {
        let limit_cps = 1e12 * f64::min(256.0 / dead_time_ps, 128.0 / chip_period_ps);
        for share in [0.99, 1.01] {
            let rate_cps = share * limit_cps;
            let mut scene = constant_light(rate_cps, 31, |spad| spad.dead_time_ps = dead_time_ps)?;
            scene.chip_period_ps = chip_period_ps;
            let reason = refused(&scene);
            let says = |cps: f64| {
                reason.as_ref().is_none_or(|reason| reason.contains(&format!("{cps:.3e} cps")))
            };
            let is_right = reason.is_some() == (share > 1.0);
            wrong += usize::from(!(is_right && says(rate_cps) && says(limit_cps)));
        }
    }
    let scene = constant_light(200e3, 31, |spad| spad.dead_time_ps = 1e9)?;
    // 10^5 dead times of 125,000 chips.
    let says_so = refused(&scene).is_some_and(|reason| reason.contains("1.250e10 chips"));
    CaseMeasurement::none(wrong + usize::from(!says_so), 7, "verdicts")
}

/// Why a scene has no mean response.
fn refused(scene: &Scene) -> Option<String> {
    let model = model(scene);
    refusal(|| Some(MeanResponse::of_tier(&model, CountingTier::Events).err()?.to_string()))
}

fn too_little_light() -> Result<CaseMeasurement, CaseError> {
    let mut wrong = 0;
    for wait_chips in [20_400.0, 20_600.0, 1e12, f64::INFINITY] {
        let scene = constant_light(1.0 / (8e-9 * wait_chips), 31, |_| ())?;
        let model = model(&scene);
        let reason = refusal(|| Some(StepCounter::new(&model).outside_domain()?.to_string()));
        let says = |reason: &String| match wait_chips.is_finite() {
            true => {
                reason.contains(&format!("once in {wait_chips:.3e} chips"))
                    && reason.contains("one photon in 20470 chips")
            }
            false => reason.contains("no photon ever comes") && !reason.contains("inf"),
        };
        let is_too_little = wait_chips > 20_470.0;
        let is_right = reason.is_some() == is_too_little && reason.iter().all(says);
        wrong += usize::from(!is_right);
    }
    CaseMeasurement::none(wrong, 4, "verdicts")
}
