//! Phase steps that count the same light, several at once.
//!
//! They have one total count, and signed counts that know of each other: every step's
//! signs differ from its neighbour's near the edges of the reference only. So a group's
//! counts are weighed together, with their covariances. Of a long scan those of the groups
//! at the own code's peaks are worked out, and a few others stand for the rest, for away
//! from the peaks the reference's signs are as good as random.

use std::sync::Arc;

use super::problem::Problem;
use super::shared_steps::SharedSteps;
use super::template::Axis;
use super::weights::Weights;
use crate::response::{GroupMoments, MeanCount, SecondMoments};
use crate::scan::{Group, Step};

/// Steps of a long scan away from all peaks whose moments are taken, and groups at least.
const STEPS_AWAY: usize = 24;
const GROUPS_AWAY: usize = 2;

impl Problem<'_> {
    /// Moments of the steps' counts, group by group.
    pub fn shared_steps(&self, second: &SecondMoments) -> Vec<SharedSteps> {
        let of_group = |places: Vec<usize>| {
            let steps: Vec<Step> = places.iter().map(|&place| self.steps[place]).collect();
            SharedSteps { moments: second.of_steps_together(&steps), places }
        };
        self.groups().into_iter().map(of_group).collect()
    }

    /// Places of the steps of each group.
    fn groups(&self) -> Vec<Vec<usize>> {
        let grouping = self.model.timing.grouping();
        let mut groups: Vec<(Group, Vec<usize>)> = Vec::new();
        for (place, &step) in self.steps.iter().enumerate() {
            let group = grouping.group_of(step);
            match groups.last_mut() {
                Some((last, places)) if *last == group => places.push(place),
                _ => groups.push((group, vec![place])),
            }
        }
        groups.into_iter().map(|(_, places)| places).collect()
    }
}

/// Weights of steps whose groups' moments are known at some light near that which
/// expects `means`.
pub fn weights_of_all(known: &[SharedSteps], means: &[MeanCount]) -> Weights {
    let here: Vec<SharedSteps> = known.iter().map(|group| group.expecting(means)).collect();
    Weights::of_groups(&here)
}

/// Weights of a long scan. `peaks` are the places of the own code's on the axis,
/// and `moments` gives those of a problem of few groups.
pub fn weights_of_scan<E>(
    problem: &Problem,
    axis: &Axis,
    peaks: &[f64],
    means: &[MeanCount],
    moments: impl FnOnce(&Problem) -> Result<Arc<[SharedSteps]>, E>,
) -> Result<Weights, E> {
    let groups = problem.groups();
    let is_near = |places: &Vec<usize>| {
        places.iter().any(|&place| {
            let place = problem.place_of(problem.steps[place], axis);
            peaks.iter().any(|peak| axis.shape(place - peak) > 0.0)
        })
    };
    let (near, away): (Vec<usize>, Vec<usize>) =
        (0..groups.len()).partition(|&group| is_near(&groups[group]));
    let spread = spread_over(&away, problem.model.timing.parallel as usize);
    let mut chosen = [near.clone(), spread.clone()].concat();
    chosen.sort_unstable();
    let few = Problem {
        steps: chosen
            .iter()
            .flat_map(|&group| groups[group].iter().map(|&place| problem.steps[place]))
            .collect(),
        ..problem.clone()
    };
    let found = moments(&few)?;
    let of_group = |group: &usize| chosen.binary_search(group).ok().map(|at| &found[at]);
    let others: Vec<&SharedSteps> = spread.iter().filter_map(of_group).collect();
    let away = mean_of(&others);
    let all = groups.iter().enumerate().map(|(number, places)| {
        let moments = match (near.binary_search(&number), of_group(&number), &away) {
            (Ok(_), Some(own), _) | (_, Some(own), None) => own.moments.clone(),
            (_, _, Some(away)) => away.of_first(places.len()),
            // Without any away from the peaks, all groups are near.
            (_, None, None) => GroupMoments::default(),
        };
        let group = SharedSteps { places: places.clone(), moments };
        group.expecting(means)
    });
    Ok(Weights::of_groups(&all.collect::<Vec<_>>()))
}

/// Few of some groups, evenly apart.
fn spread_over(groups: &[usize], parallel: usize) -> Vec<usize> {
    let wanted = STEPS_AWAY.div_ceil(parallel).max(GROUPS_AWAY);
    let count = wanted.min(groups.len());
    (0..count).map(|part| groups[(2 * part + 1) * groups.len() / (2 * count)]).collect()
}

/// Means of the moments of groups, of those with the most steps; `None` of none.
fn mean_of(groups: &[&SharedSteps]) -> Option<GroupMoments> {
    let steps = groups.iter().map(|group| group.places.len()).max()?;
    let whole = groups.iter().filter(|group| group.places.len() == steps);
    let whole: Vec<&GroupMoments> = whole.map(|group| &group.moments).collect();
    let mean = |of: &dyn Fn(&GroupMoments) -> f64| {
        whole.iter().map(|moments| of(moments)).sum::<f64>() / whole.len() as f64
    };
    let row = |a: usize| (0..=steps).map(|b| mean(&|m| m.covariance[a][b])).collect();
    Some(GroupMoments {
        signed_means: (0..steps).map(|lane| mean(&|m| m.signed_means[lane])).collect(),
        total_mean: mean(&|m| m.total_mean),
        covariance: (0..=steps).map(row).collect(),
    })
}
