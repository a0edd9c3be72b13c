//! The simulated targets once more, before the Verilog, which follows them by its own counts: a host turns that on, and behind
//! each scan and each window reads where the target is.

use std::collections::VecDeque;
use std::ops::Range;

use super::run::{TargetState, TrackedScan};
use super::windows::Windows;
use crate::photons::Pulse;
use crate::reference::host::{Host, Request};
use crate::reference::host_ports::HostClocks;
use crate::reference::level::LevelPainter;
use crate::reference::predictor::{ReferenceError, ReferenceModel, Surroundings};
use crate::reference::stimulus::{Drive, RESET_CLOCKS, Stimulus};
use crate::sensor::interface::Interface;
use crate::sensor::registers::{RegisterPlan, STATUS, setting_address, state};
use crate::sensor::track::{TrackPlan, TrackSetting};

/// Clocks that are gone through at once while a scan is waited for: preparations are longer.
const STRIDE_CLOCKS: u64 = 8;
/// Clocks in which a host has done what it is asked for at a time, at most.
const HOST_CLOCKS: u64 = 400;

/// The hardware does not follow a target as the simulation does.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "target {target}, scan {scan}: the hardware shows {shown}, and without it it is {expected}"
)]
pub struct Differs {
    target: usize,
    scan: usize,
    shown: String,
    expected: String,
}

/// Photons of one target after the other, and the host.
pub(super) struct Targets<'m> {
    /// As the scene has it.
    interface: &'m Interface,
    registers: &'m RegisterPlan,
    plan: TrackPlan,
    setting: TrackSetting,
    /// What the simulation had of each target: its scans.
    scans: &'m [Vec<TrackedScan>],
    /// Photons of a target.
    photons: &'m dyn Fn(u64) -> Windows<'m>,
    /// What the hardware is at before `clock`.
    scout: ReferenceModel,
    clock: u64,
    level: LevelPainter,
    host: Host,
    /// Pulses that the scout has not seen yet.
    ahead: VecDeque<Pulse>,
    /// What it has seen, to be driven.
    pulses: VecDeque<Pulse>,
    resets: Vec<Range<u64>>,
    hosts: HostClocks,
    /// Targets that are done, and what was wrong with the last.
    done: usize,
    differs: Option<Differs>,
}

impl<'m> Targets<'m> {
    /// Before hardware that follows targets as a host's registers say.
    pub fn new(
        (interface, registers): (&'m Interface, &'m RegisterPlan),
        (plan, setting): (TrackPlan, TrackSetting),
        scans: &'m [Vec<TrackedScan>],
        photons: &'m dyn Fn(u64) -> Windows<'m>,
    ) -> Result<Targets<'m>, ReferenceError> {
        Ok(Targets {
            interface,
            registers,
            plan,
            setting,
            scans,
            photons,
            scout: ReferenceModel::new(interface.clone())?,
            clock: 0,
            level: LevelPainter::new(interface.lanes()),
            host: Host::new(0, vec![STATUS]),
            ahead: VecDeque::new(),
            pulses: VecDeque::new(),
            resets: Vec::new(),
            hosts: Vec::new(),
            done: 0,
            differs: None,
        })
    }

    /// Clocks in which all targets are done, at most.
    pub fn clocks(&self) -> u64 {
        let of_target = |scans: &Vec<TrackedScan>| {
            let last = scans.last().map_or(0, |last| last.chips + self.scan_clocks(last));
            RESET_CLOCKS + self.preparation_clocks() + last + self.decision_clocks() + HOST_CLOCKS
        };
        RESET_CLOCKS + HOST_CLOCKS + self.scans.iter().map(of_target).sum::<u64>()
    }

    /// # Errors
    /// When the hardware has shown anything else than the simulation, or has not come to all targets.
    pub fn end(self) -> Result<(), Differs> {
        match self.differs {
            Some(differs) => Err(differs),
            None if self.done < self.scans.len() => {
                Err(self.differs(0, "no end of it".to_owned(), "one of many".to_owned()))
            }
            None => Ok(()),
        }
    }

    fn differs(&self, scan: usize, shown: String, expected: String) -> Differs {
        Differs { target: self.done, scan, shown, expected }
    }

    /// Clocks from scans being wanted to a scan's first word, at most.
    fn preparation_clocks(&self) -> u64 {
        self.interface.start_clocks() + self.interface.timing.preparation_chips + STRIDE_CLOCKS
    }

    fn scan_clocks(&self, scan: &TrackedScan) -> u64 {
        scan.steps * self.interface.timing.scan.integration_chips
    }

    /// From a scan's last word to where what follows of it is decided, and can be read.
    fn decision_clocks(&self) -> u64 {
        let last = self.interface.result_latency_clocks.max(self.interface.peak_latency_clocks());
        u64::from(last + self.plan.decision_clocks()) + STRIDE_CLOCKS
    }

    /// Goes on to a clock.
    fn advance(&mut self, until: u64, resets: Vec<Range<u64>>, host: HostClocks) {
        let clocks = self.clock..until;
        let end = self.interface.timing.sampling().first_sample(until);
        let seen = self.pulses.len();
        while let Some(pulse) = self.ahead.pop_front_if(|pulse| pulse.first < end) {
            self.pulses.push_back(pulse);
        }
        let mut hits = [Vec::new()];
        let pulses: Vec<Pulse> = self.pulses.range(seen..).copied().collect();
        self.level.paint(clocks.clone(), &pulses, |_, _| (), &mut hits[0]);
        self.resets.extend_from_slice(&resets);
        self.hosts.extend_from_slice(&host);
        let surroundings = Surroundings { clocks, resets, host, ..Surroundings::default() };
        self.scout.predict_results(&surroundings, &hits);
        self.scout.take_finished().for_each(drop);
        self.clock = until;
    }

    fn reset(&mut self) {
        self.ahead.clear();
        let clocks = self.clock..self.clock + RESET_CLOCKS;
        self.advance(clocks.end, vec![clocks], Vec::new());
    }

    /// The host does something; gives what it has read last.
    fn ask(&mut self, request: Request) -> u32 {
        self.host.ask([request]);
        let mut read = 0;
        while !self.host.is_idle() {
            let shown = self.scout.host_outputs();
            let inputs = self.host.next(&shown, |_| false);
            if shown.read_valid && inputs.read_ready {
                read = shown.read_data;
            }
            let clocks = self.clock..self.clock + 1;
            self.advance(clocks.end, Vec::new(), vec![(clocks, inputs)]);
        }
        read
    }

    /// Tracking is turned on; settings outlive the resets to come.
    fn turn_on(&mut self) {
        self.reset();
        let number = self.registers.track_setting().unwrap_or_default();
        self.ask(Request::write(setting_address(number), self.setting.word()));
    }

    /// Waits for the scan behind the one whose first word came at a clock; gives that of its own.
    fn next_scan(&mut self, before: u64) -> Option<u64> {
        let end = self.clock + self.preparation_clocks();
        while self.clock <= end {
            let position = self.scout.position();
            if position.is_scan() && position.first_word() > before {
                return (position.first_word() >= self.clock).then_some(position.first_word());
            }
            self.advance(self.clock + STRIDE_CLOCKS, Vec::new(), Vec::new());
        }
        None
    }

    /// A target's scans.
    fn follow(&mut self) -> Result<(), Differs> {
        let (scans, mut windows) = (self.scans, (self.photons)(self.done as u64));
        let sampling = self.interface.timing.sampling();
        self.reset();
        let (mut origin, mut first_word) = (None, self.clock);
        for (number, scan) in scans[self.done].iter().enumerate() {
            let begins = self.next_scan(first_word);
            first_word = begins.unwrap_or(self.clock);
            let chips = begins.map(|begins| begins - *origin.get_or_insert(begins));
            if chips != Some(scan.chips) {
                let shown = format!("a scan after {chips:?} chips");
                return Err(self.differs(number, shown, format!("one after {}", scan.chips)));
            }
            let start = sampling.first_sample(first_word);
            self.ahead.extend(windows.pulses(scan.steps, scan.chips, scan.lit, start));
            let decided = first_word + self.scan_clocks(scan) + self.decision_clocks();
            self.advance(decided, Vec::new(), Vec::new());
            let position = self.ask(Request::Read { address: self.registers.position_address() });
            let status = self.ask(Request::Read { address: STATUS });
            let flag = |bit: u32| status >> bit & 1 == 1;
            let shown = TargetState {
                position: scan.after.position.map(|_| position.into()),
                is_locked: flag(state::LOCKED),
                is_lost: flag(state::LOCK_LOST),
            };
            if shown != scan.after {
                let [shown, expected] = [shown, scan.after].map(|place| format!("{place:?}"));
                return Err(self.differs(number, shown, expected));
            }
            if shown.is_lost {
                self.ask(Request::write(STATUS, 1 << state::LOCK_LOST));
            }
        }
        Ok(())
    }
}

impl Stimulus for Targets<'_> {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        if self.clock == 0 {
            self.turn_on();
        }
        while self.clock < clocks.end && self.done < self.scans.len() && self.differs.is_none() {
            match self.follow() {
                Ok(()) => self.done += 1,
                Err(differs) => self.differs = Some(differs),
            }
        }
        let end = self.interface.timing.sampling().first_sample(clocks.end);
        while let Some(pulse) = self.pulses.pop_front_if(|pulse| pulse.first < end) {
            drive.pulses[0].push(pulse);
        }
        self.resets.retain(|reset| reset.end > clocks.start);
        self.hosts.retain(|(host, _)| host.end > clocks.start);
        drive.surroundings.resets.clone_from(&self.resets);
        let hosts = self.hosts.iter().take_while(|(host, _)| host.start < clocks.end);
        drive.surroundings.host.extend(hosts.cloned());
    }
}
