//! Random scenes with one to four paths: whether the fit scatters as it says, or says
//! that it does not know.

use std::sync::Arc;

use goldtof::code::{CodeSpec, Family};
use goldtof::estimate::fit::OtherLight;
use goldtof::scene::{Path as LightPath, Scene, Source, SourceIndex};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::told::{Told, scans};
use crate::{Outcome, set_detection_rate};

const SCENES: u64 = 200;
/// Codes of 127 chips: the own one, and two others.
const DEGREE: u32 = 7;
const CODES: [i64; 3] = [3, 9, 60];
/// Scatter may be off by so much, and by so many standard errors.
const SHARE: f64 = 0.1;
const STANDARD_ERRORS: f64 = 4.0;

/// Scenes whose scatter is not as the fit says and that raise no warning.
pub fn random(scene: &Scene) -> Outcome {
    println!("{SCENES} random scenes, 1 to 4 paths, codes of 127 chips, whole scans, counts tier");
    let (mut off, mut warned, mut paths) = (0, 0, 0);
    for number in 0..SCENES {
        let scene = random_scene(scene, number)?;
        let told = Told::of(&scene, OtherLight::Given, scans())?;
        // A path that half of the scans miss is said to be missing.
        let is_missed = told.paths.iter().any(|path| 2 * path.found() < scans());
        let is_warned = is_missed && told.untold > 0 || 2 * told.untold > scans();
        let ratios = told.paths.iter().map(|path| path.scatter_over_own());
        let is_off =
            |[ratio, error]: [f64; 2]| (ratio - 1.0).abs() > SHARE + STANDARD_ERRORS * error;
        let is_off = is_missed && told.untold == 0 || ratios.into_iter().any(is_off);
        paths += told.paths.len();
        warned += u64::from(is_warned);
        off += u64::from(is_off && !is_warned);
        if is_off {
            let kind = if is_warned { "warned" } else { "OFF" };
            let light: Vec<String> = scene
                .paths
                .iter()
                .map(|p| {
                    let chips = p.delay_ps / scene.chip_period_ps;
                    let share = p.transmission;
                    format!("{}: {chips:.2} chips, {share:.2}", scene.sources[p.source].name)
                })
                .collect();
            told.print(&format!(
                "{kind}: scene {number}, {} chips a step, {}",
                scene.scan.integration_chips,
                light.join("; ")
            ));
        }
    }
    println!(
        "  {SCENES} scenes with {paths} paths, {} scans each: {off} off without a warning, {warned} \
         warned",
        scans()
    );
    Ok(())
}

/// Paths anywhere, every other of them within three chips of the one before it.
fn random_scene(scene: &Scene, number: u64) -> Outcome<Scene> {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(number);
    let mut scene = with_short_codes(scene)?;
    let path = scene.paths.remove(0);
    let length = scene.sources[0].code.len() as f64;
    let mut before = 0.0;
    for place in 0..random.random_range(1..=4) {
        let source = match place {
            0 => 0,
            _ if random.random_bool(0.6) => 0,
            _ => random.random_range(1..CODES.len()),
        };
        let delay_chips: f64 = match place > 0 && random.random_bool(0.5) {
            true => before + random.random_range(0.3..3.0),
            false => random.random_range(0.0..length),
        };
        before = delay_chips;
        scene.paths.push(LightPath {
            source: SourceIndex(source),
            delay_ps: delay_chips.rem_euclid(length) * scene.chip_period_ps,
            transmission: 10_f64.powf(random.random_range(-1.0..0.0)),
            ..path.clone()
        });
    }
    let log_chips: f64 = random.random_range(4.3..5.3);
    scene.scan.integration_chips = 10_f64.powf(log_chips) as u64;
    set_detection_rate(&mut scene, random.random_range(3e6..20e6))?;
    Ok(scene)
}

/// Sources with the short codes, and a scan of all their steps.
pub fn with_short_codes(scene: &Scene) -> Outcome<Scene> {
    let mut scene = scene.clone();
    let source = scene.sources.remove(0);
    scene.sources.clear();
    for index in CODES {
        let mut spec = CodeSpec::new(Family::Gold);
        spec.degree = Some(DEGREE);
        spec.index = Some(index);
        scene.sources.push(Source {
            name: format!("code-{index}"),
            code: Arc::new(spec.build()?),
            ..source.clone()
        });
    }
    let steps = u64::from(scene.samples_per_chip) * scene.sources[0].code.len();
    scene.scan.first_step = 0;
    (scene.scan.steps, scene.scan.steps_per_period) = (steps, steps);
    Ok(scene)
}
