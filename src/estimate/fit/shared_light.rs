//! Phase steps that count the same light, several at once.
//!
//! They have one total count, and signed counts that know of each other: every step's
//! signs differ from its neighbour's near the edges of the reference only. So a group's
//! counts are weighed together, with their covariances.

use super::problem::Problem;
use crate::response::{GroupMoments, SecondMoments};
use crate::scan::{Group, Step};

/// Problems of so many steps are weighed group by group.
const MOST_STEPS: u64 = 512;

/// Steps of a problem that count the same light.
#[derive(Debug, Clone)]
pub struct SharedSteps {
    /// Their places among the problem's steps.
    pub places: Vec<usize>,
    /// Moments of their counts.
    pub moments: GroupMoments,
}

/// Whether a problem of so many steps is weighed group by group, where steps are
/// `parallel` at once.
pub fn are_weighed_together(steps: u64, parallel: u32) -> bool {
    parallel > 1 && steps <= MOST_STEPS
}

impl Problem<'_> {
    /// Whether the steps are weighed group by group.
    pub fn has_shared_steps(&self) -> bool {
        are_weighed_together(self.steps.len() as u64, self.model.timing.parallel)
    }

    /// Moments of the steps' counts, group by group.
    pub fn shared_steps(&self, second: &SecondMoments) -> Vec<SharedSteps> {
        let grouping = self.model.timing.grouping();
        let mut groups: Vec<(Group, Vec<usize>)> = Vec::new();
        for (place, &step) in self.steps.iter().enumerate() {
            let group = grouping.group_of(step);
            match groups.last_mut() {
                Some((last, places)) if *last == group => places.push(place),
                _ => groups.push((group, vec![place])),
            }
        }
        let of_group = |(_, places): (Group, Vec<usize>)| {
            let steps: Vec<Step> = places.iter().map(|&place| self.steps[place]).collect();
            SharedSteps {
                moments: second.of_steps_together(&steps),
                places,
            }
        };
        groups.into_iter().map(of_group).collect()
    }
}

impl SharedSteps {
    /// The same steps where they expect other counts: covariances go with the
    /// detections, and those with the total with the signed counts.
    pub fn expecting(&self, signed_means: Vec<f64>, total_mean: f64) -> SharedSteps {
        let there = &self.moments;
        let share = total_mean / there.total_mean.max(f64::MIN_POSITIVE);
        let mut covariance = there.covariance.clone();
        covariance.iter_mut().flatten().for_each(|c| *c *= share);
        let total = self.places.len();
        for (lane, (here, there)) in signed_means.iter().zip(&there.signed_means).enumerate() {
            let with_total = covariance[lane][total] + here - there * share;
            covariance[lane][total] = with_total;
            covariance[total][lane] = with_total;
        }
        SharedSteps {
            places: self.places.clone(),
            moments: GroupMoments {
                signed_means,
                total_mean,
                covariance,
            },
        }
    }
}
