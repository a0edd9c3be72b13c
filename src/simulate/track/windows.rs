//! Counts of scans that begin when the hardware begins them.

use std::ops::Range;
use std::sync::Arc;

use crate::photons::fast::StepCounter;
use crate::photons::{DetectorModel, Level, Pulse, PulseStream, StepCount};
use crate::response::CountingTier;
use crate::scan::{Group, Sample};
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// A detector's light, and what is left of it without light that is modulated.
pub(super) struct TargetLight([DetectorModel; 2]);

impl TargetLight {
    pub fn of(sensor: &Sensor, detector: DetectorIndex) -> TargetLight {
        let model = DetectorModel::new(sensor, detector);
        let mut dark = model.clone();
        dark.excess.clear();
        TargetLight([model, dark])
    }

    /// What counts them, for all targets.
    pub fn counters(&self) -> [StepCounter<'_>; 2] {
        self.0.each_ref().map(StepCounter::new)
    }
}

/// One detector's light over a run: scan after scan of it, photon by photon.
pub(super) struct Windows<'m> {
    counters: &'m [StepCounter<'m>; 2],
    /// Theirs, in the present scan.
    models: [DetectorModel; 2],
    tier: CountingTier,
    seed: u64,
    run: u64,
    /// The next scan's first group: each has random numbers of its own.
    group: u64,
}

impl<'m> Windows<'m> {
    pub fn new(
        counters: &'m [StepCounter<'m>; 2],
        tier: CountingTier,
        seed: u64,
        run: u64,
    ) -> Windows<'m> {
        let models = counters.each_ref().map(|counter| counter.recorder().model().clone());
        Windows { counters, models, tier, seed, run, group: 0 }
    }

    /// Signed counts of the `steps` phase steps from `first` on of a scan that begins so many chips after the run's first
    /// one. The modulated light is there in the first `lit` of them.
    pub fn scan(&mut self, first: u64, steps: u64, chips: u64, lit: u64) -> Vec<i64> {
        let parts = self.begin(first, steps, chips, lit);
        match self.tier {
            CountingTier::Events => {
                let mut counts = vec![StepCount::ZERO; steps as usize];
                let places = counts.split_at_mut(lit.min(steps) as usize);
                for ((counter, steps), places) in self.of_parts(parts).zip([places.0, places.1]) {
                    counter.count(self.seed, self.run..self.run + 1, steps, places);
                }
                counts.iter().map(|count| count.signed).collect()
            }
            CountingTier::Sampled | CountingTier::Binned => {
                self.counts(self.sampled(parts, Sample(0)), first, steps)
            }
        }
    }

    /// Pulses of the next scan, of so many phase steps, whose first sample is `start`; as [`Windows::scan`] has them.
    pub fn pulses(&mut self, steps: u64, chips: u64, lit: u64, start: Sample) -> Vec<Pulse> {
        let parts = self.begin(0, steps, chips, lit);
        self.sampled(parts, start)
    }

    /// Begins the next scan; gives its groups with modulated light, and those behind them.
    fn begin(&mut self, first: u64, steps: u64, chips: u64, lit: u64) -> [Range<u64>; 2] {
        let groups = self.group..self.group + steps;
        for model in &mut self.models {
            model.begin_scan(Group(groups.start), first, chips);
        }
        self.group = groups.end;
        let dark = groups.start + lit.min(steps);
        [groups.start..dark, dark..groups.end]
    }

    fn of_parts(
        &self,
        parts: [Range<u64>; 2],
    ) -> impl Iterator<Item = (StepCounter<'_>, Range<u64>)> {
        let counters = self.counters.iter().zip(&self.models);
        counters.map(|(counter, model)| counter.of_scan(model)).zip(parts)
    }

    fn sampled(&self, parts: [Range<u64>; 2], start: Sample) -> Vec<Pulse> {
        let timing = self.models[0].timing();
        let samples_of_step = timing.sampling().samples_of(timing.scan.integration_chips);
        let first_group = parts[0].start;
        let mut pulses = Vec::new();
        for (counter, groups) in self.of_parts(parts).filter(|(_, groups)| !groups.is_empty()) {
            let recorder = Arc::new(counter.recorder().clone());
            let [first, end] = [groups.start, groups.end].map(Group);
            PulseStream::of_groups(&recorder, self.seed, self.run, first, Some(end))
                .advance(Sample(u64::MAX), &mut pulses);
        }
        // Streams have the samples of a scan that has all groups.
        let of_scan = |sample: Sample| start + (sample.0 - first_group * samples_of_step);
        pulses
            .iter()
            .map(|pulse| Pulse { first: of_scan(pulse.first), end: of_scan(pulse.end) })
            .collect()
    }

    /// As the hardware counts: a hit is a high sample after a low one, and its sign that of the reference's chip.
    fn counts(&self, pulses: Vec<Pulse>, first: u64, steps: u64) -> Vec<i64> {
        let timing = self.models[0].timing();
        let code = &self.models[0].reference.chips;
        let sampling = timing.sampling();
        let samples_of_step = sampling.samples_of(timing.scan.integration_chips);
        let samples_of_code = sampling.samples_of(code.len() as u64);
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
            let chip = code[sampling.clock_of(Sample(sample)) as usize];
            *count += if chip == 1 { 1 } else { -1 };
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::Tier;
    use crate::simulate::scans::scans;

    fn sensor() -> Sensor {
        Sensor::load("tests/scenes/tracking.toml").expect("the scene is valid")
    }

    const FIRST: DetectorIndex = DetectorIndex(0);

    /// A first scan is one as any other command simulates it, bit for bit.
    #[test]
    fn the_first_scan_counts_as_the_reference_model_does() {
        let sensor = sensor();
        let light = TargetLight::of(&sensor, FIRST);
        let counters = light.counters();
        let scan = sensor.timing().scan;
        for (tier, counting) in
            [(Tier::Events, CountingTier::Events), (Tier::Sampled, CountingTier::Sampled)]
        {
            let mut expected = Vec::new();
            let kept = &mut |counts: &[crate::photons::StepCount]| {
                expected.extend(counts.iter().map(|count| count.signed));
            };
            scans(&sensor, FIRST, tier, 5, 1, kept).expect("it can be simulated");
            let mut windows = Windows::new(&counters, counting, 5, 0);
            let counted = windows.scan(scan.first_step, scan.steps, 0, scan.steps);
            assert_eq!(counted, expected, "{tier}");
        }
    }

    /// Without modulated light the counts have no peak, and the light comes back with another scan.
    #[test]
    fn light_is_there_until_it_is_cut() {
        let sensor = sensor();
        let light = TargetLight::of(&sensor, FIRST);
        let counters = light.counters();
        let scan = sensor.timing().scan;
        let mut windows = Windows::new(&counters, CountingTier::Sampled, 5, 0);
        let sum = |counts: Vec<i64>| counts.iter().sum::<i64>();
        let lit = sum(windows.scan(scan.first_step, scan.steps, 0, scan.steps));
        let dark = sum(windows.scan(scan.first_step, scan.steps, 0, 0));
        let again = sum(windows.scan(scan.first_step, scan.steps, 0, scan.steps));
        assert!(dark.abs() < lit / 2 && again > lit / 2, "{lit} {dark} {again}");
        assert_ne!(lit, again, "random numbers are others");
    }
}
