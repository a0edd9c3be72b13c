//! Biases without noise: expected counts of a detector stepped through time, which
//! shares nothing with the fit, go through the fit.

use std::sync::Arc;

use goldtof::code::{Code, CodeSpec, Family};
use goldtof::estimate::fit::{OtherLight, fit_means};
use goldtof::photons::StepCount;
use goldtof::response::MeanCount;
use goldtof::scene::{DetectorIndex, Path as LightPath, Scene, Source, SourceIndex};
use goldtof::sensor::Sensor;

use crate::{Outcome, TIER, cut_scan, error_mm, phase_error_mm, set_detection_rate};
use optics_support::stepped::Stepped;

/// Length of a time step: biases change by less than a micrometre with half of it.
const STEP_PS: f64 = 25.0;
/// So many code periods that rounding mean counts moves no phase estimate.
const PERIODS: u64 = 100_000;

/// Code `index` of the article's Gold set.
pub fn gold(index: i64) -> Outcome<Arc<Code>> {
    let mut spec = CodeSpec::new(Family::Gold);
    spec.degree = Some(11);
    spec.index = Some(index);
    Ok(Arc::new(spec.build()?))
}

/// Adds a second source of equal power whose light comes `chips` after the first.
pub fn add_interferer(scene: &mut Scene, code: &Arc<Code>, chips: f64) {
    scene.sources.push(Source {
        name: "other".to_owned(),
        code: Arc::clone(code),
        ..scene.sources[0].clone()
    });
    let delay_ps = scene.paths[0].delay_ps + chips * scene.chip_period_ps;
    let period_ps = code.len() as f64 * scene.chip_period_ps;
    scene.paths.push(LightPath {
        source: SourceIndex(1),
        delay_ps: delay_ps.rem_euclid(period_ps),
        ..scene.paths[0].clone()
    });
}

fn phase_mm(scene: &Scene, counts: &[MeanCount]) -> Outcome<f64> {
    let rounded: Vec<StepCount> = counts
        .iter()
        .map(|count| StepCount {
            signed: count.signed.round() as i64,
            total: count.total.round() as u64,
        })
        .collect();
    phase_error_mm(scene, &rounded)
}

fn whole_periods(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.scan.integration_chips = PERIODS * scene.sources[0].code.len();
    scene.paths[0].delay_ps = 21_350.0;
    scene
}

pub fn walk(scene: &Scene) -> Outcome {
    println!("walk without noise at 3.2 m, stepped detector: bias in mm");
    println!("  detected Mcps |     phase     model");
    for rate in [1e6, 2e6, 5e6, 10e6, 20e6, 30e6, 40e6, 45e6] {
        let mut scene = whole_periods(scene);
        set_detection_rate(&mut scene, rate)?;
        cut_scan(&mut scene, 14);
        let stepped = Stepped::new(&scene, STEP_PS);
        let counts = stepped.counts();
        let fitted =
            fit_means(&Sensor::new(&scene), DetectorIndex(0), TIER, &counts, OtherLight::None)?;
        println!(
            "  {:13.3} | {:9.3} {:9.5}  ({} iterations, chi-square {:.1})",
            stepped.detection_rate_hz() / 1e6,
            phase_mm(&scene, &counts)?,
            error_mm(&scene, fitted.delay_ps),
            fitted.iterations,
            fitted.chi_square,
        );
    }
    Ok(())
}

pub fn circular(scene: &Scene) -> Outcome {
    println!("sub-step delays without noise at 10 Mcps, stepped detector: bias in mm");
    println!("  delay beyond a step |     phase     model");
    let mut scene = whole_periods(scene);
    set_detection_rate(&mut scene, 10e6)?;
    for twentieth in 0..20 {
        scene.paths[0].delay_ps = 21_000.0 + 50.0 * f64::from(twentieth);
        let mut scene = scene.clone();
        cut_scan(&mut scene, 14);
        let counts = Stepped::new(&scene, STEP_PS).counts();
        let fitted =
            fit_means(&Sensor::new(&scene), DetectorIndex(0), TIER, &counts, OtherLight::None)?;
        println!(
            "  {:16} ps | {:9.3} {:9.5}",
            50 * twentieth,
            phase_mm(&scene, &counts)?,
            error_mm(&scene, fitted.delay_ps),
        );
    }
    Ok(())
}

pub fn interference(scene: &Scene) -> Outcome {
    println!("equal-power interferer without noise, 10 Mcps in all, stepped detector: bias in mm");
    println!("  relative delay (chips) |     phase     given     found   right code");
    let code = gold(417)?;
    let near = (0..=32).map(|quarter| f64::from(quarter) / 4.0 - 4.0);
    let far = (0..20).map(|number| 0.3125 + 101.55 * f64::from(number));
    for chips in near.chain(far) {
        let chips = (chips * 320.0_f64).round() / 320.0;
        let mut scene = whole_periods(scene);
        // An ordinary scan: 1.04 ms are 64 code periods.
        scene.scan.integration_chips = 64 * 2047;
        add_interferer(&mut scene, &code, chips);
        set_detection_rate(&mut scene, 10e6)?;
        let counts = Stepped::new(&scene, STEP_PS).counts();
        let given =
            fit_means(&Sensor::new(&scene), DetectorIndex(0), TIER, &counts, OtherLight::Given)?;
        let found =
            fit_means(&Sensor::new(&scene), DetectorIndex(0), TIER, &counts, OtherLight::Search)?;
        let right = found.paths.get(1).is_some_and(|path| path.code.chips == code.chips);
        println!(
            "  {chips:22.4} | {:9.3} {:9.5} {:9.5}   {right}",
            phase_mm(&scene, &counts)?,
            error_mm(&scene, given.delay_ps),
            error_mm(&scene, found.delay_ps),
        );
    }
    Ok(())
}
