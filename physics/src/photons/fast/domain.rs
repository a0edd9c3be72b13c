//! For which models the lanes are exact, and their tables.

use super::excess::OnTime;
use super::grid::{Grid, LONGEST_PERIOD_CHIPS};
use super::normal::NORMAL_REACH;
use super::sign::{EdgeTiming, SignTable};
use crate::photons::DetectorModel;
use crate::scene::PathIndex;

/// Why a model is left to the plain loop.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OutsideDomain {
    /// The tables are for delays that stay.
    #[error("path {path} of the scene moves; the lanes take paths that stand still")]
    MovingPath {
        /// Its index.
        path: PathIndex,
    },
    /// The tables are for light that turns on and off alike.
    #[error("a laser's rise and fall times differ; the lanes take edges that are alike")]
    UnlikeEdges,
    /// Lanes pass over what comes within a dead time.
    #[error("recharge is passive; the lanes take a dead time that nothing begins anew")]
    PassiveRecharge,
    /// One number decides a Gaussian jitter and no other.
    #[error("the jitter has a tail; the lanes take jitter that is Gaussian")]
    Tail,
    /// The codes repeat together too late for the tables.
    #[error("the codes repeat together after more than {limit} chips")]
    PeriodTooLong {
        /// The longest period of the tables.
        limit: u64,
    },
    /// A dead time must end within a period.
    #[error("the dead time is {dead_time_chips} chips; the lanes take less than {limit_chips}")]
    DeadTimeTooLong {
        /// The model's dead time.
        dead_time_chips: f64,
        /// Period of the tables.
        limit_chips: u32,
    },
    /// A process is so quick that whole ticks would show.
    #[error(
        "the detector fires {time_constant_chips} chips after it gets ready; \
         the lanes take at least {least_chips}"
    )]
    TooQuick {
        /// Mean wait for any light, or afterpulsing time constant, or dead time.
        time_constant_chips: f64,
        /// The shortest that is exact.
        least_chips: f64,
    },
    /// Light so rare that the lanes would mostly wait.
    #[error(
        "{}; the lanes pay off up to one photon in {most_chips} chips, beyond which one photon \
         after another is quicker", frequency(*.mean_wait_chips)
    )]
    TooRare {
        /// Mean wait for any light; infinite in the dark.
        mean_wait_chips: f64,
        /// The longest for which lanes pay.
        most_chips: f64,
    },
    /// Jitter, transition and edge delays reach beyond one chip.
    #[error("jitter, transition and edge delays together reach from one edge to the next")]
    EdgesTooWide,
    /// Steps of one group share a detection's jitter, and each lane of theirs
    /// decides by the same number: that is exact while no detection is near edges
    /// of two steps.
    #[error(
        "with {parallel} phase steps at once, jitter, transition and edge delays together reach \
         from one step's edge to the next one's"
    )]
    StepsTooClose {
        /// Steps of a group.
        parallel: u32,
    },
}

fn frequency(mean_wait_chips: f64) -> String {
    if mean_wait_chips.is_finite() {
        format!("a photon comes once in {mean_wait_chips:.3e} chips")
    } else {
        "no photon ever comes".to_owned()
    }
}

/// With so many ticks in a time constant, rounding a wait to ticks adds 10^-7
/// to its variance, and nothing to its mean.
const LEAST_TIME_CONSTANT_TICKS: f64 = 1000.0;

/// Waits are cut at a period, at the cost of an iteration each; a photon of the
/// plain loop costs about ten.
const MOST_PERIODS_PER_PHOTON: f64 = 10.0;

/// Every table of a model, shared by all lanes and threads.
#[derive(Debug, Clone)]
pub struct Tables {
    pub grid: Grid,
    /// On-time and mean wait in ticks of each path with excess light.
    pub paths: Vec<PathTable>,
    pub sign: SignTable,
    pub dead_time_ticks: u32,
    /// Standard deviation of the jitter.
    pub jitter_ticks: f64,
    /// Beyond this distance from a border, jitter does not carry over it.
    pub reach_ticks: u32,
}

/// The excess light of one path.
#[derive(Debug, Clone)]
pub struct PathTable {
    pub on_time: OnTime,
    pub mean_wait_ticks: f64,
    pub delay_ticks: i64,
    /// What its random streams are told apart by.
    pub number: u64,
}

impl Tables {
    /// The tables of a model, or why there are none.
    pub fn new(model: &DetectorModel) -> Result<Tables, OutsideDomain> {
        check_parts(model)?;
        let mut codes = model.excess.iter().map(|light| light.code.len());
        let period = codes.try_fold(model.reference.len(), least_common_multiple);
        let grid = period
            .and_then(Grid::new)
            .ok_or(OutsideDomain::PeriodTooLong { limit: LONGEST_PERIOD_CHIPS })?;
        if model.dead_time_chips >= f64::from(grid.period_chips) {
            return Err(OutsideDomain::DeadTimeTooLong {
                dead_time_chips: model.dead_time_chips,
                limit_chips: grid.period_chips,
            });
        }
        check_quickness(model, grid)?;

        let chips = |ps: f64| model.timing.clock.chips(ps);
        let jitter_chips = model.jitter_chips.unwrap_or(0.0);
        let timing = EdgeTiming {
            rising_delay_chips: chips(model.counter.rising_delay_ps),
            falling_delay_chips: chips(model.counter.falling_delay_ps),
            transition_chips: chips(model.counter.transition_ps),
            jitter_chips,
        };
        let mut sign = SignTable::new(grid, &model.reference.chips, &timing)
            .ok_or(OutsideDomain::EdgesTooWide)?;
        // A jitter of no width decides nothing, but it is drawn.
        sign.is_random |= model.jitter_chips.is_some();
        let zone = 2.0 * (NORMAL_REACH * timing.jitter_chips + timing.transition_chips)
            + (timing.rising_delay_chips - timing.falling_delay_chips).abs();
        if model.timing.parallel > 1 && zone * f64::from(model.timing.clock.samples_per_chip) >= 1.0
        {
            return Err(OutsideDomain::StepsTooClose { parallel: model.timing.parallel });
        }
        let paths = model.excess.iter().flat_map(|light| {
            let on_time = OnTime::new(grid, &light.code.chips);
            light.strands().map(move |strand| PathTable {
                on_time: on_time.clone(),
                mean_wait_ticks: grid.ticks(strand.mean_wait_chips),
                delay_ticks: grid.round(strand.delay()),
                number: strand.number,
            })
        });
        Ok(Tables {
            grid,
            paths: paths.collect(),
            sign,
            dead_time_ticks: grid.round(model.dead_time_chips) as u32,
            jitter_ticks: grid.ticks(jitter_chips),
            reach_ticks: grid.ticks(NORMAL_REACH * jitter_chips).ceil() as u32,
        })
    }
}

/// Whether the model has only parts that the lanes have.
fn check_parts(model: &DetectorModel) -> Result<(), OutsideDomain> {
    if let Some(light) = model.excess.iter().find(|light| light.movement.is_some()) {
        return Err(OutsideDomain::MovingPath { path: light.path });
    }
    if model.excess.iter().any(|light| light.shape.has_gates()) {
        return Err(OutsideDomain::UnlikeEdges);
    }
    if model.is_paralyzable {
        return Err(OutsideDomain::PassiveRecharge);
    }
    if model.tail.is_some() {
        return Err(OutsideDomain::Tail);
    }
    Ok(())
}

fn check_quickness(model: &DetectorModel, grid: Grid) -> Result<(), OutsideDomain> {
    let excess_per_chip: f64 = model.excess.iter().map(|light| light.rate_per_chip).sum();
    let mean_wait_chips = 1.0 / (model.constant_per_chip + excess_per_chip);
    let most_chips = MOST_PERIODS_PER_PHOTON * f64::from(grid.period_chips);
    if mean_wait_chips > most_chips {
        return Err(OutsideDomain::TooRare { mean_wait_chips, most_chips });
    }
    let mut time_constant_chips = mean_wait_chips;
    if let Some(afterpulsing) = model.afterpulsing {
        time_constant_chips = time_constant_chips.min(afterpulsing.time_constant_chips);
        // An endless chain of afterpulses is as quick as the dead time lets it.
        if afterpulsing.mean_per_avalanche > 0.9 {
            time_constant_chips = time_constant_chips.min(model.dead_time_chips);
        }
    }
    let least_chips = LEAST_TIME_CONSTANT_TICKS / f64::from(grid.chip_ticks());
    if time_constant_chips < least_chips {
        return Err(OutsideDomain::TooQuick { time_constant_chips, least_chips });
    }
    Ok(())
}

/// `None` beyond the longest period of the tables.
fn least_common_multiple(a: u64, b: u64) -> Option<u64> {
    let (mut divisor, mut rest) = (a, b);
    while rest > 0 {
        (divisor, rest) = (rest, divisor % rest);
    }
    let multiple = (a / divisor).checked_mul(b)?;
    (multiple <= LONGEST_PERIOD_CHIPS).then_some(multiple)
}
