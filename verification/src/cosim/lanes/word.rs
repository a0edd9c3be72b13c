//! The lanes of a vector on their way: what one process clocks and compares.

use std::sync::atomic::{AtomicBool, Ordering};

use super::design::{Backend, LaneDesign};
use super::expected::ExpectedRun;
use super::high_samples::Place;
use super::model::{BLOCKS_AT_ONCE, BlockAnswer, LaneBlock, LaneModel, halted};
use super::planes::Planes;
use super::referee::Referee;
use super::slices::{Slice, Slices};
use super::starts::Starts;
use super::tables::{output_places, tables};
use super::vectors::LANES;
use crate::cosim::error::CosimError;
use crate::reference::stimulus::RESET_CLOCKS;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;

/// What all words of a run share.
pub(super) struct Setup<'a> {
    /// The design.
    pub(super) design: &'a LaneDesign,
    /// The sensor.
    pub(super) interface: &'a Interface,
    /// Start states.
    pub(super) starts: &'a Starts,
    /// Slices.
    pub(super) slices: Slices,
    /// Set by whoever no longer wants the run, and by a word that differs.
    pub(super) stop: &'a AtomicBool,
}

/// What came of a vector's lanes.
pub(super) struct WordResult {
    pub(super) starts: Planes,
    pub(super) ends: Planes,
    pub(super) beats: Vec<(u64, Planes)>,
    pub(super) differs: Option<u64>,
    /// Clocks of the first 64 lanes, together, that Verilator's model went through alike; of the
    /// first lanes of a run alone.
    pub(super) refereed: Result<u64, String>,
}

/// The lanes of a vector on their way, in a process of their own.
pub(super) struct VectorRun<'a> {
    setup: &'a Setup<'a>,
    expected: &'a ExpectedRun,
    slices: &'a [Slice],
    is_first: bool,
    model: LaneModel,
    /// Sees the first blocks of the first lanes.
    referee: Option<Referee>,
    /// For each detector and lane the first run of samples that is not over.
    places: Vec<Vec<Place>>,
    /// Memory of a list of edges that is needed no longer.
    spare: Vec<u32>,
    /// For each lane the next change.
    changes: Vec<usize>,
    /// Plane of each bit of a record.
    planes: Vec<Option<usize>>,
    tables: Vec<u64>,
    /// Clock of the lanes, from their slices' start.
    clock: u64,
    beats: Vec<(u64, Planes)>,
    differs: Option<u64>,
}

impl<'a> VectorRun<'a> {
    /// The lanes of a vector from `first_lane` on, or as many as are left.
    pub(super) fn new(
        setup: &'a Setup<'a>,
        expected: &'a ExpectedRun,
        first_lane: usize,
    ) -> Result<VectorRun<'a>, CosimError> {
        let all = &setup.slices.list;
        let slices = &all[first_lane..all.len().min(first_lane + LANES)];
        let layout = Layout::of(setup.interface);
        let tables = tables(setup.interface, &layout, slices, LANES);
        let is_first = first_lane == 0;
        let mut planes = vec![None; layout.outputs.words * 64];
        for (plane, (word, shift)) in output_places(&layout).into_iter().enumerate() {
            planes[word * 64 + shift as usize] = Some(plane);
        }
        Ok(VectorRun {
            model: LaneModel::load(setup.design, Backend::Vectors, &tables)?,
            referee: is_first.then(|| Referee::load(setup.design, &tables)).transpose()?,
            tables: tables.iter().map(|table| table.length).collect(),
            places: vec![vec![Place::default(); slices.len()]; expected.high.len()],
            spare: Vec::new(),
            changes: vec![0; slices.len()],
            is_first,
            planes,
            setup,
            expected,
            slices,
            clock: 0,
            beats: Vec::new(),
            differs: None,
        })
    }

    /// Clocks them to their ends.
    pub(super) fn run(mut self, on_clocks: &mut dyn FnMut(u64)) -> Result<WordResult, CosimError> {
        let starts = self.warm_up().map_err(halted)?;
        let mut ends = Planes::new(LANES, starts.rows().len());
        let mut until: Vec<u64> = self.slices.iter().map(Slice::length).collect();
        until.sort_unstable();
        until.dedup();
        let refereed = self.refereed(until[0], on_clocks).map_err(halted)?;
        for end in until {
            self.check(end, on_clocks).map_err(halted)?;
            let mut now = self.model.registers().map_err(halted)?;
            now.keep(&self.lanes_where(|slice| slice.length() == end));
            // Each lane ends once.
            ends ^= &now;
        }
        Ok(WordResult { starts, ends, beats: self.beats, differs: self.differs, refereed })
    }

    fn lanes_where(&self, is_so: impl Fn(&Slice) -> bool) -> Planes {
        Planes::row_where(LANES, self.slices.iter().map(is_so))
    }

    /// Clocks and compares what the referee sees of the lanes, before a clock at which the first of
    /// them ends; gives the clocks that it saw, or how it differs.
    fn refereed(
        &mut self,
        first_end: u64,
        on_clocks: &mut dyn FnMut(u64),
    ) -> Result<Result<u64, String>, String> {
        let Some(mut referee) = self.referee.take() else {
            return Ok(Ok(0));
        };
        let before = self.model.registers()?;
        referee.start(&before, &self.first_expected())?;
        self.referee = Some(referee);
        self.check(first_end.min(Referee::CLOCKS), on_clocks)?;
        let after = self.model.registers()?;
        let referee = self.referee.take().expect("it was put there");
        referee.verdict(&self.setup.design.registers, &after)
    }

    /// Brings every lane to the start of its slice, the first to the power-up; gives
    /// the registers.
    fn warm_up(&mut self) -> Result<Planes, String> {
        let slices = &self.setup.slices;
        let warm_up = slices.warm_up_clocks();
        let first = self.slices.as_ptr_range().start;
        let number = slices.list.iter().position(|slice| std::ptr::eq(slice, first));
        let number = number.unwrap_or_default();
        let planes_at = |before: u64| {
            let of_slice = |slice: &Slice| slice.group.saturating_sub(before);
            let groups: Vec<u64> = self.slices.iter().map(of_slice).collect();
            let counted = &self.expected.counted[number..number + self.slices.len()];
            self.setup.starts.planes(LANES, self.setup.interface, &groups, counted)
        };
        // A group without hits, after which all that no input reaches is as it should be,
        // also what was no recurrence. Then the rest is set.
        let (early, guesses) =
            (planes_at(slices.warm_up_groups + 1), planes_at(slices.warm_up_groups));
        self.model.set_registers(&early)?;
        self.clock_unwatched(slices.group_clocks, |_, _, _| Vec::new())?;
        let settled = self.model.registers()?;
        let follow = &self.setup.design.follow_inputs;
        let both = settled.rows().zip(guesses.rows()).zip(follow);
        let start =
            both.flat_map(|((settled, guess), &follows)| if follows { guess } else { settled });
        self.model.set_registers(&Planes::of_words(LANES, start.copied().collect()))?;
        let sampling = self.setup.interface.timing.sampling();
        for (detector, high) in self.expected.high.iter().enumerate() {
            for (lane, slice) in self.slices.iter().enumerate() {
                let sample = sampling.first_sample(slice.clocks.start.saturating_sub(warm_up));
                self.places[detector][lane] = high.first_hit_from(sample);
            }
        }
        self.clock_unwatched(warm_up, |word, left, clocks| {
            word.edges(-left.cast_signed(), clocks)
        })?;
        let mut planes = self.model.registers()?;
        if self.is_first {
            for (register, value) in self.setup.design.power_up(0).into_iter().enumerate() {
                planes.set(register, 0, value);
            }
            for places in &mut self.places {
                places[0] = Place::default();
            }
        }
        self.model.set_registers(&planes)?;
        let expected = self.first_expected();
        self.model.expect(&expected)?;
        Ok(planes)
    }

    /// Goes through some clocks and compares nothing; `edges` gives those of the next ones, of
    /// which so many are left.
    fn clock_unwatched(
        &mut self,
        clocks: u64,
        mut edges: impl FnMut(&mut Self, u64, u64) -> Vec<u32>,
    ) -> Result<(), String> {
        let mut left = clocks;
        loop {
            if left > 0 && self.model.under_way() < BLOCKS_AT_ONCE {
                let clocks = left.min(self.setup.design.block_clocks);
                let block = LaneBlock {
                    clocks,
                    reset: Planes::new(LANES, 1),
                    watched: Planes::new(LANES, 1),
                    edges: edges(self, left, clocks),
                    events: Vec::new(),
                    phases: vec![0; self.tables.len()],
                };
                self.model.submit(&block)?;
                left -= clocks;
            } else if self.model.under_way() > 0 {
                self.model.collect()?;
            } else {
                return Ok(());
            }
        }
    }

    /// What the outputs are expected to be before the slices.
    fn first_expected(&mut self) -> Planes {
        let mut expected = Planes::new(LANES, self.setup.design.outputs);
        let mut record = vec![0u64; self.planes.len() / 64];
        let mut next = 0;
        for (lane, slice) in self.slices.iter().enumerate() {
            while let Some(change) = self.expected.changes.get(next)
                && change.clock < slice.clocks.start
            {
                record[change.word] ^= change.flips;
                next += 1;
            }
            self.changes[lane] = next;
            for (bit, plane) in self.planes.iter().enumerate() {
                if let Some(plane) = plane {
                    expected.set(*plane, lane, record[bit / 64] >> (bit % 64) & 1 == 1);
                }
            }
        }
        expected
    }

    /// Clocks and compares up to a clock of the lanes.
    fn check(&mut self, end: u64, on_clocks: &mut dyn FnMut(u64)) -> Result<(), String> {
        let mut under_way = std::collections::VecDeque::new();
        loop {
            let go_on = self.clock < end && !self.setup.stop.load(Ordering::Relaxed);
            if go_on && self.model.under_way() < BLOCKS_AT_ONCE {
                let block = self.block(end);
                self.model.submit(&block)?;
                if let Some(referee) = &mut self.referee {
                    referee.block(&block)?;
                }
                self.clock += block.clocks;
                under_way.push_back((self.clock - block.clocks, block.clocks, block.watched));
                self.spare = block.edges;
                continue;
            }
            let Some((first, clocks, watched)) = under_way.pop_front() else {
                return Ok(());
            };
            let found = self.model.collect()?;
            if let Some(referee) = &mut self.referee {
                referee.found(&found);
            }
            on_clocks(clocks * watched.ones());
            self.take(first, &watched, found);
        }
    }

    fn take(&mut self, first: u64, watched: &Planes, found: BlockAnswer) {
        if let Some(lane) = found.different.first_lane() {
            self.setup.stop.store(true, Ordering::Relaxed);
            let clock = self.slices[lane].clocks.start + first + found.first_clock;
            self.differs = Some(self.differs.map_or(clock, |other| other.min(clock)));
        }
        // What comes from lanes that have ended belongs to nobody.
        for (clock, mut planes) in found.beats {
            planes.keep(watched);
            self.beats.push((first + clock, planes));
        }
    }

    fn block(&mut self, end: u64) -> LaneBlock {
        // The first lane's reset is a block of its own.
        let in_reset = self.is_first && self.clock < RESET_CLOCKS;
        let end = if in_reset { end.min(RESET_CLOCKS) } else { end };
        let clocks = (end - self.clock).min(self.setup.design.block_clocks);
        LaneBlock {
            clocks,
            reset: Planes::row_where(LANES, [in_reset].into_iter()),
            watched: self.lanes_where(|slice| slice.length() > self.clock),
            edges: self.edges(self.clock.cast_signed(), clocks),
            events: self.events(clocks),
            phases: self.tables.iter().map(|length| self.clock % length).collect(),
        }
    }

    /// Where the levels change in some clocks, from `clock` of the lanes on.
    fn edges(&mut self, clock: i64, clocks: u64) -> Vec<u32> {
        let sampling = self.setup.interface.timing.sampling();
        let of_detector = self.setup.interface.lanes() as usize;
        let all = self.setup.design.samples as u64;
        let mut edges = std::mem::take(&mut self.spare);
        edges.clear();
        for (detector, places) in self.places.iter_mut().enumerate() {
            let high = &self.expected.high[detector];
            high.touch(places);
            for (lane, (slice, place)) in self.slices.iter().zip(places).enumerate() {
                let Some(first) = slice.clocks.start.checked_add_signed(clock) else {
                    continue;
                };
                let window = sampling.samples(&(first..first + clocks));
                let first = (detector * of_detector * LANES + lane) as u64;
                high.edges(place, &window, |sample| {
                    let (clock, sample) = (sampling.clock_of(sample), sampling.lane_of(sample));
                    // A block's places have 32 bits: nothing wraps.
                    let row = clock.wrapping_mul(all).wrapping_add(sample.into());
                    edges.push(first.wrapping_add(row.wrapping_mul(LANES as u64)) as u32);
                });
            }
        }
        edges
    }

    /// Changes of the expected outputs in the next clocks.
    fn events(&mut self, clocks: u64) -> Vec<u64> {
        let mut events = Vec::new();
        for (lane, slice) in self.slices.iter().enumerate() {
            let start = slice.clocks.start;
            let end = (start + self.clock + clocks).min(slice.clocks.end);
            let list = &self.expected.changes;
            while let Some(change) = list.get(self.changes[lane])
                && change.clock < end
            {
                self.changes[lane] += 1;
                let mut flips = change.flips;
                while flips != 0 {
                    let bit = change.word * 64 + flips.trailing_zeros() as usize;
                    flips &= flips - 1;
                    if let Some(output) = self.planes[bit] {
                        let place = (output * LANES + lane) as u64;
                        events.push((change.clock - start - self.clock) << 32 | place);
                    }
                }
            }
        }
        events.sort_unstable();
        events
    }
}
