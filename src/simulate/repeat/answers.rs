//! What the scene's estimator says of a scan, path by path.

use rayon::prelude::*;

use crate::estimate::chance::NO_PEAK;
use crate::estimate::estimator::{Estimated, Estimator, EstimatorInput};
use crate::estimate::fit::{ALARM_SIGMAS, ModelEstimate};
use crate::estimate::{
    CountingTier, Estimate, TrueDelay, delay_error_ps, distance_m, tolerance_ps, true_delay,
};
use crate::histogram::Histogram;
use crate::photons::{DetectorModel, StepCount};
use crate::scene::{DetectorIndex, EstimatorKind, OtherLight, PathIndex};
use crate::sensor::Sensor;

/// Most paths of a fit that are matched to the scene's.
const MOST_MATCHED: usize = 12;

/// One detector's way from counts to distances.
pub struct Ranging<'a> {
    pub sensor: &'a Sensor,
    pub detector: DetectorIndex,
    pub counting: CountingTier,
    /// Paths that the estimator can speak of.
    pub paths: Vec<PathIndex>,
    /// What each of them should be found at.
    pub truths: Vec<TrueDelay>,
    pub code_period_ps: f64,
    pub estimator: Estimator<'a>,
}

/// What one scan says.
#[derive(Debug, Default)]
pub struct ScanAnswer {
    /// Places in [`Ranging::paths`], and the error of the distance.
    pub found: Vec<(usize, f64)>,
    /// Every distance that the scan shows of the detector's own source, the strongest first.
    pub distances_m: Vec<f64>,
    /// Whether the scene has paths that the scan does not tell apart.
    pub is_untold: bool,
    /// Whether chi-square is too large; none without a fit, or where steps are
    /// not independent.
    pub alarm: Option<bool>,
    /// Whether `goldtof estimate` would refuse the scan, since its peak may be chance.
    pub is_refused: bool,
    /// What went wrong.
    pub remark: Option<String>,
}

impl<'a> Ranging<'a> {
    pub fn new(sensor: &'a Sensor, detector: DetectorIndex, counting: CountingTier) -> Ranging<'a> {
        let mut paths: Vec<PathIndex> = sensor.scene().own_paths(detector).collect();
        let takes_in_others = sensor.scene().estimator == EstimatorKind::Model
            && sensor.scene().other_light != OtherLight::None;
        if takes_in_others {
            paths.extend(DetectorModel::new(sensor, detector).modulated_paths());
            paths.sort_unstable();
            paths.dedup();
        }
        Ranging {
            truths: paths.iter().map(|&path| true_delay(sensor, path, counting)).collect(),
            sensor,
            detector,
            counting,
            paths,
            code_period_ps: sensor.timing().code_period_ps(),
            estimator: Estimator::new(sensor, detector, counting),
        }
    }

    /// The answers of whole scans, whose counts follow one another.
    pub fn answers(&self, counts: &[StepCount]) -> Vec<ScanAnswer> {
        counts
            .par_chunks_exact(self.sensor.timing().scan.steps as usize)
            .map(|counts| self.judged(EstimatorInput::Steps(counts)))
            .collect()
    }

    /// The answers of histograms.
    pub fn answers_of_histograms(&self, histograms: &[Histogram]) -> Vec<ScanAnswer> {
        let answer = |histogram| self.judged(EstimatorInput::Bins(histogram));
        histograms.par_iter().map(answer).collect()
    }

    /// What a scan or a histogram says, and whether that may be chance.
    fn judged(&self, counted: EstimatorInput) -> ScanAnswer {
        let is_refused = self.estimator.check_modulated().is_ok()
            && self.estimator.chance(counted).is_some_and(|chance| chance >= NO_PEAK);
        ScanAnswer { is_refused, ..self.answer(counted) }
    }

    /// Largest error of an estimate that has found its peak.
    pub fn tolerance_m(&self) -> f64 {
        let chip_ps = self.sensor.clock().chip_period_ps;
        distance_m(tolerance_ps(chip_ps, self.code_period_ps))
    }

    /// What a scan or a histogram says.
    pub fn answer(&self, counted: EstimatorInput) -> ScanAnswer {
        match self.estimator.answer(counted) {
            Ok(Estimated::Phase(estimate)) => self.of_phase(&estimate),
            Ok(Estimated::Fit(fitted)) => self.of_fit(&fitted),
            Err(reason) => ScanAnswer {
                remark: Some(format!("no estimate: {reason}")),
                ..ScanAnswer::default()
            },
        }
    }

    fn of_fit(&self, fitted: &ModelEstimate) -> ScanAnswer {
        let found = self.matched(fitted).into_iter();
        ScanAnswer {
            found: found.map(|(_, place, error_m)| (place, error_m)).collect(),
            distances_m: self.own_distances_m(fitted),
            is_untold: fitted.untold.is_some(),
            alarm: Some(fitted.alarm_sigmas() > ALARM_SIGMAS),
            is_refused: false,
            remark: fitted.untold.as_ref().map(ToString::to_string),
        }
    }

    /// The distances of a fit's paths of the detector's own source.
    fn own_distances_m(&self, fitted: &ModelEstimate) -> Vec<f64> {
        let own = &self.sensor.reference(self.detector).chips;
        let paths = fitted.paths.iter().filter(|path| path.code.chips == *own);
        paths.map(|path| distance_m(path.delay_ps)).collect()
    }

    fn of_phase(&self, estimate: &Estimate) -> ScanAnswer {
        ScanAnswer {
            found: self.nearest(estimate.delay_ps, |_| true).into_iter().collect(),
            distances_m: vec![estimate.distance_m],
            is_untold: false,
            alarm: None,
            is_refused: false,
            remark: estimate.coarse_only.map(|reason| reason.to_string()),
        }
    }

    /// The paths that a fit has found: number in the fit, place, error of the
    /// distance. Of one code's paths as many as can be, and then so that the sum of
    /// their squared errors is least; no place is given twice.
    pub fn matched(&self, fitted: &ModelEstimate) -> Vec<(usize, usize, f64)> {
        // More paths than a fit ever has would be matched in their order.
        let numbers = fitted.paths.len().min(MOST_MATCHED);
        let near: Vec<_> = (0..numbers).map(|number| self.near(fitted, number)).collect();
        best_matching(&near, &mut Vec::new())
    }

    /// The places that a path of a fit may have, those of its code within a chip, each with the
    /// error of the distance.
    pub fn near(&self, fitted: &ModelEstimate, number: usize) -> Vec<(usize, f64)> {
        let path = &fitted.paths[number];
        let of_code = |place: &usize| {
            let source = self.sensor.scene().paths[self.paths[*place]].source;
            self.sensor.scene().sources[source].code.chips == path.code.chips
        };
        let places = (0..self.paths.len()).filter(of_code);
        places.filter_map(|place| self.nearest(path.delay_ps, |p| p == place)).collect()
    }

    /// The nearest path of some, if it is within a chip.
    fn nearest(&self, delay_ps: f64, among: impl Fn(usize) -> bool) -> Option<(usize, f64)> {
        let error_ps = |place: usize| {
            delay_error_ps(delay_ps, self.truths[place].delay_ps, self.code_period_ps)
        };
        let places = (0..self.paths.len()).filter(|&place| among(place));
        let (place, error_ps) = places
            .map(|place| (place, error_ps(place)))
            .min_by(|(_, a), (_, b)| a.abs().total_cmp(&b.abs()))?;
        (error_ps.abs() <= self.sensor.clock().chip_period_ps)
            .then(|| (place, distance_m(error_ps)))
    }
}

/// The matching of most numbers to places, of those the one with the least sum of
/// squared errors. `near` has the places that each number may have, with the errors;
/// `taken` those that are no longer free.
fn best_matching(near: &[Vec<(usize, f64)>], taken: &mut Vec<usize>) -> Vec<(usize, usize, f64)> {
    let Some((last, before)) = near.split_last() else {
        return Vec::new();
    };
    let mut best = best_matching(before, taken);
    for &(place, error_m) in last {
        if taken.contains(&place) {
            continue;
        }
        taken.push(place);
        let mut with = best_matching(before, taken);
        taken.pop();
        with.push((before.len(), place, error_m));
        let squares = |m: &[(usize, usize, f64)]| m.iter().map(|(.., e)| e * e).sum::<f64>();
        let is_better =
            with.len() > best.len() || with.len() == best.len() && squares(&with) < squares(&best);
        if is_better {
            best = with;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn close_paths_keep_their_order_and_none_is_left_out() {
        // Paths at 0 and 1, found at 0.9 and 1.1: the nearest would leave one out.
        let near = [vec![(0, 0.9), (1, -0.1)], vec![(0, 1.1), (1, 0.1)]];
        let matched = best_matching(&near, &mut Vec::new());
        assert_eq!(matched, [(0, 0, 0.9), (1, 1, 0.1)]);
        // Found the other way round, and one that is nowhere near.
        let near = [vec![(0, 1.1), (1, 0.1)], vec![], vec![(0, 0.9), (1, -0.1)]];
        let matched = best_matching(&near, &mut Vec::new());
        assert_eq!(matched, [(0, 1, 0.1), (2, 0, 0.9)]);
    }
}
