//! Several paths and sensors in one scan: what share is found, bias and scatter in
//! Cramer-Rao bounds, confident wrong answers, and the time of a fit.

use std::sync::Arc;

use goldtof::code::{CodeSpec, Family};
use goldtof::estimate::fit::OtherLight;
use goldtof::scene::{Path as LightPath, Scene, Source, SourceIndex};

use crate::noiseless::gold;
use crate::told::{Told, scans};
use crate::{Outcome, cut_scan};

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
        let known = scene.sources.iter().position(|s| s.code.chips == code.chips);
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

/// Two paths, the first between two steps.
fn pair(scene: &Scene, apart: f64, ratio: f64, power_w: f64, chips: u64) -> Outcome<Scene> {
    let first = 80.0375;
    let lit = [(3, first, 1.0 / (1.0 + ratio)), (3, first + apart, ratio / (1.0 + ratio))];
    with_paths(scene, &lit, power_w, chips)
}

/// Two paths of one code, 0.4 to 3 chips apart.
pub fn pairs(scene: &Scene) -> Outcome {
    println!("two paths, 1.04 ms, whole scans, counts tier");
    for (rate, power_w) in [("5 Mcps", POWER_W), ("20 Mcps", 5.0 * POWER_W)] {
        for ratio in [1.0, 0.3] {
            for apart in [0.4, 0.6, 1.0, 1.5, 3.0] {
                let scene = pair(scene, apart, ratio, power_w, 130_000)?;
                let name = format!("{rate}, 1 : {ratio}, {apart} chips");
                Told::of(&scene, OtherLight::Given, scans())?.print(&name);
            }
        }
    }
    Ok(())
}

/// Two paths too close, or in too little light, to be told apart in 95 % of scans.
pub fn too_close(scene: &Scene) -> Outcome {
    println!("two paths where the light does not tell, whole scans, counts tier");
    for (name, chips, kinds) in [
        ("1.04 ms", 130_000, [(0.05, 1.0), (0.1, 1.0), (0.2, 1.0), (0.2, 0.3), (0.3, 0.1)]),
        ("104.8 us", 13_100, [(0.1, 1.0), (0.3, 1.0), (0.4, 1.0), (0.4, 0.3), (0.6, 0.3)]),
    ] {
        for (apart, ratio) in kinds {
            let scene = pair(scene, apart, ratio, POWER_W, chips)?;
            let name = format!("5 Mcps, {name}, 1 : {ratio}, {apart} chips");
            Told::of(&scene, OtherLight::Given, scans())?.print(&name);
        }
    }
    Ok(())
}

/// The own sensor under another one, codes known.
pub fn near_far(scene: &Scene) -> Outcome {
    println!("own sensor under another one of 22 pW, whole scans, counts tier");
    for (ratio, name, chips) in [
        (10.0, "104.8 us", 13_100),
        (30.0, "104.8 us", 13_100),
        (30.0, "1.04 ms", 130_000),
        (100.0, "1.04 ms", 130_000),
        (100.0, "10.4 ms", 1_300_000),
    ] {
        let lit = [(3, 80.0375, 1.0 / ratio), (9, 187.6375, 1.0)];
        let scene = with_paths(scene, &lit, 22e-12, chips)?;
        Told::of(&scene, OtherLight::Given, scans())?.print(&format!("1 : {ratio}, {name}"));
    }
    Ok(())
}

/// The own sensor under another one whose clock is not its own: 20 ppm are 2.6 chips in a
/// step. In 5 chips to either side of the own path.
pub fn clocks(scene: &Scene) -> Outcome {
    println!("own sensor under another one of 22 pW with another clock, 1.04 ms, in photons");
    for (ratio, ppm) in [
        (1.0, 20.0),
        (3.0, 20.0),
        (10.0, 20.0),
        (30.0, 20.0),
        (100.0, 20.0),
        (10.0, 2.3),
        (10.0, -2.3),
    ] {
        let lit = [(3, 80.0375, 1.0 / ratio), (9, 187.6375, 1.0)];
        let mut scene = with_paths(scene, &lit, 22e-12, 130_000)?;
        scene.sources[1].clock.offset = 1e-6 * ppm;
        cut_scan(&mut scene, 40);
        let told = Told::of_photons(&scene, OtherLight::Given, scans())?;
        told.print(&format!("1 : {ratio}, {ppm} ppm"));
    }
    Ok(())
}

/// The own light alone, others searched for, with codes of degree 5 to 11, 104.8 us.
pub fn alone(scene: &Scene) -> Outcome {
    println!("own light alone, others searched for, whole scans, counts tier");
    // Degree 8 has no Gold sets.
    for (degree, (rate, times)) in [5, 6, 7, 9, 10, 11].into_iter().flat_map(|degree| {
        [("5 Mcps", 1.0), ("1 Mcps", 0.2), ("20 Mcps", 5.0)].map(|light| (degree, light))
    }) {
        let spec = CodeSpec { degree: Some(degree), index: Some(3), ..CodeSpec::new(Family::Gold) };
        let mut scene = with_paths(scene, &[(3, 9.6625, 1.0)], times * POWER_W, 13_100)?;
        let code = spec.build()?;
        scene.scan.steps = code.len() * u64::from(scene.samples_per_chip);
        scene.scan.steps_per_period = scene.scan.steps;
        scene.sources[0].code = Arc::new(code);
        Told::of(&scene, OtherLight::Search, scans())?.print(&format!("degree {degree}, {rate}"));
    }
    Ok(())
}

/// None to three sensors with unknown codes.
pub fn unknown(scene: &Scene) -> Outcome {
    println!("unknown sensors of equal power, 2.5 pW each, 104.8 us, whole scans, counts tier");
    let all = [(3, 80.0375, 1.0), (300, 375.0875, 1.0), (1500, 1187.525, 1.0), (47, 1630.31, 1.0)];
    for sensors in 1..=4 {
        let scene = with_paths(scene, &all[..sensors], 2.5e-12, 13_100)?;
        let name = format!("{} others", sensors - 1);
        Told::of(&scene, OtherLight::Search, scans())?.print(&name);
    }
    Ok(())
}
