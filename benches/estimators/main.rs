//! Errors of the model estimator beside the phase's, for the article's sensor:
//! without noise on the expected counts of a detector of another construction,
//! with noise on drawn counts; what wrong parameters cost; what a fit costs.
//!
//!     cargo bench --bench estimators -- [noiseless-walk] [noiseless-circular] \
//!         [noiseless-interference] [walk] [interference] [wrong] [timing] \
//!         [pairs] [too-close] [near-far] [clocks] [alone] [unknown] [random] [shared] [histogram] \
//!         [wrong-code] [right-scenes]
//!
//! GOLDTOF_SCANS says how many scans each line of pairs to shared and right-scenes has (default 40).

mod apart;
mod diagnosis;
mod histogram;
mod noise;
mod noiseless;
mod random;
mod shared;
mod timing;
mod told;
mod wrong;

use std::error::Error;
use std::path::Path;

use goldtof::estimate::{
    CountingTier, calibration_offset_ps, delay_error_ps, distance_m, estimate,
};
use goldtof::photons::{DetectorModel, StepCount};
use goldtof::response::MeanResponse;
use goldtof::scene::{self, DetectorIndex, Scene};
use goldtof::sensor::Sensor;

type Outcome<T = ()> = Result<T, Box<dyn Error>>;

const TIER: CountingTier = CountingTier::Events;

fn main() -> Outcome {
    let parts: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    type Part = (&'static str, fn(&Scene) -> Outcome);
    let known: [Part; 18] = [
        ("noiseless-walk", noiseless::walk),
        ("noiseless-circular", noiseless::circular),
        ("noiseless-interference", noiseless::interference),
        ("walk", noise::walk),
        ("interference", noise::interference),
        ("wrong", wrong::wrong),
        ("timing", timing::timing),
        ("pairs", apart::pairs),
        ("too-close", apart::too_close),
        ("near-far", apart::near_far),
        ("clocks", apart::clocks),
        ("alone", apart::alone),
        ("unknown", apart::unknown),
        ("random", random::random),
        ("shared", shared::shared),
        ("histogram", histogram::histogram),
        ("wrong-code", diagnosis::wrong_code),
        ("right-scenes", diagnosis::right_scenes),
    ];
    let scene = scene::load(Path::new("scenes/paper-single.toml"))?;
    for (name, part) in known {
        if parts.is_empty() || parts.iter().any(|asked| asked == name) {
            part(&scene)?;
        }
    }
    Ok(())
}

/// Sets the laser's power for a mean detection rate.
fn set_detection_rate(scene: &mut Scene, rate_cps: f64) -> Outcome {
    for _ in 0..30 {
        let model = DetectorModel::new(&Sensor::new(scene), DetectorIndex(0));
        let found = MeanResponse::of_tier(&model, TIER)?.detection_rate_hz();
        let dead = scene.detectors[0].dead_time_ps * 1e-12;
        // The rates before the dead time, roughly, as a ratio.
        let open = |rate: f64| rate / (1.0 - rate * dead);
        for source in &mut scene.sources {
            source.mean_power_w *= open(rate_cps) / open(found);
        }
    }
    Ok(())
}

/// The steps round the first path.
fn cut_scan(scene: &mut Scene, halfwidth: u64) {
    let step_ps = scene.chip_period_ps / f64::from(scene.samples_per_chip);
    let peak = (scene.paths[0].delay_ps
        + calibration_offset_ps(&Sensor::new(scene), DetectorIndex(0), TIER))
        / step_ps;
    let all = scene.scan.steps_per_period;
    scene.scan.first_step = (peak.round() as u64 + all - halfwidth) % all;
    scene.scan.steps = 2 * halfwidth;
}

fn error_mm(scene: &Scene, delay_ps: f64) -> f64 {
    let period_ps = scene.scan.steps_per_period as f64 * scene.chip_period_ps
        / f64::from(scene.samples_per_chip);
    1e3 * distance_m(delay_error_ps(delay_ps, scene.paths[0].delay_ps, period_ps))
}

fn phase_error_mm(scene: &Scene, counts: &[StepCount]) -> Outcome<f64> {
    let signed: Vec<i64> = counts.iter().map(|count| count.signed).collect();
    let offset_ps = calibration_offset_ps(&Sensor::new(scene), DetectorIndex(0), TIER);
    let found = estimate(&scene.timing(), &signed, offset_ps)?;
    Ok(error_mm(scene, found.delay_ps))
}
