//! Photons to distance, many times: the JSON of `goldtof simulate`.

use std::fmt::Write as _;
use std::time::Instant;

use serde::Serialize;

use super::scans::{ScansError, scans};
use super::{Tier, domain, expected};
use crate::estimate::{
    CountingTier, Measurement, TrueDelay, calibration_offset_ps, delay_error_ps, distance_m,
    estimate, predict, true_delay,
};
use crate::scene::Scene;

/// What a simulation gives.
#[derive(Debug, Clone, Serialize)]
pub struct Simulation {
    /// The scene's name.
    pub scene: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// How much of the sensor was simulated.
    pub fidelity: Tier,
    /// For which scenes and questions its answers hold.
    pub domain: &'static str,
    /// Where this scene is outside of that, and what it does to the answer.
    pub warnings: Vec<String>,
    /// Scans simulated; none by the tier that draws nothing.
    pub repetitions: u64,
    /// One entry per detector and path of its own source.
    pub estimates: Vec<PathStatistics>,
    /// Wall time.
    pub run_time_s: f64,
}

/// Statistics of the estimates that a detector's scans give of one path.
///
/// A repetition counts for the path nearest to its estimate, if that is within a
/// chip of it; all statistics are over the repetitions that count for the path.
#[derive(Debug, Clone, Serialize)]
pub struct PathStatistics {
    /// Name of the detector.
    pub detector: String,
    /// Index of the path in the scene.
    pub path: usize,
    /// True distance, folded into the unambiguous range; without a fluctuation,
    /// whose effect belongs to the scatter.
    pub true_m: f64,
    /// When a path that moves has it, from the start of the scan: as the scan comes
    /// by the path. None for a path that stands still.
    pub true_at_s: Option<f64>,
    /// Repetitions that count for the path.
    pub estimates: u64,
    /// Their share of all repetitions: how often the coarse stage is right.
    pub correct_coarse_fraction: f64,
    /// Mean estimate; none without estimates.
    pub mean_m: Option<f64>,
    /// Mean error.
    pub bias_m: Option<f64>,
    /// Standard deviation of one scan's estimate; none below two estimates.
    pub std_m: Option<f64>,
    /// Standard error of `mean_m` and `bias_m`.
    pub std_error_m: Option<f64>,
    /// Standard error of `std_m`, for normal errors.
    pub std_std_error_m: Option<f64>,
    /// The bias that the exact mean response gives.
    pub expected_bias_m: Option<f64>,
    /// The standard deviation that it gives.
    pub expected_std_m: Option<f64>,
    /// Rate of counted detections.
    pub detected_rate_cps: f64,
    /// Why there is no fine estimate, where that is so.
    pub remark: Option<String>,
}

/// Simulates a scene's detectors, `repetitions` scans each.
///
/// # Errors
/// When the tier cannot do the scene.
pub fn simulate(
    scene: &Scene,
    tier: Tier,
    seed: u64,
    repetitions: u64,
) -> Result<Simulation, ScansError> {
    let started = Instant::now();
    let mut estimates = Vec::new();
    let mut warnings = Vec::new();
    for detector in 0..scene.detectors.len() {
        let mut errors = PathErrors::new(scene, detector, tier.counting());
        let mut detections = 0;
        let mut signed = Vec::new();
        scans(scene, detector, tier, seed, repetitions, |counts| {
            detections += counts.iter().map(|count| count.total).sum::<u64>();
            signed.clear();
            signed.extend(counts.iter().map(|count| count.signed));
            errors.take(&signed);
        })?;
        let integration_s = scene.scan.integration_chips as f64 * scene.chip_period_ps * 1e-12;
        let measured_s = repetitions as f64 * scene.scan.steps as f64 * integration_s;
        let mut statistics = errors.statistics(detections as f64 / measured_s);
        if !tier.draws() {
            expected::answer(scene, detector, &mut statistics)?;
        }
        estimates.extend(statistics);
        warnings.extend(domain::warnings(scene, detector, tier));
    }
    Ok(Simulation {
        scene: scene.name.clone(),
        seed,
        fidelity: tier,
        domain: domain::of(tier),
        warnings,
        repetitions: if tier.draws() { repetitions } else { 0 },
        estimates,
        run_time_s: started.elapsed().as_secs_f64(),
    })
}

/// Errors of a detector's estimates, sorted by path.
struct PathErrors<'a> {
    scene: &'a Scene,
    detector: usize,
    counting: CountingTier,
    offset_ps: f64,
    code_period_ps: f64,
    /// Paths of the detector's own source.
    paths: Vec<usize>,
    /// What each of them should be found at.
    truths: Vec<TrueDelay>,
    errors_m: Vec<Vec<f64>>,
    scans: u64,
    remark: Option<String>,
}

impl<'a> PathErrors<'a> {
    fn new(scene: &'a Scene, detector: usize, counting: CountingTier) -> PathErrors<'a> {
        let own = scene.detectors[detector].reference;
        let paths: Vec<usize> = (0..scene.paths.len())
            .filter(|&p| scene.paths[p].detector == detector && scene.paths[p].source == own)
            .collect();
        PathErrors {
            scene,
            detector,
            counting,
            offset_ps: calibration_offset_ps(scene, detector, counting),
            code_period_ps: scene.chip_period_ps * scene.sources[own].code.len() as f64,
            errors_m: vec![Vec::new(); paths.len()],
            truths: paths
                .iter()
                .map(|&path| true_delay(scene, path, counting))
                .collect(),
            paths,
            scans: 0,
            remark: None,
        }
    }

    fn take(&mut self, counts: &[i64]) {
        self.scans += 1;
        let estimate = match estimate(&Measurement::new(self.scene, counts), self.offset_ps) {
            Ok(estimate) => estimate,
            Err(reason) => {
                self.remark = Some(reason.to_string());
                return;
            }
        };
        if let Some(reason) = estimate.coarse_only {
            self.remark = Some(reason.to_string());
        }
        let error_ps = |truth: &TrueDelay| {
            delay_error_ps(estimate.delay_ps, truth.delay_ps, self.code_period_ps)
        };
        let nearest = self
            .truths
            .iter()
            .map(error_ps)
            .zip(&mut self.errors_m)
            .min_by(|(a, _), (b, _)| a.abs().total_cmp(&b.abs()));
        if let Some((error_ps, errors_m)) = nearest
            && error_ps.abs() <= self.scene.chip_period_ps
        {
            errors_m.push(distance_m(error_ps));
        }
    }

    fn statistics(&self, detected_rate_cps: f64) -> Vec<PathStatistics> {
        let of_path = |((&path, truth), errors_m): ((&usize, &TrueDelay), &Vec<f64>)| {
            let true_m = distance_m(truth.delay_ps.rem_euclid(self.code_period_ps));
            let moments = Moments::of(errors_m);
            let expected = predict(self.scene, self.detector, path, self.counting).ok();
            PathStatistics {
                detector: self.scene.detectors[self.detector].name.clone(),
                path,
                true_m,
                true_at_s: truth.at_ps.map(|ps| ps * 1e-12),
                estimates: errors_m.len() as u64,
                correct_coarse_fraction: errors_m.len() as f64 / self.scans as f64,
                mean_m: moments.mean.map(|mean| true_m + mean),
                bias_m: moments.mean,
                std_m: moments.std,
                std_error_m: moments.std_error,
                std_std_error_m: moments.std_std_error,
                expected_bias_m: expected.map(|e| e.bias_m),
                expected_std_m: expected.map(|e| e.std_m),
                detected_rate_cps,
                remark: self.remark.clone(),
            }
        };
        let truths = self.paths.iter().zip(&self.truths);
        truths.zip(&self.errors_m).map(of_path).collect()
    }
}

/// Mean and scatter of a sample; what it is too small for is not there.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Moments {
    mean: Option<f64>,
    std: Option<f64>,
    std_error: Option<f64>,
    std_std_error: Option<f64>,
}

impl Moments {
    fn of(values: &[f64]) -> Moments {
        let n = values.len() as f64;
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / n);
        let std = mean.filter(|_| values.len() > 1).map(|mean| {
            let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            (squares / (n - 1.0)).sqrt()
        });
        Moments {
            mean,
            std,
            std_error: std.map(|std| std / n.sqrt()),
            std_std_error: std.map(|std| std / (2.0 * (n - 1.0)).sqrt()),
        }
    }
}

impl Simulation {
    /// The simulation in words.
    pub fn to_text(&self) -> String {
        let mut text = format!(
            "{}: {} scans, fidelity {}, seed {}, {:.2} s\n",
            self.scene, self.repetitions, self.fidelity, self.seed, self.run_time_s
        );
        let millimetres = |value: Option<f64>| match value {
            Some(metres) => format!("{:.2} mm", metres * 1e3),
            None => "none".to_owned(),
        };
        for e in &self.estimates {
            let _ = writeln!(
                text,
                "{}, path {} at {:.4} m: bias {} +- {}, standard deviation {} +- {}, coarse stage \
                 right in {:.1} % of {}",
                e.detector,
                e.path,
                e.true_m,
                millimetres(e.bias_m),
                millimetres(e.std_error_m),
                millimetres(e.std_m),
                millimetres(e.std_std_error_m),
                e.correct_coarse_fraction * 100.0,
                self.repetitions,
            );
            if let Some(at_s) = e.true_at_s {
                let _ = writeln!(
                    text,
                    "  moving: the distance is that of {:.4} ms after the start of the scan",
                    at_s * 1e3
                );
            }
            if e.expected_bias_m.is_some() {
                let _ = writeln!(
                    text,
                    "  expected: bias {}, standard deviation {}",
                    millimetres(e.expected_bias_m),
                    millimetres(e.expected_std_m)
                );
            }
            let _ = writeln!(
                text,
                "  {:.3} million detections per second",
                e.detected_rate_cps / 1e6
            );
            if let Some(remark) = &e.remark {
                let _ = writeln!(text, "  {remark}");
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_sample_is_too_small_for_is_not_there() {
        let nothing = Moments::of(&[]);
        assert_eq!((nothing.mean, nothing.std), (None, None));
        let one = Moments::of(&[2.0]);
        assert_eq!((one.mean, one.std), (Some(2.0), None));
        // 1, 3: mean 2, squared deviations 1 + 1 over n - 1 = 1.
        let two = Moments::of(&[1.0, 3.0]);
        assert_eq!((two.mean, two.std), (Some(2.0), Some(2.0f64.sqrt())));
        assert_eq!(two.std_error, Some(1.0));
    }
}
