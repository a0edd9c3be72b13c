//! Means of counts against closed forms.

use crate::photons::StepCount;
use crate::scene::Scene;

/// How many of some counts have counted anything.
pub(super) fn seen(counts: &[StepCount]) -> usize {
    counts.iter().filter(|count| count.total > 0).count()
}

/// How many counts of two runs differ.
pub(super) fn differing(a: &[StepCount], b: &[StepCount]) -> usize {
    a.iter().zip(b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len())
}

/// Integration time per phase step.
pub(super) fn step_s(scene: &Scene) -> f64 {
    scene.timing().integration_ps() * 1e-12
}

/// The value of largest magnitude; NaN if one is NaN, or there is none.
pub(super) fn worst(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    values.into_iter().map(f64::abs).reduce(larger).unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_value_is_the_largest_or_undefined() {
        assert_eq!(worst([0.5, -2.0, 1.0]), 2.0);
        assert!(worst([0.5, f64::NAN, 1.0]).is_nan());
        assert!(worst([]).is_nan() && worst([f64::NAN, 1.0]).is_nan());
    }
}
