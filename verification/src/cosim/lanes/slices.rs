//! How the clocks of a scan are shared out among lanes.

use std::ops::Range;

use super::Unfit;
use crate::reference::stimulus::{RESET_CLOCKS, clocks_for_scans};
use crate::sensor::interface::Interface;

/// The part of a run that one lane clocks: whole groups of phase steps, and of the
/// last lane what follows them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Slice {
    /// Its first group.
    pub(super) group: u64,
    /// Its clocks; group g begins with clock g D, so that the first slice begins with
    /// the reset.
    pub(super) clocks: Range<u64>,
}

impl Slice {
    /// How many clocks it has.
    pub(super) fn length(&self) -> u64 {
        self.clocks.end - self.clocks.start
    }
}

/// The slices of a run, and what comes before each but the first.
#[derive(Debug, Clone)]
pub(super) struct Slices {
    /// In order; they cover the run.
    pub(super) list: Vec<Slice>,
    /// Groups that a lane clocks to warm up.
    pub(super) warm_up_groups: u64,
    /// Clocks of a group.
    pub(super) group_clocks: u64,
}

/// First clock that takes a word of a scan's first group: a word comes a clock behind
/// its chip.
pub(super) const FIRST_WORD: u64 = RESET_CLOCKS + 1;

impl Slices {
    /// Shares out `clocks` clocks among at most `lanes` lanes.
    ///
    /// # Errors
    /// When the run is too short, or longer than one scan.
    pub(super) fn of(interface: &Interface, clocks: u64, lanes: u64) -> Result<Slices, Unfit> {
        let group_clocks = interface.timing.scan.integration_chips;
        let latency = settling_clocks(interface);
        let warm_up_groups = 2 + latency.div_ceil(group_clocks);
        if clocks > clocks_for_scans(interface, 1) {
            return Err(Unfit::new("the run is longer than one scan"));
        }
        // Whole groups; what follows the last belongs to its lane.
        let groups = interface.groups().min(clocks / group_clocks);
        let lanes = lanes.min(groups / (2 * warm_up_groups).max(1));
        if lanes < 2 {
            return Err(Unfit::new(format!(
                "the run has {groups} groups of phase steps; lanes need at least {}",
                4 * warm_up_groups
            )));
        }
        let mut list = Vec::new();
        let mut group = 0;
        for lane in 0..lanes {
            let end = groups / lanes * (lane + 1) + (groups % lanes).min(lane + 1);
            let last = lane + 1 == lanes;
            list.push(Slice {
                group,
                clocks: group * group_clocks..if last { clocks } else { end * group_clocks },
            });
            group = end;
        }
        Ok(Slices { list, warm_up_groups, group_clocks })
    }

    /// Clocks that each lane but the first runs before its slice: from the first word
    /// of an earlier group on.
    pub(super) fn warm_up_clocks(&self) -> u64 {
        self.warm_up_groups * self.group_clocks - FIRST_WORD
    }
}

/// Clocks after which nothing of the samples is left on its way to the counts, the
/// peak and the stream.
pub(super) fn settling_clocks(interface: &Interface) -> u64 {
    let peak = interface.peak_latency_clocks();
    let beats = interface.beats_of_group();
    u64::from(interface.result_latency_clocks.max(peak)) + beats + 8
}
