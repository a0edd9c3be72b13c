//! Whether a scan's peak could be chance: how often a scan without any light of the source that is ranged
//! has as large a count. A beam that is blocked, or a laser that is off, leaves counts that have a largest
//! one, too.

use std::f64::consts::{PI, TAU};
use std::sync::{Arc, OnceLock};

use super::count_law::CountLaw;
use super::effort::{TheoryEffort, Work};
use super::fit::slipping::SlippingLight;
use super::fit::start::PeakShape;
use super::phase::{first_maximum, fundamental, is_one_window};
use crate::photons::{DeadTime, DetectorModel, StepCount};
use crate::response::{CountingTier, MeanCount, MeanResponse, MeanResponseError, SecondMoments};
use crate::scan::Step;
use crate::scene::{Architecture, DetectorIndex, EstimatorKind};
use crate::sensor::Sensor;

/// From this chance on there is no estimate.
pub const NO_PEAK: f64 = 0.02;
/// From this chance on it is told.
pub const DOUBTFUL: f64 = 0.001;

/// Phase steps times samples per chip of scans whose scatter is to tell how bright it was, at least: of less, a
/// code's sidelobes pass for noise. Of Gold codes of 63 chips, with one sample per chip and no noise at all, a peak
/// is some four standard deviations high among them, and higher in longer scans.
const SCATTERED: usize = 62;
const SCATTERED_STEPS: usize = 16;

/// A detector's scan as it would be without any light of its own source.
#[derive(Debug, Clone)]
pub struct Darkness<'s> {
    sensor: &'s Sensor,
    detector: DetectorIndex,
    /// Laws of the phase steps' counts; a single one if all have the same.
    laws: Arc<[CountLaw]>,
    /// What a fit looks for.
    shape: Arc<OnceLock<PeakShape>>,
    /// What codes of other clocks, which are anywhere beside the reference, add to a count at most, in the scene.
    most_slipping: f64,
    /// Hits of a step by the scene: none if it has no other light.
    hits_of_scene: f64,
    /// What a step counts by what was measured.
    hits: f64,
    /// What such light adds to the mean of every count.
    more: f64,
}

impl<'s> Darkness<'s> {
    /// As bright as the scene is.
    pub fn of_scene(
        sensor: &'s Sensor,
        detector: DetectorIndex,
        tier: CountingTier,
    ) -> Darkness<'s> {
        let spad = &sensor.scene().detectors[detector];
        let of_scene = laws_without_own_light(sensor, detector, tier).unwrap_or_default();
        let hits_of_scene = mean(of_scene.iter().map(|law| law.total));
        let laws = of_scene.into();
        let mut dark = Darkness {
            sensor,
            detector,
            laws,
            shape: Arc::default(),
            most_slipping: most_slipping(sensor, detector, tier).unwrap_or_default(),
            hits_of_scene,
            hits: 0.0,
            more: 0.0,
        };
        if hits_of_scene <= 0.0 {
            // Without other light in the scene, or without theory, hits come as they come.
            let clusters = spad.afterpulses_per_avalanche();
            dark.laws = [CountLaw::of_clusters(dark.balance(), 1.0, clusters)].into();
        }
        dark
    }

    /// The same of a sensor that differs in its estimator at most.
    #[must_use]
    pub fn of_sensor<'n>(&self, sensor: &'n Sensor) -> Darkness<'n> {
        Darkness {
            sensor,
            detector: self.detector,
            laws: Arc::clone(&self.laws),
            shape: Arc::clone(&self.shape),
            most_slipping: self.most_slipping,
            hits_of_scene: self.hits_of_scene,
            hits: self.hits,
            more: self.more,
        }
    }

    /// As bright as a scan's `counts` say.
    ///
    /// Total counts tell how bright it was. Without them it was as bright as the scene is, or brighter if
    /// neighbouring counts differ by more: the signal changes little from one step to the next.
    #[must_use]
    pub fn as_bright_as(&self, counts: &[StepCount]) -> Darkness<'s> {
        let mut dark = self.clone();
        let counted = mean(counts.iter().map(|count| count.total as f64));
        if counted > 0.0 {
            dark.hits = counted;
            dark.more = dark.balance() * (counted - dark.hits_of_laws());
        } else if !counts.is_empty() {
            let scattered = dark.excess_scatter(counts) * dark.hits_of_laws();
            dark.hits = scattered.min(dark.most_hits()).max(dark.hits_of_scene);
            dark.more = dark.middle(counts);
        }
        dark
    }

    /// The median of what counts have beyond the laws' means: most steps see no peak.
    fn middle(&self, counts: &[StepCount]) -> f64 {
        let excess = counts.iter().zip(self.laws.iter().cycle());
        let mut excess: Vec<f64> =
            excess.map(|(count, law)| count.signed as f64 - law.mean).collect();
        let middle = excess.len() / 2;
        *excess.select_nth_unstable_by(middle, f64::total_cmp).1
    }

    /// Hits that the laws expect of a step.
    fn hits_of_laws(&self) -> f64 {
        mean(self.laws.iter().map(|law| law.total))
    }

    /// Ones of the reference less its zeros, in its chips.
    fn balance(&self) -> f64 {
        let code = self.sensor.reference(self.detector);
        2.0 * code.weight() as f64 / code.len() as f64 - 1.0
    }

    /// The laws of some steps' counts: light that is not modulated makes the difference to the scene's.
    fn laws(&self, steps: usize) -> Vec<CountLaw> {
        let brighter = self.hits / self.hits_of_laws();
        let of_step = |of_scene: &CountLaw| CountLaw {
            mean: of_scene.mean + self.more,
            variance: of_scene.variance * brighter,
            total: of_scene.total * brighter,
            ..*of_scene
        };
        self.laws.iter().map(of_step).cycle().take(steps).collect()
    }

    /// Hits of a step at most, however bright: one each dead time of each cell.
    fn most_hits(&self) -> f64 {
        let spad = &self.sensor.scene().detectors[self.detector];
        f64::from(spad.cells) * self.sensor.timing().integration_ps() / spad.dead_time_ps
    }

    /// How many times the variance of the scene's noise the counts have, by the differences of neighbours
    /// (von Neumann 1941) away from the largest one; 0 if they are too few to tell.
    fn excess_scatter(&self, counts: &[StepCount]) -> f64 {
        let samples_per_chip = self.sensor.clock().samples_per_chip as usize;
        if counts.len() < SCATTERED_STEPS || counts.len() * samples_per_chip < SCATTERED {
            return 0.0;
        }
        let group = self.steps_of_the_same_light(counts.len());
        let law = |step: usize| self.laws[step % self.laws.len()];
        let excess: Vec<f64> = counts
            .iter()
            .enumerate()
            .map(|(step, count)| count.signed as f64 - law(step).mean)
            .collect();
        let peak = first_maximum(&excess);
        let (mut squares, mut expected) = (0.0, 0.0);
        for step in 1..counts.len() {
            let apart = step.abs_diff(peak);
            if apart.min(counts.len() - apart) <= samples_per_chip {
                continue;
            }
            squares += (excess[step] - excess[step - 1]).powi(2);
            let sees_the_same = step % group != 0;
            let of_light = if sees_the_same { self.of_the_same_light() } else { 1.0 };
            expected += of_light * (law(step).variance + law(step - 1).variance);
        }
        if expected > 0.0 { squares / expected } else { 0.0 }
    }

    /// Variance of the difference of two neighbours that count the same hits, over that of two that do not:
    /// only hits in samples in which their signs differ are in it, each by 2.
    fn of_the_same_light(&self) -> f64 {
        let code = self.sensor.reference(self.detector);
        let changes = 2.0 * code.runs() as f64 / code.len() as f64;
        2.0 * changes / f64::from(self.sensor.clock().samples_per_chip)
    }

    /// The sensor without its own light, and how much more of light that is not modulated it has, in counts
    /// per second.
    pub fn sensor(&self) -> (Sensor, f64) {
        let dark = without_own_light(self.sensor, self.detector);
        let spad = &dark.scene().detectors[self.detector];
        let dead_time = DeadTime::of(spad, spad.dead_time_ps * 1e-12);
        let step_s = dark.timing().integration_ps() * 1e-12;
        let [counted, of_scene] = [self.hits, self.hits_of_scene].map(|hits| hits / step_s);
        (dark, dead_time.primary(counted) - dead_time.primary(of_scene))
    }

    /// Share of such scans, as bright as the scene, in which every count is 0; see [`chance_of_zeros`].
    pub fn chance_of_zeros(&self, steps: usize, has_totals: bool) -> f64 {
        let groups = steps as f64 / self.steps_of_the_same_light(steps) as f64;
        chance_of_zeros(self.hits_of_scene, groups, has_totals)
    }

    /// Share of such scans whose counts show as much as those that the estimate rests on; none of hardware whose
    /// counts saturate, and without hits.
    ///
    /// The phase rests on the largest count less what codes of other clocks may add to it, or, where the scan is one
    /// window, on its fundamental alone; a fit on all counts. Of counts that go together, and of heights one step apart, it is more than the share.
    pub fn chance(&self, counts: &[StepCount]) -> Option<f64> {
        if self.sensor.interface().saturates() || self.hits <= 0.0 || counts.is_empty() {
            return None;
        }
        let signed: Vec<f64> = counts.iter().map(|count| count.signed as f64).collect();
        let laws = self.laws(counts.len());
        let (law, count) = match self.sensor.scene().estimator {
            EstimatorKind::Fft if is_one_window(self.sensor.timing()) => {
                return Some(self.chance_of_fundamental(&laws, &signed));
            }
            EstimatorKind::Model if self.has_shape(counts.len()) => self.height(&laws, &signed),
            _ => {
                let coarse = first_maximum(&signed);
                (laws[coarse], signed[coarse] - self.most_slipping)
            }
        };
        // Of hardly any hits the saddlepoint of clusters is too far out, and most are alone.
        let alone = CountLaw { afterpulses: 0.0, ..law };
        let of_one = law.above(count - 0.5).max(alone.above(count - 0.5));
        Some(-(counts.len() as f64 * (-of_one).ln_1p()).exp_m1())
    }

    /// Share of such scans of a period of two chips with as large a fundamental, whose square is exponentially
    /// distributed. Counts of the same light correlate as the square wave does: 1 - 2 |k - l| / S.
    fn chance_of_fundamental(&self, laws: &[CountLaw], signed: &[f64]) -> f64 {
        let excess: Vec<f64> =
            signed.iter().zip(laws).map(|(count, law)| count - law.mean).collect();
        let Ok(sum) = fundamental(&excess, 0, self.sensor.timing()) else { return 1.0 };
        let chip = f64::from(self.sensor.clock().samples_per_chip);
        let group = self.steps_of_the_same_light(laws.len());
        let mut mean_square = 0.0;
        for (first, law) in laws.iter().enumerate() {
            let from = first - first % group;
            for second in from..(from + group).min(laws.len()) {
                let apart = first.abs_diff(second) as f64;
                let correlation = 1.0 - 2.0 * apart.min(2.0 * chip - apart) / chip;
                mean_square += law.variance * correlation * (PI * apart / chip).cos();
            }
        }
        (-sum.norm_sqr() / mean_square).exp()
    }

    /// Whether a fit begins at the best match of so many counts: that of a histogram begins at the largest.
    fn has_shape(&self, counts: usize) -> bool {
        let is_up_down = self.sensor.scene().hardware.architecture == Architecture::UpDown;
        is_up_down && counts as u64 == self.sensor.timing().scan.steps
    }

    /// The height of what looks most like the code's light, as a sum of counts that is as far off and as even, and its law.
    fn height(&self, laws: &[CountLaw], signed: &[f64]) -> (CountLaw, f64) {
        let shape = self.shape.get_or_init(|| PeakShape::of(self.sensor, self.detector, None));
        let excess: Vec<f64> =
            signed.iter().zip(laws).map(|(count, law)| count - law.mean).collect();
        let (step, height) = shape.best_match(&excess);
        let std = mean(laws.iter().map(|law| law.variance)).sqrt();
        let sum = |of_count: f64| shape.terms * of_count;
        let law = CountLaw {
            mean: sum(laws[step].mean),
            variance: sum(laws[step].variance),
            total: sum(laws[step].total),
            ..laws[step]
        };
        (law, law.mean + height / std * law.std())
    }

    /// Neighbouring steps that count the same hits.
    fn steps_of_the_same_light(&self, steps: usize) -> usize {
        match self.sensor.scene().hardware.architecture {
            Architecture::Histogram => steps,
            Architecture::UpDown => self.sensor.timing().parallel as usize,
        }
    }
}

/// The sensor with nothing on its way from the detector's own source to it.
fn without_own_light(sensor: &Sensor, detector: DetectorIndex) -> Sensor {
    sensor.with(|scene| {
        let own = scene.detectors[detector].reference;
        scene.paths.retain(|path| path.detector != detector || path.source != own);
    })
}

/// The laws of the scene's phase steps without the own light, by the exact response: one if no other light is
/// modulated.
fn laws_without_own_light(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
) -> Result<Vec<CountLaw>, MeanResponseError> {
    let mut dark = without_own_light(sensor, detector).with(|scene| scene.hardware.parallel = 1);
    if DetectorModel::new(&dark, detector).modulated_paths().next().is_none() {
        dark = dark.with(|scene| scene.scan.steps = 1);
    }
    TheoryEffort::of(&dark, detector)?.check(Work::Predictions(0))?;
    let model = DetectorModel::new(&dark, detector);
    let response = MeanResponse::of_tier(&model, tier)?;
    let first = SecondMoments::new(&response)?.of_steps(&[Step::at(0)])[0];
    // Hits up and hits down are as good as Poisson numbers, whatever the mean of their difference.
    let fano = first.signed_variance / first.total_mean;
    let spad = &sensor.scene().detectors[detector];
    let of_step = |mean: &MeanCount| CountLaw::of(spad, mean, fano * mean.total);
    let laws = response.mean_counts().iter().map(of_step).collect();
    Ok(if first.total_mean > 0.0 { laws } else { Vec::new() })
}

/// What codes of other clocks add to a signed count at most.
fn most_slipping(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
) -> Result<f64, MeanResponseError> {
    Ok(SlippingLight::new(&DetectorModel::new(sensor, detector), tier)?.most())
}

/// Share of scans of so many groups of steps, each with so many hits, in which every count is 0: without total counts
/// also those with as many hits up as down, nearly 1 / sqrt(1 + 2 pi h) of groups.
pub fn chance_of_zeros(hits: f64, groups: f64, has_totals: bool) -> f64 {
    let ln_of_group = if has_totals { -hits } else { -0.5 * (TAU * hits).ln_1p() };
    (groups * ln_of_group).exp()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let number = values.len().max(1) as f64;
    values.sum::<f64>() / number
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution as _, Poisson};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::scene;

    /// `quick`, with settings, of a detector without dead time and afterpulses.
    fn ideal(settings: &[&str]) -> Sensor {
        let file = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/quick.toml");
        let ideal = ["detector.dead_time=0 ns", "detector.afterpulsing.probability=0"];
        let settings = ideal.iter().chain(settings).map(|text| text.parse().expect("a setting"));
        let settings: Vec<scene::Setting> = settings.collect();
        Sensor::new(&scene::load_with(&file, &settings).expect("the scene is sound"))
    }

    /// P(up - down >= count) of two Poisson numbers, by sums.
    fn skellam(up: f64, down: f64, count: usize) -> f64 {
        let poisson = |mean: f64| -> Vec<f64> {
            let next = |p: &mut f64, k: usize| {
                let now = *p;
                *p *= mean / (k + 1) as f64;
                Some(now)
            };
            (0..500).scan((-mean).exp(), next).collect()
        };
        let (up, down) = (poisson(up), poisson(down));
        (0..500 - count).map(|k| down[k] * up[k + count..].iter().sum::<f64>()).sum()
    }

    /// A scan whose largest count is `largest`, and whose steps have `total` hits.
    fn scan(steps: usize, largest: i64, total: u64) -> Vec<StepCount> {
        let mut counts = vec![StepCount { signed: 0, total }; steps];
        counts[100].signed = largest;
        counts
    }

    /// Hits of no light are two Poisson numbers, as many up and down as the code has ones and zeros: 12 and 19
    /// of 31 chips.
    #[test]
    fn the_chance_is_that_of_the_largest_of_many_differences_of_poisson_numbers() {
        let sensor = ideal(&["hardware.total_counts=true"]);
        for (total, largest) in [(4, 7), (4, 11), (100, 30), (100, 60)] {
            let (up, down) = (total as f64 * 12.0 / 31.0, total as f64 * 19.0 / 31.0);
            let below = (-skellam(up, down, largest)).ln_1p();
            let exact = -(248.0 * below).exp_m1();
            let counts = scan(248, largest as i64, total);
            let dark = Darkness::of_scene(&sensor, DetectorIndex(0), CountingTier::Sampled)
                .as_bright_as(&counts);
            let found = dark.chance(&counts).expect("there are hits");
            assert!((found / exact - 1.0).abs() < 0.05, "{total}, {largest}: {found} {exact}");
        }
    }

    /// Counts of about so many hits in each group of steps, anywhere in the code; with totals if they are told.
    fn counts_of_noise(
        sensor: &Sensor,
        hits: f64,
        parallel: usize,
        has_totals: bool,
        random: &mut Xoshiro256PlusPlus,
    ) -> Vec<StepCount> {
        counts_of_light(sensor, [hits, 0.0], parallel, has_totals, random)
    }

    /// The same with so many hits beside by light of the code that comes 100 steps late.
    fn counts_of_light(
        sensor: &Sensor,
        hits: [f64; 2],
        parallel: usize,
        has_totals: bool,
        random: &mut Xoshiro256PlusPlus,
    ) -> Vec<StepCount> {
        let chips = &sensor.reference(DetectorIndex(0)).chips;
        let samples_per_chip = sensor.clock().samples_per_chip as usize;
        let samples = samples_per_chip * chips.len();
        let sign = |sample: usize| 2 * i64::from(chips[sample % samples / samples_per_chip]) - 1;
        let lit: Vec<usize> = (0..samples).filter(|&sample| sign(sample) > 0).collect();
        let mut number = |mean: f64| match mean > 0.0 {
            true => Poisson::new(mean).expect("a mean").sample(random) as u64,
            false => 0,
        };
        let numbers: Vec<[u64; 2]> =
            (0..samples.div_ceil(parallel)).map(|_| hits.map(&mut number)).collect();
        let mut counts = Vec::new();
        for [anywhere, of_code] in numbers {
            let first = counts.len();
            let mut hits: Vec<usize> =
                (0..anywhere).map(|_| random.random_range(0..samples)).collect();
            let at = |_| lit[random.random_range(0..lit.len())] + 100;
            hits.extend((0..of_code).map(at));
            // The reference is as late as the step's number.
            let late = |step: usize| 2 * samples - first - step;
            let signed = |step: usize| hits.iter().map(|hit| sign(hit + late(step))).sum();
            let total = if has_totals { anywhere + of_code } else { 0 };
            let steps = parallel.min(samples - first);
            counts.extend((0..steps).map(|step| StepCount { signed: signed(step), total }));
        }
        counts
    }

    /// Signed counts of 900 hits at random places of a code, balanced or not, in a scene that expects 90: the scatter
    /// tells on average how bright it was, whether steps count the same hits or not.
    #[test]
    fn without_totals_the_scatter_tells_how_bright_it_was() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
        for (parallel, code) in [
            (1, "source.code.index=0"),
            (4, "source.code.index=0"),
            (16, "source.code.index=0"),
            (16, "source.code={ family = \"chips\", chips = \"1110111011111011\" }"),
        ] {
            let parallel_steps = format!("hardware.parallel={parallel}");
            let sensor = ideal(&["detector.dark_count_rate=4.5 Mcps", &parallel_steps, code]);
            let dark = Darkness::of_scene(&sensor, DetectorIndex(0), CountingTier::Sampled);
            let ratio = |_| {
                let counts = counts_of_noise(&sensor, 900.0, parallel, false, &mut random);
                let dark = dark.as_bright_as(&counts);
                assert!((dark.hits_of_scene / 90.0 - 1.0).abs() < 0.01, "{}", dark.hits_of_scene);
                dark.hits / 900.0
            };
            let scans = 60;
            let mean = (0..scans).map(ratio).sum::<f64>() / f64::from(scans);
            let independent = f64::from(scans) * sensor.timing().groups() as f64;
            let error = (3.0 / independent).sqrt();
            assert!((mean - 1.0).abs() < 4.0 * error + 0.03, "{parallel}, {code}: {mean}");
        }
    }

    /// A fit rests on all counts. Of hits at random places no more scans than their share say that they are no chance, and
    /// heights one step apart, which are nearly the same, make them fewer by no more than the samples of a chip. The
    /// light of a path that only all counts together show is none.
    #[test]
    fn heights_of_noise_have_their_shares_and_those_of_weak_light_do_not() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(9);
        for (parallel, hits, lit) in
            [(1, 6.0, 5.0), (1, 200.0, 28.0), (4, 200.0, 40.0), (16, 200.0, 55.0)]
        {
            let settings = ["hardware.total_counts=true", &format!("hardware.parallel={parallel}")];
            let sensors = [EstimatorKind::Model, EstimatorKind::Fft]
                .map(|estimator| ideal(&settings).estimated_by(estimator));
            let dark = sensors
                .each_ref()
                .map(|of| Darkness::of_scene(of, DetectorIndex(0), CountingTier::Sampled));
            let (scans, limits) = (150, [0.5, 0.2, 0.05]);
            let (mut of_noise, mut of_light) = ([0; 3], [0; 2]);
            for _ in 0..scans {
                let mut scan =
                    |lit| counts_of_light(&sensors[0], [hits, lit], parallel, true, &mut random);
                let (noise, light) = (scan(0.0), scan(lit));
                let chance = |dark: &Darkness, counts: &[StepCount]| {
                    dark.as_bright_as(counts).chance(counts).expect("there are hits")
                };
                let of_height = chance(&dark[0], &noise);
                let below = limits.map(|limit| u32::from(of_height < limit));
                of_noise.iter_mut().zip(below).for_each(|(n, below)| *n += below);
                for (n, dark) in of_light.iter_mut().zip(&dark) {
                    *n += u32::from(chance(dark, &light) < NO_PEAK);
                }
            }
            let of = format!("{parallel} at once, {hits} hits: {of_noise:?}, {of_light:?}");
            for (found, limit) in of_noise.into_iter().zip(limits) {
                let most = limit * f64::from(scans);
                let found = f64::from(found);
                assert!(found < most + 4.0 * most.sqrt() && found > most / 8.0, "{of}");
            }
            let [of_all, of_largest] = of_light;
            assert!(of_all > scans * 19 / 20 && of_largest < scans * 4 / 5, "{of}");
        }
    }

    /// Hits at random places of a square wave: the shares of scans with larger fundamentals are uniform, whether
    /// steps count the same hits or not.
    #[test]
    fn fundamentals_of_a_square_wave_have_their_shares() {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(8);
        for parallel in [1, 4, 16] {
            let settings = ["source.code={ family = \"square\" }", "hardware.total_counts=true"];
            let parallel_steps = format!("hardware.parallel={parallel}");
            let sensor = ideal(&[settings[0], settings[1], &parallel_steps]);
            let mut below = [0; 4];
            let dark = Darkness::of_scene(&sensor, DetectorIndex(0), CountingTier::Sampled);
            for _ in 0..2000 {
                let counts = counts_of_noise(&sensor, 50.0, parallel, true, &mut random);
                let chance = dark.as_bright_as(&counts).chance(&counts).expect("there are hits");
                let limits = [0.5, 0.2, 0.05, 0.02];
                below.iter_mut().zip(limits).for_each(|(n, limit)| *n += u32::from(chance < limit));
            }
            for (found, share) in below.into_iter().zip([0.5, 0.2, 0.05, 0.02]) {
                let (mean, std): (f64, f64) =
                    (2000.0 * share, (2000.0 * share * (1.0 - share)).sqrt());
                assert!((f64::from(found) - mean).abs() < 4.0 * std, "{parallel}: {below:?}");
            }
        }
    }

    /// Every Gold code of degree 5, at 1, 2 and 8 samples per chip, without any noise: its peak is one, however bright,
    /// also half-way between two steps. With one sample per chip the scene's own noise is taken.
    #[test]
    fn no_code_hides_its_own_peak() {
        for (index, samples) in (0..33).flat_map(|index| [1, 2, 8].map(|samples| (index, samples)))
        {
            let code = format!("source.code.index={}", index - 2);
            let samples_per_chip = format!("clock.samples_per_chip={samples}");
            let sensor = ideal(&["detector.dark_count_rate=4.5 Mcps", &code, &samples_per_chip]);
            let chips = &sensor.reference(DetectorIndex(0)).chips;
            let sign = |chip: usize| 2 * i64::from(chips[chip % 31]) - 1;
            let at_lag =
                |lag: usize| (0..31).map(|chip| sign(chip) * sign(chip + lag)).sum::<i64>();
            for (times, late) in [(30, 0), (1000, 0), (1000, 1)] {
                // Steps in half samples from the peak, which is ten chips and a bit late.
                let count = |step: i64| {
                    let place = (2 * (step - 10 * samples) - late).rem_euclid(62 * samples);
                    let (chip, rest) = (place / (2 * samples), place % (2 * samples));
                    let [here, next] = [chip, chip + 1].map(|lag| at_lag(lag as usize));
                    let signed =
                        times * (here * (2 * samples - rest) + next * rest) / (2 * samples);
                    StepCount { signed, total: 0 }
                };
                let counts: Vec<StepCount> = (0..31 * samples).map(count).collect();
                let dark = Darkness::of_scene(&sensor, DetectorIndex(0), CountingTier::Sampled)
                    .as_bright_as(&counts);
                let chance = dark.chance(&counts).expect("there are hits");
                assert!(chance < NO_PEAK, "{index}, {samples}, {times}, {late}: {chance}");
            }
        }
    }

    /// Light that is all of one step's counts does not pass for noise.
    #[test]
    fn a_peak_is_no_scatter() {
        let sensor = ideal(&["detector.dark_count_rate=4.5 Mcps"]);
        let counts = scan(248, 100, 0);
        let dark = Darkness::of_scene(&sensor, DetectorIndex(0), CountingTier::Sampled)
            .as_bright_as(&counts);
        assert!(dark.chance(&counts).expect("there are hits") < 1e-9);
    }
}
