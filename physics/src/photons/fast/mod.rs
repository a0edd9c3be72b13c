//! The fast photon engine: many phase steps side by side.
//!
//! It counts what [`count_step`] counts, from the same
//! distribution, an order of magnitude faster. Every vector lane simulates a
//! phase step of its own; one iteration takes every lane from the end of a dead
//! time to the next detection, and has no branch that depends on a lane.
//!
//! Why it is exact (up to whole ticks of 2^-19 chip, 24-bit numbers, and logarithms that are 4e-7 off at most,
//! 10^-8 on average):
//!
//! - `lanes`: fresh draws at the end of each dead time, because Poisson arrivals
//!   have no memory; long waits are cut, for the same reason.
//! - `excess`: the light's change of time, one exponential per arrival.
//! - `profile`: light with edges, thinned.
//! - `movement`: a path that moves, in straight pieces, each with a time of its own.
//! - `afterpulses`: all that are pending are one decaying mass.
//! - `sign`: jitter, delays and transition are a probability near edges, and
//!   nothing elsewhere; or jitter is drawn.
//! - `steps`: the start and the end of a step, where jitter carries detections
//!   over the border.
//! - `record`: where detections themselves are wanted, or jitter has a tail.
//! - `domain`: where a start is forgotten too slowly, it is drawn.
//! - `overlaps`: the level that cells make together.
//! - `members`: cells of a pixel, detectors that fire one another, and passive recharge.
//!
//! A part that the model does not have is a loop that is not entered, so leaving
//! it out changes no other number. Counts depend on seed, detector, scan and
//! step alone: neither on the number of threads nor on the vector width, as no
//! operation differs between instruction sets. Models that the lanes cannot do
//! exactly ([`OutsideDomain`]) go through the plain loop.

mod afterpulses;
mod arithmetic;
mod constant;
mod domain;
mod excess;
mod instruction_set;
mod lanes;
mod members;
mod movement;
pub(crate) mod normal;
mod overlaps;
mod pieces;
mod places;
mod profile;
mod record;
mod sign;
mod steps;
mod streams;
mod threads;

use std::num::NonZero;
use std::ops::Range;
use std::sync::Arc;
use std::thread::available_parallelism;

pub use domain::OutsideDomain;
pub use instruction_set::{InstructionSet, Runner};
pub(crate) use places::CHIP_BITS;
pub(super) use record::RegisteredSteps;
pub use record::RegisteredTicks;

use self::arithmetic::LANES;
use self::domain::Tables;
use self::record::{GroupRunner, OfCells};
use self::sign::SignTable;
use self::steps::{JobShare, StepJobs, StepRunner};
use super::counter::{StepCount, count_detections, count_step, transition};
use super::detector::DetectorModel;
use crate::scan::Group;

/// Counts phase steps `steps` of scan number `repetition`, as
/// [`count_step`] does: `out[i]` is for step
/// `steps.start + i`. One thread.
///
/// # Panics
/// If `out` has not one place for each step.
pub fn count_steps(
    model: &DetectorModel,
    seed: u64,
    repetition: u64,
    steps: Range<u64>,
    out: &mut [StepCount],
) {
    StepCounter::new(model).count(seed, repetition..repetition + 1, steps, out);
}

/// [`count_steps`] on every core, with the same counts.
///
/// # Panics
/// If `out` has not one place for each step.
pub fn count_steps_on_all_cores(
    model: &DetectorModel,
    seed: u64,
    repetition: u64,
    steps: Range<u64>,
    out: &mut [StepCount],
) {
    let threads = available_parallelism().unwrap_or(NonZero::<usize>::MIN);
    StepCounter::new(model).count_on_threads(threads, seed, repetition..repetition + 1, steps, out);
}

/// Records the detections of groups of phase steps of one detector.
#[derive(Debug, Clone)]
pub struct Recorder<'m> {
    model: &'m DetectorModel,
    tables: Result<Arc<Tables>, OutsideDomain>,
    instruction_set: InstructionSet,
}

/// Detections of all groups that are recorded at once, about, of 8 bytes each.
const MOST_RECORDED: f64 = 2e6;
/// With fewer lanes at work the plain loop is as quick.
const LEAST_LANES: usize = 4;

impl<'m> Recorder<'m> {
    /// Makes the tables of a model, and chooses the best instruction set.
    pub fn new(model: &'m DetectorModel) -> Recorder<'m> {
        let tables = Tables::new(model).map(Arc::new);
        Recorder { model, tables, instruction_set: InstructionSet::best() }
    }

    /// The same for a scan of its own: `model` differs from the recorder's in that
    /// [one has begun](DetectorModel::begin_scan).
    pub fn of_scan<'s>(&self, model: &'s DetectorModel) -> Recorder<'s> {
        Recorder { model, tables: self.tables.clone(), instruction_set: self.instruction_set }
    }

    /// Uses another instruction set.
    ///
    /// # Panics
    /// On recording, if the processor does not have it.
    pub fn with_instruction_set(self, instruction_set: InstructionSet) -> Recorder<'m> {
        Recorder { instruction_set, ..self }
    }

    /// The model.
    pub fn model(&self) -> &'m DetectorModel {
        self.model
    }

    /// Groups to record at once, so that no more than some megabytes are kept; none where that
    /// leaves too few lanes at work, or the lanes cannot do the model.
    pub fn groups_at_once(&self) -> Option<usize> {
        let chips = self.model.timing.scan.integration_chips as f64;
        let most = self.model.most_detections_of_coupled_per_chip();
        let fitting = (MOST_RECORDED / (most * chips)) as usize;
        // Twice as many groups as lanes, or lanes wait for the longest one.
        let groups = fitting.min(2 * LANES);
        (self.tables.is_ok() && groups >= LEAST_LANES).then_some(groups)
    }

    /// The registered times of some groups, each with the number of its scan: those of each
    /// group in order, from the distribution of [`DetectorModel::step`]. One thread.
    ///
    /// # Panics
    /// If there are no [`Recorder::groups_at_once`].
    pub fn record(&self, seed: u64, groups: &[(u64, Group)]) -> Vec<Vec<RegisteredTicks>> {
        let recorded = self.run(seed, groups, self.level());
        recorded.into_iter().map(|recorded| recorded.times).collect()
    }

    /// The pulses at the inputs.
    pub(super) fn record_pulses(&self, seed: u64, groups: &[(u64, Group)]) -> Vec<RegisteredSteps> {
        let each = (self.model.inputs() > 1).then_some(OfCells::Each);
        self.run(seed, groups, each.or(self.level()))
    }

    /// The cells whose level is counted, if they make one.
    fn level(&self) -> Option<OfCells<'_>> {
        let pixel = self.model.pixel.as_deref();
        pixel.filter(|pixel| pixel.law.edges() == 1).map(OfCells::Level)
    }

    fn run(
        &self,
        seed: u64,
        groups: &[(u64, Group)],
        of_cells: Option<OfCells<'_>>,
    ) -> Vec<RegisteredSteps> {
        let tables = self.tables.as_ref().unwrap_or_else(|reason| panic!("{reason}"));
        let mut runner = GroupRunner::new(self.model, tables, seed, groups, of_cells);
        self.instruction_set.run(&mut runner);
        runner.into_recorded()
    }
}

/// Counts phase steps of one detector.
#[derive(Debug, Clone)]
pub struct StepCounter<'m> {
    recorder: Recorder<'m>,
    /// `None` where counts are of recorded detections, one by one.
    sign: Option<Arc<SignTable>>,
}

impl<'m> StepCounter<'m> {
    /// Makes the tables of a model, and chooses the best instruction set.
    pub fn new(model: &'m DetectorModel) -> StepCounter<'m> {
        // Where most pulses overlap, the level is that of recorded detections.
        let makes_level = model.pixel.as_ref().filter(|pixel| pixel.law.edges() == 1);
        let is_counted = makes_level.is_none_or(|pixel| overlaps::pay(model, pixel));
        let sign = if is_counted { domain::sign_table(model) } else { None };
        StepCounter { recorder: Recorder::new(model), sign: sign.map(Arc::new) }
    }

    /// The same for a scan of its own, as [`Recorder::of_scan`].
    pub fn of_scan<'s>(&self, model: &'s DetectorModel) -> StepCounter<'s> {
        StepCounter { recorder: self.recorder.of_scan(model), sign: self.sign.clone() }
    }

    /// What it counts of.
    pub fn recorder(&self) -> &Recorder<'m> {
        &self.recorder
    }

    /// Uses another instruction set.
    ///
    /// # Panics
    /// On counting, if the processor does not have it.
    pub fn with_instruction_set(self, instruction_set: InstructionSet) -> StepCounter<'m> {
        let recorder = self.recorder.with_instruction_set(instruction_set);
        StepCounter { recorder, ..self }
    }

    /// Why the plain loop is used instead of lanes; `None` if it is not.
    pub fn outside_domain(&self) -> Option<OutsideDomain> {
        self.recorder.tables.as_ref().err().copied()
    }

    /// Counts `steps` of every scan in `repetitions`, scan after scan.
    ///
    /// # Panics
    /// If `out` has not one place for each step of each scan.
    pub fn count(
        &self,
        seed: u64,
        repetitions: Range<u64>,
        steps: Range<u64>,
        out: &mut [StepCount],
    ) {
        self.count_on_threads(NonZero::<usize>::MIN, seed, repetitions, steps, out);
    }

    /// [`StepCounter::count`] on some threads, with the same counts.
    ///
    /// # Panics
    /// If `out` has not one place for each step of each scan.
    pub fn count_on_threads(
        &self,
        threads: NonZero<usize>,
        seed: u64,
        repetitions: Range<u64>,
        steps: Range<u64>,
        out: &mut [StepCount],
    ) {
        let numbers = repetitions.end.saturating_sub(repetitions.start)
            * steps.end.saturating_sub(steps.start);
        assert_eq!(numbers, out.len() as u64, "one place for each step");
        let jobs = StepJobs { seed, first_repetition: repetitions.start, steps };
        threads::share(threads, out, |next| self.count_jobs(&jobs, next));
    }

    /// Counts the jobs of all shares that `next` gives.
    fn count_jobs<'o>(
        &self,
        jobs: &StepJobs,
        next: &mut dyn FnMut() -> Option<(u64, &'o mut [StepCount])>,
    ) {
        let Recorder { model, tables, instruction_set } = &self.recorder;
        if let (Ok(tables), Some(sign)) = (tables, &self.sign) {
            let mut next_share = || next().map(|(first, places)| JobShare { first, places });
            let mut runner = StepRunner::new(model, tables, sign, jobs, &mut next_share);
            return instruction_set.run(&mut runner);
        }
        while let Some((first, places)) = next() {
            match self.recorder.groups_at_once() {
                Some(groups) => self.count_recorded(groups, jobs, first, places),
                None => {
                    for (number, place) in (first..).zip(places) {
                        let (repetition, step) = jobs.repetition_and_step(number);
                        *place = count_step(model, jobs.seed, repetition, step);
                    }
                }
            }
        }
    }

    /// Counts jobs from the registered times of their groups, some groups at a time.
    fn count_recorded(
        &self,
        at_once: usize,
        jobs: &StepJobs,
        first: u64,
        places: &mut [StepCount],
    ) {
        let model = self.recorder.model;
        let steps = (first..).zip(places).map(|(number, place)| {
            let (repetition, step) = jobs.repetition_and_step(number);
            ((repetition, model.timing.grouping().group_of(step)), step, place)
        });
        let steps: Vec<_> = steps.collect();
        let mut groups: Vec<_> = steps.iter().map(|(group, ..)| *group).collect();
        groups.dedup();
        let mut steps = steps.into_iter().peekable();
        for groups in groups.chunks(at_once) {
            let lists = self.recorder.record(jobs.seed, groups);
            for (group, list) in groups.iter().zip(&lists) {
                while let Some((_, step, place)) = steps.next_if(|(of, ..)| of == group) {
                    let detections = list.iter().map(|time| time.detection());
                    let mut transition = transition(model, jobs.seed, group.0, step);
                    *place = count_detections(model, group.0, step, &mut transition, detections);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::code::{Code, Generator};
    use crate::photons::afterpulsing::Afterpulsing;
    use crate::photons::light::ExcessLight;
    use crate::photons::light::LightRates;
    use crate::photons::paths::NumberedPath;
    use crate::scene;
    use crate::scene::{DetectorIndex, PathIndex};
    use crate::sensor::Sensor;

    fn table_i() -> DetectorModel {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/paper-single.toml");
        let mut scene = scene::load(&file).expect("the scene is sound");
        scene.sources[0].mean_power_w *= 3.0;
        DetectorModel::new(&Sensor::new(&scene), DetectorIndex(0))
    }

    fn counts(counter: &StepCounter) -> Vec<StepCount> {
        let mut counts = vec![StepCount::ZERO; 100];
        counter.count(1, 0..1, 0..100, &mut counts);
        assert!(counter.outside_domain().is_none());
        assert!(counts.iter().any(|count| count.total > 0));
        counts
    }

    /// A part left out against the same part, at work but neutral.
    fn assert_same(without: &DetectorModel, neutral: &DetectorModel) {
        let [without, neutral] = [without, neutral].map(|m| counts(&StepCounter::new(m)));
        assert_eq!(without, neutral);
    }

    #[test]
    fn afterpulses_of_no_number_change_nothing() {
        let mut without = table_i();
        without.afterpulsing = None;
        let mut neutral = without.clone();
        neutral.afterpulsing =
            Some(Afterpulsing { mean_per_avalanche: 0.0, time_constant_chips: 0.6 });
        assert_same(&without, &neutral);
    }

    #[test]
    fn constant_light_of_no_rate_changes_nothing() {
        let mut without = table_i();
        without.constant_per_chip = 0.0;
        let mut neutral = without.clone();
        neutral.constant_per_chip = 1e-300;
        assert_same(&without, &neutral);
    }

    #[test]
    fn a_path_without_light_changes_nothing() {
        let without = table_i();
        let mut neutral = without.clone();
        let chips = vec![1; 89];
        let code =
            Arc::new(Code { generator: Generator::Chips(chips.clone()), interleave: 0, chips });
        let rates = LightRates { on_hz: 1e-290, off_hz: 0.0 };
        let other = NumberedPath { index: PathIndex(1), number: 1 };
        let dark = ExcessLight::new(other, rates, &code, 333.0, neutral.timing.clock, &[]);
        neutral.excess.extend(dark);
        assert_eq!(neutral.excess.len(), 2);
        assert_same(&without, &neutral);
    }

    #[test]
    fn jitter_of_no_width_and_a_draw_that_decides_nothing_change_nothing() {
        let mut without = table_i();
        without.jitter_chips = None;
        without.counter.transition_ps = 0.0;
        let mut neutral = without.clone();
        neutral.jitter_chips = Some(0.0);
        assert_same(&without, &neutral);

        let left_out = StepCounter::new(&without);
        let mut drawn = left_out.clone();
        let sign = Arc::make_mut(drawn.sign.as_mut().expect("the lanes can do it"));
        assert!(!sign.is_random);
        sign.is_random = true;
        assert_eq!(counts(&left_out), counts(&drawn));
    }

    #[test]
    fn each_part_left_out_leaves_the_draws_of_the_others() {
        // Jitter decides signs only, so totals stay where no border is near.
        let with = table_i();
        let mut without = with.clone();
        without.jitter_chips = None;
        let [with, without] = [&with, &without].map(|m| counts(&StepCounter::new(m)));
        let same = with.iter().zip(&without).filter(|(a, b)| a.total == b.total);
        assert!(same.count() > 90);
        assert_ne!(with, without);
    }
}
