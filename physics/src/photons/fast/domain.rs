//! For which models the lanes are exact, and their tables.

use std::sync::Arc;

use super::arithmetic::NORMAL_BOUND;
use super::excess::OnTime;
use super::members::{CrosstalkTargets, LitMembers, MemberTables, PerMember, Traps};
use super::movement::{MOST_RATE, SLACK_CHIPS};
use super::normal::NORMAL_REACH;
use super::places::{
    CHIP_TICKS, LONGEST_CHIPS, MOST_CODE_CHIPS, round_ticks, ticks, ticks_of_chips,
};
use super::profile::Profile;
use super::sign::{SignEdges, SignTable, threshold_of};
use crate::photons::DetectorModel;
use crate::photons::detector::Coupled;
use crate::photons::light::ExcessLight;
use crate::photons::movement::PathMovement;
use crate::response::LongRun;
use crate::scene::PathIndex;

/// Why a model is left to the plain loop.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum OutsideDomain {
    /// Each straight piece of a path costs as much as a photon.
    #[error(
        "path {path} of the scene moves anew every {piece_chips} chips; the lanes pay off where a photon \
         comes more often"
    )]
    MovesTooOften {
        /// Its index.
        path: PathIndex,
        /// How long it goes straight on.
        piece_chips: f64,
    },
    /// Waits would leave their table.
    #[error(
        "the delay of path {path} of the scene changes by up to {rate:.1e} of the time in 2^40 chips; \
         the lanes take {most:.1e}"
    )]
    MovesTooQuickly {
        /// Its index.
        path: PathIndex,
        /// Share of the time.
        rate: f64,
        /// The most of the lanes.
        most: f64,
    },
    /// The tables would fill the memory.
    #[error("a code has {chips} chips; the lanes take up to {limit}")]
    CodeTooLong {
        /// Its chips.
        chips: u64,
        /// Those of the longest table.
        limit: u64,
    },
    /// What is pending is looked through at each arrival.
    #[error(
        "{mean:.1} afterpulses and avalanches by crosstalk are pending at a time; the lanes take up to {most}"
    )]
    TooManyPending {
        /// Their mean number in the brightest light.
        mean: f64,
        /// Up to which lanes pay.
        most: f64,
    },
    /// What is pending has a word of ticks.
    #[error(
        "afterpulses or crosstalk come {delay_chips:.0} chips after an avalanche; the lanes take up to {limit_chips}"
    )]
    PendingTooLong {
        /// The longest delay: of afterpulses that of all but one in 10^11.
        delay_chips: f64,
        /// The longest of the lanes.
        limit_chips: u32,
    },
    /// Each arrival takes as long, lost or not.
    #[error(
        "{arrivals:.1} photons arrive in a dead time, of which all but one are lost; the lanes pay off up to {most}"
    )]
    MostlyBlind {
        /// Their mean number in the brightest light.
        arrivals: f64,
        /// Up to which lanes pay.
        most: f64,
    },
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

/// More of what is pending than that is looked through one by one as quickly.
const MOST_PENDING: f64 = 8.0;

/// Of so many arrivals in a dead time of the brightest light the plain loop passes over those that are lost as quickly.
const MOST_LOST: f64 = 12.0;

/// Time constants after which no afterpulse of 10^11 is pending.
const TIME_CONSTANTS: f64 = 25.0;

/// Dead times leave half of a table to waits.
const LONGEST_DEAD_TIME_CHIPS: u32 = LONGEST_CHIPS / 2;

/// Starts that take more dead times to be forgotten, and a greater share of a phase step, are drawn.
const LONG_DEAD_TIMES: f64 = 64.0;
const LONG_SHARE: f64 = 0.5;

/// Every table of a model, shared by all lanes and threads.
#[derive(Debug, Clone)]
pub struct Tables {
    /// How long before a step its simulation starts.
    pub warm_up_chips: i64,
    /// What a detector that has run for ever is like then; none where the start is forgotten, or
    /// not known.
    pub long_run: Option<LongRun>,
    /// Excess light without edges, or with edges all alike.
    pub paths: Vec<PathTable>,
    /// Waits are cut there.
    pub longest_wait_ticks: u32,
    pub dead_time_ticks: u32,
    /// Mean wait for constant light, endless if there is none, and on whom it falls.
    pub constant_wait_ticks: f64,
    pub constant_target: LitMembers,
    /// None of a detector that is blind from each avalanche on for as long, and hears no other.
    pub members: Option<MemberTables>,
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
    /// On which members it falls.
    pub target: LitMembers,
    /// How its delay changes, and by which number; none of a path that keeps it.
    pub movement: Option<(PathMovement, u64)>,
}

impl Tables {
    /// The tables of a model, or why there are none.
    pub fn new(model: &DetectorModel) -> Result<Tables, OutsideDomain> {
        let members = model.members();
        // Light that falls on all cells is that of the detector.
        let lit = if model.pixel.is_some() { vec![model] } else { members.clone() };
        for member in &members {
            check_lengths(member)?;
        }
        check_quickness(model, &lit)?;
        check_movements(model, &lit)?;
        // Light of one code and shape shares its tables.
        let mut known: Vec<(&ExcessLight, LightTables)> = Vec::new();
        let mut paths = Vec::new();
        for (place, lit) in (0..).zip(&lit) {
            let target =
                if model.pixel.is_some() { LitMembers::All } else { LitMembers::One(place) };
            for light in &lit.excess {
                let is_alike = |other: &ExcessLight| {
                    Arc::ptr_eq(&light.code, &other.code) && Arc::ptr_eq(&light.shape, &other.shape)
                };
                let found = known.iter().find(|(other, _)| is_alike(other));
                let tables = found.map_or_else(|| LightTables::new(light), |(_, t)| t.clone());
                paths.extend(tables.of(light, &target));
                known.push((light, tables));
            }
        }
        let dead_time_ticks = round_ticks(model.dead_time_chips) as u32;
        let dead_time_chips = dead_time_ticks.div_ceil(CHIP_TICKS);
        let constants: Vec<f64> = members.iter().map(|member| member.constant_per_chip).collect();
        let members = match members.len() == 1 && !(model.is_paralyzable && dead_time_ticks > 0) {
            true => None,
            false => Some(member_tables(model, &members)?),
        };
        let blind_chips = if members.is_some() { 0 } else { dead_time_chips };
        let moves = paths.iter().filter_map(|path| path.movement.as_ref()).any(|m| !m.0.is_none());
        let slack_chips = if moves { SLACK_CHIPS } else { 0 };
        let step_chips = model.timing.scan.integration_chips as f64;
        let least_chips = (LONG_DEAD_TIMES * model.dead_time_chips).max(LONG_SHARE * step_chips);
        let is_long = model.warm_up_chips as f64 > least_chips && !moves;
        let long_run = is_long.then(|| LongRun::of(model)).flatten();
        let chips = long_run.as_ref().map(|_| model.border_chips().ceil() as i64);
        Ok(Tables {
            warm_up_chips: chips.unwrap_or(model.warm_up_chips),
            long_run,
            paths,
            longest_wait_ticks: (LONGEST_CHIPS - 1 - blind_chips - slack_chips) * CHIP_TICKS,
            dead_time_ticks,
            constant_wait_ticks: ticks(1.0 / constants.iter().sum::<f64>()),
            constant_target: match model.pixel.as_ref().is_some_and(|pixel| pixel.is_even()) {
                true => LitMembers::All,
                false => shares(&constants),
            },
            members,
            jitter_ticks: ticks(model.jitter_chips.unwrap_or(0.0)),
            reach_ticks: ticks(jitter_reach_chips(model)).ceil() as u32,
        })
    }
}

/// As far as jitter carries a detection.
pub fn jitter_reach_chips(model: &DetectorModel) -> f64 {
    f64::from(NORMAL_BOUND) * model.jitter_chips.unwrap_or(0.0)
}

/// On whom light of these rates falls.
fn shares(rates: &[f64]) -> LitMembers {
    let all: f64 = rates.iter().sum();
    let mut until = 0.0;
    let thresholds = rates[1..].iter().zip(rates).map(|(_, rate)| {
        until += rate / all;
        threshold_of(until)
    });
    LitMembers::Shares(thresholds.collect())
}

/// What the members of a detector are like, and do to one another.
fn member_tables(
    model: &DetectorModel,
    members: &[&DetectorModel],
) -> Result<MemberTables, OutsideDomain> {
    check_pending(model, members)?;
    let dead_times = members.iter().map(|member| round_ticks(member.dead_time_chips) as u32);
    let afterpulsing = || members.iter().map(|member| member.afterpulsing);
    let half_lives = afterpulsing()
        .map(|a| a.map_or(0.0, |a| ticks(a.time_constant_chips) * std::f64::consts::LN_2));
    let left = members.iter().map(|member| {
        // With passive recharge they come within the dead time, and prolong it.
        let afterpulsing = member.afterpulsing.filter(|_| !member.is_paralyzable);
        afterpulsing.map_or(0.0, |a| (-member.dead_time_chips / a.time_constant_chips).exp())
    });
    let traps = afterpulsing().any(|a| a.is_some()).then(|| Traps {
        means: PerMember::of_floats(
            afterpulsing().map(|a| a.map_or(0.0, |a| a.mean_per_avalanche)),
        ),
        half_lives: PerMember::of_floats(half_lives),
        left: PerMember::of_floats(left),
    });
    let of_cells = model.pixel.iter().filter_map(|pixel| pixel.crosstalk);
    let mut crosstalk: Vec<CrosstalkTargets> = of_cells
        .map(|(probability, delay_chips)| CrosstalkTargets::Cells {
            threshold: threshold_of(probability).max(0),
            delay: round_ticks(delay_chips) as u32,
        })
        .collect();
    crosstalk.extend(model.crosstalk.iter().flat_map(|coupled| links(coupled)));
    Ok(MemberTables {
        number: members.len() as u32,
        own: model.crosstalk.as_ref().map(|coupled| coupled.own as u32),
        is_paralyzable: model.is_paralyzable,
        dead_times: PerMember::new(&dead_times.collect::<Vec<_>>()),
        traps,
        crosstalk,
    })
}

/// The links of coupled detectors, of each member one after another.
fn links(coupled: &Coupled) -> Vec<CrosstalkTargets> {
    let number = coupled.models.len();
    let of = |member: usize| coupled.links.iter().filter(move |link| link.from == member);
    let most = (0..number).map(|member| of(member).count()).max().unwrap_or(0);
    let round = |round: usize| {
        let link = |member| of(member).nth(round);
        let column = |value: &dyn Fn(usize) -> u32| {
            PerMember::new(&(0..number).map(value).collect::<Vec<_>>())
        };
        CrosstalkTargets::Link {
            thresholds: column(&|of| {
                threshold_of(link(of).map_or(0.0, |link| link.probability)) as u32
            }),
            targets: column(&|of| link(of).map_or(0, |link| link.to as u32)),
            delays: column(&|of| link(of).map_or(0, |link| round_ticks(link.delay_chips) as u32)),
        }
    };
    (0..most).map(round).collect()
}

/// Whether what is pending fits a word, and lanes pay off in spite of it and of what blind members lose. Rates are
/// those without crosstalk, which are the same whichever of coupled detectors is asked for.
fn check_pending(model: &DetectorModel, members: &[&DetectorModel]) -> Result<(), OutsideDomain> {
    let talks = |of: usize| match (&model.pixel, &model.crosstalk) {
        (Some(pixel), _) => pixel.crosstalk.into_iter().collect::<Vec<_>>(),
        (None, Some(coupled)) => {
            let links = coupled.links.iter().filter(|link| link.from == of);
            links.map(|link| (link.probability, link.delay_chips)).collect()
        }
        (None, None) => Vec::new(),
    };
    let mut mean = 0.0;
    for (of, member) in members.iter().enumerate() {
        let (member, talks) = (member.without_crosstalk(), talks(of));
        let longest = |delay_chips: f64| match delay_chips > f64::from(LONGEST_CHIPS) {
            true => Err(OutsideDomain::PendingTooLong { delay_chips, limit_chips: LONGEST_CHIPS }),
            false => Ok(()),
        };
        talks.iter().try_for_each(|(_, delay)| longest(*delay))?;
        let trapped = member.afterpulsing.map_or(Ok(0.0), |a| {
            longest(TIME_CONSTANTS * a.time_constant_chips)?;
            Ok(a.mean_per_avalanche * (a.time_constant_chips + member.dead_time_chips))
        })?;
        let arrivals = member.brightest_per_chip() * member.dead_time_chips;
        if arrivals > MOST_LOST && !member.is_paralyzable {
            return Err(OutsideDomain::MostlyBlind { arrivals, most: MOST_LOST });
        }
        let talk: f64 = talks.iter().map(|(probability, delay)| probability * delay).sum();
        if talk + trapped > 0.0 {
            // What avalanches cause comes on top, as often as they do if members are alike.
            let caused: f64 = talks.iter().map(|(probability, _)| probability).sum();
            let rate = member.most_detections_per_chip() / (1.0 - caused).max(0.0);
            mean += rate.min(member.most_of_dead_time_per_chip()) * (talk + trapped);
        }
    }
    match mean > MOST_PENDING {
        true => Err(OutsideDomain::TooManyPending { mean, most: MOST_PENDING }),
        false => Ok(()),
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
    fn of(&self, light: &ExcessLight, target: &LitMembers) -> Vec<PathTable> {
        let table = |mean_wait_chips: f64, delay_chips: f64, number: u64| PathTable {
            on_time: Arc::clone(&self.on_time),
            profile: self.profile.clone(),
            mean_wait_ticks: ticks(mean_wait_chips),
            delay_ticks: round_ticks(delay_chips.rem_euclid(light.code.len() as f64)),
            code_chips: light.code.len(),
            number,
            target: target.clone(),
            movement: light.movement.clone().map(|movement| (movement, light.number)),
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

/// The counter's sign, decided as soon as an avalanche comes: none where its jitter is not Gaussian,
/// or may carry it over both ends of a step.
pub fn sign_table(model: &DetectorModel) -> Option<SignTable> {
    if model.tail.is_some() {
        return None;
    }
    let chips = |ps: f64| model.timing.clock.chips(ps);
    let timing = SignEdges {
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
    let is_near_one = model.timing.parallel == 1 || zone * samples_per_chip < 1.0;
    let table = is_near_one.then(|| SignTable::new(&model.reference.chips, &timing)).flatten();
    if let Some(mut table) = table {
        // A jitter of no width decides nothing, but it is drawn.
        table.is_random |= model.jitter_chips.is_some();
        return Some(table);
    }
    let is_near_one_end =
        2.0 * jitter_reach_chips(model) < model.timing.scan.integration_chips as f64;
    is_near_one_end.then(|| SignTable::drawn(&model.reference.chips, &timing)).flatten()
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

/// Mean wait for any light, that of `lit` together and all that is constant, where it is brightest.
fn mean_wait_chips(model: &DetectorModel, lit: &[&DetectorModel]) -> f64 {
    let excess = lit.iter().flat_map(|lit| &lit.excess).map(|light| light.rate_per_chip);
    let constant = model.members().into_iter().map(|member| member.constant_per_chip);
    1.0 / (constant.sum::<f64>() + excess.sum::<f64>())
}

/// Whether paths of `lit` that move are straight for longer than a photon takes to come, and slow.
fn check_movements(model: &DetectorModel, lit: &[&DetectorModel]) -> Result<(), OutsideDomain> {
    let wait_chips = mean_wait_chips(model, lit);
    for light in lit.iter().flat_map(|lit| &lit.excess) {
        let Some(movement) = &light.movement else { continue };
        let (path, rate) = (light.path, movement.steepest());
        if rate > MOST_RATE {
            return Err(OutsideDomain::MovesTooQuickly { path, rate, most: MOST_RATE });
        }
        if let Some(piece_chips) = movement.piece_chips().filter(|chips| *chips < wait_chips) {
            return Err(OutsideDomain::MovesTooOften { path, piece_chips });
        }
    }
    Ok(())
}

/// Of a model, under the light of `lit` together.
fn check_quickness(model: &DetectorModel, lit: &[&DetectorModel]) -> Result<(), OutsideDomain> {
    let mean_wait_chips = mean_wait_chips(model, lit);
    let most_chips = MOST_CUTS_PER_PHOTON * f64::from(LONGEST_CHIPS);
    if mean_wait_chips > most_chips {
        return Err(OutsideDomain::TooRare { mean_wait_chips, most_chips });
    }
    let mut time_constant_chips = mean_wait_chips;
    for member in model.members() {
        let Some(afterpulsing) = member.afterpulsing else { continue };
        time_constant_chips = time_constant_chips.min(afterpulsing.time_constant_chips);
        // An endless chain of afterpulses is as quick as the dead time lets it.
        if afterpulsing.mean_per_avalanche > 0.9 {
            time_constant_chips = time_constant_chips.min(member.dead_time_chips);
        }
    }
    let least_chips = LEAST_TIME_CONSTANT_TICKS / f64::from(CHIP_TICKS);
    if time_constant_chips < least_chips {
        return Err(OutsideDomain::TooQuick { time_constant_chips, least_chips });
    }
    Ok(())
}
