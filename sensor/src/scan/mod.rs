//! How a scan is divided: its steps, the groups of them that share their light,
//! and [`Timing`], which says when each of them is.
//!
//! The numbers of steps, of groups, of chips and of samples are types of their own. With
//! one phase step at a time the first two are equal, with one sample in a chip the last
//! two, and a wrong one would show only with several.
//!
//! ```
//! # mod goldtof {
//! #     pub use goldtof_sensor::*;
//! # }
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))?;
//! use std::path::Path;
//!
//! let scene = goldtof::scene::load(Path::new("scenes/quick.toml"))?;
//! let timing = scene.timing();
//! assert_eq!(timing.code_chips(), 31);
//! assert_eq!(timing.clock.sample_period_ps(), 1000.0); // 8 samples in a chip of 8 ns
//! assert_eq!(timing.groups(), 248); // one phase step at a time
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod chip;
mod sample;
mod sampler;
mod timescale;
mod timing;

use std::ops::Range;

pub use chip::Chip;
pub use sample::{Sample, Sampling};
pub use sampler::Sampler;
pub use timescale::Timescale;
pub use timing::{CHIPS_TO_PREPARATION, Clock, PERIODS_OF_PREPARATION, Scan, Timing};

/// Number of a step in its scan, from 0. It is not the phase step k of the
/// reference, which [`Scan::phase_step`] gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Step(pub u64);

/// Number of a group in its scan, from 0: the steps that the hardware correlates
/// at once, which see the same light at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Group(pub u64);

impl Step {
    /// The step whose counts stand at `index` of a scan's.
    pub fn at(index: usize) -> Step {
        Step(index as u64)
    }

    /// Where the step's counts stand among its scan's.
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// Every step of a scan of `steps`.
    pub fn all(steps: u64) -> impl DoubleEndedIterator<Item = Step> + ExactSizeIterator {
        (0..steps as usize).map(Step::at)
    }
}

/// How the steps of a scan form groups.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grouping {
    /// Steps of a scan.
    pub steps: u64,
    /// Steps of a group; the last group may have fewer.
    pub parallel: u64,
}

impl Grouping {
    /// Groups of a scan.
    pub fn groups(&self) -> u64 {
        self.steps.div_ceil(self.parallel)
    }

    /// The group that a step belongs to.
    pub fn group_of(&self, step: Step) -> Group {
        Group(step.0 / self.parallel)
    }

    /// The step that `lane` correlates in a group.
    pub fn step_of(&self, group: Group, lane: u64) -> Step {
        Step(group.0 * self.parallel + lane)
    }

    /// The steps of a group.
    pub fn steps_of(&self, group: Group) -> impl ExactSizeIterator<Item = Step> + use<> {
        let first = group.0 * self.parallel;
        let steps: Range<usize> = first as usize..(first + self.parallel).min(self.steps) as usize;
        steps.map(Step::at)
    }

    /// Steps of the last group.
    pub fn steps_of_last(&self) -> u64 {
        self.steps_of(Group(self.groups() - 1)).len() as u64
    }

    /// Whether the last group has as many steps as the others.
    pub fn is_even(&self) -> bool {
        self.steps.is_multiple_of(self.parallel)
    }

    /// Whether `group` is the last of a scan.
    pub fn is_last(&self, group: Group) -> bool {
        group.0 + 1 == self.groups()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_in_one_group_and_the_last_may_be_short() {
        for (steps, parallel, groups, last) in [(12, 4, 3, 4), (13, 4, 4, 1), (5, 5, 1, 5)] {
            let grouping = Grouping { steps, parallel };
            assert_eq!(grouping.groups(), groups);
            let all: Vec<Step> =
                (0..groups).flat_map(|group| grouping.steps_of(Group(group))).collect();
            assert!(all.into_iter().eq(Step::all(steps)));
            assert_eq!(grouping.steps_of(Group(groups - 1)).len() as u64, last);
            assert!(grouping.is_last(grouping.group_of(Step(steps - 1))));
            assert_eq!(grouping.is_even(), last == parallel);
            let lane = 2.min(last - 1);
            let step = grouping.step_of(Group(groups - 1), lane);
            assert_eq!(grouping.group_of(step), Group(groups - 1));
        }
    }
}
