//! A search for sensors that are not there finds none, with short codes, too, whose
//! correlations with each other are large.

use std::sync::Arc;

use crate::optics_support::table_i_scene;
use goldtof::code::{Code, CodeSpec, Family};
use goldtof::estimate::CountingTier;
use goldtof::estimate::fit::{Fitter, OtherLight};
use goldtof::photons::DetectorModel;
use goldtof::response::{CountSampler, MeanResponse, SecondMoments};
use goldtof::scene::{DetectorIndex, Scene};
use goldtof::sensor::Sensor;

fn gold(degree: u32, index: i64) -> Arc<Code> {
    let spec = CodeSpec { degree: Some(degree), index: Some(index), ..CodeSpec::new(Family::Gold) };
    Arc::new(spec.build().expect("a code of the set"))
}

/// The sensor of Table I, alone.
fn alone(degree: u32, rate: f64, periods: f64) -> Scene {
    let code = gold(degree, 3);
    let chips = (code.len() as f64 * periods) as u64;
    let mut scene = table_i_scene(code, rate, chips);
    scene.paths[0].delay_ps = 77_300.0;
    scene
}

/// Scans in which other light is found, and in which there is no distance.
fn finds(scene: &Scene, scans: u64) -> [u64; 2] {
    let sensor = Sensor::new(scene);
    let model = DetectorModel::new(&sensor, DetectorIndex(0));
    let tier = CountingTier::Events;
    let response = MeanResponse::of_tier(&model, tier).expect("a response");
    let second = SecondMoments::new(&response).expect("second moments");
    let sampler = CountSampler::of(&model, &second).expect("a sampler");
    let fitter = Fitter::new(&sensor, DetectorIndex(0), tier, OtherLight::Search);
    let mut found = [0, 0];
    for scan in 0..scans {
        match fitter.fit(&sampler.scan(5, scan)) {
            Ok(fit) if fit.paths.len() > 1 => {
                found[0] += 1;
                if std::env::var("SHOW").is_ok() {
                    for p in &fit.paths {
                        eprintln!(
                            "  {scan}: {:?} {:.1} +- {:.1} rate {:.4} sig {:.2}",
                            p.code.chips == scene.sources[0].code.chips,
                            p.delay_ps,
                            p.delay_std_ps,
                            p.rate_hz / 1e6,
                            p.significance()
                        );
                    }
                    eprintln!("   chi {} of {}", fit.chi_square, fit.degrees_of_freedom);
                }
            }
            Ok(_) => {}
            Err(e) => {
                found[1] += 1;
                if std::env::var("SHOW").is_ok() {
                    eprintln!("{e}");
                }
            }
        }
    }
    found
}

#[test]
fn no_light_is_found_that_is_not_there() {
    let scans: u64 = std::env::var("SCANS").map_or(40, |s| s.parse().unwrap());
    let degrees: Vec<u32> = std::env::var("DEGREES")
        .map_or(vec![5, 6], |s| s.split(',').map(|d| d.parse().unwrap()).collect());
    for degree in degrees {
        for (rate, periods) in [
            (5e6, 422.6 * 31.0 / f64::from((1 << degree) - 1)),
            (1e6, 100.3 * 31.0 / f64::from((1 << degree) - 1)),
            (20e6, 1000.0 * 31.0 / f64::from((1 << degree) - 1)),
        ] {
            let scene = alone(degree, rate, periods);
            let t = std::time::Instant::now();
            eprintln!(
                "degree {degree}, {rate:.0e}, {periods:.1}: {:?} of {scans} {:?}",
                finds(&scene, scans),
                t.elapsed()
            );
        }
    }
}
