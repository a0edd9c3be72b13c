//! The inner loop: one wait, and mostly one avalanche, in every lane.

use super::afterpulses::Afterpulses;
use super::arithmetic::{LANES, LONGEST_WAIT, Words};
use super::constant::ConstantLight;
use super::domain::Tables;
use super::excess::ExcessLight;
use super::places::{Clock, round_ticks, ticks, ticks_of_chips};
use crate::photons::DetectorModel;
use crate::photons::random::{Part, StreamKey, scatter};

/// Detectors at work side by side, each in a phase step of its own.
///
/// A lane's clock is the time of its last avalanche, or of where a wait was cut, before or
/// after a border (the step's start or end, more or less).
#[derive(Debug)]
pub struct Lanes<'t> {
    tables: &'t Tables,
    paths: Vec<ExcessLight<'t>>,
    /// `None` if there is none, as for afterpulses: a part that does not exist
    /// costs nothing, and does as much as one of infinite waits.
    constant: Option<ConstantLight>,
    afterpulses: Option<Afterpulses>,
    pub clock: Clock,
    /// How far the clock went on in the last iteration.
    pub elapsed: Words,
    /// 1 where the last iteration was an avalanche, 0 where a wait was cut.
    pub fired: Words,
    /// Ticks for which a detector with passive recharge is still blind if nothing comes.
    blind: Words,
}

impl<'t> Lanes<'t> {
    pub fn new(model: &DetectorModel, tables: &'t Tables) -> Lanes<'t> {
        let path = |path: &'t super::domain::PathTable| {
            ExcessLight::new(&path.on_time, path.profile.as_deref(), path.mean_wait_ticks)
        };
        Lanes {
            tables,
            paths: tables.paths.iter().map(path).collect(),
            constant: (model.constant_per_chip > 0.0)
                .then(|| ConstantLight::new(ticks(1.0 / model.constant_per_chip))),
            afterpulses: model
                .afterpulsing
                .map(|a| Afterpulses::new(a.mean_per_avalanche, ticks(a.time_constant_chips))),
            clock: Clock::new(),
            elapsed: Words::all(0),
            fired: Words::all(0),
            blind: Words::all(0),
        }
    }

    /// Puts a ready detector before the light of a key, and the lane's clock `border` ticks
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
        let start = round_ticks(model.first_ready_chips(key)) - ticks_of_chips(model.warm_up_chips);
        for (path, table) in self.paths.iter_mut().zip(&self.tables.paths) {
            path.streams.restart(lane, key.hash(Part::Path(table.number)));
            if let Some((_, streams)) = &mut path.edges {
                streams.restart(lane, key.hash(Part::Path(scatter(table.number, 1))));
            }
            let position = model.code_position(key.repetition, key.group, table.code_chips);
            path.places.set(lane, ticks_of_chips(position) + start - table.delay_ticks);
        }
        if let Some(constant) = &mut self.constant {
            constant.streams.restart(lane, key.hash(Part::ConstantLight));
        }
        if let Some(afterpulses) = &mut self.afterpulses {
            afterpulses.streams.restart(lane, key.hash(Part::Afterpulsing));
            afterpulses.masses[lane] = 0.0;
        }
        self.clock.set(lane, start - border);
        self.fired[lane] = 0;
        self.blind[lane] = 0;
        start
    }

    /// From where each detector gets ready to the end of the next wait.
    ///
    /// There the arrivals of all parts have no memory,
    /// so the next avalanche is the earliest of fresh draws. A wait that is too long is cut,
    /// with no avalanche, and drawn again: that is exact
    /// for the same reason, and keeps every number small.
    #[inline(always)]
    pub fn iterate(&mut self) {
        let dead_time = self.tables.dead_time_ticks;
        let mut waits = Words::all(LONGEST_WAIT);
        let mut cuts = Words::all(self.tables.longest_wait_ticks);
        if self.tables.is_paralyzable {
            for lane in 0..LANES {
                // Zero is an endless time below itself.
                let blind = self.blind[lane].wrapping_sub(1).min(cuts[lane].wrapping_sub(1));
                cuts[lane] = blind.wrapping_add(1);
            }
        }
        for path in &mut self.paths {
            path.shorten(&mut waits, &mut cuts);
        }
        if let Some(constant) = &mut self.constant {
            constant.shorten(&mut waits);
        }
        if let Some(afterpulses) = &mut self.afterpulses {
            afterpulses.shorten(&mut waits);
        }
        // Until the detector is ready again, and where afterpulses begin to come.
        let (mut until_ready, mut trapping) = (Words::all(0), Words::all(0));
        if self.tables.is_paralyzable {
            for lane in 0..LANES {
                let (blind, wait) = (self.blind[lane], waits[lane].min(cuts[lane]));
                let has_arrived = waits[lane] < cuts[lane];
                let left = blind.saturating_sub(wait);
                self.elapsed[lane] = wait;
                until_ready[lane] = wait;
                trapping[lane] = u32::from(!has_arrived & (blind > 0) & (left == 0));
                self.fired[lane] = u32::from(has_arrived & (blind == 0));
                self.blind[lane] = if has_arrived { dead_time } else { left };
            }
        } else {
            for lane in 0..LANES {
                let wait = waits[lane].min(cuts[lane]);
                self.elapsed[lane] = wait.wrapping_add(self.fired[lane].wrapping_mul(dead_time));
                self.fired[lane] = u32::from(waits[lane] < cuts[lane]);
                until_ready[lane] = wait.wrapping_add(self.fired[lane].wrapping_mul(dead_time));
                trapping[lane] = self.fired[lane];
            }
        }
        for path in &mut self.paths {
            path.places.advance(&until_ready);
        }
        if let Some(afterpulses) = &mut self.afterpulses {
            afterpulses.decay(&until_ready, &trapping);
        }
        self.clock.advance(&self.elapsed);
    }
}
