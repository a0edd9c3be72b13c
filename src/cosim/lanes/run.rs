//! A run in lanes: each lane clocks its slice, every output is compared at every clock,
//! and the ends are stitched to the starts.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;

use super::expected::Expected;
use super::model::{BLOCK_CLOCKS, BLOCKS_AT_ONCE, Design, Event, Found, LaneBlock, LaneModel};
use super::model::{Table, halted};
use super::pulses::{Light, Packed, refuse_if_stopped};
use super::slices::{Slice, Slices};
use super::starts::Starts;
use super::verilog::LANES;
use super::{Refusal, Unfit};
use crate::code::Code;
use crate::cosim::error::CosimError;
use crate::cosim::sent::{SentCount, SentReader};
use crate::reference::blocks::Records;
use crate::reference::canvas::Change;
use crate::reference::exercise::Exercise;
use crate::reference::stimulus::RESET_CLOCKS;
use crate::sensor::interface::Interface;
use crate::sensor::layout::Layout;

/// What a run in lanes found.
#[derive(Debug)]
pub struct LanesOutcome {
    /// Clocks compared.
    pub clocks: u64,
    /// Lanes that shared them.
    pub lanes: usize,
    /// What the outputs have shown.
    pub exercise: Exercise,
    /// What the result stream sent, in order.
    pub sent: Vec<SentCount>,
    /// For each detector the hits of each step, as the reference model counts them.
    pub hits: Vec<Vec<u64>>,
    /// The outputs after the last clock.
    pub last_outputs: Vec<u64>,
    /// A clock at which some output differed; not the first one.
    pub differs: Option<u64>,
}

/// A run in lanes.
pub(super) struct LanesRun<'a> {
    /// The design.
    pub(super) design: &'a Design,
    /// The sensor.
    pub(super) interface: &'a Interface,
    /// Start states.
    pub(super) starts: &'a Starts,
    /// Slices.
    pub(super) slices: Slices,
    /// Photons.
    pub(super) light: Light<'a>,
    /// Threads that make photons.
    pub(super) threads: usize,
    /// Set by whoever no longer wants the run, and by a word that differs.
    pub(super) stop: &'a AtomicBool,
}

impl LanesRun<'_> {
    /// Runs all lanes.
    ///
    /// # Errors
    /// When the registers do not stitch, or a model fails.
    pub(super) fn run(&self, on_progress: impl Fn(u64) + Sync) -> Result<LanesOutcome, Refusal> {
        let expected = Expected::of(&self.light, &self.slices, self.threads, self.stop)?;
        let done = AtomicU64::new(0);
        let results = thread::scope(|scope| {
            let word = |number: usize| {
                let (expected, done, on_progress) = (&expected, &done, &on_progress);
                scope.spawn(move || {
                    let word = Word::new(self, expected, number * LANES)?;
                    word.run(|clocks| {
                        on_progress(done.fetch_add(clocks, Ordering::Relaxed) + clocks);
                    })
                })
            };
            let count = self.slices.list.len().div_ceil(LANES);
            let words: Vec<_> = (0..count).map(word).collect();
            words
                .into_iter()
                .map(|word| {
                    word.join()
                        .unwrap_or_else(|panic| std::panic::resume_unwind(panic))
                })
                .collect::<Result<Vec<WordResult>, CosimError>>()
        })?;
        let differs = results.iter().filter_map(|result| result.differs).min();
        if differs.is_none() {
            refuse_if_stopped(self.stop)?;
            self.stitch(&results)?;
        }
        let layout = Layout::of(self.interface);
        Ok(LanesOutcome {
            clocks: self.slices.list.last().map_or(0, |slice| slice.clocks.end),
            lanes: self.slices.list.len(),
            sent: self.sent(&results, &layout),
            last_outputs: last_outputs(&expected.changes, &layout),
            exercise: expected.exercise,
            hits: expected.hits,
            differs,
        })
    }

    /// Every lane ends, in every register, as the next one starts: so they are one
    /// run.
    fn stitch(&self, results: &[WordResult]) -> Result<(), Unfit> {
        let bit = |planes: &[Vec<u64>], lane: usize, register: usize| {
            planes[lane / LANES][register] >> (lane % LANES) & 1
        };
        let starts: Vec<Vec<u64>> = results.iter().map(|word| word.starts.clone()).collect();
        let ends: Vec<Vec<u64>> = results.iter().map(|word| word.ends.clone()).collect();
        let mut loose: Vec<String> = Vec::new();
        for (number, register) in self.design.registers.iter().enumerate() {
            let fits = (1..self.slices.list.len())
                .all(|lane| bit(&starts, lane, number) == bit(&ends, lane - 1, number));
            if !fits {
                loose.push(format!("{}[{}]", register.name.0, register.name.1));
            }
        }
        if loose.is_empty() {
            return Ok(());
        }
        let count = loose.len();
        loose.truncate(4);
        Err(Unfit::new(format!(
            "{count} registers do not begin a lane as the lane before ends: {}{}",
            loose.join(", "),
            if count > 4 { ", ..." } else { "" }
        )))
    }

    /// What the stream sent, lane after lane.
    fn sent(&self, results: &[WordResult], layout: &Layout) -> Vec<SentCount> {
        let places = output_places(layout);
        let ready = layout.inputs.field("m_axis_tready");
        let mut input = vec![0; layout.inputs.words];
        input[ready.word] = 1 << ready.shift;
        let valid = layout.outputs.field("m_axis_tvalid");
        let mut reader = SentReader::new(self.interface, layout);
        let mut sent = Vec::new();
        let mut records = Records::default();
        let mut read = |got: Vec<u64>| {
            records.inputs.clone_from(&input);
            records.got = got;
            reader.read(&records, |count| sent.push(count));
        };
        for lane in 0..self.slices.list.len() {
            for (_, planes) in &results[lane / LANES].beats {
                let mut got = vec![0; layout.outputs.words];
                for (&(word, shift), plane) in places.iter().zip(planes) {
                    got[word] |= (plane >> (lane % LANES) & 1) << shift;
                }
                if got[valid.word] >> valid.shift & 1 == 1 {
                    read(got);
                }
            }
        }
        read(vec![0; layout.outputs.words]);
        sent
    }
}

/// Word and bit of each output's plane in a record, in the planes' order.
fn output_places(layout: &Layout) -> Vec<(usize, u32)> {
    let fields = layout.outputs.fields.iter();
    fields
        .flat_map(|field| {
            (0..field.port.width).map(|bit| {
                let bit = field.shift + bit;
                (field.word + (bit / 64) as usize, bit % 64)
            })
        })
        .collect()
}

/// The record of those outputs that do not follow a code, after the last clock.
fn last_outputs(changes: &[Change], layout: &Layout) -> Vec<u64> {
    let mut record = vec![0; layout.outputs.words];
    for change in changes {
        record[change.word] ^= change.flips;
    }
    record
}

/// What came of 64 lanes.
struct WordResult {
    starts: Vec<u64>,
    ends: Vec<u64>,
    beats: Vec<(u64, Vec<u64>)>,
    differs: Option<u64>,
}

/// 64 lanes on their way, in a process of their own.
struct Word<'a> {
    run: &'a LanesRun<'a>,
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
    fn new(
        run: &'a LanesRun<'a>,
        expected: &'a Expected,
        first_lane: usize,
    ) -> Result<Word<'a>, CosimError> {
        let all = &run.slices.list;
        let slices = &all[first_lane..all.len().min(first_lane + LANES)];
        let layout = Layout::of(run.interface);
        let tables = tables(run.interface, &layout, slices);
        let mut planes = vec![None; layout.outputs.words * 64];
        for (plane, (word, shift)) in output_places(&layout).into_iter().enumerate() {
            planes[word * 64 + shift as usize] = Some(plane);
        }
        Ok(Word {
            model: LaneModel::load(run.design, &tables)?,
            tables: tables
                .iter()
                .map(|table| table.planes.len() as u64)
                .collect(),
            cursors: vec![vec![0; slices.len()]; expected.pulses.len()],
            changes: vec![0; slices.len()],
            is_first: first_lane == 0,
            planes,
            run,
            expected,
            slices,
            clock: 0,
            beats: Vec::new(),
            differs: None,
        })
    }

    fn run(mut self, mut on_clocks: impl FnMut(u64)) -> Result<WordResult, CosimError> {
        let starts = self.warm_up().map_err(halted)?;
        let mut ends = vec![0; starts.len()];
        let mut until: Vec<u64> = self.slices.iter().map(length).collect();
        until.sort_unstable();
        until.dedup();
        for end in until {
            self.check(end, &mut on_clocks).map_err(halted)?;
            let now = self.model.registers().map_err(halted)?;
            let ended = self.lanes_where(|slice| length(slice) == end);
            for (register, plane) in ends.iter_mut().zip(now) {
                *register |= plane & ended;
            }
        }
        Ok(WordResult {
            starts,
            ends,
            beats: self.beats,
            differs: self.differs,
        })
    }

    fn lanes_where(&self, is_so: impl Fn(&Slice) -> bool) -> u64 {
        let lanes = self.slices.iter().enumerate();
        lanes.fold(0, |plane, (lane, slice)| {
            plane | u64::from(is_so(slice)) << lane
        })
    }

    /// Brings every lane to the start of its slice, the first to the power-up; gives
    /// the registers.
    fn warm_up(&mut self) -> Result<Vec<u64>, String> {
        let slices = &self.run.slices;
        let warm_up = slices.warm_up_clocks();
        let first = self.slices.as_ptr_range().start;
        let number = slices
            .list
            .iter()
            .position(|slice| std::ptr::eq(slice, first));
        let number = number.unwrap_or_default();
        let planes_at = |before: u64| {
            let of_slice = |slice: &Slice| slice.group.saturating_sub(before);
            let groups: Vec<u64> = self.slices.iter().map(of_slice).collect();
            let counted = &self.expected.counted[number..number + self.slices.len()];
            self.run.starts.planes(&groups, counted)
        };
        // A group without hits, after which all that no input reaches is as it should be,
        // also what was no recurrence. Then the rest is set.
        let (early, guesses) = (
            planes_at(slices.warm_up_groups + 1),
            planes_at(slices.warm_up_groups),
        );
        self.model.set_registers(&early)?;
        self.clock_quietly(slices.group_clocks)?;
        let settled = self.model.registers()?;
        let follow = &self.run.design.follow_inputs;
        let both = settled.iter().zip(&guesses).zip(follow);
        let start: Vec<u64> = both
            .map(|((&settled, &guess), &follows)| if follows { guess } else { settled })
            .collect();
        self.model.set_registers(&start)?;
        let lanes = u64::from(self.run.interface.lanes());
        for (detector, pulses) in self.expected.pulses.iter().enumerate() {
            for (lane, slice) in self.slices.iter().enumerate() {
                let sample = slice.clocks.start.saturating_sub(warm_up) * lanes;
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
            for (plane, power_up) in planes.iter_mut().zip(self.run.design.power_up(0)) {
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
                samples: vec![0; clocks as usize * self.run.design.samples],
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
        let mut expected = vec![0; self.run.design.outputs];
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
    fn check(&mut self, end: u64, on_clocks: &mut impl FnMut(u64)) -> Result<(), String> {
        let mut under_way = std::collections::VecDeque::new();
        loop {
            let go_on = self.clock < end && !self.run.stop.load(Ordering::Relaxed);
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
            self.run.stop.store(true, Ordering::Relaxed);
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
            watched: self.lanes_where(|slice| length(slice) > self.clock),
            samples: self.samples(self.clock.cast_signed(), clocks),
            events: self.events(clocks),
            phases: self
                .tables
                .iter()
                .map(|length| self.clock % length)
                .collect(),
        }
    }

    /// Paints the planes of samples of some clocks, from `clock` of the lanes on.
    fn samples(&mut self, clock: i64, clocks: u64) -> Vec<u64> {
        let lanes = self.run.interface.lanes() as usize;
        let all = self.run.design.samples;
        let mut planes = vec![0u64; clocks as usize * all];
        for (detector, cursors) in self.cursors.iter_mut().enumerate() {
            let high = &self.expected.pulses[detector];
            let place = |sample: usize| sample / lanes * all + detector * lanes + sample % lanes;
            for (lane, (slice, cursor)) in self.slices.iter().zip(cursors).enumerate() {
                let Some(first) = slice.clocks.start.checked_add_signed(clock) else {
                    continue;
                };
                let window = first * lanes as u64..(first + clocks) * lanes as u64;
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
fn first_hit_from(pulses: &[Packed], sample: u64) -> usize {
    let mut number = pulses.partition_point(|pulse| pulse.samples().end < sample);
    let mut high_until = 0;
    while let Some(pulse) = pulses.get(number).map(|pulse| pulse.samples())
        && (pulse.start < sample || pulse.start <= high_until)
    {
        high_until = high_until.max(pulse.end);
        number += 1;
    }
    number
}

fn length(slice: &Slice) -> u64 {
    slice.clocks.end - slice.clocks.start
}

/// Calls `mark` with each sample of a window, numbered from its start, that is high
/// where the one before it is not, or the other way round; before the window all is low.
#[inline]
fn mark_edges(
    high: &[Packed],
    cursor: &mut usize,
    window: &Range<u64>,
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

/// Lasers and epoch: their planes at every clock of a period.
fn tables(interface: &Interface, layout: &Layout, slices: &[Slice]) -> Vec<Table> {
    let place = |port: &str| -> usize {
        let fields = layout.outputs.fields.iter();
        let before = fields.take_while(|field| field.port.name != port);
        before.map(|field| field.port.width as usize).sum()
    };
    let most = slices.iter().map(length).max().unwrap_or_default();
    let planes = |period: u64, value: &dyn Fn(u64) -> bool| {
        let starts: Vec<u64> = slices
            .iter()
            .map(|slice| (slice.clocks.start % period + period - RESET_CLOCKS % period) % period)
            .collect();
        let plane = |clock: u64| {
            let lanes = starts.iter().enumerate();
            lanes.fold(0, |plane, (lane, start)| {
                plane | u64::from(value((start + clock) % period)) << lane
            })
        };
        (0..period.min(most)).map(plane).collect::<Vec<u64>>()
    };
    let of_code = |code: &Code| planes(code.len(), &|chip| code.chips[chip as usize] == 1);
    let period = interface.reference_codes[0].len();
    let lasers = interface.source_codes.iter().enumerate();
    let mut tables: Vec<Table> = lasers
        .map(|(number, code)| Table {
            output: place("o_laser") + number,
            planes: of_code(code).into(),
        })
        .collect();
    tables.push(Table {
        output: place("o_epoch"),
        planes: planes(period, &|chip| chip == 0).into(),
    });
    tables
}
