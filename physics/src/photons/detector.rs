//! What one detector sees of a sensor, in chips.

use std::sync::Arc;

use rand::RngExt;

use super::afterpulsing::Afterpulsing;
use super::dead_time::DeadTime;
use super::light::{ExcessLight, LightRates};
use super::memory::DetectorMemory;
use super::movement::{PathMovement, Trajectory};
use super::paths::{number_of, paths_to};
use super::random::{RandomStream, StreamKey, scatter};
use super::shape::PulseShape;
use super::tail::Tail;
use crate::code::Code;
use crate::scan::{Chip, Group, Sampler, Timing};
use crate::scene::{CellOutputs, CounterTiming, Detector, DetectorIndex, PathIndex};
use crate::sensor::Sensor;
use crate::sensor::cells::Cells;

/// The ready-made numbers behind every phase step of one detector.
///
/// Light is split into the *excess* on-light of each path and one constant
/// process that holds everything else: off-light, background, dark counts.
/// Parts with a neutral parameter do not exist here, and draw nothing.
#[derive(Debug, Clone)]
pub struct DetectorModel {
    /// What its random streams are told apart by.
    number: u64,
    pub timing: Timing,
    pub reference: Arc<Code>,
    /// Excess on-light, one entry per path that has any.
    pub excess: Vec<ExcessLight>,
    /// Rate of the background per chip.
    pub constant_per_chip: f64,
    pub dead_time_chips: f64,
    /// Whether each arrival within the dead time begins it anew.
    pub(crate) is_paralyzable: bool,
    pub(crate) afterpulsing: Option<Afterpulsing>,
    pub(crate) delay_chips: f64,
    /// Standard deviation of all jitters together; `None` if zero.
    pub jitter_chips: Option<f64>,
    /// What detections are late beside that.
    pub(crate) tail: Option<Tail>,
    /// How light of each code of the scene follows it.
    shapes: Vec<(Arc<Code>, Arc<PulseShape>)>,
    pub pulse_width_chips: f64,
    /// When the pulses are sampled.
    pub sampler: Sampler,
    pub(crate) counter: CounterTiming,
    pub(crate) warm_up_chips: i64,
    /// The detectors whose crosstalk it hears.
    pub(crate) crosstalk: Option<Arc<Coupled>>,
    /// Its cells, where it has several; all else here is of them together.
    pub(crate) pixel: Option<Arc<DetectorCells>>,
    /// Where its groups stand, if not one scan after another.
    pub(crate) anchor: Option<Anchor>,
}

/// The cells of a detector that has several.
#[derive(Debug, Clone)]
pub struct DetectorCells {
    pub cells: Vec<DetectorModel>,
    /// What their pulses make of the level.
    pub law: Cells,
    /// Whether the hardware has an input for each.
    has_outputs: bool,
    pub pulse_width_chips: f64,
    /// Chance that an avalanche fires one of the other cells, and how much later.
    pub crosstalk: Option<(f64, f64)>,
}

impl DetectorCells {
    /// Inputs of the hardware: one for each cell that has an output.
    pub fn inputs(&self) -> usize {
        if self.has_outputs { self.cells.len() } else { 1 }
    }

    /// Whether all cells have the same light and dark counts.
    pub fn is_even(&self) -> bool {
        self.cells.windows(2).all(|two| two[0].constant_per_chip == two[1].constant_per_chip)
    }

    /// The cells of a detector; none of one that is a single SPAD.
    pub fn of(sensor: &Sensor, detector: DetectorIndex, number: u64) -> Option<Arc<DetectorCells>> {
        let spad = &sensor.scene().detectors[detector];
        let cells = (0..spad.cells).filter(|_| spad.cells > 1).map(|cell| {
            let of_cell = spad.cell(cell);
            DetectorModel::of_spad(sensor, detector, &of_cell, scatter(number, cell.into()))
        });
        let cells: Vec<_> = cells.collect();
        let chips = |ps: f64| sensor.clock().chips(ps);
        (!cells.is_empty()).then(|| {
            Arc::new(DetectorCells {
                cells,
                law: Cells::of(spad),
                has_outputs: spad.cell_outputs == CellOutputs::Separate,
                pulse_width_chips: chips(spad.pulse_width_ps),
                crosstalk: spad
                    .cell_crosstalk
                    .map(|talk| (talk.probability, chips(talk.delay_ps)))
                    .filter(|(probability, _)| *probability > 0.0),
            })
        })
    }
}

/// A scan whose first group has a number, and begins at a time, of its own: the light goes on, and the codes begin anew.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Anchor {
    /// Its first group.
    group: Group,
    /// Chips from the first scan's start to it.
    chips: u64,
}

/// One way of crosstalk, from one detector of some to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    pub from: usize,
    pub to: usize,
    pub probability: f64,
    pub delay_chips: f64,
}

/// Detectors that fire one another, in the scene's order.
#[derive(Debug, Clone)]
pub struct Coupled {
    /// All of them. That of the one itself has no light here: whoever simulates it has it.
    pub models: Vec<Option<DetectorModel>>,
    /// Which it is.
    pub own: usize,
    pub links: Vec<Link>,
}

impl Coupled {
    /// The detectors that fire one another, a detector among them; none where it is alone. It is
    /// the same set for each of them, so that they see one history of all.
    pub fn to(sensor: &Sensor, detector: DetectorIndex) -> Option<Arc<Coupled>> {
        let scene = sensor.scene();
        let talks = |of: DetectorIndex| scene.detectors[of].crosstalk();
        let mut members = vec![detector];
        let mut next = 0;
        while let Some(&member) = members.get(next) {
            next += 1;
            for neighbour in scene.neighbours(member) {
                let is_coupled = talks(member).is_some() || talks(neighbour).is_some();
                if is_coupled && !members.contains(&neighbour) {
                    members.push(neighbour);
                }
            }
        }
        if members.len() == 1 {
            return None;
        }
        members.sort_unstable();
        let place = |of: DetectorIndex| members.iter().position(|member| *member == of);
        let links = members.iter().enumerate().flat_map(|(from, &member)| {
            let talk = talks(member);
            let to = scene.neighbours(member).filter_map(place);
            to.filter_map(move |to| {
                let talk = talk?;
                let delay_chips = sensor.clock().chips(talk.delay_ps);
                Some(Link { from, to, probability: talk.probability, delay_chips })
            })
        });
        let alone = |&member: &DetectorIndex| {
            (member != detector).then(|| DetectorModel::alone(sensor, member))
        };
        Some(Arc::new(Coupled {
            models: members.iter().map(alone).collect(),
            own: place(detector).unwrap_or_default(),
            links: links.collect(),
        }))
    }

    /// Those whose avalanches fire the one itself, and how.
    pub fn heard(&self) -> impl Iterator<Item = (&Link, &DetectorModel)> {
        let here = self.links.iter().filter(|link| link.to == self.own);
        here.filter_map(|link| Some((link, self.models[link.from].as_ref()?)))
    }

    /// Other detectors.
    pub fn others(&self) -> impl Iterator<Item = &DetectorModel> {
        self.models.iter().flatten()
    }

    /// Bound on the avalanches that others cause at the detector, per chip.
    pub fn most_per_chip(&self) -> f64 {
        let of = |(link, source): (&Link, &DetectorModel)| {
            link.probability * source.most_of_dead_time_per_chip()
        };
        self.heard().map(of).sum()
    }
}

/// Jitter is cut at this many standard deviations (probability 1.5e-23), so
/// that the reorder buffer is bounded.
pub(crate) const JITTER_BOUND_SIGMAS: f64 = 10.0;

/// What a pending afterpulse costs at each avalanche, in detections of the plain loop.
const PENDING_WORK: f64 = 0.02;
/// What looking for the next avalanche costs for each cell, in the same.
const LOOK_WORK: f64 = 0.05;

impl DetectorModel {
    /// The model of detector `detector` (an index into the scene's detectors).
    ///
    /// # Panics
    /// If the scene has no such detector.
    pub fn new(sensor: &Sensor, detector: DetectorIndex) -> DetectorModel {
        let mut model = DetectorModel::alone(sensor, detector);
        model.crosstalk = Coupled::to(sensor, detector);
        let detectors = &sensor.scene().detectors;
        if detectors.iter().any(|spad| spad.crosstalk().is_some()) {
            // All of them start at one time, so that each sees the others as they see themselves.
            let all = DetectorIndex::of(detectors);
            let delay_ps = detectors.iter().filter_map(|spad| Some(spad.crosstalk?.delay_ps));
            let delay_chips = sensor.clock().chips(delay_ps.fold(0.0, f64::max)).ceil() as i64;
            let longest = all.map(|other| DetectorModel::alone(sensor, other).warm_up_chips);
            model.warm_up_chips = longest.max().unwrap_or(0) + delay_chips;
        }
        model
    }

    /// The model of a detector that hears no other one.
    pub(crate) fn alone(sensor: &Sensor, detector: DetectorIndex) -> DetectorModel {
        let spad = &sensor.scene().detectors[detector];
        let number = number_of(&spad.name);
        let mut model = DetectorModel::of_spad(sensor, detector, spad, number);
        model.pixel = DetectorCells::of(sensor, detector, number);
        model
    }

    /// The model of one SPAD in the place of a detector, with random numbers of its own.
    pub(crate) fn of_spad(
        sensor: &Sensor,
        detector: DetectorIndex,
        spad: &Detector,
        number: u64,
    ) -> DetectorModel {
        let clock = sensor.clock();
        let chips = |ps: f64| clock.chips(ps);

        let shapes: Vec<(Arc<Code>, Arc<PulseShape>)> = sensor
            .scene()
            .sources
            .iter()
            .map(|source| {
                let shape = PulseShape::new(&source.response, clock);
                (Arc::clone(&source.code), Arc::new(shape))
            })
            .collect();
        let mut excess: Vec<ExcessLight> = Vec::new();
        let mut constant_hz =
            spad.background_rate_cps * spad.photon_detection_probability + spad.dark_count_rate_cps;
        for numbered in paths_to(sensor, detector) {
            let path = &sensor.scene().paths[numbered.index];
            let source = &sensor.scene().sources[path.source];
            let rates = LightRates::of(source, path, spad, clock);
            constant_hz += rates.off_hz;
            let light =
                ExcessLight::new(numbered, rates, &source.code, path.delay_ps, clock, &excess);
            let movement = PathMovement::new(path, source, clock);
            let shape = Arc::clone(&shapes[path.source.0].1);
            excess.extend(light.map(|light| light.moving(movement).shaped(shape)));
        }

        let reference = sensor.scene().sources[spad.reference].code.clone();
        let jitter_ps = spad.jitter_std_ps();
        let mut model = DetectorModel {
            number,
            timing: *sensor.timing(),
            excess,
            constant_per_chip: clock.per_chip(constant_hz),
            dead_time_chips: chips(spad.dead_time_ps),
            is_paralyzable: spad.is_paralyzable(),
            afterpulsing: Afterpulsing::new(
                spad.afterpulsing_probability,
                chips(spad.afterpulsing_time_constant_ps),
            ),
            delay_chips: chips(spad.delay_ps),
            jitter_chips: (jitter_ps > 0.0).then(|| chips(jitter_ps)),
            tail: Tail::new(&spad.jitter_tail, clock),
            shapes,
            pulse_width_chips: chips(spad.pulse_width_ps),
            sampler: spad.sampler.clone(),
            counter: spad.counter,
            warm_up_chips: 0,
            crosstalk: None,
            pixel: None,
            anchor: None,
            reference,
        };
        model.warm_up_chips = model.warm_up();
        model
    }

    /// The scene's paths that carry modulated light to this detector, in order.
    pub fn modulated_paths(&self) -> impl Iterator<Item = PathIndex> + '_ {
        self.synchronised().map(|light| light.path)
    }

    /// How light of a code follows it: as the scene says, and light of unknown codes
    /// as the reference's.
    pub fn shape_of(&self, code: &Code) -> Arc<PulseShape> {
        let of = |code: &Code| self.shapes.iter().find(|(known, _)| known.chips == code.chips);
        let found = of(code).or_else(|| of(&self.reference));
        found.map_or_else(|| Arc::new(PulseShape::ideal()), |(_, shape)| Arc::clone(shape))
    }

    /// Inputs that the hardware has for it: one, or one for each of its cells.
    pub fn inputs(&self) -> usize {
        self.pixel.as_ref().map_or(1, |pixel| pixel.inputs())
    }

    /// All SPADs that are simulated for it: its cells, or the detectors that fire one another
    /// with it, itself among them, in the scene's order.
    pub(crate) fn members(&self) -> Vec<&DetectorModel> {
        match (&self.pixel, &self.crosstalk) {
            (Some(pixel), _) => pixel.cells.iter().collect(),
            (None, Some(coupled)) => {
                coupled.models.iter().map(|model| model.as_ref().unwrap_or(self)).collect()
            }
            (None, None) => vec![self],
        }
    }

    /// The same, hearing nothing.
    pub(crate) fn without_crosstalk(&self) -> DetectorModel {
        DetectorModel { crosstalk: None, ..self.clone() }
    }

    /// About the detections per chip of the one of [those](Self::members) that has most, where it hears
    /// others: it is the same for each of them.
    pub(crate) fn most_detections_of_coupled_per_chip(&self) -> f64 {
        let Some(coupled) = &self.crosstalk else { return self.most_detections_per_chip() };
        let members = self.members();
        let alone = members.iter().map(|member| member.without_crosstalk());
        let alone: f64 = alone.map(|member| member.most_detections_per_chip()).sum();
        let caused = |of| {
            let links = coupled.links.iter().filter(move |link| link.from == of);
            links.map(|link| link.probability).sum::<f64>()
        };
        let caused = (0..members.len()).map(caused).fold(0.0, f64::max);
        let quickest = members.iter().map(|member| member.most_of_dead_time_per_chip());
        // Dead time ends chains of those that fire one another surely.
        (alone / (1.0 - caused).max(0.1)).min(quickest.fold(0.0, f64::max))
    }

    /// Cells whose hits are added up, each a detector of its own with as large a share of the light; 1 of
    /// any other detector.
    pub fn added_cells(&self) -> u32 {
        self.pixel.as_ref().map_or(1, |pixel| pixel.law.edges())
    }

    pub fn key(&self, seed: u64, repetition: u64, group: Group) -> StreamKey {
        StreamKey { seed, detector: self.number, group, repetition }
    }

    /// Modulated light whose code keeps its place beside the reference's.
    pub(crate) fn synchronised(&self) -> impl Iterator<Item = &ExcessLight> {
        self.excess.iter().filter(|light| !self.slips(light))
    }

    /// Modulated light of clocks of their own, which comes at every delay within a scan
    /// and so is constant on average: its mean rate per chip.
    pub(crate) fn slipping_per_chip(&self) -> f64 {
        self.slipping().map(ExcessLight::mean_per_chip).sum()
    }

    /// That light, path by path.
    pub fn slipping(&self) -> impl Iterator<Item = &ExcessLight> {
        self.excess.iter().filter(|light| self.slips(light))
    }

    /// Whether a clock runs away by a chip or more within a scan.
    fn slips(&self, light: &ExcessLight) -> bool {
        let scan_chips = self.timing.scan_chips() as f64;
        let slip = light.movement.as_ref().and_then(|movement| movement.slip);
        slip.is_some_and(|slip| slip.range_chips(scan_chips) >= 1.0)
    }

    /// How far the delay of a path moves within a scan, and how far it may for
    /// paths to count as standing still: a thousandth of a phase step. In chips.
    pub fn movement_in_scan(&self) -> (f64, f64) {
        let scan_chips = self.timing.scan_chips() as f64;
        let moved = self
            .synchronised()
            .filter_map(|light| light.movement.as_ref())
            .map(|movement| {
                let slip = movement.slip.map_or(0.0, |slip| slip.range_chips(scan_chips));
                movement.range_chips(scan_chips) + slip
            })
            .fold(0.0, f64::max);
        (moved, 1e-3 * self.timing.clock.sample_period_chips())
    }

    /// Its next scan begins `chips` after its first one, with phase step `first_step` at group `group`, and with the
    /// codes' first chips. Light and movement go on: groups of other numbers have random numbers of their own. It is of
    /// sensors that count one phase step at a time, and its random numbers may be of any repetition.
    pub fn begin_scan(&mut self, group: Group, first_step: u64, chips: u64) {
        let scan = &mut self.timing.scan;
        let before = group.0 % scan.steps_per_period;
        scan.first_step = (first_step + scan.steps_per_period - before) % scan.steps_per_period;
        self.anchor = Some(Anchor { group, chips });
    }

    /// First chip of a group, from the first chip of its codes on: of the scan, and of all scans.
    fn chips_of_codes(&self, repetition: u64, group: Group) -> Chip {
        match self.anchor {
            None => self.timing.first_chip(repetition, group),
            Some(anchor) => self.timing.start_of_group(Group(group.0 - anchor.group.0)),
        }
    }

    /// Chips from the start of a scan, at which paths have their own delays, to a group.
    pub(crate) fn chips_of_movement(&self, group: Group) -> u128 {
        match self.anchor {
            None => self.timing.start_of_group(group).0,
            Some(anchor) => self.chips_of_codes(0, group).0 + u128::from(anchor.chips),
        }
    }

    /// How a path moves in the scan and the group of a key.
    pub(super) fn trajectory<'m>(
        &self,
        movement: &'m PathMovement,
        key: &StreamKey,
        path: u64,
    ) -> Trajectory<'m> {
        let in_scan = i64::try_from(self.chips_of_movement(key.group)).unwrap_or(i64::MAX);
        let trajectory = Trajectory::new(movement, key, path, in_scan);
        trajectory.since_first_scan(self.chip_of_all(key.repetition, key.group))
    }

    /// First chip of a group among those of all scans.
    pub(crate) fn chip_of_all(&self, repetition: u64, group: Group) -> Chip {
        match self.anchor {
            None => self.timing.first_chip(repetition, group),
            Some(_) => Chip(self.chips_of_movement(group)),
        }
    }

    /// Position in a code of `length` chips at which a group starts.
    pub(crate) fn code_position(&self, repetition: u64, group: Group, length: u64) -> i64 {
        self.chips_of_codes(repetition, group).of_code(length) as i64
    }

    /// How long before a step its simulation starts.
    pub fn warm_up_chips(&self) -> i64 {
        self.warm_up_chips
    }

    /// When the hardware that it feeds does what.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// How long before a step its simulation starts, so that the step does not
    /// remember. Where that is too long, it starts as if it had run before
    /// ([`Self::first_ready_chips`]).
    fn warm_up(&self) -> i64 {
        let chips = self.memory().simulated_start_chips() + self.border_chips();
        chips.ceil() as i64
    }

    /// How long before a step avalanches may be registered within it.
    pub(crate) fn border_chips(&self) -> f64 {
        let jitter = self.jitter_chips.unwrap_or(0.0);
        let tail = self.tail.as_ref().map_or(0.0, Tail::longest_chips);
        // At least a fixed margin, so that small delays and jitters do not move
        // the start, and with it every arrival.
        (self.delay_chips + 2.0 * JITTER_BOUND_SIGMAS * jitter + tail).max(4.0)
    }

    /// Its dead time, of rates per chip.
    pub fn dead_time(&self) -> DeadTime {
        DeadTime { length: self.dead_time_chips, is_prolonged: self.is_paralyzable }
    }

    /// What it remembers under all of its light.
    fn memory(&self) -> DetectorMemory {
        self.memory_under(self.brightest_per_chip())
    }

    /// What it remembers under light of at most `brightest_per_chip` primary detections.
    pub fn memory_under(&self, brightest_per_chip: f64) -> DetectorMemory {
        // A paralyzable detector is blind where anything came within the last dead time, whatever
        // came before.
        let remembered_per_chip = if self.is_paralyzable { 0.0 } else { brightest_per_chip };
        DetectorMemory::new(self.dead_time_chips, self.afterpulsing, remembered_per_chip)
    }

    /// Bound on the detections per chip: what the brightest light makes with its
    /// afterpulses, where an avalanche begets less than one, and one in a dead time.
    pub fn most_detections_per_chip(&self) -> f64 {
        if let Some(pixel) = &self.pixel {
            return pixel.cells.iter().map(DetectorModel::most_detections_per_chip).sum();
        }
        let primary = self.brightest_per_chip();
        let begotten = self.afterpulsing.map_or(0.0, |a| a.mean_per_avalanche);
        let alone = 1.0 - begotten + primary * self.dead_time_chips;
        let most = if alone > 0.0 { primary / alone } else { f64::INFINITY };
        if self.dead_time_chips > 0.0 { most.min(1.0 / self.dead_time_chips) } else { most }
    }

    /// What a chip costs at most, in detections of the plain loop without afterpulses:
    /// an avalanche goes over all afterpulses that are pending.
    pub fn most_work_per_chip(&self) -> f64 {
        if let Some(pixel) = &self.pixel {
            // The next one is looked for among all cells.
            let looked_for = 1.0 + LOOK_WORK * pixel.cells.len() as f64;
            let cells = pixel.cells.iter().map(DetectorModel::most_work_per_chip);
            return looked_for * cells.sum::<f64>();
        }
        // A paralyzable detector's arrivals are drawn one by one, counted or not.
        let lost = if self.is_paralyzable { self.brightest_per_chip() } else { 0.0 };
        let own = (self.most_detections_per_chip() + lost)
            * (1.0 + PENDING_WORK * self.most_pending_afterpulses());
        let others = self.crosstalk.iter().flat_map(|coupled| coupled.others());
        own + others.map(DetectorModel::most_work_per_chip).sum::<f64>()
    }

    /// Afterpulses that are still to come, on average, in the brightest light.
    pub fn most_pending_afterpulses(&self) -> f64 {
        let detections = self.most_detections_per_chip();
        self.afterpulsing.map_or(0.0, |a| detections * a.mean_per_avalanche * a.time_constant_chips)
    }

    /// Primary rate with every laser on.
    pub(crate) fn brightest_per_chip(&self) -> f64 {
        let heard = self.crosstalk.as_ref().map_or(0.0, |coupled| coupled.most_per_chip());
        let light: f64 = self.excess.iter().map(|light| light.rate_per_chip).sum();
        self.constant_per_chip + light + heard
    }

    /// Bound on the detections per chip, whatever it hears.
    pub(crate) fn most_of_dead_time_per_chip(&self) -> f64 {
        1.0 / self.dead_time_chips
    }

    /// When the detector is first ready, in chips after its simulation starts.
    ///
    /// At once, if the warm-up makes it forget. Else anywhere within a dead time,
    /// with equal chance: under background the wait for the end of a dead time
    /// that is going on has that distribution, and the detector is ready for only
    /// 1 / (rate x dead time) of the time, less than half a per cent here.
    pub(crate) fn first_ready_chips(&self, key: &StreamKey) -> f64 {
        if self.memory().forgets_its_start() {
            return 0.0;
        }
        let share: f64 = key.stream(RandomStream::Start).random();
        share * self.dead_time_chips
    }
}
