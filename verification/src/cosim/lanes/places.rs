//! Where a scan and its codes stand at the first word of a group.
//!
//! A generator's registers follow from the chip at which its code stands. At a group's first
//! word that is known, however long a group is: all codes have gone on by a chip a clock, and a
//! reference has waited for each chip of its phase step's delay.

use serde::{Deserialize, Serialize};

use crate::scan::Group;
use crate::sensor::interface::Interface;

/// Numbers that a register may count in binary: the group and its phase step, of the group, the one
/// behind it and the one before it.
pub(super) fn numbers(interface: &Interface, group: u64) -> Vec<u64> {
    let near = [0, 1, -1].map(|ahead| group.saturating_add_signed(ahead));
    let phase_step = |group: &u64| {
        let step = interface.grouping().step_of(Group(*group), 0);
        interface.timing.scan.phase_step(step)
    };
    let steps = near.iter().map(phase_step);
    near.iter().copied().chain(steps).collect()
}

/// A code, and which delay it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct CodePlace {
    /// Chips of the code.
    pub(super) period: u64,
    /// Groups by which its delay is that of a later group, or of an earlier one; none
    /// if it has no delay.
    delay_ahead: Option<i64>,
}

impl CodePlace {
    /// All that a register may follow.
    pub(super) fn all(interface: &Interface) -> Vec<CodePlace> {
        let codes = interface.source_codes.iter().chain(&interface.reference_codes);
        let mut periods: Vec<u64> = codes.map(|code| code.len()).collect();
        periods.sort_unstable();
        periods.dedup();
        let delays = [None, Some(0), Some(1), Some(-1)];
        let of_period = |period| delays.map(|delay_ahead| CodePlace { period, delay_ahead });
        periods.into_iter().flat_map(of_period).collect()
    }

    /// The chip at a group's first word, counted from the one that stands
    /// `clocks_on` clocks behind the first group's first word, as long as that group's delay holds.
    pub(super) fn chip(self, interface: &Interface, group: u64, clocks_on: u64) -> u64 {
        let scan = &interface.timing.scan;
        let lanes = u64::from(interface.lanes());
        let delay_chips = |group: u64| {
            let step = interface.grouping().step_of(Group(group), 0);
            scan.phase_step(step) / lanes % self.period
        };
        let later = self.delay_ahead.map_or(0, |ahead| {
            let delay = delay_chips(group.saturating_add_signed(ahead));
            delay + self.period - delay_chips(0)
        });
        let gone = u128::from(group) * u128::from(scan.integration_chips);
        let gone = (gone % u128::from(self.period)) as u64;
        (gone + 3 * self.period - later - clocks_on % self.period) % self.period
    }
}
