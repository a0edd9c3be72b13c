//! Two paths of one code that are closer together than their peaks are wide.
//!
//! The residual of one path fitted to two has no peak. So pairs of delays on a grid are compared
//! with the one path to first order, and the best of them are fitted. Two paths are told apart if
//! chi-square falls further than noise makes it fall in one of a thousand scans.

use std::sync::Arc;

use super::descent::Hypothesis;
use super::parameters::{FitParameters, PathParameters};
use super::search::FitSearch;
use super::template::Matched;

/// Two paths are told apart if chi-square falls by this. Measured: with one path alone the largest
/// fall over all pairs is as large in 1.0, 1.3, and 0.9 of a thousand scans, at peak signal-to-noise
/// ratios of 10, 36, and 150.
pub const TOLD_APART: f64 = 13.8;

/// Pairs that gain less than this to first order are not fitted.
const WORTH_A_FIT: f64 = 8.0;
/// Pairs that are fitted.
const FITTED: usize = 3;
/// Farthest from the one path, in chips.
pub const REACH_CHIPS: f64 = 1.5;
/// Least share of the light that the weaker one has.
pub const LEAST_SHARE: f64 = 0.03;

/// A path that may be two.
struct Close<'a, 's, 'm> {
    search: &'a FitSearch<'s, 'm>,
    here: &'a Hypothesis<'m>,
    path: &'a PathParameters,
    matched: &'a Matched,
    /// Products of the template with the residual.
    products: Vec<f64>,
    /// What a pair must gain at least, to first order.
    least_gain: f64,
}

/// A place of the grid: the two neighbouring phase steps, relative to the path.
struct Slot {
    ends: [f64; 2],
    /// Product of its template with the scan, less all light but the path's.
    product: f64,
}

impl Slot {
    fn middle(&self) -> f64 {
        0.5 * (self.ends[0] + self.ends[1])
    }
}

/// The likeliest pairs in place of path number `path`, the best first: none where its code may have
/// no further path. To first order each lowers chi-square by more than `least_gain`.
pub fn pairs<'m>(
    search: &FitSearch<'_, 'm>,
    here: &Hypothesis<'m>,
    path: usize,
    least_gain: f64,
) -> Vec<Hypothesis<'m>> {
    let lit = &here.parameters.paths[path];
    let mut known = search.air.known.iter().filter(|known| search.air.room(known, here) > 0);
    let Some(candidate) = known.find(|known| lit.has(&known.code)) else { return Vec::new() };
    let matched = &candidate.matched;
    let products = matched.products(&search.air.axis, &search.residual(here));
    let close = Close { search, here, path: lit, matched, products, least_gain };
    // A pair whose fit fails is left out.
    let fitted = starts(&close, &slots(&close)).into_iter().filter_map(|[first, second]| {
        let in_place = |light: &mut FitParameters| {
            light.paths[path] = first;
            light.paths.push(second);
        };
        search.fitted(here, in_place).ok()
    });
    let mut fitted: Vec<Hypothesis> = fitted.collect();
    fitted.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    fitted
}

/// Whether the counts tell a pair from the one path `path` of `here`: it gains enough, and both of
/// its paths have light.
pub fn is_told_apart(here: &Hypothesis, pair: &Hypothesis, path: usize) -> bool {
    let last = pair.parameters.paths.len() - 1;
    let [a, b] = [path, last].map(|p| pair.parameters.paths[p].rate());
    here.chi_square - pair.chi_square > TOLD_APART && a.min(b) > LEAST_SHARE * (a + b)
}

/// Half a phase step from place to place.
fn slots(close: &Close) -> Vec<Slot> {
    let axis = &close.search.air.axis;
    let centre = axis.place_of(close.path.delay_chips);
    let first = centre.floor();
    let height = close.path.rate() * close.search.unit(close.here);
    let reach = (REACH_CHIPS * axis.samples_per_chip).ceil().max(2.0) as i64;
    let steps = close.products.len() as i64;
    let product = |place: f64| {
        let index = place as i64;
        let index = match axis.is_full() {
            true => index.rem_euclid(steps),
            false => index,
        };
        let left_over = usize::try_from(index).ok().and_then(|i| close.products.get(i));
        Some(left_over? + height * close.matched.overlap(place - centre))
    };
    (-2 * reach..=2 * reach)
        .filter_map(|half| {
            let low = first + half.div_euclid(2) as f64;
            let ends = [low, low + half.rem_euclid(2) as f64];
            let product = 0.5 * (product(ends[0])? + product(ends[1])?);
            Some(Slot { ends, product })
        })
        .collect()
}

/// The pairs that gain most, and their strengths.
fn starts(close: &Close, slots: &[Slot]) -> Vec<[PathParameters; 2]> {
    let overlap = |a: &Slot, b: &Slot| {
        let pairs = a.ends.iter().flat_map(|x| b.ends.iter().map(move |y| x - y));
        0.25 * pairs.map(|apart| close.matched.overlap(apart)).sum::<f64>()
    };
    let variance = close.search.sigma().powi(2);
    let alone = slots.iter().map(|p| p.product.max(0.0).powi(2) / (overlap(p, p) * variance));
    let alone = alone.fold(0.0, f64::max);
    let mut pairs: Vec<(f64, usize, usize, [f64; 2])> = Vec::new();
    for (i, a) in slots.iter().enumerate() {
        for (j, b) in slots.iter().enumerate().skip(i + 1) {
            let (aa, bb, ab) = (overlap(a, a), overlap(b, b), overlap(a, b));
            let det = aa * bb - ab * ab;
            if det <= 1e-6 * aa * bb {
                continue;
            }
            let heights =
                [(a.product * bb - b.product * ab) / det, (b.product * aa - a.product * ab) / det];
            let least = LEAST_SHARE * (heights[0] + heights[1]);
            if heights[0] <= least || heights[1] <= least || least <= 0.0 {
                continue;
            }
            let gain = (heights[0] * a.product + heights[1] * b.product) / variance - alone;
            if gain > close.least_gain.max(WORTH_A_FIT) {
                pairs.push((gain, i, j, heights));
            }
        }
    }
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<(usize, usize)> = Vec::new();
    let mut starts = Vec::new();
    let axis = &close.search.air.axis;
    let unit = close.search.unit(close.here);
    for (_, i, j, heights) in pairs {
        let is_near = |&(k, l): &(usize, usize)| i.abs_diff(k) <= 2 && j.abs_diff(l) <= 2;
        if chosen.iter().any(is_near) {
            continue;
        }
        chosen.push((i, j));
        let path = |slot: &Slot, height: f64| PathParameters {
            code: Arc::clone(&close.path.code),
            delay_chips: axis.delay_at(slot.middle()),
            ln_rate: (height / unit).max(1e-12).ln(),
        };
        starts.push([path(&slots[i], heights[0]), path(&slots[j], heights[1])]);
        if starts.len() == FITTED {
            break;
        }
    }
    starts
}
