//! What the receiver of the results does: when it takes them, and when it lets them wait.

use std::ops::Range;

use rand::RngExt;

use super::Adversarial;
use super::hits::length;
use crate::reference::planned::{LONGEST_HOLD, ReceiverPlan};
use crate::sensor::histogram::CLOCKS_TO_ROW;

impl Adversarial {
    /// What the receiver does from the arrival of the last results to that of the next.
    pub(super) fn decide_receiver(&mut self, receiver: ReceiverPlan, origin: u64, next: u64) {
        let Some((arrived, beats)) = self.arrival else {
            return;
        };
        // No stall can begin in what is decided.
        let from = (arrived + 1).max(origin);
        let histogram = self.interface.histogram();
        // Of histograms in two memories it is decided before the first row shows whether it
        // is read.
        let next = match histogram.is_some_and(|plan| plan.takes_turns()) {
            true => next - u64::from(CLOCKS_TO_ROW),
            false => next,
        };
        let sends_at_once = histogram.is_some_and(|plan| !plan.takes_turns());
        match receiver {
            ReceiverPlan::Takes => self.stall_idly(from + beats + 1..next.saturating_sub(1)),
            // Until a reset that follows has begun.
            ReceiverPlan::Stalls => self.stall(from..next + 8),
            ReceiverPlan::Holds { beat } => {
                self.hold(from + beat.min(beats - 1));
            }
            ReceiverPlan::HoldsEach { beat } => {
                let mut at = self.hold(from + beat.min(beats - 1)) + 1;
                for _ in beat + 1..beats {
                    self.stall(at..at + 1);
                    at += 2;
                }
            }
            ReceiverPlan::StopsAt { beat, clocks } => self.stall(from + beat..next + clocks),
            ReceiverPlan::HoldsAcross { beat } => {
                let beat = beat.min(beats - 1);
                let more = length(&mut self.rng, 8);
                self.stall(from + beat..next + 1 + more);
            }
            // Rows that leave one a clock do not wait for each other.
            ReceiverPlan::TakesLastAfter { clocks } if sends_at_once => {
                self.stall(from + beats - 1..next + clocks);
            }
            ReceiverPlan::TakesLastAfter { clocks } => {
                self.stall(from..(next + clocks + 1).saturating_sub(beats));
            }
            ReceiverPlan::Random => self.stall_by_chance(from..next),
        }
    }

    /// Nothing is ready to be taken, and nobody to take it.
    fn stall_idly(&mut self, clocks: Range<u64>) {
        if clocks.start < clocks.end && self.rng.random_bool(0.25) {
            let start = self.rng.random_range(clocks.clone());
            let end = start + length(&mut self.rng, clocks.end - start);
            self.stall(start..end);
        }
    }

    fn stall(&mut self, clocks: Range<u64>) {
        let from = clocks.start.max(self.stalls_until).max(self.decided);
        if from < clocks.end {
            self.stalls_until = clocks.end + 1;
            self.stalls.push_back(from..clocks.end);
        }
    }

    /// Holds what stands at a clock for some; gives the first at which it is taken.
    fn hold(&mut self, clock: u64) -> u64 {
        let end = clock + 1 + length(&mut self.rng, LONGEST_HOLD - 1);
        self.stall(clock..end);
        end
    }

    fn stall_by_chance(&mut self, clocks: Range<u64>) {
        match self.rng.random_range(0..4) {
            0 | 1 => {}
            2 => self.stall(clocks.start..clocks.end + 1),
            _ => {
                let longest = clocks.end.saturating_sub(clocks.start).max(1);
                let mut at = clocks.start;
                for _ in 0..8 {
                    let from = at + length(&mut self.rng, longest) - 1;
                    at = from + length(&mut self.rng, longest);
                    self.stall(from..at);
                    at += 1;
                }
            }
        }
    }
}
