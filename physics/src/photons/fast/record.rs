//! The registered times of groups of phase steps, detection by detection.

use super::arithmetic::{LANES, LaneWords, jitter};
use super::domain::Tables;
use super::lanes::Lanes;
use super::places::{CHIP_BITS, IN_CHIP, round_ticks, ticks_of_chips};
use super::streams::LaneStreams;
use crate::photons::detector::DetectorCells;
use crate::photons::pixel::InputLevel;
use crate::photons::random::{RandomStream, StreamRng};
use crate::photons::{Detection, DetectorModel};
use crate::scan::Group;

/// Iterations that are kept before they are put into lists, lane by lane: they stay in a
/// core's first cache.
const ROWS: usize = 32;
/// Where a row has no detection.
const NONE: u32 = 1 << 31;
/// A lane's clock counts so many chips at most.
const CHIPS_PER_BATCH: i64 = 1 << 30;

/// A registered time in ticks since the start of its group.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct RegisteredTicks(pub(crate) u64);

impl RegisteredTicks {
    /// As the plain loop gives it.
    #[inline]
    pub fn detection(self) -> Detection {
        let fraction = (self.0 as u32 & IN_CHIP) as i32;
        Detection {
            chip: self.0 >> CHIP_BITS,
            fraction: f64::from(fraction) * (1.0 / f64::from(1_u32 << CHIP_BITS)),
        }
    }
}

/// A cell's number has so many bits: there are 64 at most.
pub const CELL_BITS: u32 = 6;
/// Where it stands in a row, above the ticks.
const CELL_SHIFT: u32 = CHIP_BITS + 1;

/// What a group of steps registers, in order.
#[derive(Debug, Clone, Default)]
pub struct RegisteredSteps {
    /// Detections, or when the level rises that several cells make.
    pub times: Vec<RegisteredTicks>,
    /// When that level falls; empty of detections, whose pulses are all equally long.
    pub ends: Vec<RegisteredTicks>,
    /// At which input each begins; empty where there is one.
    pub inputs: Vec<u8>,
}

/// What is recorded of several cells.
#[derive(Debug, Clone, Copy)]
pub enum OfCells<'t> {
    /// The level that they make.
    Level(&'t DetectorCells),
    /// Detections, with the cell of each.
    Each,
}

/// Time and cell, which is in its last bits.
fn of_cell(time: &RegisteredTicks) -> (u64, usize) {
    (time.0 >> CELL_BITS, (time.0 & ((1 << CELL_BITS) - 1)) as usize)
}

/// The level of some cells: `times` are registered ones of all of them, in order, with the cell's
/// number in the last bits.
pub fn level(pixel: &DetectorCells, times: &[RegisteredTicks]) -> RegisteredSteps {
    let width = round_ticks(pixel.pulse_width_chips) as u64;
    let mut line = InputLevel::new(pixel);
    let [rises, ends] = [(); 2].map(|()| Vec::with_capacity(times.len()));
    let mut recorded = RegisteredSteps { times: rises, ends, inputs: Vec::new() };
    let mut keep = |pulse: Option<(u64, u64)>| {
        recorded.times.extend(pulse.map(|(rise, _)| RegisteredTicks(rise)));
        recorded.ends.extend(pulse.map(|(_, fall)| RegisteredTicks(fall)));
    };
    // All pulses are equally long, so they end in the order in which they begin.
    let mut open = times.iter().map(of_cell).peekable();
    for (time, cell) in times.iter().map(of_cell) {
        while let Some((begun, ended)) = open.next_if(|(begun, _)| begun + width <= time) {
            keep(line.end(begun + width, ended));
        }
        keep(line.begin(time, time + width, cell));
    }
    for (begun, ended) in open {
        keep(line.end(begun + width, ended));
    }
    recorded
}

/// Puts a time into its place, which is near the end.
pub fn insert(list: &mut Vec<RegisteredTicks>, time: RegisteredTicks) {
    let mut place = list.len();
    list.push(time);
    while place > 0 && list[place - 1] > time {
        list[place] = list[place - 1];
        place -= 1;
    }
    list[place] = time;
}

/// An iteration of all lanes: when what fired is registered, in the lanes' clocks.
#[derive(Debug, Clone, Copy)]
struct Detections {
    chips: LaneWords,
    /// Ticks into the chip, and the cell's number; or [`NONE`].
    fractions: LaneWords,
}

/// The group of one lane.
#[derive(Debug)]
struct LaneGroup {
    /// Its place among the jobs; none of an idle lane.
    job: Option<usize>,
    /// Registered ticks of the lane's clock at zero, but for jitter.
    origin: i64,
    /// Avalanche time at which it ends, in ticks of registered time.
    end: i64,
    /// The first row that is not in the list yet.
    row: usize,
    tail: Option<StreamRng>,
}

/// Runs groups through lanes: a lane that is done takes the next one.
pub struct GroupRunner<'t> {
    model: &'t DetectorModel,
    seed: u64,
    /// Scans and groups.
    jobs: &'t [(u64, Group)],
    started: usize,
    /// For each job the times, in order.
    lists: Vec<Vec<RegisteredTicks>>,
    /// Where a step ends.
    end: i64,
    reach: i64,
    lanes: Lanes<'t>,
    /// None of a detector whose detections need no cell.
    of_cells: Option<OfCells<'t>>,
    /// Streams, and its standard deviation in ticks.
    jitter: Option<(LaneStreams, f32)>,
    rows: Box<[Detections; ROWS]>,
    row: usize,
    groups: [LaneGroup; LANES],
    busy: usize,
}

impl<'t> GroupRunner<'t> {
    pub fn new(
        model: &'t DetectorModel,
        tables: &'t Tables,
        seed: u64,
        jobs: &'t [(u64, Group)],
        of_cells: Option<OfCells<'t>>,
    ) -> GroupRunner<'t> {
        let nothing = Detections { chips: LaneWords::all(0), fractions: LaneWords::all(NONE) };
        let idle = |_| LaneGroup { job: None, origin: 0, end: 0, row: 0, tail: None };
        let chips = model.timing.scan.integration_chips;
        let expected = (model.most_detections_per_chip() * chips as f64).min(65_536.0) as usize;
        let mut runner = GroupRunner {
            model,
            seed,
            jobs,
            started: 0,
            lists: jobs.iter().map(|_| Vec::with_capacity(expected)).collect(),
            end: ticks_of_chips(chips as i64),
            reach: i64::from(tables.reach_ticks),
            lanes: Lanes::new(model, tables),
            of_cells,
            jitter: model.jitter_chips.map(|_| (LaneStreams::new(), tables.jitter_ticks as f32)),
            rows: Box::new([nothing; ROWS]),
            row: 0,
            groups: std::array::from_fn(idle),
            busy: 0,
        };
        for lane in 0..LANES {
            runner.start_next(lane);
        }
        runner
    }

    /// Simulates all jobs.
    ///
    /// Inlined into a caller for each instruction set.
    #[inline(always)]
    pub fn run(&mut self) {
        while self.busy > 0 {
            self.lanes.iterate();
            self.keep_row();
            if self.lanes.clock.any_at_border() {
                self.cross_borders();
            }
            if self.row == ROWS {
                self.empty_rows();
            }
        }
    }

    /// What all jobs have registered.
    pub fn into_recorded(self) -> Vec<RegisteredSteps> {
        let of_cells = self.of_cells;
        let recorded = |times: Vec<RegisteredTicks>| match of_cells {
            Some(OfCells::Level(pixel)) => level(pixel, &times),
            Some(OfCells::Each) => {
                let each = times.iter().map(of_cell);
                let (times, inputs) =
                    each.map(|(time, cell)| (RegisteredTicks(time), cell as u8)).unzip();
                RegisteredSteps { times, inputs, ends: Vec::new() }
            }
            None => RegisteredSteps { times, ..RegisteredSteps::default() },
        };
        self.lists.into_iter().map(recorded).collect()
    }

    #[inline(always)]
    fn keep_row(&mut self) {
        let clock = &self.lanes.clock;
        let mut shifts = LaneWords::all(0);
        if let Some((streams, sigma)) = &mut self.jitter {
            let random = streams.next();
            for lane in 0..LANES {
                shifts[lane] = jitter(random[lane], *sigma) as u32;
            }
        }
        // Of its own until it is full: of a place in a list the compiler makes no vectors.
        let mut row = Detections { chips: LaneWords::all(0), fractions: LaneWords::all(0) };
        for lane in 0..LANES {
            let ticks = clock.fractions[lane].wrapping_add(shifts[lane]);
            let none = self.lanes.fired[lane].wrapping_sub(1) & NONE;
            row.chips[lane] = clock.chips[lane].wrapping_add((ticks as i32 >> CHIP_BITS) as u32);
            row.fractions[lane] = (ticks & IN_CHIP) | none;
        }
        if let (Some(_), Some(members)) = (self.of_cells, &self.lanes.members) {
            for lane in 0..LANES {
                row.fractions[lane] |= members.hit[lane] << CELL_SHIFT;
            }
        }
        self.rows[self.row % ROWS] = row;
        self.row += 1;
    }

    #[inline(never)]
    fn empty_rows(&mut self) {
        for lane in 0..LANES {
            self.empty_rows_of(lane);
            self.groups[lane].row = 0;
        }
        self.row = 0;
    }

    /// Puts what a lane has registered into its list. Jitter lets few overtake others.
    fn empty_rows_of(&mut self, lane: usize) {
        let group = &mut self.groups[lane];
        let first = std::mem::replace(&mut group.row, self.row);
        let Some(job) = group.job else {
            return;
        };
        let list = &mut self.lists[job];
        let cell_bits = if self.of_cells.is_some() { CELL_BITS } else { 0 };
        for row in &self.rows[first..self.row] {
            let fraction = row.fractions[lane];
            if fraction & NONE != 0 {
                continue;
            }
            let chip = i64::from(row.chips[lane] as i32);
            let mut ticks = ticks_of_chips(chip) + i64::from(fraction & IN_CHIP) + group.origin;
            if let (Some(rng), Some(tail)) = (&mut group.tail, &self.model.tail) {
                ticks += round_ticks(tail.draw(rng));
            }
            if ticks < 0 || ticks >= self.end {
                continue;
            }
            let cell = u64::from(fraction >> CELL_SHIFT);
            let time = RegisteredTicks((ticks as u64) << cell_bits | cell);
            insert(list, time);
        }
    }

    #[cold]
    #[inline(never)]
    fn cross_borders(&mut self) {
        for lane in 0..LANES {
            if self.lanes.clock.is_at_border(lane) {
                self.empty_rows_of(lane);
                self.cross_border(lane);
            }
        }
    }

    /// A lane that has come to its clock's border: nothing that is avalanched from there on is
    /// registered within the group, or the border goes on.
    fn cross_border(&mut self, lane: usize) {
        let group = &mut self.groups[lane];
        if group.job.is_none() {
            self.lanes.clock.park(lane);
            return;
        }
        let time = self.lanes.clock.ticks(lane) + group.origin;
        if time >= group.end {
            self.busy -= 1;
            self.start_next(lane);
        } else {
            self.set_clock(lane, time);
        }
    }

    /// Starts the next job in a lane, or leaves the lane idle.
    fn start_next(&mut self, lane: usize) {
        let Some(&(repetition, group)) = self.jobs.get(self.started) else {
            self.groups[lane].job = None;
            self.lanes.clock.park(lane);
            return;
        };
        let model = self.model;
        let key = model.key(self.seed, repetition, group);
        if let Some((streams, _)) = &mut self.jitter {
            streams.restart(lane, key.hash(RandomStream::Jitter));
        }
        let start = self.lanes.start(lane, model, &key, 0) + round_ticks(model.delay_chips);
        self.groups[lane] = LaneGroup {
            job: Some(self.started),
            origin: 0,
            end: self.end + self.reach,
            row: self.row,
            tail: model.tail.as_ref().map(|_| key.stream(RandomStream::Tail)),
        };
        self.started += 1;
        self.busy += 1;
        self.set_clock(lane, start);
    }

    /// Sets a lane's clock at a registered time, without jitter, to run to its border.
    fn set_clock(&mut self, lane: usize, time: i64) {
        let group = &mut self.groups[lane];
        group.origin = group.end.min(time + ticks_of_chips(CHIPS_PER_BATCH));
        self.lanes.clock.set(lane, time - group.origin);
    }
}
