//! Second moments of the counts of a problem's steps, and the weights that follow from them.
//!
//! Steps that share their light have one total count, and correlated signed counts:
//! a step's signs differ from its neighbour's only near the edges of the reference. So a
//! group's counts are weighted together, with their covariances.
//!
//! Of a long scan the moments of few steps stand for all. At the own code's peaks they are
//! taken step by step, or group by group. Elsewhere the reference's signs are as good as random
//! beside the light, and moments per detection depend on where in a chip the reference's edges
//! are, and hardly on the chip.

use std::sync::Arc;

use super::parameters::FitParameters;
use super::problem::Problem;
use super::slipping::SlippingLight;
use super::template::DelayAxis;
use super::weights::Weights;
use crate::response::{CountMoments, GroupMoments, MeanCount, SecondMoments};
use crate::scan::Step;

/// From this many steps on, second moments of all steps of the scan at once cost
/// less than step by step.
const STEPS_FOR_SCAN_MOMENTS: usize = 60;

/// Second moments of a problem's counts.
pub enum ProblemMoments {
    /// Of each step, where it counts light of its own.
    Alone(Vec<StepMomentsPerDetection>),
    /// Of each group of steps that share their light.
    Shared(Vec<GroupMoments>),
}

impl ProblemMoments {
    pub fn of(problem: &Problem, second: &SecondMoments) -> ProblemMoments {
        if problem.shares_light() {
            let of_group = |places: Vec<usize>| {
                let steps: Vec<Step> = places.iter().map(|&place| problem.steps[place]).collect();
                second.of_steps_together(&steps)
            };
            return ProblemMoments::Shared(problem.groups().into_iter().map(of_group).collect());
        }
        let all = problem.takes_all_steps() && problem.steps.len() > STEPS_FOR_SCAN_MOMENTS;
        let moments = if all { second.of_scan() } else { second.of_steps(&problem.steps) };
        ProblemMoments::Alone(moments.iter().map(StepMomentsPerDetection::from_moments).collect())
    }
}

/// Second moments of one step's counts, per expected detection.
#[derive(Debug, Clone, Copy)]
pub struct StepMomentsPerDetection {
    signed_mean: f64,
    signed_variance: f64,
    total_variance: f64,
    covariance: f64,
}

impl StepMomentsPerDetection {
    /// Those of a step with some moments.
    pub fn from_moments(moments: &CountMoments) -> StepMomentsPerDetection {
        let detections = moments.total_mean.max(f64::MIN_POSITIVE);
        StepMomentsPerDetection {
            signed_mean: moments.signed_mean / detections,
            signed_variance: moments.signed_variance / detections,
            total_variance: moments.total_variance / detections,
            covariance: moments.covariance / detections,
        }
    }

    /// Moments of a step that expects `mean`: what r shares with N goes with r as N's
    /// variance goes with N.
    pub fn expecting(&self, mean: &MeanCount) -> CountMoments {
        let more = mean.signed - self.signed_mean * mean.total;
        CountMoments {
            signed_mean: mean.signed,
            total_mean: mean.total,
            signed_variance: self.signed_variance * mean.total,
            total_variance: self.total_variance * mean.total,
            covariance: self.covariance * mean.total + self.total_variance * more,
        }
    }

    fn mean(all: &[&StepMomentsPerDetection]) -> StepMomentsPerDetection {
        let mean = |of: fn(&StepMomentsPerDetection) -> f64| {
            all.iter().map(|moments| of(moments)).sum::<f64>() / all.len() as f64
        };
        StepMomentsPerDetection {
            signed_mean: mean(|m| m.signed_mean),
            signed_variance: mean(|m| m.signed_variance),
            total_variance: mean(|m| m.total_variance),
            covariance: mean(|m| m.covariance),
        }
    }
}

/// The same of a group whose steps, at some places, expect `means`.
fn expecting(known: &GroupMoments, places: &[usize], means: &[MeanCount]) -> GroupMoments {
    let known = known.of_first(places.len());
    let signed_means: Vec<f64> = places.iter().map(|&place| means[place].signed).collect();
    let total_mean = means[places[0]].total;
    let detections = known.total_mean.max(f64::MIN_POSITIVE);
    let share = total_mean / detections;
    let mut covariance = known.covariance;
    let total = places.len();
    let total_variance = covariance[total][total] / detections;
    covariance.iter_mut().flatten().for_each(|c| *c *= share);
    for (lane, (here, there)) in signed_means.iter().zip(&known.signed_means).enumerate() {
        covariance[lane][total] += total_variance * (here - there * share);
        covariance[total][lane] = covariance[lane][total];
    }
    GroupMoments { signed_means, total_mean, covariance }
}

/// Means of the moments of groups, of those with the most steps.
fn mean_of_groups(groups: &[&GroupMoments]) -> GroupMoments {
    let steps = groups.iter().map(|group| group.signed_means.len()).max().unwrap_or(0);
    let whole = groups.iter().filter(|group| group.signed_means.len() == steps);
    let whole: Vec<&GroupMoments> = whole.copied().collect();
    let mean = |of: &dyn Fn(&GroupMoments) -> f64| {
        whole.iter().map(|moments| of(moments)).sum::<f64>() / whole.len() as f64
    };
    let row = |a: usize| (0..=steps).map(|b| mean(&|m| m.covariance[a][b])).collect();
    GroupMoments {
        signed_means: (0..steps).map(|lane| mean(&|m| m.signed_means[lane])).collect(),
        total_mean: mean(&|m| m.total_mean),
        covariance: (0..=steps).map(row).collect(),
    }
}

/// Which steps' moments stand for those of a long scan.
struct Choice {
    /// Chips to either side of a peak in which none but its own stand for a step's.
    reach_chips: f64,
    /// Phases of a chip that are told apart elsewhere.
    phases: usize,
    /// Steps, or groups of steps, of each phase.
    of_phase: usize,
}

impl Choice {
    /// Steps elsewhere, at least; twice as many that share their light.
    const STEPS_AWAY: usize = 12;
    const MOST_PHASES: usize = 8;

    fn of(samples_per_chip: usize, parallel: usize) -> Choice {
        let (reach_chips, phases, steps) = match parallel {
            1 => (1.5, samples_per_chip.min(Choice::MOST_PHASES), Choice::STEPS_AWAY),
            _ => (1.0, 1, 2 * Choice::STEPS_AWAY),
        };
        Choice { reach_chips, phases, of_phase: steps.div_ceil(phases * parallel).max(2) }
    }
}

/// How many steps' moments stand for a long scan's, with so many own peaks.
pub fn few_steps(samples_per_chip: u32, parallel: u32, peaks: f64) -> f64 {
    let choice = Choice::of(samples_per_chip as usize, parallel as usize);
    let parallel = f64::from(parallel);
    let near = 2.0 * (choice.reach_chips * f64::from(samples_per_chip) + parallel) - 1.0;
    peaks * near + (choice.phases * choice.of_phase) as f64 * parallel
}

/// Groups of steps whose moments stand for those of all: of a short scan each for itself.
struct Few {
    /// Their steps.
    steps: Vec<Step>,
    /// Of each group of the problem: which class it is of.
    class_of: Vec<usize>,
    /// Of each class, those of the few whose mean stands for it.
    classes: Vec<Vec<usize>>,
}

impl Few {
    fn of(
        problem: &Problem,
        axis: &DelayAxis,
        parameters: &FitParameters,
        groups: &[Vec<usize>],
    ) -> Few {
        let timing = &problem.model.timing;
        let samples = axis.samples_per_chip as usize;
        let choice = Choice::of(samples, timing.parallel as usize);
        let peaks = problem.own_peaks(parameters, axis);
        let reach = choice.reach_chips * axis.samples_per_chip;
        let is_near = |&place: &usize| {
            let place = problem.place_of(problem.steps[place], axis);
            peaks.iter().any(|peak| axis.steps_apart(place - peak) <= reach)
        };
        let mut few = Few { steps: Vec::new(), class_of: Vec::new(), classes: Vec::new() };
        let mut away: Vec<Vec<usize>> = vec![Vec::new(); choice.phases];
        for (number, group) in groups.iter().enumerate() {
            if !problem.is_long() || group.iter().any(is_near) {
                few.class_of.push(choice.phases + few.classes.len());
                few.classes.push(vec![number]);
            } else {
                let phase_step = timing.scan.phase_step(problem.steps[group[0]]) as usize;
                let phase = phase_step % samples * choice.phases / samples;
                few.class_of.push(phase);
                away[phase].push(number);
            }
        }
        let spread = away.iter().map(|groups| {
            let count = choice.of_phase.min(groups.len());
            (0..count).map(|part| groups[(2 * part + 1) * groups.len() / (2 * count)]).collect()
        });
        let mut classes: Vec<Vec<usize>> = spread.collect();
        classes.append(&mut few.classes);
        let mut chosen: Vec<usize> = classes.iter().flatten().copied().collect();
        chosen.sort_unstable();
        let steps = chosen.iter().flat_map(|&group| &groups[group]);
        few.steps = steps.map(|&place| problem.steps[place]).collect();
        let number = |group: usize| chosen.partition_point(|&other| other < group);
        few.classes =
            classes.into_iter().map(|groups| groups.into_iter().map(number).collect()).collect();
        few
    }

    /// The moments of every class, from those of the few.
    fn classes<T>(&self, known: &[T], mean: impl Fn(&[&T]) -> T) -> Vec<T> {
        let of_class = |class: &Vec<usize>| {
            let members: Vec<&T> = class.iter().map(|&number| &known[number]).collect();
            mean(&members)
        };
        self.classes.iter().map(of_class).collect()
    }
}

impl Problem<'_> {
    /// What counts weigh that expect `means`: `moments` gives those of some of the steps at light
    /// nearby, and per detection they are the same. Light of other clocks is `slipping`; steps
    /// of a long scan are taken for far apart beside what slips between them.
    pub fn weights<E>(
        &self,
        axis: &DelayAxis,
        parameters: &FitParameters,
        means: &[MeanCount],
        slipping: Option<&SlippingLight>,
        moments: impl FnOnce(&Problem) -> Result<Arc<ProblemMoments>, E>,
    ) -> Result<Weights, E> {
        let groups = self.groups();
        let few = Few::of(self, axis, parameters, &groups);
        let known = moments(&Problem { steps: few.steps.clone(), ..self.clone() })?;
        let timing = &self.model.timing;
        let beside = slipping.map(|slipping| {
            |a: usize, b: usize| slipping.covariance(timing, self.steps[a], self.steps[b])
        });
        let known = match &*known {
            ProblemMoments::Alone(known) => few.classes(known, StepMomentsPerDetection::mean),
            ProblemMoments::Shared(known) => {
                let known = few.classes(known, mean_of_groups);
                let all = groups.into_iter().zip(&few.class_of).map(|(places, &class)| {
                    let moments = expecting(&known[class], &places, means);
                    (places, moments)
                });
                let all: Vec<_> = all.collect();
                return Ok(match beside {
                    None => Weights::of_groups(&all),
                    Some(beside) => Weights::of_groups_together(all, beside, self.is_long()),
                });
            }
        };
        let all = few.class_of.iter().zip(means).map(|(&class, mean)| known[class].expecting(mean));
        let mut all: Vec<CountMoments> = all.collect();
        let Some(slipping) = slipping else {
            return Ok(Weights::of(&all));
        };
        if self.is_long() {
            all.iter_mut().for_each(|step| step.signed_variance += slipping.variance());
            return Ok(Weights::of(&all));
        }
        Ok(Weights::of_steps_together(&all, |a, b| {
            slipping.covariance(timing, self.steps[a], self.steps[b])
        }))
    }
}
