//! From counts to a fit: of one path, or of all light.

use std::sync::OnceLock;

use super::air::{self, Air, own_threshold};
use super::error::FitError;
use super::folds_over;
use super::joint;
use super::known_moments::KnownMoments;
use super::model_estimate::ModelEstimate;
use super::moving;
use super::one_path::OnePathFit;
use super::parameters::FitParameters;
use super::problem::{Problem, window};
use super::scoring::likeliest_of;
use super::slipping::SlippingLight;
use super::start::{self, PeakShape};
use super::template::DelayAxis;
use crate::estimate::bound::{averaged, check_scene_even};
use crate::estimate::{CountingTier, NoEstimate, TheoryEffort, Work, coverage, distance_m};
use crate::photons::{DetectorModel, StepCount};
use crate::response::{MeanCount, MeanResponse};
use crate::scan::Step;
use crate::scene::{DetectorIndex, OtherLight};
use crate::sensor::Sensor;

/// Phase steps from a fit to the places from which one of steps whose scatter goes together is tried
/// again.
const NEIGHBOURS: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];

/// Fits the scans of one detector. Second moments that one scan needed are kept for
/// the next; what a scan gives does not depend on which came before.
#[derive(Debug)]
pub struct Fitter<'s> {
    sensor: &'s Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    other: OtherLight,
    /// Of a path that moves, one that stands still as it does at the moment.
    model: DetectorModel,
    /// The moment that a moving path's distance refers to.
    moment_ps: Result<Option<f64>, FitError>,
    /// Seconds that a fit takes, and the limit, if it takes longer.
    too_long: OnceLock<Option<(f64, f64)>>,
    moments: KnownMoments,
    /// What the only path looks like in the counts, where light of other clocks does not make that depend on how many they are.
    shape: OnceLock<PeakShape>,
    air: OnceLock<Result<Air, FitError>>,
}

impl<'s> Fitter<'s> {
    /// A fitter for scans of detector `detector`.
    pub fn new(
        sensor: &'s Sensor,
        detector: DetectorIndex,
        tier: CountingTier,
        other: OtherLight,
    ) -> Fitter<'s> {
        let moment_ps = moving::moment_ps(sensor, detector, tier, other);
        Fitter {
            sensor,
            detector,
            tier,
            other,
            model: match moment_ps {
                Ok(Some(moment_ps)) => DetectorModel::new(&sensor.still_at(moment_ps), detector),
                _ => DetectorModel::new(sensor, detector),
            },
            moment_ps,
            too_long: OnceLock::new(),
            moments: KnownMoments::default(),
            shape: OnceLock::new(),
            air: OnceLock::new(),
        }
    }

    /// The moment that a moving path's distance refers to, from the start of the scan;
    /// `None` for light at rest.
    ///
    /// # Errors
    /// If it moves in a way that the fit does not model.
    pub fn moment_ps(&self) -> Result<Option<f64>, FitError> {
        self.moment_ps.clone()
    }

    /// Fits the counts of one scan.
    ///
    /// One path starts from the phase at the place where all counts look most like its code's
    /// light, and the rate of detections. More light starts from background alone:
    /// see [`joint`](super::joint).
    ///
    /// # Errors
    /// When the counts have no peak, or do not suffice for the unknowns, or the
    /// mean response cannot be had.
    pub fn fit(&self, counts: &[StepCount]) -> Result<ModelEstimate, FitError> {
        let counts: Vec<MeanCount> = counts
            .iter()
            .map(|count| MeanCount { signed: count.signed as f64, total: count.total as f64 })
            .collect();
        self.fit_means(&counts)
    }

    /// Fits the scene's expected counts: the mean of fits to scans, to first order in the noise.
    ///
    /// # Errors
    /// As [`Fitter::fit`].
    pub fn expected(&self) -> Result<ModelEstimate, FitError> {
        let (sensor, detector, tier) = (self.sensor, self.detector, self.tier);
        let moment_ps = self.moment_ps()?;
        TheoryEffort::of(sensor, detector)?.check(Work::Fit)?;
        let response = MeanResponse::of_tier(&self.model, tier)?;
        // A fit settles everywhere, but its average is not always that of the average.
        check_scene_even(sensor, detector, tier, &response)?;
        let mut means = response.mean_counts();
        if let Some(moment_ps) = moment_ps {
            moving::take_movement(sensor, &response, tier, moment_ps, &mut means)?;
        }
        if self.fits_one_path() && self.slipping()?.is_some() {
            let (problem, settled) = self.one_path(&means)?;
            // A fit's own covariance is of one slope of the counts, which scatter that goes together makes tell less of the
            // delay on one side than on the other.
            let scatter = settled.scatter(&problem)?;
            coverage::of_one_peak(scatter.law.std).check()?;
            let fitted = self.estimate(&problem, &settled)?;
            return Ok(fitted.scattered_by(sensor.clock(), scatter.law));
        }
        let mut fitted = self.fit_means(&means)?;
        // A fit's own covariance is of light up to a phase step's fraction away, which says too little
        // where steps share their light.
        let shares_light = sensor.timing().parallel > 1 && fitted.paths.len() == 1;
        if let Some(std_m) = shares_light.then(|| averaged(sensor, detector, tier)).flatten() {
            fitted.std_m = std_m;
            fitted.paths[0].delay_std_ps = std_m / distance_m(1.0);
        }
        Ok(fitted)
    }

    /// The same for counts that need not be whole, one per step of the scan.
    ///
    /// # Errors
    /// As [`Fitter::fit`].
    pub fn fit_means(&self, counts: &[MeanCount]) -> Result<ModelEstimate, FitError> {
        let (sensor, detector) = (self.sensor, self.detector);
        if counts.len() as u64 != sensor.timing().scan.steps {
            return Err(FitError::WrongNumberOfCounts {
                found: counts.len(),
                steps: sensor.timing().scan.steps,
            });
        }
        // A path that moves in a way that the fit does not model.
        self.moment_ps()?;
        self.check_time()?;
        if self.fits_one_path() {
            let (problem, settled) = self.one_path(counts)?;
            return self.estimate(&problem, &settled);
        }
        check_not_flat(counts)?;
        let problem = Problem::of_scan(&self.model, self.tier);
        let air = self.air.get_or_init(|| air::look_for(sensor, detector, self.other, &problem));
        let air = air.as_ref().map_err(Clone::clone)?;
        let found = joint::all_light(air, &problem, &self.moments, counts)?;
        folds_over(&self.model, found.hypothesis.parameters.brightest()).check()?;
        Ok(found.estimate(air, &problem))
    }
}

impl Fitter<'_> {
    /// Whether one path is all that may be there.
    fn fits_one_path(&self) -> bool {
        air::is_one_path(self.sensor, &self.model, self.other)
    }

    /// Light of other clocks beside a path at rest.
    fn slipping(&self) -> Result<Option<&SlippingLight>, FitError> {
        if self.moment_ps()?.is_some() {
            return Ok(None);
        }
        Ok(self.moments.slipping(&Problem::of_scan(&self.model, self.tier))?)
    }

    /// The step at which all counts look most like the path's.
    fn best_match(&self, signed: &[f64], counts: &[MeanCount]) -> Result<usize, FitError> {
        let timing = self.sensor.timing();
        let Some(slipping) = self.slipping()? else {
            let shape = self.shape.get_or_init(|| PeakShape::of(self.sensor, self.detector, None));
            return Ok(shape.best_match(signed).0);
        };
        // Of constant light a count's variance is the number of detections.
        let detections = counts.iter().map(|count| count.total).sum::<f64>() / counts.len() as f64;
        let beside = |apart: usize| slipping.covariance_apart(timing, apart) / detections.max(1.0);
        Ok(PeakShape::of(self.sensor, self.detector, Some(&beside)).best_match(signed).0)
    }

    /// The fit of the only path, at rest or moving.
    fn one_path(&self, counts: &[MeanCount]) -> Result<(Problem<'_>, OnePathFit<'_>), FitError> {
        let (sensor, detector, tier) = (self.sensor, self.detector, self.tier);
        let scan = &sensor.timing().scan;
        let signed: Vec<f64> = counts.iter().map(|count| count.signed).collect();
        let peak = self.best_match(&signed, counts)?;
        let start = start::start(sensor, detector, tier, counts, (&signed, peak))?;
        let peak = Step::at(peak);
        let round_peak = window(scan, sensor.clock().samples_per_chip, peak);
        let mut problem = Problem::of_scan(&self.model, tier);
        let moment_ps = self.moment_ps()?;
        if let Some(moment_ps) = moment_ps {
            problem.steps = moving::in_one_go(&round_peak, peak);
            problem.moment_ps = moment_ps;
        } else if self.slipping()?.is_some() {
            problem.steps = round_peak;
        }
        let axis = DelayAxis::new(sensor, detector, tier, &problem.steps);
        let start = FitParameters { walk: moment_ps.map(|_| 0.0), ..start };
        let settled = self.likeliest(&problem, &axis, start, counts)?;
        Ok((problem, settled))
    }

    /// What a fit of the only path says.
    fn estimate(&self, problem: &Problem, settled: &OnePathFit) -> Result<ModelEstimate, FitError> {
        let limit = problem.most_walk();
        if settled.end.parameters.walk.is_some_and(|walk| walk.abs() >= 0.999 * limit) {
            return Err(FitError::TooFast { limit_m_per_s: distance_m(1e12 * limit) });
        }
        folds_over(&self.model, settled.end.parameters.brightest()).check()?;
        let estimate = settled.estimate(problem);
        if self.slipping()?.is_some() {
            self.check_stands_out(problem, &estimate)?;
        }
        Ok(estimate)
    }

    /// Refuses own light that does not exceed the scatter that light of other clocks adds to
    /// the counts: its largest correlation looks like a path.
    fn check_stands_out(
        &self,
        problem: &Problem,
        estimate: &ModelEstimate,
    ) -> Result<(), FitError> {
        let chips = self.sensor.timing().scan.steps as f64 / problem.samples_per_chip();
        let (sigmas, needed) = (estimate.paths[0].significance(), own_threshold(chips));
        match sigmas < needed {
            true => Err(FitError::OwnNotSeen { sigmas, needed }),
            false => Ok(()),
        }
    }

    /// Refuses what would take too long. Light whose time cannot be estimated does not have a response
    /// either, and the fit reports why.
    fn check_time(&self) -> Result<(), FitError> {
        let too_long = |sensor| TheoryEffort::of(sensor, self.detector).ok()?.too_long_fit();
        match *self.too_long.get_or_init(|| too_long(self.sensor)) {
            Some((seconds, limit_s)) => Err(FitError::TooLong { seconds, limit_s }),
            None => Ok(()),
        }
    }

    /// The fit from a start. The information of steps of shared light, and of those whose scatter other clocks' light makes go
    /// together, depends on where between two
    /// steps the path is, so that a fit may settle in the wrong place: there the likeliest of the fits
    /// from the first one's end and from its neighbours is taken.
    fn likeliest<'m>(
        &self,
        problem: &Problem<'m>,
        axis: &DelayAxis,
        start: FitParameters,
        counts: &[MeanCount],
    ) -> Result<OnePathFit<'m>, FitError> {
        let settle =
            |start: FitParameters| OnePathFit::new(problem, axis, &self.moments, start, counts);
        let first = settle(start)?;
        let settled = &first.end.parameters;
        let goes_together = problem.shares_light() || self.slipping()?.is_some();
        if !goes_together || settled.walk.is_some() {
            return Ok(first);
        }
        let step_chips = self.sensor.clock().sample_period_chips();
        let others = NEIGHBOURS.map(|steps| settle(settled.later(steps * step_chips)));
        likeliest_of(Ok(first), others, OnePathFit::unlikelihood)
    }
}

/// Refuses counts that are all equal: they do not have a peak.
fn check_not_flat(counts: &[MeanCount]) -> Result<(), NoEstimate> {
    let first = counts.first().map_or(0.0, |count| count.signed);
    let is_dark = counts.iter().all(|count| count.total <= 0.0);
    match is_dark || counts.iter().all(|count| count.signed == first) {
        true => Err(NoEstimate::Flat { count: first as i64 }),
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::estimate::bound::bound;
    use crate::photons::count_step;
    use crate::scan::Step;
    use crate::scene::{PathIndex, load_with};

    /// Photons of dim light, counted for long: fits scatter as they say, as is expected and nearly as
    /// the bound, and chi-square is its degrees of freedom. (A fit starts from a node of the light,
    /// and even the dimmest node is far brighter than this.)
    #[test]
    fn fits_of_dim_light_scatter_as_they_say() {
        for (power_pw, integration_ms, dead_time_ns, dark_kcps) in [
            (0.05, 8, 0, 71),
            (0.02, 20, 5, 71),
            (0.02, 20, 14, 71),
            (0.1, 4, 50, 0),
            (0.002, 60, 2, 1),
            (1.0, 1, 0, 71),
        ] {
            let settings = [
                "estimate.estimator=model".to_owned(),
                "scan.steps={ around = \"3.2 m\", halfwidth = 12 }".to_owned(),
                "detector.afterpulsing.probability=0".to_owned(),
                format!("source.mean_power={power_pw} pW"),
                format!("scan.integration={integration_ms} ms"),
                format!("detector.dead_time={dead_time_ns} ns"),
                format!("detector.dark_count_rate={dark_kcps} kcps"),
            ];
            let settings = settings.map(|setting| setting.parse().expect("a setting"));
            let scene = load_with(Path::new("../scenes/quick.toml"), &settings).expect("sound");
            let (sensor, tier) = (Sensor::new(&scene), CountingTier::Events);
            let model = DetectorModel::new(&sensor, DetectorIndex(0));
            let fitter = Fitter::new(&sensor, DetectorIndex(0), tier, OtherLight::None);
            let scans = 150;
            let [mut errors, mut squares, mut stated, mut chi_square] = [0.0; 4];
            let mut degrees = 0.0;
            for scan in 0..scans {
                let steps = Step::all(sensor.timing().scan.steps);
                let counts: Vec<_> = steps.map(|step| count_step(&model, 5, scan, step)).collect();
                let fitted = fitter.fit(&counts).expect("it fits");
                let error = fitted.distance_m - 3.2;
                errors += error;
                squares += error * error;
                stated += fitted.std_m;
                chi_square += fitted.chi_square;
                degrees = fitted.degrees_of_freedom as f64;
            }
            let of = format!("{power_pw} pW, {integration_ms} ms, {dead_time_ns} ns");
            let scans = scans as f64;
            let (std, stated) = ((squares / scans).sqrt(), stated / scans);
            let within = |what: &str, sigmas: f64| {
                assert!(sigmas.abs() < 4.0, "{of}: {what} is {sigmas} standard errors off");
            };
            within("bias", errors / scans.sqrt() / std);
            within("stated", (std / stated - 1.0) * (2.0 * scans).sqrt());
            within("chi-square", (chi_square / scans - degrees) * (scans / (2.0 * degrees)).sqrt());
            let expected = fitter.expected().expect("there is an expectation").std_m;
            within("expected", (std / expected - 1.0) * (2.0 * scans).sqrt());
            let bound = bound(&sensor, DetectorIndex(0), tier).expect("there is a bound");
            let bound_m = bound.of_path(PathIndex(0)).expect("of the path");
            assert!((expected / bound_m - 1.0).abs() < 0.03, "{of}: {expected} {bound_m}");
        }
    }
}
