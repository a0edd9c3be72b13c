//! The unknowns of a fit, their steps for derivatives, and what these are of counts.

use std::sync::Arc;

use super::normal::Normal;
use crate::code::Code;
use crate::response::{Light, LightPath, MeanCount};

/// Steps for derivatives: delay in chips, and light as a share of what it is.
pub const DELAY_STEP_CHIPS: f64 = 2e-3;
const LIGHT_STEP: f64 = 5e-3;

/// Derivatives are good for steps of a fit this near: delay in chips, and shares of
/// the light.
const LINEAR_CHIPS: f64 = 1.0 / 64.0;
const LINEAR_SHARE: f64 = 0.03;

/// Two peaks of a code's correlation, a chip to either side, and where light of either may be looked for beside them.
const PEAKS_MEET_CHIPS: f64 = 3.0;

/// Farthest that one step of a fit moves a delay, in chips, and the logarithm of a strength.
const MOST_DELAY_STEP: f64 = 0.5;
const MOST_LN_RATE_STEP: f64 = 2.0;

/// The unknowns: delay and ln(strength) of each path, how the only path moves if it does, and
/// the background, in this order.
#[derive(Debug, Clone, PartialEq)]
pub struct FitParameters {
    pub paths: Vec<PathParameters>,
    /// Change of the delay per time, 2 v / c; `None` of paths that stand still. The delay is
    /// then that at the [problem's moment](super::problem::Problem::moment_ps).
    pub walk: Option<f64>,
    /// Background per chip.
    pub constant: f64,
}

/// A path: its code, and what is unknown of it.
#[derive(Debug, Clone, PartialEq)]
pub struct PathParameters {
    pub code: Arc<Code>,
    pub delay_chips: f64,
    /// Logarithm of what an on-chip adds to the primary rate per chip.
    pub ln_rate: f64,
}

impl PathParameters {
    /// What an on-chip adds to the primary rate per chip.
    pub fn rate(&self) -> f64 {
        self.ln_rate.exp()
    }

    /// The mean of that over the code.
    pub fn mean_rate(&self) -> f64 {
        self.rate() * share_of_ones(&self.code)
    }

    /// How far it is from another one of its code, the shorter way round.
    pub fn chips_from(&self, other: &PathParameters) -> f64 {
        let period_chips = self.code.len() as f64;
        let later = (other.delay_chips - self.delay_chips).rem_euclid(period_chips);
        later.min(period_chips - later)
    }

    /// Whether the path's light has that code.
    pub fn has(&self, code: &Code) -> bool {
        self.code.chips == code.chips
    }
}

/// Ones among a code's chips.
pub fn share_of_ones(code: &Code) -> f64 {
    code.weight() as f64 / code.len() as f64
}

/// Derivatives of every step's means by one unknown.
pub type DerivativeColumn = Vec<MeanCount>;

impl FitParameters {
    /// Those of some light.
    pub fn of(light: &Light) -> FitParameters {
        let path = |path: &LightPath| PathParameters {
            code: Arc::clone(&path.code),
            delay_chips: path.delay_chips,
            ln_rate: path.rate_per_chip.ln(),
        };
        FitParameters {
            paths: light.paths.iter().map(path).collect(),
            walk: None,
            constant: light.constant_per_chip,
        }
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        2 * self.paths.len() + usize::from(self.walk.is_some()) + 1
    }

    /// The solution of the normal equations, with every unknown within reach, a background that is
    /// not negative, and a walk of `most_walk` at most.
    pub fn step(&self, normal: &Normal, most_walk: f64) -> Vec<f64> {
        let reach = [MOST_DELAY_STEP, MOST_LN_RATE_STEP].map(|most| [-most, most]);
        let mut limits: Vec<[f64; 2]> = self.paths.iter().flat_map(|_| reach).collect();
        limits.extend(self.walk.map(|walk| [-most_walk - walk, most_walk - walk]));
        limits.push([-self.constant, f64::INFINITY]);
        normal.solution_within(&limits)
    }

    /// All unknowns moved by a step.
    pub fn moved(&self, step: &[f64]) -> FitParameters {
        let mut moved = self.clone();
        for (path, step) in moved.paths.iter_mut().zip(step.chunks(2)) {
            path.delay_chips += step[0];
            path.ln_rate += step[1];
        }
        if let Some(walk) = &mut moved.walk {
            *walk += step[2 * self.paths.len()];
        }
        moved.constant = (self.constant + step[step.len() - 1]).max(0.0);
        moved
    }

    /// The same with all light later by some chips.
    pub fn later(&self, chips: f64) -> FitParameters {
        let mut later = self.clone();
        later.paths.iter_mut().for_each(|path| path.delay_chips += chips);
        later
    }

    /// Whether each path stands by itself: none of its own code is so near that their peaks meet.
    pub fn are_apart(&self) -> bool {
        self.pairs_within(PEAKS_MEET_CHIPS).next().is_none()
    }

    /// Pairs of paths of one code that are no more than so many chips apart.
    pub fn pairs_within(&self, chips: f64) -> impl Iterator<Item = [&PathParameters; 2]> {
        let pairs = self.paths.iter().enumerate().flat_map(|(number, path)| {
            self.paths[number + 1..].iter().map(move |other| [path, other])
        });
        pairs.filter(move |[path, other]| other.has(&path.code) && path.chips_from(other) <= chips)
    }

    /// The differences of all unknowns.
    pub fn minus(&self, other: &FitParameters) -> Vec<f64> {
        let pairs = self.paths.iter().zip(&other.paths);
        let mut differences: Vec<f64> = pairs
            .flat_map(|(a, b)| [a.delay_chips - b.delay_chips, a.ln_rate - b.ln_rate])
            .collect();
        differences.extend(self.walk.zip(other.walk).map(|(a, b)| a - b));
        differences.push(self.constant - other.constant);
        differences
    }

    /// Whether derivatives at `other` are too far off for a fit that is here.
    pub fn differ_from(&self, other: &FitParameters) -> bool {
        let differences = self.minus(other);
        let (paths, rest) = differences.split_at(2 * self.paths.len());
        let far = |path: &[f64]| path[0].abs() > LINEAR_CHIPS || path[1].abs() > LINEAR_SHARE;
        let constant = rest.last().copied().unwrap_or_default();
        paths.chunks(2).any(far)
            || self.walk != other.walk
            || constant.abs() > LINEAR_SHARE * self.brightest()
    }

    /// Whether counts scatter otherwise under the light of `other`: some of it differs by more than a
    /// share of all light.
    pub fn differ_in_light_from(&self, other: &FitParameters) -> bool {
        let near = |here: f64, there: f64| (here - there).abs() <= LINEAR_SHARE * self.brightest();
        let mut pairs = self.paths.iter().zip(&other.paths);
        !near(self.constant, other.constant)
            || !pairs.all(|(here, there)| near(here.rate(), there.rate()))
    }

    /// Adds a path, whose mean is taken from the background.
    pub fn add_path(&mut self, path: PathParameters) {
        self.constant = (self.constant - path.mean_rate()).max(0.1 * self.constant);
        self.paths.push(path);
    }

    /// Removes a path, whose mean goes to the background.
    pub fn remove_path(&mut self, path: usize) {
        self.constant += self.paths.remove(path).mean_rate();
    }

    /// One path in the place of two of one code; the second number is the larger one.
    pub fn merge_paths(&mut self, [first, second]: [usize; 2]) {
        let gone = self.paths.remove(second);
        let kept = &mut self.paths[first];
        let all = kept.rate() + gone.rate();
        kept.delay_chips += gone.rate() / all * (gone.delay_chips - kept.delay_chips);
        kept.ln_rate = all.ln();
    }

    /// Changes the logarithm of two paths' ratio; their centroid, total light and second moment stay.
    pub fn share_anew(&mut self, [first, second]: [usize; 2], by: f64) {
        let [rate_a, rate_b] = [first, second].map(|path| self.paths[path].rate());
        let [early, late] = [first, second].map(|path| self.paths[path].delay_chips);
        let all = rate_a + rate_b;
        let share = rate_b / all;
        let next = 1.0 / (1.0 + rate_a / rate_b * (-by).exp());
        let middle = early + share * (late - early);
        let wider = (share * (1.0 - share) / (next * (1.0 - next))).sqrt();
        let apart = wider * (late - early);
        let moved = [(first, -next, 1.0 - next), (second, 1.0 - next, next)];
        for (path, side, share) in moved {
            self.paths[path].delay_chips = middle + side * apart;
            self.paths[path].ln_rate = (share * all).ln();
        }
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

    /// Number of the unknown that is the walk.
    pub fn walk_index(&self) -> Option<usize> {
        self.walk.map(|_| 2 * self.paths.len())
    }

    /// All light together, per chip.
    pub fn brightest(&self) -> f64 {
        self.constant + self.paths.iter().map(PathParameters::rate).sum::<f64>()
    }

    /// Unknown number `index`, which is not the walk, moved by `sign` times its step for
    /// derivatives, or by as much of it as is possible, and that step.
    pub fn nudged(&self, index: usize, sign: f64) -> (FitParameters, f64) {
        let mut nudged = self.clone();
        let step = match nudged.paths.get_mut(index / 2) {
            Some(path) if index.is_multiple_of(2) => {
                path.delay_chips += sign * DELAY_STEP_CHIPS;
                DELAY_STEP_CHIPS
            }
            Some(path) => {
                path.ln_rate += sign * LIGHT_STEP;
                LIGHT_STEP
            }
            None => {
                // There is no less light than none.
                let step = (sign * LIGHT_STEP * self.brightest()).max(-self.constant);
                nudged.constant += step;
                return (nudged, step);
            }
        };
        (nudged, sign * step)
    }
}

/// Differences of counts over a step of an unknown.
pub fn slope(from: &[MeanCount], to: &[MeanCount], step: f64) -> DerivativeColumn {
    from.iter()
        .zip(to)
        .map(|(a, b)| MeanCount {
            signed: (b.signed - a.signed) / step,
            total: (b.total - a.total) / step,
        })
        .collect()
}
