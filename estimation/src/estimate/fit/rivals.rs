//! How far paths may be from where they fit best, beyond what the normal equations say.
//!
//! A variance is that within hypotheses and that between them (the law of total variance). Each
//! hypothesis has a weight of exp(-(chi-square + penalty) / 2), where the penalty of a path is the
//! fall of chi-square by which it must show to be accepted.
//!
//! Two kinds of hypotheses come into question. One has two close paths where one was taken, or the
//! other way round, or another pair. The other shares the light of a close pair out anew: counts
//! tell the middle of the two and how wide they spread, and hardly their ratio, and with it where
//! each of them is. Chi-square then has a valley that bends: a faint second path far out spreads as
//! wide as an equal one nearby. No covariance at its lowest point says how long it is. So it is
//! walked, with the ratio held at one value after another and all else fitted anew (a profile
//! likelihood).

use super::descent::Hypothesis;
use super::normal::Normal;
use super::pairs::{REACH_CHIPS, TOLD_APART, pairs};
use super::search::FitSearch;

/// Ratios that are known better than this, in e-folds, bend nothing.
const KNOWN_LN_RATIO: f64 = 0.2;
/// Steps of ln(ratio), in its standard deviations where the valley is lowest, and the largest.
const STEP_SIGMAS: f64 = 0.75;
const MOST_STEP: f64 = 0.5;
/// Most steps to each side.
const MOST_STEPS: usize = 16;
/// The walk ends where chi-square is this much worse: that has a weight of 0.5 %.
const UNLIKELY: f64 = 10.6;
/// Largest ln(ratio) of two paths: a fainter second one is not accepted.
const MOST_LN_RATIO: f64 = 3.5;
/// A hypothesis whose paths are all within this of those that were taken is the same one.
const SAME_CHIPS: f64 = 1.0 / 64.0;

/// By how much the unlikelihood, -2 ln(weight), of a hypothesis exceeds that of the one that was
/// taken, and the squares by which delay (chips) and ln(strength) of a path differ.
type Rival = (f64, [f64; 2]);

/// What hypotheses beside the one that was taken make of it.
#[derive(Debug)]
pub struct Beyond {
    /// To be added to the variances of each path's delay (chips^2) and ln(strength).
    pub variances: Vec<[f64; 2]>,
    /// Least fall of chi-square by which two close paths show that they are not one; infinite without such.
    pub least_fall: f64,
}

/// What is to be added to the variances of delay and strength of each path that the normal equations of the fit that
/// was taken say, and how surely close paths are told apart.
pub fn beyond_normal<'m>(
    search: &FitSearch<'_, 'm>,
    taken: &Hypothesis<'m>,
    normal: &Normal,
) -> Beyond {
    let paths = &taken.parameters.paths;
    let mut least_fall = f64::INFINITY;
    let mut rivals = Rivals { taken, of_paths: vec![Vec::new(); paths.len()] };
    let mut bent: Vec<Option<[f64; 2]>> = vec![None; paths.len()];
    for second in 0..paths.len() {
        pairs(search, taken, second, 0.0).iter().for_each(|pair| rivals.add(pair, &[second]));
        for first in 0..second {
            let apart = (paths[first].delay_chips - paths[second].delay_chips).abs();
            let pair = [first, second];
            if apart > REACH_CHIPS || !paths[first].has(&paths[second].code) {
                continue;
            }
            let Some(valley) = valley(search, taken, normal, pair) else { continue };
            for (path, added) in pair.into_iter().zip(valley) {
                // Each says all there is of a path's variance, so that the largest holds.
                let known = bent[path].unwrap_or(added);
                bent[path] = Some([known[0].max(added[0]), known[1].max(added[1])]);
            }
            let Ok(one) = search.fitted(taken, |light| light.merge_paths(pair)) else { continue };
            least_fall = least_fall.min(one.chi_square - taken.chi_square);
            rivals.add(&one, &pair);
            pairs(search, &one, first, 0.0).iter().for_each(|other| rivals.add(other, &pair));
        }
    }
    let both = rivals.of_paths.iter().zip(bent);
    let variances = both.map(|(rivals, bent)| {
        let (between, bent) = (mean_squares(rivals), bent.unwrap_or_default());
        [between[0] + bent[0], between[1] + bent[1]]
    });
    Beyond { variances: variances.collect(), least_fall }
}

/// Hypotheses beside the one that was taken, path by path.
struct Rivals<'a, 'm> {
    taken: &'a Hypothesis<'m>,
    of_paths: Vec<Vec<Rival>>,
}

impl Rivals<'_, '_> {
    /// Adds one that has other paths in place of some of those taken. What is nearby in either is
    /// not in question.
    fn add(&mut self, other: &Hypothesis, in_place_of: &[usize]) {
        let unlikelihood = |light: &Hypothesis| {
            light.chi_square + TOLD_APART * light.parameters.paths.len() as f64
        };
        let more = unlikelihood(other) - unlikelihood(self.taken);
        let off_chips = |&path: &usize| {
            let path = &self.taken.parameters.paths[path];
            let lit = other.parameters.paths.iter().filter(|lit| lit.has(&path.code));
            let off = lit.map(|lit| (lit.delay_chips - path.delay_chips).abs());
            off.fold(f64::INFINITY, f64::min)
        };
        let off_chips: Vec<f64> = in_place_of.iter().map(off_chips).collect();
        if off_chips.iter().all(|off| *off < SAME_CHIPS) {
            return;
        }
        for (&path, off) in in_place_of.iter().zip(off_chips).filter(|(_, off)| *off < REACH_CHIPS)
        {
            self.of_paths[path].push((more, [off * off, 0.0]));
        }
    }
}

/// Mean squares over the one that was taken and its rivals.
fn mean_squares(rivals: &[Rival]) -> [f64; 2] {
    let least = rivals.iter().fold(0.0, |least: f64, (more, _)| least.min(*more));
    let (mut all, mut sums) = ((0.5 * least).exp(), [0.0; 2]);
    for (more, squares) in rivals {
        let weight = (-0.5 * (more - least)).exp();
        all += weight;
        sums = [0, 1].map(|which| sums[which] + weight * squares[which]);
    }
    sums.map(|sum| sum / all)
}

/// What the valley of two paths adds to the variances of each, in place of what a straight valley
/// would make of it, which may be more. Any ln(ratio) is as likely before anything is counted.
/// `None` where the ratio is known so well that the valley does not bend.
fn valley<'m>(
    search: &FitSearch<'_, 'm>,
    taken: &Hypothesis<'m>,
    normal: &Normal,
    pair @ [first, second]: [usize; 2],
) -> Option<[[f64; 2]; 2]> {
    let ln_ratio = taken.parameters.ln_ratio(first, second);
    let ln_ratio_std = normal.standard_deviation_of(&ln_ratio);
    if ln_ratio_std < KNOWN_LN_RATIO {
        return None;
    }
    let [straight, across] = [normal, &normal.holding(&ln_ratio)].map(Normal::standard_deviations);
    let along = walk(search, taken, pair, ln_ratio_std).map(|rivals| mean_squares(&rivals));
    let added = |path: usize, which: usize| {
        let unknown = 2 * pair[path] + which;
        across[unknown].powi(2) + along[path][which] - straight[unknown].powi(2)
    };
    Some([0, 1].map(|path| [added(path, 0), added(path, 1)]))
}

/// Places along the valley of two paths, for each of the two.
fn walk<'m>(
    search: &FitSearch<'_, 'm>,
    taken: &Hypothesis<'m>,
    pair: [usize; 2],
    ln_ratio_std: f64,
) -> [Vec<Rival>; 2] {
    let step = (STEP_SIGMAS * ln_ratio_std).min(MOST_STEP);
    let mut found = [Vec::new(), Vec::new()];
    for side in [-step, step] {
        let mut here = taken.clone();
        for _ in 0..MOST_STEPS {
            // Light that has no response ends the valley.
            let Ok(next) = search.with_ratio(&here, pair, side) else { break };
            let [first, second] = pair.map(|path| &next.parameters.paths[path]);
            let more = next.chi_square - taken.chi_square;
            if (second.ln_rate - first.ln_rate).abs() > MOST_LN_RATIO || more > UNLIKELY {
                break;
            }
            for (found, path) in found.iter_mut().zip(pair) {
                let [there, best] = [&next, taken].map(|light| &light.parameters.paths[path]);
                let delay = there.delay_chips - best.delay_chips;
                let ln_rate = there.ln_rate - best.ln_rate;
                found.push((more, [delay * delay, ln_rate * ln_rate]));
            }
            here = next;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of two that are as likely, and one whose odds are e to 1: the variance of a mixture by hand.
    #[test]
    fn rivals_count_as_much_as_they_are_likely() {
        assert_eq!(mean_squares(&[]), [0.0; 2]);
        assert_eq!(mean_squares(&[(0.0, [4.0, 1.0])]), [2.0, 0.5]);
        let e = std::f64::consts::E;
        let [delay, _] = mean_squares(&[(-2.0, [1.0, 0.0])]);
        assert!((delay - e / (1.0 + e)).abs() < 1e-12, "{delay}");
        assert!(mean_squares(&[(2000.0, [1.0, 1.0])])[0] < 1e-12);
    }
}
