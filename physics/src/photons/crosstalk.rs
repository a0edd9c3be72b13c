//! Crosstalk: avalanches that an avalanche of another detector causes.

use std::sync::Arc;

use rand::RngExt as _;

use super::detector::DetectorModel;
use super::random::{Part, StreamKey, StreamRng};
use super::step::Avalanches;
use super::time::ChipTime;
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// One way of crosstalk, from one detector of some to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    from: usize,
    to: usize,
    probability: f64,
    delay_chips: f64,
}

/// The detectors that make crosstalk at one of them, or at those that do, in the scene's order.
#[derive(Debug, Clone)]
pub struct Coupled {
    /// All of them. That of the one itself has no light here: whoever simulates it has it.
    models: Vec<Option<DetectorModel>>,
    /// Which it is.
    own: usize,
    links: Vec<Link>,
}

impl Coupled {
    /// What makes crosstalk at a detector; none where nothing does.
    pub fn to(sensor: &Sensor, detector: DetectorIndex) -> Option<Arc<Coupled>> {
        let scene = sensor.scene();
        let talks = |of: DetectorIndex| scene.detectors[of].crosstalk();
        let mut members = vec![detector];
        let mut next = 0;
        while let Some(&member) = members.get(next) {
            next += 1;
            for neighbour in scene.neighbours(member) {
                if talks(neighbour).is_some() && !members.contains(&neighbour) {
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

    /// Other detectors.
    pub fn others(&self) -> impl Iterator<Item = &DetectorModel> {
        self.models.iter().flatten()
    }

    /// Bound on the avalanches that others cause at the detector, per chip.
    pub fn most_per_chip(&self) -> f64 {
        let here = self.links.iter().filter(|link| link.to == self.own);
        let of = |link: &Link| {
            let source = self.models[link.from].as_ref();
            source.map_or(0.0, |source| link.probability * source.most_of_dead_time_per_chip())
        };
        here.map(of).sum()
    }
}

/// The detectors beside the one that is simulated, and what all of them cause.
#[derive(Debug, Clone)]
pub struct Others<'m> {
    coupled: &'m Coupled,
    /// Where the coupled detectors are, none for the one itself.
    detectors: Vec<Option<Avalanches<'m>>>,
    /// Of each, whether its avalanches are seen by others.
    rngs: Vec<StreamRng>,
}

impl<'m> Others<'m> {
    /// From so many chips before a group on.
    pub fn new(coupled: &'m Coupled, own: &DetectorModel, key: StreamKey) -> Others<'m> {
        let key_of = |model: &DetectorModel| model.key(key.seed, key.repetition, key.group);
        let detectors = coupled.models.iter().map(|model| {
            let model = model.as_ref()?;
            let mut detector = Avalanches::new(model, &key_of(model), own.warm_up_chips);
            detector.listen();
            Some(detector)
        });
        let rng = |model: &Option<DetectorModel>| {
            key_of(model.as_ref().unwrap_or(own)).stream(Part::Crosstalk)
        };
        Others {
            coupled,
            detectors: detectors.collect(),
            rngs: coupled.models.iter().map(rng).collect(),
        }
    }

    /// The earliest avalanche of another detector that comes before one of the detector itself, and
    /// whose it is. Of two at one time that of the scene's first detector comes first.
    pub fn first_before(&self, own: ChipTime) -> Option<(ChipTime, usize)> {
        let mut first = (own, self.coupled.own);
        for (place, detector) in self.detectors.iter().enumerate() {
            let next = detector.as_ref().map_or(ChipTime::NEVER, Avalanches::next_arrival);
            if next < first.0 || (next == first.0 && place < first.1) {
                first = (next, place);
            }
        }
        (first.1 != self.coupled.own).then_some(first)
    }

    /// Lets the detector at `place` fire, and all that hear it hear it.
    pub fn fire(&mut self, place: usize, own: &mut Avalanches<'m>) {
        if let Some(detector) = &mut self.detectors[place] {
            let (avalanche, _) = detector.fire(ChipTime::NEVER);
            self.cause(place, avalanche, own);
        }
    }

    /// What an avalanche of the detector itself causes.
    pub fn caused_by_own(&mut self, avalanche: ChipTime, own: &mut Avalanches<'m>) {
        self.cause(self.coupled.own, avalanche, own);
    }

    fn cause(&mut self, from: usize, avalanche: ChipTime, own: &mut Avalanches<'m>) {
        for link in self.coupled.links.iter().filter(|link| link.from == from) {
            if self.rngs[from].random::<f64>() >= link.probability {
                continue;
            }
            let time = avalanche.after(link.delay_chips);
            match &mut self.detectors[link.to] {
                Some(detector) => detector.hear(time),
                None => own.hear(time),
            }
        }
    }
}
