//! Plausibility of counts: whether a scene's hardware can have produced them, which is checked for
//! every count that comes from outside, and whether they can have a peak that is not chance.

use super::NoEstimate;
use crate::photons::{DetectorModel, StepCount};
use crate::scan::Step;
use crate::scene::{DetectorIndex, Scene};
use crate::sensor::Sensor;
use crate::sensor::cells::Cells;

/// A phase step's signed count, and the total one where there is any, as the scene's hardware
/// can have counted them.
///
/// # Errors
/// What is wrong and what would be right.
pub fn possible_count(
    scene: &Scene,
    signed: i128,
    total: Option<i128>,
) -> Result<StepCount, String> {
    let chips = i128::from(scene.scan.integration_chips);
    // A rising edge takes two samples, and the first may stand alone.
    let of_level = (chips * i128::from(scene.samples_per_chip) / 2 + 1).max(chips);
    // All detectors of a scene whose cells are added up have as many.
    let cells = scene.detectors.first().map_or(1, |spad| Cells::of(spad).edges());
    let most = of_level * i128::from(cells);
    if signed.abs() > most {
        return Err(format!(
            "count is {signed}; {chips} chips of {} samples hold at most {most} detections{}",
            scene.samples_per_chip,
            if cells > 1 { format!(" of {cells} cells") } else { String::new() }
        ));
    }
    let Some(total) = total else {
        return Ok(StepCount { signed: signed as i64, total: 0 });
    };
    if !(signed.abs()..=most).contains(&total) {
        return Err(format!(
            "total_count is {total}; with count {signed} it is {} to {most}",
            signed.abs()
        ));
    }
    let saturates = scene.hardware.counter_width.is_some();
    if !saturates && (total - signed) % 2 != 0 {
        return Err(format!(
            "total_count {total} and count {signed} do not belong together: the sum of hits up and hits \
             down, and their difference, are both even or both odd"
        ));
    }
    Ok(StepCount { signed: signed as i64, total: total as u64 })
}

/// The counts of a scan as its hardware can have counted them: `counts` has one for each
/// phase step, in their order.
///
/// # Errors
/// If there is not one per step, or one is impossible.
pub fn possible_scan(
    scene: &Scene,
    counts: &[(i64, Option<u64>)],
) -> Result<Vec<StepCount>, ImpossibleScan> {
    let steps = scene.scan.steps;
    if counts.len() as u64 != steps {
        return Err(ImpossibleScan::WrongNumber { found: counts.len(), steps });
    }
    let of_step = |(step, &(signed, total)): (usize, &(i64, Option<u64>))| {
        possible_count(scene, signed.into(), total.map(i128::from)).map_err(|problem| {
            let phase_step = scene.scan.phase_step(Step(step as u64));
            ImpossibleScan::Count { phase_step, problem }
        })
    };
    counts.iter().enumerate().map(of_step).collect()
}

/// Why counts are those of no scan of the scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ImpossibleScan {
    /// There are more or fewer than phase steps.
    #[error("{found} phase steps were counted, and a scan of this scene has {steps}")]
    WrongNumber {
        /// How many there are.
        found: usize,
        /// How many there should be.
        steps: u64,
    },
    /// No hardware of the scene counts that.
    #[error("phase step {phase_step}: {problem}")]
    Count {
        /// Number of the phase step in the code period.
        phase_step: u64,
        /// What is wrong, and what would be right.
        problem: String,
    },
}

/// Checks that light with the code of a detector's reference reaches it.
///
/// Without any, the largest count of a scan is chance, however well it looks: an
/// extinction ratio of 1, a source without power, a path that carries nothing, a
/// detection probability of 0, or no path at all.
///
/// # Errors
/// [`NoEstimate::NotModulated`].
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
    use crate::scene;

    #[test]
    fn added_cells_count_as_often_as_there_are_some() {
        let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../tests/scenes/adder.toml");
        let mut scene = scene::load(&file).expect("the scene is sound");
        // 125 chips of 4 samples hold 250 rising edges and one more, of each of three cells.
        assert!(possible_count(&scene, -753, Some(753)).is_ok());
        let told = possible_count(&scene, 754, None).unwrap_err();
        assert!(told.contains("at most 753 detections of 3 cells"), "{told}");
        scene.detectors.iter_mut().for_each(|spad| spad.combination = scene::Combination::Or);
        assert!(possible_count(&scene, 252, None).is_err());
    }

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
