//! The inner loop: one wait, and mostly one avalanche, in every lane.

use rand::RngExt;

use super::afterpulses::Afterpulses;
use super::arithmetic::{Floats, LANES, LONGEST_WAIT, LaneWords, to_ticks};
use super::constant::ConstantLight;
use super::domain::{PathTable, Tables};
use super::excess::LaneExcessLight;
use super::members::{LitMembers, Members};
use super::pieces::Pieces;
use super::places::{LaneTimes, round_ticks, ticks, ticks_of_chips};
use crate::photons::DetectorModel;
use crate::photons::random::{RandomStream, StreamKey, scatter};

/// Detectors at work side by side, each in a phase step of its own.
///
/// A lane's clock is the time of its last avalanche, or of where a wait was cut, before or
/// after a border (the step's start or end, more or less).
#[derive(Debug)]
pub struct Lanes<'t> {
    tables: &'t Tables,
    paths: Vec<LaneExcessLight<'t>>,
    /// None where all paths keep their delays.
    pieces: Option<Pieces>,
    /// `None` if there is none, as for afterpulses: a part that does not exist
    /// costs nothing, and does as much as one of infinite waits.
    constant: Option<ConstantLight>,
    afterpulses: Option<Afterpulses>,
    pub clock: LaneTimes,
    /// How far the clock went on in the last iteration.
    pub elapsed: LaneWords,
    /// 1 where the last iteration was an avalanche that counts, 0 where a wait was cut.
    pub fired: LaneWords,
    /// None of a detector that is blind from each avalanche on for as long, and hears no other.
    pub members: Option<Members<'t>>,
    iterations: u32,
}

/// After so many iterations places for what is pending are given back.
const ITERATIONS_TO_SHRINK: u32 = 256;

impl<'t> Lanes<'t> {
    pub fn new(model: &DetectorModel, tables: &'t Tables) -> Lanes<'t> {
        let path = |path: &'t PathTable| {
            let movement = path.movement.as_ref().map(|(movement, _)| movement);
            LaneExcessLight::new(
                &path.on_time,
                path.profile.as_deref(),
                path.mean_wait_ticks,
                movement,
            )
        };
        let moves = tables.paths.iter().any(|path| path.movement.is_some());
        Lanes {
            tables,
            paths: tables.paths.iter().map(path).collect(),
            pieces: moves.then(Pieces::new),
            constant: tables
                .constant_wait_ticks
                .is_finite()
                .then(|| ConstantLight::new(tables.constant_wait_ticks)),
            afterpulses: model.afterpulsing.filter(|_| tables.members.is_none()).map(|a| {
                let time_constant_ticks = ticks(a.time_constant_chips);
                Afterpulses::new(a.mean_per_avalanche, time_constant_ticks, tables.dead_time_ticks)
            }),
            clock: LaneTimes::new(),
            elapsed: LaneWords::all(0),
            fired: LaneWords::all(0),
            members: tables.members.as_ref().map(Members::new),
            iterations: 0,
        }
    }

    /// Puts a detector that gets ready before the light of a key, and the lane's clock `border` ticks
    /// before its avalanches' time. Gives the ticks of its start.
    ///
    /// Steps of one group get the same streams: the same detections, in each of
    /// their lanes.
    pub fn start(
        &mut self,
        lane: usize,
        model: &DetectorModel,
        key: &StreamKey,
        border: i64,
    ) -> i64 {
        let ready = |model: &DetectorModel, key| round_ticks(model.first_ready_chips(key));
        let warm_up_chips = self.tables.warm_up_chips;
        let mut start = -ticks_of_chips(warm_up_chips);
        let mut pending = 0.0;
        // All members begin at one time, whichever of them it is that counts.
        let mut shared = *key;
        let mut keys = Vec::new();
        if let Some(members) = &mut self.members {
            let models = model.members();
            keys.extend(models.iter().map(|m| m.key(key.seed, key.repetition, key.group)));
            if model.pixel.is_none() {
                shared = keys[0];
            }
            let blind = models.iter().zip(&keys).map(|(model, key)| ready(model, key) as u32);
            members.start(lane, &shared, blind);
        } else if let Some(long_run) = &self.tables.long_run {
            let place = model.code_position(key.repetition, key.group, long_run.period_chips());
            let share: f64 = key.stream(RandomStream::Start).random();
            let ready = long_run.ready_in((place - warm_up_chips) as f64, share);
            start += round_ticks(ready.chips);
            pending = ready.pending;
        } else {
            start += ready(model, key);
        }
        for (path, table) in self.paths.iter_mut().zip(&self.tables.paths) {
            let key = match table.target {
                LitMembers::One(member) => keys.get(member as usize).unwrap_or(key),
                _ => key,
            };
            path.streams.restart(lane, key.hash(RandomStream::Path(table.number)));
            if let Some((_, streams)) = &mut path.edges {
                streams.restart(lane, key.hash(RandomStream::Path(scatter(table.number, 1))));
            }
            let position = model.code_position(key.repetition, key.group, table.code_chips);
            let origin = ticks_of_chips(position) - table.delay_ticks;
            path.places.set(lane, origin + start);
            if let (Some(path), Some((_, number))) = (&mut path.movement, &table.movement) {
                path.start(lane, model, key, *number, origin);
            }
        }
        if let Some(pieces) = &mut self.pieces {
            pieces.begin(lane, start, &mut self.paths);
        }
        if let Some(constant) = &mut self.constant {
            constant.streams.restart(lane, shared.hash(RandomStream::ConstantLight));
        }
        if let Some(afterpulses) = &mut self.afterpulses {
            afterpulses.streams.restart(lane, key.hash(RandomStream::Afterpulsing));
            afterpulses.masses[lane] = pending as f32;
        }
        self.clock.set(lane, start - border);
        self.fired[lane] = 0;
        start
    }

    /// From where each detector gets ready, or has had its last arrival, to the end of the next wait.
    ///
    /// There the arrivals of all parts have no memory,
    /// so the next avalanche is the earliest of fresh draws. A wait that is too long is cut,
    /// with no avalanche, and drawn again: that is exact
    /// for the same reason, and keeps every number small.
    #[inline(always)]
    pub fn iterate(&mut self) {
        // Of what is not looked up by ticks only the first is rounded to them.
        let mut others = Floats::all(LONGEST_WAIT as f32);
        if let Some(constant) = &mut self.constant {
            constant.shorten(&mut others);
        }
        if let Some(afterpulses) = &mut self.afterpulses {
            afterpulses.shorten(&mut others);
        }
        let mut waits = LaneWords::all(LONGEST_WAIT);
        let mut cuts = LaneWords::all(self.tables.longest_wait_ticks);
        if let Some(pieces) = &self.pieces {
            pieces.cut(&mut cuts);
        }
        if let Some(members) = &mut self.members {
            members.choose();
        }
        for (path, table) in self.paths.iter_mut().zip(&self.tables.paths) {
            let before = waits;
            path.shorten(&mut waits, &mut cuts);
            if let Some(members) = &mut self.members {
                members.aim(&table.target, &before, &waits);
            }
        }
        let before = waits;
        for lane in 0..LANES {
            waits[lane] = before[lane].min(to_ticks(others[lane]));
        }
        if let Some(members) = &mut self.members {
            members.aim(&self.tables.constant_target, &before, &waits);
            (self.elapsed, self.fired) = members.arrive(&waits, &cuts);
            let elapsed = self.elapsed;
            self.advance_light(&elapsed);
            self.iterations = self.iterations.wrapping_add(1);
            if let Some(members) = &mut self.members
                && self.iterations.is_multiple_of(ITERATIONS_TO_SHRINK)
            {
                members.shrink();
            }
        } else {
            self.fire(&waits, &cuts);
        }
        self.clock.advance(&self.elapsed);
    }

    /// All light goes on.
    #[inline(always)]
    fn advance_light(&mut self, elapsed: &LaneWords) {
        for path in &mut self.paths {
            path.advance(elapsed);
        }
        if let Some(pieces) = &mut self.pieces {
            pieces.clock.advance(elapsed);
            if pieces.clock.any_at_border() {
                pieces.go_on(&mut self.paths);
            }
        }
    }

    /// The detector fires at the end of a wait, and is blind from then on.
    #[inline(always)]
    fn fire(&mut self, waits: &LaneWords, cuts: &LaneWords) {
        let dead_time = self.tables.dead_time_ticks;
        let mut until_ready = LaneWords::all(0);
        for lane in 0..LANES {
            let wait = waits[lane].min(cuts[lane]);
            let blind = if self.fired[lane] != 0 { dead_time } else { 0 };
            self.elapsed[lane] = wait.wrapping_add(blind);
            let fires = waits[lane] < cuts[lane];
            self.fired[lane] = u32::from(fires);
            until_ready[lane] = wait.wrapping_add(if fires { dead_time } else { 0 });
        }
        self.advance_light(&until_ready);
        if let Some(afterpulses) = &mut self.afterpulses {
            afterpulses.decay(&until_ready, &self.fired);
        }
    }
}
