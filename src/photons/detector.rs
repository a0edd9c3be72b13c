//! What one detector sees of a scene, in chips.

use std::sync::Arc;

use rand::RngExt;

use super::afterpulsing::Afterpulsing;
use super::light::{ExcessLight, LightRates};
use super::movement::Movement;
use super::paths::{number_of, paths_to};
use super::random::{Part, StreamKey};
use super::step::StepDetections;
use crate::code::Code;
use crate::scan::{Group, Grouping, Step};
use crate::scene::{CounterTiming, Scan, Scene};

/// The ready-made numbers behind every phase step of one detector.
///
/// Light is split into the *excess* on-light of each path and one constant
/// process that holds everything else: off-light, background, dark counts.
/// Parts with a neutral parameter do not exist here, and draw nothing.
#[derive(Debug, Clone)]
pub struct DetectorModel {
    /// What its random streams are told apart by.
    number: u64,
    pub(crate) scan: Scan,
    /// The phase steps that share their light.
    grouping: Grouping,
    pub(crate) samples_per_chip: u32,
    pub(crate) reference: Arc<Code>,
    /// Excess on-light, one entry per path that has any.
    pub(crate) excess: Vec<ExcessLight>,
    /// Rate of the constant light per chip.
    pub(crate) constant_per_chip: f64,
    pub(crate) dead_time_chips: f64,
    pub(crate) afterpulsing: Option<Afterpulsing>,
    pub(crate) delay_chips: f64,
    /// Standard deviation of all jitters together; `None` if zero.
    pub(crate) jitter_chips: Option<f64>,
    pub(crate) pulse_width_chips: f64,
    pub(crate) counter: CounterTiming,
    pub(crate) chip_period_ps: f64,
    pub(crate) warm_up_chips: i64,
    /// Chips from the start of one scan to the start of the next.
    scan_pitch_chips: u128,
}

/// Jitter is cut at this many standard deviations (probability 1.5e-23), so
/// that the reorder buffer is bounded.
pub(crate) const JITTER_BOUND_SIGMAS: f64 = 10.0;

/// Longest warm-up.
const MOST_WARM_UP_DEAD_TIMES: f64 = 1e5;

impl DetectorModel {
    /// The model of detector `detector` (an index into the scene's detectors).
    ///
    /// # Panics
    /// If the scene has no such detector.
    pub fn new(scene: &Scene, detector: usize) -> DetectorModel {
        let spad = &scene.detectors[detector];
        let chips = |ps: f64| ps / scene.chip_period_ps;
        let per_chip = |hz: f64| hz * scene.chip_period_ps * 1e-12;

        let mut excess: Vec<ExcessLight> = Vec::new();
        let mut constant_hz =
            spad.background_rate_cps * spad.photon_detection_probability + spad.dark_count_rate_cps;
        for numbered in paths_to(scene, detector) {
            let path = &scene.paths[numbered.index];
            let source = &scene.sources[path.source];
            let rates = LightRates::of(source, path, spad);
            constant_hz += rates.off_hz;
            let light = ExcessLight::new(
                numbered,
                rates,
                &source.code,
                path.delay_ps,
                scene.chip_period_ps,
                &excess,
            );
            let movement = Movement::new(path, scene.chip_period_ps);
            excess.extend(light.map(|light| light.moving(movement)));
        }

        let reference = scene.sources[spad.reference].code.clone();
        let jitter_ps = spad.jitter_ps.iter().map(|s| s * s).sum::<f64>().sqrt();
        let mut model = DetectorModel {
            number: number_of(&spad.name),
            scan: scene.scan,
            grouping: scene.grouping(),
            samples_per_chip: scene.samples_per_chip,
            excess,
            constant_per_chip: per_chip(constant_hz),
            dead_time_chips: chips(spad.dead_time_ps),
            afterpulsing: Afterpulsing::new(
                spad.afterpulsing_probability,
                chips(spad.afterpulsing_time_constant_ps),
            ),
            delay_chips: chips(spad.delay_ps),
            jitter_chips: (jitter_ps > 0.0).then(|| chips(jitter_ps)),
            pulse_width_chips: chips(spad.pulse_width_ps),
            counter: spad.counter,
            chip_period_ps: scene.chip_period_ps,
            warm_up_chips: 0,
            scan_pitch_chips: 0,
            reference,
        };
        model.warm_up_chips = model.warm_up();
        model.scan_pitch_chips = model.scan_pitch();
        model
    }

    /// The scene's paths that carry modulated light to this detector, in order.
    pub fn modulated_paths(&self) -> impl Iterator<Item = usize> + '_ {
        self.excess.iter().map(|light| light.path)
    }

    /// Simulates the light of a group of steps of scan number `repetition`. The result depends on the arguments alone.
    pub fn step(&self, seed: u64, repetition: u64, group: Group) -> StepDetections<'_> {
        StepDetections::new(self, self.key(seed, repetition, group))
    }

    pub(crate) fn key(&self, seed: u64, repetition: u64, group: Group) -> StreamKey {
        StreamKey {
            seed,
            detector: self.number,
            group,
            repetition,
        }
    }

    /// Groups of a scan: the `parallel` phase steps of a group see the same
    /// light at the same time.
    pub fn groups(&self) -> u64 {
        self.grouping.groups()
    }

    /// The group that a step of the scan belongs to.
    pub fn group_of(&self, step: Step) -> Group {
        self.grouping.group_of(step)
    }

    /// Steps that a group may have.
    pub fn parallel(&self) -> u64 {
        self.grouping.parallel
    }

    /// The steps of a group; the last group may have fewer than the others.
    pub fn steps_of_group(&self, group: Group) -> impl ExactSizeIterator<Item = Step> + use<> {
        self.grouping.steps_of(group)
    }

    /// Whether scans follow one another without a gap: when the reference ends
    /// where it began.
    pub(crate) fn runs_on(&self) -> bool {
        self.scan.is_full() && self.grouping.is_even()
    }

    /// Index, in the running transmit code, of the first chip of a group.
    ///
    /// Scans over the whole code period follow one another without a gap; after
    /// any other scan the hardware waits for the reference's next first chip.
    pub fn first_chip(&self, repetition: u64, group: Group) -> u128 {
        u128::from(repetition) * self.scan_pitch_chips
            + u128::from(group.0) * u128::from(self.scan.integration_chips)
    }

    /// Chips from the start of a scan to the start of a group of phase steps.
    pub(crate) fn start_in_scan(&self, group: Group) -> i64 {
        let chips = u128::from(group.0) * u128::from(self.scan.integration_chips);
        i64::try_from(chips).unwrap_or(i64::MAX)
    }

    /// How far the delay of a path moves within a scan, and how far it may for
    /// paths to count as standing still: a thousandth of a phase step. In chips.
    pub(crate) fn movement_in_scan(&self) -> (f64, f64) {
        let scan_chips = self.groups() as f64 * self.scan.integration_chips as f64;
        let movements = self
            .excess
            .iter()
            .filter_map(|light| light.movement.as_ref());
        let moved = movements
            .map(|movement| movement.range_chips(scan_chips))
            .fold(0.0, f64::max);
        (moved, 1e-3 / f64::from(self.samples_per_chip))
    }

    /// Position in a code of `length` chips at which a group starts.
    pub(crate) fn code_position(&self, repetition: u64, group: Group, length: u64) -> i64 {
        (self.first_chip(repetition, group) % u128::from(length)) as i64
    }

    /// Dead time, in chips.
    pub fn dead_time_chips(&self) -> f64 {
        self.dead_time_chips
    }

    /// How long before a step its simulation starts.
    pub fn warm_up_chips(&self) -> i64 {
        self.warm_up_chips
    }

    /// Chip period T_c.
    pub fn chip_period_ps(&self) -> f64 {
        self.chip_period_ps
    }

    /// Samples per chip, S.
    pub fn samples_per_chip(&self) -> u32 {
        self.samples_per_chip
    }

    /// The code that the detections are correlated with.
    pub fn reference(&self) -> &Arc<Code> {
        &self.reference
    }

    /// Standard deviation of all jitters together, in chips.
    pub fn jitter_chips(&self) -> f64 {
        self.jitter_chips.unwrap_or(0.0)
    }

    /// The scan that the model's steps belong to.
    pub fn scan(&self) -> &Scan {
        &self.scan
    }

    /// How long before a step its simulation starts, so that the step does not
    /// remember.
    ///
    /// A saturated detector fires like a clock, and forgets its start after the
    /// square of (rate x dead time) dead times. Where that is too long, it starts
    /// as if it had run before ([`Self::first_ready_chips`]).
    fn warm_up(&self) -> i64 {
        let dead_times = self.dead_times_to_forget().min(MOST_WARM_UP_DEAD_TIMES);
        let afterpulsing = self.afterpulsing.map_or(0.0, |a| a.time_constant_chips);
        let memory = (dead_times * self.dead_time_chips).max(30.0 * afterpulsing);
        let jitter = self.jitter_chips.unwrap_or(0.0);
        // At least a fixed margin, so that small delays and jitters do not move
        // the start, and with it every arrival.
        let margin = (self.delay_chips + 2.0 * JITTER_BOUND_SIGMAS * jitter).max(4.0);
        let chips = memory + margin;
        chips.ceil() as i64
    }

    fn dead_times_to_forget(&self) -> f64 {
        let excess_per_chip: f64 = self.excess.iter().map(|light| light.rate_per_chip).sum();
        let saturation = (self.constant_per_chip + excess_per_chip) * self.dead_time_chips;
        32.0 + 2.0 * saturation * saturation
    }

    /// When the detector is first ready, in chips after its simulation starts.
    ///
    /// At once, if the warm-up makes it forget. Else anywhere within a dead time,
    /// with equal chance: under constant light the wait for the end of a dead time
    /// that is going on has that distribution, and the detector is ready for only
    /// 1 / (rate x dead time) of the time, less than half a per cent here.
    pub(crate) fn first_ready_chips(&self, key: &StreamKey) -> f64 {
        if self.dead_times_to_forget() <= MOST_WARM_UP_DEAD_TIMES {
            return 0.0;
        }
        let share: f64 = key.stream(Part::Start).random();
        share * self.dead_time_chips
    }

    fn scan_pitch(&self) -> u128 {
        let scan_chips = u128::from(self.groups()) * u128::from(self.scan.integration_chips);
        if self.runs_on() {
            scan_chips
        } else {
            scan_chips.next_multiple_of(u128::from(self.reference.len()))
        }
    }
}
