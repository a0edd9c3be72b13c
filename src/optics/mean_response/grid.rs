//! Where integration steps end: the same places in every chip.

use super::MeanResponseError;
use crate::optics::DetectorModel;

/// The finest step of integration, as a share of a chip.
const FINEST_CELL_CHIPS: f64 = 1.0 / 128.0;

/// The longest common code period that is solved.
const LONGEST_PERIOD_CHIPS: u64 = 1 << 16;

/// Cells of integration. The time frame is that of registered times, so that
/// samples are taken at multiples of 1 / S.
#[derive(Debug, Clone)]
pub struct Grid {
    /// Common period of all codes at the detector, in chips.
    pub period_chips: u64,
    /// Cells of one chip.
    pub cells: Vec<GridCell>,
    /// Chips that one dead time reaches into, backwards or forwards.
    pub reach_chips: usize,
    /// Chips that make the detector forget how it started.
    pub memory_chips: u64,
    paths: Vec<GridPath>,
    constant_per_chip: f64,
}

/// One step of integration.
#[derive(Debug, Clone)]
pub struct GridCell {
    pub width: f64,
    /// Sample that sees this cell's detections, 1..=S from the chip's start.
    pub sample: u64,
    /// Places one dead time before the start, middle and end.
    pub before: [Place; 3],
    /// Places one dead time after the start, middle and end.
    pub after: [Place; 3],
    /// For each path, code chip that lights the cell, minus chip number.
    code_offsets: Vec<i64>,
}

/// A place in another cell.
#[derive(Debug, Clone, Copy)]
pub struct Place {
    /// Chips away.
    pub chips: i64,
    /// Cell in that chip.
    pub cell: usize,
    /// Position in that cell, 0..=1.
    pub position: f64,
}

#[derive(Debug, Clone)]
struct GridPath {
    rate_per_chip: f64,
    chips: Vec<u8>,
}

impl Grid {
    pub fn new(model: &DetectorModel) -> Result<Grid, MeanResponseError> {
        check(model)?;
        let period_chips = common_period(model)?;
        let edges = edges(model);
        let dead_time = model.dead_time_chips;
        let cells = edges
            .windows(2)
            .map(|edge| {
                let (start, width) = (edge[0], edge[1] - edge[0]);
                let nodes = [0.0, 0.5, 1.0];
                let place = |offset: f64| {
                    // Looked up just inside the cell: at an edge of the light
                    // the rate has two values, and this cell's is meant.
                    nodes.map(|x: f64| {
                        let inside = x.clamp(1e-6, 1.0 - 1e-6);
                        locate(&edges, start + inside * width + offset)
                            .at(&edges, start + x * width + offset)
                    })
                };
                let middle = start + 0.5 * width;
                GridCell {
                    width,
                    sample: (middle * f64::from(model.samples_per_chip)) as u64 + 1,
                    before: place(-dead_time),
                    after: place(dead_time),
                    code_offsets: model
                        .excess
                        .iter()
                        .map(|light| (middle - light.delay() - model.delay_chips).floor() as i64)
                        .collect(),
                }
            })
            .collect();
        Ok(Grid {
            period_chips,
            cells,
            reach_chips: dead_time.ceil() as usize + 1,
            memory_chips: model.warm_up_chips as u64,
            paths: model
                .excess
                .iter()
                .map(|light| GridPath {
                    rate_per_chip: light.rate_per_chip,
                    chips: light.code.chips.clone(),
                })
                .collect(),
            constant_per_chip: model.constant_per_chip,
        })
    }

    /// Primary rate in a cell of a chip, per chip.
    pub fn lambda(&self, chip: i64, cell: usize) -> f64 {
        let offsets = &self.cells[cell].code_offsets;
        self.constant_per_chip
            + self
                .paths
                .iter()
                .zip(offsets)
                .map(|(path, offset)| {
                    let position = (chip + offset).rem_euclid(path.chips.len() as i64);
                    path.rate_per_chip * f64::from(path.chips[position as usize])
                })
                .sum::<f64>()
    }
}

impl Place {
    /// The same cell, with the position of `time`.
    fn at(self, edges: &[f64], time: f64) -> Place {
        let start = edges[self.cell];
        let width = edges[self.cell + 1] - start;
        Place {
            position: (time - self.chips as f64 - start) / width,
            ..self
        }
    }
}

fn locate(edges: &[f64], time: f64) -> Place {
    let chip = time.floor();
    let cell = edges.partition_point(|&edge| edge <= time - chip) - 1;
    Place {
        chips: chip as i64,
        cell: cell.min(edges.len() - 2),
        position: 0.0,
    }
}

fn check(model: &DetectorModel) -> Result<(), MeanResponseError> {
    let ps = |chips: f64| chips * model.chip_period_ps;
    if let Some(afterpulsing) = model.afterpulsing
        && afterpulsing.time_constant_chips < 2.0 * FINEST_CELL_CHIPS
    {
        return Err(MeanResponseError::TimeConstantTooShort {
            time_constant_ps: ps(afterpulsing.time_constant_chips),
            least_ps: ps(2.0 * FINEST_CELL_CHIPS),
        });
    }
    let dead_time_needed = model.dead_time_chips > 0.0 || model.afterpulsing.is_some();
    if dead_time_needed && model.dead_time_chips < FINEST_CELL_CHIPS {
        return Err(MeanResponseError::DeadTimeTooShort {
            dead_time_ps: ps(model.dead_time_chips),
            least_ps: ps(FINEST_CELL_CHIPS),
        });
    }
    Ok(())
}

fn common_period(model: &DetectorModel) -> Result<u64, MeanResponseError> {
    let mut period = model.reference.len();
    for light in &model.excess {
        let length = light.code.len();
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

/// Edges of the cells of one chip, 0 and 1 included: every sample, every edge
/// of light, and the kinks that those edges leave one, two and three dead times
/// later; then halved until the cells are short enough.
fn edges(model: &DetectorModel) -> Vec<f64> {
    let samples_per_chip = f64::from(model.samples_per_chip);
    let mut breaks: Vec<f64> = (0..=model.samples_per_chip)
        .map(|sample| f64::from(sample) / samples_per_chip)
        .collect();
    for light in &model.excess {
        for kink in 0..4 {
            let time = light.delay() + model.delay_chips + f64::from(kink) * model.dead_time_chips;
            breaks.push(time - time.floor());
        }
    }
    breaks.sort_by(f64::total_cmp);
    breaks.dedup_by(|later, earlier| *later - *earlier < 1e-7);

    let widest = widest_cell(model);
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

fn widest_cell(model: &DetectorModel) -> f64 {
    let brightest = model.constant_per_chip
        + model
            .excess
            .iter()
            .map(|light| light.rate_per_chip)
            .sum::<f64>();
    let mut widest = (1.0 / f64::from(model.samples_per_chip)).min(0.125);
    if brightest > 0.0 {
        widest = widest.min(0.25 / brightest);
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
