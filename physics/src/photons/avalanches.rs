//! A detector from avalanche to avalanche.

use rand_distr::{Distribution, Exp1};

use super::afterpulsing::{Pending, PendingAfterpulses};
use super::detector::{DetectorModel, JITTER_BOUND_SIGMAS};
use super::light::ExcessArrivals;
use super::random::{RandomStream, StreamKey, StreamRng};
use super::time::ChipTime;

/// A detector that runs from avalanche to avalanche, in all light that arrives, from a time at which it
/// is ready.
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

impl<'m> Avalanches<'m> {
    /// Ready so many chips before the group of `key`, or a little later.
    pub fn new(model: &'m DetectorModel, key: &StreamKey, warm_up_chips: i64) -> Avalanches<'m> {
        let start = Avalanches::start(model, key, warm_up_chips);
        let excess = model
            .excess
            .iter()
            .flat_map(|light| light.strands().map(move |strand| (light, strand)))
            .map(|(light, strand)| {
                let position = model.code_position(key.repetition, key.group, light.code.len());
                let movement = light.movement.as_ref();
                let trajectory = movement.map(|moves| model.trajectory(moves, key, light.number));
                let rng = key.stream(RandomStream::Path(strand.number));
                ExcessArrivals::new(strand, rng, trajectory, position, start)
            })
            .collect();
        let constant = (model.constant_per_chip > 0.0).then(|| {
            let rng = key.stream(RandomStream::ConstantLight);
            ConstantArrivals::new(rng, 1.0 / model.constant_per_chip, start)
        });
        let afterpulses = model
            .afterpulsing
            .map(|a| PendingAfterpulses::new(a, key.stream(RandomStream::Afterpulsing)));
        Avalanches { model, excess, constant, afterpulses, crosstalk: None }
    }

    /// When it is ready first.
    pub fn start(model: &DetectorModel, key: &StreamKey, warm_up_chips: i64) -> ChipTime {
        ChipTime::at_chip(-warm_up_chips).after(model.first_ready_chips(key))
    }

    /// Hears what other detectors cause from now on.
    pub fn listen(&mut self) {
        let ready = ChipTime::at_chip(i64::MIN);
        self.crosstalk = Some(Heard { pending: Pending::none(), ready });
    }

    /// An avalanche that another detector causes at a time, if this one is ready then.
    #[inline]
    pub fn hear(&mut self, time: ChipTime) {
        if let Some(heard) = self.crosstalk.as_mut().filter(|heard| time > heard.ready) {
            heard.pending.add(time);
        }
    }

    /// The next avalanche, and when its dead time ends, of a step that is registered until `end`.
    #[inline]
    pub fn fire(&mut self, end: ChipTime) -> (ChipTime, ChipTime) {
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
    pub fn next_arrival(&self) -> ChipTime {
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
    pub fn registered_from(&self, avalanche: ChipTime) -> ChipTime {
        let bound = self.model.jitter_chips.map_or(0.0, |s| JITTER_BOUND_SIGMAS * s);
        avalanche.shifted(self.model.delay_chips - bound)
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
