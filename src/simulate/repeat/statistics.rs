//! The statistics of many scans beside what theory expects.

use super::answers::Ranging;
use super::moments::ScanMoments;
use super::tally::ScanTally;
use crate::estimate::bound::bound_and_remark;
use crate::estimate::coverage;
use crate::estimate::evidence::{Comparisons, Evidence, Expectation, ExpectedErrors};
use crate::estimate::fit::FitError;
use crate::estimate::unwrap::{check_normal, fold, fold_distance, unwrap};
use crate::estimate::{Prediction, Theory, distance_m, folded, share_error};
use crate::math::share_interval;
use crate::scene::EstimatorKind;
use crate::simulate::path_statistics::PathStatistics;

/// What is expected of a path's errors, or why nothing is.
type ExpectedOfPath = Result<ExpectedErrors, String>;

/// One entry per path of a detector.
pub fn statistics(
    ranging: &Ranging,
    tally: &ScanTally,
    theory: &Theory,
    detected_rate_cps: f64,
    family: Comparisons,
) -> Vec<PathStatistics> {
    let scene = ranging.sensor.scene();
    let (expected, missed) = expectations(ranging, theory);
    let of_path = |place: usize| {
        let path = ranging.paths[place];
        let truth = &ranging.truths[place];
        let range_m = distance_m(ranging.code_period_ps);
        let true_distance_m = fold_distance(distance_m(truth.delay_ps), range_m);
        let errors_m = &tally.errors_m[place];
        let (moments, spread) = match unwrap(errors_m, range_m) {
            Ok(unwrapped) => (ScanMoments::of(&unwrapped), None),
            Err(spread) => (ScanMoments::NONE, Some(spread.to_string())),
        };
        let bias_m = moments.mean.map(|mean| fold(mean, range_m));
        let missed_scans = tally.scans - tally.found[place];
        let of_scans = |count: u64| (tally.scans > 0).then(|| count as f64 / tally.scans as f64);
        let (bound_m, bound_kind, bound_remark) =
            bound_and_remark(ranging.sensor, path, ranging.counting, &theory.bound);
        let are_errors_drawn = theory.predictions[place].as_ref().is_ok_and(|told| told.is_drawn);
        let with_error = |share| (share, share_error(ranging.sensor, share, are_errors_drawn));
        let expectation = Expectation {
            errors: expected[place].as_ref().ok().copied(),
            missed: missed[place].map(with_error),
        };
        let evidence = Evidence { errors_m, scans: tally.scans, missed: missed_scans, range_m };
        let contradictions = family.contradictions(&evidence, &expectation);
        PathStatistics {
            detector: scene.detectors[ranging.detector].name.clone(),
            source: scene.sources[scene.paths[path].source].name.clone(),
            path,
            true_distance_m,
            true_distance_at_s: truth.at_ps.map(|ps| ps * 1e-12),
            estimates: errors_m.len() as u64,
            missed_scans,
            missed_fraction: of_scans(missed_scans),
            missed_fraction_ci95: (tally.scans > 0)
                .then(|| share_interval(missed_scans, tally.scans)),
            expected_missed_fraction: missed[place],
            correct_coarse_fraction: of_scans(tally.found[place]),
            refused_fraction: of_scans(tally.refused),
            mean_distance_m: bias_m.map(|bias_m| fold_distance(true_distance_m + bias_m, range_m)),
            bias_m,
            std_m: moments.std,
            bias_std_error_m: moments.std_error,
            std_std_error_m: moments.std_std_error,
            expected_bias_m: expectation.errors.map(|errors| errors.bias_m),
            expected_std_m: expectation.errors.map(|errors| errors.std_m),
            expectation_holds: contradictions.as_ref().map(Vec::is_empty),
            expectation_remark: contradictions.filter(|c| !c.is_empty()).map(|c| c.join("; ")),
            bound_m,
            bound_kind,
            std_over_bound: moments.std.zip(bound_m).map(|(std, bound)| std / bound),
            bound_remark,
            chi_square_alarm_fraction: (tally.fits > 0)
                .then(|| tally.alarms as f64 / tally.fits as f64),
            detected_rate_cps,
            remark: joined([
                tally.remark(),
                spread,
                unexpected(&expected[place]),
                folded(ranging.sensor, path),
            ]),
        }
    };
    (0..ranging.paths.len()).map(of_path).collect()
}

/// Why nothing is expected of a path's errors, where that is so.
fn unexpected(expected: &ExpectedOfPath) -> Option<String> {
    expected.as_ref().err().map(|reason| format!("no expectation: {reason}"))
}

/// What each path's errors and share of misses are expected to be.
fn expectations(ranging: &Ranging, theory: &Theory) -> (Vec<ExpectedOfPath>, Vec<Option<f64>>) {
    let range_m = distance_m(ranging.code_period_ps);
    if ranging.sensor.scene().estimator == EstimatorKind::Model {
        return match fitted_to_means(ranging, theory) {
            Ok(expected) => (expected, theory.missed.clone()),
            // Scans that are not fitted find no path.
            Err(reason) => {
                let paths = ranging.paths.len();
                (vec![Err(reason.to_string()); paths], vec![None; paths])
            }
        };
    }
    let errors = theory.predictions.iter().map(|predicted| {
        let Prediction { bias_m, std_m, .. } = predicted.as_ref().map_err(ToString::to_string)?;
        // Errors of longer codes are cut off at a chip.
        check_normal(*std_m, range_m).map_err(|spread| spread.to_string())?;
        Ok(ExpectedErrors { bias_m: *bias_m, std_m: *std_m })
    });
    (errors.collect(), theory.missed.clone())
}

/// The fit's answer to the expected counts.
fn fitted_to_means(ranging: &Ranging, theory: &Theory) -> Result<Vec<ExpectedOfPath>, FitError> {
    let fitted = ranging.estimator.expected_fit()?;
    let unseen = || Err("the expected counts do not show the path".to_owned());
    let mut expected: Vec<ExpectedOfPath> = ranging.paths.iter().map(|_| unseen()).collect();
    for (order, place, bias_m) in ranging.matched(&fitted) {
        let std_m = distance_m(fitted.paths[order].delay_std_ps);
        let path = ranging.paths[place];
        let errors = ExpectedErrors { bias_m, std_m };
        let bound = theory.bound.as_ref().ok();
        let errors =
            bound.map_or(errors, |bound| bound.errors_of_fit(path, errors, fitted.paths.len()));
        let Ranging { sensor, detector, counting, .. } = *ranging;
        let covered = coverage::check_fit(sensor, detector, path, counting, (&fitted, errors));
        expected[place] = covered.map(|()| errors).map_err(|reason| reason.to_string());
    }
    Ok(expected)
}

/// What there is of remarks, in one; none if there are none.
fn joined(remarks: impl IntoIterator<Item = Option<String>>) -> Option<String> {
    let remarks: Vec<String> = remarks.into_iter().flatten().collect();
    (!remarks.is_empty()).then(|| remarks.join("; "))
}
