//! Several paths and sensors in one scan: what share is found, bias and scatter in
//! Cramer-Rao bounds, and the time of a fit.

use std::time::Instant;

use goldtof::estimate::bound::bound;
use goldtof::estimate::fit::{Fitter, OtherLight};
use goldtof::estimate::{delay_error_ps, distance_m};
use goldtof::photons::DetectorModel;
use goldtof::response::{CountSampler, MeanResponse, SecondMoments};
use goldtof::scene::{DetectorIndex, Path as LightPath, PathIndex, Scene, Source, SourceIndex};
use goldtof::sensor::Sensor;

use crate::noiseless::gold;
use crate::{Outcome, TIER};

/// Mean power of the article's laser that gives about 5.4 million detections per
/// second, through paths that let all of it pass.
const POWER_W: f64 = 4.1e-12;

/// A path of a scene: index of its code, delay in chips, share of the light.
type Lit = (i64, f64, f64);

fn with_paths(scene: &Scene, lit: &[Lit], power_w: f64, chips: u64) -> Outcome<Scene> {
    let mut scene = scene.clone();
    let (source, path) = (scene.sources[0].clone(), scene.paths[0].clone());
    scene.sources.clear();
    scene.paths.clear();
    for &(index, delay_chips, share) in lit {
        let code = gold(index)?;
        let known = scene
            .sources
            .iter()
            .position(|s| s.code.chips == code.chips);
        let number = known.unwrap_or(scene.sources.len());
        if known.is_none() {
            scene.sources.push(Source {
                name: format!("code-{index}"),
                code,
                mean_power_w: power_w,
                ..source.clone()
            });
        }
        scene.paths.push(LightPath {
            source: SourceIndex(number),
            delay_ps: delay_chips * scene.chip_period_ps,
            transmission: share,
            ..path.clone()
        });
    }
    scene.scan.integration_chips = chips;
    Ok(scene)
}

fn line(name: &str, scene: &Scene, other: OtherLight, scans: u64) -> Outcome {
    let sensor = Sensor::new(scene);
    let model = DetectorModel::new(&sensor, DetectorIndex(0));
    let response = MeanResponse::of_tier(&model, TIER)?;
    let second = SecondMoments::new(&response)?;
    let sampler = CountSampler::of(&model, &second);
    let bound = bound(&sensor, DetectorIndex(0), TIER)?;
    let fitter = Fitter::new(&sensor, DetectorIndex(0), TIER, other);
    let period_ps = sensor.timing().code_period_ps();
    let mut errors = vec![Vec::new(); scene.paths.len()];
    let (mut refused, mut untold, mut more) = (0, 0, 0);
    let start = Instant::now();
    for scan in 0..scans {
        let Ok(fitted) = fitter.fit(&sampler.scan(7, scan)) else {
            refused += 1;
            continue;
        };
        untold += u32::from(fitted.untold.is_some());
        more += u32::from(fitted.paths.len() > scene.paths.len());
        let mut found = fitted.paths;
        found.sort_by(|a, b| a.delay_ps.total_cmp(&b.delay_ps));
        for (path, errors) in scene.paths.iter().zip(&mut errors) {
            let code = &scene.sources[path.source].code.chips;
            let error_ps = |delay_ps: f64| delay_error_ps(delay_ps, path.delay_ps, period_ps);
            let place = found.iter().position(|f| {
                &f.code.chips == code && error_ps(f.delay_ps).abs() < scene.chip_period_ps
            });
            if let Some(place) = place {
                errors.push(distance_m(error_ps(found.remove(place).delay_ps)));
            }
        }
    }
    let ms = start.elapsed().as_secs_f64() * 1e3 / scans as f64;
    println!(
        "  {name}: {scans} scans, {refused} refused, {untold} untold, {more} with more; {ms:.0} ms"
    );
    for (number, errors) in errors.iter().enumerate() {
        let bound_m = bound.of_path(PathIndex(number)).unwrap_or(f64::NAN);
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        let squares = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>();
        let ratio = (squares / (n - 1.0)).sqrt() / bound_m;
        println!(
            "    path {number}: found in {n}, bias {:.2} +- {:.2} bounds, std / bound {ratio:.3} +- {:.3}, bound {:.2} mm",
            mean / bound_m,
            ratio / n.sqrt(),
            ratio / (2.0 * n).sqrt(),
            bound_m * 1e3,
        );
    }
    Ok(())
}

/// Two paths of one code, 0.4 to 3 chips apart.
pub fn pairs(scene: &Scene) -> Outcome {
    println!("two paths, 1.04 ms, counts tier");
    for (rate, power_w) in [("5 Mcps", POWER_W), ("20 Mcps", 5.0 * POWER_W)] {
        for ratio in [1.0, 0.3] {
            for apart in [0.4, 0.6, 1.0, 1.5, 3.0] {
                let lit = [(3, 80.0375, 0.5), (3, 80.0375 + apart, 0.5 * ratio)];
                let scene = with_paths(scene, &lit, power_w, 130_000)?;
                let name = format!("{rate}, 1 : {ratio}, {apart} chips");
                line(&name, &scene, OtherLight::Given, 40)?;
            }
        }
    }
    Ok(())
}

/// The own sensor under another one, codes known.
pub fn near_far(scene: &Scene) -> Outcome {
    println!("own sensor under another one, counts tier");
    for (ratio, name, chips) in [
        (10.0, "104.8 us", 13_100),
        (30.0, "1.04 ms", 130_000),
        (100.0, "10.4 ms", 1_300_000),
    ] {
        let lit = [(3, 80.0375, 1.0 / ratio), (9, 187.6375, 1.0)];
        let scene = with_paths(scene, &lit, 22e-12, chips)?;
        line(
            &format!("1 : {ratio}, {name}"),
            &scene,
            OtherLight::Given,
            40,
        )?;
    }
    Ok(())
}

/// One to three sensors with unknown codes.
pub fn unknown(scene: &Scene) -> Outcome {
    println!("unknown sensors of equal power, 2.5 pW each, 104.8 us, counts tier");
    let all = [
        (3, 80.0375, 1.0),
        (300, 375.0875, 1.0),
        (1500, 1187.525, 1.0),
        (47, 1630.31, 1.0),
    ];
    for sensors in 1..=4 {
        let scene = with_paths(scene, &all[..sensors], 2.5e-12, 13_100)?;
        line(
            &format!("{} others", sensors - 1),
            &scene,
            OtherLight::Search,
            40,
        )?;
    }
    Ok(())
}
