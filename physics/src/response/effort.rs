//! How long a mean response and its moments take, before they are worked out.
//!
//! Every stage is some operations for each cell of the grid, each phase step, or
//! each pair of unknowns. What one operation takes was measured on one core of a
//! server of 2023; the sums are good to a factor of two or so, on purpose the same
//! everywhere, so that what is refused does not depend on the machine.

use super::MeanResponseError;
use super::chain::states_needed;
use super::grid::{Grid, Kinks, SampleInstants, frame_chips};
use super::heard;
use super::light::Light;
use super::moments::{ENDS, reach_across_ends};
use super::sampling::DetectionSampling;
use super::tier::CountingTier;
use crate::photons::DetectorModel;
use crate::photons::tail::Tail;

/// One cell of the state equation, forwards, beside its states.
const FORWARDS_S: f64 = 25e-9;
/// The same backwards, for second moments.
const BACKWARDS_S: f64 = 40e-9;
/// A product of matrix and vector of states, per element, forwards.
const STATE_S: f64 = 0.4e-9;
/// A brightness that is compared, on the way to a cell's own.
const BRIGHTNESS_S: f64 = 1e-9;
/// What a cell does at one brightness, per state.
const CELL_STEP_S: f64 = 150e-9;
/// One term of a column of the correlator, per chip.
const TERM_S: f64 = 1.6e-9;
/// One node of a quadrature through jitter, and a term that it is compared with.
const NODE_S: f64 = 30e-9;
const NODE_TERM_S: f64 = 0.4e-9;
/// One product of reference and hits.
const PRODUCT_S: f64 = 0.5e-9;
/// One point of a Fourier transform there and back, per binary digit of its length.
const FFT_S: f64 = 12e-9;
/// From this many steps on, mean counts are had by Fourier transform.
const STEPS_FOR_FFT: f64 = 200.0;
/// One cell's part in the covariance of two steps' counts.
const PAIR_S: f64 = 1.5e-9;
/// A term or a node of a column.
const COLUMN_BYTES: f64 = 64.0;
/// Jitter is followed to so many standard deviations on either side.
const JITTER_REACH: f64 = 6.0;

/// Seconds on one core.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effort {
    /// One mean response.
    pub response_s: f64,
    /// The same of all light later or earlier.
    pub delayed_s: f64,
    /// Mean counts of every step of a scan from it.
    pub counts_s: f64,
    /// Mean counts of one step.
    pub count_s: f64,
    /// What second moments follow from.
    pub moments_s: f64,
    /// Second moments of one step.
    pub step_s: f64,
    /// Covariance of two steps that count the same light.
    pub pair_s: f64,
    /// Second moments of every step.
    pub scan_s: f64,
    /// Bytes held by all of that.
    pub bytes: f64,
}

/// Sizes of a solution.
struct Size {
    /// How long the detector remembers, and what of it is solved.
    memory_chips: usize,
    settling_chips: usize,
    /// Chips that are solved: those, and the period.
    chips: f64,
    period: f64,
    cells: f64,
    reach: f64,
    states: f64,
    paths: f64,
    /// Brightnesses of one cell.
    brightnesses: f64,
}

impl Effort {
    /// What `light` takes for a detector.
    ///
    /// # Errors
    /// As for the mean response itself.
    pub fn of(model: &DetectorModel, light: &Light) -> Result<Effort, MeanResponseError> {
        let forwards = Size::of(model, light, Kinks::Later)?;
        let both = Size::of(model, light, Kinks::LaterAndEarlier)?;
        let steps = model.timing.scan.steps as f64;
        let period = forwards.period;
        let rest = (model.timing.scan.integration_chips % forwards.period as u64) as f64;
        let partial_s = rest.min(period - rest) * PRODUCT_S;
        let count_s = period * PRODUCT_S + partial_s;
        let samples = f64::from(model.timing.clock.samples_per_chip);
        let counts_s = if steps < STEPS_FOR_FFT {
            steps * count_s
        } else {
            samples * period * period.log2().max(1.0) * FFT_S + steps * partial_s
        };
        let solution_s = both.backwards_s(both.chips);
        let brightest = light.brightest_per_chip();
        let across_s = reach_across_ends(model, brightest, both.memory_chips)
            .map_or(0.0, |reach| {
                both.backwards_s((reach.before + reach.after.min(both.settling_chips)) as f64)
            });
        let ends = steps.min(ENDS as f64);
        let step_s = solution_s + across_s;
        let mut heard_s = 0.0;
        for (_, other) in model.crosstalk.iter().flat_map(|coupled| coupled.heard()) {
            heard_s += Size::of(other, &Light::of(other), Kinks::Later)?.forwards_s();
        }
        let delayed_s = correlator_s(model, &forwards);
        Ok(Effort {
            response_s: forwards.forwards_s() + heard_s + delayed_s,
            delayed_s: delayed_s + if heard_s > 0.0 { forwards.forwards_s() } else { 0.0 },
            counts_s,
            count_s,
            moments_s: both.forwards_s() + solution_s + ends * across_s,
            step_s,
            pair_s: both.cells * both.period * PAIR_S,
            scan_s: scan_s(model, light, &both, [step_s, solution_s]),
            bytes: both.bytes() + correlator_bytes(model, &forwards),
        })
    }
}

impl Size {
    fn of(model: &DetectorModel, light: &Light, kinks: Kinks) -> Result<Size, MeanResponseError> {
        // At most: a counter in continuous time needs no sample instants.
        let samples = SampleInstants {
            origin_chips: frame_chips(light) + model.delay_chips,
            sampling: DetectionSampling::of(model, light, CountingTier::Sampled)
                .unwrap_or_default(),
        };
        let grid = Grid::new(model, light, kinks, &samples)?;
        let states = match states_needed(model.afterpulsing, model.dead_time_chips) {
            0..=1 => 1.0,
            2..=4 => 4.0,
            5..=8 => 8.0,
            _ => 16.0,
        };
        let settling_chips = grid.settling_chips();
        let chips = (grid.period_chips + settling_chips) as f64;
        let paths = light.paths.len() as f64;
        let hears = model.crosstalk.as_ref().is_some_and(|all| all.heard().next().is_some());
        let heard = if hears { heard::LEVELS } else { 1.0 };
        Ok(Size {
            memory_chips: grid.memory_chips,
            settling_chips,
            chips,
            period: grid.period_chips as f64,
            cells: grid.cells.len() as f64,
            reach: grid.reach_chips as f64,
            states,
            paths,
            brightnesses: (heard * 2_f64.powf(paths.min(40.0))).min(chips),
        })
    }

    fn forwards_s(&self) -> f64 {
        self.solution_s(self.chips, FORWARDS_S + STATE_S * self.states * self.states)
    }

    fn backwards_s(&self, chips: f64) -> f64 {
        self.solution_s(chips, BACKWARDS_S + 3.0 * STATE_S * self.states * self.states)
    }

    fn solution_s(&self, chips: f64, cell_s: f64) -> f64 {
        let look_up_s = 0.5 * self.brightnesses * BRIGHTNESS_S + self.paths * PRODUCT_S;
        let steps_s = self.brightnesses * self.states * CELL_STEP_S;
        self.cells * (chips * (cell_s + look_up_s) + steps_s)
    }

    fn bytes(&self) -> f64 {
        let states = self.states;
        let history = 2.0 * (self.reach + 2.0) * 4.0 * states;
        let cell_steps = self.brightnesses * (1.0 + 5.0 * states + 2.0 * states * states);
        let solution = self.period * (4.0 + 3.0 * states + 8.0);
        8.0 * self.cells * (history + cell_steps + solution)
    }
}

/// What a column of the correlator has: cells that it reaches, and nodes of quadrature.
fn column_size(model: &DetectorModel, size: &Size) -> [f64; 2] {
    let sigma = model.jitter_chips.unwrap_or(0.0);
    let tail_chips = model.tail.as_ref().map_or(0.0, Tail::longest_chips);
    let delays = match &model.tail {
        Some(Tail::Delays(delays)) => delays.len() as f64,
        Some(Tail::Exponential { .. }) | None => 1.0,
    };
    let sides = if model.counter.transition_ps > 0.0 { 2.0 } else { 1.0 };
    let gaussian = 1.0 + 2.0 * JITTER_REACH * sigma * size.cells;
    let terms = sides * (gaussian + tail_chips * size.cells);
    let nodes = 8.0 * (sides * (delays - 1.0) * gaussian + terms);
    [terms, if sigma + tail_chips > 0.0 { nodes } else { terms }]
}

/// The correlator's columns, one for each edge of a sample.
fn correlator_s(model: &DetectorModel, size: &Size) -> f64 {
    let [terms, nodes] = column_size(model, size);
    let column_s = nodes * (NODE_S + 0.5 * terms * NODE_TERM_S) + terms * size.period * TERM_S;
    let edges =
        if model.counter.rising_delay_ps == model.counter.falling_delay_ps { 1.0 } else { 2.0 };
    (edges * f64::from(model.timing.clock.samples_per_chip) + 1.0) * column_s
}

/// Bytes of a column at a time.
fn correlator_bytes(model: &DetectorModel, size: &Size) -> f64 {
    let [terms, nodes] = column_size(model, size);
    COLUMN_BYTES * (terms + nodes)
}

/// Second moments of all steps: combs of slots, or one step after another.
fn scan_s(
    model: &DetectorModel,
    light: &Light,
    size: &Size,
    [step_s, solution_s]: [f64; 2],
) -> f64 {
    let memory = model.memory_under(light.brightest_per_chip()).of_pairs_chips() as f64;
    let phases = f64::from(model.timing.clock.samples_per_chip.min(8));
    let steps = model.timing.scan.steps as f64;
    if steps <= memory * phases || size.period < 2.0 * memory {
        return steps * step_s;
    }
    let combs = (size.period / (size.period / memory).floor()).ceil();
    let transforms_s = memory * size.period * size.period.log2() * FFT_S;
    phases * (combs * solution_s + transforms_s)
}
