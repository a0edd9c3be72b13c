//! The state of the detector through one code period.

// States are looped over by number: iterators are not always inlined.
#![allow(clippy::needless_range_loop)]

use std::ops::Range;

use super::chain::{Chain, State};
use super::grid::{Grid, Rearming};
use super::history::History;
use super::integrator::{CellStep, CellSteps};
use super::steady::{self, Round, Rounds};

/// Mean detections over one common code period.
#[derive(Debug, Clone)]
pub struct Detections {
    /// For each cell: the rate at its start and end, and its slope there times
    /// the cell's width.
    pub rates: Vec<[f64; 4]>,
    /// Expected detections before each cell, and in all.
    pub cumulative: Vec<f64>,
}

/// Probabilities of the ready states at each cell's start, middle and end.
pub type ReadyStates<const M: usize> = Vec<[State<M>; 3]>;

impl Detections {
    /// From the cubics of all cells.
    pub fn of(grid: &Grid, rates: Vec<[f64; 4]>) -> Detections {
        let mut cumulative = Vec::with_capacity(rates.len() + 1);
        let mut before_chip = 0.0;
        cumulative.push(before_chip);
        // Chip by chip: one sum would wait for each of its additions.
        for rates in rates.chunks(grid.cells.len()) {
            let mut sum = 0.0;
            for (rate, cell) in rates.iter().zip(&grid.cells) {
                sum += cell.width * integral_of_cubic(rate);
                cumulative.push(before_chip + sum);
            }
            before_chip += sum;
        }
        Detections { rates, cumulative }
    }

    /// Without dead time and afterpulses every primary event is a detection.
    pub fn poisson(grid: &Grid) -> Detections {
        let mut lambdas = Vec::new();
        let mut rates = Vec::with_capacity(grid.period_chips * grid.cells.len());
        for chip in 0..grid.period_chips {
            grid.fill_rates(chip as i64, &mut lambdas);
            rates.extend(lambdas.iter().map(|&lambda| [lambda, lambda, 0.0, 0.0]));
        }
        Detections::of(grid, rates)
    }

    /// Expected detections in a whole code period.
    pub fn per_period(&self) -> f64 {
        self.cumulative[self.cumulative.len() - 1]
    }

    /// The time in chips until which so many detections are expected from the start of a code period:
    /// the inverse of [`Detections::until`].
    pub fn when(&self, grid: &Grid, detections: f64) -> f64 {
        let turns = (detections / self.per_period()).floor();
        let left = detections - turns * self.per_period();
        let cells = grid.cells.len();
        let index = self.cumulative.partition_point(|before| *before <= left);
        let index = index.clamp(1, self.rates.len()) - 1;
        let (chip, cell) = (index / cells, index % cells);
        let width = grid.cells[cell].width;
        let (mut low, mut high) = (0.0, 1.0);
        // To 10^-9 of a cell.
        for _ in 0..30 {
            let middle: f64 = 0.5 * (low + high);
            let before =
                self.cumulative[index] + width * integral_until(&self.rates[index], middle);
            (low, high) = if before < left { (middle, high) } else { (low, middle) };
        }
        let chips = turns * grid.period_chips as f64 + chip as f64;
        chips + grid.edges[cell] + low * width
    }

    /// Expected detections from the start of a code period to a time in chips.
    pub fn until(&self, grid: &Grid, time: f64) -> f64 {
        let (chip, cell, position) = grid.locate(time);
        let period = grid.period_chips as i64;
        let index = chip.rem_euclid(period) as usize * grid.cells.len() + cell;
        let within = grid.cells[cell].width * integral_until(&self.rates[index], position);
        chip.div_euclid(period) as f64 * self.per_period() + self.cumulative[index] + within
    }
}

/// The integral over 0..1 of the cubic with values and slopes `[y0, y1, s0, s1]`.
fn integral_of_cubic([start, end, start_slope, end_slope]: &[f64; 4]) -> f64 {
    0.5 * (start + end) + (start_slope - end_slope) / 12.0
}

/// The integral of that cubic over 0..x.
fn integral_until(cubic: &[f64; 4], x: f64) -> f64 {
    let basis = integrated_basis(x);
    cubic.iter().zip(basis).map(|(y, basis)| y * basis).sum()
}

/// Integrals over 0..x of the cubic's four basis functions: one for each of the
/// values at start and end, and of the slopes there.
pub fn integrated_basis(x: f64) -> [f64; 4] {
    let (square, cube) = (x * x, x * x * x);
    [
        x - cube + 0.5 * square * square,
        cube - 0.5 * square * square,
        0.5 * square - 2.0 / 3.0 * cube + 0.25 * square * square,
        0.25 * square * square - cube / 3.0,
    ]
}

/// Mean detections, and those among them whose pulse merges with the one before.
#[derive(Debug, Clone)]
pub struct AllAndMerged {
    /// Every detection.
    pub all: Detections,
    /// Those that are no rising edge of their own; none where pulses cannot merge.
    pub merged: Option<Detections>,
}

impl AllAndMerged {
    /// Expected rising edges in a whole code period.
    pub fn per_period(&self) -> f64 {
        self.all.per_period() - self.merged.as_ref().map_or(0.0, Detections::per_period)
    }

    /// Detections that are rising edges.
    pub fn counted(&self) -> Detections {
        let Some(merged) = &self.merged else {
            return self.all.clone();
        };
        let less = |(a, b): (&[f64; 4], &[f64; 4])| std::array::from_fn(|i| a[i] - b[i]);
        let (all, merged_before) = (&self.all.cumulative, &merged.cumulative);
        Detections {
            rates: self.all.rates.iter().zip(&merged.rates).map(less).collect(),
            cumulative: all.iter().zip(merged_before).map(|(a, b)| a - b).collect(),
        }
    }
}

/// Ready states whose next pulse will not count, by the number of sample instants
/// that must pass first, less one.
struct Unarmed<'g, const M: usize> {
    rearming: &'g Rearming,
    levels: Vec<State<M>>,
}

impl<'g, const M: usize> Unarmed<'g, M> {
    fn new(grid: &'g Grid) -> Option<Unarmed<'g, M>> {
        let rearming = grid.rearming.as_ref()?;
        Some(Unarmed { levels: vec![[0.0; M]; rearming.most_waits()], rearming })
    }

    /// Goes through cell `index`: the states at its start and end, and their slopes.
    #[inline(always)]
    fn advance(
        &mut self,
        index: usize,
        step: &CellStep<M>,
        inflow: &[State<M>; 3],
    ) -> [State<M>; 4] {
        // A detector may merge pulses and be ready again at once: then nothing waits.
        if self.rearming.at_instant[index] && !self.levels.is_empty() {
            self.levels.rotate_left(1);
            if let Some(last) = self.levels.last_mut() {
                *last = [0.0; M];
            }
        }
        let waits = self.rearming.waits[index];
        let nothing = [[0.0; M]; 3];
        let mut sums = [[0.0; M]; 4];
        for (level, state) in self.levels.iter_mut().enumerate() {
            let inflow = if level + 1 == waits { inflow } else { &nothing };
            let end = step.advance(state, inflow);
            let slopes = [step.slope(state, &inflow[0]), step.slope(&end, &inflow[2])];
            for m in 0..M {
                sums[0][m] += state[m];
                sums[1][m] += end[m];
                sums[2][m] += slopes[0][m];
                sums[3][m] += slopes[1][m];
            }
            *state = end;
        }
        sums
    }
}

/// Detections within the last dead time.
struct DeadTime {
    /// Rates of the last chips' cells, a ring.
    rates: Vec<[f64; 4]>,
    chips: usize,
    /// Chips put so far.
    next: usize,
    /// Whole chips before now, cell, and position of where the dead time began
    /// that ends now.
    begin: (i64, usize, f64),
}

impl DeadTime {
    fn new(grid: &Grid) -> DeadTime {
        let chips = grid.reach_chips + 1;
        DeadTime {
            rates: vec![[0.0; 4]; chips * grid.cells.len()],
            chips,
            next: 0,
            begin: grid.locate(-grid.dead_time_chips),
        }
    }

    fn put(&mut self, chip: usize, cell: usize, rate: [f64; 4]) {
        let cells = self.rates.len() / self.chips;
        self.rates[(chip % self.chips) * cells + cell] = rate;
        self.next = chip + 1;
    }

    /// Probability to be dead at the end of the last chip.
    fn probability(&self, grid: &Grid) -> f64 {
        let (chip, first_cell, position) = self.begin;
        let cells = grid.cells.len();
        let mut sum = 0.0;
        for back in (chip..0).map(|chip| chip.unsigned_abs() as usize) {
            // Before the beginning nothing was detected.
            let Some(chip_number) = self.next.checked_sub(back) else {
                continue;
            };
            let is_first = back == chip.unsigned_abs() as usize;
            for cell in if is_first { first_cell } else { 0 }..cells {
                let rate = &self.rates[(chip_number % self.chips) * cells + cell];
                let mut share = integral_of_cubic(rate);
                if is_first && cell == first_cell {
                    share -= integral_until(rate, position);
                }
                sum += grid.cells[cell].width * share;
            }
        }
        sum
    }
}

/// Solves from a ready detector until it has forgotten that, and through one code period, of which
/// the mean detections are returned; `states`, if given, receives the ready states whose next pulse
/// counts.
pub fn solve<const M: usize>(
    grid: &Grid,
    chain: &Chain<M>,
    round: Option<Round>,
    states: Option<&mut ReadyStates<M>>,
) -> AllAndMerged {
    let mut detector = Detector::new(grid, chain);
    match round {
        Some(round) => {
            detector.round_chips = round.chips;
            steady::settle(&mut detector, round.most);
        }
        None => {
            detector.first_chip = -(grid.memory_chips as i64);
            detector.go_on(grid.memory_chips, None);
        }
    }
    let rates = Vec::with_capacity(grid.period_chips * grid.cells.len());
    let mut period = Period { rates, merged: Vec::new(), states };
    // Of even light one chip is like the next.
    if grid.is_even() {
        detector.go_on(1, Some(&mut period));
        period.repeat(grid.period_chips);
    } else {
        detector.go_on(grid.period_chips, Some(&mut period));
    }
    AllAndMerged {
        all: Detections::of(grid, period.rates),
        merged: grid.rearming.as_ref().map(|_| Detections::of(grid, period.merged)),
    }
}

/// What is kept of a code period.
struct Period<'s, const M: usize> {
    rates: Vec<[f64; 4]>,
    /// Of detections that merge; empty where pulses cannot.
    merged: Vec<[f64; 4]>,
    states: Option<&'s mut ReadyStates<M>>,
}

impl<const M: usize> Period<'_, M> {
    /// As many times what is kept.
    fn repeat(&mut self, times: usize) {
        self.rates = self.rates.repeat(times);
        self.merged = self.merged.repeat(times);
        if let Some(states) = &mut self.states {
            **states = states.repeat(times);
        }
    }
}

/// A detector that started ready, some chips ago.
struct Detector<'g, const M: usize> {
    grid: &'g Grid,
    steps: CellSteps<'g, M>,
    /// Probabilities of the ready states.
    ready: State<M>,
    history: History<M, f64>,
    unarmed: Option<Unarmed<'g, M>>,
    dead: DeadTime,
    /// Chip of the light with which it started.
    first_chip: i64,
    /// Chips since.
    chips: usize,
    /// Chips of a round.
    round_chips: usize,
    lambdas: Vec<f64>,
}

impl<'g, const M: usize> Detector<'g, M> {
    fn new(grid: &'g Grid, chain: &'g Chain<M>) -> Detector<'g, M> {
        let mut ready = [0.0; M];
        ready[0] = 1.0;
        Detector {
            grid,
            steps: CellSteps::new(chain, grid.cells.len()),
            ready,
            history: History::new(grid.cells.len(), grid.reach_chips),
            unarmed: Unarmed::new(grid),
            dead: DeadTime::new(grid),
            first_chip: 0,
            chips: 0,
            round_chips: 0,
            lambdas: Vec::new(),
        }
    }

    /// Goes through some chips, which `period` keeps.
    ///
    /// With the widest vectors that the processor has: no operation differs, so
    /// results do not.
    fn go_on(&mut self, chips: usize, period: Option<&mut Period<M>>) {
        #[cfg(target_arch = "x86_64")]
        if is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has the instructions, as just made sure.
            return unsafe { self.go_on_avx2(chips, period) };
        }
        self.go_on_plainly(chips, period);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn go_on_avx2(&mut self, chips: usize, period: Option<&mut Period<M>>) {
        self.go_on_plainly(chips, period);
    }

    #[inline(always)]
    fn go_on_plainly(&mut self, chips: usize, mut period: Option<&mut Period<M>>) {
        let grid = self.grid;
        let first = self.chips;
        for chip in first..first + chips {
            // Steps of finite length lose or gain some 10^-8 of probability at a time,
            // and nothing would ever bring it back: what is not dead is ready.
            let ready = (1.0 - self.dead.probability(grid)) / self.ready.iter().sum::<f64>();
            for m in 0..M {
                self.ready[m] *= ready;
            }
            grid.fill_rates(self.first_chip + chip as i64, &mut self.lambdas);
            for (index, cell) in grid.cells.iter().enumerate() {
                let step = self.steps.get(index, cell.width, self.lambdas[index]);
                let mut inflow = [[0.0; M]; 3];
                for node in 0..3 {
                    let place = &cell.before[node];
                    // The detector starts ready: before, nothing is dead yet.
                    if let Ok(past) = usize::try_from(chip as i64 + place.chips) {
                        inflow[node] = self.history.read(past, place);
                    }
                }
                let end = step.advance(&self.ready, &inflow);
                let start_slope = step.slope(&self.ready, &inflow[0]);
                let end_slope = step.slope(&end, &inflow[2]);
                let borders = [self.ready, end, start_slope, end_slope];
                let waiting = match &mut self.unarmed {
                    Some(unarmed) => unarmed.advance(index, step, &inflow),
                    None => [[0.0; M]; 4],
                };
                // What comes back one dead time later; linear, so slopes pass alike.
                let passing = pass(step, &borders);
                let rate = rates_of(&passing, cell.width);
                self.dead.put(chip, index, rate);
                if let Some(period) = period.as_deref_mut() {
                    period.rates.push(rate);
                    if self.unarmed.is_some() {
                        period.merged.push(rates_of(&pass(step, &waiting), cell.width));
                    }
                    if let Some(states) = period.states.as_deref_mut() {
                        states.push(armed(&borders, &waiting, cell.width));
                    }
                }
                self.history.put(chip, index, passing);
                self.ready = end;
            }
        }
        self.chips += chips;
    }

    /// The last chips, of which a dead time reads.
    fn reached(&self) -> Range<usize> {
        self.chips - self.grid.reach_chips - 1..self.chips
    }
}

/// Its state is what the next dead time reads of the last one, what is ready, and what waits.
impl<const M: usize> Rounds for Detector<'_, M> {
    fn go_round(&mut self) {
        self.go_on(self.round_chips, None);
    }

    fn states(&self) -> Vec<Vec<f64>> {
        let waiting = self.unarmed.iter().flat_map(|unarmed| &unarmed.levels);
        let waiting = waiting.flatten().chain(&self.ready);
        let borders = (0..4).flat_map(|border| {
            let cells = self.reached().flat_map(|chip| self.history.of_chip(chip));
            cells.flat_map(move |borders| &borders[border])
        });
        vec![borders.chain(waiting).copied().collect()]
    }

    /// Cells' starts.
    fn telling(&self) -> usize {
        self.reached().len() * self.grid.cells.len() * M
    }

    /// Nothing: what is ready is all that is not blind.
    fn drifting(&self) -> usize {
        0
    }

    fn set(&mut self, states: &[Vec<f64>]) {
        let mut state = states[0].iter().copied();
        let mut next = || state.next().unwrap_or_default();
        for border in 0..4 {
            for chip in self.reached() {
                for borders in self.history.of_chip_mut(chip) {
                    borders[border].fill_with(&mut next);
                }
            }
        }
        for level in self.unarmed.iter_mut().flat_map(|unarmed| &mut unarmed.levels) {
            level.fill_with(&mut next);
        }
        self.ready.fill_with(&mut next);
        for chip in self.reached() {
            for (index, cell) in self.grid.cells.iter().enumerate() {
                let rate = rates_of(&self.history.of_chip(chip)[index], cell.width);
                self.dead.put(chip, index, rate);
            }
        }
    }
}

/// Rates at which states lead on, and their slopes.
#[inline(always)]
fn pass<const M: usize>(step: &CellStep<M>, borders: &[State<M>; 4]) -> [State<M>; 4] {
    let [start, end, start_slope, end_slope] = borders;
    [
        step.pass_forwards(start),
        step.pass_forwards(end),
        step.pass_forwards(start_slope),
        step.pass_forwards(end_slope),
    ]
}

/// The cubic of a cell's detection rate.
#[inline(always)]
fn rates_of<const M: usize>(passing: &[State<M>; 4], width: f64) -> [f64; 4] {
    let mut rate = [0.0; 4];
    for of in 0..4 {
        for m in 0..M {
            rate[of] += passing[of][m];
        }
    }
    rate[2] *= width;
    rate[3] *= width;
    rate
}

/// Ready states at a cell's start, middle and end, less those that wait.
#[inline(always)]
fn armed<const M: usize>(
    ready: &[State<M>; 4],
    waiting: &[State<M>; 4],
    width: f64,
) -> [State<M>; 3] {
    let mut borders = [[0.0; M]; 4];
    for of in 0..4 {
        for m in 0..M {
            borders[of][m] = ready[of][m] - waiting[of][m];
        }
    }
    let [start, end, start_slope, end_slope] = borders;
    let eighth = width / 8.0;
    let mut middle = [0.0; M];
    for m in 0..M {
        middle[m] = 0.5 * (start[m] + end[m]) + eighth * (start_slope[m] - end_slope[m]);
    }
    [start, middle, end]
}
