//! One phase step, photon by photon.

use rand_distr::{Distribution, Exp1, StandardNormal};

use super::afterpulsing::{Pending, PendingAfterpulses};
use super::crosstalk::Others;
use super::detector::{DetectorModel, JITTER_BOUND_SIGMAS};
use super::light::ExcessArrivals;
use super::movement::Trajectory;
use super::random::{Part, StreamKey, StreamRng};
use super::reorder::ReorderBuffer;
use super::time::ChipTime;
use crate::scan::Group;

/// The registered time of a detection, relative to the start of its step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Detection {
    /// Whole chips.
    pub chip: u64,
    /// Offset inside the chip, 0 <= fraction < 1.
    pub fraction: f64,
}

/// A detector that runs from avalanche to avalanche, in all light that arrives (eq. 9: every path's
/// and the background's) from a time at which it is ready.
///
/// The arrivals of each part are Poisson and have no memory, so
/// an arrival that falls into a dead time is drawn anew from its end; with passive
/// recharge the dead time is first begun anew by it.
#[derive(Debug, Clone)]
pub struct Avalanches<'m> {
    model: &'m DetectorModel,
    excess: Vec<ExcessArrivals<'m>>,
    constant: Option<ConstantArrivals>,
    afterpulses: Option<PendingAfterpulses>,
    crosstalk: Option<Heard>,
}

/// What other detectors cause.
#[derive(Debug, Clone)]
struct Heard {
    pending: Pending,
    /// When the detector is ready again.
    ready: ChipTime,
}

/// The detections of one group of phase steps in order of registered time.
#[derive(Debug, Clone)]
pub struct StepDetections<'m> {
    model: &'m DetectorModel,
    detector: Avalanches<'m>,
    /// Those whose crosstalk it hears.
    others: Option<Box<Others<'m>>>,
    jitter: Option<StreamRng>,
    tail: Option<StreamRng>,
    registered: ReorderBuffer,
    /// No time that is still to be registered comes before it.
    horizon: ChipTime,
    end: ChipTime,
}

impl DetectorModel {
    /// Simulates the light of a group of steps of scan number `repetition`. The result
    /// depends on the arguments alone.
    pub fn step(&self, seed: u64, repetition: u64, group: Group) -> StepDetections<'_> {
        StepDetections::new(self, self.key(seed, repetition, group))
    }
}

impl<'m> Avalanches<'m> {
    /// Ready so many chips before the group of `key`, or a little later.
    pub(crate) fn new(
        model: &'m DetectorModel,
        key: &StreamKey,
        warm_up_chips: i64,
    ) -> Avalanches<'m> {
        let start = Avalanches::start(model, key, warm_up_chips);
        let start_in_scan = model.timing.start_of_group(key.group);
        let start_in_scan = i64::try_from(start_in_scan.0).unwrap_or(i64::MAX);
        let start_in_all = model.timing.first_chip(key.repetition, key.group);
        let excess = model
            .excess
            .iter()
            .flat_map(|light| light.strands().map(move |strand| (light, strand)))
            .map(|(light, strand)| {
                let position = model.code_position(key.repetition, key.group, light.code.len());
                let trajectory = light
                    .movement
                    .as_ref()
                    .map(|movement| Trajectory::new(movement, key, light.number, start_in_scan))
                    .map(|trajectory| trajectory.since_first_scan(start_in_all));
                let rng = key.stream(Part::Path(strand.number));
                ExcessArrivals::new(strand, rng, trajectory, position, start)
            })
            .collect();
        let constant = (model.constant_per_chip > 0.0).then(|| {
            let rng = key.stream(Part::ConstantLight);
            ConstantArrivals::new(rng, 1.0 / model.constant_per_chip, start)
        });
        let afterpulses =
            model.afterpulsing.map(|a| PendingAfterpulses::new(a, key.stream(Part::Afterpulsing)));
        Avalanches { model, excess, constant, afterpulses, crosstalk: None }
    }

    fn start(model: &DetectorModel, key: &StreamKey, warm_up_chips: i64) -> ChipTime {
        ChipTime::at_chip(-warm_up_chips).after(model.first_ready_chips(key))
    }

    /// Hears what other detectors cause from now on.
    pub(crate) fn listen(&mut self) {
        let ready = ChipTime::at_chip(i64::MIN);
        self.crosstalk = Some(Heard { pending: Pending::none(), ready });
    }

    /// An avalanche that another detector causes at a time, if this one is ready then.
    #[inline]
    pub(crate) fn hear(&mut self, time: ChipTime) {
        if let Some(heard) = self.crosstalk.as_mut().filter(|heard| time > heard.ready) {
            heard.pending.add(time);
        }
    }

    /// The next avalanche, and when its dead time ends, of a step that is registered until `end`.
    #[inline]
    pub(crate) fn fire(&mut self, end: ChipTime) -> (ChipTime, ChipTime) {
        let avalanche = self.next_arrival();
        let mut ready = avalanche.after(self.model.dead_time_chips);
        if self.model.is_paralyzable {
            ready = self.recharged(avalanche, end);
        }
        self.redraw_arrivals(ready);
        if let Some(afterpulses) = &mut self.afterpulses {
            afterpulses.avalanche(ready);
        }
        if let Some(heard) = &mut self.crosstalk {
            heard.pending.lose(ready);
            heard.ready = ready;
        }
        (avalanche, ready)
    }

    /// The first arrival that is still to come.
    #[inline]
    pub(crate) fn next_arrival(&self) -> ChipTime {
        let mut first = ChipTime::NEVER;
        for arrivals in &self.excess {
            if arrivals.next < first {
                first = arrivals.next;
            }
        }
        if let Some(constant) = &self.constant
            && constant.next < first
        {
            first = constant.next;
        }
        if let Some(afterpulses) = &self.afterpulses
            && afterpulses.pending.next < first
        {
            first = afterpulses.pending.next;
        }
        if let Some(heard) = &self.crosstalk
            && heard.pending.next < first
        {
            first = heard.pending.next;
        }
        first
    }

    /// Passes over the light that comes until `ready`.
    #[inline]
    fn redraw_arrivals(&mut self, ready: ChipTime) {
        for arrivals in &mut self.excess {
            if arrivals.next <= ready {
                arrivals.redraw(ready);
            }
        }
        if let Some(constant) = &mut self.constant
            && constant.next <= ready
        {
            constant.redraw(ready);
        }
    }

    /// When a dead time ends that each arrival within it begins anew; a time after the step
    /// where that is later.
    fn recharged(&mut self, avalanche: ChipTime, end: ChipTime) -> ChipTime {
        let mut arrival = avalanche;
        loop {
            let ready = arrival.after(self.model.dead_time_chips);
            self.redraw_arrivals(arrival);
            if let Some(afterpulses) = &mut self.afterpulses {
                afterpulses.pending.lose(arrival);
            }
            arrival = self.next_arrival();
            // In bright light the dead time may never end.
            if arrival > ready || self.registered_from(ready) >= end {
                return ready;
            }
        }
    }

    /// The earliest time at which what comes at `avalanche` or later may be registered.
    #[inline]
    fn registered_from(&self, avalanche: ChipTime) -> ChipTime {
        let bound = self.model.jitter_chips.map_or(0.0, |s| JITTER_BOUND_SIGMAS * s);
        avalanche.shifted(self.model.delay_chips - bound)
    }
}

impl<'m> StepDetections<'m> {
    pub(crate) fn new(model: &'m DetectorModel, key: StreamKey) -> StepDetections<'m> {
        let mut detector = Avalanches::new(model, &key, model.warm_up_chips);
        let others = model.crosstalk.as_deref().map(|coupled| {
            detector.listen();
            Box::new(Others::new(coupled, model, key))
        });
        StepDetections {
            model,
            detector,
            others,
            jitter: model.jitter_chips.map(|_| key.stream(Part::Jitter)),
            tail: model.tail.as_ref().map(|_| key.stream(Part::Tail)),
            registered: ReorderBuffer::default(),
            horizon: Avalanches::start(model, &key, model.warm_up_chips),
            end: ChipTime::at_chip(
                i64::try_from(model.timing.scan.integration_chips).unwrap_or(i64::MAX),
            ),
        }
    }

    /// The next avalanche; what is registered from then on comes after its dead time.
    #[inline]
    fn fire(&mut self) -> ChipTime {
        if let Some(others) = &mut self.others {
            // What comes too late to be heard within the step need not be known.
            while let Some((time, place)) = others.first_before(self.detector.next_arrival())
                && self.detector.registered_from(time) < self.end
            {
                others.fire(place, &mut self.detector);
            }
        }
        let (avalanche, ready) = self.detector.fire(self.end);
        if let Some(others) = &mut self.others {
            others.caused_by_own(avalanche, &mut self.detector);
        }
        self.horizon = self.detector.registered_from(ready);
        avalanche
    }

    /// Delay and jitter from the avalanche to its registered time.
    #[inline]
    fn register(&mut self, avalanche: ChipTime) -> ChipTime {
        let mut shift = self.model.delay_chips;
        if let (Some(rng), Some(sigma)) = (&mut self.jitter, self.model.jitter_chips) {
            let normal: f64 = StandardNormal.sample(rng);
            shift += sigma * normal.clamp(-JITTER_BOUND_SIGMAS, JITTER_BOUND_SIGMAS);
        }
        if let (Some(rng), Some(tail)) = (&mut self.tail, &self.model.tail) {
            shift += tail.draw(rng);
        }
        avalanche.shifted(shift)
    }
}

impl Iterator for StepDetections<'_> {
    type Item = Detection;

    #[inline]
    fn next(&mut self) -> Option<Detection> {
        loop {
            while let Some(time) = self.registered.pop_before(self.horizon) {
                if time >= self.end {
                    // Nothing that follows is earlier.
                    self.horizon = self.end;
                    return None;
                }
                if let Ok(chip) = u64::try_from(time.chip) {
                    return Some(Detection { chip, fraction: time.fraction });
                }
            }
            if self.horizon >= self.end {
                return None;
            }
            let avalanche = self.fire();
            let time = self.register(avalanche);
            self.registered.insert(time);
        }
    }
}

/// Arrivals of the background, one after another.
#[derive(Debug, Clone)]
struct ConstantArrivals {
    rng: StreamRng,
    mean_wait_chips: f64,
    next: ChipTime,
}

impl ConstantArrivals {
    fn new(rng: StreamRng, mean_wait_chips: f64, start: ChipTime) -> ConstantArrivals {
        let mut arrivals = ConstantArrivals { rng, mean_wait_chips, next: start };
        arrivals.redraw(start);
        arrivals
    }

    /// Draws the first arrival after `from`.
    #[inline]
    fn redraw(&mut self, from: ChipTime) {
        let exponential: f64 = Exp1.sample(&mut self.rng);
        self.next = from.after(exponential * self.mean_wait_chips);
    }
}
