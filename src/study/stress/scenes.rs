//! Scenes that the cases start from.

use crate::light::photon_rate_hz;
use crate::light::round_trip_ps;
use crate::scene::{self, Detector, Scene, SceneErrors};
use crate::study::article;

/// A sensor that adds nothing of its own: no dead time, no afterpulses, no
/// delay, no jitter, no edges; one path without delay, every photon detected.
/// `code` is the right-hand side of the key, `rate_cps` the mean rate of photons.
pub(super) fn ideal(
    code: &str,
    samples_per_chip: u32,
    rate_cps: f64,
    integration_chips: u64,
) -> Result<Scene, SceneErrors> {
    let integration_ns = 8 * integration_chips;
    let text = format!(
        r#"
[clock]
chip_period = "8 ns"
samples_per_chip = {samples_per_chip}

[[source]]
name = "laser"
code = {code}
wavelength = "783 nm"
mean_power = "{power_w:e} W"
extinction_ratio = "inf"

[[detector]]
name = "spad"
reference = "laser"

[[path]]
source = "laser"
detector = "spad"
delay = "0 ns"

[scan]
integration = "{integration_ns} ns"
"#,
        power_w = rate_cps / photon_rate_hz(1.0, 783.0),
    );
    scene::parse("ideal.toml", &text)
}

/// The detector of Table I at 3.2 m, at a mean primary rate of `rate_cps`.
pub(super) fn table_i(
    code: &str,
    rate_cps: f64,
    integration_chips: u64,
) -> Result<Scene, SceneErrors> {
    let detector = article::detector();
    let photons_cps = rate_cps / detector.photon_detection_probability;
    let mut scene = ideal(code, 8, photons_cps, integration_chips)?;
    scene.sources[0].extinction_ratio = 10.0;
    scene.paths[0].delay_ps = round_trip_ps(3.2);
    scene.detectors[0] = detector;
    Ok(scene)
}

/// A Gold code of 31 chips.
pub(super) const GOLD_5: &str = r#"{ family = "gold", degree = 5 }"#;
/// A Gold code of 2,047 chips.
pub(super) const GOLD_11: &str = r#"{ family = "gold", degree = 11 }"#;

/// Ideal scene under background only: `rate_cps` of background on a detector that `set` changes.
pub(super) fn constant_light(
    rate_cps: f64,
    integration_chips: u64,
    set: impl FnOnce(&mut Detector),
) -> Result<Scene, SceneErrors> {
    let mut scene = ideal(GOLD_5, 8, 0.0, integration_chips)?;
    scene.detectors[0].background_rate_cps = rate_cps;
    set(&mut scene.detectors[0]);
    Ok(scene)
}

/// The ideal sensor in light of 10 Mcps, with a scan of one phase step.
pub(super) fn lit_step(
    code: &str,
    samples_per_chip: u32,
    integration_chips: u64,
    step: u64,
) -> Result<Scene, SceneErrors> {
    let mut scene = ideal(code, samples_per_chip, 10e6, integration_chips)?;
    window(&mut scene, step, 1);
    Ok(scene)
}

/// A scan of the `steps` phase steps from `first` on.
pub(super) fn window(scene: &mut Scene, first: u64, steps: u64) {
    scene.scan.first_step = first;
    scene.scan.steps = steps;
}
