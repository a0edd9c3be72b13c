//! Inputs chosen to hurt: sample words at the edge of what the hardware must
//! stand, a consumer that stalls, resets in the middle.
//!
//! The run is a chain of episodes of random length, each with one pattern. The
//! first part of the run has no reset, so that at least one whole scan and the
//! start of the next are reached; after that resets come at random.

use std::collections::VecDeque;
use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::stimulus::{Drive, RESET_CLOCKS, Stimulus, clocks_for_scans, scan_start};
use crate::photons::Pulse;
use crate::scan::Group;
use crate::sensor::contract::Contract;

/// Longest run that is chosen when the user asks for no number of clocks.
const LONGEST_DEFAULT: u64 = 20_000_000;

/// What an episode does to the samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Pattern {
    /// High on every other sample: the most hits there can be.
    EveryOther { odd: bool },
    /// High throughout: no hit but the first.
    AllHigh,
    /// Low throughout.
    AllLow,
    /// Edges at word borders only, every other word high.
    WordBorders,
    /// Rising edge on the first lane of every word, high until the last but one.
    FirstLane,
    /// Rising edge on the last lane of every word.
    LastLane,
    /// Every hit where the present reference has one sign: the largest count.
    OneSided {
        up: bool,
        /// Which of the steps at once, so that each has its turn.
        lane: u64,
    },
    /// Runs of random length.
    Random { longest: u64 },
}

/// The adversary.
pub struct Adversarial {
    rng: Xoshiro256PlusPlus,
    contract: Contract,
    calm_until: u64,
    /// Resets and stalls that have been decided, in order.
    resets: VecDeque<Range<u64>>,
    stalls: VecDeque<Range<u64>>,
    /// For each detector the pulses that have been decided, in order of their
    /// first sample.
    pulses: Vec<VecDeque<Pulse>>,
    /// First clock that is not decided yet.
    decided: u64,
    /// End of the last reset decided.
    released: u64,
}

impl Adversarial {
    /// An adversary. A shorter run is the start of a longer one.
    pub fn new(contract: &Contract, seed: u64) -> Adversarial {
        Adversarial {
            rng: Xoshiro256PlusPlus::seed_from_u64(seed),
            contract: contract.clone(),
            calm_until: Self::default_clocks(contract) / 2,
            resets: std::iter::once(0..RESET_CLOCKS).collect(),
            stalls: VecDeque::new(),
            pulses: vec![VecDeque::new(); contract.reference_codes.len()],
            decided: RESET_CLOCKS,
            released: RESET_CLOCKS,
        }
    }

    /// Clocks after which a scene's adversary has done its worst: two scans in
    /// peace and as long again with resets, or the longest that is reasonable.
    pub fn default_clocks(contract: &Contract) -> u64 {
        clocks_for_scans(contract, 2)
            .saturating_mul(2)
            .clamp(20_000, LONGEST_DEFAULT)
    }

    /// A length between 1 and `longest` clocks, each decade as likely as another.
    fn length(&mut self, longest: u64) -> u64 {
        let decades: f64 = self.rng.random();
        (longest as f64).powf(decades) as u64
    }

    fn decide_episode(&mut self) {
        // Several results long, so that a stall can lose some, but short enough
        // that a run sees many patterns.
        let between_results = scan_start(&self.contract, 1).div_ceil(self.contract.groups());
        let start = self.decided;
        let longest = between_results.saturating_mul(6).clamp(16, 1 << 16);
        let mut end = start + self.length(longest);
        if start >= self.calm_until && self.rng.random_bool(0.3) {
            let reset = start..start + self.length(8);
            end = end.max(reset.end + 1);
            self.released = reset.end;
            self.resets.push_back(reset);
        }
        self.decide_stalls(start..end);
        for detector in 0..self.pulses.len() {
            let pattern = self.pattern();
            self.decide_pulses(detector, pattern, start..end);
        }
        self.decided = end;
    }

    fn pattern(&mut self) -> Pattern {
        match self.rng.random_range(0..12) {
            0 => Pattern::EveryOther { odd: false },
            1 => Pattern::EveryOther { odd: true },
            2 => Pattern::AllHigh,
            3 => Pattern::AllLow,
            4 => Pattern::WordBorders,
            5 => Pattern::FirstLane,
            6 => Pattern::LastLane,
            7 | 8 => Pattern::OneSided {
                up: self.rng.random(),
                lane: self
                    .rng
                    .random_range(0..u64::from(self.contract.parallel())),
            },
            _ => Pattern::Random {
                longest: 1 + self.length(3 * u64::from(self.contract.lanes())),
            },
        }
    }

    fn decide_stalls(&mut self, clocks: Range<u64>) {
        let dwell = self.contract.timing.scan.integration_chips;
        let mut at = clocks.start;
        match self.rng.random_range(0..4) {
            // A consumer that always takes, and one that never does.
            0 | 1 => {}
            2 => self.stalls.push_back(clocks),
            _ => {
                while at < clocks.end {
                    let from = at + self.length(2 * dwell) - 1;
                    let until = (from + self.length(2 * dwell)).min(clocks.end);
                    if from < until {
                        self.stalls.push_back(from..until);
                    }
                    at = until.max(at) + 1;
                }
            }
        }
    }

    fn decide_pulses(&mut self, detector: usize, pattern: Pattern, clocks: Range<u64>) {
        let lanes = u64::from(self.contract.lanes());
        let samples = clocks.start * lanes..clocks.end * lanes;
        let out = &mut self.pulses[detector];
        let mut pulse = |first: u64, end: u64| out.push_back(Pulse { first, end });
        match pattern {
            Pattern::EveryOther { odd } => (samples.start + u64::from(odd)..samples.end)
                .step_by(2)
                .for_each(|s| pulse(s, s + 1)),
            Pattern::AllHigh => pulse(samples.start, samples.end),
            Pattern::AllLow => {}
            Pattern::WordBorders => clocks
                .step_by(2)
                .for_each(|c| pulse(c * lanes, (c + 1) * lanes)),
            Pattern::FirstLane => {
                clocks.for_each(|c| pulse(c * lanes, c * lanes + (lanes - 1).max(1)));
            }
            Pattern::LastLane => clocks.for_each(|c| pulse((c + 1) * lanes - 1, (c + 1) * lanes)),
            Pattern::OneSided { up, lane } => {
                let mut s = samples.start;
                while s < samples.end {
                    if self.sign_is_up(detector, lane, s) == Some(up) {
                        self.pulses[detector].push_back(Pulse {
                            first: s,
                            end: s + 1,
                        });
                        s += 1;
                    }
                    s += 1;
                }
            }
            Pattern::Random { longest } => {
                let mut s = samples.start + self.rng.random_range(0..=longest);
                while s < samples.end {
                    let end = s + self.rng.random_range(1..=longest);
                    self.pulses[detector].push_back(Pulse { first: s, end });
                    s = end + self.rng.random_range(1..=longest);
                }
            }
        }
    }

    /// The reference's sign at a sample for one of the steps at once, if a scan
    /// is running then.
    fn sign_is_up(&self, detector: usize, lane: u64, sample: u64) -> Option<bool> {
        let lanes = u64::from(self.contract.lanes());
        let cycle = (sample / lanes).checked_sub(self.released + 1)?;
        let in_scan = cycle % scan_start(&self.contract, 1);
        let group = Group(in_scan / self.contract.timing.scan.integration_chips);
        if group.0 >= self.contract.groups() {
            return None;
        }
        let step = self.contract.grouping().step_of(group, lane);
        let phase_step = self.contract.timing.scan.phase_step(step);
        let code = &self.contract.reference_codes[detector];
        let period = code.len() * lanes;
        let in_period = (cycle % code.len()) * lanes + sample % lanes;
        let chip = (in_period + period - phase_step) % period / lanes;
        Some(code.chips[chip as usize] == 1)
    }
}

impl Stimulus for Adversarial {
    fn drive(&mut self, drive: &mut Drive) {
        let clocks = drive.surroundings.clocks.clone();
        while self.decided < clocks.end {
            self.decide_episode();
        }
        let lanes = u64::from(self.contract.lanes());
        for (decided, pulses) in self.pulses.iter_mut().zip(&mut drive.pulses) {
            while let Some(pulse) = decided.pop_front_if(|p| p.first < clocks.end * lanes) {
                pulses.push(pulse);
            }
        }
        // What reaches beyond the block is told again in the next.
        let tell = |queue: &mut VecDeque<Range<u64>>, out: &mut Vec<Range<u64>>| {
            while queue.pop_front_if(|r| r.end <= clocks.start).is_some() {}
            out.extend(queue.iter().take_while(|r| r.start < clocks.end).cloned());
        };
        tell(&mut self.resets, &mut drive.surroundings.resets);
        tell(&mut self.stalls, &mut drive.surroundings.stalls);
    }
}
