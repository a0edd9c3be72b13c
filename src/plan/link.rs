//! Photons from each source to each detector, and what else makes it fire.

use crate::photons::photon_rate_hz;
use crate::scene::PathIndex;
use crate::sensor::Sensor;

/// Where a path's photons stay. Rates are per second, averaged over the code.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkBudget {
    /// The source's name.
    pub source: String,
    /// The detector's name.
    pub detector: String,
    /// Distance of the target.
    pub distance_m: f64,
    /// Photons that leave the source.
    pub emitted_hz: f64,
    /// Photons that reach the detector.
    pub returned_hz: f64,
    /// Those that fire a ready detector.
    pub detected_hz: f64,
    /// Ambient photons that do.
    pub ambient_hz: f64,
    /// Avalanches without light.
    pub dark_hz: f64,
}

impl LinkBudget {
    /// Photons of the path for each count of background.
    pub fn signal_to_background(&self) -> f64 {
        self.detected_hz / (self.ambient_hz + self.dark_hz)
    }
}

/// Path by path.
pub fn link_budget(sensor: &Sensor) -> Vec<LinkBudget> {
    let scene = sensor.scene();
    let of_path = |index: PathIndex| {
        let path = &scene.paths[index];
        let (source, spad) = (&scene.sources[path.source], &scene.detectors[path.detector]);
        let emitted_hz = photon_rate_hz(source.mean_power_w, source.wavelength_nm);
        let returned_hz = emitted_hz * path.transmission;
        LinkBudget {
            source: source.name.clone(),
            detector: spad.name.clone(),
            distance_m: path.distance_m(),
            emitted_hz,
            returned_hz,
            detected_hz: returned_hz * spad.photon_detection_probability,
            ambient_hz: spad.background_rate_cps * spad.photon_detection_probability,
            dark_hz: spad.dark_count_rate_cps,
        }
    };
    let lit = |index: &PathIndex| scene.sources[scene.paths[*index].source].mean_power_w > 0.0;
    PathIndex::of(&scene.paths)
        .filter(lit)
        .map(of_path)
        .collect()
}
