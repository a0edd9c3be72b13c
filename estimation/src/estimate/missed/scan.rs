//! The laws of all counts of a scan.

use super::law::CountLaw;
use super::target::Target;
use crate::estimate::expected_counts::ExpectedCounts;
use crate::scan::Step;

/// Scans of more steps are worked out by FFT.
const STEPS_ONE_BY_ONE: usize = 400;

/// The laws of a scan's counts.
///
/// Variances change little from step to step: of short scans they are worked out at
/// every half chip, and are straight between.
pub fn laws(counts: &ExpectedCounts, target: &Target) -> Vec<CountLaw> {
    let steps = counts.means.len();
    let variances = if steps > STEPS_ONE_BY_ONE {
        let moments = counts.second.of_scan();
        moments.iter().map(|m| m.signed_variance).collect()
    } else {
        between(counts, steps, target.sensor.clock().samples_per_chip.div_ceil(2) as usize)
    };
    let spad = &target.sensor.scene().detectors[target.detector];
    let afterpulses = -(-spad.afterpulsing_probability).ln_1p();
    let of_step = |(mean, variance): (&crate::response::MeanCount, f64)| CountLaw {
        mean: mean.signed,
        variance,
        total: mean.total,
        afterpulses,
    };
    counts.means.iter().zip(variances).map(of_step).collect()
}

/// Variances of every `stride`-th step and the last, and those between.
fn between(counts: &ExpectedCounts, steps: usize, stride: usize) -> Vec<f64> {
    let known = |index: usize| (index * stride).min(steps - 1);
    let asked: Vec<Step> = (0..=steps.div_ceil(stride)).map(|i| Step::at(known(i))).collect();
    let moments = counts.second.of_steps(&asked);
    (0..steps)
        .map(|step| {
            let early = step / stride;
            let (from, to) = (known(early), known(early + 1));
            let share = (step - from) as f64 / (to - from).max(1) as f64;
            let [a, b] = [early, early + 1].map(|index| moments[index].signed_variance);
            a + share * (b - a)
        })
        .collect()
}
