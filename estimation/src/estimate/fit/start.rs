//! Where the fit of one path starts: at the phase round the place where all counts of the scan together look most like
//! the path, and at the rate.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::Arc;

use goldtof_fft::num_complex::Complex64;
use nalgebra::{DMatrix, DVector, DVectorView};

use super::parameters::{FitParameters, PathParameters, share_of_ones};
use super::template::{Template, real, spectrum};
use crate::estimate::phase::{estimate_at, first_maximum};
use crate::estimate::{CountingTier, NoEstimate, calibration_offset_ps};
use crate::photons::DeadTime;
use crate::response::MeanCount;
use crate::scan::{Group, Grouping, Step};
use crate::scene::{Detector, DetectorIndex, JitterTail};
use crate::sensor::Sensor;

/// Least share of the light that a start attributes to the path.
const LEAST_PATH_SHARE: f64 = 0.02;

/// Largest share of the light that a start attributes to the path: with all of it, a count of the
/// other sign would be impossible.
const MOST_PATH_SHARE: f64 = 0.999;

/// A shape that changes by so little over a scan's steps does so by rounding.
const NEXT_TO_NOTHING: f64 = 1e-9;

/// The phase estimate for the delay: that of `values`, one for each step, round step number `peak`, where the path is thought
/// to be. For the light, with q the code's share of
/// ones and e the excess on-light: detections per chip give the mean light
/// m = q e + constant, corrected for the dead time, and without dead time the peak
/// would be r / N = (q (e + constant) - (1 - q) constant) / m, that is
/// e / m = (r / N + 1 - 2 q) / (2 q (1 - q)). Where few counts make this negative, or larger than
/// possible, the fit starts from a little light, or nearly all.
///
/// # Errors
/// When all counts are equal, or nothing was counted, or the code does not modulate.
pub fn start(
    sensor: &Sensor,
    detector: DetectorIndex,
    tier: CountingTier,
    counts: &[MeanCount],
    (values, peak): (&[f64], usize),
) -> Result<FitParameters, NoEstimate> {
    let spad = &sensor.scene().detectors[detector];
    let code = &sensor.scene().sources[spad.reference].code;
    let signed = counts[peak].signed;
    // Of light that hardly is any the step at the peak may have counted nothing.
    let total = counts.iter().map(|count| count.total).sum::<f64>() / counts.len() as f64;
    if counts.iter().all(|count| count.signed == signed) || total <= 0.0 {
        return Err(NoEstimate::Flat { count: signed as i64 });
    }
    let offset_ps = calibration_offset_ps(sensor, detector, tier);
    let phase = estimate_at(values, peak, sensor.timing(), offset_ps);

    let ones = share_of_ones(code);
    let sample_ps = sensor.clock().sample_period_ps();
    let seen = match tier {
        CountingTier::Events | CountingTier::Binned => 1.0,
        CountingTier::Sampled => (spad.pulse_width_ps / sample_ps).min(1.0),
    };
    let detected = total / sensor.timing().scan.integration_chips as f64 / seen;
    let dead_time = DeadTime::of(spad, sensor.clock().chips(spad.dead_time_ps));
    let mean = dead_time.primary(detected) * (1.0 - spad.afterpulsing_probability);
    let zeros = 1.0 - ones;
    if ones * zeros <= 0.0 {
        return Err(NoEstimate::NotModulated);
    }
    let contrast = (signed / total + zeros - ones) / (2.0 * ones * zeros);
    let rate = mean * contrast.clamp(LEAST_PATH_SHARE, MOST_PATH_SHARE / ones);
    Ok(FitParameters {
        paths: vec![PathParameters {
            code: Arc::clone(code),
            delay_chips: sensor.clock().chips(phase.delay_ps),
            ln_rate: rate.ln(),
        }],
        walk: None,
        constant: mean - rate * ones,
    })
}

/// What a path of the detector's own code adds to the signed counts of a scan, as blurred as the jitter makes it, ready to be held against them by least squares with the
/// counts' scatter: steps that share their light go together, and so do all under light of other clocks.
///
/// Steps are on a circle, the code period; those of a part of it are on one of twice as many, the other half empty.
#[derive(Debug)]
pub struct PeakShape {
    together: Vec<Together>,
    /// Transfer function that takes out what other clocks' light makes go together.
    whitening: Option<Vec<f64>>,
    /// Conjugate spectrum of the shape, whitened.
    shape: Vec<Complex64>,
    /// Weighed counts of one at all steps.
    of_constant: Vec<f64>,
    /// By the path's step, the height's standard deviations for a unit of the match there; 0 where the scan does not show it.
    sigmas: Vec<f64>,
    /// Of as many steps' counts the sum is as even as the height: 1 of steps that share their light.
    pub terms: f64,
}

/// What jitter, its mean taken off, leaves of a wave of so many radians per ps, by the characteristic function of its law.
fn blurred(spad: &Detector, wave_per_ps: f64) -> Complex64 {
    let delayed = |by_ps: f64| Complex64::cis(-wave_per_ps * by_ps);
    let tail = match &spad.jitter_tail {
        JitterTail::None => Complex64::ONE,
        JitterTail::Exponential { share, time_constant_ps } => {
            (1.0 - share) + share / Complex64::new(1.0, wave_per_ps * time_constant_ps)
        }
        JitterTail::Measured(curve) => {
            curve.points.iter().map(|[time_ps, share]| *share * delayed(*time_ps)).sum()
        }
    };
    let gaussian = (-0.5 * (wave_per_ps * spad.jitter_std_ps()).powi(2)).exp();
    gaussian * tail * delayed(-spad.jitter_tail.mean_ps())
}

/// Runs of so many steps whose scatter goes together, as that of no others does.
#[derive(Debug)]
struct Together {
    starts: Vec<usize>,
    /// Of their covariance, in units of a step's variance.
    inverse: DMatrix<f64>,
}

/// Jitter and afterpulses make counts differ beside what their signs do by such a share of their variance.
const BESIDE_SIGNS: f64 = 1e-3;

impl PeakShape {
    /// `beside` is the covariance that the signed counts of two steps so far apart have on average over a scan beside that of
    /// constant light, in units of the variance by that. With it steps that share their light are weighed as they are on average over
    /// where they are in their groups, which finds somewhat less than the covariance of each group.
    pub fn of(
        sensor: &Sensor,
        detector: DetectorIndex,
        beside: Option<&dyn Fn(usize) -> f64>,
    ) -> PeakShape {
        let (scan, clock) = (&sensor.timing().scan, sensor.clock());
        let code = sensor.reference(detector);
        let steps = scan.steps as usize;
        let circle = if scan.is_full() { steps } else { 2 * steps };
        let template = Template::new(code, code, 0.0).expect("a code is as long as itself");
        let at = |apart: f64| template.at(apart / f64::from(clock.samples_per_chip))[0];
        let behind = |place: usize| match place < steps {
            true => place as f64,
            false => place as f64 - circle as f64,
        };
        let mut shape = spectrum((0..circle).map(|place| at(behind(place))));
        let turn_ps = circle as f64 * clock.sample_period_ps();
        for (place, of) in shape.iter_mut().enumerate() {
            let turns =
                if 2 * place <= circle { place as f64 } else { place as f64 - circle as f64 };
            *of *= blurred(&sensor.scene().detectors[detector], TAU * turns / turn_ps);
        }
        let signs = 2.0 * code.weight() as f64 - code.len() as f64;
        let of_signs = |apart: usize| (2.0 * at(apart as f64) - signs) / code.len() as f64;
        let whitening = beside.map(|beside| {
            let lanes = sensor.timing().parallel as usize;
            let shared = |apart: usize| match apart < lanes {
                true => (lanes - apart) as f64 / lanes as f64 * of_signs(apart),
                false => 0.0,
            };
            whitening(steps, circle, shared, beside)
        });
        if let Some(whitening) = &whitening {
            shape.iter_mut().zip(whitening).for_each(|(of, by)| *of *= by);
        }
        let together = match whitening {
            None => Together::of(sensor.timing().grouping(), of_signs),
            Some(_) => {
                Together::of(Grouping { parallel: 1, ..sensor.timing().grouping() }, of_signs)
            }
        };
        let by_step = real(shape.clone());
        let mean = by_step.iter().sum::<f64>() / circle as f64;
        let power = |of: i32| by_step.iter().map(|value| (value - mean).powi(of)).sum::<f64>();
        let terms = match sensor.timing().parallel {
            1 => power(2).powi(2) / power(4),
            _ => 1.0,
        };
        let mut squares = vec![0.0; circle];
        for runs in &together {
            let of_run = spectrum((0..circle).map(|place| runs.product(&by_step, place)));
            let mut begins = vec![0.0; circle];
            runs.starts.iter().for_each(|&start| begins[start] = 1.0);
            let sums =
                correlated(&spectrum(begins.into_iter()), of_run.iter().map(Complex64::conj));
            squares.iter_mut().zip(sums).for_each(|(all, of)| *all += of);
        }
        shape.iter_mut().for_each(|of| *of = of.conj());
        let of_constant = weighed(&together, &vec![1.0; steps]);
        let padded = of_constant.iter().copied().chain(std::iter::repeat_n(0.0, circle - steps));
        let sums = correlated(&spectrum(padded), shape.iter().copied());
        let all: f64 = of_constant.iter().sum();
        let spread = squares.iter().zip(sums).map(|(squares, sum)| squares - sum * sum / all);
        let spread: Vec<f64> = spread.take(steps).collect();
        let least = NEXT_TO_NOTHING * squares.iter().copied().fold(0.0, f64::max);
        let sigma = |spread: f64| if spread > least { spread.sqrt().recip() } else { 0.0 };
        let sigmas = spread.into_iter().map(sigma).collect();
        PeakShape { together, whitening, shape, of_constant, sigmas, terms }
    }

    /// Number of the step at which the signed counts, plus or minus a constant, look most like the shape: of least squares of
    /// height and constant, the place where the height is the most standard deviations above zero; and how many, of counts of
    /// unit variance.
    ///
    /// Every step of the peak has light of its own, so that at low light this finds
    /// it where the largest single count misses: a triangle of 2 S steps has the
    /// signal-to-noise ratio of sqrt(2 S / 3) times the largest of them. Where all steps count the same light the two are
    /// nearly one.
    ///
    /// # Panics
    /// If there are not as many counts as the scan has steps.
    pub fn best_match(&self, signed: &[f64]) -> (usize, f64) {
        assert_eq!(signed.len(), self.of_constant.len(), "one count for each step");
        let steps = signed.len();
        let empty = self.shape.len() - steps;
        let padded =
            |values: Vec<f64>| spectrum(values.into_iter().chain(std::iter::repeat_n(0.0, empty)));
        let mut counts = signed.to_vec();
        if let Some(whitening) = &self.whitening {
            let mean = counts.iter().sum::<f64>() / steps as f64;
            counts.iter_mut().for_each(|count| *count -= mean);
            let by = whitening.iter().map(|&by| by.into());
            counts = correlated(&padded(counts), by);
            counts.truncate(steps);
        }
        let mut counts = weighed(&self.together, &counts);
        let mean = counts.iter().sum::<f64>() / self.of_constant.iter().sum::<f64>();
        counts.iter_mut().zip(&self.of_constant).for_each(|(count, one)| *count -= mean * one);
        let matched = correlated(&padded(counts), self.shape.iter().copied());
        let scores: Vec<f64> = matched.iter().zip(&self.sigmas).map(|(of, by)| of * by).collect();
        let peak = first_maximum(&scores);
        (peak, scores[peak])
    }
}

impl Together {
    /// The runs of a scan by how long they are, where signs so far apart have some correlation.
    fn of(grouping: Grouping, correlation: impl Fn(usize) -> f64) -> Vec<Together> {
        let mut starts: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for group in (0..grouping.groups()).map(Group) {
            let mut steps = grouping.steps_of(group);
            let length = steps.len();
            starts.entry(length).or_default().extend(steps.next().map(Step::index));
        }
        let of_length = |(length, starts)| {
            let covariance = DMatrix::from_fn(length, length, |a: usize, b: usize| {
                if a == b { 1.0 + BESIDE_SIGNS } else { correlation(a.abs_diff(b)) }
            });
            let inverse = covariance.cholesky().map(|factor| factor.inverse());
            let inverse = inverse.unwrap_or_else(|| DMatrix::identity(length, length));
            Together { starts, inverse }
        };
        starts.into_iter().map(of_length).collect()
    }

    /// Sum of squares of values round a circle, from a place on for a run, weighed.
    fn product(&self, values: &[f64], start: usize) -> f64 {
        let length = self.inverse.nrows();
        let at = |lane: usize| values[(start + lane) % values.len()];
        let values = DVector::from_fn(length, |lane, _| at(lane));
        values.dot(&(&self.inverse * &values))
    }
}

/// Values of all steps, weighed with the inverse of their covariance.
fn weighed(together: &[Together], values: &[f64]) -> Vec<f64> {
    let mut weighed = vec![0.0; values.len()];
    for Together { starts, inverse } in together {
        let length = inverse.nrows();
        if let [weight] = inverse.as_slice() {
            starts.iter().for_each(|&step| weighed[step] = weight * values[step]);
            continue;
        }
        for &start in starts {
            let run = start..start + length;
            let of = inverse * DVectorView::from_slice(&values[run.clone()], length);
            weighed[run].copy_from_slice(of.as_slice());
        }
    }
    weighed
}

/// Transfer function by which counts that go together with some covariance in constant light, and with another one beside,
/// scatter alone.
fn whitening(
    steps: usize,
    circle: usize,
    shared: impl Fn(usize) -> f64,
    beside: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let covariance = |apart: usize| match apart < steps {
        // So many pairs there are in a scan.
        true => shared(apart) + (steps - apart) as f64 / steps as f64 * beside(apart),
        false => 0.0,
    };
    let round = |place: usize| match place {
        0 => covariance(0),
        _ => covariance(place) + covariance(circle - place),
    };
    let power = spectrum((0..circle).map(round)).into_iter();
    power.map(|of| of.re.max(BESIDE_SIGNS).sqrt().recip()).collect()
}

/// Values that have the product of two spectra.
fn correlated(of: &[Complex64], with: impl Iterator<Item = Complex64>) -> Vec<f64> {
    real(of.iter().zip(with).map(|(of, with)| of * with).collect())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::scene::load_with;

    /// A sensor of code degree 5, and of each of its samples whether the laser is on.
    fn sensor(settings: &[&str]) -> (Sensor, Vec<bool>) {
        let settings = settings.iter().chain(&["source.code.degree=5"]);
        let settings: Vec<_> = settings.map(|s| s.parse().expect("a setting")).collect();
        let scene = load_with(Path::new("../scenes/quick.toml"), &settings).expect("sound");
        let sensor = Sensor::new(&scene);
        let samples = sensor.clock().samples_per_chip as usize;
        let chips = &sensor.reference(DetectorIndex(0)).chips;
        let on = chips.iter().flat_map(|&chip| vec![chip == 1; samples]).collect();
        (sensor, on)
    }

    /// The sign with which a photon in sample `sample` counts in step `step`.
    fn sign(on: &[bool], sample: usize, step: usize) -> f64 {
        if on[(sample + on.len() - step) % on.len()] { 1.0 } else { -1.0 }
    }

    fn shape(sensor: &Sensor) -> PeakShape {
        PeakShape::of(sensor, DetectorIndex(0), None)
    }

    /// Least squares of height and constant at each step, with the shape from the samples and each sum written out.
    struct LeastSquares {
        /// Weighed shapes less what a constant has of them, in standard deviations of the height.
        of_steps: Vec<DVector<f64>>,
    }

    impl LeastSquares {
        fn new(on: &[bool], weights: &DMatrix<f64>) -> LeastSquares {
            let lit: Vec<usize> = (0..on.len()).filter(|&sample| on[sample]).collect();
            let at = |apart: usize| -> f64 { lit.iter().map(|&of| sign(on, of, apart)).sum() };
            let shape: Vec<f64> = (0..on.len()).map(at).collect();
            let steps = weights.nrows();
            let ones = weights * DVector::from_element(steps, 1.0);
            let of_step = |peak: usize| {
                let at = |step: usize, _: usize| shape[(step + on.len() - peak) % on.len()];
                let shape = DVector::from_fn(steps, at);
                let beside = weights * &shape - &ones * (shape.dot(&ones) / ones.sum());
                let height = shape.dot(&beside).sqrt();
                beside / height
            };
            LeastSquares { of_steps: (0..steps).map(of_step).collect() }
        }

        fn best(&self, counts: &[f64]) -> usize {
            let counts = DVector::from_row_slice(counts);
            let scores: Vec<f64> = self.of_steps.iter().map(|of| of.dot(&counts)).collect();
            first_maximum(&scores)
        }
    }

    /// Of steps that go with no others, in scans of a whole period and of a part, with plain and interleaved codes.
    #[test]
    fn the_best_match_is_that_of_least_squares() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
        for settings in [
            &[][..],
            &["source.code.interleave=1"],
            &["scan.steps={ around = \"1.2 m\", halfwidth = 30 }"],
        ] {
            // Of half as many steps the sums that are written out are an eighth.
            let (sensor, on) = sensor(&[&["clock.samples_per_chip=4"], settings].concat());
            let (steps, shape) = (sensor.timing().scan.steps as usize, shape(&sensor));
            let expected = LeastSquares::new(&on, &DMatrix::identity(steps, steps));
            for _ in 0..8 {
                let counts: Vec<f64> =
                    (0..steps).map(|_| rng.random_range(-50.0..50.0_f64).round()).collect();
                assert_eq!(shape.best_match(&counts).0, expected.best(&counts), "{settings:?}");
            }
        }
    }

    /// Photons of a weak path and of background, counted in groups of steps: the best match is right as often as that of
    /// least squares with the covariance of the group's counts, and more often than the largest count, or than the best match
    /// were each step's light its own.
    #[test]
    fn weak_peaks_are_found_by_all_counts() {
        let (alone, on) = sensor(&[]);
        let lit: Vec<usize> = (0..on.len()).filter(|&sample| on[sample]).collect();
        let (steps, lanes, peak, scans) = (on.len(), 8, 101, 300);
        let together = alone.with(|scene| scene.hardware.parallel = lanes as u32);
        let shapes = [shape(&together), shape(&alone)];
        let covariance = DMatrix::from_fn(steps, steps, |a, b| match a / lanes == b / lanes {
            true => (0..steps).map(|at| sign(&on, at, a) * sign(&on, at, b)).sum::<f64>(),
            false => 0.0,
        });
        let weights = covariance.cholesky().expect("no two steps count the same").inverse();
        let exact = LeastSquares::new(&on, &weights);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
        let mut right = [0; 4];
        for _ in 0..scans {
            let mut counts = vec![0.0; steps];
            for (group, counts) in counts.chunks_mut(lanes).enumerate() {
                for photon in 0..1_800 {
                    let sample = match photon < 90 {
                        true => (lit[rng.random_range(0..lit.len())] + peak) % steps,
                        false => rng.random_range(0..steps),
                    };
                    for (lane, count) in counts.iter_mut().enumerate() {
                        *count += sign(&on, sample, group * lanes + lane);
                    }
                }
            }
            let found = [
                shapes[0].best_match(&counts).0,
                exact.best(&counts),
                shapes[1].best_match(&counts).0,
                first_maximum(&counts),
            ];
            for (right, found) in right.iter_mut().zip(found) {
                *right += usize::from(found.abs_diff(peak) < 8);
            }
        }
        let [best, exact, alone, largest] = right;
        assert!(best + scans / 100 >= exact, "{right:?}");
        assert!(best >= alone + scans / 20 && alone >= largest + scans / 5, "{right:?}");
    }
}
