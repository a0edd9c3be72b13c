//! Groups, resets and stalls by chance, when no cover point is left to aim at, and a host that writes and
//! reads at random. Faults that no cover point describes show here: after many scans without a reset, in
//! long stalls, where two events coincide.

use rand::{Rng, RngExt};

use super::Adversarial;
use super::hits::length;
use crate::reference::host::Request;
use crate::reference::planned::{Length, PlannedGroup, ReceiverPlan};
use crate::sensor::registers::{
    ADDRESS_BITS, CONTROL, PEAKS, RegisterPlan, STATUS, setting_address, state,
};

/// Most groups for which no reset comes by plan.
const MOST_GROUPS: u64 = 1 << 10;
/// Most requests of a host in one go.
const MOST_REQUESTS: u64 = 12;
/// Most chips of a scan that a host asks for, so that there are many scans.
const MOST_CHIPS_OF_SCAN: u64 = 1 << 13;
/// Longest stall.
const LONGEST_STALL: u64 = 1 << 13;

impl Adversarial {
    /// A group by chance, with all that may happen.
    pub(super) fn by_chance(&mut self) -> PlannedGroup {
        let mut plan = PlannedGroup::random().received(ReceiverPlan::Random);
        let longest = 2 * u64::from(self.interface.result_latency_clocks) + 8;
        if self.aims.groups_without_reset > 0 {
            self.aims.groups_without_reset -= 1;
        } else if self.rng.random_bool(0.01) {
            self.aims.groups_without_reset = self.rng.random_range(0..MOST_GROUPS);
        } else if self.rng.random_bool(0.15) {
            let age = length(&mut self.rng, longest) - 1;
            plan = plan.after_reset(age, length(&mut self.rng, 8));
        }
        plan.left_to_the_last = self.rng.random_bool(0.1).then_some(0);
        if self.rng.random_bool(0.02) {
            plan.length = Length::AtLeast(4096);
            if self.rng.random_bool(0.5) {
                plan.receiver = ReceiverPlan::Stalls;
            }
        }
        if self.rng.random_bool(0.002) {
            let clocks = length(&mut self.rng, LONGEST_STALL);
            plan.receiver = ReceiverPlan::StopsAt { beat: 0, clocks };
        }
        if let Some(registers) = &self.interface.registers
            && self.rng.random_bool(0.3)
        {
            plan.asks = talk(registers, &mut self.rng);
        }
        plan
    }
}

/// Anything that a host may write and read, most of it so that there are scans.
pub(super) fn talk(plan: &RegisterPlan, rng: &mut impl Rng) -> Vec<Request> {
    let requests = length(rng, MOST_REQUESTS);
    (0..requests).flat_map(|_| some(plan, rng)).collect()
}

fn some(plan: &RegisterPlan, rng: &mut impl Rng) -> Vec<Request> {
    vec![match rng.random_range(0..20) {
        0..3 => return scan(plan, rng),
        3..8 => {
            let setting = rng.random_range(2..plan.settings());
            let data = value(plan, setting, rng);
            Request::Write { address: setting_address(setting), data, strobe: strobe(rng) }
        }
        8..11 => {
            let run = u32::from(rng.random_bool(0.7)) << state::RUN;
            let single = u32::from(rng.random_bool(0.3)) << state::SINGLE;
            // No other bit does anything.
            let others = junk(rng) & !(1 << state::RUN | 1 << state::SINGLE);
            Request::Write { address: CONTROL, data: run | single | others, strobe: strobe(rng) }
        }
        11..13 => Request::Write { address: STATUS, data: rng.random(), strobe: strobe(rng) },
        13..16 => Request::Read { address: any_address(plan, rng) },
        16 | 17 => {
            // Not how long scans are.
            let address = any_address(plan, rng);
            let is_length = [0, 1].map(setting_address).contains(&address);
            let strobe = if is_length { 0 } else { strobe(rng) };
            Request::Write { address, data: junk(rng), strobe }
        }
        18 => Request::Wait { clocks: length(rng, 16 * plan.least_chips) },
        _ => Request::Wait { clocks: length(rng, 2 * MOST_CHIPS_OF_SCAN) },
    }]
}

/// Chips and groups of scans that are not long, in whatever order they are taken over; three of ten do
/// not fit.
fn scan(plan: &RegisterPlan, rng: &mut impl Rng) -> Vec<Request> {
    let least = plan.least_chips;
    let chips = match rng.random_range(0..4) {
        0 => rng.random_range(0..least),
        1 => rng.random_range(least..1 << plan.chips_bits),
        _ => least + rng.random_range(0..2 * least),
    };
    let chips = chips & ((1 << plan.chips_bits) - 1);
    let most = (MOST_CHIPS_OF_SCAN / chips.max(1)).clamp(1, (1 << plan.groups_bits) - 1);
    let groups = match plan.whole_groups.filter(|&whole| whole <= most) {
        Some(whole) if rng.random_bool(0.3) => whole,
        _ if rng.random_bool(0.1) => 0,
        _ => length(rng, most + 1),
    };
    let beyond = |value: u64, bits: u32, rng: &mut _| {
        value as u32 | junk(rng).checked_shl(bits).unwrap_or(0)
    };
    vec![
        Request::write(setting_address(1), 1),
        Request::write(setting_address(0), beyond(chips, plan.chips_bits, rng)),
        Request::write(setting_address(1), beyond(groups, plan.groups_bits, rng)),
    ]
}

/// An address of a register, and now and then one that differs from it by a bit.
fn any_address(plan: &RegisterPlan, rng: &mut impl Rng) -> u32 {
    let address = match rng.random_range(0..6) {
        0 => 4 * rng.random_range(0..1 << plan.word_bits()),
        1 | 2 => setting_address(rng.random_range(0..plan.settings())),
        3 => PEAKS + 4 * rng.random_range(0..=plan.readings()),
        4 => CONTROL,
        _ => STATUS,
    };
    match rng.random_bool(0.5) {
        true => address ^ 1 << rng.random_range(2..ADDRESS_BITS),
        false => address,
    }
}

/// Whole words mostly.
fn strobe(rng: &mut impl Rng) -> u8 {
    if rng.random_bool(0.85) { 0xf } else { rng.random_range(0..0xf) }
}

/// Nothing, or any bits.
fn junk(rng: &mut impl Rng) -> u32 {
    if rng.random_bool(0.5) { 0 } else { rng.random() }
}

/// A value of a setting that is not of a scan's length; bits above those that the hardware keeps are
/// of any value.
fn value(plan: &RegisterPlan, setting: usize, rng: &mut impl Rng) -> u32 {
    match setting {
        _ if rng.random_bool(0.1) => 0,
        2 if rng.random_bool(0.7) => {
            let chips = rng.random_range(0..plan.period_chips);
            ((chips << plan.sample_bits) as u32) | rng.random_range(0..1 << plan.sample_bits)
        }
        _ => rng.random(),
    }
}
