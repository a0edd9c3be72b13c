//! The inner loop: one wait, and mostly one detection, in every lane.

use super::afterpulses::Afterpulses;
use super::arithmetic::{Integers, LANES, Words, wrap};
use super::constant::ConstantLight;
use super::domain::Tables;
use super::excess::ExcessLight;
use super::sign::Sign;
use crate::photons::DetectorModel;

/// Thirty-two detectors at work, each in a phase step of its own.
///
/// A lane's clock is a phase (ticks within the period) and a signed number of
/// periods, both of the last avalanche, or of where a wait was cut. It counts up
/// to a border (the step's start or end) at zero.
#[derive(Debug)]
pub struct Lanes<'t> {
    tables: &'t Tables,
    pub paths: Vec<ExcessLight<'t>>,
    /// `None` if there is none, as for afterpulses: a part that does not exist
    /// costs nothing, and does as much as one of infinite waits.
    pub constant: Option<ConstantLight>,
    pub afterpulses: Option<Afterpulses>,
    pub sign: Sign<'t>,
    pub phases: Words,
    pub periods: Integers,
    /// 1 where the last iteration was an avalanche, 0 where a wait was cut.
    pub fired: Words,
    /// Detections since the lane's counts were taken.
    pub totals: Words,
    /// Those of them that counted up.
    pub ups: Words,
}

impl<'t> Lanes<'t> {
    pub fn new(model: &DetectorModel, tables: &'t Tables) -> Lanes<'t> {
        let grid = tables.grid;
        let paths = tables.paths.iter();
        Lanes {
            tables,
            paths: paths
                .map(|path| ExcessLight::new(&path.on_time, path.mean_wait_ticks))
                .collect(),
            constant: (model.constant_per_chip > 0.0)
                .then(|| ConstantLight::new(grid.ticks(1.0 / model.constant_per_chip))),
            afterpulses: model
                .afterpulsing
                .map(|a| Afterpulses::new(a.mean_per_avalanche, grid.ticks(a.time_constant_chips))),
            sign: Sign::new(&tables.sign),
            phases: Words::all(0),
            periods: Integers::all(i32::MIN),
            fired: Words::all(0),
            totals: Words::all(0),
            ups: Words::all(0),
        }
    }

    /// Goes on until an avalanche in at least one lane lies at or behind its
    /// border.
    #[inline(always)]
    pub fn run_to_border(&mut self) {
        loop {
            self.iterate();
            let before = self.periods.iter().fold(-1, |all, periods| all & periods);
            if before >= 0 {
                return;
            }
        }
    }

    /// From the end of each dead time to the end of the next wait.
    ///
    /// Where the detector gets ready, the arrivals of all parts have no memory,
    /// so the next avalanche is the earliest of fresh draws. A wait of a period
    /// or longer is cut there, with no avalanche, and drawn again: that is exact
    /// for the same reason, and keeps every number small.
    #[inline(always)]
    fn iterate(&mut self) {
        let period = self.tables.grid.period_ticks;
        let dead_time = self.tables.dead_time_ticks;

        let mut ready = Words::all(0);
        for (lane, ready) in ready.iter_mut().enumerate() {
            let end = self.phases[lane].wrapping_add(self.fired[lane].wrapping_mul(dead_time));
            *ready = wrap(end, period);
            self.periods[lane] = self.periods[lane].wrapping_add(i32::from(end >= period));
        }

        let mut waits = Words::all(period);
        for path in &mut self.paths {
            path.shorten(&ready, &mut waits);
        }
        if let Some(constant) = &mut self.constant {
            constant.shorten(&mut waits);
        }
        if let Some(afterpulses) = &mut self.afterpulses {
            afterpulses.shorten(&mut waits);
        }

        for lane in 0..LANES {
            let end = ready[lane].wrapping_add(waits[lane]);
            self.phases[lane] = wrap(end, period);
            self.periods[lane] = self.periods[lane].wrapping_add(i32::from(end >= period));
            self.fired[lane] = u32::from(waits[lane] < period);
        }
        if let Some(afterpulses) = &mut self.afterpulses {
            let mut elapsed = waits;
            for (elapsed, fired) in elapsed.iter_mut().zip(self.fired.iter()) {
                *elapsed = elapsed.wrapping_add(fired.wrapping_mul(dead_time));
            }
            afterpulses.decay(&elapsed, &self.fired);
        }

        self.sign.decide(&self.phases);
        for lane in 0..LANES {
            self.totals[lane] = self.totals[lane].wrapping_add(self.fired[lane]);
            self.ups[lane] = self.ups[lane].wrapping_add(self.fired[lane] & self.sign.levels[lane]);
        }
    }
}
