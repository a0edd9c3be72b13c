//! The Cramer-Rao bound: how precise any unbiased estimator can be.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::corners::{
    Corners, LEAST_EVEN, MOST_APART, averaged_over_delays, check_close, may_be_uneven, most_uneven,
};
use super::evidence::ExpectedErrors;
use super::expected_counts::{ExpectedCounts, with_counts};
use super::fit::bins::BinFitter;
use super::fit::error::FitError;
use super::fit::likeliest::{Likeliest, PathSlopes, Scatter, is_off_information, likeliest};
use super::fit::moments::ProblemMoments;
use super::fit::moving;
use super::fit::parameters::{DerivativeColumn, FitParameters};
use super::fit::problem::{NeighbouringResponses, Problem, ResponseReading, Sides, window};
use super::fit::template::DelayAxis;
use super::fit::weights::Weights;
use super::phase::first_maximum;
use super::prediction::moves;
use super::truth::Asked;
use super::{CountingTier, TheoryEffort, Work, coverage, distance_m};
use crate::photons::DetectorModel;
use crate::response::{Light, MeanCount, MeanResponse};
use crate::scan::Step;
use crate::scene::{Architecture, DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Up to so large a bound, in chips, bounds beside it are taken in.
const MOST_CHIPS_APART: f64 = 0.1;

/// How precise estimates from the counts of one scan can be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PrecisionBound {
    /// One entry per path that carries modulated light, in the scene's order.
    pub paths: Vec<PathBound>,
    /// Phase steps that take part: the whole scan, of a path that moves 3 S round its peak.
    pub steps: usize,
}

/// What a bound is: where the counts tell more of a delay on one side than on the other, no one bound holds for every
/// estimator.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum BoundKind {
    /// No unbiased estimate from the same counts scatters less.
    CramerRao,
    /// The standard deviation of the maximum-likelihood estimate, which bounds no other estimator's.
    MaximumLikelihood,
}

impl BoundKind {
    /// Of counts that do or do not change unevenly with the delay.
    fn of(are_uneven: bool) -> BoundKind {
        if are_uneven { BoundKind::MaximumLikelihood } else { BoundKind::CramerRao }
    }

    /// What a text calls it.
    pub fn name(self) -> &'static str {
        match self {
            BoundKind::CramerRao => "Cramer-Rao bound",
            BoundKind::MaximumLikelihood => "maximum-likelihood scatter",
        }
    }
}

/// How precise the estimate of one path can be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PathBound {
    /// Index of the path in the scene.
    pub path: PathIndex,
    /// Least standard deviation of its distance, with delay and strength of
    /// every path and the background unknown.
    pub bound_m: f64,
    /// The same if the counts changed as evenly with the distance as their slope at the scene's says.
    pub slope_m: f64,
    /// Mean error that a fit has which knows of that slope only.
    pub bias_m: f64,
    /// What `bound_m` is.
    pub kind: BoundKind,
    /// Least standard deviation of the speed of a moving path, which is then unknown, too; the distance
    /// is that at the moment at which the scan passes the path.
    pub velocity_bound_m_per_s: Option<f64>,
}

impl PathBound {
    /// Errors of a fit that knows of one slope of the counts only.
    fn errors(&self, of_slope: ExpectedErrors) -> ExpectedErrors {
        let share = of_slope.std_m / self.slope_m;
        ExpectedErrors {
            bias_m: of_slope.bias_m + share * self.bias_m,
            std_m: share * self.bound_m,
        }
    }
}

impl PrecisionBound {
    /// What a fit of path `path` is expected to be off by, that of the expected counts being `fitted`: its derivatives and
    /// second moments are those of light nearby, so that its standard deviation may be off by 1 %, but is not better
    /// than the bound; and it knows of one slope of the counts only. A fit of fewer paths than reach the detector has
    /// fewer unknowns than the bound, which is then none for it: it trades scatter for bias.
    pub fn errors_of_fit(
        &self,
        path: PathIndex,
        fitted: ExpectedErrors,
        fitted_paths: usize,
    ) -> ExpectedErrors {
        if fitted_paths < self.paths.len() {
            return fitted;
        }
        self.paths.iter().find(|entry| entry.path == path).map_or(fitted, |entry| {
            entry.errors(ExpectedErrors { std_m: fitted.std_m.max(entry.slope_m), ..fitted })
        })
    }

    /// A remark for a path's bound that is none for other estimators, or not of all steps.
    pub fn remark(&self, path: PathIndex) -> Option<String> {
        let entry = self.paths.iter().find(|entry| entry.path == path)?;
        if entry.kind == BoundKind::MaximumLikelihood {
            return Some(
                "the counts change unevenly with the delay, so that no one bound holds for every estimator"
                    .to_owned(),
            );
        }
        entry.velocity_bound_m_per_s.map(|_| {
            format!(
                "the bound is of the {} phase steps round the peak, as the fit of a path that moves",
                self.steps
            )
        })
    }

    /// The bound of path `path` of the scene, if it carries modulated light.
    pub fn of_path(&self, path: PathIndex) -> Option<f64> {
        let entry = self.paths.iter().find(|entry| entry.path == path)?;
        Some(entry.bound_m)
    }
}

/// The bound for all light of a detector from all steps of the scan: from derivatives of the
/// means, and the covariance of r and N at each step; in [long scans](super::fit::moments)
/// a few steps stand for all. Information in the variances is left out.
/// The bound of a moving path is of the 3 S steps round its peak.
///
/// # Errors
/// When the mean response cannot be had, or the scan does not determine all
/// unknowns.
pub fn bound(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
) -> Result<PrecisionBound, FitError> {
    if sensor.scene().hardware.architecture == Architecture::Histogram {
        return bound_of_bins(sensor, detector);
    }
    TheoryEffort::of(sensor, detector)?.check(Work::Bound)?;
    let moment_ps = moving::moment_ps(sensor, detector, tier, sensor.scene().other_light)?;
    if let Some(moment_ps) = moment_ps {
        return bound_of_moving(sensor, detector, tier, moment_ps);
    }
    with_counts(sensor, detector, tier, |counts| bound_of(sensor, detector, tier, counts))
}

/// The bound for a histogram: the Cramer-Rao bound where the bins carry the same information at
/// every plausible delay. Elsewhere there is not one bound for all estimates, and this is the standard
/// deviation of the maximum-likelihood estimate.
fn bound_of_bins(sensor: &Sensor, detector: DetectorIndex) -> Result<PrecisionBound, FitError> {
    let fitter = BinFitter::new(sensor, detector)?;
    let (clock, scatter) = (sensor.clock(), fitter.scatter_chips()?);
    Ok(PrecisionBound {
        paths: vec![PathBound {
            path: fitter.path,
            bound_m: distance_m(clock.ps(scatter.law.std)),
            slope_m: distance_m(clock.ps(scatter.law.std)),
            // Fits of bins know the likelihood.
            bias_m: 0.0,
            kind: BoundKind::of(scatter.is_uneven()),
            velocity_bound_m_per_s: None,
        }],
        steps: (sensor.timing().code_chips() * u64::from(clock.samples_per_chip)) as usize,
    })
}

/// Standard deviation of a sensor's only path in metres, where the information changes within it: steps that count
/// the same light tell much more of a delay on one side of an edge than on the other. The bound's square on
/// average over the delays that estimates come from, by Gauss and Hermite's three. `None` with more paths, and
/// without a bound.
pub(super) fn averaged(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
) -> Option<f64> {
    let of = |bound: &PrecisionBound| match bound.paths[..] {
        [path] => Some((path.path, path.slope_m)),
        _ => None,
    };
    let (path, here_m) = of(&bound(sensor, detector, tier).ok()?)?;
    // Farther apart, other edges come in between.
    if here_m > MOST_CHIPS_APART * distance_m(sensor.clock().chip_period_ps) {
        return Some(here_m);
    }
    let beside = [-1.0, 1.0].map(|side| {
        let later_ps = side * 3.0_f64.sqrt() * here_m / distance_m(1.0);
        let there = sensor.with(|scene| scene.paths[path].delay_ps += later_ps);
        let there = bound(&there, detector, tier).ok().as_ref().and_then(of);
        there.map_or(here_m, |(_, bound_m)| bound_m)
    });
    let [before, after] = beside.map(|bound_m| bound_m * bound_m);
    Some(((4.0 * here_m * here_m + before + after) / 6.0).sqrt())
}

/// Responses on both sides of each unknown of a detector's light, to tell bounds at several
/// integration times from. `None` without a bound.
pub(super) fn beside<'m>(
    response: &MeanResponse<'m>,
    tier: CountingTier,
) -> Option<Vec<NeighbouringResponses<'m>>> {
    let light = Light::of(response.model());
    let parameters = FitParameters::of(&light);
    let problem = Problem::of_scan(response.model(), tier);
    let of_unknown = |unknown| problem.beside(&parameters, response, unknown).ok();
    (!light.paths.is_empty()).then(|| (0..parameters.len()).map(of_unknown).collect())?
}

/// The bound of the scene's own counts.
pub(super) fn bound_of(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    counts: &ExpectedCounts,
) -> Result<PrecisionBound, FitError> {
    let light = Light::of(counts.model());
    if light.paths.is_empty() {
        return Err(FitError::Dark);
    }
    let problem = Problem::of_scan(counts.model(), tier);
    bound_of_problem(sensor, detector, &problem, &FitParameters::of(&light), counts)
}

/// The bound of a path that moves, and of its speed.
fn bound_of_moving(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    moment_ps: f64,
) -> Result<PrecisionBound, FitError> {
    let still = sensor.still_at(moment_ps);
    with_counts(&still, detector, tier, |counts| {
        let peak = Step::at(first_maximum(&counts.signed()));
        let samples_per_chip = sensor.clock().samples_per_chip;
        let steps = moving::in_one_go(&window(&sensor.timing().scan, samples_per_chip, peak), peak);
        let model = counts.model();
        let (problem, parameters) = moving::of_scene(sensor, model, tier, steps, moment_ps)?;
        bound_of_problem(sensor, detector, &problem, &parameters, counts)
    })
}

fn bound_of_problem<'m>(
    sensor: &Sensor,
    detector: DetectorIndex,
    problem: &Problem<'m>,
    parameters: &FitParameters,
    counts: &ExpectedCounts<'_, 'm>,
) -> Result<PrecisionBound, FitError> {
    let jacobian = match &counts.beside {
        None => {
            problem.jacobian(parameters, counts.response, ResponseReading::Exact, Sides::Both)?
        }
        Some(beside) => {
            let columns = beside.iter();
            let column = |side| problem.slope_between(parameters, side, ResponseReading::Exact);
            columns.map(column).collect::<Result<_, _>>()?
        }
    };
    let axis = DelayAxis::new(sensor, detector, problem.tier, &problem.steps);
    let means: Vec<_> = problem.steps.iter().map(|step| counts.means[step.index()]).collect();
    let moments =
        |few: &Problem| Ok::<_, FitError>(Arc::new(ProblemMoments::of(few, counts.second)));
    let weights = problem.weights(&axis, parameters, &means, None, moments)?;
    coverage::are_moments(weights.most_correlated).check()?;
    let corners = Corners::of(sensor, detector, problem, parameters)?;
    let of = (counts.response, &means[..]);
    bound_of_weights(problem, parameters, of, &jacobian, (&weights, corners))
}

/// The bound of counts of the means `means` with some weights, and how [corners are looked at](Corners);
/// `jacobian` has the means' derivatives.
fn bound_of_weights<'m>(
    problem: &Problem<'m>,
    parameters: &FitParameters,
    (response, means): (&MeanResponse<'m>, &[MeanCount]),
    jacobian: &[DerivativeColumn],
    (weights, corners): (&Weights, Corners),
) -> Result<PrecisionBound, FitError> {
    check_close(problem, parameters)?;
    let (steps, unknowns) = (problem.steps.len(), parameters.len());
    let information_of = |jacobian: &[DerivativeColumn]| {
        weights.information(jacobian).ok_or(FitError::Undetermined { steps, unknowns })
    };
    let information = information_of(jacobian)?;
    let deviations = information.standard_deviations();
    let have_met = match corners {
        Corners::Meet => averaged_over_delays(problem, parameters, &information, information_of)?,
        _ => None,
    };
    let velocity = parameters.walk_index().map(|walk| distance_m(1e12 * deviations[walk]));
    let columns = weights.whitened_columns(jacobian);
    let metres = |chips| distance_m(problem.clock().ps(chips));
    let bound = |(index, path): (usize, PathIndex)| {
        let (delay, std_chips) = (2 * index, deviations[2 * index]);
        let apart = |chips| {
            let apart = problem.apart(parameters, response, means, (index, chips))?;
            Ok::<_, FitError>(weights.whitened(&apart))
        };
        let may_be_uneven = may_be_uneven(problem, parameters, response);
        let has_corners = corners == Corners::Apart;
        let mut scatter = None;
        if may_be_uneven || has_corners {
            let read = most_uneven(problem, &columns, (delay, std_chips), apart)?;
            let is_out = !(LEAST_EVEN..=1.0 / LEAST_EVEN).contains(&read);
            if may_be_uneven && is_out {
                return Err(FitError::Uneven { std_mm: metres(std_chips) * 1e3, read });
            }
            if has_corners && (read - 1.0).abs() > MOST_APART {
                let slopes = PathSlopes::of_path(columns.clone(), index);
                scatter = likeliest(&Scatter::Normal, slopes, problem.found_within_chips(), apart)?;
            }
        }
        let of_likeliest = scatter.filter(Likeliest::is_uneven).map(|scatter| scatter.law.std);
        let of_met = have_met.as_ref().map(|stds| stds[index]);
        let of_met = of_met.filter(|&std| is_off_information(std, std_chips));
        let uneven = of_likeliest.or(of_met);
        Ok(PathBound {
            path,
            bound_m: metres(uneven.unwrap_or(std_chips)),
            slope_m: metres(std_chips),
            bias_m: scatter.map_or(0.0, |scatter| metres(scatter.law.mean)),
            kind: BoundKind::of(uneven.is_some()),
            velocity_bound_m_per_s: velocity,
        })
    };
    let paths = problem.model.modulated_paths().enumerate();
    Ok(PrecisionBound { paths: paths.map(bound).collect::<Result<_, FitError>>()?, steps })
}

/// [`PrecisionBound::errors_of_fit`] without the bound: how unevenly the counts change is told with the weights of Poisson counts,
/// which cost little.
///
/// # Errors
/// As [`bound`].
pub fn errors_of_fit(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    path: PathIndex,
    fitted: ExpectedErrors,
) -> Result<ExpectedErrors, FitError> {
    // Fits of bins know it, and a path that moves comes by every corner.
    if sensor.scene().hardware.architecture == Architecture::Histogram || moves(sensor, detector) {
        return Ok(fitted);
    }
    let model = DetectorModel::new(sensor, detector);
    let (response, problem) =
        (MeanResponse::of_tier(&model, tier)?, Problem::of_scan(&model, tier));
    let parameters = FitParameters::of(&Light::of(&model));
    let corners = Corners::of(sensor, detector, &problem, &parameters)?;
    if corners == Corners::Unseen && !may_be_uneven(&problem, &parameters, &response) {
        return Ok(fitted);
    }
    let means = response.mean_counts();
    let jacobian = problem.jacobian(&parameters, &response, ResponseReading::Exact, Sides::Both)?;
    let (of, weights) = ((&response, &means[..]), Weights::of_poisson(&means));
    let about = bound_of_weights(&problem, &parameters, of, &jacobian, (&weights, corners))?;
    let of_path = about.paths.iter().find(|entry| entry.path == path);
    Ok(of_path.map_or(fitted, |entry| entry.errors(fitted)))
}

/// Whether something is expected of a fit to the scene's expected counts.
///
/// # Errors
/// [`FitError::Uneven`] where it is not.
pub(super) fn check_scene_even(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    response: &MeanResponse,
) -> Result<(), FitError> {
    let problem = Problem::of_scan(response.model(), tier);
    let parameters = FitParameters::of(&Light::of(response.model()));
    check_close(&problem, &parameters)?;
    if !may_be_uneven(&problem, &parameters, response) {
        return Ok(());
    }
    match bound(sensor, detector, tier) {
        Err(uneven @ FitError::Uneven { .. }) => Err(uneven),
        _ => Ok(()),
    }
}

/// The bound of a path in metres, and what it is. It does not hold for counts that do not show the path, or
/// are clamped.
///
/// # Errors
/// Why there is none, in words.
pub fn bound_m(
    sensor: &Sensor,
    path: PathIndex,
    counting: CountingTier,
    bound: &Result<PrecisionBound, FitError>,
) -> Result<(f64, BoundKind), String> {
    let bound = bound.as_ref().map_err(ToString::to_string)?;
    let detector = sensor.scene().paths[path].detector;
    let asked = Asked { sensor, detector, path, tier: counting };
    coverage::check_scene(&asked).map_err(|reason| reason.to_string())?;
    let entry = bound.paths.iter().find(|entry| entry.path == path);
    let entry = entry.ok_or_else(|| "the path carries no modulated light".to_owned())?;
    let is_of_bins = sensor.scene().hardware.architecture == Architecture::Histogram;
    if entry.kind == BoundKind::MaximumLikelihood && !is_of_bins {
        let within = coverage::within_corners(sensor, entry.bound_m).check();
        within.map_err(|reason| reason.to_string())?;
    }
    Ok((entry.bound_m, entry.kind))
}

/// The same for a report: the bound, what it is, and its remark, or the reason why there is none.
pub fn bound_and_remark(
    sensor: &Sensor,
    path: PathIndex,
    counting: CountingTier,
    bound: &Result<PrecisionBound, FitError>,
) -> (Option<f64>, Option<BoundKind>, Option<String>) {
    match bound_m(sensor, path, counting, bound) {
        Ok((bound_m, kind)) => {
            (Some(bound_m), Some(kind), bound.as_ref().ok().and_then(|bound| bound.remark(path)))
        }
        Err(reason) => (None, None, Some(format!("no bound: {reason}"))),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::estimate::fit::Fitter;
    use crate::photons::count_step;
    use crate::response::SecondMoments;
    use crate::scene::OtherLight;
    use crate::scene::{load, load_with};

    /// Fits to simulated photons of dim light so many phase steps behind a tip of the correlation: where there is a bound
    /// they scatter as it says, and where there is none not as the slope does, at a tip less and beside it more. At a tip of
    /// more samples a chip that is less than the slope says, and beside it the fit has a mean error.
    #[test]
    fn there_is_a_bound_where_fits_scatter_as_slopes_say() {
        const SCANS: u64 = 200;
        let (detector, tier) = (DetectorIndex(0), CountingTier::Events);
        for (samples_per_chip, behind, scatter) in [
            (1, 0.0, Some(0.4..0.75)),
            (1, 0.1, Some(1.2..3.0)),
            (1, 0.3, None),
            (4, 0.0, None),
            (4, 0.1, None),
            (8, 0.0, None),
        ] {
            let delay_ps = 8_000.0 * (3.0 + behind / f64::from(samples_per_chip));
            let settings = [
                format!("clock.samples_per_chip={samples_per_chip}"),
                format!("path.distance={} m", distance_m(delay_ps)),
                format!("scan.integration={} us", 128 / samples_per_chip),
                "source.mean_power=2 pW".to_owned(),
                "detector.delay=0 s".to_owned(),
                "detector.counter={}".to_owned(),
            ];
            let settings: Vec<_> = settings.iter().map(|s| s.parse().expect("sound")).collect();
            let scene = load_with(Path::new("../scenes/quick.toml"), &settings).expect("sound");
            let sensor = Sensor::new(&scene);
            let bound = bound(&sensor, detector, tier);
            let (said_m, bias_m) = match (&bound, &scatter) {
                (Ok(bound), None) => {
                    let PathBound { bound_m, slope_m, bias_m, .. } = bound.paths[0];
                    let is_on_a_step = behind == 0.0;
                    assert_eq!(
                        bound_m < 0.98 * slope_m,
                        is_on_a_step,
                        "{samples_per_chip} {behind}"
                    );
                    (bound_m, bias_m)
                }
                (Err(FitError::Uneven { std_mm, .. }), Some(_)) => (std_mm * 1e-3, 0.0),
                _ => panic!("{samples_per_chip} {behind}: {bound:?}"),
            };
            let fitter = Fitter::new(&sensor, detector, tier, OtherLight::None);
            let expected = fitter.expected().map(|expected| expected.std_m);
            assert_eq!(
                expected.is_ok(),
                scatter.is_none(),
                "{samples_per_chip} {behind}: {expected:?}"
            );
            let model = DetectorModel::new(&sensor, detector);
            let error_m = |scan| {
                let steps = Step::all(scene.scan.steps);
                let counts: Vec<_> = steps.map(|step| count_step(&model, 3, scan, step)).collect();
                fitter.fit(&counts).expect("it fits").distance_m - distance_m(delay_ps)
            };
            // But for scans that miss the path, by more than a chip.
            let is_found = |error_m: &f64| error_m.abs() < distance_m(8_000.0);
            let errors_m: Vec<f64> = (0..SCANS).map(error_m).filter(is_found).collect();
            assert!(errors_m.len() as u64 > SCANS - 5, "{samples_per_chip} {behind}");
            let scans = errors_m.len() as f64;
            let mean_m = errors_m.iter().sum::<f64>() / scans;
            let square = errors_m.iter().map(|error_m| error_m * error_m).sum::<f64>();
            let ratio = (square / scans).sqrt() / said_m;
            // Four standard errors of a standard deviation, and of a mean.
            let off = (mean_m - bias_m) / said_m;
            assert!(scatter.is_some() || off.abs() < 0.28, "{samples_per_chip} {behind}: {off}");
            let scatter = scatter.unwrap_or(0.8..1.2);
            assert!(scatter.contains(&ratio), "{samples_per_chip} {behind}: {ratio}");
        }
    }

    /// Against exact moments of each of the 16,376 steps, also under ten times as much light.
    #[test]
    fn few_steps_stand_for_a_long_scan() {
        for times in [1.0, 10.0] {
            let mut scene = load(Path::new("../scenes/paper-single.toml")).expect("it is valid");
            for source in &mut scene.sources {
                source.mean_power_w *= times;
            }
            let (sensor, tier) = (Sensor::new(&scene), CountingTier::Sampled);
            let detector = DetectorIndex(0);
            let bound = with_counts(&sensor, detector, tier, |counts| {
                bound_of(&sensor, detector, tier, counts)
            });
            let bound = bound.expect("there is one");
            let model = DetectorModel::new(&sensor, DetectorIndex(0));
            let response = MeanResponse::of_tier(&model, tier).expect("there is one");
            let second = SecondMoments::new(&response).expect("there are some");
            let light = Light::of(&model);
            let problem = Problem::of_scan(&model, tier);
            let parameters = FitParameters::of(&light);
            let jacobian =
                problem.jacobian(&parameters, &response, ResponseReading::Exact, Sides::Both);
            let exact = Weights::of(&second.of_scan());
            let exact = exact.information(&jacobian.expect("there is one")).expect("it is regular");
            let exact_m = distance_m(sensor.clock().ps(exact.standard_deviations()[0]));
            let ratio = bound.paths[0].slope_m / exact_m;
            assert!((ratio - 1.0).abs() < 3e-3, "{times}: {ratio}");
        }
    }
}
