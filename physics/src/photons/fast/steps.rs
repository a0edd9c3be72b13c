//! Which phase step a lane is in, and what becomes of its counts.

use std::ops::Range;

use super::arithmetic::{LANES, LaneWords};
use super::domain::Tables;
use super::lanes::Lanes;
use super::overlaps::Overlaps;
use super::places::{round_ticks, ticks_of_chips};
use super::sign::{Sign, SignTable};
use crate::photons::counter::transition;
use crate::photons::random::RandomStream;
use crate::photons::{DetectorModel, StepCount};
use crate::scan::Step;

/// Phase steps to simulate, numbered from 0: all steps of a scan, then those of
/// the next.
#[derive(Debug, Clone)]
pub struct StepJobs {
    pub seed: u64,
    pub first_repetition: u64,
    pub steps: Range<u64>,
}

impl StepJobs {
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
pub struct JobShare<'o> {
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
    /// Chips to go when the clock comes to its border.
    chips_left: u64,
    count: StepCount,
}

/// Runs jobs through lanes: a lane that is done takes the next job of the share
/// that was taken last, or of the next one. Lanes thus run dry only at the very
/// end.
pub struct StepRunner<'t, 'o> {
    model: &'t DetectorModel,
    tables: &'t Tables,
    jobs: &'t StepJobs,
    next_share: &'t mut dyn FnMut() -> Option<JobShare<'o>>,
    /// Those that were taken: some lanes may still be at work in earlier ones.
    shares: Vec<JobShare<'o>>,
    /// Places of the last share whose jobs have been started.
    started: usize,
    lanes: Lanes<'t>,
    sign: Sign<'t>,
    /// Of several cells that make one level.
    overlaps: Option<Overlaps<'t>>,
    /// Detections since a lane's counts were taken.
    totals: LaneWords,
    /// Those of them that counted up.
    ups: LaneWords,
    steps: [LaneStep; LANES],
    busy: usize,
}

impl<'t, 'o> StepRunner<'t, 'o> {
    pub fn new(
        model: &'t DetectorModel,
        tables: &'t Tables,
        sign: &'t SignTable,
        jobs: &'t StepJobs,
        next_share: &'t mut dyn FnMut() -> Option<JobShare<'o>>,
    ) -> StepRunner<'t, 'o> {
        let idle =
            LaneStep { place: (0, 0), stage: Stage::Idle, chips_left: 0, count: StepCount::ZERO };
        let overlaps = Overlaps::new(model, tables);
        let mut runner = StepRunner {
            model,
            tables,
            jobs,
            next_share,
            shares: Vec::new(),
            started: 0,
            lanes: Lanes::new(model, tables),
            sign: Sign::new(sign, overlaps.is_some()),
            overlaps,
            totals: LaneWords::all(0),
            ups: LaneWords::all(0),
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
            self.iterate();
            if self.lanes.clock.any_at_border() {
                self.cross_borders();
            }
        }
    }

    #[inline(always)]
    fn iterate(&mut self) {
        self.lanes.iterate();
        self.sign.decide(&self.lanes.elapsed);
        let counted = self.counted();
        for lane in 0..LANES {
            self.totals[lane] = self.totals[lane].wrapping_add(counted[lane]);
            self.ups[lane] = self.ups[lane].wrapping_add(counted[lane] & self.sign.levels[lane]);
        }
    }

    /// 1 where the last avalanche is counted.
    #[inline(always)]
    fn counted(&mut self) -> LaneWords {
        let fired = self.lanes.fired;
        let (Some(overlaps), Some(members)) = (&mut self.overlaps, &self.lanes.members) else {
            return fired;
        };
        let (near, lanes) = overlaps.advance(&self.lanes.elapsed, &fired);
        let cells = members.hit;
        if lanes != 0 {
            self.list(lanes, &cells);
        }
        match &mut self.overlaps {
            Some(overlaps) => overlaps.follow(&fired, &near, &cells, &self.sign),
            None => fired,
        }
    }

    /// Puts avalanches that may overlap the last ones into lists, and those.
    #[inline(never)]
    fn list(&mut self, mut lanes: u64, cells: &LaneWords) {
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let now = self.list_last(lane);
            if let Some(overlaps) = &mut self.overlaps {
                overlaps.list(lane, now, self.sign.randoms[lane], cells[lane]);
            }
        }
    }

    /// Puts the avalanche that was the last into its lane's list, and takes it out of the counts. Gives the lane's
    /// time, as it is registered without jitter.
    fn list_last(&mut self, lane: usize) -> i64 {
        let now = self.registered(lane);
        if self.overlaps.as_ref().is_some_and(|overlaps| overlaps.is_full(lane)) {
            self.count_list(lane);
        }
        if let Some(overlaps) = &mut self.overlaps {
            let (total, ups) = overlaps.list_last(lane, now);
            self.totals[lane] = self.totals[lane].wrapping_sub(total);
            self.ups[lane] = self.ups[lane].wrapping_sub(ups);
        }
        now
    }

    /// Adds a lane's list to its counts.
    fn count_list(&mut self, lane: usize) {
        let LaneStep { place: (share, place), count, .. } = &mut self.steps[lane];
        let job = self.shares[*share].first + *place as u64;
        let (repetition, step) = self.jobs.repetition_and_step(job);
        if let Some(overlaps) = &mut self.overlaps {
            count.add(overlaps.take(lane, repetition, step));
        }
    }

    /// A lane's time, as it is registered without jitter.
    fn registered(&self, lane: usize) -> i64 {
        let step = &self.steps[lane];
        let chips = match step.stage {
            Stage::Counting => self.model.timing.scan.integration_chips - step.chips_left,
            Stage::WarmUp | Stage::Idle => 0,
        };
        let border = ticks_of_chips(chips as i64) - i64::from(self.tables.reach_ticks);
        self.lanes.clock.ticks(lane) + border
    }

    #[cold]
    #[inline(never)]
    fn cross_borders(&mut self) {
        for lane in 0..LANES {
            if self.lanes.clock.is_at_border(lane) {
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
        if self.overlaps.is_some() {
            self.list_last(lane);
        }
        let (before, detection) = self.take_counts(lane);
        if self.steps[lane].stage == Stage::Counting {
            self.steps[lane].count.add(before);
        }
        let reach = i64::from(self.tables.reach_ticks);
        let mut behind = self.lanes.clock.ticks(lane);
        loop {
            let step = &mut self.steps[lane];
            if step.stage == Stage::Idle {
                self.lanes.clock.park(lane);
                return;
            }
            if step.chips_left > 0 {
                behind = self.set_clock(lane, behind);
                if behind < 0 {
                    self.steps[lane].count.add(detection);
                    return;
                }
                continue;
            }
            if behind < 2 * reach {
                let is_before = self.sign.is_before(lane, behind - reach, self.tables.jitter_ticks);
                if is_before == (step.stage == Stage::Counting) {
                    step.count.add(detection);
                }
                return;
            }
            if step.stage == Stage::Counting {
                self.count_list(lane);
                let LaneStep { place: (share, place), count, .. } = self.steps[lane];
                self.shares[share].places[place] = count;
                self.busy -= 1;
                self.start_next(lane);
                return;
            }
            step.stage = Stage::Counting;
            step.chips_left = self.model.timing.scan.integration_chips;
        }
    }

    /// Empties a lane's counts: those before the last iteration, and its own, unless that is in a list.
    fn take_counts(&mut self, lane: usize) -> (StepCount, StepCount) {
        let fired = if self.overlaps.is_some() { 0 } else { self.lanes.fired[lane] };
        let up = fired & self.sign.levels[lane];
        let before = StepCount::of(self.ups[lane] - up, self.totals[lane] - fired);
        self.ups[lane] = 0;
        self.totals[lane] = 0;
        (before, StepCount::of(up, fired))
    }

    /// Sets a lane's clock for the next batch of the chips that are left; gives it in ticks.
    fn set_clock(&mut self, lane: usize, behind: i64) -> i64 {
        let step = &mut self.steps[lane];
        let batch = CHIPS_PER_BATCH.min(step.chips_left);
        step.chips_left -= batch;
        let behind = behind - ticks_of_chips(batch as i64);
        self.lanes.clock.set(lane, behind);
        behind
    }

    /// Starts the next job in a lane, or leaves the lane idle.
    fn start_next(&mut self, lane: usize) {
        let Some((number, place)) = self.next_job() else {
            self.steps[lane].stage = Stage::Idle;
            self.lanes.clock.park(lane);
            return;
        };
        self.busy += 1;
        self.steps[lane] =
            LaneStep { place, stage: Stage::WarmUp, chips_left: 0, count: StepCount::ZERO };
        let (repetition, step) = self.jobs.repetition_and_step(number);
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

    /// Puts a ready detector before the step, and the lane's border at its start.
    fn aim_at_start(&mut self, lane: usize, repetition: u64, step: Step) {
        let (model, sign) = (self.model, self.sign.table);
        let group = model.timing.grouping().group_of(step);
        let key = model.key(self.jobs.seed, repetition, group);
        // All in avalanche time: a detection is registered `delay` later.
        let delay = round_ticks(model.delay_chips);
        let border = -delay - i64::from(self.tables.reach_ticks);
        let start = self.lanes.start(lane, model, &key, border);

        let samples_per_chip = u64::from(model.timing.clock.samples_per_chip);
        let phase_step = model.timing.scan.phase_step(step);
        let [chips, samples] = [phase_step / samples_per_chip, phase_step % samples_per_chip];
        let phase_step =
            ticks_of_chips(chips as i64) + round_ticks(samples as f64 / samples_per_chip as f64);
        let code = model.code_position(repetition, group, model.reference.len());
        let place = ticks_of_chips(code) + start + delay - phase_step - sign.first_cell;
        self.sign.places.set(lane, place);
        self.sign.streams.restart(lane, key.hash(RandomStream::Jitter));
        if let Some(coins) = &mut self.sign.coins {
            coins.restart(lane, key.hash_of_step(step, RandomStream::Transition));
        }
        if let Some(overlaps) = &mut self.overlaps {
            overlaps.start(lane, transition(model, self.jobs.seed, repetition, step));
        }
        self.totals[lane] = 0;
        self.ups[lane] = 0;
    }
}
