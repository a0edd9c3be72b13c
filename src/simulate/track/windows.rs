//! Counts of scans that begin when the hardware begins them.

use crate::photons::{DetectorModel, Level, Pulse, count_step, pulses_of_group};
use crate::response::CountingTier;
use crate::scan::{Group, Sample, Step};

/// One detector's light over a run: scan after scan of it, photon by photon.
pub(super) struct Windows<'m> {
    model: DetectorModel,
    /// The same without light that is modulated.
    dark: DetectorModel,
    tier: CountingTier,
    seed: u64,
    run: u64,
    chips_of_code: &'m [u8],
    /// The next scan's first group: each has random numbers of its own.
    group: u64,
}

impl<'m> Windows<'m> {
    pub fn new(model: &'m DetectorModel, tier: CountingTier, seed: u64, run: u64) -> Windows<'m> {
        let mut dark = model.clone();
        dark.excess.clear();
        let chips_of_code = &model.reference.chips;
        Windows { model: model.clone(), dark, tier, seed, run, chips_of_code, group: 0 }
    }

    /// Signed counts of the `steps` phase steps from `first` on of a scan that begins so many chips after the run's first
    /// one. The modulated light is there in the first `lit` of them.
    pub fn scan(&mut self, first: u64, steps: u64, chips: u64, lit: u64) -> Vec<i64> {
        let group = self.begin(first, steps, chips);
        match self.tier {
            CountingTier::Events => {
                let count = |step| {
                    let model = self.of_step(step, lit);
                    count_step(model, self.seed, self.run, Step(group.0 + step)).signed
                };
                (0..steps).map(count).collect()
            }
            CountingTier::Sampled => self.counts(self.sampled(group, steps, lit), first, steps),
        }
    }

    /// Begins the next scan; gives its first group.
    fn begin(&mut self, first: u64, steps: u64, chips: u64) -> Group {
        let group = Group(self.group);
        self.group += steps;
        for model in [&mut self.model, &mut self.dark] {
            model.begin_scan(group, first, chips);
        }
        group
    }

    fn of_step(&self, step: u64, lit: u64) -> &DetectorModel {
        if step < lit { &self.model } else { &self.dark }
    }

    /// Pulses of the next scan, of so many phase steps, from its first sample on; as [`Windows::scan`] has them.
    pub fn pulses(&mut self, steps: u64, chips: u64, lit: u64) -> impl Iterator<Item = Pulse> {
        let group = self.begin(0, steps, chips);
        self.sampled(group, steps, lit)
    }

    fn sampled(&self, group: Group, steps: u64, lit: u64) -> impl Iterator<Item = Pulse> {
        let timing = self.model.timing();
        let samples_of_step = timing.sampling().samples_of(timing.scan.integration_chips);
        (0..steps).flat_map(move |step| {
            let start = Sample(step * samples_of_step);
            let group = Group(group.0 + step);
            pulses_of_group(self.of_step(step, lit), self.seed, self.run, group, start)
        })
    }

    /// As the hardware counts: a hit is a high sample after a low one, and its sign that of the reference's chip.
    fn counts(&self, pulses: impl Iterator<Item = Pulse>, first: u64, steps: u64) -> Vec<i64> {
        let timing = self.model.timing();
        let sampling = timing.sampling();
        let samples_of_step = sampling.samples_of(timing.scan.integration_chips);
        let samples_of_code = sampling.samples_of(self.chips_of_code.len() as u64);
        let mut counts = vec![0; steps as usize];
        let mut level = Level::default();
        for pulse in pulses {
            if !level.rises(&pulse) {
                continue;
            }
            let step = pulse.first.0 / samples_of_step;
            // What comes in the last sample of the scan is seen in the first one behind it.
            let Some(count) = counts.get_mut(step as usize) else { continue };
            let delay = (first + step) % samples_of_code;
            let sample = (pulse.first.0 + samples_of_code - delay) % samples_of_code;
            let chip = self.chips_of_code[sampling.clock_of(Sample(sample)) as usize];
            *count += if chip == 1 { 1 } else { -1 };
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DetectorIndex, Fluctuation};
    use crate::sensor::Sensor;
    use crate::simulate::Tier;
    use crate::simulate::scans::scans;

    fn sensor() -> Sensor {
        Sensor::load("tests/scenes/tracking.toml").expect("the scene is valid")
    }

    /// A first scan is one as any other command simulates it: by the same plain loop, since the path trembles more often
    /// than photons come, and the bit-exact model of the hardware.
    #[test]
    fn the_first_scan_counts_as_the_reference_model_does() {
        let tremor = Fluctuation { std_m: 1e-6, correlation_time_ps: 128e3 };
        let sensor = sensor().with(|scene| {
            let movement = scene.paths[0].movement.as_mut().expect("the path moves");
            movement.fluctuation = Some(tremor);
        });
        let model = DetectorModel::new(&sensor, DetectorIndex(0));
        let scan = sensor.timing().scan;
        for (tier, counting) in
            [(Tier::Events, CountingTier::Events), (Tier::Sampled, CountingTier::Sampled)]
        {
            let mut expected = Vec::new();
            let kept = &mut |counts: &[crate::photons::StepCount]| {
                expected.extend(counts.iter().map(|count| count.signed));
            };
            scans(&sensor, DetectorIndex(0), tier, 5, 1, kept).expect("it can be simulated");
            let mut windows = Windows::new(&model, counting, 5, 0);
            let counted = windows.scan(scan.first_step, scan.steps, 0, scan.steps);
            assert_eq!(counted, expected, "{tier}");
        }
    }

    /// Without modulated light the counts have no peak, and the light comes back with another scan.
    #[test]
    fn light_is_there_until_it_is_cut() {
        let sensor = sensor();
        let model = DetectorModel::new(&sensor, DetectorIndex(0));
        let scan = sensor.timing().scan;
        let mut windows = Windows::new(&model, CountingTier::Sampled, 5, 0);
        let sum = |counts: Vec<i64>| counts.iter().sum::<i64>();
        let lit = sum(windows.scan(scan.first_step, scan.steps, 0, scan.steps));
        let dark = sum(windows.scan(scan.first_step, scan.steps, 0, 0));
        let again = sum(windows.scan(scan.first_step, scan.steps, 0, scan.steps));
        assert!(dark.abs() < lit / 2 && again > lit / 2, "{lit} {dark} {again}");
        assert_ne!(lit, again, "random numbers are others");
    }
}
