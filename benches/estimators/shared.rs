//! Several paths where steps that are counted at once see the same light.

use goldtof::estimate::fit::OtherLight;
use goldtof::scene::{Path as LightPath, Scene, SourceIndex};

use crate::random::with_short_codes;
use crate::told::{Told, scans};
use crate::{Outcome, set_detection_rate};

/// Source, delay in chips and strength of each path.
const LIT: [(usize, f64, f64); 3] = [(0, 40.3, 0.6), (0, 42.1, 0.4), (1, 90.7, 0.6)];

/// Three paths, with 1, 4, 8 and 16 steps at once.
pub fn shared(scene: &Scene) -> Outcome {
    println!("three paths, codes of 127 chips, 16 Mcps, 160 us, whole scans, counts tier");
    for parallel in [1, 4, 8, 16] {
        let mut scene = with_short_codes(scene)?;
        let path = scene.paths[0].clone();
        scene.paths = LIT
            .iter()
            .map(|&(source, chips, share)| LightPath {
                source: SourceIndex(source),
                delay_ps: chips * scene.chip_period_ps,
                transmission: share,
                ..path.clone()
            })
            .collect();
        scene.hardware.parallel = parallel;
        scene.scan.integration_chips = 20_000;
        set_detection_rate(&mut scene, 12e6)?;
        let name = format!("{parallel} at once");
        Told::of(&scene, OtherLight::Given, scans())?.print(&name);
    }
    Ok(())
}
