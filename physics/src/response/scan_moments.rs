//! Second moments of all steps of a scan at once.
//!
//! At each sub-chip phase b the reference divides time into slots of one chip
//! (see `correlator`), and r\[k\] is a signed sum of the slots' counts n_i. With
//! V_d\[i\] the covariance of n_i and n_(i+d) that comes from pairs whose earlier
//! detection is in slot i,
//!
//! Var r = sum over i of hits_i + 2 sum over d of chi_(i - a) chi_(i+d - a) V_d\[i\],
//!
//! which is, for every d, a periodic correlation with the code's product with
//! itself d chips on: all shifts a by FFT. V_d comes from few solutions: the
//! detector forgets within some chips, so slots that far apart can be weighted
//! at once without being confused ("combs").
//!
//! Second moments per detection of a whole period are worked out for up to eight
//! phases per chip, interpolated between, and scaled to what a step is expected to
//! detect; what a step's end divides of the pairs is taken off the total's variance alone,
//! which may be far below the number of detections. Rising and falling edges are taken half-way between their delays.

use std::sync::Arc;

use goldtof_fft::Fft;
use goldtof_fft::num_complex::Complex64;
use rayon::prelude::*;

use super::long_scan::{LongScan, PerDetection};
use super::moments::{CountMoments, SecondMoments, rows};
use super::several::Several;
use crate::scan::Step;

/// Phases per chip that are worked out.
const PHASES_PER_CHIP: usize = 8;

impl SecondMoments<'_, '_> {
    /// Moments of every step of the first scan: of few steps one by one.
    pub fn of_scan(&self) -> Vec<CountMoments> {
        of_scan(self)
    }
}

fn of_scan(second: &SecondMoments) -> Vec<CountMoments> {
    let scan = &second.response.model.timing.scan;
    let brightest = second.response.light.brightest_per_chip();
    let memory = second.response.model.memory_under(brightest).of_pairs_chips();
    let period = second.solved.pairs.grid.period_chips;
    let stride =
        (second.response.model.timing.clock.samples_per_chip as usize / PHASES_PER_CHIP).max(1);
    let phases = second.response.model.timing.clock.samples_per_chip as usize / stride;
    let one_by_one = scan.steps as usize <= memory * phases;
    if one_by_one || period < 2 * memory {
        return second.of_steps(&Step::all(scan.steps).collect::<Vec<_>>());
    }
    let long_scan = &second.solved.long_scan;
    let long_scan = long_scan.get_or_init(|| LongScan::new(second, memory, stride));
    let later_chips = second.response.delay_chips - long_scan.delay_chips;
    let means = second.response.mean_counts();
    means
        .into_iter()
        .enumerate()
        .map(|(step, mean)| {
            let phase_step = scan.phase_step(Step::at(step));
            let place = second.response.phase_chips(phase_step) - later_chips;
            let of_one = long_scan.at(place);
            CountMoments {
                signed_mean: mean.signed,
                total_mean: mean.total,
                signed_variance: of_one.variance * mean.total,
                total_variance: second.total_variance(Step::at(step)),
                covariance: mean.signed + of_one.excess_covariance * mean.total,
            }
        })
        .collect()
}

impl LongScan {
    fn new(second: &SecondMoments, memory: usize, stride: usize) -> LongScan {
        let samples = second.response.model.timing.clock.samples_per_chip as usize;
        let phases = (0..=samples).step_by(stride);
        LongScan {
            delay_chips: second.response.delay_chips,
            phases: phases.map(|step| second.response.phase_chips(step as u64)).collect(),
            per_detection: all_phase_steps(second, memory, stride),
        }
    }
}

/// Second moments of every `stride`-th phase step of the code period.
fn all_phase_steps(second: &SecondMoments, memory: usize, stride: usize) -> Vec<PerDetection> {
    let phases = second.response.model.timing.clock.samples_per_chip as usize / stride;
    let period = second.solved.pairs.grid.period_chips;
    let combs = combs(period, memory);
    let slots: Vec<Slots> = (0..phases)
        .map(|phase| {
            let offset = second.response.phase_chips((phase * stride) as u64);
            Slots::new(second, offset)
        })
        .collect();
    // As many at once as are solved for side by side, of whatever phase.
    let asked: Vec<_> =
        slots.iter().flat_map(|slots| combs.iter().map(move |comb| (slots, &comb[..]))).collect();
    let solved = asked.par_chunks(Several::COUNT).map(|asked| covariances(second, asked, memory));
    let solved = solved.collect::<Vec<_>>().concat();

    let code = &second.response.model.reference.chips;
    let correlation = CodeCorrelation::new(code, memory);
    let of_phases: Vec<_> = (slots.par_iter().zip(solved.par_chunks(combs.len())))
        .map(|(slots, solved)| slots.per_detection(solved, &correlation, memory))
        .collect();
    (0..code.len() * phases).map(|step| of_phases[step % phases][step / phases]).collect()
}

/// Slots that may be weighted at once: at least `memory` apart, and every slot in
/// exactly one comb.
fn combs(period: usize, memory: usize) -> Vec<Vec<usize>> {
    let teeth = period / memory;
    let start = |tooth: usize| tooth * period / teeth;
    let longest = period.div_ceil(teeth);
    (0..longest)
        .map(|offset| {
            (0..teeth)
                .filter(|&tooth| start(tooth) + offset < start(tooth + 1))
                .map(|tooth| start(tooth) + offset)
                .collect()
        })
        .collect()
}

/// The slots of one phase, in the grid's frame.
struct Slots {
    /// Whole chips from the frame's origin to the start of code chip 0 (of a
    /// reference that is delayed by less than a chip).
    whole: i64,
    /// Share of each cell of a chip after the slot's start, and before it, of what
    /// samples see.
    after: Vec<f64>,
    before: Vec<f64>,
    hits: Vec<f64>,
    excess_of_all: Vec<f64>,
}

/// Covariance of two slots, from pairs whose earlier detection is in `slot`.
#[derive(Clone, Copy)]
struct SlotPair {
    slot: usize,
    lag: usize,
    covariance: f64,
}

/// The covariances of some combs' slots with those up to `memory` before, comb by comb.
fn covariances(
    second: &SecondMoments,
    asked: &[(&Slots, &[usize])],
    memory: usize,
) -> Vec<Vec<SlotPair>> {
    let period = second.solved.pairs.grid.period_chips;
    let weights: Vec<_> = asked.iter().map(|(slots, comb)| slots.weights(comb, period)).collect();
    let of_comb = |((slots, comb), excess): (&(&Slots, &[usize]), Vec<f64>)| {
        let excess = slots.add_up(&excess);
        let of_slot = |&late: &usize| {
            let excess = &excess;
            (0..memory).map(move |lag| {
                let slot = (late + period - lag) % period;
                SlotPair { slot, lag, covariance: excess[slot] }
            })
        };
        comb.iter().flat_map(of_slot).collect()
    };
    asked.iter().zip(second.solved.pairs.excess(&rows(&weights))).map(of_comb).collect()
}

impl Slots {
    fn new(second: &SecondMoments, offset: f64) -> Slots {
        let timing = &second.response.timing;
        let start = offset + 0.5 * (timing.rising + timing.falling) - second.frame_chips();
        let [after, _] = second.solved.pairs.shares_after(start - start.floor());
        let seen = second.solved.pairs.seen.iter().zip(&after);
        let mut slots = Slots {
            whole: start.floor() as i64,
            before: seen.map(|(seen, after)| seen - after).collect(),
            after,
            hits: Vec::new(),
            excess_of_all: Vec::new(),
        };
        slots.hits = slots.add_up(&second.solved.pairs.hits);
        slots.excess_of_all = slots.add_up(&second.solved.pairs.excess_of_all);
        slots
    }

    /// Adds up values per cell by slots.
    fn add_up(&self, per_cell: &[f64]) -> Vec<f64> {
        let period = per_cell.len() / self.after.len();
        let mut sums = vec![0.0; period];
        for (chip, values) in per_cell.chunks(self.after.len()).enumerate() {
            for ((value, after), before) in values.iter().zip(&self.after).zip(&self.before) {
                sums[chip] += after * value;
                sums[(chip + period - 1) % period] += before * value;
            }
        }
        sums
    }

    /// What every cell of the code period has of a comb's slots.
    fn weights(&self, comb: &[usize], period: usize) -> Vec<f64> {
        let cells = self.after.len();
        let mut weights = vec![0.0; period * cells];
        for &slot in comb {
            let next = (slot + 1) % period;
            for (cell, (after, before)) in self.after.iter().zip(&self.before).enumerate() {
                weights[slot * cells + cell] += after;
                weights[next * cells + cell] += before;
            }
        }
        weights
    }

    /// Second moments of every whole-chip shift of the reference, from the
    /// covariances of all slots.
    fn per_detection(
        &self,
        pairs: &[Vec<SlotPair>],
        correlation: &CodeCorrelation,
        memory: usize,
    ) -> Vec<PerDetection> {
        let period = self.hits.len();
        let mut by_lag = vec![vec![0.0; period]; memory];
        for pair in pairs.iter().flatten() {
            by_lag[pair.lag][pair.slot] = pair.covariance;
        }
        let hits: f64 = self.hits.iter().sum();
        // Covariance with N: with later detections of any slot, and with earlier.
        let mut linear = self.excess_of_all.clone();
        for (lag, covariances) in by_lag.iter().enumerate() {
            let (wrapping, others) = covariances.split_at(period - lag);
            let later = linear[lag..].iter_mut().zip(wrapping);
            later.for_each(|(sum, covariance)| *sum += covariance);
            let first = linear.iter_mut().zip(others);
            first.for_each(|(sum, covariance)| *sum += covariance);
        }
        let quadratic = correlation.quadratic(&by_lag);
        let linear = correlation.linear(&linear);
        // Slot i begins i + cut chips after the frame's origin, and is shift a's
        // code chip i + whole - a.
        let length = correlation.length;
        (0..length as i64)
            .map(|a| {
                let shift = (a + self.whole).rem_euclid(length as i64) as usize;
                PerDetection {
                    variance: 1.0 + 2.0 * quadratic[shift] / hits,
                    excess_covariance: linear[shift] / hits,
                }
            })
            .collect()
    }
}

/// Periodic correlations with the reference's signs, by FFT.
struct CodeCorrelation {
    forward: Arc<dyn Fft<f64>>,
    inverse: Arc<dyn Fft<f64>>,
    length: usize,
    /// Spectrum of the signs, and of their products with those `lag` chips on.
    signs: Vec<Complex64>,
    products: Vec<Vec<Complex64>>,
}

impl CodeCorrelation {
    fn new(code: &[u8], lags: usize) -> CodeCorrelation {
        let length = code.len();
        let [forward, inverse] = goldtof_fft::pair(length);
        let mut correlation =
            CodeCorrelation { forward, inverse, length, signs: Vec::new(), products: Vec::new() };
        let chi = |i: usize| 2.0 * f64::from(code[i % length]) - 1.0;
        correlation.signs = correlation.spectrum((0..length).map(chi));
        correlation.products = (0..lags)
            .map(|lag| correlation.spectrum((0..length).map(|i| chi(i) * chi(i + lag))))
            .collect();
        correlation
    }

    /// Sum over slots and lags of values times the product of the two slots'
    /// signs, for every shift.
    fn quadratic(&self, by_lag: &[Vec<f64>]) -> Vec<f64> {
        let mut sum = vec![Complex64::ZERO; self.length];
        for (values, product) in by_lag.iter().zip(&self.products) {
            let values = self.spectrum(values.iter().copied());
            for ((sum, value), product) in sum.iter_mut().zip(values).zip(product) {
                *sum += value * product.conj();
            }
        }
        self.back(sum)
    }

    /// Sum over slots of values times the slot's sign, for every shift.
    fn linear(&self, values: &[f64]) -> Vec<f64> {
        let values = self.spectrum(values.iter().copied());
        let product = values.iter().zip(&self.signs).map(|(v, s)| v * s.conj());
        self.back(product.collect())
    }

    /// Spectrum of values folded to the code's period.
    fn spectrum(&self, values: impl Iterator<Item = f64>) -> Vec<Complex64> {
        let mut folded = vec![Complex64::ZERO; self.length];
        for (i, value) in values.enumerate() {
            folded[i % self.length].re += value;
        }
        self.forward.process(&mut folded);
        folded
    }

    fn back(&self, mut spectrum: Vec<Complex64>) -> Vec<f64> {
        self.inverse.process(&mut spectrum);
        spectrum.iter().map(|v| v.re / self.length as f64).collect()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::photons::DetectorModel;
    use crate::response::MeanResponse;
    use crate::scene::{DetectorIndex, load_with};
    use crate::sensor::Sensor;

    /// Against those that are solved for anew, in variances of the total count: with light that comes some whole phase steps
    /// later, and halfway between two; of pulses that merge or are missed between samples, which are always solved for.
    #[test]
    fn later_light_has_the_moments_of_its_phases() {
        const HALF_A_STEP: f64 = 1.5e-2;
        let exact = [(3.0, 1e-9), (0.5, HALF_A_STEP), (-81.5, HALF_A_STEP)];
        let solved = [(0.5, 0.0)];
        for (setting, delays) in [
            ("path.distance=3.2 m", &exact[..]),
            ("detector.pulse_width=13.5 ns", &solved),
            ("detector.pulse_width=0.7 ns", &solved),
        ] {
            let setting = [setting.parse().expect("sound")];
            let scene = load_with(Path::new("../scenes/quick.toml"), &setting).expect("sound");
            let sensor = Sensor::new(&scene);
            let model = DetectorModel::new(&sensor, DetectorIndex(0));
            let response = MeanResponse::new(&model).expect("solved");
            let second = SecondMoments::new(&response).expect("solved");
            second.of_scan();
            for &(steps, most) in delays {
                let delayed = response.delayed(steps * sensor.clock().sample_period_ps());
                let delayed = delayed.expect("solved");
                let found = SecondMoments::of_delayed(&second.solved(), &delayed);
                let found = found.expect("solved").of_scan();
                let anew = SecondMoments::new(&delayed).expect("solved").of_scan();
                let of = |moments: &CountMoments| {
                    [moments.signed_variance, moments.total_variance, moments.covariance]
                };
                let off = found.iter().zip(&anew).flat_map(|(found, anew)| {
                    let pairs = of(found).into_iter().zip(of(anew));
                    pairs.map(|(found, of_anew)| (found - of_anew).abs() / anew.total_variance)
                });
                let off = off.fold(0.0, f64::max);
                assert!(off <= most, "{steps} steps later: {off:e}");
            }
        }
    }

    #[test]
    fn combs_hold_every_slot_once_and_keep_their_distance() {
        for (period, memory) in [(31, 9), (2047, 11), (40, 20), (23, 7)] {
            let mut seen = vec![0; period];
            for comb in combs(period, memory) {
                for (index, &slot) in comb.iter().enumerate() {
                    seen[slot] += 1;
                    let next = comb[(index + 1) % comb.len()];
                    let gap = (next + period - slot - 1) % period + 1;
                    assert!(gap >= memory, "{period} {memory}: {slot} {next}");
                }
            }
            assert!(seen.iter().all(|&times| times == 1));
        }
    }
}
