//! Where a detector is that has run for ever.
//!
//! A saturated detector fires like a clock, whose phase it forgets too slowly to be simulated for
//! every phase step. Its last avalanche was at u with the rate r(u) of avalanches that the state equation
//! has, if it is blind at t: t - D < u <= t. Otherwise it has been ready since t - a with the rate r(t - a - D) S(a),
//! S being the chance that nothing came since.

use super::avalanches::detections;
use super::forward::Detections;
use super::grid::{Grid, Kinks, SampleInstants, frame_chips};
use super::light::Light;
use crate::photons::DetectorModel;
use crate::photons::afterpulsing::Afterpulsing;

/// Share of the afterpulses that may outlast the dead time: those of one avalanche then know nothing of the
/// one before.
const MOST_LEFT: f64 = 1e-9;
/// Afterpulses are looked for so many time constants back: e^-16 of them are left.
const TIME_CONSTANTS: f64 = 16.0;
/// Steps of a time constant.
const STEPS: f64 = 8.0;

/// A detector that has run for ever in its light.
#[derive(Debug, Clone)]
pub struct LongRun {
    grid: Grid,
    detections: Detections,
    frame_chips: f64,
    dead_time_chips: f64,
    afterpulsing: Option<Afterpulsing>,
}

/// When a detector will be ready.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReadyIn {
    /// Chips until then; 0 if it is.
    pub chips: f64,
    /// Afterpulses that are pending then, on average.
    pub pending: f64,
}

impl LongRun {
    /// None of several SPADs, of one whose arrivals prolong its dead time or whose afterpulses outlast it,
    /// and of one whose state equation is not solved.
    pub fn of(model: &DetectorModel) -> Option<LongRun> {
        // One of no share is none.
        let afterpulsing = model.afterpulsing.filter(|a| a.mean_per_avalanche > 0.0);
        let left = |a: Afterpulsing| (-model.dead_time_chips / a.time_constant_chips).exp();
        let is_alone = model.members().len() == 1 && !model.is_paralyzable;
        if !is_alone || model.dead_time_chips <= 0.0 || afterpulsing.map_or(0.0, left) > MOST_LEFT {
            return None;
        }
        let light = Light::of(model);
        let samples = SampleInstants { origin_chips: 0.0, sampling: None };
        let grid = Grid::of_any_memory(model, &light, Kinks::Later, &samples).ok()?;
        Some(LongRun {
            detections: detections(model, &grid).ok()?.all,
            frame_chips: frame_chips(&light),
            dead_time_chips: model.dead_time_chips,
            grid,
            afterpulsing,
        })
    }

    /// Common period of all codes.
    pub fn period_chips(&self) -> u64 {
        self.grid.period_chips as u64
    }

    /// When it is ready, of a detector that is looked at some chips after its codes' first chip leaves the
    /// lasers; drawn by a number from 0 to 1.
    pub fn ready_in(&self, chips: f64, share: f64) -> ReadyIn {
        let now = chips - self.frame_chips;
        let until = |time: f64| self.detections.until(&self.grid, time);
        let (until_now, blind) = (until(now), until(now - self.dead_time_chips));
        let pending = self.afterpulsing.map_or(0.0, |a| a.mean_per_avalanche);
        if share < until_now - blind {
            let last = self.detections.when(&self.grid, until_now - share);
            let chips = (last + self.dead_time_chips - now).clamp(0.0, self.dead_time_chips);
            return ReadyIn { chips, pending };
        }
        let ready = share - (until_now - blind);
        let pending = self
            .afterpulsing
            .map_or(0.0, |afterpulsing| pending * self.ready_for(now, ready, afterpulsing));
        ReadyIn { chips: 0.0, pending }
    }

    /// Share of its afterpulses that is left to a detector which is ready `now`; `share` of its
    /// probability to be ready is of those that became it later.
    fn ready_for(&self, now: f64, share: f64, afterpulsing: Afterpulsing) -> f64 {
        let Afterpulsing { mean_per_avalanche, time_constant_chips } = afterpulsing;
        let step = time_constant_chips / STEPS;
        let mut lambdas = Vec::new();
        let (mut lit_chip, mut exposure, mut sum) = (None, 0.0, 0.0);
        let became_ready =
            |time: f64| self.detections.until(&self.grid, time - self.dead_time_chips);
        let mut later = became_ready(now);
        for number in 0..(TIME_CONSTANTS * STEPS) as u32 {
            let back = (f64::from(number) + 0.5) * step;
            let (chip, cell, _) = self.grid.locate(now - back);
            if lit_chip != Some(chip) {
                self.grid.fill_rates(chip, &mut lambdas);
                lit_chip = Some(chip);
            }
            let left = (-back / time_constant_chips).exp();
            let light = exposure + 0.5 * step * lambdas[cell];
            let earlier = became_ready(now - back - 0.5 * step);
            sum += (later - earlier) * (-light - mean_per_avalanche * (1.0 - left)).exp();
            if sum > share {
                return left;
            }
            later = earlier;
            exposure += step * lambdas[cell];
        }
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photons::OptionalPart;
    use crate::response::chain::Chain;
    use crate::response::forward::{self, ReadyStates};
    use crate::scene::{DetectorIndex, load_with};
    use crate::sensor::Sensor;

    fn model(settings: &[&str]) -> DetectorModel {
        let parsed = settings.iter().map(|setting| setting.parse().expect("a setting"));
        let file = std::path::Path::new("../scenes/quick.toml");
        let scene = load_with(file, &parsed.collect::<Vec<_>>()).expect("sound");
        DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0))
    }

    /// Blind as often as detections of the last dead time say, until each of them ends; and what is
    /// pending for a ready one, against the states of the chain of pending afterpulses.
    #[test]
    fn what_is_drawn_is_the_solved_state() {
        let settings = ["source.mean_power=4 pW", "detector.dead_time=1 us"];
        let model = model(&settings);
        let long_run = LongRun::of(&model).expect("solved");
        let (grid, detections) = (&long_run.grid, &long_run.detections);
        let chain = Chain::<4>::new(model.afterpulsing, model.dead_time_chips);
        let mut states = ReadyStates::<4>::new();
        forward::solve(grid, &chain, grid.round(), Some(&mut states));
        for (index, cell) in [(0, 0), (7, 3), (30, 5)] {
            let time = index as f64 + grid.edges[cell];
            let chips = time + long_run.frame_chips + 5.0 * grid.period_chips as f64;
            let [state, ..] = states[index * grid.cells.len() + cell];
            let ready: f64 = state.iter().sum();
            let blind = detections.until(grid, time) - detections.until(grid, time - 125.0);
            assert!((blind + ready - 1.0).abs() < 1e-6, "{blind} {ready}");

            let draws = 40_000;
            let shares = (0..draws).map(|draw| (f64::from(draw) + 0.5) / f64::from(draws));
            let drawn: Vec<_> =
                shares.map(|share| (share, long_run.ready_in(chips, share))).collect();
            let is_ready = |&&(_, of): &&(f64, ReadyIn)| of.chips == 0.0;
            let found = drawn.iter().filter(is_ready).count() as f64 / f64::from(draws);
            assert!((found - ready).abs() < 1e-4, "{found} {ready}");
            let pending = drawn.iter().filter(is_ready).map(|(_, of)| of.pending).sum::<f64>();
            let expected = (0..4).map(|m| m as f64 * state[m]).sum::<f64>();
            let pending = pending / f64::from(draws);
            assert!((pending / expected - 1.0).abs() < 0.01, "{pending} {expected}");
            for (share, of) in drawn.iter().filter(|(_, of)| of.chips > 0.0) {
                let last = time + of.chips - model.dead_time_chips;
                let since = detections.until(grid, time) - detections.until(grid, last);
                assert!((since - share).abs() < 1e-9, "{since} {share}");
            }
        }
    }

    #[test]
    fn what_has_other_memories_is_not_drawn() {
        assert!(LongRun::of(&model(&["detector.dead_time=1 us"])).is_some());
        for settings in [
            &["detector.dead_time=14 ns"][..],
            &["detector.dead_time=1 us", "detector.cells=4"],
            &["detector.dead_time=1 us", "detector.recharge=passive"],
        ] {
            assert!(LongRun::of(&model(settings)).is_none(), "{settings:?}");
        }
        // Afterpulses that never come outlast nothing.
        let none = "detector.afterpulsing={ probability = 0, time_constant = \"5 ns\" }";
        let without = model(&["detector.dead_time=40 ns", none]);
        for model in [without.with_neutral(OptionalPart::Afterpulsing), without] {
            assert!(LongRun::of(&model).is_some(), "{:?}", model.afterpulsing);
        }
    }
}
