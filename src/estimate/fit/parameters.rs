//! The unknowns of a fit, their steps for derivatives, and what these are of counts.

use crate::code::Code;
use crate::response::{Light, LightPath, MeanCount};

/// Steps for derivatives: delay in chips, logarithm of a strength, and constant
/// light as a share of all light.
pub const DELAY_STEP_CHIPS: f64 = 2e-3;
const STRENGTH_STEP: f64 = 5e-3;
const CONSTANT_STEP: f64 = 5e-3;

/// Derivatives are good for steps of a fit this near: delay in chips, and shares of
/// the light.
const LINEAR_CHIPS: f64 = 1.0 / 64.0;
const LINEAR_SHARE: f64 = 0.03;

/// The unknowns: delay and ln(strength) of each path, and the background.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    pub paths: Vec<PathParameters>,
    /// Background per chip.
    pub constant: f64,
}

/// The unknowns of one path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathParameters {
    pub delay_chips: f64,
    /// Logarithm of what an on-chip adds to the primary rate per chip.
    pub ln_rate: f64,
}

/// Derivatives of every step's means by one unknown.
pub type Column = Vec<MeanCount>;

impl Parameters {
    /// Those of some light.
    pub fn of(light: &Light) -> Parameters {
        let path = |path: &LightPath| PathParameters {
            delay_chips: path.delay_chips,
            ln_rate: path.rate_per_chip.ln(),
        };
        Parameters {
            paths: light.paths.iter().map(path).collect(),
            constant: light.constant_per_chip,
        }
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        2 * self.paths.len() + 1
    }

    /// All unknowns moved by `share` of a step. Background stays at or above
    /// zero, strengths within e^2 of what they were, delays within half a chip.
    pub fn moved(&self, step: &[f64], share: f64) -> Parameters {
        let mut moved = self.clone();
        for (path, step) in moved.paths.iter_mut().zip(step.chunks(2)) {
            path.delay_chips += (share * step[0]).clamp(-0.5, 0.5);
            path.ln_rate += (share * step[1]).clamp(-2.0, 2.0);
        }
        moved.constant = (self.constant + share * step[step.len() - 1]).max(0.0);
        moved
    }

    /// The differences of all unknowns.
    pub fn minus(&self, other: &Parameters) -> Vec<f64> {
        let pairs = self.paths.iter().zip(&other.paths);
        let mut differences: Vec<f64> = pairs
            .flat_map(|(a, b)| [a.delay_chips - b.delay_chips, a.ln_rate - b.ln_rate])
            .collect();
        differences.push(self.constant - other.constant);
        differences
    }

    /// Whether derivatives at `other` are too far off for a fit that is here.
    pub fn differ_from(&self, other: &Parameters) -> bool {
        let differences = self.minus(other);
        let (constant, paths) = differences.split_last().unwrap_or((&0.0, &[]));
        let far = |path: &[f64]| path[0].abs() > LINEAR_CHIPS || path[1].abs() > LINEAR_SHARE;
        paths.chunks(2).any(far) || constant.abs() > LINEAR_SHARE * self.brightest()
    }

    /// Adds a path with a code, whose mean is taken from the background.
    pub fn add_path(&mut self, path: PathParameters, code: &Code) {
        let mean = path.ln_rate.exp() * code.weight() as f64 / code.len() as f64;
        self.constant = (self.constant - mean).max(0.1 * self.constant);
        self.paths.push(path);
    }

    /// Removes a path with a code, whose mean goes to the background.
    pub fn remove_path(&mut self, path: usize, code: &Code) {
        let gone = self.paths.remove(path);
        self.constant += gone.ln_rate.exp() * code.weight() as f64 / code.len() as f64;
    }

    /// The combination of the unknowns that is the logarithm of two paths' ratio.
    pub fn ln_ratio(&self, first: usize, second: usize) -> Vec<f64> {
        let mut combination = vec![0.0; self.len()];
        combination[2 * first + 1] = -1.0;
        combination[2 * second + 1] = 1.0;
        combination
    }

    /// Whether unknown number `index` is a delay.
    pub fn is_delay(&self, index: usize) -> bool {
        index < 2 * self.paths.len() && index.is_multiple_of(2)
    }

    /// Everything that shines, per chip.
    pub fn brightest(&self) -> f64 {
        self.constant + self.paths.iter().map(|p| p.ln_rate.exp()).sum::<f64>()
    }

    /// Unknown number `index` moved by `sign` times its step for derivatives,
    /// and that step.
    pub fn nudged(&self, index: usize, sign: f64) -> (Parameters, f64) {
        let mut nudged = self.clone();
        let step = match nudged.paths.get_mut(index / 2) {
            Some(path) if index.is_multiple_of(2) => {
                path.delay_chips += sign * DELAY_STEP_CHIPS;
                DELAY_STEP_CHIPS
            }
            Some(path) => {
                path.ln_rate += sign * STRENGTH_STEP;
                STRENGTH_STEP
            }
            None => {
                let step = CONSTANT_STEP * self.brightest();
                nudged.constant += sign * step;
                step
            }
        };
        (nudged, sign * step)
    }
}

/// Differences of counts over a step of an unknown.
pub fn slope(from: &[MeanCount], to: &[MeanCount], step: f64) -> Column {
    from.iter()
        .zip(to)
        .map(|(a, b)| MeanCount {
            signed: (b.signed - a.signed) / step,
            total: (b.total - a.total) / step,
        })
        .collect()
}
