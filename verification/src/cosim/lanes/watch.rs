//! A short run of a design from its reset on, whose registers are looked at.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::design::{Backend, LaneDesign};
use super::model::{LaneBlock, LaneModel, PeriodicOutput, halted};
use super::places::CodePlace;
use super::planes::Planes;
use super::recurrence::SPARE_SAMPLES;
use super::slices::{FIRST_WORD, settling_clocks};
use super::tally::LaneTally;
use crate::cosim::error::CosimError;
use crate::reference::canvas::Changes;
use crate::reference::predictor::{ReferenceModel, Surroundings};
use crate::reference::stimulus::RESET_CLOCKS;
use crate::scan::{Group, Sample};
use crate::sensor::interface::Interface;

/// Clocks that are watched, unless these are more groups than are of use, or too few.
const CLOCKS: u64 = 4_000_000;
/// Most groups that are watched.
const MOST_GROUPS: u64 = 600;
/// Least groups that are watched: so many tell a thermometer of 16 places.
const LEAST_GROUPS: u64 = 40;
/// Most clocks at which the registers are read one after another, in the first group.
const MOST_CHIPS: u64 = 4_200;
/// First groups: what the reset left is still on its way.
pub(super) const FIRST_GROUPS: usize = 2;
const QUIET_GROUPS: u64 = 12;
/// Most hits of a detector in a quiet group.
const QUIET_HITS: usize = 2;

/// What was seen.
pub(super) struct Watched {
    /// Of each register what it was at the first word of each group.
    pub(super) histories: Vec<Vec<bool>>,
    /// Of each register what it was at clocks of the first group one after another, from
    /// [`settling_clocks`] behind its first word on.
    pub(super) chips: Vec<Vec<bool>>,
    /// What had been counted at the first word of each group.
    pub(super) counted: Vec<Vec<i64>>,
}

/// A run that is watched.
pub(super) struct Watch<'a> {
    design: &'a LaneDesign,
    interface: &'a Interface,
    /// Groups that are watched.
    groups: u64,
    /// Of each register what it was at the clocks that were watched one by one.
    chips: Vec<Vec<bool>>,
    model: LaneModel,
    rng: Xoshiro256PlusPlus,
}

impl<'a> Watch<'a> {
    pub(super) fn new(
        design: &'a LaneDesign,
        interface: &'a Interface,
    ) -> Result<Watch<'a>, CosimError> {
        let backend = Backend::Vectors;
        let dark = |output| PeriodicOutput {
            output,
            planes: Planes::new(backend.lanes(), 1).into(),
            length: 1,
        };
        let tables: Vec<PeriodicOutput> = (0..design.tables).map(dark).collect();
        let groups = interface.groups();
        // An LFSR that counts all groups is told by twice its bits.
        let counter_bits = groups.next_power_of_two().ilog2() as usize;
        let least = (FIRST_GROUPS + 2 * counter_bits + SPARE_SAMPLES) as u64;
        Ok(Watch {
            design,
            interface,
            groups: (CLOCKS / interface.timing.scan.integration_chips)
                .clamp(least.max(LEAST_GROUPS), MOST_GROUPS)
                .min(groups),
            chips: vec![Vec::new(); design.registers.len()],
            model: LaneModel::load(design, backend, &tables)?,
            rng: Xoshiro256PlusPlus::seed_from_u64(1),
        })
    }

    /// All registers, and all that has been counted, at the first words of the first
    /// groups.
    pub(super) fn run(mut self) -> Result<Watched, CosimError> {
        let group_clocks = self.interface.timing.scan.integration_chips;
        let mut reference = ReferenceModel::new(self.interface.clone())?;
        let mut tally = LaneTally::new(self.interface);
        let power_up = self.design.power_up(0);
        let mut registers = Planes::new(self.model.lanes(), power_up.len());
        for (register, value) in power_up.into_iter().enumerate() {
            registers.set(register, 0, value);
        }
        self.model.set_registers(&registers).map_err(halted)?;
        let mut samples = vec![false; FIRST_WORD as usize * self.design.samples];
        self.clock(&samples[..RESET_CLOCKS as usize * self.design.samples], true)?;
        self.clock(&samples[RESET_CLOCKS as usize * self.design.samples..], false)?;
        let mut clock = 0;
        let mut histories = vec![Vec::new(); self.design.registers.len()];
        let mut counted = Vec::new();
        for group in 0..self.groups {
            self.note(&mut histories)?;
            counted.push(tally.values());
            let end = FIRST_WORD + (group + 1) * group_clocks;
            let hits = self.stimulate(group, &mut samples);
            let surroundings = Surroundings {
                clocks: clock..end,
                resets: std::iter::once(0..RESET_CLOCKS).collect(),
                ..Surroundings::default()
            };
            reference.predict_changes(&surroundings, &hits, &mut Changes::default());
            clock = end;
            let rest = if group == 0 { self.watch_chips(&samples)? } else { &samples[..] };
            self.clock(rest, false)?;
            for result in reference.take_finished() {
                tally.add(&result);
            }
        }
        Ok(Watched { histories, chips: self.chips, counted })
    }

    /// Clocks a part of the first group clock by clock: a code's period, if it is not too long.
    /// Gives the samples of the rest.
    fn watch_chips<'s>(&mut self, samples: &'s [bool]) -> Result<&'s [bool], CosimError> {
        let settling = settling_clocks(self.interface);
        let periods = CodePlace::all(self.interface).into_iter().map(|place| place.period);
        let wanted = 2 * periods.max().unwrap_or_default();
        let quiet = self.interface.timing.scan.integration_chips - 2 * settling;
        let (before, rest) = samples.split_at(settling as usize * self.design.samples);
        self.clock(before, false)?;
        let watched = wanted.min(MOST_CHIPS).min(quiet) as usize;
        let (watched, rest) = rest.split_at(watched * self.design.samples);
        for word in watched.chunks(self.design.samples) {
            let mut chips = std::mem::take(&mut self.chips);
            self.note(&mut chips)?;
            self.chips = chips;
            self.clock(word, false)?;
        }
        Ok(rest)
    }

    /// Adds what all registers are to what they were.
    fn note(&mut self, histories: &mut [Vec<bool>]) -> Result<(), CosimError> {
        let planes = self.model.registers().map_err(halted)?;
        for (register, history) in histories.iter_mut().enumerate() {
            history.push(planes.get(register, 0));
        }
        Ok(())
    }

    /// Clocks lane 0 with some samples; nobody looks at the others.
    fn clock(&mut self, samples: &[bool], in_reset: bool) -> Result<(), CosimError> {
        let (design, lanes) = (self.design, self.model.lanes());
        let of_detector = self.interface.lanes() as usize;
        for part in samples.chunks(design.block_clocks as usize * design.samples) {
            let mut edges = Vec::new();
            let mut levels = vec![false; design.samples / of_detector];
            for (place, &sample) in part.iter().enumerate() {
                let level = &mut levels[place % design.samples / of_detector];
                if std::mem::replace(level, sample) != sample {
                    edges.push((place * lanes) as u32);
                }
            }
            let block = LaneBlock {
                clocks: (part.len() / design.samples) as u64,
                reset: Planes::row_where(lanes, [in_reset].into_iter()),
                watched: Planes::new(lanes, 1),
                edges,
                events: Vec::new(),
                phases: vec![0; design.tables],
            };
            self.model.submit(&block).map_err(halted)?;
            self.model.collect().map_err(halted)?;
        }
        Ok(())
    }

    /// Pulses of one sample for a group, for each detector of one sign or of both, and
    /// none at its end, so that all are counted when it is over.
    fn stimulate(&mut self, group: u64, samples: &mut Vec<bool>) -> Vec<Vec<Sample>> {
        let interface = self.interface;
        let lanes = u64::from(interface.lanes());
        let clocks = interface.timing.scan.integration_chips;
        let loud = (clocks - settling_clocks(interface)) * lanes;
        samples.clear();
        samples.resize(clocks as usize * self.design.samples, false);
        let sampling = interface.timing.sampling();
        let first = sampling.first_sample(FIRST_WORD + group * clocks);
        let step = interface.grouping().step_of(Group(group), 0);
        let phase_step = interface.timing.scan.phase_step(step);
        let mut all = Vec::new();
        for (detector, code) in interface.reference_codes.iter().enumerate() {
            let period = code.len() * lanes;
            let delay = period - phase_step % period;
            let sign = self.rng.random_range(0..4u8);
            let most = self.most_hits(group, loud, sign == 0);
            let mut hits = Vec::new();
            // At even and odd samples, so that neighbouring phase steps count differently.
            let mut sample = self.rng.random_range(0..2);
            while sample < loud && hits.len() < most {
                let chip = (group * clocks * lanes + sample + delay) % period / lanes;
                let up = code.chips[chip as usize] == 1;
                let wanted = match sign {
                    0 => up,
                    1 => !up,
                    _ => true,
                };
                if wanted {
                    let (clock, lane) = (sample / lanes, sample % lanes);
                    let plane = detector * interface.lanes() as usize + lane as usize;
                    samples[clock as usize * self.design.samples + plane] = true;
                    hits.push(first + sample);
                }
                sample += self.rng.random_range(2..4);
            }
            all.push(hits);
        }
        all
    }

    /// Most hits of a group: few at first, then of any order of magnitude. Where all are
    /// counted up it grows slowly, so that the largest count does in many steps and
    /// comes to saturation long after a count below zero has.
    fn most_hits(&mut self, group: u64, loud: u64, are_up: bool) -> usize {
        if group < QUIET_GROUPS {
            return QUIET_HITS;
        }
        let octaves = (loud as f64 / 2.0).log2().max(1.0);
        let grown = (group - QUIET_GROUPS) as f64 / (self.groups as f64 / 2.0);
        let most = if are_up { grown.min(1.0) } else { 1.0 };
        self.rng.random_range(0.0..=(octaves * most).max(0.1)).exp2() as usize
    }
}
