//! Diagnosis of a sensor whose counts differ from the expectation of its scene.
//!
//! Every statement rests on a test, and all tests are one [`Comparisons`]: by design they reject a
//! correct scene in about one scan of a hundred (docs/recorded-counts.md has what was measured). At
//! first only the distance is unknown. Of light level, background, dead time, afterpulsing, chip period, integration
//! time and the other recharge, the one that raises the likelihood most is freed, and the next, as long as the gain is significant. Where
//! several do about as well, all of them are named: the counts do not tell which it is. A cause that
//! is named fits the counts; another one, or several together, may fit them as well.
//!
//! The chip period is a special case: code and counter run off one clock, so that another period leaves the counts what
//! they are but for what the detector does in its own time. It stands for any mistake of the detector's times at once, while
//! a crystal is exact to ppm. So another cause that does about as well comes first, and dead time and afterpulsing take its
//! place, unless the peak stands at the scene's path by that clock alone; and where the chip period does not explain the
//! counts by itself, they are explained without it, if they can be.

use std::sync::Arc;

use serde::Serialize;

use super::Cause;
use super::codes::{self, Candidate};
use super::hypothesis::{ExpectedChange, SceneChange, SceneFit, Unknown, constant_cps, fit};
use super::observed::{ExpectedNumbers, Observed, differences};
use crate::estimate::chance::{Darkness, chance_of_zeros};
use crate::estimate::coverage::steps_outside;
use crate::estimate::evidence::Comparisons;
use crate::estimate::fit::FitError;
use crate::estimate::{CountingTier, calibration_offset_ps, distance_m};
use crate::math::normal_cdf;
use crate::photons::DetectorModel;
use crate::response::MeanResponse;
use crate::scene::{Scene, SourceIndex};
use crate::sensor::Sensor;

/// Probability that any of the tests rejects a correct scene, and their largest number.
const WRONG: f64 = 0.014;
const TESTS: usize = 9;

/// Hits of a step, on average over a scan, or of a histogram, from which on causes are
/// looked for: of scans with 370 the tests accuse a right scene as seldom as their level
/// says, of scans with 7 one time in five.
pub const FEWEST_HITS: f64 = 300.0;

/// What the best fit's distance rests on where the chip period alone explains the counts.
const OF_CLOCK: &str = "the best fit's distance is told with that chip period; a crystal is exact to ppm, so look \
     whether the scene has the clock's setting";

/// A test and its outcome.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct TestOutcome {
    /// What is tested.
    pub cause: Cause,
    /// Gain of twice the log-likelihood, by chance a chi-square of one degree of freedom; for
    /// the residuals, their chi-square.
    pub statistic: f64,
    /// Probability of a statistic at least as large if the scene is right.
    pub p_value: Option<f64>,
    /// Whether it is below the test's level.
    pub rejects: bool,
    /// The scene's value, in `unit`.
    pub scene_value: Option<f64>,
    /// The fitted value.
    pub fitted_value: Option<f64>,
    /// Its standard deviation.
    pub fitted_value_std: Option<f64>,
    /// Unit of the values.
    pub unit: &'static str,
}

/// What the counts show about the scene.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct Diagnosis {
    /// Causes that fit the counts better than the scene, the strongest first; empty if there are
    /// none. Causes that the counts do not distinguish are all listed.
    pub causes: Vec<Cause>,
    /// The same in a sentence.
    pub sentence: String,
    /// Every test that was done.
    pub tests: Vec<TestOutcome>,
    /// What could not be tested, and why.
    pub not_tested: Vec<String>,
}

/// Tests a scan against its scene: the diagnosis, and the fit behind it. `delays_ps` are candidates for
/// the delay of its peak, relative to the scene's: the tests begin with the one that agrees best. The scan
/// `may_be_dark` if its peak may be chance.
pub(super) fn diagnose(
    sensor: &Sensor,
    observed: Observed,
    delays_ps: &[f64],
    may_be_dark: bool,
) -> Result<(Diagnosis, SceneFit), FitError> {
    let mut examination = Examination {
        sensor,
        scene: sensor.scene(),
        observed,
        unknowns: vec![Unknown::Delay],
        fitted: fit_of_scene(sensor, observed, delays_ps, None)?,
        tests: Vec::new(),
        alike: Vec::new(),
        has_right_clock: false,
        not_tested: Vec::new(),
    };
    if examination.fitted.errors.is_empty() {
        examination.unknowns.clear();
    }
    if let Some(nothing) = examination.without_hits()? {
        return Ok(nothing);
    }
    let hits = examination.fitted.expected.hits();
    if hits < FEWEST_HITS {
        return Ok(examination.too_few_hits(hits));
    }
    if let Some(dark) = may_be_dark.then(|| examination.without_light()).flatten() {
        return Ok(dark);
    }
    let mut examination = examination.with_causes();
    let codes = match examination.is_explained() {
        true => Vec::new(),
        false => examination.other_codes(),
    };
    Ok(examination.conclude(codes))
}

/// The scene with its delay fitted, from the best of some delays; without an unknown if the counts do
/// not determine the delay. Of the scene `as_it_is` the expectation may be known.
pub(super) fn fit_of_scene(
    sensor: &Sensor,
    observed: Observed,
    delays_ps: &[f64],
    as_it_is: Option<&ExpectedNumbers>,
) -> Result<SceneFit, FitError> {
    let start = best_delay(sensor, observed, delays_ps, as_it_is)?;
    let fitted = fit(sensor, observed, &[Unknown::Delay], start.clone());
    fitted.or_else(|_| fit(sensor, observed, &[], start))
}

/// Longest code whose peak is looked for outside of a scan: sidelobes of longer ones are small.
const MOST_CHIPS_OUTSIDE: u64 = 511;

/// A delay at which the scan does not come by the peak, if its sidelobes fit the counts better than any peak within
/// the scan: light of any level, in any background, half a chip apart over the code period.
fn delay_outside(sensor: &Sensor, observed: Observed) -> Result<Option<f64>, FitError> {
    let Observed::Steps(scan) = observed else { return Ok(None) };
    let (clock, detector) = (sensor.clock(), observed.detector());
    let code = sensor.reference(detector);
    if sensor.timing().scan.is_full() || code.len() > MOST_CHIPS_OUTSIDE {
        return Ok(None);
    }
    let Some(own) = sensor.scene().own_paths(detector).next() else { return Ok(None) };
    let offset_ps = calibration_offset_ps(sensor, detector, CountingTier::Sampled);
    let here_ps = sensor.scene().paths[own].delay_ps + offset_ps;
    let model = DetectorModel::new(sensor, detector);
    let response = MeanResponse::of_tier(&model, CountingTier::Sampled)?;
    let signed: Vec<f64> = scan.counts.iter().map(|count| count.signed as f64).collect();
    let variance = observed.expected(sensor, 0.0)?.each()[0][1].powi(2);
    // The gain of twice the log-likelihood, and the delay: of the best within the scan, and outside.
    let mut best = [(0.0, 0.0); 2];
    for half_chips in 0..2 * code.len() {
        let delay_ps = clock.ps(0.5 * half_chips as f64);
        let means = response.delayed(delay_ps)?.mean_counts();
        let means: Vec<f64> = means.iter().map(|mean| mean.signed).collect();
        let gain = gain_of_shape(&signed, &means) / variance;
        let is_outside = steps_outside(sensor, here_ps + delay_ps) > 0.0;
        let of_place = &mut best[usize::from(is_outside)];
        if gain > of_place.0 {
            *of_place = (gain, delay_ps);
        }
    }
    let [(within, _), (outside, delay_ps)] = best;
    let needed = critical() + 2.0 * (2.0 * code.len() as f64).ln();
    Ok((outside - within > needed).then_some(delay_ps))
}

/// By how much the sum of squares falls if counts have a constant and a positive multiple of a shape, beside a constant
/// alone.
fn gain_of_shape(counts: &[f64], shape: &[f64]) -> f64 {
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let (count, level) = (mean(counts), mean(shape));
    let product: f64 = counts.iter().zip(shape).map(|(y, m)| (y - count) * (m - level)).sum();
    let square: f64 = shape.iter().map(|m| (m - level).powi(2)).sum();
    if product > 0.0 && square > 0.0 { product * product / square } else { 0.0 }
}

/// Of some delays, the one at which the scene agrees best with the recorded counts.
fn best_delay(
    sensor: &Sensor,
    observed: Observed,
    delays_ps: &[f64],
    as_it_is: Option<&ExpectedNumbers>,
) -> Result<ExpectedChange, FitError> {
    if let Some(delay_ps) = delay_outside(sensor, observed)? {
        return SceneChange::later(delay_ps).start(sensor, observed);
    }
    let values = observed.values();
    let mut best: Option<(f64, ExpectedChange)> = None;
    for &delay_ps in delays_ps {
        let change = SceneChange::later(delay_ps);
        let start = match as_it_is {
            Some(known) if delay_ps == 0.0 => ExpectedChange { change, expected: known.clone() },
            _ => change.start(sensor, observed)?,
        };
        let deviance = start.expected.judge(&values)?.deviance;
        if deviance < best.as_ref().map_or(f64::INFINITY, |(least, _)| *least) {
            best = Some((deviance, start));
        }
    }
    best.map_or_else(|| SceneChange::default().start(sensor, observed), |(_, start)| Ok(start))
}

#[derive(Clone)]
struct Examination<'s> {
    sensor: &'s Sensor,
    scene: &'s Scene,
    observed: Observed<'s>,
    unknowns: Vec<Unknown>,
    fitted: SceneFit,
    tests: Vec<TestOutcome>,
    /// Freed parameters, each with those that do about as well.
    alike: Vec<Vec<Unknown>>,
    /// Whether the chip period is taken for the scene's.
    has_right_clock: bool,
    not_tested: Vec<String>,
}

/// Chance of a chi-square of one degree of freedom above `statistic`.
fn chance(statistic: f64) -> f64 {
    2.0 * normal_cdf(-statistic.max(0.0).sqrt())
}

fn family() -> Comparisons {
    Comparisons::of(WRONG, TESTS)
}

/// The chi-square of one degree of freedom that has the chance of a test to be wrong.
fn critical() -> f64 {
    family().sigmas().powi(2)
}

impl Examination<'_> {
    /// The same with every parameter freed that raises the likelihood significantly. The chip period is a cause by itself,
    /// or beside others where the counts have no explanation without it.
    fn with_causes(mut self) -> Self {
        let mut found = self.clone();
        while found.take_in_best() {}
        if found.unknowns.contains(&Unknown::ChipPeriod) && !found.is_of_clock() {
            self.has_right_clock = true;
            while self.take_in_best() {}
            if self.is_explained() || !found.is_explained() {
                return self;
            }
        }
        found
    }

    /// Whether another chip period is all that the counts tell.
    fn is_of_clock(&self) -> bool {
        self.alike == [[Unknown::ChipPeriod]] && self.is_explained()
    }

    /// Why counts of the other recharge are not known, if they are not.
    fn no_other_recharge(&self) -> Option<&'static str> {
        let spad = &self.scene.detectors[self.observed.detector()];
        let has_crosstalk = self.scene.detectors.iter().any(|spad| spad.crosstalk().is_some());
        if spad.afterpulsing_probability > 0.0 {
            Some(
                "afterpulses within a dead time would prolong it, and what is then counted is not known",
            )
        } else if has_crosstalk {
            Some("passive recharge beside crosstalk is not simulated")
        } else {
            None
        }
    }

    /// Frees the parameter that raises the likelihood most, if significantly; the chip period only if no other does about
    /// as well.
    fn take_in_best(&mut self) -> bool {
        let spad = &self.scene.detectors[self.observed.detector()];
        let mut candidates = vec![Unknown::Light, Unknown::Constant, Unknown::Integration];
        if !self.has_right_clock {
            candidates.push(Unknown::ChipPeriod);
        }
        if spad.dead_time_ps > 0.0 {
            candidates.extend([Unknown::DeadTime, Unknown::Afterpulsing]);
            candidates.extend(self.no_other_recharge().is_none().then_some(Unknown::Recharge));
        }
        candidates.retain(|unknown| !self.unknowns.contains(unknown));
        // Tests that failed with fewer unknowns are repeated.
        self.not_tested.clear();
        let mut gains: Vec<(f64, Unknown, SceneFit)> = Vec::new();
        for unknown in candidates {
            let mut unknowns = self.unknowns.clone();
            unknowns.push(unknown);
            let start = match unknown {
                Unknown::Recharge => {
                    self.fitted.change.by(unknown, 1.0).start(self.sensor, self.observed)
                }
                _ => Ok(self.fitted.end()),
            };
            match start.and_then(|start| fit(self.sensor, self.observed, &unknowns, start)) {
                Ok(fitted) => {
                    let gain = self.fitted.agreement.deviance - fitted.agreement.deviance;
                    self.tests.retain(|test| test.cause != unknown.cause());
                    self.tests.push(self.outcome(unknown, gain, &fitted));
                    gains.push((gain, unknown, fitted));
                }
                Err(reason) => {
                    self.not_tested.push(format!("{}: {reason}", unknown.name()));
                }
            }
        }
        let most = gains.iter().map(|(gain, ..)| *gain).fold(0.0, f64::max);
        if most <= critical() {
            return false;
        }
        gains.retain(|(gain, ..)| *gain > most - critical());
        gains.sort_by(|a, b| b.0.total_cmp(&a.0));
        // The chip period alone where the peak stands at the scene's path by no other; otherwise last, and not at all where
        // times of the detector are as good.
        let is_clock = |(_, unknown, _): &(f64, Unknown, SceneFit)| *unknown == Unknown::ChipPeriod;
        let is_of_detector = |(_, unknown, _): &(f64, Unknown, SceneFit)| {
            matches!(unknown, Unknown::DeadTime | Unknown::Afterpulsing | Unknown::Recharge)
        };
        if self.is_path_by_clock_alone(&gains) {
            gains.retain(is_clock);
        } else if gains.iter().any(is_of_detector) {
            gains.retain(|found| !is_clock(found));
        }
        gains.sort_by_key(is_clock);
        self.alike.push(gains.iter().map(|(_, unknown, _)| *unknown).collect());
        let Some((_, unknown, fitted)) = gains.into_iter().next() else { return false };
        self.unknowns.push(unknown);
        self.fitted = fitted;
        true
    }

    /// The diagnosis of counts that a scene without any light of the own source explains, and better than
    /// the scene does: whatever else is freed would be fitted to noise.
    fn without_light(&mut self) -> Option<(Diagnosis, SceneFit)> {
        let detector = self.observed.detector();
        let counts = self.observed.step_counts(self.sensor);
        let (dark, brighter_cps) =
            Darkness::of_scene(self.sensor, detector).as_bright_as(&counts).sensor();
        let start = SceneChange::default().by(Unknown::Constant, brighter_cps);
        let start = start.start(&dark, self.observed).ok()?;
        // Signed counts alone do not tell the background but by their scatter.
        let unknowns: &[Unknown] =
            if self.observed.tells_light() { &[Unknown::Constant] } else { &[] };
        let fitted = fit(&dark, self.observed, unknowns, start).ok()?;
        let gain = self.fitted.agreement.deviance - fitted.agreement.deviance;
        let explains = fitted.p_value.is_none_or(|p| p >= family().level());
        if !explains || gain <= critical() {
            return None;
        }
        let test = TestOutcome {
            cause: Cause::NoLight,
            statistic: gain,
            p_value: Some(chance(gain)),
            rejects: true,
            scene_value: None,
            fitted_value: None,
            fitted_value_std: None,
            unit: "",
        };
        Some((self.darkness(vec![test]), fitted))
    }

    /// The diagnosis of counts that a scene without the own light makes.
    fn darkness(&self, tests: Vec<TestOutcome>) -> Diagnosis {
        let own = self.scene.detectors[self.observed.detector()].reference;
        let sentence = format!(
            "the counts are those of a scene without any light of \"{}\": the beam is blocked, the laser \
             off, or the target out of reach",
            self.scene.sources[own].name
        );
        Diagnosis { causes: vec![Cause::NoLight], sentence, tests, not_tested: Vec::new() }
    }

    /// The diagnosis of counts that are all 0, where the scene's light leaves some: of darkness if that has none, or
    /// of a detector that does not count.
    fn without_hits(&self) -> Result<Option<(Diagnosis, SceneFit)>, FitError> {
        let (sensor, detector) = (self.sensor, self.observed.detector());
        let counts = self.observed.step_counts(sensor);
        if self.observed.values().iter().any(|&value| value != 0.0) {
            return Ok(None);
        }
        let start = SceneChange::default().start(sensor, self.observed)?;
        let nothing = fit(sensor, self.observed, &[], start)?;
        let groups = match self.observed {
            Observed::Steps(_) => counts.len() as f64,
            Observed::Bins(_) => 1.0,
        };
        let has_totals = self.observed.tells_light();
        if chance_of_zeros(nothing.expected.hits(), groups, has_totals) >= family().level() {
            return Ok(None);
        }
        let dark = Darkness::of_scene(sensor, detector).as_bright_as(&counts);
        if dark.chance_of_zeros(counts.len(), has_totals) >= family().level() {
            return Ok(Some((self.darkness(Vec::new()), nothing)));
        }
        let sentence = "every count is 0, and the scene has hits even in darkness: the detector is off or not connected";
        let diagnosis = Diagnosis {
            causes: vec![Cause::NoHits],
            sentence: sentence.to_owned(),
            tests: Vec::new(),
            not_tested: Vec::new(),
        };
        Ok(Some((diagnosis, nothing)))
    }

    /// No diagnosis: the tests do not keep their level where hits are few.
    fn too_few_hits(self, hits: f64) -> (Diagnosis, SceneFit) {
        let of = match self.observed {
            Observed::Steps(_) => "a step",
            Observed::Bins(_) => "all bins",
        };
        let reason = format!(
            "causes: {hits:.1} hits are expected in {of}; from {FEWEST_HITS} on the tests are \
             known to hold"
        );
        let diagnosis = Diagnosis {
            causes: Vec::new(),
            sentence: "no diagnosis: the scan has too few hits".to_owned(),
            tests: Vec::new(),
            not_tested: vec![reason],
        };
        (diagnosis, self.fitted)
    }

    fn outcome(&self, unknown: Unknown, statistic: f64, fitted: &SceneFit) -> TestOutcome {
        let spad = &self.scene.detectors[self.observed.detector()];
        let (value, std) = (fitted.change.value(unknown), fitted.std_of(unknown));
        // The scene's value, the fitted one, and the factor from the change to its standard deviation.
        let constant_cps = constant_cps(spad);
        let probability = spad.afterpulsing_probability;
        let (scene_value, fitted_value, of_change) = match unknown {
            Unknown::Light | Unknown::Integration => (1.0, value.exp(), value.exp()),
            Unknown::Constant => (constant_cps, constant_cps + value, 1.0),
            Unknown::Afterpulsing => (probability, probability + value, 1.0),
            Unknown::DeadTime => {
                let ns = spad.dead_time_ps * 1e-3;
                (ns, ns + value * 1e-3, 1e-3)
            }
            Unknown::ChipPeriod => {
                let ns = self.scene.chip_period_ps * 1e-3;
                (ns, ns * value.exp(), ns * value.exp())
            }
            Unknown::Delay => (0.0, value * 1e-3, 1e-3),
            Unknown::Recharge => (0.0, 0.0, 0.0),
        };
        let is_number = unknown != Unknown::Recharge;
        TestOutcome {
            cause: unknown.cause(),
            statistic,
            p_value: Some(chance(statistic)),
            rejects: statistic > critical(),
            scene_value: is_number.then_some(scene_value),
            fitted_value: is_number.then_some(fitted_value),
            fitted_value_std: std.map(|std| std * of_change),
            unit: unknown.unit(),
        }
    }

    fn is_explained(&self) -> bool {
        self.fitted.p_value.is_none_or(|p| p >= family().level())
    }

    /// The codes that explain the counts better than the scene's, if some do: the best, and
    /// those that do about as well.
    fn other_codes(&mut self) -> Vec<(Candidate, SceneFit)> {
        let found =
            codes::search(self.scene, self.observed, &self.observed.step_counts(self.sensor));
        let (candidates, tried) = match found {
            Ok(found) => found,
            Err(reason) => {
                self.not_tested.push(format!("code: {reason}"));
                return Vec::new();
            }
        };
        // As many codes and as many places as were tried.
        let tried = tried as f64 * self.observed.phase_steps() as f64;
        let needed = critical() + 2.0 * tried.ln();
        let fit = |candidate: Candidate| {
            let fitted = self.with_code(&candidate)?;
            let gain = self.fitted.agreement.deviance - fitted.agreement.deviance;
            Some((gain, candidate, fitted))
        };
        let mut fits: Vec<_> = candidates.into_iter().filter_map(fit).collect();
        fits.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Some(best) = fits.first().map(|(gain, ..)| *gain) else {
            return Vec::new();
        };
        self.tests.push(TestOutcome {
            cause: fits[0].1.cause,
            statistic: best,
            p_value: None,
            rejects: best > needed,
            scene_value: None,
            fitted_value: None,
            fitted_value_std: None,
            unit: "",
        });
        let least = needed.max(best - critical());
        let as_good = fits.into_iter().take_while(|(gain, ..)| *gain > least || *gain == best);
        let as_good = as_good.filter(|_| best > needed);
        as_good.map(|(_, candidate, fitted)| (candidate, fitted)).collect()
    }

    /// The scene with other codes, fitted from where within a chip its means agree best.
    fn with_code(&self, candidate: &Candidate) -> Option<SceneFit> {
        let mut scene = self.scene.clone();
        let own = scene.detectors[self.observed.detector()].reference;
        let mut light = scene.sources[own].clone();
        light.code = Arc::clone(&candidate.light);
        scene.sources[own].code = Arc::clone(&candidate.reference);
        scene.sources.push(light);
        let last = SourceIndex(scene.sources.len() - 1);
        for path in scene.paths.iter_mut().filter(|path| path.source == own) {
            path.source = last;
        }
        let sensor = Sensor::new(&scene);
        let step_ps = sensor.clock().sample_period_ps();
        let offset_ps =
            calibration_offset_ps(&sensor, self.observed.detector(), CountingTier::Sampled);
        let first = scene.paths.iter().find(|path| path.detector == self.observed.detector())?;
        let at_ps = candidate.at_step as f64 * step_ps - offset_ps - first.delay_ps;
        let agreement = |chips: f64| {
            // The light level that was fitted with a wrong code is useless here.
            let delay_ps = at_ps + sensor.clock().ps(chips);
            let means = self.observed.means(&sensor, delay_ps).ok()?;
            let whitening = self.fitted.expected.whitening(&means).ok()?;
            let residuals = differences(&self.observed.values(), &means);
            let squares = whitening.whitened(&residuals).ok()?.into_iter().map(|z| z * z);
            Some((squares.sum::<f64>(), SceneChange::later(delay_ps)))
        };
        let places = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];
        let agreements = places.into_iter().filter_map(agreement);
        let (_, start) = agreements.min_by(|a, b| a.0.total_cmp(&b.0))?;
        let start = start.start(&sensor, self.observed).ok()?;
        fit(&sensor, self.observed, &[Unknown::Delay, Unknown::Light], start).ok()
    }

    /// The diagnosis, given `codes` that explain the counts better than the scene's, the best first.
    fn conclude(mut self, codes: Vec<(Candidate, SceneFit)>) -> (Diagnosis, SceneFit) {
        let mut causes = Vec::new();
        let mut says = Vec::new();
        let words: Vec<&str> = codes.iter().map(|(code, _)| &*code.words).collect();
        if !words.is_empty() {
            let tells = if words.len() == 1 { "" } else { "; they do not tell which" };
            says.push(format!("the counts fit better if {}{tells}", words.join(", also if ")));
        }
        for (code, _) in &codes {
            if !causes.contains(&code.cause) {
                causes.push(code.cause);
            }
        }
        match codes.into_iter().next() {
            Some((_, fitted)) => self.fitted = fitted,
            None => {
                for alike in &self.alike {
                    for cause in alike.iter().map(|unknown| unknown.cause()) {
                        if !causes.contains(&cause) {
                            causes.push(cause);
                        }
                    }
                    says.push(self.of_unknowns(alike));
                }
                let is_of_clock = self.is_of_clock();
                if is_of_clock {
                    says.push(OF_CLOCK.to_owned());
                }
                says.extend(self.offset(is_of_clock, &mut causes));
            }
        }
        says.extend(self.scatter(&mut causes));
        let sentence = match says.is_empty() {
            true => "the counts are as the scene says".to_owned(),
            false => says.join("; "),
        };
        let spad = &self.scene.detectors[self.observed.detector()];
        if let Some(reason) = self.no_other_recharge()
            && !self.alike.is_empty()
            && spad.dead_time_ps > 0.0
        {
            self.not_tested.push(format!("{}: {reason}", Unknown::Recharge.name()));
        }
        let Examination { tests, not_tested, fitted, .. } = self;
        (Diagnosis { causes, sentence, tests, not_tested }, fitted)
    }

    /// Counts a fit's delay from the scene's path, by the fitted clock or by the scene's, in less than a code period.
    fn told(&self, mut fitted: SceneFit, is_of_clock: bool) -> SceneFit {
        fitted.tell_times_of_scene(self.scene, self.observed.detector(), is_of_clock);
        let code =
            &self.scene.sources[self.scene.detectors[self.observed.detector()].reference].code;
        let period_ps = self.scene.clock().ps(code.len() as f64);
        let turns = (fitted.change.value(Unknown::Delay) / period_ps).round();
        fitted.change = fitted.change.by(Unknown::Delay, -turns * period_ps);
        fitted
    }

    /// Whether the peak stands at the scene's path by another chip period, of which it is known well enough, and by no other
    /// of some freed parameters.
    fn is_path_by_clock_alone(&self, gains: &[(f64, Unknown, SceneFit)]) -> bool {
        let (mut by_clock, mut by_others) = (None, Vec::new());
        for (_, unknown, fitted) in gains {
            let is_clock = *unknown == Unknown::ChipPeriod;
            let told = self.told(fitted.clone(), is_clock);
            let Some(std_ps) = told.std_of(Unknown::Delay) else { return false };
            let peak = (told.change.value(Unknown::Delay), std_ps);
            if is_clock {
                by_clock = Some(peak);
            } else {
                by_others.push(peak);
            }
        }
        let is_at_path = |later_ps: f64, std_ps: f64| (later_ps / std_ps).powi(2) <= critical();
        by_clock.is_some_and(|(later_ps, clock_ps)| {
            is_at_path(later_ps, clock_ps)
                && by_others
                    .iter()
                    .all(|(later_ps, std_ps)| !is_at_path(*later_ps, std_ps.hypot(clock_ps)))
        })
    }

    /// Whether the peak stands where the scene's path has it, by the fitted clock or by the scene's.
    fn offset(&mut self, is_of_clock: bool, causes: &mut Vec<Cause>) -> Option<String> {
        self.fitted = self.told(self.fitted.clone(), is_of_clock);
        let std_ps = self.fitted.std_of(Unknown::Delay)?;
        let by_ps = self.fitted.change.value(Unknown::Delay);
        let outcome = self.outcome(Unknown::Delay, (by_ps / std_ps).powi(2), &self.fitted);
        let rejects = outcome.rejects;
        self.tests.push(outcome);
        rejects.then(|| {
            causes.push(Cause::Offset);
            format!(
                "the peak stands {:.3} +- {:.3} ns {} than the scene's: the target is {:.4} m \
                 {}, or a constant delay (detector.delay, cables) differs by as much",
                by_ps.abs() * 1e-3,
                std_ps * 1e-3,
                if by_ps > 0.0 { "later" } else { "earlier" },
                distance_m(by_ps.abs()),
                if by_ps > 0.0 { "farther" } else { "nearer" },
            ) + match self.observed.tells_light() {
                true => "",
                false => "; without total counts another dead time or light level also fits",
            }
        })
    }

    /// Whether the residuals scatter as photons do.
    fn scatter(&mut self, causes: &mut Vec<Cause>) -> Option<String> {
        let p = self.fitted.p_value?;
        let rejects = p.min(1.0 - p) < 0.5 * family().level();
        let (cause, text) = match p < 0.5 {
            true => (
                Cause::Unexplained,
                "the residuals are larger than chance: something else is not as the scene says \
                 (other light, a path more, a detector of another kind)",
            ),
            false => (
                Cause::TooEven,
                "the counts scatter less than photons can: are they averages, or scaled?",
            ),
        };
        self.tests.push(TestOutcome {
            cause,
            statistic: self.fitted.agreement.chi_square,
            p_value: Some(p),
            rejects,
            scene_value: Some(self.fitted.degrees as f64),
            fitted_value: Some(self.fitted.agreement.chi_square),
            fitted_value_std: None,
            unit: "chi-square",
        });
        rejects.then(|| {
            causes.push(cause);
            text.to_owned()
        })
    }

    /// The freed parameters in words.
    fn of_unknowns(&self, alike: &[Unknown]) -> String {
        let spad = &self.scene.detectors[self.observed.detector()];
        let words = |unknown: &Unknown| {
            if *unknown == Unknown::Recharge {
                return Some(format!("recharge = \"{}\"", spad.recharge.other().name()));
            }
            let test = self.tests.iter().find(|test| test.cause == unknown.cause())?;
            let (value, scene) = (test.fitted_value?, test.scene_value?);
            let std = test.fitted_value_std.unwrap_or(0.0);
            Some(match unknown {
                Unknown::Light => format!("{value:.4} +- {std:.4} times the scene's light"),
                Unknown::Integration => format!(
                    "{value:.4} +- {std:.4} times the scene's integration time, or so many scans added up"
                ),
                Unknown::Constant => format!(
                    "background (dark counts, background) of {value:.4e} +- {std:.1e} cps in place \
                     of {scene:.4e}"
                ),
                Unknown::DeadTime | Unknown::ChipPeriod => format!(
                    "a {} of {value:.3} +- {std:.3} ns in place of {scene:.3}",
                    unknown.name()
                ),
                Unknown::Afterpulsing => format!(
                    "an afterpulsing probability of {value:.4} +- {std:.4} in place of {scene:.4}"
                ),
                Unknown::Delay | Unknown::Recharge => return None,
            })
        };
        let words: Vec<String> = alike.iter().filter_map(words).collect();
        let tells = if words.len() == 1 { "" } else { "; they do not tell which" };
        format!("the counts fit better with {}{tells}", words.join(", also with "))
    }
}
