//! Counts that a scene's hardware can have counted: what is held against every count that
//! comes from outside, wherever it comes in.

use crate::photons::StepCount;
use crate::scan::Step;
use crate::scene::Scene;

/// A phase step's signed count, and the total one where there is any, as the scene's hardware
/// can have counted them.
///
/// # Errors
/// With what is wrong and what would be right, if it cannot.
pub fn possible_count(
    scene: &Scene,
    signed: i128,
    total: Option<i128>,
) -> Result<StepCount, String> {
    let chips = i128::from(scene.scan.integration_chips);
    // A rising edge takes two samples, and the first may stand alone.
    let most = (chips * i128::from(scene.samples_per_chip) / 2 + 1).max(chips);
    if signed.abs() > most {
        return Err(format!(
            "count is {signed}; {chips} chips of {} samples hold at most {most} detections",
            scene.samples_per_chip
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
            "total_count {total} and count {signed} do not belong together: hits up and down, both \
             together and one less the other, are both even or both odd"
        ));
    }
    Ok(StepCount { signed: signed as i64, total: total as u64 })
}

/// The counts of a scan as its hardware can have counted them: `counts` has one for each
/// phase step, in their order.
///
/// # Errors
/// If there are more or fewer than steps, or one is impossible.
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
