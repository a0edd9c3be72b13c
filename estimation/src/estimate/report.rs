//! The estimate of one detector beside the truth and what theory expects.

use std::sync::OnceLock;

use serde::Serialize;

use super::bound::{BoundKind, bound_and_remark};
use super::chance::{DOUBTFUL, Darkness, NO_PEAK};
use super::coverage;
use super::estimator::{Estimated, Estimator, EstimatorInput};
use super::evidence::{Comparisons, Evidence, Expectation, ExpectedErrors};
use super::fit::{ALARM_SIGMAS, FittedPath, ModelEstimate, shared_light};
use super::histogram;
use super::theory::covered;
use super::truth::Asked;
use super::unwrap::{check_normal, fold, fold_distance};
use super::{
    CountingTier, Prediction, Theory, delay_error_ps, distance_m, folded, share_error, theory,
    tolerance_ps, true_delay,
};
use crate::histogram::Histogram;
use crate::photons::StepCount;
use crate::scene::{DetectorIndex, EstimatorKind, PathIndex};
use crate::sensor::Sensor;

/// A share of misses that is not told.
pub const SELDOM: f64 = 1e-3;

/// The distance that a scan's counts give.
#[derive(Debug, Clone, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct EstimateReport {
    /// The detector's name.
    pub detector: String,
    /// The source whose light it ranges.
    pub source: String,
    /// How the distance was obtained from the counts.
    pub estimator: EstimatorKind,
    /// Index of the path that the estimate is compared with: of all paths of its
    /// reference's source, the nearest to the estimate; without an estimate the
    /// first.
    pub path: Option<PathIndex>,
    /// The estimate; null if the counts do not have a peak, or no modulated light could
    /// have caused one, or scans without any have as large counts too often.
    pub distance_m: Option<f64>,
    /// Share of scans without any light of the source in which some count is as large as what the estimate
    /// rests on ([`crate::estimate::chance`]); null without hits, and where counts may saturate. From 0.02
    /// on there is no estimate.
    pub chance_fraction: Option<f64>,
    /// That path's distance, folded into the unambiguous range.
    pub true_distance_m: Option<f64>,
    /// When a moving path has it, from the start of the scan: when the scan passes
    /// the path. Null for a path at rest.
    pub true_distance_at_s: Option<f64>,
    /// Estimate less truth, the shorter way round the unambiguous range.
    pub error_m: Option<f64>,
    /// The estimator's bias on the exact mean counts of this scene (for the
    /// phase: range walk, interference, circular error).
    pub expected_bias_m: Option<f64>,
    /// Its standard deviation from the counts' variances; of the model estimator no less
    /// than the bound.
    pub expected_std_m: Option<f64>,
    /// Share of scans that [miss](crate::estimate::missed) the path, of which bias and standard deviation are not: null without an
    /// expectation, and of a fit where the phase misses one scan in a thousand at most, as the fit then does, or where it is not
    /// known.
    pub expected_missed_fraction: Option<f64>,
    /// (error - expected bias) / expected standard deviation.
    pub deviation_in_std: Option<f64>,
    /// Whether the estimate agrees with its expectation, at a significance level of 1 in 10,000
    /// ([`crate::estimate::evidence`]); null without an expectation. A contradiction is described
    /// in `remark`.
    pub expectation_holds: Option<bool>,
    /// Least standard deviation of an estimate from these counts ([`crate::estimate::bound`]).
    pub bound_m: Option<f64>,
    /// What `bound_m` is; null without one.
    pub bound_kind: Option<BoundKind>,
    /// `expected_std_m` over `bound_m`.
    pub std_over_bound: Option<f64>,
    /// Why there is no bound, or which steps it is of if not all.
    pub bound_remark: Option<String>,
    /// The fit behind the estimate; null for the phase estimator.
    pub fit: Option<FitReport>,
    /// Phase step of the largest count.
    pub coarse_phase_step: Option<u64>,
    /// Subtracted from the measured delay: everything constant that is not time of flight.
    pub calibration_offset_ps: f64,
    /// Distance beyond which the code repeats.
    pub unambiguous_range_m: f64,
    /// Why there is no estimate, or only a coarse one, or no expectation.
    pub remark: Option<String>,
    /// Of a path beyond the unambiguous range: that its distance is folded into it.
    pub folded: Option<String>,
}

/// What the model estimator reports besides the distance.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FitReport {
    /// Every path that was fitted, the strongest of the detector's source first.
    pub paths: Vec<FittedPathReport>,
    /// Primary rate of all light that is not modulated, dark counts included.
    pub unmodulated_primary_rate_cps: f64,
    /// Weighted sum of squared residuals.
    pub chi_square: f64,
    /// What it is expected to be.
    pub degrees_of_freedom: usize,
    /// How many standard deviations it is above that.
    pub chi_square_excess_in_std: f64,
    /// Whether that is too much: the light or the detector is not as modelled.
    pub alarm: bool,
    /// Speed of the path's distance, positive away from the sensor; none of light that stands
    /// still.
    pub velocity_m_per_s: Option<f64>,
    /// Its standard deviation, by the fit itself.
    pub velocity_std_m_per_s: Option<f64>,
    /// Phase steps that took part.
    pub phase_steps: usize,
}

/// One path of a fit.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FittedPathReport {
    /// The source with this path's code; none if the scene has no such source.
    pub source: Option<String>,
    /// Distance, folded into the unambiguous range.
    pub distance_m: f64,
    /// Its standard deviation, by the fit itself.
    pub distance_std_m: f64,
    /// Primary rate that on-chips add.
    pub primary_rate_cps: f64,
    /// That rate in its standard deviations.
    pub significance_in_std: f64,
}

/// A detector's scans beside the truth and what theory expects of them: what follows from the scene
/// alone is worked out once, when a scan first asks for it.
#[derive(Debug)]
pub struct Reporter<'s> {
    estimator: Estimator<'s>,
    /// Of each path of the scene: theory of it, and what is expected of counts of phase steps and of
    /// bins.
    theories: Vec<OnceLock<Theory>>,
    expectations: Vec<[OnceLock<ExpectedOfPath>; 2]>,
    is_compared: bool,
}

/// What the scene's estimator is expected to say of a path, and the share of scans that miss it,
/// where that is known, with its error; or why nothing is expected.
pub type ExpectedOfPath = Result<(ExpectedErrors, Option<(f64, f64)>), String>;

impl<'s> Reporter<'s> {
    /// Of scans of detector `detector`.
    pub fn new(sensor: &'s Sensor, detector: DetectorIndex) -> Reporter<'s> {
        let paths = sensor.scene().paths.len();
        Reporter {
            estimator: Estimator::new(sensor, detector, CountingTier::Sampled),
            theories: (0..paths).map(|_| OnceLock::new()).collect(),
            expectations: (0..paths).map(|_| Default::default()).collect(),
            is_compared: true,
        }
    }

    /// Without bound and expectation, which take longer than all else.
    #[must_use]
    pub fn without_theory(mut self) -> Reporter<'s> {
        self.is_compared = false;
        self
    }

    /// With the theory of sampled counts of a path, as [`theory`] gives it for that path alone: neither the
    /// estimator nor other detectors change it.
    #[must_use]
    pub fn knowing(mut self, path: PathIndex, theory: Theory) -> Reporter<'s> {
        self.theories[path.0] = theory.into();
        self
    }

    /// With what counts would be without the own light, as another estimator of the same scans knows it.
    #[must_use]
    pub fn knowing_darkness(mut self, darkness: &Darkness) -> Reporter<'s> {
        self.estimator = self.estimator.knowing_darkness(darkness);
        self
    }

    /// With what [`Reporter::expectation`] says of a path.
    #[must_use]
    pub fn expecting(
        mut self,
        path: PathIndex,
        of_steps: bool,
        is: ExpectedOfPath,
    ) -> Reporter<'s> {
        self.expectations[path.0][usize::from(of_steps)] = is.into();
        self
    }

    /// The distance that the counts of one scan give, those of the steps in order, with the scene's
    /// estimator; fewer than the scan's steps give none.
    pub fn scan(&self, counts: &[StepCount]) -> EstimateReport {
        let steps = self.estimator.sensor.timing().scan.steps;
        if (counts.len() as u64) < steps {
            let mut report = self.without_estimate();
            let measured = counts.len();
            report.add_remark(&format!(
                "no estimate: {measured} of the scan's {steps} phase steps were measured"
            ));
            return report;
        }
        self.report(EstimatorInput::Steps(counts))
    }

    /// The distance that a histogram gives, with the scene's estimator.
    ///
    /// # Panics
    /// If the histogram has not one bin per sample of the detector's code.
    pub fn histogram(&self, histogram: &Histogram) -> EstimateReport {
        self.report(EstimatorInput::Bins(histogram))
    }

    /// The same without counts: what is expected of the estimator against the first path.
    pub fn expected(&self) -> EstimateReport {
        let mut report = self.without_estimate();
        match self.estimator.check_modulated() {
            Err(reason) => report.remark = Some(format!("no estimate: {reason}")),
            Ok(()) => self.compare(&mut report, None, false),
        }
        report
    }

    fn without_estimate(&self) -> EstimateReport {
        let scene = self.estimator.sensor.scene();
        let spad = &scene.detectors[self.estimator.detector];
        EstimateReport {
            detector: spad.name.clone(),
            source: scene.sources[spad.reference].name.clone(),
            estimator: scene.estimator,
            calibration_offset_ps: self.estimator.offset_ps,
            unambiguous_range_m: distance_m(self.estimator.sensor.timing().code_period_ps()),
            ..EstimateReport::default()
        }
    }

    /// The estimator's answer, with truth and expectation beside it.
    fn report(&self, counted: EstimatorInput) -> EstimateReport {
        let mut report = self.without_estimate();
        let of_steps = matches!(counted, EstimatorInput::Steps(_));
        let modulated = self.estimator.check_modulated();
        let walks = modulated.is_ok().then(|| self.estimator.walks(of_steps)).flatten();
        let measured_ps = modulated.map_err(|reason| reason.to_string()).and_then(|()| {
            self.check_chance(&mut report, counted)?;
            let found = self.estimator.answer(counted).map_err(|reason| reason.to_string())?;
            Ok(report.take(self.estimator.sensor, self.estimator.detector, &found, of_steps))
        });
        if let Err(reason) = &measured_ps {
            report.add_remark(&format!("no estimate: {reason}"));
        }
        if let Some(walks) = walks {
            report.add_remark(&format!("range walk is left in: {walks}"));
        }
        self.compare(&mut report, measured_ps.ok(), of_steps);
        report
    }

    /// Whether a scan without the own light has counts as large: then there is no estimate.
    fn check_chance(
        &self,
        report: &mut EstimateReport,
        counted: EstimatorInput,
    ) -> Result<(), String> {
        report.chance_fraction = self.estimator.chance(counted);
        let Some(fraction) = report.chance_fraction.filter(|&fraction| fraction >= DOUBTFUL) else {
            return Ok(());
        };
        let as_large = format!(
            "{:.1} % of scans without any light of \"{}\" have as large counts",
            fraction * 1e2,
            report.source
        );
        if fraction >= NO_PEAK {
            return Err(as_large);
        }
        report.add_remark(&format!("the peak may be chance: {as_large}"));
        Ok(())
    }

    /// Puts truth and expectation beside the time of flight, if there is one; `of_steps` where it
    /// is of phase steps' counts.
    fn compare(&self, report: &mut EstimateReport, measured_ps: Option<f64>, of_steps: bool) {
        let Estimator { sensor, detector, tier, .. } = self.estimator;
        let code_period_ps = sensor.timing().code_period_ps();
        let truth = |p: PathIndex| true_delay(sensor, p, tier);
        let error_ps = |p: PathIndex| {
            let true_ps = truth(p).delay_ps;
            delay_error_ps(measured_ps.unwrap_or(true_ps), true_ps, code_period_ps)
        };
        let own_paths = sensor.scene().own_paths(detector);
        report.path = own_paths.min_by(|&a, &b| error_ps(a).abs().total_cmp(&error_ps(b).abs()));
        let Some(path) = report.path else { return };
        let truth = truth(path);
        let true_ps = fold_distance(truth.delay_ps, code_period_ps);
        report.true_distance_m = Some(distance_m(true_ps));
        report.true_distance_at_s = truth.at_ps.map(|ps| ps * 1e-12);
        report.error_m = measured_ps.map(|_| distance_m(error_ps(path)));
        report.folded = folded(sensor, path);
        if !self.is_compared {
            return;
        }
        let theory = self.theory(path);
        (report.bound_m, report.bound_kind, report.bound_remark) =
            bound_and_remark(sensor, path, tier, &theory.bound);
        match self.expectation(path, of_steps) {
            Ok((errors, missed)) => {
                report.expected_missed_fraction = missed.map(|(share, _)| share);
                report.hold_against(sensor, *errors, *missed);
            }
            Err(reason) => report.add_remark(&format!("no expectation: {reason}")),
        }
        let ratio = report.expected_std_m.zip(report.bound_m);
        report.std_over_bound = ratio.map(|(std_m, bound_m)| std_m / bound_m);
    }

    /// Theory of sampled counts of a path; of the scene's estimator.
    pub fn theory(&self, path: PathIndex) -> &Theory {
        let Estimator { sensor, detector, tier, .. } = self.estimator;
        let paths: &[PathIndex] = match sensor.scene().estimator {
            EstimatorKind::Fft => &[path],
            // The fit's expectation is its own.
            EstimatorKind::Model => &[],
        };
        self.theories[path.0].get_or_init(|| theory(sensor, detector, paths, tier))
    }

    /// What is expected of estimates against a path, from counts of phase steps or from bins: counts do not
    /// change it.
    pub fn expectation(&self, path: PathIndex, of_steps: bool) -> &ExpectedOfPath {
        let expected = &self.expectations[path.0][usize::from(of_steps)];
        expected.get_or_init(|| self.expect(path, of_steps))
    }

    fn expect(&self, path: PathIndex, of_steps: bool) -> ExpectedOfPath {
        let Estimator { sensor, detector, .. } = self.estimator;
        let (ExpectedErrors { bias_m, std_m }, missed) = match sensor.scene().estimator {
            EstimatorKind::Fft => self.expected_phase(path, of_steps)?,
            EstimatorKind::Model => {
                let missed = self.missed_by_fit(path);
                let missed = missed.map(|share| (share, share_error(sensor, share, false)));
                (self.expected_fit(path)?, missed)
            }
        };
        let delay_std_ps = sensor.scene().detectors[detector].delay_std_ps;
        let std_m = std_m.hypot(distance_m(delay_std_ps));
        Ok((ExpectedErrors { bias_m, std_m }, missed))
    }

    fn expected_phase(&self, path: PathIndex, of_steps: bool) -> ExpectedOfPath {
        let Estimator { sensor, detector, tier, .. } = self.estimator;
        let of_its_steps;
        let expected = match of_steps && self.estimator.is_histogram() {
            true => {
                let asked = Asked { sensor, detector, path, tier };
                of_its_steps = covered(&asked, histogram::predict(&asked, true));
                &of_its_steps
            }
            false => &self.theory(path).predictions[0],
        };
        let expected = expected.as_ref().map_err(ToString::to_string)?;
        let range_m = distance_m(sensor.code_period_of_path_ps(path));
        check_normal(expected.std_m, range_m).map_err(|spread| spread.to_string())?;
        let Prediction { bias_m, std_m, missed_fraction, is_drawn, .. } = *expected;
        let missed = missed_fraction.map(|share| (share, share_error(sensor, share, is_drawn)));
        Ok((ExpectedErrors { bias_m, std_m }, missed))
    }

    /// The share of scans of which the fit misses a path; `None` where the phase does so seldom.
    fn missed_by_fit(&self, path: PathIndex) -> Option<f64> {
        let Estimator { sensor, detector, tier, .. } = self.estimator;
        let by_phase = self.theory(path).missed.first().copied().flatten();
        match by_phase {
            Some(share) if share <= SELDOM => None,
            _ => *theory(sensor, detector, &[path], tier).missed.first()?,
        }
    }

    fn expected_fit(&self, path: PathIndex) -> Result<ExpectedErrors, String> {
        let Estimator { sensor, detector, tier, .. } = self.estimator;
        let fitted = self.estimator.expected_fit().map_err(|e| e.to_string())?;
        let code = &sensor.scene().sources[sensor.scene().paths[path].source].code;
        let code_period_ps = sensor.code_period_of_path_ps(path);
        let true_ps = true_delay(sensor, path, tier).delay_ps;
        let error_ps =
            |fitted: &FittedPath| delay_error_ps(fitted.delay_ps, true_ps, code_period_ps);
        let nearest = fitted
            .paths
            .iter()
            .filter(|fitted| fitted.code.chips == code.chips)
            .min_by(|a, b| error_ps(a).abs().total_cmp(&error_ps(b).abs()));
        let nearest = nearest.ok_or("the expected counts do not show the path")?;
        let [bias_m, std_m] = [error_ps(nearest), nearest.delay_std_ps].map(distance_m);
        let errors = ExpectedErrors { bias_m, std_m };
        let bound = self.theory(path).bound.as_ref();
        let errors =
            bound.map_or(errors, |bound| bound.errors_of_fit(path, errors, fitted.paths.len()));
        let covered = coverage::check_fit(sensor, detector, path, tier, (&fitted, errors));
        covered.map(|()| errors).map_err(|reason| reason.to_string())
    }
}

impl EstimateReport {
    /// Takes the estimator's answer: the delay, in ps.
    fn take(
        &mut self,
        sensor: &Sensor,
        detector: DetectorIndex,
        found: &Estimated,
        of_steps: bool,
    ) -> f64 {
        match found {
            Estimated::Phase(estimate) => {
                self.distance_m = Some(estimate.distance_m);
                self.coarse_phase_step = Some(estimate.coarse_step);
                if let Some(reason) = estimate.coarse_only {
                    self.add_remark(&format!("coarse estimate only: {reason}"));
                }
                estimate.delay_ps
            }
            Estimated::Fit(fitted) => {
                self.distance_m = Some(fitted.distance_m);
                self.fit = Some(FitReport::of(sensor, fitted));
                let shared = of_steps.then(|| shared_light(sensor, detector)).flatten();
                let untold = fitted.untold.as_ref().map(ToString::to_string);
                shared.into_iter().chain(untold).for_each(|remark| self.add_remark(&remark));
                fitted.delay_ps
            }
        }
    }

    /// Holds the one scan against what is expected of it.
    fn hold_against(
        &mut self,
        sensor: &Sensor,
        errors: ExpectedErrors,
        missed: Option<(f64, f64)>,
    ) {
        let ExpectedErrors { bias_m, std_m } = errors;
        self.expected_bias_m = Some(bias_m);
        self.expected_std_m = Some(std_m);
        let Some(error_m) = self.error_m else { return };
        self.deviation_in_std = Some(fold(error_m - bias_m, self.unambiguous_range_m) / std_m);
        let chip_ps = sensor.clock().chip_period_ps;
        let tolerance_m = distance_m(tolerance_ps(chip_ps, sensor.timing().code_period_ps()));
        let is_missed = error_m.abs() > tolerance_m;
        // An estimate elsewhere does not belong to any path, and is not an error of this one.
        let found = [error_m];
        let evidence = Evidence {
            errors_m: if is_missed { &[] } else { &found },
            scans: 1,
            missed: u64::from(is_missed),
            range_m: self.unambiguous_range_m,
        };
        let paths = sensor.scene().paths.len();
        let expected = Expectation { errors: Some(errors), missed };
        let told = Comparisons::of_paths(paths).contradictions(&evidence, &expected);
        match told {
            Some(told) if !told.is_empty() => {
                self.expectation_holds = Some(false);
                self.add_remark(&format!("the expectation does not hold: {}", told.join("; ")));
            }
            // A single scan that misses what is seldom missed bears nothing out.
            _ if is_missed => self.add_remark(
                "the estimate does not belong to any of the scene's paths, and is not compared with the \
                 expectation",
            ),
            Some(_) => self.expectation_holds = Some(true),
            None => {}
        }
    }

    /// Adds to what is remarked on already.
    pub fn add_remark(&mut self, remark: &str) {
        let before = self.remark.take().map(|before| before + "; ");
        self.remark = Some(before.unwrap_or_default() + remark);
    }
}

impl FitReport {
    fn of(sensor: &Sensor, fitted: &ModelEstimate) -> FitReport {
        let of_path = |path: &FittedPath| FittedPathReport {
            source: sensor
                .scene()
                .sources
                .iter()
                .find(|source| source.code.chips == path.code.chips)
                .map(|source| source.name.clone()),
            distance_m: distance_m(path.delay_ps),
            distance_std_m: distance_m(path.delay_std_ps),
            primary_rate_cps: path.rate_hz,
            significance_in_std: path.significance(),
        };
        FitReport {
            paths: fitted.paths.iter().map(of_path).collect(),
            unmodulated_primary_rate_cps: fitted.constant_rate_hz,
            chi_square: fitted.chi_square,
            degrees_of_freedom: fitted.degrees_of_freedom,
            chi_square_excess_in_std: fitted.alarm_sigmas(),
            alarm: fitted.alarm_sigmas() > ALARM_SIGMAS,
            velocity_m_per_s: fitted.velocity.map(|velocity| velocity.m_per_s),
            velocity_std_m_per_s: fitted.velocity.map(|velocity| velocity.std_m_per_s),
            phase_steps: fitted.steps,
        }
    }
}
