//! Means, variances and covariance of the counts, step by step.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::prelude::*;

use super::MeanResponseError;
use super::correlator::dot;
use super::expected::MeanResponse;
use super::grid::{SampleInstants, frame_chips};
use super::long_scan::LongScan;
use super::pairs::{DetectorPairs, before_chips};
use super::span::PairReach;
use crate::photons::DetectorModel;
use crate::scan::{Group, Step};

/// A count that is never anything but its mean weighs as if it had the variance of rounding.
pub const ROUNDING: f64 = 1.0 / 12.0;
/// Beyond this the moments of a step are none; where all hits count up it is 1 but for rounding.
pub const MOST_CORRELATION: f64 = 1.001;
/// What counts are weighed with then.
const CORRELATION_INSTEAD: f64 = 0.9;

/// Moments of the signed count r and the total count N of one phase step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountMoments {
    /// Mean of r.
    pub signed_mean: f64,
    /// Mean of N.
    pub total_mean: f64,
    /// Variance of r.
    pub signed_variance: f64,
    /// Variance of N.
    pub total_variance: f64,
    /// Covariance of r and N.
    pub covariance: f64,
}

impl CountMoments {
    /// Those of a step that lasts so many times as long.
    #[must_use]
    pub fn in_times(&self, times: f64) -> CountMoments {
        CountMoments {
            signed_mean: times * self.signed_mean,
            total_mean: times * self.total_mean,
            signed_variance: times * self.signed_variance,
            total_variance: times * self.total_variance,
            covariance: times * self.covariance,
        }
    }

    /// Correlation of r and N. Beyond 1 hits up, or down, have a variance below zero: moments without the rims of steps
    /// are then farther off than these few hits vary.
    pub fn correlation(&self) -> f64 {
        match self.covariance.abs() <= 1e-3 * ROUNDING {
            true => 0.0,
            false => self.covariance / self.most_covariance(),
        }
    }

    fn most_covariance(&self) -> f64 {
        (self.signed_variance.max(0.0) * self.total_variance.max(0.0)).sqrt()
    }

    /// Factor W of the inverse covariance, W^T W = C^-1, as (a, b, c): a r and b r + c N have
    /// unit covariance.
    pub fn whitening(&self) -> [f64; 3] {
        // Cholesky of C = [[v, c], [c, n]], then the inverse of its factor.
        let signed = self.signed_variance.max(ROUNDING).sqrt();
        let covariance = match self.correlation() {
            correlation if correlation.abs() > MOST_CORRELATION => {
                CORRELATION_INSTEAD * correlation.signum() * self.most_covariance()
            }
            _ => self.covariance,
        };
        let shared = covariance / signed;
        let rest = (self.total_variance - shared * shared).max(1e-3 * ROUNDING).sqrt();
        [1.0 / signed, -shared / (signed * rest), 1.0 / rest]
    }
}

/// Moments of the counts of one group of phase steps, which share their light.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct GroupMoments {
    /// Mean of r of each step that was asked for.
    pub signed_means: Vec<f64>,
    /// Mean of N, which is one and the same for all of them.
    pub total_mean: f64,
    /// Covariances of r of each step and, last, of N.
    pub covariance: Vec<Vec<f64>>,
}

impl GroupMoments {
    /// Those of the first `steps` steps only.
    pub fn of_first(&self, steps: usize) -> GroupMoments {
        let total = self.signed_means.len();
        let kept: Vec<usize> = (0..steps.min(total)).chain([total]).collect();
        let row = |&a: &usize| kept.iter().map(|&b| self.covariance[a][b]).collect();
        GroupMoments {
            signed_means: self.signed_means.iter().take(steps).copied().collect(),
            total_mean: self.total_mean,
            covariance: kept.iter().map(row).collect(),
        }
    }
}

/// Steps that are longer, in the scales on which the detector's counts are correlated, end
/// with too few pairs that the end divides to change a variance by 1 in 1,000.
const LONG_IN_SCALES: f64 = 300.0;
/// Steps whose moments are worked out at once, at most.
const STEPS_AT_ONCE: usize = 64;
/// Ends of steps within the code period that are told apart for the total count, whose variance
/// differs little between them.
pub(super) const ENDS: usize = 4;

/// Second moments of the counts around a mean response. Signs are taken without jitter.
pub struct SecondMoments<'r, 'm> {
    pub(super) response: &'r MeanResponse<'m>,
    pub(super) solved: SolvedPairs,
    /// Of single phase steps, where several integration times ask for them.
    phase_steps: Option<KeptPhaseSteps>,
    /// How far pairs of detections reach across the end of a step; none if steps are so long
    /// that it does not matter.
    reach: Option<PairReach>,
    /// Ends of steps that are told apart for the total count.
    ends: Vec<usize>,
    /// What the ends of steps, by their chips, divide of the pairs of all detections.
    known_across: Mutex<BTreeMap<usize, Arc<AcrossEnd>>>,
    /// Moments of the steps that were asked for so far.
    known: Mutex<BTreeMap<Step, CountMoments>>,
}

/// What the chips before each chip of the code period add to the moments of a phase step,
/// whatever its length.
struct BeforeChips {
    signed_variance: Vec<f64>,
    covariance: Vec<f64>,
}

/// What second moments follow from, however long steps are and however late the light comes.
#[derive(Clone)]
pub struct SolvedPairs {
    pub(super) pairs: Arc<DetectorPairs>,
    /// Variance of N that the chips before each chip add.
    total_variance: Arc<Vec<f64>>,
    /// Of the phase steps of a long scan, once they were asked for.
    pub(super) long_scan: Arc<OnceLock<LongScan>>,
}

impl fmt::Debug for SolvedPairs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SolvedPairs").finish_non_exhaustive()
    }
}

/// What single phase steps' moments add up from, of those that were asked for.
type KeptPhaseSteps = Arc<Mutex<BTreeMap<u64, Arc<BeforeChips>>>>;

/// What an end of steps divides of the pairs of all detections.
struct AcrossEnd {
    /// Later counts after the end that go with a detection in every cell before it.
    of_all: Vec<f64>,
    /// What a step that ends there does not count of the variance of all detections that pairs
    /// which begin in it have.
    beyond: f64,
}

impl<'r, 'm> SecondMoments<'r, 'm> {
    /// Solves for the states of the detector, and for the total count.
    ///
    /// # Errors
    /// As for the mean response.
    pub fn new(response: &'r MeanResponse<'m>) -> Result<SecondMoments<'r, 'm>, MeanResponseError> {
        let samples = SampleInstants {
            origin_chips: origin_chips(response),
            sampling: response.sampling.clone(),
        };
        let heard = response.heard.as_deref();
        let pairs = DetectorPairs::new(response.model, &response.light, heard, samples)?;
        let per_cell = pairs.hits.iter().zip(&pairs.excess_of_all);
        let per_cell = per_cell
            .zip(pairs.seen_of_period())
            .map(|((hits, excess), seen)| [seen * (hits + 2.0 * excess)]);
        let [total_variance] = before_chips(&pairs.grid, per_cell);
        let solved = SolvedPairs {
            pairs: Arc::new(pairs),
            total_variance: Arc::new(total_variance),
            long_scan: Arc::default(),
        };
        Ok(SecondMoments::of_pairs(response, solved, None))
    }

    /// Those round a response to light that differs from that of `solved` in its [delay](MeanResponse::delayed)
    /// alone. Only where the state of the detector depends on that it is solved again; of a long scan moments
    /// are interpolated between the phases of a chip that have been worked out: a variance is off by up to a hundredth,
    /// which weights of a fit hardly tell.
    ///
    /// # Errors
    /// As for the mean response.
    pub fn of_delayed(
        solved: &SolvedPairs,
        response: &'r MeanResponse<'m>,
    ) -> Result<SecondMoments<'r, 'm>, MeanResponseError> {
        match response.state_depends_on_delay() || response.misses_pulses() {
            true => SecondMoments::new(response),
            false => Ok(SecondMoments::of_pairs(response, solved.clone(), None)),
        }
    }

    /// What [`SecondMoments::of_delayed`] needs.
    pub fn solved(&self) -> SolvedPairs {
        self.solved.clone()
    }

    /// Keeps what does not depend on the integration time, for
    /// [`SecondMoments::counted_by`]: of each phase step two numbers for every chip of the code
    /// period.
    #[must_use]
    pub fn shared(self) -> SecondMoments<'r, 'm> {
        SecondMoments { phase_steps: Some(Arc::default()), ..self }
    }

    /// Those round a response that is [counted](MeanResponse::counted_by) for another
    /// integration time. Nothing is solved again.
    pub fn counted_by<'s, 'n>(&self, response: &'s MeanResponse<'n>) -> SecondMoments<'s, 'n> {
        SecondMoments::of_pairs(response, self.solved(), self.phase_steps.clone())
    }

    fn of_pairs(
        response: &'r MeanResponse<'m>,
        solved: SolvedPairs,
        phase_steps: Option<KeptPhaseSteps>,
    ) -> SecondMoments<'r, 'm> {
        let brightest = response.light.brightest_per_chip();
        let reach = reach_across_ends(response.model, brightest, solved.pairs.grid.memory_chips);
        let mut second = SecondMoments {
            response,
            solved,
            phase_steps,
            reach,
            ends: Vec::new(),
            known_across: Mutex::default(),
            known: Mutex::default(),
        };
        let timing = &response.model.timing;
        let groups = (0..timing.groups().min(ENDS as u64)).map(Group);
        let first_steps = groups.flat_map(|group| timing.grouping().steps_of(group).take(1));
        second.ends = first_steps.map(|step| second.end(step)).collect();
        second
    }

    /// Moments of a step of the first scan.
    pub fn of_step(&self, step: Step) -> CountMoments {
        self.of_steps(&[step])[0]
    }

    /// Moments of a step, from those of its phase step.
    fn moments(&self, step: Step, before: &BeforeChips) -> CountMoments {
        let mean = self.response.mean_count(step);
        let phase_step = self.response.model.timing.scan.phase_step(step);
        let mut moments = CountMoments {
            signed_mean: mean.signed,
            total_mean: mean.total,
            signed_variance: self.over_step(step, &before.signed_variance),
            total_variance: self.total_variance(step),
            covariance: self.over_step(step, &before.covariance),
        };
        if self.reach.is_some() {
            let (signs, seen, end) = (self.signs(phase_step), self.seen(), self.end(step));
            let (across, of_all) = (self.across(&signs, end), self.across_of_all(step));
            let divided = self.beyond(&signs, &across, end);
            moments.signed_variance = moments.signed_variance - divided - divided;
            moments.covariance -= self.beyond(&signs, &of_all.of_all, end);
            moments.covariance -= self.beyond(&seen, &across, end);
        }
        moments
    }

    /// What phase steps' moments add up from.
    fn of_phase_steps(&self, phase_steps: BTreeSet<u64>) -> BTreeMap<u64, Arc<BeforeChips>> {
        let kept = self.phase_steps.as_ref();
        let kept = || Some(kept?.lock().unwrap_or_else(PoisonError::into_inner));
        let mut known = kept().map(|kept| kept.clone()).unwrap_or_default();
        let unknown = phase_steps.into_iter().filter(|phase_step| !known.contains_key(phase_step));
        let unknown: Vec<u64> = unknown.collect();
        let signs: Vec<_> = unknown.par_iter().map(|&step| self.signs(step)).collect();
        let (seen, excess) = (self.seen(), self.solved.pairs.excess(&rows(&signs)));
        let before = signs.par_iter().zip(&excess).map(|(signs, excess)| {
            let signed = signs.iter().zip(excess);
            let total = seen.iter().zip(&self.solved.pairs.excess_of_all);
            let per_cell = self.solved.pairs.hits.iter().zip(signed.zip(total)).map(
                |(hits, ((sign, excess), (seen, excess_of_all)))| {
                    let later = sign * excess;
                    let covariance = hits * sign + sign * excess_of_all + seen * excess;
                    [hits * seen + later + later, covariance]
                },
            );
            let [signed_variance, covariance] = before_chips(&self.solved.pairs.grid, per_cell);
            Arc::new(BeforeChips { signed_variance, covariance })
        });
        let before: Vec<_> = before.collect();
        let found = unknown.into_iter().zip(before);
        if let Some(mut kept) = kept() {
            kept.extend(found.clone());
        }
        known.extend(found);
        known
    }

    /// Sum of weights of detections before chip `end` of the code period times the later
    /// counts that go with them.
    fn beyond(&self, weights: &[f64], across: &[f64], end: usize) -> f64 {
        self.reach.map_or(0.0, |reach| {
            let before = self.solved.pairs.before(weights, end, reach);
            let of_cell: f64 = before.zip(across).map(|(weight, across)| weight * across).sum();
            self.cells() * of_cell
        })
    }

    /// Later counts, weighted with each of `weights`, that go with a detection in every cell,
    /// and those of them that come after the end of a step.
    fn later(&self, step: Step, weights: &[&[f64]]) -> [Vec<Vec<f64>>; 2] {
        let end = self.end(step);
        let across = match self.reach {
            Some(reach) => self.solved.pairs.excess_across(weights, end, reach),
            None => vec![Vec::new(); weights.len()],
        };
        [self.solved.pairs.excess(weights), across]
    }

    fn across(&self, weights: &[f64], end: usize) -> Vec<f64> {
        let across = |reach| self.solved.pairs.excess_across(&[weights], end, reach).swap_remove(0);
        self.reach.map_or_else(Vec::new, across)
    }

    /// What the end of a step divides of the pairs of all detections; [`ENDS`] are told apart.
    fn across_of_all(&self, step: Step) -> Arc<AcrossEnd> {
        let end = self.end(step);
        let end = if self.ends.contains(&end) { end } else { self.ends[end % self.ends.len()] };
        let mut known = self.known_across.lock().unwrap_or_else(PoisonError::into_inner);
        let across = known.entry(end).or_insert_with(|| {
            let seen = self.seen();
            let of_all = self.across(&seen, end);
            let beyond = 2.0 * self.beyond(&seen, &of_all, end);
            Arc::new(AcrossEnd { of_all, beyond })
        });
        Arc::clone(across)
    }

    fn seen(&self) -> Vec<f64> {
        self.solved.pairs.seen_of_period().collect()
    }

    /// Moments of some steps of the first scan, on all processors. They are kept:
    /// a step that is asked for again costs nothing.
    pub fn of_steps(&self, steps: &[Step]) -> Vec<CountMoments> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let mut unknown: Vec<Step> = steps.to_vec();
        unknown.retain(|step| !known().contains_key(step));
        let phase_step = |step: &Step| self.response.model.timing.scan.phase_step(*step);
        // Some at a time: what their moments add up from takes memory.
        for some in unknown.chunks(STEPS_AT_ONCE) {
            let before = self.of_phase_steps(some.iter().map(phase_step).collect());
            let moments = |step: &Step| (*step, self.moments(*step, &before[&phase_step(step)]));
            // Not locked meanwhile: while it waits a thread may be given other work that asks.
            let found: Vec<_> = some.par_iter().map(moments).collect();
            known().extend(found);
        }
        let known = known();
        steps.iter().map(|step| known[step]).collect()
    }

    /// Variance of the sum of weight x r over steps of one group, which count the
    /// same detections: that of one count with the weighted sum of their signs.
    ///
    /// # Panics
    /// If there are no steps.
    pub fn variance_of_sum(&self, steps: &[(Step, f64)]) -> f64 {
        let mut sign = vec![0.0; self.solved.pairs.hits.len()];
        // Mean of the squared sign of what is seen: that of one step is 1 also in a
        // cell that an edge divides, where its mean is not. Cells are no wider than an
        // eighth of a chip, so edges of two steps seldom lie in one.
        let mut spread = sign.clone();
        for &(step, weight) in steps {
            let signs = self.signs(self.response.model.timing.scan.phase_step(step));
            let sums = sign.iter_mut().zip(&mut spread);
            for ((sum, spread), (s, seen)) in
                sums.zip(signs.iter().zip(self.solved.pairs.seen_of_period()))
            {
                *sum += weight * s;
                *spread += weight * weight * (seen - of_seen(s * s, seen));
            }
        }
        let first = steps[0].0;
        let ([excess, across], seen) = (self.later(first, &[&sign]), self.seen());
        let within = self.times_counted(first).zip(&self.solved.pairs.hits).enumerate();
        let within = within.map(|(cell, (times, hits))| {
            let square = of_seen(sign[cell] * sign[cell], seen[cell]) + spread[cell];
            times * (hits * square + 2.0 * sign[cell] * excess[0][cell])
        });
        within.sum::<f64>() - 2.0 * self.beyond(&sign, &across[0], self.end(first))
    }

    /// Moments of the counts of a whole group.
    pub fn of_group(&self, group: Group) -> GroupMoments {
        let steps = self.response.model.timing.grouping().steps_of(group);
        self.of_steps_together(&steps.collect::<Vec<_>>())
    }

    /// Moments of the counts of some steps of one group.
    ///
    /// # Panics
    /// If there are no steps.
    pub fn of_steps_together(&self, steps: &[Step]) -> GroupMoments {
        let model = self.response.model;
        let (first, end) = (steps[0], self.end(steps[0]));
        let mut weights: Vec<Vec<f64>> =
            steps.iter().map(|&step| self.signs(model.timing.scan.phase_step(step))).collect();
        let [mut excess, mut across] = self.later(first, &rows(&weights));
        let seen = self.seen();
        // Of N, whose weight is 1 where a pulse is seen.
        weights.push(seen.clone());
        excess.push(self.solved.pairs.excess_of_all.clone());
        across.push(self.across_of_all(first).of_all.clone());
        let detections: Vec<f64> = self
            .times_counted(first)
            .zip(&self.solved.pairs.hits)
            .map(|(times, hits)| times * hits)
            .collect();
        // Half of a detection itself, and the later ones: both halves of a covariance are alike.
        let mut with = excess;
        for (with, weights) in with.iter_mut().zip(&weights) {
            for (cell, (with, times)) in with.iter_mut().zip(self.times_counted(first)).enumerate()
            {
                *with = times * *with + 0.5 * of_seen(detections[cell] * weights[cell], seen[cell]);
            }
        }
        let mut halves = products(&weights, &with);
        for (halves, weights) in halves.iter_mut().zip(&weights) {
            for (half, across) in halves.iter_mut().zip(&across) {
                *half -= self.beyond(weights, across, end);
            }
        }
        let count = steps.len();
        let row = |a: usize| (0..=count).map(|b| halves[a][b] + halves[b][a]).collect();
        let mut covariance: Vec<Vec<f64>> = (0..=count).map(row).collect();
        for (lane, signs) in weights[..count].iter().enumerate() {
            // The square of a sign is 1 also in a cell that an edge divides, where its mean is not.
            let divided = detections.iter().zip(signs.iter().zip(&seen));
            let divided = divided.map(|(hits, (s, seen))| hits * (seen - of_seen(s * s, *seen)));
            covariance[lane][lane] += divided.sum::<f64>();
        }
        covariance[count][count] = self.total_variance(first);
        let means = steps.iter().map(|&step| self.response.mean_count(step));
        GroupMoments {
            signed_means: means.map(|mean| mean.signed).collect(),
            total_mean: self.response.mean_count(first).total,
            covariance,
        }
    }

    /// Variance of N of a step.
    pub(super) fn total_variance(&self, step: Step) -> f64 {
        self.over_step(step, &self.solved.total_variance) - self.across_of_all(step).beyond
    }

    /// Mean sign in every cell of the code period, 0 where no sample sees a pulse.
    fn signs(&self, phase_step: u64) -> Vec<f64> {
        let response = self.response;
        let chips = &response.model.reference.chips;
        let chip_at = |chip: i64| chips[chip.rem_euclid(chips.len() as i64) as usize];
        // Code chip 0 begins here, in the grid's frame.
        let phase = response.phase_chips(phase_step);
        let timing = &response.timing;
        let [rising, falling] =
            [timing.rising, timing.falling].map(|edge| phase + edge - self.frame_chips());
        let whole = rising.min(falling).floor();
        let [rise, fall] =
            [rising, falling].map(|edge| self.solved.pairs.shares_after(edge - whole));
        let grid = &self.solved.pairs.grid;
        let of_cell = |[two_before, before, after]: [u8; 3], cell: usize| {
            // An edge a little over a chip late still belongs to the chip before.
            let seen = self.solved.pairs.seen[cell];
            let level = level_after(two_before, before, rise[1][cell], fall[1][cell], seen)
                + level_after(before, after, rise[0][cell], fall[0][cell], seen)
                - f64::from(before) * seen;
            2.0 * level - seen
        };
        // Three chips in a row are one of few patterns.
        let of_pattern: [Vec<f64>; 8] = std::array::from_fn(|pattern| {
            let chips = [2, 1, 0].map(|bit| (pattern >> bit & 1) as u8);
            (0..grid.cells.len()).map(|cell| of_cell(chips, cell)).collect()
        });
        let mut signs = Vec::with_capacity(self.solved.pairs.hits.len());
        for chip in 0..grid.period_chips as i64 {
            let chips = [2, 1, 0].map(|back| chip_at(chip - whole as i64 - back));
            let pattern = chips.iter().fold(0, |bits, &chip| bits << 1 | usize::from(chip));
            signs.extend_from_slice(&of_pattern[pattern]);
        }
        signs
    }

    /// Registered time of the grid's origin, in chips.
    pub(super) fn frame_chips(&self) -> f64 {
        origin_chips(self.response)
    }

    /// What the chips of a step add up to; `before` has the sums before each chip
    /// of the grid.
    fn over_step(&self, step: Step, before: &[f64]) -> f64 {
        let period = self.solved.pairs.grid.period_chips;
        let (periods, first, rest) = self.chips_of(step);
        let end = first + rest;
        let partial = match end.checked_sub(period) {
            None => before[end] - before[first],
            Some(past) => before[period] - before[first] + before[past],
        };
        self.cells() * (periods * before[period] + partial)
    }

    /// Cells of which each counts as one does for which pairs are solved.
    fn cells(&self) -> f64 {
        f64::from(self.response.model.added_cells())
    }

    /// How many times a step counts each cell of the code period, of all of a detector's cells.
    fn times_counted(&self, step: Step) -> impl Iterator<Item = f64> + '_ {
        let grid = &self.solved.pairs.grid;
        let (periods, first, rest) = self.chips_of(step);
        let cells = self.cells();
        (0..grid.period_chips).flat_map(move |chip| {
            let is_in_rest = (chip + grid.period_chips - first) % grid.period_chips < rest;
            let times = cells * (periods + f64::from(is_in_rest));
            std::iter::repeat_n(times, grid.cells.len())
        })
    }

    /// Whole code periods of a step, its first chip in the grid, and the chips left over. The
    /// step's edges are rounded to whole chips of the grid.
    fn chips_of(&self, step: Step) -> (f64, usize, usize) {
        let (periods, first, rest) = self.response.chips_of(step);
        let shift = (self.frame_chips() - self.response.timing.window).round() as i64;
        let period = self.solved.pairs.grid.period_chips as i64;
        (periods, (first as i64 - shift).rem_euclid(period) as usize, rest)
    }

    /// Chip of the code period, in the grid, with which a step has ended.
    fn end(&self, step: Step) -> usize {
        let (_, first, rest) = self.chips_of(step);
        (first + rest) % self.solved.pairs.grid.period_chips
    }
}

/// How far pairs of detections reach across the end of a step, of a detector that has forgotten
/// its start after `memory_chips`; none where steps are so long that it does not matter.
pub(super) fn reach_across_ends(
    model: &DetectorModel,
    brightest_per_chip: f64,
    memory_chips: usize,
) -> Option<PairReach> {
    let memory = model.memory_under(brightest_per_chip);
    let step_chips = model.timing.scan.integration_chips;
    let after = memory.of_ends_chips().min(memory_chips);
    let before = usize::try_from(step_chips).unwrap_or(usize::MAX).min(after);
    (step_chips as f64 <= LONG_IN_SCALES * memory.scale_chips())
        .then_some(PairReach { before, after })
}

/// Numbers of each row that are multiplied at once: few enough that those of all rows stay in the
/// processor's cache.
const PRODUCTS_AT_ONCE: usize = 1024;

/// Sums of the products of each row of `a` with each of `b`.
fn products(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut products = vec![vec![0.0; b.len()]; a.len()];
    let length = a.first().map_or(0, Vec::len);
    for begin in (0..length).step_by(PRODUCTS_AT_ONCE) {
        let part = begin..length.min(begin + PRODUCTS_AT_ONCE);
        for (sums, a) in products.iter_mut().zip(a) {
            for (sum, b) in sums.iter_mut().zip(b) {
                *sum += dot(&a[part.clone()], &b[part.clone()]);
            }
        }
    }
    products
}

/// Rows of numbers, to be read.
pub(super) fn rows(rows: &[Vec<f64>]) -> Vec<&[f64]> {
    rows.iter().map(Vec::as_slice).collect()
}

/// Registered time of the origin of a response's grid, in chips.
fn origin_chips(response: &MeanResponse) -> f64 {
    frame_chips(&response.light) + response.delay_chips + response.model.delay_chips
}

/// A mean over what is seen of a cell, taken as its mean's square would be: of the
/// square of a sum over the cell, and the seen share.
fn of_seen(square: f64, seen: f64) -> f64 {
    if seen > 0.0 { square / seen } else { 0.0 }
}

/// Mean level over what is seen of a cell that an edge from `before` to `after` may
/// divide.
fn level_after(before: u8, after: u8, after_rise: f64, after_fall: f64, seen: f64) -> f64 {
    match (before, after) {
        (0, 1) => after_rise,
        (1, 0) => seen - after_fall,
        _ => f64::from(after) * seen,
    }
}
