//! The Cramer-Rao bound: how precise any unbiased estimator can be.

use std::sync::Arc;

use super::expected_counts::{ExpectedCounts, with_counts};
use super::fit::bins::BinFitter;
use super::fit::error::FitError;
use super::fit::moments::Moments;
use super::fit::moving;
use super::fit::normal::Normal;
use super::fit::parameters::{Column, Parameters, slope};
use super::fit::problem::{Beside, Problem, Reading, Sides, window};
use super::fit::template::Axis;
use super::fit::weights::Weights;
use super::phase::first_maximum;
use super::truth::Asked;
use super::{CountingTier, TheoryEffort, Work, coverage, distance_m};
use crate::response::{Light, MeanCount, MeanResponse};
use crate::scan::Step;
use crate::scene::{Architecture, DetectorIndex, PathIndex};
use crate::sensor::Sensor;

/// Where one slope of the counts reads another one nearby as less than this, or as more than its inverse, the standard
/// deviation that follows from a slope is not a measure of an estimate's scatter. Slopes on both sides of a tip of the
/// correlation read one another as less with 1 and 2 samples a chip. DESIGN.md has how estimates scatter there, and the
/// command that shows it.
const LEAST_EVEN: f64 = 0.7;

/// Slopes of the counts are compared over so many standard deviations, but no more than a phase step: the next corner
/// is that far.
const COMPARED_STDS: f64 = 5.0;

/// From so many samples a chip on corners are not looked at: there estimates scatter by at least 0.89 of what a slope
/// says.
const EVEN_SAMPLES: f64 = 4.0;

/// Up to so large a bound, in chips, bounds beside it are taken in.
const MOST_CHIPS_APART: f64 = 0.1;

/// How precise estimates from the counts of one scan can be.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// One entry per path that carries modulated light, in the scene's order.
    pub paths: Vec<PathBound>,
    /// Phase steps that take part: the whole scan, of a path that moves 3 S round its peak.
    pub steps: usize,
    /// Whether this is the maximum-likelihood estimate's standard deviation and no bound for others: of a
    /// histogram whose bins tell more of a delay on one side of the light's edges than on the other.
    pub of_likeliest: bool,
}

/// How precise the estimate of one path can be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathBound {
    /// Index of the path in the scene.
    pub path: PathIndex,
    /// Least standard deviation of its distance, with delay and strength of
    /// every path and the background unknown.
    pub bound_m: f64,
    /// Least standard deviation of the speed of a moving path, which is then unknown, too; the distance
    /// is that at the moment at which the scan passes the path.
    pub velocity_bound_m_per_s: Option<f64>,
}

impl Bound {
    /// Expected standard deviation of a fit that reports `std_m` for path `path`: its derivatives and
    /// second moments are those of light nearby, so that it may be off by 1 %, but it is not better than
    /// the bound.
    pub fn at_least(&self, path: PathIndex, std_m: f64) -> f64 {
        self.of_path(path).map_or(std_m, |bound_m| bound_m.max(std_m))
    }

    /// A remark for a bound that is not of all steps, or none for other estimators.
    pub fn remark(&self) -> Option<String> {
        if self.of_likeliest {
            return Some(
                "the standard deviation of the maximum-likelihood estimate: bins tell a delay \
                 unevenly, so that no one bound holds for every estimator"
                    .to_owned(),
            );
        }
        let moves = |path: &PathBound| path.velocity_bound_m_per_s.is_some();
        self.paths.iter().any(moves).then(|| {
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
) -> Result<Bound, FitError> {
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
fn bound_of_bins(sensor: &Sensor, detector: DetectorIndex) -> Result<Bound, FitError> {
    let fitter = BinFitter::new(sensor, detector)?;
    let (clock, scatter) = (sensor.clock(), fitter.scatter_chips()?);
    Ok(Bound {
        paths: vec![PathBound {
            path: fitter.path,
            bound_m: distance_m(clock.ps(scatter.law.std)),
            velocity_bound_m_per_s: None,
        }],
        steps: (sensor.timing().code_chips() * u64::from(clock.samples_per_chip)) as usize,
        of_likeliest: scatter.is_uneven(),
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
    let of = |bound: &Bound| match bound.paths[..] {
        [path] => Some((path.path, path.bound_m)),
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
) -> Option<Vec<Beside<'m>>> {
    let light = Light::of(response.model());
    let parameters = Parameters::of(&light);
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
) -> Result<Bound, FitError> {
    let light = Light::of(counts.model());
    if light.paths.is_empty() {
        return Err(FitError::Dark);
    }
    let problem = Problem::of_scan(counts.model(), tier);
    bound_of_problem(sensor, detector, &problem, &Parameters::of(&light), counts)
}

/// The bound of a path that moves, and of its speed.
fn bound_of_moving(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    moment_ps: f64,
) -> Result<Bound, FitError> {
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
    parameters: &Parameters,
    counts: &ExpectedCounts<'_, 'm>,
) -> Result<Bound, FitError> {
    let jacobian = match &counts.beside {
        None => problem.jacobian(parameters, counts.response, Reading::Exact, Sides::Both)?,
        Some(beside) => {
            let columns = beside.iter();
            let column = |side| problem.slope_between(parameters, side, Reading::Exact);
            columns.map(column).collect::<Result<_, _>>()?
        }
    };
    let axis = Axis::new(sensor, detector, problem.tier, &problem.steps);
    let means: Vec<_> = problem.steps.iter().map(|step| counts.means[step.index()]).collect();
    let moments = |few: &Problem| Ok::<_, FitError>(Arc::new(Moments::of(few, counts.second)));
    let weights = problem.weights(&axis, parameters, &means, None, moments)?;
    let (steps, unknowns) = (problem.steps.len(), parameters.len());
    let information = weights.information(&jacobian);
    let information = information.ok_or(FitError::Undetermined { steps, unknowns })?;
    let deviations = information.standard_deviations();
    if may_be_uneven(problem, parameters, counts.response) {
        let scene = (parameters, counts.response, &means[..]);
        check_even(problem, scene, &weights, (&jacobian, &deviations))?;
    }
    let velocity = parameters.walk_index().map(|walk| distance_m(1e12 * deviations[walk]));
    let paths = counts.model().modulated_paths().zip(deviations.chunks(2));
    let bound = |(path, deviations): (PathIndex, &[f64])| PathBound {
        path,
        bound_m: distance_m(sensor.clock().ps(deviations[0])),
        velocity_bound_m_per_s: velocity,
    };
    Ok(Bound { paths: paths.map(bound).collect(), steps, of_likeliest: false })
}

/// Whether the counts may change unevenly with a delay: only these scenes are looked at. What steps that count the same
/// light tell is [averaged], and a path that moves comes by every corner.
fn may_be_uneven(problem: &Problem, parameters: &Parameters, response: &MeanResponse) -> bool {
    let has_corners = problem.samples_per_chip() < EVEN_SAMPLES && !problem.shares_light();
    parameters.walk.is_none() && (response.misses_pulses() || has_corners)
}

/// Whether a fit to the scene's expected counts has the standard deviation that follows from their slopes.
///
/// # Errors
/// [`FitError::Uneven`] where it has not.
pub(super) fn check_scene_even(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    response: &MeanResponse,
) -> Result<(), FitError> {
    let problem = Problem::of_scan(response.model(), tier);
    if !may_be_uneven(&problem, &Parameters::of(&Light::of(response.model())), response) {
        return Ok(());
    }
    match bound(sensor, detector, tier) {
        Err(uneven @ FitError::Uneven { .. }) => Err(uneven),
        _ => Ok(()),
    }
}

/// Whether the counts change nearly evenly with each delay, some standard deviations to either side of the scene's:
/// without that no estimate is unbiased, and the bound is meaningless. The code's correlation has a corner at each
/// phase step, and pulses shorter than a sample leave stretches of delay between two samples in which the counts
/// hardly change. Compared are slopes to either side and at the scene's delay, with all else unknown.
fn check_even<'m>(
    problem: &Problem<'m>,
    (parameters, response, here): (&Parameters, &MeanResponse<'m>, &[MeanCount]),
    weights: &Weights,
    (jacobian, deviations): (&[Column], &[f64]),
) -> Result<(), FitError> {
    let means_at = |index: usize, later_chips: f64| -> Result<Column, FitError> {
        let mut moved = parameters.clone();
        moved.paths[index].delay_chips += later_chips;
        let response = match parameters.paths.len() {
            1 => response.delayed(problem.clock().ps(later_chips))?,
            _ => problem.response(&moved)?,
        };
        Ok(problem.means_of(&moved, &response)?)
    };
    for index in 0..parameters.paths.len() {
        let (delay, std_chips) = (2 * index, deviations[2 * index]);
        let apart = (COMPARED_STDS * std_chips).min(1.0 / problem.samples_per_chip());
        let earlier = slope(&means_at(index, -apart)?, here, apart);
        let later = slope(here, &means_at(index, apart)?, apart);
        let mut columns = weights.whitened_columns(jacobian);
        let slopes = [weights.whitened(&earlier), columns[delay].clone(), weights.whitened(&later)];
        for by in &slopes {
            columns[delay].clone_from(by);
            for of in &slopes {
                let read = Normal::of_whitened(&columns, of).map_or(0.0, |n| n.solution()[delay]);
                if !(LEAST_EVEN..=1.0 / LEAST_EVEN).contains(&read) {
                    let std_mm = distance_m(problem.clock().ps(std_chips)) * 1e3;
                    return Err(FitError::Uneven { std_mm, read });
                }
            }
        }
    }
    Ok(())
}

/// The Cramer-Rao bound of a path, in metres. It does not hold for counts that do not show the path, or
/// are clamped.
///
/// # Errors
/// Why there is none, in words.
pub fn bound_m(
    sensor: &Sensor,
    path: PathIndex,
    counting: CountingTier,
    bound: &Result<Bound, FitError>,
) -> Result<f64, String> {
    let bound = bound.as_ref().map_err(ToString::to_string)?;
    let detector = sensor.scene().paths[path].detector;
    let asked = Asked { sensor, detector, path, tier: counting };
    coverage::check_scene(&asked).map_err(|reason| reason.to_string())?;
    bound.of_path(path).ok_or_else(|| "the path carries no modulated light".to_owned())
}

/// The same for a report: the bound with its remark, or the reason why there is none.
pub fn bound_and_remark(
    sensor: &Sensor,
    path: PathIndex,
    counting: CountingTier,
    bound: &Result<Bound, FitError>,
) -> (Option<f64>, Option<String>) {
    match bound_m(sensor, path, counting, bound) {
        Ok(bound_m) => (Some(bound_m), bound.as_ref().ok().and_then(Bound::remark)),
        Err(reason) => (None, Some(format!("no bound: {reason}"))),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::estimate::fit::Fitter;
    use crate::photons::{DetectorModel, count_step};
    use crate::response::SecondMoments;
    use crate::scene::OtherLight;
    use crate::scene::{load, load_with};

    /// Fits to simulated photons of dim light so many phase steps behind a tip of the correlation: where there is a bound
    /// they scatter as it says, and where there is none not as the slope does, at a tip less and beside it more.
    #[test]
    fn there_is_a_bound_where_fits_scatter_as_slopes_say() {
        const SCANS: u64 = 200;
        let (detector, tier) = (DetectorIndex(0), CountingTier::Events);
        for (samples_per_chip, behind, scatter) in
            [(1, 0.0, Some(0.4..0.75)), (1, 0.1, Some(1.2..3.0)), (1, 0.3, None), (8, 0.0, None)]
        {
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
            let slope_m = match (&bound, &scatter) {
                (Ok(bound), None) => bound.paths[0].bound_m,
                (Err(FitError::Uneven { std_mm, .. }), Some(_)) => std_mm * 1e-3,
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
            let errors_m: Vec<f64> = (0..SCANS).map(error_m).collect();
            let square = errors_m.iter().map(|error_m| error_m * error_m).sum::<f64>();
            let ratio = (square / SCANS as f64).sqrt() / slope_m;
            // Four standard errors of a standard deviation.
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
            let parameters = Parameters::of(&light);
            let jacobian = problem.jacobian(&parameters, &response, Reading::Exact, Sides::Both);
            let exact = Weights::of(&second.of_scan());
            let exact = exact.information(&jacobian.expect("there is one")).expect("it is regular");
            let exact_m = distance_m(sensor.clock().ps(exact.standard_deviations()[0]));
            let ratio = bound.paths[0].bound_m / exact_m;
            assert!((ratio - 1.0).abs() < 3e-3, "{times}: {ratio}");
        }
    }
}
