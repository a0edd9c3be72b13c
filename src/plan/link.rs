//! Photons from each source to each detector, and what else makes it fire.

use serde::Serialize;

use crate::light::photon_rate_hz;
use crate::scene::{PathIndex, Scene};
use crate::sensor::Sensor;

/// Where a path's photons stay. Rates are averages over the code.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct LinkBudget {
    /// The source's name.
    pub source: String,
    /// The detector's name.
    pub detector: String,
    /// Distance of the target, at the start of a scan.
    pub distance_m: f64,
    /// Photons that leave the source.
    pub emitted_hz: f64,
    /// Photons of the path that reach the detector.
    pub returned_hz: f64,
    /// Those that fire a detector which is always ready.
    pub primary_hz: f64,
    /// Photons of the detector's background that do.
    pub background_hz: f64,
    /// Avalanches without light.
    pub dark_counts_hz: f64,
    /// The path's primary rate over that of background and dark counts; none without these.
    pub signal_to_background: Option<f64>,
}

impl LinkBudget {
    /// That of one path.
    pub fn of(scene: &Scene, path: PathIndex) -> LinkBudget {
        let path = &scene.paths[path];
        let (source, spad) = (&scene.sources[path.source], &scene.detectors[path.detector]);
        let emitted_hz = photon_rate_hz(source.mean_power_w, source.wavelength_nm);
        let returned_hz = emitted_hz * path.transmission;
        let primary_hz = returned_hz * spad.photon_detection_probability;
        let background_hz = spad.background_rate_cps * spad.photon_detection_probability;
        let unwanted_hz = background_hz + spad.dark_count_rate_cps;
        LinkBudget {
            source: source.name.clone(),
            detector: spad.name.clone(),
            distance_m: path.distance_m(),
            emitted_hz,
            returned_hz,
            primary_hz,
            background_hz,
            dark_counts_hz: spad.dark_count_rate_cps,
            signal_to_background: (unwanted_hz > 0.0).then(|| primary_hz / unwanted_hz),
        }
    }
}

/// Path by path, but for those whose source is dark.
pub fn link_budget(sensor: &Sensor) -> Vec<LinkBudget> {
    let scene = sensor.scene();
    let emits = |index: &PathIndex| scene.sources[scene.paths[*index].source].emits();
    let paths = PathIndex::of(&scene.paths).filter(emits);
    paths.map(|path| LinkBudget::of(scene, path)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sensor of the article's Table I, whose numbers are in the scene: 4 pW of
    /// 783 nm, detected with 31 %, 71 kcps of dark counts.
    #[test]
    fn photons_of_the_articles_sensor_are_these() {
        let file =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper-single.toml");
        let mut scene = crate::scene::load(&file).expect("it is sound");
        let of = |scene: &crate::scene::Scene| link_budget(&Sensor::new(scene)).remove(0);
        let budget = of(&scene);
        // A photon of 783 nm has 2.53696e-19 J.
        assert!((budget.emitted_hz / 15.7669e6 - 1.0).abs() < 1e-4);
        assert_eq!(budget.returned_hz, budget.emitted_hz);
        assert!((budget.primary_hz / 4.88773e6 - 1.0).abs() < 1e-4);
        let ratio = budget.signal_to_background.expect("there are dark counts");
        assert!((ratio / (4.88773e6 / 71e3) - 1.0).abs() < 1e-4);
        scene.paths[0].transmission = 0.25;
        scene.detectors[0].background_rate_cps = 1e6;
        let budget = of(&scene);
        assert!((budget.primary_hz / 1.22193e6 - 1.0).abs() < 1e-4);
        assert!((budget.background_hz / 0.31e6 - 1.0).abs() < 1e-9);
        let ratio = budget.signal_to_background.expect("there is background");
        assert!((ratio / (1.22193 / 0.381) - 1.0).abs() < 1e-4);
        scene.sources[0].mean_power_w = 0.0;
        assert!(link_budget(&Sensor::new(&scene)).is_empty());
    }
}
