//! The distribution of one step's signed count.

use std::f64::consts::PI;

use crate::estimate::expected_counts::ExpectedCounts;
use crate::math::normal_cdf;
use crate::response::MeanCount;
use crate::scan::Step;
use crate::scene::Detector;

/// Beyond so many standard deviations a tail is taken as a normal one's, which is nothing, of variances from here on:
/// of few hits two in a step are many standard deviations, and not seldom.
const REACH_STD: f64 = 12.0;
const LEAST_VARIANCE: f64 = 100.0;

/// Clusters' cumulants are taken up to this share of where they end.
const NEAR_ONE: f64 = 1.0 - 1e-9;
/// Saddlepoints are looked for up to here: counts of one direction have theirs at
/// infinity.
const FARTHEST: f64 = 40.0;

/// A signed count with exact mean and variance, and the tails of counts that come in
/// clusters: avalanches of the light, each followed by its afterpulses, all with signs
/// of their own.
///
/// Without afterpulses it is the difference of two Poisson numbers. The tails matter:
/// the largest of 16,000 counts lies four standard deviations out, where at 40
/// detections the clusters of Table I's detector make it 30 % more likely than a normal
/// number would.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountLaw {
    pub mean: f64,
    pub variance: f64,
    /// Mean number of detections.
    pub total: f64,
    /// Mean afterpulses of an avalanche.
    pub afterpulses: f64,
}

/// Cumulant generating function of the clusters at one place, and two derivatives.
struct Generated {
    value: f64,
    slope: f64,
    curvature: f64,
}

impl CountLaw {
    /// That of a step of a detector with some means, and a variance of its signed count.
    pub fn of(spad: &Detector, mean: &MeanCount, variance: f64) -> CountLaw {
        let (mean, total) = (mean.signed, mean.total);
        CountLaw { mean, variance, total, afterpulses: spad.afterpulses_per_avalanche() }
    }

    /// That of a step with so many detections, whose clusters alone make the variance.
    pub fn of_clusters(mean: f64, total: f64, afterpulses: f64) -> CountLaw {
        let law = CountLaw { mean, variance: 0.0, total, afterpulses };
        CountLaw { variance: law.generated(0.0).curvature, ..law }
    }

    pub fn std(&self) -> f64 {
        self.variance.sqrt()
    }

    /// Of clusters as of a branching process, each of n detections by Borel's
    /// distribution: G(z) = z exp(m (G - 1)) generates n, z = u e^s + (1 - u) e^-s the
    /// sign of one detection, K(s) = N (1 - m) (G(z) - 1) their sum.
    fn generated(&self, s: f64) -> Generated {
        let up = self.upward();
        let (plus, minus) = (up * s.exp(), (1.0 - up) * (-s).exp());
        let (z, dz) = (plus + minus, plus - minus);
        let m = self.clustering();
        // ln g - m (g - 1) = ln z has its root below 1 / m; Newton's steps come to it
        // from below.
        let mut g = z.min(1.0);
        for _ in 0..60 {
            let step = (z.ln() - g.ln() + m * (g - 1.0)) / (1.0 / g - m);
            let most = if m > 0.0 { NEAR_ONE / m } else { f64::INFINITY };
            let next = (g + step).clamp(0.1 * g, most.max(g));
            let is_done = (next - g).abs() < 1e-13 * g;
            g = next;
            if is_done {
                break;
            }
        }
        // d ln G / d ln z, and its derivative by ln z.
        let gain = 1.0 / (1.0 - m * g);
        let bend = gain * gain * gain * m * g;
        let log_slope = dz / z;
        let log_curvature = 1.0 - log_slope * log_slope;
        let clusters = self.total * (1.0 - m);
        let slope = gain * log_slope;
        Generated {
            value: clusters * (g - 1.0),
            slope: clusters * g * slope,
            curvature: clusters
                * g
                * (slope * slope + bend * log_slope * log_slope + gain * log_curvature),
        }
    }

    /// Share of the detections that count upwards.
    fn upward(&self) -> f64 {
        (0.5 * (1.0 + self.mean / self.total)).clamp(0.0, 1.0)
    }

    /// P(count < y) for y half-way between two whole numbers; between those the
    /// smooth curve through them.
    ///
    /// By the saddlepoint K'(s) = y with the lattice's correction (Lugannani and Rice
    /// 1980; Daniels 1987), of the clusters' count, whose deviations are stretched to
    /// the exact variance.
    pub fn below(&self, y: f64) -> f64 {
        if self.variance <= 0.0 {
            return f64::from(y > self.mean);
        }
        let z = (y - self.mean) / self.std();
        let is_beyond = z.abs() > REACH_STD && self.variance > LEAST_VARIANCE;
        if is_beyond || self.total <= 0.0 {
            return normal_cdf(z);
        }
        let at_zero = self.generated(0.0);
        let of_clusters = at_zero.slope + z * at_zero.curvature.sqrt();
        let Some((s, there)) = self.saddlepoint(of_clusters) else {
            // Beyond what can be counted at all.
            return f64::from(z > 0.0);
        };
        let w = (2.0 * (s * of_clusters - there.value)).max(0.0).sqrt() * s.signum();
        let correction = if w.abs() < 2e-3 {
            self.cumulants()[0] / 6.0
        } else {
            1.0 / w - 1.0 / (2.0 * (0.5 * s).sinh() * there.curvature.sqrt())
        };
        let density = (-0.5 * w * w).exp() / (2.0 * PI).sqrt();
        (normal_cdf(w) + density * correction).clamp(0.0, 1.0)
    }

    /// P(count > y): as [`CountLaw::below`], and as precise however small it is.
    pub fn above(&self, y: f64) -> f64 {
        CountLaw { mean: -self.mean, ..*self }.below(-y)
    }

    /// Afterpulses of an avalanche, as far as clusters end: the variance is exact all
    /// the same.
    fn clustering(&self) -> f64 {
        self.afterpulses.min(0.5)
    }

    /// Between which s the clusters' cumulants exist: where G(z) < 1 / m.
    fn limits(&self) -> [f64; 2] {
        let (m, up) = (self.clustering(), self.upward());
        if m <= 0.0 {
            return [-FARTHEST, FARTHEST];
        }
        let z = (m - 1.0).exp() / m;
        let root = (z * z - 4.0 * up * (1.0 - up)).max(0.0).sqrt();
        // u e^2s - z e^s + 1 - u = 0.
        let [low, high] = [2.0 * (1.0 - up) / (z + root), (z + root) / (2.0 * up)];
        [low.ln().max(-FARTHEST), high.ln().min(FARTHEST)]
    }

    /// Where K'(s) = y: Newton's steps, and halves of the bracket where these leave it.
    fn saddlepoint(&self, y: f64) -> Option<(f64, Generated)> {
        let [mut low, mut high] = self.limits();
        let mut s = 0.0;
        for _ in 0..100 {
            let there = self.generated(s);
            if there.slope < y {
                low = s;
            } else {
                high = s;
            }
            let next = s + (y - there.slope) / there.curvature;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let is_done = (next - s).abs() < 1e-9;
            s = next;
            if is_done {
                break;
            }
        }
        let there = self.generated(s);
        // Short of y at the rim: not to be had by any count.
        let is_there = (there.slope - y).abs() < 0.1 + 0.01 * y.abs();
        is_there.then_some((s, there))
    }

    /// Skewness and excess kurtosis of the clusters' count.
    fn cumulants(&self) -> [f64; 2] {
        const STEP: f64 = 0.02;
        let [low, middle, high] = [-STEP, 0.0, STEP].map(|s| self.generated(s).curvature);
        if middle <= 0.0 {
            return [0.0; 2];
        }
        [
            (high - low) / (2.0 * STEP) / middle.powf(1.5),
            (high - 2.0 * middle + low) / (STEP * STEP) / (middle * middle),
        ]
    }

    /// What turns a standard normal number into this count's deviation, in standard
    /// deviations: third-order polynomial of Cornish and Fisher (1938), from its
    /// constant term on.
    pub fn deviation_of_normal(&self) -> [f64; 4] {
        // A step without any light counts 0.
        if self.total <= 0.0 {
            return [0.0, 1.0, 0.0, 0.0];
        }
        let [skewness, kurtosis] = self.cumulants();
        let (skew, kurt, square) = (skewness / 6.0, kurtosis / 24.0, skewness * skewness / 36.0);
        [-skew, 1.0 - 3.0 * kurt + 5.0 * square, skew, kurt - 2.0 * square]
    }

    /// Mean and variance of the count if it is known to be below `y`, for a normal
    /// one.
    pub fn given_below(&self, y: f64) -> (f64, f64) {
        let std = self.std();
        let z = (y - self.mean) / std;
        if z > 8.0 {
            return (self.mean, self.variance);
        }
        if z < -8.0 {
            // The tail is exponential, of slope |z|.
            return (y + std / z, (std / z).powi(2));
        }
        let ratio = (-0.5 * z * z).exp() / (2.0 * PI).sqrt() / normal_cdf(z);
        let variance = self.variance * (1.0 - z * ratio - ratio * ratio).max(0.0);
        (self.mean - std * ratio, variance)
    }
}

/// Scans of more steps are worked out by FFT.
const STEPS_ONE_BY_ONE: usize = 400;

/// The laws of a scan's counts.
///
/// Variances change little from step to step: of short scans they are worked out at
/// every half chip, and are straight between.
pub fn laws(counts: &ExpectedCounts, spad: &Detector) -> Vec<CountLaw> {
    let steps = counts.means.len();
    let variances = if steps > STEPS_ONE_BY_ONE {
        let moments = counts.second.of_scan();
        moments.iter().map(|m| m.signed_variance).collect()
    } else {
        between(counts, steps, counts.model().timing.clock.samples_per_chip.div_ceil(2) as usize)
    };
    let steps = counts.means.iter().zip(variances);
    steps.map(|(mean, variance)| CountLaw::of(spad, mean, variance)).collect()
}

/// Variances of every `stride`-th step and the last, and those between.
fn between(counts: &ExpectedCounts, steps: usize, stride: usize) -> Vec<f64> {
    let known = |index: usize| (index * stride).min(steps - 1);
    let asked: Vec<Step> = (0..=steps.div_ceil(stride)).map(|i| Step::at(known(i))).collect();
    let moments = counts.second.of_steps(&asked);
    (0..steps)
        .map(|step| {
            let early = step / stride;
            let (from, to) = (known(early), known(early + 1));
            let share = (step - from) as f64 / (to - from).max(1) as f64;
            let [a, b] = [early, early + 1].map(|index| moments[index].signed_variance);
            a + share * (b - a)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P(count = x) for x = -300..=300: clusters are added one number at a time
    /// (Panjer's recursion would do for positive sums only, so by convolution of the
    /// Poisson-many clusters of each size).
    fn exact(mean: f64, total: f64, m: f64) -> Vec<f64> {
        const REACH: i64 = 300;
        let up = 0.5 * (1.0 + mean / total);
        let place = |x: i64| (x + REACH) as usize;
        let mut chances = vec![0.0; 2 * REACH as usize + 1];
        chances[place(0)] = 1.0;
        let mut factorial = 1.0;
        for n in 1_i64..=12 {
            factorial *= n as f64;
            // Borel's distribution.
            let size = (-m * n as f64).exp() * (m * n as f64).powi(n as i32 - 1) / factorial;
            let mut ways = 1.0;
            for ups in 0..=n {
                let rate = total
                    * (1.0 - m)
                    * size
                    * ways
                    * up.powi(ups as i32)
                    * (1.0 - up).powi((n - ups) as i32);
                chances = add_poisson(&chances, rate, 2 * ups - n);
                ways *= (n - ups) as f64 / (ups + 1) as f64;
            }
        }
        chances
    }

    /// Adds `jump` times a Poisson number.
    fn add_poisson(chances: &[f64], rate: f64, jump: i64) -> Vec<f64> {
        let mut sum = vec![0.0; chances.len()];
        let mut term = (-rate).exp();
        for k in 0..200_i64 {
            for (x, chance) in chances.iter().enumerate() {
                let to = x as i64 + k * jump;
                if (0..chances.len() as i64).contains(&to) {
                    sum[to as usize] += term * chance;
                }
            }
            term *= rate / (k + 1) as f64;
            if term < 1e-18 && k as f64 > rate {
                break;
            }
        }
        sum
    }

    #[test]
    fn tails_are_those_of_counts_in_clusters() {
        for (mean, total, m, limit) in [
            (0.0, 3.0, 0.0, 0.03),
            (2.0, 10.0, 0.0, 0.01),
            (0.0, 40.0, 0.147, 0.03),
            (20.0, 40.0, 0.147, 0.03),
            (0.0, 0.02, 0.0, 0.15),
        ] {
            let (law, exact) = (CountLaw::of_clusters(mean, total, m), exact(mean, total, m));
            // Of hardly any hits, up to three in a step.
            let places = -3..=if total < 1.0 { 14 } else { 5 };
            for z in places {
                let x = (mean + f64::from(z) * law.std()).round() as i64;
                let below: f64 = exact[..(x + 301) as usize].iter().sum();
                let tail = below.min(1.0 - below);
                let found = law.below(x as f64 + 0.5);
                let error = (found - below).abs();
                assert!(error < limit * tail + 1e-9, "{mean} {total} {m} {x}: {found} {below}");
            }
        }
    }

    #[test]
    fn the_chance_grows_with_the_count_however_far_out_and_however_few() {
        for (mean, total, variance) in
            [(4.5, 7.5, 6.5), (-0.3, 0.8, 0.9), (0.5, 0.8, 0.7), (7.0, 7.0, 5.0)]
        {
            let law = CountLaw { mean, variance, total, afterpulses: 0.147 };
            let mut before = 0.0;
            for x in -40..60 {
                let below = law.below(f64::from(x) + 0.5);
                assert!((before - 0.02..=1.0).contains(&below), "{law:?} {x}: {before} {below}");
                before = below;
            }
            assert!(law.below(-60.5) < 1e-6 && before > 1.0 - 1e-6, "{before}");
        }
    }

    #[test]
    fn cumulants_are_those_of_the_jumps() {
        // No clusters: every cumulant of even order is the number of detections.
        let plain = CountLaw::of_clusters(0.0, 50.0, 0.0);
        assert!((plain.variance - 50.0).abs() < 1e-9);
        assert!(plain.cumulants()[0].abs() < 1e-9);
        assert!((plain.cumulants()[1] - 1.0 / 50.0).abs() < 1e-5);
        // E n = 1 / (1 - m), E n (n - 1) = E n^2 - E n with Var n = m / (1 - m)^3; the
        // fourth moment of n signs is 3 n^2 - 2 n.
        let m = 0.147_f64;
        let clustered = CountLaw::of_clusters(0.0, 50.0, m);
        let second = m / (1.0 - m).powi(3) + (1.0 - m).powi(-2);
        let fourth = 50.0 * (1.0 - m) * (3.0 * second - 2.0 / (1.0 - m));
        let found = clustered.cumulants()[1] * 2500.0;
        assert!((found / fourth - 1.0).abs() < 1e-3, "{found} {fourth}");
    }

    #[test]
    fn a_count_known_to_be_below_its_mean_is_half_a_normal_one() {
        let law = CountLaw { variance: 9.0, ..CountLaw::of_clusters(10.0, 20.0, 0.0) };
        let (mean, variance) = law.given_below(10.0);
        // Half-normal: sqrt(2 / pi) and 1 - 2 / pi.
        assert!((mean - (10.0 - 3.0 * (2.0 / PI).sqrt())).abs() < 1e-9);
        assert!((variance - 9.0 * (1.0 - 2.0 / PI)).abs() < 1e-9);
        assert_eq!(law.given_below(100.0), (10.0, 9.0));
        let (mean, variance) = law.given_below(-30.0);
        assert!(mean < -30.0 && mean > -30.5 && variance < 0.1);
    }

    /// A step without any light counts 0 in every scan: it has no cumulants beyond a normal number's.
    #[test]
    fn a_count_of_no_light_has_no_shape_of_its_own() {
        let nothing = CountLaw { mean: 0.0, variance: 0.0, total: 0.0, afterpulses: 0.137 };
        assert_eq!(nothing.deviation_of_normal(), [0.0, 1.0, 0.0, 0.0]);
    }
}
