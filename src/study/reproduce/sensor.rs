//! The article's sensors, as scenes.

use std::sync::Arc;

use crate::code::{Code, CodeError, CodeSpec, Family};
use crate::estimate::{CountingTier, Prediction, PredictionError, calibration_offset_ps, predict};
use crate::scene::{DetectorIndex, Path, PathIndex, Scan, Scene, Source, SourceIndex};
use crate::sensor::Sensor;

/// Chip period of the article.
pub const CHIP_PERIOD_PS: f64 = 8000.0;
/// Phase steps per chip of the article (zeta = 3).
pub const SAMPLES_PER_CHIP: u32 = 8;
/// Time of flight of a target 3.2 m away, where no other is given.
pub const TARGET_PS: f64 = 21_348.1;
/// Optical power, in picowatts, where no other is given: 4.9 million primary
/// detections per second.
pub const POWER_PW: f64 = 4.0;

/// A code of the article's Gold set of length 2047.
pub fn gold(index: i64, interleave: u32) -> Result<Arc<Code>, CodeError> {
    let spec = CodeSpec {
        degree: Some(11),
        index: Some(index),
        interleave,
        ..CodeSpec::new(Family::Gold)
    };
    spec.build().map(Arc::new)
}

/// A balanced code of that set (weight 2^(n-1)), as the article demands after
/// eq. 18: number `number` of them, in the order of their indices. Other codes
/// leave a pedestal of 2 w / L - 1 of the hits under every correlation.
pub fn balanced_gold(number: usize, interleave: u32) -> Result<Arc<Code>, CodeError> {
    gold(balanced_index(number)?, interleave)
}

/// Its index. An odd degree n has 2^(n-1) + 1 balanced codes.
pub fn balanced_index(number: usize) -> Result<i64, CodeError> {
    let mut passed = 0;
    // The last index is followed by an error.
    for index in 0.. {
        let code = gold(index, 0)?;
        let weight = code.chips.iter().filter(|&&chip| chip == 1).count();
        if 2 * weight == code.chips.len() + 1 {
            if passed == number {
                return Ok(index);
            }
            passed += 1;
        }
    }
    unreachable!("an index beyond the set is an error")
}

/// The square wave that the article compares with.
pub fn square() -> Result<Arc<Code>, CodeError> {
    CodeSpec::new(Family::Square).build().map(Arc::new)
}

/// Light of one code over one path.
#[derive(Debug, Clone)]
pub struct PathLight {
    /// The code.
    pub code: Arc<Code>,
    /// Mean power at the detector, in picowatts.
    pub power_pw: f64,
    /// Time of flight.
    pub delay_ps: f64,
}

impl PathLight {
    /// Light of a code off the usual target.
    pub fn new(code: &Arc<Code>, power_pw: f64) -> PathLight {
        PathLight { code: code.clone(), power_pw, delay_ps: TARGET_PS }
    }

    /// The same light at another time of flight.
    pub fn at(self, delay_ps: f64) -> PathLight {
        PathLight { delay_ps, ..self }
    }
}

/// The sensor of Table I for the first of `lights`, with all of them on its
/// detector, and a scan over the whole code period.
///
/// # Panics
/// If there is no light at all.
pub fn sensor(lights: &[PathLight], integration_s: f64) -> Scene {
    let table_i = crate::study::table_i();
    let source = |(number, light): (usize, &PathLight)| Source {
        name: format!("laser{number}"),
        code: light.code.clone(),
        mean_power_w: light.power_pw * 1e-12,
        ..table_i.sources[0].clone()
    };
    let path = |(number, light): (usize, &PathLight)| Path {
        source: SourceIndex(number),
        delay_ps: light.delay_ps,
        ..table_i.paths[0].clone()
    };
    let steps = u64::from(SAMPLES_PER_CHIP) * lights[0].code.len();
    Scene {
        name: "article".to_owned(),
        origin: Default::default(),
        sources: lights.iter().enumerate().map(source).collect(),
        paths: lights.iter().enumerate().map(path).collect(),
        scan: Scan {
            first_step: 0,
            steps,
            steps_per_period: steps,
            integration_chips: (integration_s * 1e12 / CHIP_PERIOD_PS).round() as u64,
            requested_integration_ps: integration_s * 1e12,
        },
        ..table_i
    }
}

/// What the exact moments give of the phase estimate of the first path, for a coarse stage that
/// stands still.
pub fn expected(scene: &Scene) -> Result<Prediction, PredictionError> {
    predict(&Sensor::new(scene), DetectorIndex(0), PathIndex(0), CountingTier::Events)
}

/// Scans only the phase steps within `half_chips` of where light of this delay
/// peaks in the continuous-time counter; all of them where those are more.
pub fn window(mut scene: Scene, delay_ps: f64, half_chips: u64) -> Scene {
    let samples = u64::from(scene.samples_per_chip);
    let steps = 2 * half_chips * samples + 1;
    let period = scene.scan.steps_per_period;
    if steps < period {
        let offset_ps =
            calibration_offset_ps(&Sensor::new(&scene), DetectorIndex(0), CountingTier::Events);
        let step_ps = scene.clock().sample_period_ps();
        let peak = ((delay_ps + offset_ps) / step_ps).round() as i64;
        let first = peak - (half_chips * samples) as i64;
        scene.scan.first_step = first.rem_euclid(period as i64) as u64;
        scene.scan.steps = steps;
    }
    scene
}

/// Calibrated time of flight, in chips, that each step of the scan stands for,
/// growing from step to step.
pub fn delays_chips(scene: &Scene) -> Vec<f64> {
    let offset_ps =
        calibration_offset_ps(&Sensor::new(scene), DetectorIndex(0), CountingTier::Events);
    let samples = f64::from(scene.samples_per_chip);
    let period = scene.scan.steps_per_period as f64;
    let first = scene.scan.first_step as f64;
    // A window that starts before zero starts near the end of the period.
    let turn = if scene.scan.is_full() || first < 0.5 * period { 0.0 } else { period };
    (0..scene.scan.steps)
        .map(|j| (first - turn + j as f64) / samples - scene.clock().chips(offset_ps))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photons::DetectorModel;
    use crate::response::MeanResponse;

    #[test]
    fn a_window_has_the_target_at_its_middle_and_wraps_round_zero() {
        let code = balanced_gold(0, 0).expect("a Gold code");
        for delay_ps in [0.0, TARGET_PS, 1e6] {
            let light = PathLight::new(&code, POWER_PW).at(delay_ps);
            let scene = window(sensor(&[light], 104.8e-6), delay_ps, 4);
            let delays = delays_chips(&scene);
            assert_eq!(delays.len(), 65);
            let middle_ps = delays[32] * CHIP_PERIOD_PS;
            assert!((middle_ps - delay_ps).abs() <= 500.0, "{middle_ps}");
        }
    }

    /// The signs of a whole period add up to 2 w - L, and so does the correlation
    /// over all lags, to that share of the detections.
    #[test]
    fn no_pedestal_is_under_the_correlations() {
        for number in 0..2 {
            let code = balanced_gold(number, 0).expect("a Gold code");
            let mut scene = sensor(&[PathLight::new(&code, POWER_PW)], 1e-3);
            scene.scan.integration_chips = 60 * code.len();
            let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
            let response = MeanResponse::new(&model).expect("a mean response");
            let counts = response.mean_counts();
            let signed: f64 = counts.iter().map(|count| count.signed).sum();
            let total: f64 = counts.iter().map(|count| count.total).sum();
            let pedestal = signed / total;
            assert!((pedestal - 1.0 / 2047.0).abs() < 1e-4, "{number}: {pedestal}");
        }
    }

    #[test]
    fn a_short_code_is_scanned_whole() {
        let code = square().expect("a square wave");
        let scene = window(sensor(&[PathLight::new(&code, 1.0)], 104.8e-6), TARGET_PS, 4);
        assert!(scene.scan.is_full());
        assert_eq!(scene.scan.integration_chips, 13_100);
    }
}
