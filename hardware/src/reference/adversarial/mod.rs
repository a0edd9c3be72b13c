//! Inputs chosen to hurt, with an aim: what the hardware must stand at its worst.
//!
//! The adversary has a reference model of its own, which tells it what it has
//! reached. It begins with some phase steps in peace, with the steps round a scan's end
//! and with large counts from all over the counters' range; then it goes from cover point
//! to cover point ([`CoverPoint::recipe`]), each time from a reset; and when there is nothing
//! left to aim at it goes on by chance.

mod cells;
mod chance;
mod hits;
mod means;
mod preparation;
mod receiver;
mod written;

use crate::scene::DetectorIndex;
use std::collections::VecDeque;
use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use self::cells::{share, spread};
use self::hits::{GroupWords, Pattern};
pub use self::means::Means;
use self::written::Written;
pub use self::written::WrittenRun;
use super::coverage::{CoverPoint, registers};
use super::group_maker::GroupMaker;
use super::host::Host;
use super::host_ports::HostInputs;
use super::levels::Levels;
use super::planned::{Hits, Lead, Length, PlannedGroup, ReceiverPlan, Shortening};
use super::predictor::{ReferenceError, ReferenceModel, ScanPosition, Skip, Surroundings};
use super::stimulus::{Drive, RESET_CLOCKS, Stimulus};
use crate::photons::Pulse;
use crate::scan::{Group, Sample};
use crate::sensor::cells::CellChange;
use crate::sensor::interface::Interface;

/// Longest run that is chosen when the user asks for no number of clocks.
pub const LONGEST_DEFAULT: u64 = 1 << 25;
/// Clocks of such a run by chance, behind those in which it reaches all that it can; with a host, whose
/// every clock has to be thought of, fewer.
const CLOCKS_BY_CHANCE: u64 = 1 << 20;
const CLOCKS_BY_CHANCE_WITH_A_HOST: u64 = 1 << 19;
/// Groups in peace at the beginning, at least.
const CALM_GROUPS: u64 = 3;
/// Longest stretch that is decided at once: its pulses are kept.
const MOST_CLOCKS_AT_ONCE: u64 = 1 << 14;
/// How often a cover point is aimed at before it is given up: in some chance has a part.
const TRIES: u8 = 8;
/// Tells a host's chance from that of the rest.
const HOST_SEED: u64 = 0x686f_7374;
/// Clocks without a scan, and without a request, after which a host asks for scans.
const LONGEST_PAUSE: u64 = 64;
/// Chip of a group after which it is shortened.
const SKIP_AT_CHIP: u64 = 3;

/// The adversary.
#[derive(Debug, Clone)]
pub struct Adversarial {
    rng: Xoshiro256PlusPlus,
    interface: Interface,
    means: Means,
    reach: Shortening,
    /// Its own reference model, predicted as far as is decided.
    scout: ReferenceModel,
    levels: Levels,
    /// Resets, stalls and skips that have been decided, in order.
    resets: VecDeque<Range<u64>>,
    stalls: VecDeque<Range<u64>>,
    skips: VecDeque<Skip>,
    /// For each input the pulses that have been decided, in order of their
    /// first sample.
    pulses: Vec<VecDeque<Pulse>>,
    /// Records of what has been decided, in place of the pulses, where they are asked for.
    written: Option<Box<Written>>,
    /// First clock that is not decided yet.
    decided: u64,
    /// End of the last stall that has been decided.
    stalls_until: u64,
    /// Groups that come next, by plan.
    plans: VecDeque<PlannedGroup>,
    under_way: Option<UnderWay>,
    /// When the results of the last group arrive, and how many they are.
    arrival: Option<(u64, u64)>,
    aims: Aims,
    /// Of registers, if there are any.
    host: Option<Host>,
    /// What it has been decided to drive, in order.
    drives: VecDeque<(u64, HostInputs)>,
}

/// A group of which a part is decided.
#[derive(Debug, Clone)]
struct UnderWay {
    plan: PlannedGroup,
    origin: u64,
    chips: u64,
    done: u64,
}

/// What is still to be reached.
#[derive(Debug, Clone)]
struct Aims {
    /// How often each point has been aimed at.
    tries: Vec<u8>,
    next: usize,
    calm_groups: u64,
    /// A scan's end and large counts have been planned.
    has_prepared: bool,
    /// First clock at which nothing was left to aim at.
    over_at: Option<u64>,
    /// There the run ends.
    ends_there: bool,
    /// Groups by chance before the next reset, at least.
    groups_without_reset: u64,
}

impl Adversarial {
    /// An adversary without the means to shorten steps or scans. A shorter run is the
    /// start of a longer one.
    ///
    /// # Panics
    /// When the interface cannot be predicted; see [`ReferenceModel::new`].
    pub fn new(interface: &Interface, seed: u64) -> Adversarial {
        Adversarial::with_means(interface, seed, Means::cosim(false))
            .expect("an interface that is co-simulated can be predicted")
    }

    /// An adversary with these means.
    ///
    /// # Errors
    /// When the interface cannot be predicted.
    pub fn with_means(
        interface: &Interface,
        seed: u64,
        means: Means,
    ) -> Result<Adversarial, ReferenceError> {
        let scout = ReferenceModel::new(interface.clone())?;
        let points = scout.cover_table().points().len();
        Ok(Adversarial {
            rng: Xoshiro256PlusPlus::seed_from_u64(seed),
            interface: interface.clone(),
            means,
            reach: Shortening::of(interface, means.skips, means.most_clocks()),
            scout,
            levels: Levels::of(interface),
            resets: VecDeque::new(),
            stalls: VecDeque::new(),
            skips: VecDeque::new(),
            pulses: vec![VecDeque::new(); interface.inputs()],
            written: None,
            decided: 0,
            stalls_until: 0,
            plans: VecDeque::new(),
            under_way: None,
            arrival: None,
            aims: Aims {
                tries: vec![0; points],
                next: 0,
                calm_groups: 0,
                has_prepared: false,
                over_at: None,
                ends_there: false,
                groups_without_reset: 0,
            },
            host: interface
                .registers
                .as_ref()
                .map(|plan| Host::new(seed ^ HOST_SEED, registers::addresses(plan))),
            drives: VecDeque::new(),
        })
    }

    /// The same, which ends the run where it has reached all that it can.
    pub fn ending_there(mut self) -> Adversarial {
        self.aims.ends_there = true;
        self
    }

    /// Clocks after which it has reached all that it can, or the most that a run takes
    /// that was asked for no number.
    pub fn clocks_to_cover(mut self, most: u64) -> u64 {
        let mut scratch = Drive::of(&self.interface);
        let mut clock = 0;
        while self.aims.over_at.is_none() && self.decided < most {
            let end = (clock + MOST_CLOCKS_AT_ONCE).min(most);
            scratch.start(clock..end);
            self.drive(&mut scratch);
            clock = end;
        }
        self.aims.over_at.unwrap_or(most).min(most)
    }

    /// Clocks of a run that was asked for no number, at most `most`: those to reach all that it can, and
    /// then by chance what no cover point names.
    pub fn clocks_of_a_run(self, most: u64) -> u64 {
        let by_chance = match self.host {
            Some(_) => CLOCKS_BY_CHANCE_WITH_A_HOST,
            None => CLOCKS_BY_CHANCE,
        };
        self.clocks_to_cover(most).saturating_add(by_chance).min(most)
    }

    /// Why a cover point is too far away for these means, if it is.
    pub fn hindrance(interface: &Interface, means: Means, point: CoverPoint) -> Option<String> {
        let reach = Shortening::of(interface, means.skips, means.most_clocks());
        recipe(interface, &reach, point).err()
    }

    /// Whether it has reached all that it can, and the run ends there.
    fn is_over(&self) -> bool {
        self.aims.ends_there && self.aims.over_at.is_some()
    }

    /// Decides up to a clock, if the run does not end before it.
    fn decide_before(&mut self, end: u64) {
        while self.decided < end && !self.is_over() {
            self.decide();
        }
    }

    /// Tells what surrounds a block, besides its pulses.
    fn tell(&mut self, block: &mut Surroundings) {
        let clocks = &block.clocks;
        // What reaches beyond the block is told again in the next.
        let tell = |queue: &mut VecDeque<Range<u64>>, out: &mut Vec<Range<u64>>| {
            while queue.pop_front_if(|r| r.end <= clocks.start).is_some() {}
            out.extend(within(queue, clocks).cloned());
        };
        tell(&mut self.resets, &mut block.resets);
        tell(&mut self.stalls, &mut block.stalls);
        while let Some((clock, inputs)) = self.drives.pop_front_if(|(c, _)| *c < clocks.end) {
            block.host.push((clock..clock + 1, inputs));
        }
        while let Some(skip) = self.skips.pop_front_if(|s| s.clock < clocks.end) {
            block.skips.push(skip);
        }
    }

    /// Decides what comes next.
    fn decide(&mut self) {
        if self.decided == 0 {
            self.resets.push_back(0..RESET_CLOCKS);
            let silent = vec![Vec::new(); self.interface.reference_codes.len()];
            return self.decide_until(RESET_CLOCKS, silent, Hits::None);
        }
        if let Some(group) = self.under_way.take() {
            return self.decide_words(group);
        }
        let Some(mut plan) = self.next_plan() else {
            return;
        };
        let is_asking = self.host.as_ref().is_some_and(|host| !host.is_idle());
        let ends_talks = plan.reset.is_some() && self.aims.over_at.is_none();
        if is_asking && (ends_talks || plan.cut.is_some()) {
            // A conversation is held to its end. So is it before a group that the next plan's reset
            // cuts short, which would else go on without one.
            self.plans.push_front(plan);
            plan = PlannedGroup::random().received(ReceiverPlan::Random);
        }
        if let Some(host) = &mut self.host {
            host.ask(std::mem::take(&mut plan.asks));
        }
        if let Some(reset) = plan.reset.take() {
            let start = self.decided + reset.age;
            let end = start + reset.clocks;
            self.plans.push_front(plan);
            self.decide_lead(start, Lead::Random);
            self.resets.push_back(start..end);
            self.arrival = None;
            self.decide_lead(end, Lead::Random);
            return;
        }
        let position = self.scout.position();
        if !position.is_scan() {
            // A host has not asked for one, or settings are being taken over.
            self.plans.push_front(plan);
            // Not past the first word of one that is prepared meanwhile.
            let most = LONGEST_PAUSE.min(self.interface.timing.preparation_chips);
            let clocks = self.rng.random_range(1..=most);
            self.decide_lead(self.decided + clocks, Lead::Random);
            let is_over = !self.scout.position().is_scan();
            if let (Some(host), Some(plan)) = (&mut self.host, &self.interface.registers)
                && is_over
                && host.is_idle()
            {
                host.ask(match self.aims.over_at {
                    Some(_) if self.rng.random_bool(0.8) => chance::talk(plan, &mut self.rng),
                    _ => registers::as_in_the_scene(&self.interface, plan),
                });
            }
            return;
        }
        if self.decided < position.first_word() {
            // A receiver that holds a result does so during the pause, too.
            let chips = self.chips_of(&plan, position.first_word());
            let latency = u64::from(self.interface.result_latency_clocks);
            let arrives = position.first_word() + chips - 1 + latency;
            self.decide_receiver(plan.receiver, self.decided, arrives);
            let lead = plan.lead;
            let length = Length::Exactly(chips);
            self.plans.push_front(plan.long(length).received(ReceiverPlan::Takes));
            self.decide_lead(position.first_word(), lead);
            return;
        }
        self.start_group(plan, position);
    }

    /// The next group that is planned. When all plans are done, the next aim; none where the run ends.
    fn next_plan(&mut self) -> Option<PlannedGroup> {
        if let Some(plan) = self.plans.pop_front() {
            return Some(plan);
        }
        if self.host.as_ref().is_some_and(|host| !host.is_idle()) {
            return Some(PlannedGroup::random().received(ReceiverPlan::Random));
        }
        let is_calm = self.aims.calm_groups < CALM_GROUPS || self.decided < self.means.calm_clocks;
        if is_calm {
            self.aims.calm_groups += 1;
            let receiver = if self.aims.calm_groups <= CALM_GROUPS {
                ReceiverPlan::Takes
            } else {
                ReceiverPlan::Random
            };
            return Some(PlannedGroup::random().long(Length::Whole).received(receiver));
        }
        if !std::mem::replace(&mut self.aims.has_prepared, true) {
            let plans =
                preparation::plans(&self.interface, &self.reach, &self.means, &mut self.rng);
            self.plans = plans.into();
            return Some(self.plans.pop_front().unwrap_or_else(PlannedGroup::random));
        }
        match self.next_aim() {
            Some(plans) => self.plans.extend(plans),
            None => {
                self.aims.over_at.get_or_insert(self.decided);
                if self.is_over() {
                    return None;
                }
                let plan = self.by_chance();
                self.plans.push_back(plan);
            }
        }
        Some(self.plans.pop_front().unwrap_or_else(PlannedGroup::random))
    }

    /// The way to the next point that is not covered and not given up.
    fn next_aim(&mut self) -> Option<Vec<PlannedGroup>> {
        let table = self.scout.cover_table().clone();
        let points = table.points();
        for round in 0..TRIES {
            for _ in 0..points.len() {
                let number = self.aims.next;
                self.aims.next = (number + 1) % points.len();
                let is_covered = self.scout.exercise().covered.contains(number);
                if is_covered || self.aims.tries[number] > round {
                    continue;
                }
                self.aims.tries[number] = round + 1;
                if let Ok(plans) = recipe(&self.interface, &self.reach, points[number]) {
                    return Some(plans);
                }
                self.aims.tries[number] = TRIES;
            }
        }
        None
    }

    /// Begins a group: its length, what is left out, and what the receiver does until
    /// its results arrive.
    fn start_group(&mut self, plan: PlannedGroup, position: ScanPosition) {
        let whole = self.scout.interface().timing.scan.integration_chips;
        let origin = position.first_word();
        let chips = self.chips_of(&plan, origin);
        let groups = self.scout.interface().groups();
        let left_out = match plan.left_to_the_last {
            Some(left) if self.reach.leaves_out => {
                (groups - 1).saturating_sub(left + position.group.0 + 1)
            }
            _ => 0,
        };
        let chips = plan.cut.unwrap_or(chips).min(chips);
        let shortens = chips < whole && plan.cut.is_none();
        if shortens || left_out > 0 {
            self.skips.push_back(Skip {
                clock: origin + SKIP_AT_CHIP,
                chip: SKIP_AT_CHIP,
                group: position.group,
                chips: if shortens { whole - chips } else { 0 },
                groups: left_out,
            });
        }
        let latency = u64::from(self.interface.result_latency_clocks);
        let arrives = origin + chips - 1 + latency;
        self.decide_receiver(plan.receiver, origin, arrives);
        if plan.cut.is_none() {
            let beats = match self.interface.histogram() {
                Some(_) => self.interface.beats_of_group(),
                None => {
                    let group = Group(position.group.0 + left_out);
                    let steps = self.scout.interface().grouping().steps_of(group).len() as u64;
                    steps * self.interface.reference_codes.len() as u64
                }
            };
            self.arrival = Some((arrives, beats));
        }
        self.decide_words(UnderWay { plan, origin, chips, done: 0 });
    }

    /// Chips of a group.
    fn chips_of(&mut self, plan: &PlannedGroup, origin: u64) -> u64 {
        let whole = self.scout.interface().timing.scan.integration_chips;
        // Scans as a host sets them take their time while it talks.
        let is_set = self
            .host
            .as_ref()
            .is_some_and(|host| whole < 2 * self.reach.shortest + 16 || !host.is_idle());
        if !self.reach.shortens(&self.interface) || is_set {
            return whole;
        }
        let least = plan.hits.chips(&self.scout, origin, whole);
        let shortest = self.reach.shortest;
        let chips = match plan.length {
            Length::Whole if whole <= self.reach.most_clocks => return whole,
            Length::Exactly(chips) => return chips,
            Length::AtLeast(chips) => chips.max(shortest),
            _ => shortest + self.rng.random_range(0..shortest),
        };
        // Near its end it cannot be shortened.
        match chips.max(least) {
            chips if chips + shortest > whole => whole,
            chips => self.reach.chips_of_at_least(&self.interface, chips),
        }
    }

    /// Decides the next words of a group.
    fn decide_words(&mut self, mut group: UnderWay) {
        let chips = group.done..(group.done + MOST_CLOCKS_AT_ONCE).min(group.chips);
        let is_end = chips.end == group.chips;
        let is_aimed_next = self.plans.front().is_some_and(|plan| plan.hits.needs_low());
        let mut pulses = vec![Vec::new(); self.interface.reference_codes.len()];
        let (lanes, parallel) =
            (u64::from(self.interface.lanes()), u64::from(self.interface.parallel()));
        for (detector, pulses) in DetectorIndex::all().zip(pulses.iter_mut()) {
            let words = GroupWords::new(&self.scout, detector, group.origin, chips.clone());
            match group.plan.hits {
                Hits::Random => {
                    let pattern = Pattern::random(&mut self.rng, lanes, parallel);
                    words.pattern(pattern, &mut self.rng, pulses);
                    words.clip(is_aimed_next, pulses);
                }
                hits => {
                    let is_elsewhere = hits.detector().is_some_and(|d| d != detector);
                    // What is asked of a whole group is for its last words.
                    let is_later = hits.is_once() && !is_end;
                    if !is_elsewhere && !is_later {
                        let _ = words.aimed(hits, pulses);
                    }
                }
            }
        }
        let end = group.origin + chips.end;
        group.done = chips.end;
        let hits = group.plan.hits;
        if !is_end {
            self.under_way = Some(group);
        }
        self.decide_until(end, pulses, hits);
    }

    /// Words outside of scans, up to a clock.
    fn decide_lead(&mut self, until: u64, lead: Lead) {
        let (lanes, parallel) =
            (u64::from(self.interface.lanes()), u64::from(self.interface.parallel()));
        let is_aimed_next = self.plans.front().is_some_and(|plan| plan.hits.needs_low());
        while self.decided < until {
            let end = (self.decided + MOST_CLOCKS_AT_ONCE).min(until);
            let mut pulses = vec![Vec::new(); self.interface.reference_codes.len()];
            for (detector, pulses) in DetectorIndex::all().zip(pulses.iter_mut()) {
                let words =
                    GroupWords::new(&self.scout, detector, self.decided, 0..end - self.decided);
                match lead {
                    Lead::Random => {
                        let pattern = Pattern::random(&mut self.rng, lanes, parallel);
                        words.pattern(pattern, &mut self.rng, pulses);
                        words.clip(is_aimed_next, pulses);
                    }
                    Lead::LastSample if end == until => {
                        let _ = words.aimed(Hits::Border { first: false }, pulses);
                    }
                    Lead::LastSample => {}
                }
            }
            let hits = match lead {
                Lead::Random => Hits::Random,
                Lead::LastSample => Hits::Border { first: false },
            };
            self.decide_until(end, pulses, hits);
        }
    }

    /// Takes in pulses of each detector up to a clock, and predicts what they do.
    fn decide_until(&mut self, end: u64, mut pulses: Vec<Vec<Pulse>>, hits: Hits) {
        let clocks = self.decided..end;
        let cells = self.interface.input_cells;
        if cells.count > 1 {
            let samples = self.interface.timing.sampling().samples(&clocks);
            let of_cells = |level: Vec<Pulse>| match cells.edges() {
                1 => spread(&level, samples.clone(), &cells, &mut self.rng),
                count => share(&level, samples.clone(), count, hits, &mut self.rng),
            };
            pulses = pulses.into_iter().flat_map(of_cells).collect();
        }
        let mut hits = vec![Vec::new(); self.interface.reference_codes.len()];
        let mut changes = Vec::new();
        match &mut self.written {
            Some(written) => {
                written.paint(&mut self.levels, (clocks, &pulses), &mut hits, &mut changes);
            }
            None => {
                self.levels.paint(clocks, &pulses, |_, _, _| (), &mut hits, &mut changes);
                for (kept, pulses) in self.pulses.iter_mut().zip(pulses) {
                    kept.extend(pulses);
                }
            }
        }
        while self.decided < end {
            let until = match self.host_drives() {
                // It answers what the slave shows, clock by clock.
                true => self.decided + 1,
                false => end,
            };
            self.predict_until(until, &hits, &changes);
        }
    }

    /// Decides what a host drives at the next clock, if it does anything.
    fn host_drives(&mut self) -> bool {
        let clock = self.decided;
        let Some(host) = self.host.as_mut().filter(|host| !host.is_idle()) else {
            return false;
        };
        if within(&self.resets, &(clock..clock + 1)).next().is_some() {
            host.reset();
        } else {
            let inputs = host.next(&self.scout.host_outputs(), |event| self.scout.comes(event));
            self.drives.push_back((clock, inputs));
        }
        true
    }

    /// Predicts what is decided up to a clock.
    fn predict_until(&mut self, end: u64, hits: &[Vec<Sample>], changes: &[Vec<CellChange>]) {
        let clocks = self.decided..end;
        let samples = self.interface.timing.sampling().samples(&clocks);
        let first_skip = self.skips.partition_point(|skip| skip.clock < clocks.start);
        let skips = self.skips.range(first_skip..);
        let drives = self.drives.iter().rev();
        let mut surroundings = Surroundings {
            clocks: clocks.clone(),
            resets: within(&self.resets, &clocks).cloned().collect(),
            stalls: within(&self.stalls, &clocks).cloned().collect(),
            skips: skips.take_while(|skip| skip.clock < end).copied().collect(),
            host: drives
                .take_while(|(clock, _)| clocks.contains(clock))
                .map(|&(clock, inputs)| (clock..clock + 1, inputs))
                .collect(),
            cells: changes
                .iter()
                .map(|changes| CellChange::within(changes, &samples).to_vec())
                .collect(),
        };
        match &mut self.written {
            Some(written) => written.predict(&mut self.scout, &mut surroundings, hits),
            None => {
                self.scout.predict_results(&surroundings, hits);
                self.scout.take_finished();
            }
        }
        self.decided = end;
    }
}

/// Those of `ranges`, one behind the other, that have one of `clocks`.
fn within<'a>(
    ranges: &'a VecDeque<Range<u64>>,
    clocks: &Range<u64>,
) -> impl Iterator<Item = &'a Range<u64>> {
    let first = ranges.partition_point(|range| range.end <= clocks.start);
    let end = clocks.end;
    ranges.range(first..).take_while(move |range| range.start < end)
}

/// The way to a cover point, or why it is too long.
///
/// Every recipe begins with a reset, so that it works wherever the one before it
/// ended.
fn recipe(
    interface: &Interface,
    reach: &Shortening,
    point: CoverPoint,
) -> Result<Vec<PlannedGroup>, String> {
    let detector = point.detector.unwrap_or(DetectorIndex(0));
    let maker = GroupMaker { interface, reach, detector };
    let mut plans = point.recipe(&maker)?;
    let flush = reach.groups_to_flush(interface);
    let chips: u64 = plans.iter().map(|plan| maker.chips_of(plan)).sum();
    let clocks = chips.saturating_add(flush.saturating_mul(reach.shortest));
    if clocks > reach.most_clocks {
        return Err(format!("it takes {clocks} clocks"));
    }
    plans.extend((0..flush).map(|_| PlannedGroup::random()));
    Ok(plans)
}

impl Hits {
    /// Whether the level has to be low before the group.
    fn needs_low(self) -> bool {
        self.detector().is_some() || matches!(self, Hits::Border { .. })
    }

    /// Whether so many are meant, and no more.
    fn is_single(self) -> bool {
        self.needs_low() || matches!(self, Hits::BeforeCut { .. })
    }

    /// Whether a group has them once, and not again and again.
    fn is_once(self) -> bool {
        !matches!(
            self,
            Hits::Random
                | Hits::EveryOther
                | Hits::Lane { .. }
                | Hits::BeyondLimitAtEnd { .. }
                | Hits::OneSided { .. }
                | Hits::AllSteps { .. }
        )
    }
}

impl Stimulus for Adversarial {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = &mut drive.surroundings.clocks;
        self.decide_before(clocks.end);
        if self.is_over() {
            clocks.end = clocks.end.min(self.decided);
        }
        let end = self.interface.timing.sampling().first_sample(clocks.end);
        for (decided, pulses) in self.pulses.iter_mut().zip(&mut drive.pulses) {
            while let Some(pulse) = decided.pop_front_if(|p| p.first < end) {
                pulses.push(pulse);
            }
        }
        self.tell(&mut drive.surroundings);
    }
}

#[cfg(test)]
mod tests;
