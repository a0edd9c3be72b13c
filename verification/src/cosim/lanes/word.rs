//! 64 lanes on their way: what one process clocks and compares.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

use super::design::Design;
use super::expected::Expected;
use super::model::{BLOCK_CLOCKS, BLOCKS_AT_ONCE, Event, Found, LaneBlock, LaneModel, halted};
use super::pulses::Packed;
use super::slices::{Slice, Slices};
use super::starts::Starts;
use super::tables::{output_places, tables};
use super::verilog::LANES;
use crate::cosim::error::CosimError;
use crate::reference::stimulus::RESET_CLOCKS;
use crate::scan::Sample;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;

/// What all words of a run share.
pub(super) struct Setup<'a> {
    /// The design.
    pub(super) design: &'a Design,
    /// The sensor.
    pub(super) interface: &'a Interface,
    /// Start states.
    pub(super) starts: &'a Starts,
    /// Slices.
    pub(super) slices: Slices,
    /// Set by whoever no longer wants the run, and by a word that differs.
    pub(super) stop: &'a AtomicBool,
}

/// What came of 64 lanes.
pub(super) struct WordResult {
    pub(super) starts: Vec<u64>,
    pub(super) ends: Vec<u64>,
    pub(super) beats: Vec<(u64, Vec<u64>)>,
    pub(super) differs: Option<u64>,
}

/// 64 lanes on their way, in a process of their own.
pub(super) struct Word<'a> {
    setup: &'a Setup<'a>,
    expected: &'a Expected,
    slices: &'a [Slice],
    is_first: bool,
    model: LaneModel,
    /// For each detector and lane the first stretch of high samples that is not over.
    cursors: Vec<Vec<usize>>,
    /// For each lane the next change.
    changes: Vec<usize>,
    /// Plane of each bit of a record.
    planes: Vec<Option<usize>>,
    tables: Vec<u64>,
    /// Clock of the lanes, from their slices' start.
    clock: u64,
    beats: Vec<(u64, Vec<u64>)>,
    differs: Option<u64>,
}

impl<'a> Word<'a> {
    /// The 64 lanes from `first_lane` on, or as many as are left.
    pub(super) fn new(
        setup: &'a Setup<'a>,
        expected: &'a Expected,
        first_lane: usize,
    ) -> Result<Word<'a>, CosimError> {
        let all = &setup.slices.list;
        let slices = &all[first_lane..all.len().min(first_lane + LANES)];
        let layout = Layout::of(setup.interface);
        let tables = tables(setup.interface, &layout, slices);
        let mut planes = vec![None; layout.outputs.words * 64];
        for (plane, (word, shift)) in output_places(&layout).into_iter().enumerate() {
            planes[word * 64 + shift as usize] = Some(plane);
        }
        Ok(Word {
            model: LaneModel::load(setup.design, &tables)?,
            tables: tables.iter().map(|table| table.planes.len() as u64).collect(),
            cursors: vec![vec![0; slices.len()]; expected.pulses.len()],
            changes: vec![0; slices.len()],
            is_first: first_lane == 0,
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
        let mut ends = vec![0; starts.len()];
        let mut until: Vec<u64> = self.slices.iter().map(Slice::length).collect();
        until.sort_unstable();
        until.dedup();
        for end in until {
            self.check(end, on_clocks).map_err(halted)?;
            let now = self.model.registers().map_err(halted)?;
            let ended = self.lanes_where(|slice| slice.length() == end);
            for (register, plane) in ends.iter_mut().zip(now) {
                *register |= plane & ended;
            }
        }
        Ok(WordResult { starts, ends, beats: self.beats, differs: self.differs })
    }

    fn lanes_where(&self, is_so: impl Fn(&Slice) -> bool) -> u64 {
        let lanes = self.slices.iter().enumerate();
        lanes.fold(0, |plane, (lane, slice)| plane | u64::from(is_so(slice)) << lane)
    }

    /// Brings every lane to the start of its slice, the first to the power-up; gives
    /// the registers.
    fn warm_up(&mut self) -> Result<Vec<u64>, String> {
        let slices = &self.setup.slices;
        let warm_up = slices.warm_up_clocks();
        let first = self.slices.as_ptr_range().start;
        let number = slices.list.iter().position(|slice| std::ptr::eq(slice, first));
        let number = number.unwrap_or_default();
        let planes_at = |before: u64| {
            let of_slice = |slice: &Slice| slice.group.saturating_sub(before);
            let groups: Vec<u64> = self.slices.iter().map(of_slice).collect();
            let counted = &self.expected.counted[number..number + self.slices.len()];
            self.setup.starts.planes(self.setup.interface, &groups, counted)
        };
        // A group without hits, after which all that no input reaches is as it should be,
        // also what was no recurrence. Then the rest is set.
        let (early, guesses) =
            (planes_at(slices.warm_up_groups + 1), planes_at(slices.warm_up_groups));
        self.model.set_registers(&early)?;
        self.clock_quietly(slices.group_clocks)?;
        let settled = self.model.registers()?;
        let follow = &self.setup.design.follow_inputs;
        let both = settled.iter().zip(&guesses).zip(follow);
        let start: Vec<u64> = both
            .map(|((&settled, &guess), &follows)| if follows { guess } else { settled })
            .collect();
        self.model.set_registers(&start)?;
        let sampling = self.setup.interface.timing.sampling();
        for (detector, pulses) in self.expected.pulses.iter().enumerate() {
            for (lane, slice) in self.slices.iter().enumerate() {
                let sample = sampling.first_sample(slice.clocks.start.saturating_sub(warm_up));
                self.cursors[detector][lane] = first_hit_from(pulses, sample);
            }
        }
        let mut left = warm_up;
        while left > 0 {
            let clocks = left.min(BLOCK_CLOCKS);
            let block = LaneBlock {
                clocks,
                samples: self.samples(-left.cast_signed(), clocks),
                phases: vec![0; self.tables.len()],
                ..LaneBlock::default()
            };
            self.model.submit(&block)?;
            self.model.collect()?;
            left -= clocks;
        }
        let mut planes = self.model.registers()?;
        if self.is_first {
            for (plane, power_up) in planes.iter_mut().zip(self.setup.design.power_up(0)) {
                *plane = *plane & !1 | power_up & 1;
            }
            for cursors in &mut self.cursors {
                cursors[0] = 0;
            }
        }
        self.model.set_registers(&planes)?;
        let expected = self.first_expected();
        self.model.expect(&expected)?;
        Ok(planes)
    }

    /// Clocks without samples, and compares nothing.
    fn clock_quietly(&mut self, clocks: u64) -> Result<(), String> {
        let mut left = clocks;
        while left > 0 {
            let clocks = left.min(BLOCK_CLOCKS);
            let block = LaneBlock {
                clocks,
                samples: vec![0; clocks as usize * self.setup.design.samples],
                phases: vec![0; self.tables.len()],
                ..LaneBlock::default()
            };
            self.model.submit(&block)?;
            self.model.collect()?;
            left -= clocks;
        }
        Ok(())
    }

    /// What the outputs are expected to be before the slices.
    fn first_expected(&mut self) -> Vec<u64> {
        let mut expected = vec![0; self.setup.design.outputs];
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
                    expected[*plane] |= (record[bit / 64] >> (bit % 64) & 1) << lane;
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
                under_way.push_back((self.clock, block.clocks, block.watched));
                self.clock += block.clocks;
                continue;
            }
            let Some((first, clocks, watched)) = under_way.pop_front() else {
                return Ok(());
            };
            let found = self.model.collect()?;
            on_clocks(clocks * u64::from(watched.count_ones()));
            self.take(first, watched, found);
        }
    }

    fn take(&mut self, first: u64, watched: u64, found: Found) {
        if found.different != 0 {
            self.setup.stop.store(true, Ordering::Relaxed);
            let lane = found.different.trailing_zeros() as usize;
            let clock = self.slices[lane].clocks.start + first + found.first_clock;
            self.differs = Some(self.differs.map_or(clock, |other| other.min(clock)));
        }
        // What comes from lanes that have ended belongs to nobody.
        for (clock, mut planes) in found.beats {
            planes.iter_mut().for_each(|plane| *plane &= watched);
            self.beats.push((first + clock, planes));
        }
    }

    fn block(&mut self, end: u64) -> LaneBlock {
        // The first lane's reset is a block of its own.
        let in_reset = self.is_first && self.clock < RESET_CLOCKS;
        let end = if in_reset { end.min(RESET_CLOCKS) } else { end };
        let clocks = (end - self.clock).min(BLOCK_CLOCKS);
        LaneBlock {
            clocks,
            reset: u64::from(in_reset),
            watched: self.lanes_where(|slice| slice.length() > self.clock),
            samples: self.samples(self.clock.cast_signed(), clocks),
            events: self.events(clocks),
            phases: self.tables.iter().map(|length| self.clock % length).collect(),
        }
    }

    /// Paints the planes of samples of some clocks, from `clock` of the lanes on.
    fn samples(&mut self, clock: i64, clocks: u64) -> Vec<u64> {
        let sampling = self.setup.interface.timing.sampling();
        let lanes = self.setup.interface.lanes() as usize;
        let all = self.setup.design.samples;
        let mut planes = vec![0u64; clocks as usize * all];
        for (detector, cursors) in self.cursors.iter_mut().enumerate() {
            let high = &self.expected.pulses[detector];
            let place = |sample: usize| sample / lanes * all + detector * lanes + sample % lanes;
            for (lane, (slice, cursor)) in self.slices.iter().zip(cursors).enumerate() {
                let Some(first) = slice.clocks.start.checked_add_signed(clock) else {
                    continue;
                };
                let window = sampling.samples(&(first..first + clocks));
                mark_edges(high, cursor, &window, |sample| {
                    planes[place(sample)] ^= 1u64 << lane;
                });
            }
            let mut level = 0;
            for word in planes.chunks_exact_mut(all) {
                for plane in &mut word[detector * lanes..][..lanes] {
                    level ^= *plane;
                    *plane = level;
                }
            }
        }
        planes
    }

    /// Changes of the expected outputs in the next clocks.
    fn events(&mut self, clocks: u64) -> Vec<Event> {
        let mut events: Vec<Event> = Vec::new();
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
                        events.push(Event {
                            clock: change.clock - start - self.clock,
                            output,
                            flips: 1 << lane,
                        });
                    }
                }
            }
        }
        events.sort_unstable();
        events.dedup_by(|later, first| {
            let same = (first.clock, first.output) == (later.clock, later.output);
            if same {
                first.flips ^= later.flips;
            }
            same
        });
        events
    }
}

/// The first pulse that is a hit at or after a sample. A lane that begins to warm up
/// there has seen no level before, and a run of high samples that reaches into it would
/// be one hit too many.
fn first_hit_from(pulses: &[Packed], sample: Sample) -> usize {
    let mut number = pulses.partition_point(|pulse| pulse.samples().end < sample);
    let mut high_until = Sample(0);
    while let Some(pulse) = pulses.get(number).map(|pulse| pulse.samples())
        && (pulse.start < sample || pulse.start <= high_until)
    {
        high_until = high_until.max(pulse.end);
        number += 1;
    }
    number
}

/// Calls `mark` with each sample of a window, numbered from its start, that is high
/// where the one before it is not, or the other way round; before the window all is low.
#[inline]
fn mark_edges(
    high: &[Packed],
    cursor: &mut usize,
    window: &Range<Sample>,
    mut mark: impl FnMut(usize),
) {
    while let Some(samples) = high.get(*cursor).map(|packed| packed.samples()) {
        if samples.start >= window.end {
            return;
        }
        if samples.end > window.start {
            mark((samples.start.max(window.start) - window.start) as usize);
        }
        // What reaches into the next window is kept for it.
        if samples.end > window.end {
            return;
        }
        if samples.end > window.start && samples.end < window.end {
            mark((samples.end - window.start) as usize);
        }
        *cursor += 1;
    }
}
