//! Whether the counts hold anything but chance.

use super::NoEstimate;
use crate::photons::DetectorModel;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Checks that light with the code of a detector's reference reaches it.
///
/// Without any, the largest count of a scan is chance, however well it looks: an
/// extinction ratio of 1, a source without power, a path that carries nothing, a
/// detection probability of 0, or no path at all.
///
/// # Errors
/// [`NoEstimate::NotModulated`].
///
/// # Panics
/// If the scene has no such detector.
pub fn check_modulated(sensor: &Sensor, detector: DetectorIndex) -> Result<(), NoEstimate> {
    let own = sensor.scene().detectors[detector].reference;
    let model = DetectorModel::new(sensor, detector);
    let is_modulated = model.modulated_paths().any(|path| sensor.scene().paths[path].source == own);
    is_modulated.then_some(()).ok_or(NoEstimate::NotModulated)
}

#[cfg(test)]
mod tests {
    use std::path::Path as FilePath;

    use super::*;
    use crate::scene::{self, Scene};

    #[test]
    fn light_without_its_code_is_nothing_to_estimate_from() {
        let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/dual-view.toml");
        let bright = scene::load(&file).expect("the scene is sound");
        let own = bright.detectors[0].reference;
        let verdict = |change: &dyn Fn(&mut Scene)| {
            let mut scene = bright.clone();
            change(&mut scene);
            check_modulated(&Sensor::new(&scene), DetectorIndex(0))
        };
        let refused = Err(NoEstimate::NotModulated);
        assert_eq!(verdict(&|_| ()), Ok(()));
        assert_eq!(verdict(&|s| s.sources[own].extinction_ratio = 1.0), refused);
        assert_eq!(verdict(&|s| s.sources[own].mean_power_w = 0.0), refused);
        assert_eq!(verdict(&|s| s.detectors[0].photon_detection_probability = 0.0), refused);
        // The other source's light is left, which has another code.
        assert_eq!(verdict(&|s| s.paths.retain(|p| p.source != own)), refused);
        assert_eq!(verdict(&|s| s.paths.retain(|p| p.source == own)), Ok(()));
    }
}
