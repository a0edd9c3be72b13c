//! From all light that was found to an estimate.

use std::sync::Arc;

use super::air::{Air, Candidate};
use super::joint::Found;
use super::model_estimate::{FittedPath, ModelEstimate, Untold};
use super::pairs::TOLD_APART;
use super::problem::Problem;
use crate::estimate::distance_m;

/// Deviations that a pair must have on average to be told apart in 95 % of scans.
const IN_95_PERCENT: f64 = 1.645;

impl Found<'_> {
    /// The estimate: own paths first, the strongest of them first of all.
    pub fn estimate(&self, air: &Air, problem: &Problem) -> ModelEstimate {
        let clock = problem.clock();
        let own = &air.known[0];
        let fitted = &self.hypothesis;
        let is_own = |index: usize| fitted.codes[index].chips == own.code.chips;
        let rate = |index: usize| fitted.parameters.paths[index].ln_rate;
        let mut order: Vec<usize> = (0..fitted.codes.len()).collect();
        order.sort_by(|&a, &b| is_own(b).cmp(&is_own(a)).then(rate(b).total_cmp(&rate(a))));
        // Whoever searches does not know how many there are.
        let is_given = air.sets.is_empty();
        let room = |candidate: &Candidate| match is_given {
            true => air.room(candidate, fitted),
            false => 0,
        };
        let missing = room(own);
        let missing_of_others: usize = air.known[1..].iter().map(room).sum();
        let resolution_chips = order.first().filter(|_| missing > 0).map_or(0.0, |&strongest| {
            self.resolution_chips(air, rate(strongest).exp() * self.unit)
        });
        let std = self.normal.standard_deviations();
        let paths: Vec<FittedPath> = order
            .iter()
            .map(|&index| {
                let code = &fitted.codes[index];
                let path = fitted.parameters.paths[index];
                // Light in the middle of two paths is half their distance off.
                let hidden = if is_own(index) { 0.5 * resolution_chips } else { 0.0 };
                let [delay, ln_rate] = self.beyond_normal[index];
                let delay_variance = std[2 * index].powi(2) + delay + hidden * hidden;
                let ln_rate_variance = std[2 * index + 1].powi(2) + ln_rate;
                FittedPath {
                    code: Arc::clone(code),
                    delay_ps: clock.ps(path.delay_chips.rem_euclid(code.len() as f64)),
                    delay_std_ps: clock.ps(delay_variance.sqrt()),
                    rate_hz: clock.hz(path.ln_rate.exp()),
                    rate_relative_std: ln_rate_variance.sqrt(),
                }
            })
            .collect();
        ModelEstimate {
            delay_ps: paths[0].delay_ps,
            distance_m: distance_m(paths[0].delay_ps),
            std_m: distance_m(paths[0].delay_std_ps),
            velocity: None,
            constant_rate_hz: clock.hz(fitted.parameters.constant),
            chi_square: fitted.chi_square,
            degrees_of_freedom: self.values.saturating_sub(fitted.parameters.len()),
            steps: air.axis.len(),
            untold: (missing + missing_of_others > 0).then(|| Untold {
                missing,
                missing_of_others,
                resolution_m: distance_m(clock.ps(resolution_chips)),
            }),
            iterations: fitted.iterations,
            paths,
        }
    }

    /// How far apart two equal paths of light `height` in all must be, to be told apart
    /// in 95 % of scans.
    fn resolution_chips(&self, air: &Air, height: f64) -> f64 {
        let template = &air.known[0].matched.template;
        let needed = (TOLD_APART.sqrt() + IN_95_PERCENT).powi(2);
        let values = |delay: f64| -> Vec<f64> {
            let values = air.axis.values(template, delay).map(|[value, _]| value);
            air.axis.centred(&values.collect::<Vec<_>>())
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        // What a single path in their middle leaves over of two.
        let left_over = |apart: f64| {
            let middle = 0.37 / air.axis.samples_per_chip;
            let [early, between, late] = [-0.5, 0.0, 0.5].map(|side| values(middle + side * apart));
            let both: Vec<f64> = early.iter().zip(&late).map(|(a, b)| 0.5 * (a + b)).collect();
            let shared = dot(&both, &between).powi(2) / dot(&between, &between);
            (dot(&both, &both) - shared).max(0.0) * (height / self.sigma).powi(2)
        };
        let (mut low, mut high) = (0.0, 2.0);
        for _ in 0..8 {
            let middle = 0.5 * (low + high);
            match left_over(middle) < needed {
                true => low = middle,
                false => high = middle,
            }
        }
        high
    }
}
