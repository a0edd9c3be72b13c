//! Where integration steps end: the same places in every chip.

use std::f64::consts::PI;
use std::sync::Arc;

use super::domain::{FINEST_CELL_CHIPS, MeanResponseError, check};
use super::light::Light;
use super::sampling::DetectionSampling;
use super::steady::Round;
use crate::code::Code;
use crate::photons::DetectorModel;

/// Rate x dead time up to which 10^5 dead times are enough to forget a start:
/// what is left of it is exp(-10^5 2 pi^2 / 256^2), below 10^-12.
const LARGEST_SATURATION: f64 = 256.0;

/// The longest common code period that is solved.
const LONGEST_PERIOD_CHIPS: u64 = 1 << 18;
/// A detector must forget within so many chips: some seconds of solving.
const LONGEST_MEMORY_CHIPS: u64 = 1 << 22;

/// Cells of integration. The time frame is that of avalanches, with the first
/// path's edges at whole chips: only differences of delays matter here.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Common period of all codes and the reference, in chips.
    pub period_chips: usize,
    /// Cells of one chip.
    pub cells: Vec<GridCell>,
    /// Their edges, 0 and 1 included.
    pub edges: Vec<f64>,
    /// Dead time.
    pub dead_time_chips: f64,
    /// Chips that one dead time reaches into, backwards or forwards.
    pub reach_chips: usize,
    /// Chips that make the detector forget how it started.
    pub memory_chips: usize,
    /// Primary detections in a dead time of the brightest light.
    pub saturation: f64,
    /// For pulses that may merge.
    pub rearming: Option<Rearming>,
    paths: Vec<GridPath>,
    /// For each delay at which light turns on or off, whether a code that is so late changes before
    /// each cell.
    changed: Vec<Vec<bool>>,
    constant_per_chip: f64,
    /// What crosstalk adds to the rate, cell by cell of the period; empty without any.
    pub heard_per_chip: Vec<f64>,
}

/// Where sample instants are, for pulses that may merge.
#[derive(Debug, Clone)]
pub struct Rearming {
    /// For each cell of a chip: sample instants that a detector which becomes ready
    /// there has to wait for until its next pulse counts.
    pub waits: Vec<usize>,
    /// For each cell, whether it starts at a sample instant.
    pub at_instant: Vec<bool>,
}

/// Where an edge of the light leaves kinks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kinks {
    /// Whole dead times later: in the detector's state.
    Later,
    /// Also whole dead times earlier: in the value of being in a state.
    LaterAndEarlier,
}

/// One step of integration.
#[derive(Debug, Clone)]
pub struct GridCell {
    pub width: f64,
    /// Places one dead time before the start, middle and end.
    pub before: [GridInterpolation; 3],
    /// Places one dead time after the start, middle and end.
    pub after: [GridInterpolation; 3],
    /// Whether the place after the end is a border of cells, and the one after the next cell's start the
    /// same: what is continuous there need not be looked up twice.
    pub after_joins: bool,
}

/// A place in another cell.
#[derive(Debug, Clone, Copy)]
pub struct GridInterpolation {
    /// Chips away.
    pub chips: i64,
    /// Cell in that chip.
    pub cell: usize,
    /// Weights of the value at the cell's start and end, and of the slope there.
    pub weights: [f64; 4],
    /// Whether it is the cell's start, 0, or its end, 1: nothing else has a weight there.
    pub border: Option<usize>,
}

#[derive(Debug, Clone)]
struct GridPath {
    rate_per_chip: f64,
    code: Arc<Code>,
    /// The code that keys it, late by a delay.
    keyed: Late,
    /// The same code, late by another delay, and the chip that lets the light through.
    gate: Option<(Late, u8)>,
}

/// A code that is late by some delay.
#[derive(Debug, Clone, Copy)]
struct Late {
    /// Number of the delay.
    delay: usize,
    /// Code chip at the start of frame chip 0.
    offset: i64,
}

/// The light of all paths, without edges, and every delay at which it turns on or off.
struct Strands {
    delays: Vec<f64>,
    paths: Vec<GridPath>,
}

impl Strands {
    fn new(light: &Light) -> Strands {
        let frame = frame_chips(light);
        let mut strands = Strands { delays: Vec::new(), paths: Vec::new() };
        for path in &light.paths {
            let delay_chips = path.delay_chips - frame;
            for strand in &path.shape.strands {
                let keyed = strands.late_by(delay_chips + strand.delay_chips);
                let gate = strand.gate.map(|gate| {
                    let late = strands.late_by(delay_chips + gate.delay_chips);
                    (late, gate.open_at)
                });
                strands.paths.push(GridPath {
                    rate_per_chip: path.rate_per_chip * strand.share,
                    code: Arc::clone(&path.code),
                    keyed,
                    gate,
                });
            }
        }
        strands
    }

    fn late_by(&mut self, delay: f64) -> Late {
        let known = self.delays.iter().position(|known| *known == delay);
        let number = known.unwrap_or_else(|| {
            self.delays.push(delay);
            self.delays.len() - 1
        });
        Late { delay: number, offset: (-delay).floor() as i64 }
    }
}

impl GridPath {
    /// Rates in a frame chip before and after each of its changes: before and after the
    /// code's, by before and after the gate's.
    fn rates(&self, chip: i64) -> [[f64; 2]; 2] {
        let chips = &self.code.chips;
        let at = |late: Late, later: i64| {
            chips[(chip + late.offset + later).rem_euclid(chips.len() as i64) as usize]
        };
        [0, 1].map(|later| {
            let lit = self.rate_per_chip * f64::from(at(self.keyed, later));
            match self.gate {
                None => [lit; 2],
                Some((gate, open_at)) => {
                    [0, 1].map(|later| if at(gate, later) == open_at { lit } else { 0.0 })
                }
            }
        })
    }
}

impl Grid {
    /// The grid of a detector in some light.
    ///
    /// # Errors
    /// As for the mean response.
    pub fn new(
        model: &DetectorModel,
        light: &Light,
        kinks: Kinks,
        samples: &SampleInstants,
    ) -> Result<Grid, MeanResponseError> {
        let grid = Grid::of_any_memory(model, light, kinks, samples)?;
        let chips = model.memory_under(light.brightest_per_chip()).solved_start_chips();
        if chips > LONGEST_MEMORY_CHIPS as f64 {
            return Err(MeanResponseError::MemoryTooLong { chips, limit: LONGEST_MEMORY_CHIPS });
        }
        Ok(grid)
    }

    /// The same, however long the detector remembers.
    ///
    /// # Errors
    /// As there.
    pub fn of_any_memory(
        model: &DetectorModel,
        light: &Light,
        kinks: Kinks,
        samples: &SampleInstants,
    ) -> Result<Grid, MeanResponseError> {
        check(model)?;
        check_brightness(model, light.brightest_per_chip())?;
        let memory = model.memory_under(light.brightest_per_chip());
        let period_chips = common_period(model, light)? as usize;
        let Strands { delays, paths } = Strands::new(light);
        let edges = edges(model, light, &delays, kinks, samples);
        let dead_time = model.dead_time_chips;
        let mut cells: Vec<GridCell> = edges
            .windows(2)
            .map(|edge| {
                let (start, width) = (edge[0], edge[1] - edge[0]);
                let place = |offset: f64| {
                    [0.0, 0.5, 1.0].map(|x: f64| {
                        // Looked up just inside the cell: at an edge of the
                        // light the rate has two values, and this cell's is meant.
                        let inside = x.clamp(1e-6, 1.0 - 1e-6);
                        let time = start + x * width + offset;
                        GridInterpolation::new(&edges, start + inside * width + offset, time)
                    })
                };
                GridCell {
                    width,
                    before: place(-dead_time),
                    after: place(dead_time),
                    after_joins: false,
                }
            })
            .collect();
        for index in 0..cells.len() {
            let next = (index + 1) % cells.len();
            let turns = i64::from(next == 0);
            let start = cells[next].after[0].of_later_chip(turns);
            cells[index].after_joins = cells[index].after[2].ends_at(&start, edges.len() - 1);
        }
        let changed = |delay: &f64| {
            let middles = edges.windows(2).map(|edge| edge[0] + 0.5 * (edge[1] - edge[0]));
            middles.map(|middle| (middle - delay).floor() > (-delay).floor()).collect()
        };
        Ok(Grid {
            period_chips,
            changed: delays.iter().map(changed).collect(),
            rearming: samples.rearming(&edges),
            cells,
            edges,
            dead_time_chips: dead_time,
            reach_chips: dead_time.ceil() as usize + 1,
            memory_chips: memory.solved_start_chips().ceil() as usize + 1,
            saturation: memory.saturation(),
            paths,
            constant_per_chip: light.constant_per_chip,
            heard_per_chip: Vec::new(),
        })
    }

    /// How its steady state is extrapolated; none if it is waited for.
    pub fn round(&self) -> Option<Round> {
        // The phase's mode k fades as exp(-2 pi^2 k^2 n / (1 + saturation)^2) in n dead times.
        let turns = (1.0 + self.saturation) / PI;
        let fading_chips = 0.5 * 7.0 * turns * turns * self.dead_time_chips;
        Round::new(fading_chips, self.reach_chips + 2, self.period_chips, self.memory_chips)
    }

    /// Chips that are solved, about, until the detector has forgotten how it started.
    pub fn settling_chips(&self) -> usize {
        let expected = self.round().map(|round| round.expected_chips());
        expected.map_or(self.memory_chips, |chips| chips.min(self.memory_chips))
    }

    /// Whether all chips have the same light.
    pub fn is_even(&self) -> bool {
        self.paths.is_empty() && self.heard_per_chip.is_empty()
    }

    /// Primary rate in every cell of a chip, per chip.
    pub fn fill_rates(&self, chip: i64, rates: &mut Vec<f64>) {
        rates.clear();
        rates.resize(self.cells.len(), self.constant_per_chip);
        for path in &self.paths {
            let of_chip = path.rates(chip);
            let gate = path.gate.map_or(path.keyed, |(gate, _)| gate);
            let changed = self.changed[path.keyed.delay].iter().zip(&self.changed[gate.delay]);
            for (rate, (&keyed, &gated)) in rates.iter_mut().zip(changed) {
                *rate += of_chip[usize::from(keyed)][usize::from(gated)];
            }
        }
        if !self.heard_per_chip.is_empty() {
            let chip = chip.rem_euclid(self.period_chips as i64) as usize;
            let heard = &self.heard_per_chip[chip * self.cells.len()..];
            rates.iter_mut().zip(heard).for_each(|(rate, heard)| *rate += heard);
        }
    }

    /// Chip, cell and position 0..1 inside the cell of a time in chips.
    pub fn locate(&self, time: f64) -> (i64, usize, f64) {
        let (chip, cell) = locate(&self.edges, time);
        let inside = time - chip as f64 - self.edges[cell];
        (chip, cell, inside / self.cells[cell].width)
    }
}

impl GridInterpolation {
    /// The place of `time` in the cell that holds `inside`.
    fn new(edges: &[f64], inside: f64, time: f64) -> GridInterpolation {
        let (chips, cell) = locate(edges, inside);
        let width = edges[cell + 1] - edges[cell];
        let x = (time - chips as f64 - edges[cell]) / width;
        // The cubic that fits values and slopes.
        let end = x * x * (3.0 - 2.0 * x);
        let start_slope = x * (1.0 - x) * (1.0 - x) * width;
        let end_slope = x * x * (x - 1.0) * width;
        let border = [0.0, 1.0].into_iter().position(|border| x == border);
        GridInterpolation { chips, cell, weights: [1.0 - end, end, start_slope, end_slope], border }
    }

    /// The same place of a chip that comes so many later.
    fn of_later_chip(self, chips: i64) -> GridInterpolation {
        GridInterpolation { chips: self.chips + chips, ..self }
    }

    /// Whether it is the end of a cell, of `cells` in a chip, and `start` the start of the next.
    fn ends_at(&self, start: &GridInterpolation, cells: usize) -> bool {
        let next = match self.cell + 1 == cells {
            true => (self.chips + 1, 0),
            false => (self.chips, self.cell + 1),
        };
        (self.border, start.border) == (Some(1), Some(0)) && (start.chips, start.cell) == next
    }
}

/// Sample instants in the grid's frame.
#[derive(Debug, Clone)]
pub struct SampleInstants {
    /// Registered time of the frame's origin, in chips.
    pub origin_chips: f64,
    /// What the samples show; none for a counter in continuous time.
    pub sampling: Option<DetectionSampling>,
}

impl SampleInstants {
    /// Where counting changes within a chip, 0..1; and where that leaves the value of
    /// being in a state with a step or a kink.
    fn breaks(&self, kinks: Kinks, dead_time_chips: f64) -> Vec<f64> {
        let back: &[f64] = match kinks {
            Kinks::Later => &[0.0],
            Kinks::LaterAndEarlier => &[0.0, 1.0, 2.0],
        };
        let registered = self.sampling.as_ref().map_or(Vec::new(), DetectionSampling::breaks);
        registered
            .into_iter()
            .flat_map(|time| back.iter().map(move |dead| time - dead * dead_time_chips))
            .map(|time| time - self.origin_chips)
            .map(|time| time - time.floor())
            .collect()
    }

    fn rearming(&self, edges: &[f64]) -> Option<Rearming> {
        let sampling = self.sampling.as_ref().filter(|sampling| sampling.merges())?;
        let waits = edges
            .windows(2)
            .map(|cell| sampling.waits(0.5 * (cell[0] + cell[1]) + self.origin_chips));
        // Each instant is at one edge, the nearest: another kink's may be hardly farther from it than
        // breaks that are merged.
        let mut at_instant = vec![false; edges.len() - 1];
        for instant in sampling.instants() {
            let time = (instant - self.origin_chips).rem_euclid(1.0);
            let after = edges.partition_point(|&edge| edge < time).clamp(1, edges.len() - 1);
            let is_after = edges[after] - time < time - edges[after - 1];
            let nearest = if is_after { after } else { after - 1 };
            at_instant[nearest % (edges.len() - 1)] = true;
        }
        Some(Rearming { waits: waits.collect(), at_instant })
    }
}

impl Rearming {
    /// The largest number of instants to wait for.
    pub fn most_waits(&self) -> usize {
        self.waits.iter().copied().max().unwrap_or(0)
    }
}

/// The time of flight that the frame's whole chips stand for.
pub fn frame_chips(light: &Light) -> f64 {
    light.paths.first().map_or(0.0, |path| path.delay_chips)
}

fn locate(edges: &[f64], time: f64) -> (i64, usize) {
    let chip = time.floor();
    let cell = edges.partition_point(|&edge| edge <= time - chip) - 1;
    (chip as i64, cell.min(edges.len() - 2))
}

fn common_period(model: &DetectorModel, light: &Light) -> Result<u64, MeanResponseError> {
    let mut period = model.reference.len();
    let heard = model.crosstalk.iter().flat_map(|coupled| coupled.heard());
    let heard: Vec<u64> = heard
        .flat_map(|(_, other)| Light::of(other).paths.into_iter().map(|path| path.code.len()))
        .collect();
    for length in light.paths.iter().map(|path| path.code.len()).chain(heard) {
        period = period / gcd(period, length) * length;
        if period > LONGEST_PERIOD_CHIPS {
            return Err(MeanResponseError::PeriodTooLong {
                chips: period,
                limit: LONGEST_PERIOD_CHIPS,
            });
        }
    }
    Ok(period)
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Refuses light so bright that the finest cells are longer than the wait for a
/// photon, or that the detector does not forget its start.
fn check_brightness(
    model: &DetectorModel,
    brightest_per_chip: f64,
) -> Result<(), MeanResponseError> {
    if model.dead_time_chips <= 0.0 {
        return Ok(());
    }
    let limit_per_chip = (LARGEST_SATURATION / model.dead_time_chips).min(1.0 / FINEST_CELL_CHIPS);
    if brightest_per_chip <= limit_per_chip {
        return Ok(());
    }
    Err(MeanResponseError::TooBright {
        rate_cps: model.timing.clock.hz(brightest_per_chip),
        limit_cps: model.timing.clock.hz(limit_per_chip),
    })
}

/// Edges of the cells of one chip, 0 and 1 included: every edge of light, and
/// the kinks that those edges leave up to three dead times away; then divided
/// until the cells are short enough.
fn edges(
    model: &DetectorModel,
    light: &Light,
    delays: &[f64],
    kinks: Kinks,
    samples: &SampleInstants,
) -> Vec<f64> {
    let mut breaks = vec![0.0, 1.0];
    breaks.extend(samples.breaks(kinks, model.dead_time_chips));
    let first = match kinks {
        Kinks::Later => 0,
        Kinks::LaterAndEarlier => -3,
    };
    for delay in delays {
        for kink in first..=3 {
            let time = delay + f64::from(kink) * model.dead_time_chips;
            breaks.push(time - time.floor());
        }
    }
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|later, earlier| *later - *earlier < 1e-7);

    let widest = widest_cell(model, light);
    let mut edges = vec![0.0];
    for gap in breaks.windows(2) {
        let parts = ((gap[1] - gap[0]) / widest - 1e-9).ceil().max(1.0);
        for part in 1..=parts as u32 {
            edges.push(gap[0] + (gap[1] - gap[0]) * f64::from(part) / parts);
        }
    }
    // Breaks within the tolerance of 1 were merged into it.
    if let Some(last) = edges.last_mut() {
        *last = 1.0;
    }
    edges
}

fn widest_cell(model: &DetectorModel, light: &Light) -> f64 {
    let brightest = light.brightest_per_chip();
    let mut widest: f64 = 0.125;
    if brightest > 0.0 {
        widest = widest.min(0.125 / brightest);
    }
    if let Some(afterpulsing) = model.afterpulsing {
        widest = widest.min(0.25 * afterpulsing.time_constant_chips);
    }
    widest = widest.max(FINEST_CELL_CHIPS);
    if model.dead_time_chips > 0.0 {
        widest = widest.min(model.dead_time_chips);
    }
    widest
}
