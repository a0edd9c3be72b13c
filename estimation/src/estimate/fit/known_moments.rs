//! Second moments for fits, computed once for similar light.
//!
//! They cost more than the rest of a fit, and per detection they hardly change with the light. So
//! they are taken per detection from the nearest node of a grid of the unknowns, which does not
//! depend on what was fitted before.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::moments::ProblemMoments;
use super::parameters::{DerivativeColumn, FitParameters, PathParameters};
use super::problem::{Problem, ResponseReading, Sides};
use super::slipping::SlippingLight;
use super::template::DelayAxis;
use super::weights::Weights;
use crate::response::{MeanCount, MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;

/// Distance of nodes: delays in chips, and rates times dead time, which is what
/// moments per detection depend on.
struct Spacing {
    delay_chips: f64,
    saturation: f64,
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
fn octave(parameters: &FitParameters, dead_time_chips: f64) -> i32 {
    let saturation = parameters.brightest() * dead_time_chips.max(0.1);
    saturation.ln_1p().div_euclid(std::f64::consts::LN_2) as i32
}

/// Half a spacing changes moments by less than a per cent: chi-square of a thousand counts
/// has a spread of 4 %.
const OF_STEPS: Spacing = Spacing { delay_chips: 1.0 / 32.0, saturation: 0.008 };

/// Steps that count the same light differ by what comes within a phase step of the
/// reference's edges, where the light changes.
const OF_SHARED_STEPS: Spacing = Spacing { delay_chips: 1.0 / 128.0, ..OF_STEPS };

/// For derivatives: a peak's corners are round within some hundredths of a chip.
const OF_SLOPES: Spacing = Spacing { delay_chips: 1.0 / 64.0, saturation: 0.016 };

/// Steps of all nodes together that are kept: bounds the memory, at 64 bytes for each step
/// of one path.
const MOST_KEPT_STEPS: usize = 1 << 20;

/// Most nodes of a problem that are kept.
fn most_kept(problem: &Problem) -> usize {
    MOST_KEPT_STEPS / problem.steps.len().max(1)
}

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

impl Key {
    fn new(problem: &Problem, parameters: &FitParameters, place: Vec<i64>) -> Key {
        Key {
            steps: match problem.takes_all_steps() {
                true => Vec::new(),
                false => problem.steps.clone(),
            },
            codes: parameters.paths.iter().map(|path| path.code.chips.clone()).collect(),
            place,
        }
    }
}

/// Expected counts of a node's light, and their derivatives.
pub struct Linear {
    pub parameters: FitParameters,
    pub means: Vec<MeanCount>,
    pub columns: Vec<DerivativeColumn>,
}

impl Linear {
    /// Whether the derivatives are good for some parameters: half as far again as to
    /// the border to the next node.
    pub fn holds_for(&self, parameters: &FitParameters, problem: &Problem) -> bool {
        let dead_time_chips = problem.model.dead_time_chips;
        let octave = octave(&self.parameters, dead_time_chips);
        let rate = 0.75 * OF_SLOPES.rate(octave, dead_time_chips);
        let pairs = parameters.paths.iter().zip(&self.parameters.paths);
        let mut near = pairs.map(|(here, node)| {
            (here.delay_chips - node.delay_chips).abs() <= 0.75 * OF_SLOPES.delay_chips
                && (here.rate() - node.rate()).abs() <= rate
        });
        near.all(|near| near) && (parameters.constant - self.parameters.constant).abs() <= rate
    }

    /// Derivatives for strengths near the node's: by delay and by the logarithm of the
    /// strength they go with the strength.
    pub fn columns_at(&self, parameters: &FitParameters) -> Vec<DerivativeColumn> {
        let ratios = parameters.paths.iter().zip(&self.parameters.paths);
        let ratios = ratios.flat_map(|(here, node)| [(here.ln_rate - node.ln_rate).exp(); 2]);
        let ratios = ratios.chain([1.0]);
        let scaled = |(column, ratio): (&DerivativeColumn, f64)| {
            let entries = column.iter().map(|entry| MeanCount {
                signed: entry.signed * ratio,
                total: entry.total * ratio,
            });
            entries.collect()
        };
        self.columns.iter().zip(ratios).map(scaled).collect()
    }
}

/// Results at the nodes that were needed so far.
type Nodes<T> = Mutex<HashMap<Key, Arc<T>>>;

/// Second moments at nodes that were needed so far, and expectations with their
/// derivatives.
#[derive(Default)]
pub struct KnownMoments {
    moments: Nodes<ProblemMoments>,
    linear: Nodes<Linear>,
    slipping: OnceLock<Result<SlippingLight, MeanResponseError>>,
}

impl KnownMoments {
    /// The weights of a problem's counts at `parameters`, which expect `means`.
    pub fn weights(
        &self,
        problem: &Problem,
        parameters: &FitParameters,
        means: &[MeanCount],
        axis: &DelayAxis,
    ) -> Result<Weights, MeanResponseError> {
        let slipping = self.slipping(problem)?;
        let spacing = if problem.shares_light() { &OF_SHARED_STEPS } else { &OF_STEPS };
        problem.weights(axis, parameters, means, slipping, |few| {
            nearest_known(&self.moments, few, parameters, spacing, |_, response| {
                Ok(ProblemMoments::of(few, &SecondMoments::new(response)?))
            })
        })
    }

    /// Light of clocks of their own, which is the same for all scans, if there is any.
    pub fn slipping(&self, problem: &Problem) -> Result<Option<&SlippingLight>, MeanResponseError> {
        let slipping =
            self.slipping.get_or_init(|| SlippingLight::new(problem.model, problem.tier));
        Ok(Some(slipping.as_ref().map_err(Clone::clone)?).filter(|slipping| !slipping.is_none()))
    }

    /// Expectation and derivatives at the node nearest to some parameters.
    pub fn linear(
        &self,
        problem: &Problem,
        parameters: &FitParameters,
    ) -> Result<Arc<Linear>, MeanResponseError> {
        nearest_known(&self.linear, problem, parameters, &OF_SLOPES, |node, response| {
            Ok(Linear {
                means: problem.means_of(&node, response)?,
                columns: problem.jacobian(&node, response, ResponseReading::Exact, Sides::Both)?,
                parameters: node,
            })
        })
    }
}

/// The entry of the node nearest to some parameters, computed by `of_node` if it is missing.
fn nearest_known<T>(
    nodes: &Nodes<T>,
    problem: &Problem,
    parameters: &FitParameters,
    spacing: &Spacing,
    of_node: impl FnOnce(FitParameters, &MeanResponse) -> Result<T, MeanResponseError>,
) -> Result<Arc<T>, MeanResponseError> {
    let (place, node) = nearest(parameters, spacing, problem.model.dead_time_chips);
    let key = Key::new(problem, parameters, place);
    // A thread that panicked has left the map whole.
    let nodes = || nodes.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = nodes().get(&key) {
        return Ok(Arc::clone(known));
    }
    let response = problem.response(&node)?;
    let found = Arc::new(of_node(node, &response)?);
    let mut nodes = nodes();
    if nodes.len() < most_kept(problem) {
        nodes.insert(key, Arc::clone(&found));
    }
    Ok(found)
}

impl fmt::Debug for KnownMoments {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("KnownMoments").finish_non_exhaustive()
    }
}

/// The node nearest to some parameters, and its octave and numbers. Rates of nodes are odd
/// multiples of half a spacing: there is some light at every node.
fn nearest(
    parameters: &FitParameters,
    spacing: &Spacing,
    dead_time_chips: f64,
) -> (Vec<i64>, FitParameters) {
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
    let rates: Vec<f64> = parameters.paths.iter().map(|path| rate(path.rate())).collect();
    let constant = rate(parameters.constant);
    let paths = parameters.paths.iter().zip(rates);
    let paths = paths.map(|(path, rate)| PathParameters {
        code: Arc::clone(&path.code),
        delay_chips: numbered((path.delay_chips / spacing.delay_chips).round())
            * spacing.delay_chips,
        ln_rate: rate.ln(),
    });
    let node = FitParameters { paths: paths.collect(), walk: None, constant };
    (place, node)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::code::{CodeSpec, Family};

    #[test]
    fn a_node_is_within_half_a_spacing_and_its_own_nearest() {
        let spec = CodeSpec { degree: Some(5), ..CodeSpec::new(Family::MSequence) };
        let code = Arc::new(spec.build().expect("a code"));
        for number in 0..50 {
            let number = f64::from(number);
            let parameters = FitParameters {
                paths: vec![PathParameters {
                    code: Arc::clone(&code),
                    delay_chips: 2.0 + 0.0137 * number,
                    ln_rate: -4.0 + 0.0311 * number,
                }],
                walk: None,
                constant: 1e-3 * number,
            };
            let (place, node) = nearest(&parameters, &OF_STEPS, 2.0);
            let (path, known) = (&parameters.paths[0], &node.paths[0]);
            assert!((path.delay_chips - known.delay_chips).abs() <= 0.5001 / 32.0);
            assert!((path.rate() - known.rate()).abs() <= 0.002_001);
            assert!((parameters.constant - node.constant).abs() <= 0.002_001);
            assert_eq!(nearest(&node, &OF_STEPS, 2.0).0, place);
        }
    }
}
