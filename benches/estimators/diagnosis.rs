//! What `goldtof estimate` says of sensors with another code than the scene's, and of sensors
//! that are as their scene says.

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use goldtof::code::{Code, CodeSpec, Family};
use goldtof::recorded::{Cause, Diagnosis, RecordedScan, assess};
use goldtof::scene::{self, DetectorIndex, Scene, SourceIndex};
use goldtof::sensor::Sensor;
use goldtof::simulate::Tier;
use goldtof::simulate::scans::scans as simulated;
use rayon::prelude::*;

use crate::Outcome;
use crate::told::scans;

/// Index of the scene's own code in its set.
const OWN: i64 = 3;

/// Where another code is than the scene says.
#[derive(Debug, Clone, Copy, PartialEq)]
enum OtherCode {
    Both,
    Light,
    Reference,
}

impl OtherCode {
    /// As the diagnosis has it.
    fn words(self) -> &'static str {
        match self {
            OtherCode::Both => "light and reference carry",
            OtherCode::Light => "the light alone carries",
            OtherCode::Reference => "the reference alone has",
        }
    }
}

fn gold(degree: u32, index: i64) -> Outcome<Arc<Code>> {
    let spec = CodeSpec { degree: Some(degree), index: Some(index), ..CodeSpec::new(Family::Gold) };
    Ok(Arc::new(spec.build()?))
}

/// `scenes/quick.toml` with a code of a degree, and as many code periods a step.
fn quick(degree: u32) -> Outcome<Sensor> {
    let periods = 2500 / 31;
    let settings = [
        format!("source.code={{ family = \"gold\", degree = {degree}, index = {OWN} }}"),
        format!("scan.integration={} ns", 8 * periods * ((1 << degree) - 1)),
    ];
    let settings: Result<Vec<_>, _> = settings.iter().map(|setting| setting.parse()).collect();
    Ok(Sensor::new(&scene::load_with(Path::new("scenes/quick.toml"), &settings?)?))
}

/// A sensor as `written`, but for another code.
fn with_code(written: &Sensor, code: &Arc<Code>, place: OtherCode) -> Sensor {
    written.with(|scene| {
        let own = Arc::clone(&scene.sources[0].code);
        let mut light = scene.sources[0].clone();
        light.code = Arc::clone(if place == OtherCode::Reference { &own } else { code });
        scene.sources[0].code = if place == OtherCode::Light { own } else { Arc::clone(code) };
        scene.sources.push(light);
        scene.paths[0].source = SourceIndex(1);
    })
}

/// What is said of one scan of the sensor `built` by somebody who has the scene `written`.
fn diagnosis(built: &Sensor, written: &Sensor, seed: u64, has_totals: bool) -> Outcome<Diagnosis> {
    let mut found = None;
    simulated(built, DetectorIndex(0), Tier::Sampled, seed, 1, |counts| {
        let counts = counts.to_vec();
        let scan = RecordedScan { detector: DetectorIndex(0), counts, has_totals };
        found = assess(written, &scan).diagnosis;
    })?;
    Ok(found.ok_or("there are no residuals")?)
}

/// Every other code of the Gold set, both m-sequences included, one scan each.
pub fn wrong_code(_: &Scene) -> Outcome {
    println!("another code of the Gold set than the scene's, scenes/quick.toml, sampled photons");
    for degree in [5, 6, 7] {
        let written = quick(degree)?;
        for (place, has_totals) in [
            (OtherCode::Both, true),
            (OtherCode::Both, false),
            (OtherCode::Light, true),
            (OtherCode::Light, false),
            (OtherCode::Reference, true),
            (OtherCode::Reference, false),
        ] {
            wrong_codes(&written, degree, place, has_totals)?;
        }
    }
    Ok(())
}

fn wrong_codes(written: &Sensor, degree: u32, place: OtherCode, has_totals: bool) -> Outcome {
    let length = (1_i64 << degree) - 1;
    let others: Vec<i64> = (-2..length).filter(|&index| index != OWN).collect();
    let started = Instant::now();
    let told: Vec<(i64, Diagnosis)> = others
        .par_iter()
        .map(|&index| {
            let code = gold(degree, index).map_err(|error| error.to_string())?;
            let built = with_code(written, &code, place);
            let told = diagnosis(&built, written, 11, has_totals).map_err(|e| e.to_string())?;
            Ok((index, told))
        })
        .collect::<Result<_, String>>()?;
    let name = |index: i64| match index {
        0.. => format!("the code whose index is {} higher", (index - OWN).rem_euclid(length)),
        _ => format!("the code of index {index}"),
    };
    let is_named = |(index, told): &&(i64, Diagnosis)| {
        told.causes.contains(&Cause::Code)
            && told.sentence.contains(&format!("{} {}", place.words(), name(*index)))
    };
    let named = told.iter().filter(is_named).count();
    let alone = told.iter().filter(is_named).filter(|(_, told)| told.causes.len() == 1).count();
    println!(
        "  degree {degree}, {place:?}, {} totals: named {named} of {}, no other cause with it {alone}; \
         {:.1} s",
        if has_totals { "with" } else { "without" },
        told.len(),
        started.elapsed().as_secs_f64(),
    );
    for (index, told) in told.iter().filter(|told| !is_named(told)) {
        println!("    {index}: {:?}: {}", told.causes, told.sentence);
    }
    Ok(())
}

/// Sensors that are as their scene says: what share is accused.
pub fn right_scenes(_: &Scene) -> Outcome {
    println!("sensors that are as their scene says, sampled photons, GOLDTOF_SCANS scans each");
    let model = ["estimate.estimator=model".parse()?];
    let near_far = scene::load_with(Path::new("tests/scenes/near-far.toml"), &model)?;
    let near_far = Sensor::new(&near_far);
    for (name, sensor) in [("another source ten times as bright", near_far), ("quick", quick(5)?)] {
        let started = Instant::now();
        let told: Vec<Diagnosis> = (0..scans())
            .into_par_iter()
            .map(|seed| diagnosis(&sensor, &sensor, seed, true).map_err(|e| e.to_string()))
            .collect::<Result<_, String>>()?;
        let accused: Vec<&Diagnosis> = told.iter().filter(|told| !told.causes.is_empty()).collect();
        let seconds = started.elapsed().as_secs_f64();
        println!("  {name}: {} of {} scans accused; {seconds:.1} s", accused.len(), told.len());
        for told in accused {
            println!("    {:?}: {}", told.causes, told.sentence);
        }
    }
    Ok(())
}
