//! Crosstalk: avalanches that an avalanche of another detector causes.

use rand::RngExt as _;

use super::avalanches::Avalanches;
use super::detector::{Coupled, DetectorModel};
use super::random::{RandomStream, StreamKey, StreamRng};
use super::time::ChipTime;

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
            key_of(model.as_ref().unwrap_or(own)).stream(RandomStream::Crosstalk)
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
