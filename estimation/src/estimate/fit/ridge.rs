//! How far two close paths may be from where they fit best.
//!
//! Counts tell the middle of two close paths and how wide they spread; how their light is
//! shared out, and with it where each of them is, they tell much less. Chi-square then has a
//! valley that bends: a narrow second path far out spreads as wide as an equal one nearby. No
//! covariance at its lowest point says how long it is. So it is walked, with the ratio of the
//! two held at one value after another and all else fitted anew (a profile likelihood).

use super::descent::Hypothesis;
use super::normal::Normal;
use super::parameters::PathParameters;
use super::search::Search;

/// Ratios that are known better than this, in e-folds, bend nothing.
const KNOWN_LN_RATIO: f64 = 0.2;
/// Steps of ln(ratio), in its standard deviations where the valley is lowest, and the largest.
const STEP_SIGMAS: f64 = 0.75;
const MOST_STEP: f64 = 0.5;
/// Most steps to each side.
const MOST_STEPS: usize = 16;
/// Ratios this much worse, in chi-square, are left out: they would have a weight of 0.5 %.
const UNLIKELY: f64 = 10.6;
/// Largest ln(ratio) of the two: what is weaker is no second path.
const MOST_LN_RATIO: f64 = 3.5;

/// A point of the valley: how well it fits, and the two paths there.
struct RidgePoint {
    chi_square: f64,
    paths: [PathParameters; 2],
}

impl RidgePoint {
    fn of(here: &Hypothesis, pair: [usize; 2]) -> RidgePoint {
        RidgePoint {
            chi_square: here.chi_square,
            paths: pair.map(|path| here.parameters.paths[path].clone()),
        }
    }

    fn ln_ratio(&self) -> f64 {
        self.paths[1].ln_rate - self.paths[0].ln_rate
    }
}

/// What is to be added to the variances of delay (chips^2) and ln(strength) of two paths, by
/// number, that the normal equations of the best fit say: how far along the valley they may be,
/// in place of what a straight valley would make of it, which may be more. Any ln(ratio) is as
/// likely before anything is counted. `None` where the ratio is known so well that the valley
/// does not bend.
pub fn beyond_normal<'m>(
    search: &Search<'_, 'm>,
    best: &Hypothesis<'m>,
    normal: &Normal,
    pair @ [first, second]: [usize; 2],
) -> Option<[[f64; 2]; 2]> {
    let ln_ratio = best.parameters.ln_ratio(first, second);
    let ln_ratio_std = normal.standard_deviation_of(&ln_ratio);
    if ln_ratio_std < KNOWN_LN_RATIO {
        return None;
    }
    let [straight, across] = [normal, &normal.holding(&ln_ratio)].map(Normal::standard_deviations);
    let along = mean_squares(&walk(search, best, pair, ln_ratio_std));
    let added = |path: usize, which: usize| {
        let unknown = 2 * pair[path] + which;
        across[unknown].powi(2) + along[path][which] - straight[unknown].powi(2)
    };
    Some([0, 1].map(|path| [added(path, 0), added(path, 1)]))
}

/// Places along the valley of two paths; the first is where they fit best.
fn walk<'m>(
    search: &Search<'_, 'm>,
    best: &Hypothesis<'m>,
    pair: [usize; 2],
    ln_ratio_std: f64,
) -> Vec<RidgePoint> {
    let step = (STEP_SIGMAS * ln_ratio_std).min(MOST_STEP);
    let mut found = vec![RidgePoint::of(best, pair)];
    for side in [-step, step] {
        let mut here = best.clone();
        for _ in 0..MOST_STEPS {
            // Light that has no response ends the valley.
            let Ok(next) = search.with_ratio(&here, pair, side) else {
                break;
            };
            let place = RidgePoint::of(&next, pair);
            if place.ln_ratio().abs() > MOST_LN_RATIO
                || place.chi_square > best.chi_square + UNLIKELY
            {
                break;
            }
            found.push(place);
            here = next;
        }
    }
    found
}

/// Mean squares by which delay and ln(strength) of each path are elsewhere than in the first
/// place, each place as likely as it fits.
fn mean_squares(places: &[RidgePoint]) -> [[f64; 2]; 2] {
    let lowest = places.iter().map(|place| place.chi_square);
    let lowest = lowest.fold(f64::INFINITY, f64::min);
    let (mut all, mut squares) = (0.0, [[0.0; 2]; 2]);
    for place in places {
        let weight = (-0.5 * (place.chi_square - lowest)).exp();
        all += weight;
        for (square, (here, first)) in
            squares.iter_mut().zip(place.paths.iter().zip(&places[0].paths))
        {
            square[0] += weight * (here.delay_chips - first.delay_chips).powi(2);
            square[1] += weight * (here.ln_rate - first.ln_rate).powi(2);
        }
    }
    squares.map(|square| square.map(|sum| sum / all))
}
