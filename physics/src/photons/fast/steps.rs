//! Which phase step a lane is in, and what becomes of its counts.

use std::ops::Range;

use super::arithmetic::LANES;
use super::domain::Tables;
use super::lanes::Lanes;
use super::sign;
use crate::photons::random::Part;
use crate::photons::{DetectorModel, StepCount};
use crate::scan::{Group, Step};

/// Phase steps to simulate, numbered from 0: all steps of a scan, then those of
/// the next.
#[derive(Debug, Clone)]
pub struct Jobs {
    pub seed: u64,
    pub first_repetition: u64,
    pub steps: Range<u64>,
}

impl Jobs {
    /// Number of the scan, and the step.
    pub fn repetition_and_step(&self, job: u64) -> (u64, Step) {
        let steps = self.steps.end - self.steps.start;
        (self.first_repetition + job / steps, Step(self.steps.start + job % steps))
    }
}

/// Counts are taken from a lane after so many chips, or else its words might
/// overflow.
const CHIPS_PER_BATCH: u64 = 1 << 20;

/// Where in its step a lane is, that is, which border it runs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Before the start, so that the detector forgets how it began.
    WarmUp,
    Counting,
    Idle,
}

/// Places for the counts of some jobs.
#[derive(Debug)]
pub struct Share<'o> {
    /// Number of the first job.
    pub first: u64,
    /// One for each job.
    pub places: &'o mut [StepCount],
}

/// The step of one lane.
#[derive(Debug, Clone, Copy)]
struct LaneStep {
    /// Number of the share, and place in it.
    place: (usize, usize),
    stage: Stage,
    /// Periods to go when the clock comes to its border.
    periods_left: u64,
    count: StepCount,
}

/// Runs jobs through lanes: a lane that is done takes the next job of the share
/// that was taken last, or of the next one. Lanes thus run dry only at the very
/// end.
pub struct StepRunner<'t, 'o> {
    model: &'t DetectorModel,
    tables: &'t Tables,
    jobs: &'t Jobs,
    next_share: &'t mut dyn FnMut() -> Option<Share<'o>>,
    /// Those that were taken: some lanes may still be at work in earlier ones.
    shares: Vec<Share<'o>>,
    /// Places of the last share whose jobs have been started.
    started: usize,
    lanes: Lanes<'t>,
    steps: [LaneStep; LANES],
    busy: usize,
}

impl<'t, 'o> StepRunner<'t, 'o> {
    pub fn new(
        model: &'t DetectorModel,
        tables: &'t Tables,
        jobs: &'t Jobs,
        next_share: &'t mut dyn FnMut() -> Option<Share<'o>>,
    ) -> StepRunner<'t, 'o> {
        let idle =
            LaneStep { place: (0, 0), stage: Stage::Idle, periods_left: 0, count: StepCount::ZERO };
        let mut runner = StepRunner {
            model,
            tables,
            jobs,
            next_share,
            shares: Vec::new(),
            started: 0,
            lanes: Lanes::new(model, tables),
            steps: [idle; LANES],
            busy: 0,
        };
        for lane in 0..LANES {
            runner.start_next(lane);
        }
        runner
    }

    /// Simulates all jobs of all shares.
    ///
    /// Inlined into a caller for each instruction set.
    #[inline(always)]
    pub fn run(&mut self) {
        while self.busy > 0 {
            self.lanes.run_to_border();
            self.cross_borders();
        }
    }

    #[cold]
    #[inline(never)]
    fn cross_borders(&mut self) {
        for lane in 0..LANES {
            if self.lanes.periods[lane] >= 0 {
                self.cross_border(lane);
            }
        }
    }

    /// A lane whose avalanche lies at or behind its border.
    ///
    /// Borders stand `reach` before the start and the end of the step, since
    /// jitter may take detections from there over them, and detections from up
    /// to `reach` behind them back. In that zone each is asked on which side it
    /// is registered.
    fn cross_border(&mut self, lane: usize) {
        let (before, detection) = self.take_counts(lane);
        if self.steps[lane].stage == Stage::Counting {
            self.steps[lane].count.add(before);
        }
        let reach = i64::from(self.tables.reach_ticks);
        let mut behind = i64::from(self.lanes.periods[lane])
            * i64::from(self.tables.grid.period_ticks)
            + i64::from(self.lanes.phases[lane]);
        loop {
            let step = &mut self.steps[lane];
            if step.stage == Stage::Idle {
                self.lanes.periods[lane] = i32::MIN;
                return;
            }
            if step.periods_left > 0 {
                behind = self.set_clock(lane, behind);
                if behind < 0 {
                    self.steps[lane].count.add(detection);
                    return;
                }
                continue;
            }
            if behind < 2 * reach {
                let uniform = self.lanes.sign.uniforms[lane];
                let is_before = sign::is_before(behind - reach, self.tables.jitter_ticks, uniform);
                if is_before == (step.stage == Stage::Counting) {
                    step.count.add(detection);
                }
                return;
            }
            if step.stage == Stage::Counting {
                let (share, place) = step.place;
                self.shares[share].places[place] = step.count;
                self.busy -= 1;
                self.start_next(lane);
                return;
            }
            step.stage = Stage::Counting;
            behind = self.aim_at_end(lane, behind);
            if behind < 0 {
                self.steps[lane].count.add(detection);
                return;
            }
        }
    }

    /// Empties a lane's counts: those before the last iteration, and its own.
    fn take_counts(&mut self, lane: usize) -> (StepCount, StepCount) {
        let lanes = &mut self.lanes;
        let fired = lanes.fired[lane];
        let up = fired & lanes.sign.levels[lane];
        let before = StepCount::of(lanes.ups[lane] - up, lanes.totals[lane] - fired);
        lanes.ups[lane] = 0;
        lanes.totals[lane] = 0;
        (before, StepCount::of(up, fired))
    }

    /// Puts a lane's border from the start to the end of its step. `behind` is
    /// how far behind the old border the lane is; returns it for the new one.
    fn aim_at_end(&mut self, lane: usize, behind: i64) -> i64 {
        let grid = self.tables.grid;
        let chips = self.model.timing.scan.integration_chips;
        let rest = grid.ticks_of_chips((chips % u64::from(grid.period_chips)) as u32);
        // The clock's zero moves by the rest; what is looked up must not.
        let moved = |offset: u32| grid.phase(i64::from(offset) + i64::from(rest));
        for path in &mut self.lanes.paths {
            path.offsets[lane] = moved(path.offsets[lane]);
        }
        self.lanes.sign.offsets[lane] = moved(self.lanes.sign.offsets[lane]);
        self.steps[lane].periods_left = chips / u64::from(grid.period_chips);
        self.set_clock(lane, behind - i64::from(rest))
    }

    /// Sets a lane's clock for the next batch of the periods that are left.
    fn set_clock(&mut self, lane: usize, behind: i64) -> i64 {
        let grid = self.tables.grid;
        let step = &mut self.steps[lane];
        let batch = (CHIPS_PER_BATCH / u64::from(grid.period_chips)).min(step.periods_left);
        step.periods_left -= batch;
        let behind = behind - batch as i64 * i64::from(grid.period_ticks);
        self.lanes.phases[lane] = grid.phase(behind);
        self.lanes.periods[lane] = behind.div_euclid(i64::from(grid.period_ticks)) as i32;
        behind
    }

    /// Starts the next job in a lane, or leaves the lane idle.
    fn start_next(&mut self, lane: usize) {
        let Some((number, place)) = self.next_job() else {
            self.steps[lane].stage = Stage::Idle;
            self.lanes.periods[lane] = i32::MIN;
            return;
        };
        self.busy += 1;
        self.steps[lane] =
            LaneStep { place, stage: Stage::WarmUp, periods_left: 0, count: StepCount::ZERO };
        let (repetition, step) = self.jobs.repetition_and_step(number);
        self.restart_streams(lane, repetition, self.model.timing.grouping().group_of(step));
        self.aim_at_start(lane, repetition, step);
    }

    /// Number of the next job, and where its counts belong.
    fn next_job(&mut self) -> Option<(u64, (usize, usize))> {
        while self.shares.last().is_none_or(|s| self.started == s.places.len()) {
            let share = (self.next_share)()?;
            self.shares.push(share);
            self.started = 0;
        }
        let index = self.shares.len() - 1;
        let place = self.started;
        self.started += 1;
        Some((self.shares[index].first + place as u64, (index, place)))
    }

    /// Steps of one group get the same streams: the same detections, in each of
    /// their lanes.
    fn restart_streams(&mut self, lane: usize, repetition: u64, group: Group) {
        let key = self.model.key(self.jobs.seed, repetition, group);
        let lanes = &mut self.lanes;
        for (path, table) in lanes.paths.iter_mut().zip(&self.tables.paths) {
            path.streams.restart(lane, key.hash(Part::Path(table.number)));
        }
        if let Some(constant) = &mut lanes.constant {
            constant.streams.restart(lane, key.hash(Part::ConstantLight));
        }
        if let Some(afterpulses) = &mut lanes.afterpulses {
            let hash = key.hash(Part::Afterpulsing);
            afterpulses.streams.restart(lane, hash);
            afterpulses.masses[lane] = 0.0;
        }
        lanes.sign.streams.restart(lane, key.hash(Part::Jitter));
    }

    /// Puts a ready detector before the step, and the lane's border at its start.
    fn aim_at_start(&mut self, lane: usize, repetition: u64, step: Step) {
        let grid = self.tables.grid;
        let model = self.model;
        // All in avalanche time: a detection is registered `delay` later.
        let delay = grid.round(model.delay_chips);
        let border = -delay - i64::from(self.tables.reach_ticks);
        let group = model.timing.grouping().group_of(step);
        let code = model.code_position(repetition, group, u64::from(grid.period_chips));
        let code = i64::from(grid.ticks_of_chips(code as u32)) + border;
        for (path, table) in self.lanes.paths.iter_mut().zip(&self.tables.paths) {
            path.offsets[lane] = grid.phase(code - table.delay_ticks);
        }
        let phase_step = model.timing.scan.phase_step(step);
        let samples_per_chip = u64::from(model.timing.clock.samples_per_chip);
        let phase_step = (phase_step / samples_per_chip * u64::from(grid.chip_ticks())) as i64
            + grid.round((phase_step % samples_per_chip) as f64 / samples_per_chip as f64);
        self.lanes.sign.offsets[lane] =
            grid.phase(code + delay - phase_step - self.tables.sign.first_cell);

        let first_ready = model.first_ready_chips(&model.key(self.jobs.seed, repetition, group));
        let start =
            grid.round(first_ready) - model.warm_up_chips * i64::from(grid.chip_ticks()) - border;
        self.lanes.phases[lane] = grid.phase(start);
        self.lanes.periods[lane] = start.div_euclid(i64::from(grid.period_ticks)) as i32;
        self.lanes.fired[lane] = 0;
        self.lanes.totals[lane] = 0;
        self.lanes.ups[lane] = 0;
    }
}
