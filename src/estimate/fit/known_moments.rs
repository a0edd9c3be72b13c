//! Second moments for fits, worked out once for neighbouring light.
//!
//! They cost more than all else in a fit, and hardly change with the light beside
//! what Poisson counts would have: variances N, and the mean of r as covariance. So
//! what is different from that, per detection, is taken from the nearest node of a
//! grid of the unknowns: the same, whatever was fitted before.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::parameters::{Column, Parameters, PathParameters};
use super::problem::Problem;
use super::shared_light;
use super::shared_steps::SharedSteps;
use super::slipping::SlippingLight;
use super::template::Axis;
use super::weights::Weights;
use crate::response::{CountMoments, MeanCount, MeanResponseError, SecondMoments};
use crate::scan::Step;

/// Distance of nodes: delays in chips, and rates times dead time, which is what
/// moments per detection depend on.
struct Spacing {
    delay_chips: f64,
    saturation: f64,
    /// Most nodes that are kept.
    kept: usize,
}

impl Spacing {
    /// Distance of rates per chip, in light of some octave. Without dead time moments per
    /// detection, and derivatives per light, do not depend on the rate.
    fn rate(&self, octave: i32, dead_time_chips: f64) -> f64 {
        self.saturation / dead_time_chips.max(0.1) * f64::from(octave).exp2()
    }
}

/// How often the light is twice as bright as it takes to make the detector dead for half of
/// the time. Moments depend on the share of time that it is dead, which changes the less
/// with the light the nearer it is to one: so grids are as coarse as the light is bright.
fn octave(parameters: &Parameters, dead_time_chips: f64) -> i32 {
    let saturation = parameters.brightest() * dead_time_chips.max(0.1);
    saturation.ln_1p().div_euclid(std::f64::consts::LN_2) as i32
}

/// Half a spacing changes moments by less than a per cent: chi-square of some tens
/// of counts has a spread of 15 %.
const OF_WINDOWS: Spacing = Spacing { delay_chips: 1.0 / 32.0, saturation: 0.008, kept: 10_000 };

/// Steps that count the same light differ by what comes within a phase step of the
/// reference's edges, where the light changes.
const OF_SHARED_STEPS: Spacing = Spacing { delay_chips: 1.0 / 128.0, ..OF_WINDOWS };

/// For derivatives: a peak's corners are round within some hundredths of a chip.
const OF_SLOPES: Spacing = Spacing { delay_chips: 1.0 / 64.0, saturation: 0.016, kept: 10_000 };

/// Chi-square of ten thousands of counts has a spread of under a per cent.
const OF_SCANS: Spacing = Spacing { delay_chips: 1.0 / 64.0, saturation: 0.002, kept: 100 };

/// Of few steps that stand for all of a scan.
const OF_FEW_STEPS: Spacing = Spacing { delay_chips: 1.0 / 8.0, saturation: 0.02, kept: 10_000 };

/// Steps away from all peaks whose moments are taken.
const STEPS_AWAY: usize = 12;

/// Which node.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct Key {
    /// Steps of a window; none for the whole scan.
    steps: Vec<Step>,
    /// Chips of the codes.
    codes: Vec<Vec<u8>>,
    /// The octave of the light, and delay and strength of each path, and the background, in
    /// spacings.
    place: Vec<i64>,
}

/// Second moments of one step's counts, per expected detection.
#[derive(Debug, Clone, Copy)]
struct PerDetection {
    signed_variance: f64,
    total_variance: f64,
    /// Covariance of r and N, less the mean of r.
    excess_covariance: f64,
}

impl Key {
    fn new(problem: &Problem, place: Vec<i64>) -> Key {
        Key {
            steps: match problem.takes_all_steps() {
                true => Vec::new(),
                false => problem.steps.clone(),
            },
            codes: problem.codes.iter().map(|c| c.chips.clone()).collect(),
            place,
        }
    }
}

impl PerDetection {
    /// Moments of a step that expects `mean`.
    fn of(&self, mean: &MeanCount) -> CountMoments {
        CountMoments {
            signed_mean: mean.signed,
            total_mean: mean.total,
            signed_variance: self.signed_variance * mean.total,
            total_variance: self.total_variance * mean.total,
            covariance: mean.signed + self.excess_covariance * mean.total,
        }
    }

    fn mean(all: &[PerDetection]) -> PerDetection {
        let mean =
            |of: &dyn Fn(&PerDetection) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
        PerDetection {
            signed_variance: mean(&|m| m.signed_variance),
            total_variance: mean(&|m| m.total_variance),
            excess_covariance: mean(&|m| m.excess_covariance),
        }
    }

    /// These moments, and those of peaks as far as each reaches here.
    fn towards<'a>(&self, peaks: impl Iterator<Item = (&'a PerDetection, f64)>) -> PerDetection {
        let mut here = *self;
        for (peak, shape) in peaks.filter(|(_, shape)| *shape > 0.0) {
            here.signed_variance += shape * shape * (peak.signed_variance - self.signed_variance);
            here.excess_covariance += shape * (peak.excess_covariance - self.excess_covariance);
        }
        here.signed_variance = here.signed_variance.max(0.5 * self.signed_variance);
        here
    }
}

/// Steps far from all peaks, spread over the scan, and those of the peaks.
fn sampled_steps(problem: &Problem, axis: &Axis, peaks: &[f64]) -> Vec<Step> {
    let steps = problem.steps.len();
    let is_away = |&index: &usize| {
        let place = problem.place_of(problem.steps[index], axis);
        peaks.iter().all(|peak| axis.shape(place - peak) <= 0.0)
    };
    let spread = (0..STEPS_AWAY).map(|part| (2 * part + 1) * steps / (2 * STEPS_AWAY));
    let away = spread.filter_map(|from| (from..steps).find(is_away));
    let mut chosen: Vec<Step> = away.map(|index| problem.steps[index]).collect();
    let nearest = |peak: f64| {
        let off = |step: &&Step| axis.steps_apart(problem.place_of(**step, axis) - peak);
        problem.steps.iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    };
    chosen.extend(peaks.iter().filter_map(|&peak| nearest(peak)));
    chosen
}

/// What is expected of a node's light, and its derivatives.
pub struct Linear {
    pub parameters: Parameters,
    pub means: Vec<MeanCount>,
    columns: Vec<Column>,
}

impl Linear {
    /// Whether the derivatives are good for some parameters: half as far again as to
    /// the border to the next node.
    pub fn holds_for(&self, parameters: &Parameters, dead_time_chips: f64) -> bool {
        let octave = octave(&self.parameters, dead_time_chips);
        let rate = 0.75 * OF_SLOPES.rate(octave, dead_time_chips);
        let pairs = parameters.paths.iter().zip(&self.parameters.paths);
        let mut near = pairs.map(|(here, node)| {
            (here.delay_chips - node.delay_chips).abs() <= 0.75 * OF_SLOPES.delay_chips
                && (here.ln_rate.exp() - node.ln_rate.exp()).abs() <= rate
        });
        near.all(|near| near) && (parameters.constant - self.parameters.constant).abs() <= rate
    }

    /// Derivatives for strengths near the node's: by delay and by the logarithm of the
    /// strength they go with the strength.
    pub fn columns_at(&self, parameters: &Parameters) -> Vec<Column> {
        let ratios = parameters.paths.iter().zip(&self.parameters.paths);
        let ratios = ratios.flat_map(|(here, node)| [(here.ln_rate - node.ln_rate).exp(); 2]);
        let ratios = ratios.chain([1.0]);
        let scaled = |(column, ratio): (&Column, f64)| {
            let entries = column.iter().map(|entry| MeanCount {
                signed: entry.signed * ratio,
                total: entry.total * ratio,
            });
            entries.collect()
        };
        self.columns.iter().zip(ratios).map(scaled).collect()
    }
}

/// Second moments at nodes that were needed so far, and expectations with their
/// derivatives.
#[derive(Default)]
pub struct KnownMoments {
    nodes: Mutex<HashMap<Key, Arc<[PerDetection]>>>,
    linear: Mutex<HashMap<Key, Arc<Linear>>>,
    shared: Mutex<HashMap<Key, Arc<[SharedSteps]>>>,
    slipping: OnceLock<Result<SlippingLight, MeanResponseError>>,
}

impl KnownMoments {
    /// The weights of a problem's counts at `parameters`, which expect `means`.
    pub fn weights(
        &self,
        problem: &Problem,
        parameters: &Parameters,
        means: &[MeanCount],
    ) -> Result<Weights, MeanResponseError> {
        if problem.shares_light() {
            let known = self.nearest_shared(problem, parameters)?;
            return Ok(shared_light::weights_of_all(&known, means));
        }
        let known = self.nearest(problem, parameters)?;
        let moments = means.iter().zip(known.iter());
        let moments: Vec<CountMoments> = moments.map(|(mean, known)| known.of(mean)).collect();
        let slipping = self.slipping(problem)?;
        if slipping.is_none() {
            return Ok(Weights::of(&moments));
        }
        let timing = &problem.model.timing;
        Ok(Weights::of_steps_together(&moments, |a, b| {
            slipping.covariance(timing, problem.steps[a], problem.steps[b])
        }))
    }

    /// What light of clocks of their own adds, which is the same for all scans.
    pub fn slipping(&self, problem: &Problem) -> Result<&SlippingLight, MeanResponseError> {
        let slipping =
            self.slipping.get_or_init(|| SlippingLight::new(problem.model, problem.tier));
        slipping.as_ref().map_err(Clone::clone)
    }

    /// Expectation and derivatives at the node nearest to some parameters.
    pub fn linear(
        &self,
        problem: &Problem,
        parameters: &Parameters,
    ) -> Result<Arc<Linear>, MeanResponseError> {
        let dead_time = problem.model.dead_time_chips;
        let (place, node) = nearest(parameters, &OF_SLOPES, dead_time);
        let key = Key::new(problem, place);
        let known = || self.linear.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(linear) = known().get(&key) {
            return Ok(Arc::clone(linear));
        }
        let response = problem.response(&node)?;
        let linear = Arc::new(Linear {
            means: problem.means_of(&response),
            columns: problem.central_jacobian(&node, &response)?,
            parameters: node,
        });
        let mut known = known();
        if known.len() < OF_SLOPES.kept {
            known.insert(key, Arc::clone(&linear));
        }
        Ok(linear)
    }

    /// The weights of the counts of many steps at once: second moments of few of them
    /// stand for all. Away from the own code's peaks those per detection are alike,
    /// for the reference's signs are as good as random there; towards a peak they
    /// change with the product of two signs, the square of the peak's shape.
    pub fn scan_weights(
        &self,
        problem: &Problem,
        parameters: &Parameters,
        means: &[MeanCount],
        axis: &Axis,
    ) -> Result<Weights, MeanResponseError> {
        if !problem.is_long() {
            return self.weights(problem, parameters, means);
        }
        let own = problem.own_peaks(parameters, axis);
        if problem.shares_light() {
            let known = |few: &Problem| self.nearest_shared(few, parameters);
            return shared_light::weights_of_scan(problem, axis, &own, means, known);
        }
        let samples = sampled_steps(problem, axis, &own);
        let few = Problem { steps: samples.clone(), ..problem.clone() };
        let known = self.nearest_of(&few, parameters, &OF_FEW_STEPS)?;
        let (away, peaks) = known.split_at(samples.len() - own.len());
        let away = PerDetection::mean(away);
        // Steps of a long scan are taken for far apart beside what slips between them.
        let slipping = self.slipping(problem)?.variance();
        let moments = problem.steps.iter().zip(means).map(|(&step, mean)| {
            let place = problem.place_of(step, axis);
            let shapes = own.iter().map(|&peak| axis.shape(place - peak));
            let moments = away.towards(peaks.iter().zip(shapes)).of(mean);
            CountMoments { signed_variance: moments.signed_variance + slipping, ..moments }
        });
        Ok(Weights::of(&moments.collect::<Vec<_>>()))
    }

    fn nearest_shared(
        &self,
        problem: &Problem,
        parameters: &Parameters,
    ) -> Result<Arc<[SharedSteps]>, MeanResponseError> {
        let dead_time = problem.model.dead_time_chips;
        let (place, node) = nearest(parameters, &OF_SHARED_STEPS, dead_time);
        let key = Key::new(problem, place);
        // Whoever panicked meanwhile left the map whole.
        let nodes = || self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = nodes().get(&key) {
            return Ok(Arc::clone(known));
        }
        let response = problem.response(&node)?;
        let found: Arc<[SharedSteps]> =
            problem.shared_steps(&SecondMoments::new(&response)?).into();
        let mut nodes = nodes();
        if nodes.len() < OF_SHARED_STEPS.kept {
            nodes.insert(key, Arc::clone(&found));
        }
        Ok(found)
    }

    fn nearest(
        &self,
        problem: &Problem,
        parameters: &Parameters,
    ) -> Result<Arc<[PerDetection]>, MeanResponseError> {
        let spacing = match problem.takes_all_steps() {
            true => &OF_SCANS,
            false => &OF_WINDOWS,
        };
        self.nearest_of(problem, parameters, spacing)
    }

    fn nearest_of(
        &self,
        problem: &Problem,
        parameters: &Parameters,
        spacing: &Spacing,
    ) -> Result<Arc<[PerDetection]>, MeanResponseError> {
        let (place, node) = nearest(parameters, spacing, problem.model.dead_time_chips);
        let key = Key::new(problem, place);
        // Whoever panicked meanwhile left the map whole.
        let nodes = || self.nodes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = nodes().get(&key) {
            return Ok(Arc::clone(known));
        }
        let moments = problem.moments(&problem.response(&node)?)?;
        let found: Arc<[PerDetection]> = moments
            .iter()
            .map(|m| (m, m.total_mean.max(f64::MIN_POSITIVE)))
            .map(|(m, detections)| PerDetection {
                signed_variance: m.signed_variance / detections,
                total_variance: m.total_variance / detections,
                excess_covariance: (m.covariance - m.signed_mean) / detections,
            })
            .collect();
        let mut nodes = nodes();
        if nodes.len() < spacing.kept {
            nodes.insert(key, Arc::clone(&found));
        }
        Ok(found)
    }
}

impl fmt::Debug for KnownMoments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("KnownMoments").finish_non_exhaustive()
    }
}

/// The node nearest to some parameters, and its octave and numbers. Rates of nodes are odd
/// multiples of half a spacing: there is some light at every node.
fn nearest(
    parameters: &Parameters,
    spacing: &Spacing,
    dead_time_chips: f64,
) -> (Vec<i64>, Parameters) {
    let mut place = Vec::with_capacity(parameters.len());
    let octave = octave(parameters, dead_time_chips);
    place.push(i64::from(octave));
    let rate_spacing = spacing.rate(octave, dead_time_chips);
    let mut numbered = |number: f64| {
        place.push(number as i64);
        number
    };
    let mut rate = |rate: f64| {
        let number = numbered((rate / rate_spacing).floor());
        (number + 0.5) * rate_spacing
    };
    let rates: Vec<f64> = parameters.paths.iter().map(|p| rate(p.ln_rate.exp())).collect();
    let constant = rate(parameters.constant);
    let paths = parameters.paths.iter().zip(rates);
    let paths = paths.map(|(path, rate)| PathParameters {
        delay_chips: numbered((path.delay_chips / spacing.delay_chips).round())
            * spacing.delay_chips,
        ln_rate: rate.ln(),
    });
    let node = Parameters { paths: paths.collect(), constant };
    (place, node)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_within_half_a_spacing_and_its_own_nearest() {
        for number in 0..50 {
            let number = f64::from(number);
            let parameters = Parameters {
                paths: vec![PathParameters {
                    delay_chips: 2.0 + 0.0137 * number,
                    ln_rate: -4.0 + 0.0311 * number,
                }],
                constant: 1e-3 * number,
            };
            let (place, node) = nearest(&parameters, &OF_WINDOWS, 2.0);
            let (path, known) = (parameters.paths[0], node.paths[0]);
            assert!((path.delay_chips - known.delay_chips).abs() <= 0.5001 / 32.0);
            assert!((path.ln_rate.exp() - known.ln_rate.exp()).abs() <= 0.002_001);
            assert!((parameters.constant - node.constant).abs() <= 0.002_001);
            assert_eq!(nearest(&node, &OF_WINDOWS, 2.0).0, place);
        }
    }
}
