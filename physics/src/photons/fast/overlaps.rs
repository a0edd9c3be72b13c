//! The level that several cells make, counted in the lanes.
//!
//! A pulse that overlaps no other makes one rising edge of an OR or an XOR, and none of a
//! coincidence: it is counted as a SPAD's detection is. Only those that may overlap are put into a
//! list, with their cells and their jitter, from which the level follows. Whether two may overlap is told by their
//! avalanches: they do not if these are farther apart than a pulse and all that jitter can move both. So what is
//! in the list overlaps nothing that is not.

use super::arithmetic::{LANES, LaneWords, choose, jitter};
use super::domain::{Tables, jitter_reach_chips};
use super::places::{CHIP_TICKS, round_ticks, ticks_of_chips};
use super::record::{CELL_BITS, RegisteredTicks, insert, level};
use super::sign::Sign;
use crate::photons::counter::count_detections;
use crate::photons::detector::DetectorCells;
use crate::photons::random::StreamRng;
use crate::photons::{DetectorModel, StepCount};
use crate::scan::Step;

/// So many that may overlap are kept before they are counted.
const MOST_LISTED: usize = 64;
/// With more detections so near to the one before, recording all of them is quicker.
const MOST_WITHIN_REACH: f64 = 0.7;
/// Longer than any reach that is counted so.
const LONG_AGO: u32 = 1 << 31;
/// As far as pulses may reach: half of that.
const LONGEST_REACH_CHIPS: f64 = (LONG_AGO / 2 / CHIP_TICKS) as f64;

/// The last avalanche of each lane, and those whose pulses may overlap.
#[derive(Debug)]
pub struct Overlaps<'t> {
    model: &'t DetectorModel,
    pixel: &'t DetectorCells,
    sigma_ticks: f32,
    /// Pulses of avalanches farther apart do not overlap.
    reach_ticks: u32,
    /// Rising edges of a pulse that overlaps no other.
    alone: u32,
    /// Ticks since the last avalanche.
    ages: LaneWords,
    /// Whether it is in the list.
    listed: LaneWords,
    cells: LaneWords,
    randoms: LaneWords,
    levels: LaneWords,
    lists: Vec<List>,
}

/// Avalanches whose pulses may overlap, in order.
#[derive(Debug, Clone, Default)]
struct List {
    /// When they are registered, without jitter, and the cell's number in the last bits.
    avalanches: Vec<i64>,
    /// What their jitter is made of: all at once, as that has no branches.
    randoms: Vec<u32>,
    /// What decides near an edge of the reference.
    transition: Option<StreamRng>,
}

/// How far apart avalanches are whose pulses do not overlap.
fn reach_chips(model: &DetectorModel, pixel: &DetectorCells) -> f64 {
    pixel.pulse_width_chips + 2.0 * jitter_reach_chips(model)
}

/// Whether a level's edges are counted so: few pulses overlap, none reaches farther than ages are known, and no recording
/// stands for several phase steps.
pub fn pay(model: &DetectorModel, pixel: &DetectorCells) -> bool {
    let reach_chips = reach_chips(model, pixel);
    model.timing.parallel == 1
        && reach_chips < LONGEST_REACH_CHIPS
        && model.most_detections_per_chip() * reach_chips < MOST_WITHIN_REACH
}

impl<'t> Overlaps<'t> {
    /// None of a detector whose cells, if it has several, make no level together.
    pub fn new(model: &'t DetectorModel, tables: &Tables) -> Option<Overlaps<'t>> {
        let pixel = model.pixel.as_deref().filter(|pixel| pixel.law.edges() == 1)?;
        Some(Overlaps {
            model,
            pixel,
            sigma_ticks: tables.jitter_ticks as f32,
            reach_ticks: round_ticks(pixel.pulse_width_chips) as u32 + 2 * tables.reach_ticks,
            alone: u32::from(pixel.law.level(1)),
            ages: LaneWords::all(LONG_AGO),
            listed: LaneWords::all(0),
            cells: LaneWords::all(0),
            randoms: LaneWords::all(0),
            levels: LaneWords::all(0),
            lists: vec![List::default(); LANES],
        })
    }

    /// Starts a lane's step.
    pub fn start(&mut self, lane: usize, transition: StreamRng) {
        self.ages[lane] = LONG_AGO;
        self.lists[lane].transition = Some(transition);
    }

    /// Goes on to the next avalanche: 1 where it may overlap the last one, and a bit for each of these lanes.
    #[inline(always)]
    pub fn advance(&mut self, elapsed: &LaneWords, fired: &LaneWords) -> (LaneWords, u64) {
        let mut near = LaneWords::all(0);
        for lane in 0..LANES {
            self.ages[lane] = self.ages[lane].min(LONG_AGO).wrapping_add(elapsed[lane]);
            near[lane] = fired[lane] & u32::from(self.ages[lane] <= self.reach_ticks);
        }
        let mut lanes = 0;
        for lane in 0..LANES {
            lanes |= u64::from(near[lane]) << lane;
        }
        (near, lanes)
    }

    /// Takes avalanches for the last ones, the near ones of which are in the list; gives 1 where the others make
    /// a rising edge.
    #[inline(always)]
    pub fn follow(
        &mut self,
        fired: &LaneWords,
        near: &LaneWords,
        cells: &LaneWords,
        sign: &Sign,
    ) -> LaneWords {
        let mut counted = LaneWords::all(0);
        for lane in 0..LANES {
            let has_fired = fired[lane] != 0;
            self.ages[lane] = choose(has_fired, 0, self.ages[lane]);
            self.listed[lane] = choose(has_fired, near[lane], self.listed[lane]);
            self.cells[lane] = choose(has_fired, cells[lane], self.cells[lane]);
            self.randoms[lane] = choose(has_fired, sign.randoms[lane], self.randoms[lane]);
            self.levels[lane] = choose(has_fired, sign.levels[lane], self.levels[lane]);
            counted[lane] = fired[lane] & !near[lane] & self.alone;
        }
        counted
    }

    /// Puts a lane's last avalanche into the list, if another one may still overlap it: gives how many rising
    /// edges, and how many of these up, have been counted for it. `now` is the lane's time, as it is registered without jitter.
    pub fn list_last(&mut self, lane: usize, now: i64) -> (u32, u32) {
        if self.listed[lane] != 0 || self.ages[lane] > self.reach_ticks {
            return (0, 0);
        }
        self.listed[lane] = 1;
        let avalanche = now - i64::from(self.ages[lane]);
        self.list(lane, avalanche, self.randoms[lane], self.cells[lane]);
        (self.alone, self.alone & self.levels[lane])
    }

    /// Puts an avalanche into the list.
    pub fn list(&mut self, lane: usize, avalanche: i64, random: u32, cell: u32) {
        let list = &mut self.lists[lane];
        list.avalanches.push(avalanche << CELL_BITS | i64::from(cell));
        list.randoms.push(random);
    }

    /// Whether a lane's list is to be counted before another avalanche that overlaps none of it comes.
    pub fn is_full(&self, lane: usize) -> bool {
        self.lists[lane].randoms.len() >= MOST_LISTED && self.listed[lane] == 0
    }

    /// Counts what is in a lane's list, and empties it.
    pub fn take(&mut self, lane: usize, repetition: u64, step: Step) -> StepCount {
        let List { avalanches, randoms, transition } = &mut self.lists[lane];
        let Some(transition) = transition.as_mut().filter(|_| !randoms.is_empty()) else {
            return StepCount::ZERO;
        };
        for random in &mut *randoms {
            *random = jitter(*random, self.sigma_ticks) as u32;
        }
        let end = ticks_of_chips(self.model.timing.scan.integration_chips as i64);
        let mut times = Vec::with_capacity(randoms.len());
        for (avalanche, shift) in avalanches.drain(..).zip(randoms.drain(..)) {
            let time = avalanche + (i64::from(shift as i32) << CELL_BITS);
            if (0..end << CELL_BITS).contains(&time) {
                insert(&mut times, RegisteredTicks(time as u64));
            }
        }
        let edges = level(self.pixel, &times).times;
        let edges = edges.into_iter().map(RegisteredTicks::detection);
        count_detections(self.model, repetition, step, transition, edges)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::photons::fast::StepCounter;
    use crate::scene::{self, Combination, CounterTiming, Crosstalk, Detector, DetectorIndex};
    use crate::sensor::Sensor;

    /// Counts in lanes, and of the same photons when all of them are recorded: in all the same edges, and the same
    /// signs where no jitter and no transition decides them.
    #[test]
    fn edges_are_those_of_recorded_detections() {
        let crosstalk = |probability, delay_ps| Some(Crosstalk { probability, delay_ps });
        type Change = fn(&mut Detector);
        let laws: [(u32, Change); 4] = [
            (2, |spad| spad.coincidence = 2),
            (3, |spad| spad.combination = Combination::Xor),
            (4, |_| {}),
            (16, |spad| spad.coincidence = 2),
        ];
        // Detections a chip, chips of a step, pulse width, jitter, crosstalk.
        let conditions = [
            (0.004, 310, 7e3, 0.0, None),
            (0.1, 31, 7e3, 0.0, crosstalk(0.4, 0.0)),
            (0.05, 93, 1e3, 300.0, crosstalk(0.3, 400.0)),
            (0.03, 93, 20e3, 450.0, crosstalk(0.3, 20e3)),
            (0.02, 310, 7e3, 0.0, crosstalk(0.3, 9e3)),
            // Counts are taken from lanes every 2^20 chips, and lists that are full.
            (0.002, 31 << 16, 500e3, 0.0, None),
            (0.02, 31 << 11, 20e3, 0.0, crosstalk(0.9, 5e3)),
            // Nearly as far as ages are known.
            (1e-4, 31 << 13, 16_000e3, 0.0, None),
        ];
        for (rate, chips, pulse_width_ps, jitter_ps, cell_crosstalk) in conditions {
            for (number, (cells, change)) in laws.into_iter().enumerate() {
                let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
                let mut scene = scene::load(&file).expect("the scene is sound");
                scene.scan.integration_chips = chips;
                let spad = &mut scene.detectors[0];
                *spad = Detector { cells, pulse_width_ps, cell_crosstalk, ..spad.clone() };
                if pulse_width_ps > 10e6 {
                    spad.dark_count_rate_cps = 0.0;
                }
                spad.counter = CounterTiming::default();
                spad.jitter_ps = if jitter_ps > 0.0 { vec![jitter_ps] } else { Vec::new() };
                change(spad);
                let found = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
                scene.sources[0].mean_power_w *= rate / found.excess[0].rate_per_chip;
                let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
                let counter = StepCounter::new(&model);
                assert!(counter.sign.is_some() && counter.outside_domain().is_none());
                let recorded = StepCounter { sign: None, ..counter.clone() };

                let steps = scene.scan.steps.min(if chips > 10_000 { 8 } else { 64 });
                let repetitions = (100_000 / (chips * steps)).clamp(1, 100);
                let [found, expected] = [&counter, &recorded].map(|counter| {
                    let mut counts = vec![StepCount::ZERO; (repetitions * steps) as usize];
                    counter.count(number as u64, 0..repetitions, 0..steps, &mut counts);
                    counts
                });
                let told = format!("{cells} cells, {rate}, {chips} chips, jitter {jitter_ps}");
                let total: u64 = expected.iter().map(|count| count.total).sum();
                let mut unlike = 0;
                for (found, expected) in found.iter().zip(&expected) {
                    assert_eq!(found.total, expected.total, "{told}");
                    unlike += found.signed.abs_diff(expected.signed);
                }
                assert!(total > 0, "{told}: {total}");
                let most = if jitter_ps > 0.0 { total / 50 + 4 } else { 0 };
                assert!(unlike <= most, "{told}: {unlike} of {total}");
            }
        }
    }

    /// Ages are of 32 bits: pulses of 5,000 and 9,000 chips reach farther than they tell, and are recorded.
    #[test]
    fn pulses_that_reach_farther_than_ages_are_recorded() {
        for (pulse_width_ps, is_counted) in [(16e6, true), (40e6, false), (72e6, false)] {
            let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
            let mut scene = scene::load(&file).expect("the scene is sound");
            let spad = &mut scene.detectors[0];
            *spad = Detector { cells: 4, pulse_width_ps, dark_count_rate_cps: 0.0, ..spad.clone() };
            scene.sources[0].mean_power_w *= 1e-6;
            let model = DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0));
            assert_eq!(StepCounter::new(&model).sign.is_some(), is_counted, "{pulse_width_ps}");
        }
    }
}
