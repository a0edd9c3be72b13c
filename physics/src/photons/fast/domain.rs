//! For which models the lanes are exact, and their tables.

use std::sync::Arc;

use super::arithmetic::NORMAL_BOUND;
use super::excess::OnTime;
use super::normal::NORMAL_REACH;
use super::places::{
    CHIP_TICKS, LONGEST_CHIPS, MOST_CODE_CHIPS, round_ticks, ticks, ticks_of_chips,
};
use super::profile::Profile;
use super::sign::{EdgeTiming, SignTable};
use crate::photons::DetectorModel;
use crate::photons::light::ExcessLight;
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
    /// Scans that do not follow one another.
    #[error("scans begin when they like; the lanes take those that follow one another")]
    Anchored,
    /// The tables would fill the memory.
    #[error("a code has {chips} chips; the lanes take up to {limit}")]
    CodeTooLong {
        /// Its chips.
        chips: u64,
        /// Those of the longest table.
        limit: u64,
    },
    /// The lanes know one detector.
    #[error("crosstalk of other detectors; the lanes take detectors that hear none")]
    Crosstalk,
    /// Each cell goes through the lanes by itself.
    #[error("cells fire one another; the lanes take cells that know nothing of each other")]
    CellCrosstalk,
    /// A dead time is part of a wait, which is shorter than a table.
    #[error("the dead time is {dead_time_chips} chips; the lanes take less than {limit_chips}")]
    DeadTimeTooLong {
        /// The model's dead time.
        dead_time_chips: f64,
        /// The longest of the lanes.
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
    /// Jitter does not fit a word.
    #[error("the jitter is {jitter_chips} chips; the lanes take less than {limit_chips}")]
    TooMuchJitter {
        /// Its standard deviation.
        jitter_chips: f64,
        /// The most of the lanes.
        limit_chips: f64,
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

/// Waits are cut at [`LONGEST_CHIPS`], at the cost of an iteration each; a photon of the
/// plain loop costs about ten.
const MOST_CUTS_PER_PHOTON: f64 = 10.0;

/// Dead times leave half of a table to waits.
const LONGEST_DEAD_TIME_CHIPS: u32 = LONGEST_CHIPS / 2;

/// Every table of a model, shared by all lanes and threads.
#[derive(Debug, Clone)]
pub struct Tables {
    /// Excess light without edges, or with edges all alike.
    pub paths: Vec<PathTable>,
    /// Waits are cut there.
    pub longest_wait_ticks: u32,
    pub dead_time_ticks: u32,
    /// Whether each arrival within a dead time begins it anew.
    pub is_paralyzable: bool,
    /// Standard deviation of the jitter.
    pub jitter_ticks: f64,
    /// Beyond this distance from a border, jitter does not carry over it.
    pub reach_ticks: u32,
}

/// The excess light of one path, or a strand of it.
#[derive(Debug, Clone)]
pub struct PathTable {
    pub on_time: Arc<OnTime>,
    /// How it follows its code; none where it does so at once.
    pub profile: Option<Arc<Profile>>,
    pub mean_wait_ticks: f64,
    /// Modulo the code's period.
    pub delay_ticks: i64,
    pub code_chips: u64,
    /// What its random streams are told apart by.
    pub number: u64,
}

impl Tables {
    /// The tables of a model, or why there are none; of a detector of several cells those of each one, whose light
    /// and dead times are alike.
    pub fn new(model: &DetectorModel) -> Result<Tables, OutsideDomain> {
        if let Some(light) = model.excess.iter().find(|light| light.movement.is_some()) {
            return Err(OutsideDomain::MovingPath { path: light.path });
        }
        if model.crosstalk.is_some() {
            return Err(OutsideDomain::Crosstalk);
        }
        if model.anchor.is_some() {
            return Err(OutsideDomain::Anchored);
        }
        if let Some(pixel) = &model.pixel {
            if pixel.crosstalk.is_some() {
                return Err(OutsideDomain::CellCrosstalk);
            }
            pixel.cells.iter().try_for_each(check_quickness)?;
            return Tables::new(&pixel.cells[0]);
        }
        check_lengths(model)?;
        check_quickness(model)?;
        let jitter_chips = model.jitter_chips.unwrap_or(0.0);
        // Light of one code and shape shares its tables.
        let mut known: Vec<(&ExcessLight, LightTables)> = Vec::new();
        let mut paths = Vec::new();
        for light in &model.excess {
            let is_alike = |other: &ExcessLight| {
                Arc::ptr_eq(&light.code, &other.code) && Arc::ptr_eq(&light.shape, &other.shape)
            };
            let found = known.iter().find(|(other, _)| is_alike(other));
            let tables = found.map_or_else(|| LightTables::new(light), |(_, t)| t.clone());
            paths.extend(tables.of(light));
            known.push((light, tables));
        }
        let dead_time_ticks = round_ticks(model.dead_time_chips) as u32;
        let dead_time_chips = dead_time_ticks.div_ceil(CHIP_TICKS);
        Ok(Tables {
            paths,
            longest_wait_ticks: (LONGEST_CHIPS - 1 - dead_time_chips) * CHIP_TICKS,
            dead_time_ticks,
            is_paralyzable: model.is_paralyzable && dead_time_ticks > 0,
            jitter_ticks: ticks(jitter_chips),
            reach_ticks: ticks(f64::from(NORMAL_BOUND) * jitter_chips).ceil() as u32,
        })
    }
}

/// What follows from a code and how light follows it.
#[derive(Debug, Clone)]
struct LightTables {
    on_time: Arc<OnTime>,
    profile: Option<Arc<Profile>>,
}

impl LightTables {
    fn new(light: &ExcessLight) -> LightTables {
        let is_keyed = light.code.weight() < light.code.len();
        let has_edges = is_keyed && !light.shape.is_ideal();
        let profile = has_edges.then(|| Profile::new(&light.shape)).flatten();
        let reach = profile.as_ref().map_or(0, |profile| profile.reach);
        let on_time = Arc::new(OnTime::new(&light.code.chips, reach));
        LightTables { on_time, profile: profile.map(Arc::new) }
    }

    /// The tables of a path: one, or where light reaches too far for a profile, one for each
    /// strand.
    fn of(&self, light: &ExcessLight) -> Vec<PathTable> {
        let table = |mean_wait_chips: f64, delay_chips: f64, number: u64| PathTable {
            on_time: Arc::clone(&self.on_time),
            profile: self.profile.clone(),
            mean_wait_ticks: ticks(mean_wait_chips),
            delay_ticks: round_ticks(delay_chips.rem_euclid(light.code.len() as f64)),
            code_chips: light.code.len(),
            number,
        };
        match &self.profile {
            Some(profile) => {
                let delay_chips = light.delay() + profile.first_chips;
                vec![table(1.0 / light.rate_per_chip, delay_chips, light.number)]
            }
            None => {
                let strands = light.strands();
                strands.map(|s| table(s.mean_wait_chips, s.delay(), s.number)).collect()
            }
        }
    }
}

/// The counter's sign, where one number decides on which side of an edge a detection is
/// registered: none where it may be near another edge, too, or its jitter is not Gaussian.
pub fn sign_table(model: &DetectorModel) -> Option<SignTable> {
    if model.tail.is_some() {
        return None;
    }
    let chips = |ps: f64| model.timing.clock.chips(ps);
    let timing = EdgeTiming {
        rising_delay_chips: chips(model.counter.rising_delay_ps),
        falling_delay_chips: chips(model.counter.falling_delay_ps),
        transition_chips: chips(model.counter.transition_ps),
        jitter_chips: model.jitter_chips.unwrap_or(0.0),
    };
    // Steps of one group share a detection's jitter, and each lane of theirs decides by the
    // same number: that is exact while no detection is near edges of two steps.
    let zone = 2.0 * (NORMAL_REACH * timing.jitter_chips + timing.transition_chips)
        + (timing.rising_delay_chips - timing.falling_delay_chips).abs();
    let samples_per_chip = f64::from(model.timing.clock.samples_per_chip);
    if model.timing.parallel > 1 && zone * samples_per_chip >= 1.0 {
        return None;
    }
    let mut sign = SignTable::new(&model.reference.chips, &timing)?;
    // A jitter of no width decides nothing, but it is drawn.
    sign.is_random |= model.jitter_chips.is_some();
    Some(sign)
}

/// Whether everything fits a table or a word.
fn check_lengths(model: &DetectorModel) -> Result<(), OutsideDomain> {
    let codes = model.excess.iter().map(|light| light.code.len());
    let chips = codes.fold(model.reference.len(), u64::max);
    let limit = MOST_CODE_CHIPS as u64;
    if chips > limit {
        return Err(OutsideDomain::CodeTooLong { chips, limit });
    }
    let dead_time_chips = model.dead_time_chips;
    if dead_time_chips > f64::from(LONGEST_DEAD_TIME_CHIPS) {
        let limit_chips = LONGEST_DEAD_TIME_CHIPS;
        return Err(OutsideDomain::DeadTimeTooLong { dead_time_chips, limit_chips });
    }
    let jitter_chips = model.jitter_chips.unwrap_or(0.0);
    let limit_chips = f64::from(LONGEST_CHIPS / 2) / f64::from(NORMAL_BOUND);
    if jitter_chips > limit_chips {
        return Err(OutsideDomain::TooMuchJitter { jitter_chips, limit_chips });
    }
    // What is added to it keeps within 64 bits.
    assert!(ticks_of_chips(model.warm_up_chips) >= 0);
    Ok(())
}

fn check_quickness(model: &DetectorModel) -> Result<(), OutsideDomain> {
    let excess_per_chip: f64 = model.excess.iter().map(|light| light.rate_per_chip).sum();
    let mean_wait_chips = 1.0 / (model.constant_per_chip + excess_per_chip);
    let most_chips = MOST_CUTS_PER_PHOTON * f64::from(LONGEST_CHIPS);
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
    let least_chips = LEAST_TIME_CONSTANT_TICKS / f64::from(CHIP_TICKS);
    if time_constant_chips < least_chips {
        return Err(OutsideDomain::TooQuick { time_constant_chips, least_chips });
    }
    Ok(())
}
