//! Two paths of one code that are closer together than their peaks are wide.
//!
//! What one path leaves over of two is no peak. So pairs of delays on a grid are held
//! against the path, to first order; the most likely are fitted exactly, and two
//! paths are told apart if that lowers chi-square by more than noise would in one of
//! a thousand scans.

use std::sync::Arc;

use super::air::Candidate;
use super::descent::Hypothesis;
use super::parameters::{Parameters, PathParameters};
use super::search::Search;

/// Two paths are told apart if chi-square falls by this. Of one path alone it falls as far in
/// 1.0, 1.3, and 0.9 of a thousand scans, at peak signal-to-noise ratios of 10, 36, and 150: so
/// it was measured, with the largest fall over all pairs.
pub const TOLD_APART: f64 = 13.8;

/// Pairs that gain less than this to first order are not fitted.
const WORTH_A_FIT: f64 = 8.0;
/// Pairs that are fitted.
const FITTED: usize = 3;
/// Farthest from the one path, in chips.
const REACH_CHIPS: f64 = 1.5;
/// Least share of the light that the weaker one has.
const LEAST_SHARE: f64 = 0.03;
/// Fits this much worse do not count as alternatives.
const UNLIKELY: f64 = 20.0;

/// A path that may be two.
pub struct Close<'a, 's, 'm> {
    search: &'a Search<'s, 'm>,
    here: &'a Hypothesis<'m>,
    /// Number of the path.
    path: usize,
    pub candidate: &'a Candidate,
    /// Products of the template with what is left over.
    products: Vec<f64>,
    /// What a pair must gain at least, to first order.
    least_gain: f64,
}

impl<'a, 's, 'm> Close<'a, 's, 'm> {
    /// Path number `path`, if its code is known.
    pub fn of(
        search: &'a Search<'s, 'm>,
        here: &'a Hypothesis<'m>,
        path: usize,
        least_gain: f64,
    ) -> Option<Close<'a, 's, 'm>> {
        let lit = &here.parameters.paths[path];
        let candidate = search.air.known.iter().find(|known| lit.has(&known.code))?;
        let products = candidate.matched.products(&search.air.axis, &search.residual(here));
        Some(Close { search, here, path, candidate, products, least_gain })
    }
}

/// The best pair in place of a path.
#[derive(Debug, Clone)]
pub struct Split<'m> {
    pub hypothesis: Hypothesis<'m>,
    /// Whether the counts tell that there are two.
    pub is_pair: bool,
    /// Numbers of the paths that it is about, in the hypothesis that was taken.
    pub paths: Vec<usize>,
    alternatives: Vec<Alternative>,
}

/// How likely another hypothesis is beside the one taken, and its delays.
type Alternative = (f64, Vec<f64>);

impl Split<'_> {
    /// Mean square by which a path at some delay may be off.
    pub fn spread_of(&self, delay_chips: f64) -> f64 {
        let off = |delays: &[f64]| {
            let nearest = delays.iter().map(|d| (d - delay_chips).abs());
            nearest.fold(f64::INFINITY, f64::min)
        };
        let near = self.alternatives.iter().map(|(weight, delays)| (weight, off(delays)));
        near.filter(|(_, off)| *off < REACH_CHIPS).map(|(weight, off)| weight * off * off).sum()
    }
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

/// The best pair in place of a path, if one may be worth it.
pub fn split<'m>(close: &Close<'_, '_, 'm>) -> Option<Split<'m>> {
    let fitted = fitted(close);
    let best = fitted.first()?;
    let gain = close.here.chi_square - best.chi_square;
    let is_pair = gain > TOLD_APART && has_two(best, close.path);
    Some(Split {
        hypothesis: best.clone(),
        is_pair,
        paths: match is_pair {
            true => vec![close.path, best.parameters.paths.len() - 1],
            false => vec![close.path],
        },
        alternatives: match is_pair {
            true => close.beside(&fitted, best.chi_square),
            false => vec![(likelihood(TOLD_APART - gain), close.delays(best))],
        },
    })
}

/// How likely light is beside that which was taken, where it fits worse by so much: chi-square,
/// and for two paths in place of one what they must gain, which is what noise makes it fall.
fn likelihood(worse: f64) -> f64 {
    (-0.5 * worse).exp().min(1.0)
}

/// The likeliest pairs in place of a path, the best first.
fn fitted<'m>(close: &Close<'_, '_, 'm>) -> Vec<Hypothesis<'m>> {
    let places = places(close);
    let starts = starts(close, &places).into_iter();
    // A pair that leads nowhere is none.
    let pairs = starts.filter_map(|[first, second]| {
        let in_place = |light: &mut Parameters| {
            light.paths[close.path] = first;
            light.paths.push(second);
        };
        close.search.fitted(close.here, in_place).ok()
    });
    let mut fitted: Vec<Hypothesis> = pairs.collect();
    fitted.sort_by(|a, b| a.chi_square.total_cmp(&b.chi_square));
    fitted
}

impl Close<'_, '_, '_> {
    /// Where the paths of the code are in a hypothesis: all of them, since what was one of a
    /// pair here may have become its neighbour there.
    fn delays(&self, other: &Hypothesis) -> Vec<f64> {
        let code = &self.here.parameters.paths[self.path].code;
        let lit = other.parameters.paths.iter().filter(|path| path.has(code));
        lit.map(|path| path.delay_chips).collect()
    }

    /// One path and other pairs, beside a pair that was taken; that pair itself is no other.
    fn beside(&self, fitted: &[Hypothesis], chi_square: f64) -> Vec<Alternative> {
        let single = (self.here.chi_square - chi_square - TOLD_APART, self.here);
        let others = fitted.iter().map(|other| (other.chi_square - chi_square, other));
        let likely = others.filter(|(worse, _)| *worse < UNLIKELY);
        let all = [single].into_iter().chain(likely);
        all.map(|(worse, other)| (likelihood(worse), self.delays(other))).collect()
    }
}

impl<'m> Split<'m> {
    /// What a pair that was taken may be instead, where `close` has one path in its place
    /// beside all other light; with that, chi-square is `chi_square`.
    pub fn beside(self, close: &Close<'_, '_, 'm>, chi_square: f64) -> Split<'m> {
        Split { alternatives: close.beside(&fitted(close), chi_square), ..self }
    }

    /// The same where a path is gone; `None` of what was said of that.
    pub fn without(mut self, gone: usize) -> Option<Split<'m>> {
        let is_of_others = !self.paths.contains(&gone);
        self.paths.iter_mut().filter(|path| **path > gone).for_each(|path| *path -= 1);
        is_of_others.then_some(self)
    }

    /// How many paths there were when it was taken.
    pub fn paths_when_taken(&self) -> usize {
        self.hypothesis.parameters.paths.len() - usize::from(!self.is_pair)
    }
}

/// Whether both paths of a pair have light.
fn has_two(pair: &Hypothesis, path: usize) -> bool {
    let last = pair.parameters.paths.len() - 1;
    let [a, b] = [path, last].map(|p| pair.parameters.paths[p].rate());
    a.min(b) > LEAST_SHARE * (a + b)
}

/// Half a phase step from place to place.
fn places(close: &Close) -> Vec<Slot> {
    let axis = &close.search.air.axis;
    let path = &close.here.parameters.paths[close.path];
    let centre = axis.place_of(path.delay_chips);
    let first = centre.floor();
    let height = path.rate() * close.search.unit(close.here);
    let reach = (REACH_CHIPS * axis.samples_per_chip).ceil().max(2.0) as i64;
    let steps = close.products.len() as i64;
    let product = |place: f64| {
        let index = place as i64;
        let index = match axis.is_full() {
            true => index.rem_euclid(steps),
            false => index,
        };
        let left_over = usize::try_from(index).ok().and_then(|i| close.products.get(i));
        Some(left_over? + height * close.candidate.matched.overlap(place - centre))
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
fn starts(close: &Close, places: &[Slot]) -> Vec<[PathParameters; 2]> {
    let overlap = |a: &Slot, b: &Slot| {
        let pairs = a.ends.iter().flat_map(|x| b.ends.iter().map(move |y| x - y));
        0.25 * pairs.map(|apart| close.candidate.matched.overlap(apart)).sum::<f64>()
    };
    let variance = close.search.sigma().powi(2);
    let alone = places.iter().map(|p| p.product.max(0.0).powi(2) / (overlap(p, p) * variance));
    let alone = alone.fold(0.0, f64::max);
    let mut pairs: Vec<(f64, usize, usize, [f64; 2])> = Vec::new();
    for (i, a) in places.iter().enumerate() {
        for (j, b) in places.iter().enumerate().skip(i + 1) {
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
        let path = |place: &Slot, height: f64| PathParameters {
            code: Arc::clone(&close.here.parameters.paths[close.path].code),
            delay_chips: axis.delay_at(place.middle()),
            ln_rate: (height / unit).max(1e-12).ln(),
        };
        starts.push([path(&places[i], heights[0]), path(&places[j], heights[1])]);
        if starts.len() == FITTED {
            break;
        }
    }
    starts
}
