//! The recorded counts of one detector, and their expectation by a scene: counts of
//! phase steps, or bins of a histogram.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use super::expected::with_std;
use super::{RecordedHistogram, RecordedScan};
use crate::estimate::CountingTier;
use crate::estimate::fit::FitError;
use crate::estimate::fit::moments::StepMomentsPerDetection;
use crate::estimate::fit::weights::Weights;
use crate::estimate::histogram::{PhaseOfHistogram, dead_time};
use crate::estimate::report::{EstimateReport, Reporter};
use crate::histogram::correction::BinnedDetector;
use crate::histogram::innovations::{Innovations, deviance};
use crate::photons::{DetectorModel, StepCount};
use crate::response::{CountMoments, MeanCount, MeanResponse, SecondMoments, SolvedPairs};
use crate::scene::DetectorIndex;
use crate::sensor::Sensor;

/// Neighbouring bins are summed for the chi-square until this many hits are expected in
/// each sum: its distribution is known well where sums are not small.
pub const HITS_OF_A_SUM: f64 = 5.0;

/// What was recorded of one detector.
#[derive(Debug, Clone, Copy)]
pub(super) enum Observed<'o> {
    /// Counts of a scan's phase steps.
    Steps(&'o RecordedScan),
    /// Bins of a histogram.
    Bins(&'o RecordedHistogram),
}

impl Observed<'_> {
    pub fn detector(self) -> DetectorIndex {
        match self {
            Observed::Steps(scan) => scan.detector,
            Observed::Bins(recorded) => recorded.detector,
        }
    }

    /// Phase steps of the scan, or of the code period.
    pub fn phase_steps(self) -> usize {
        match self {
            Observed::Steps(scan) => scan.counts.len(),
            Observed::Bins(recorded) => recorded.histogram.bins().len(),
        }
    }

    /// Whether light level and background can be told from what moves the peak.
    pub fn tells_light(self) -> bool {
        match self {
            Observed::Steps(scan) => scan.has_totals,
            Observed::Bins(_) => true,
        }
    }

    /// All numbers: signed and total count of step after step, or the bins.
    pub fn values(self) -> Vec<f64> {
        match self {
            Observed::Steps(scan) => scan
                .counts
                .iter()
                .flat_map(|count| [count.signed as f64, count.total as f64])
                .collect(),
            Observed::Bins(recorded) => {
                let bins = recorded.histogram.bins().iter();
                bins.map(|&count| count as f64).collect()
            }
        }
    }

    /// Counts of the scan's phase steps, which follow from bins.
    pub fn step_counts(self, sensor: &Sensor) -> Vec<StepCount> {
        match self {
            Observed::Steps(scan) => scan.counts.clone(),
            Observed::Bins(recorded) => {
                PhaseOfHistogram::new(sensor, recorded.detector, CountingTier::Sampled)
                    .step_counts(&recorded.histogram)
            }
        }
    }

    /// What the sensor's estimator says of it.
    pub fn estimate(self, reporter: &Reporter) -> EstimateReport {
        match self {
            Observed::Steps(scan) => reporter.scan(&scan.counts),
            Observed::Bins(recorded) => reporter.histogram(&recorded.histogram),
        }
    }

    /// Means of all numbers that a detector answers.
    pub fn means(self, response: &MeanResponse) -> Vec<f64> {
        match self {
            Observed::Steps(_) => {
                let counts = response.mean_counts();
                counts.iter().flat_map(|count| [count.signed, count.total]).collect()
            }
            Observed::Bins(_) => response.mean_bins(),
        }
    }

    /// The expectation of a sensor, for light that comes later by a delay.
    pub fn expected(self, sensor: &Sensor, delay_ps: f64) -> Result<ExpectedNumbers, FitError> {
        let model = DetectorModel::new(sensor, self.detector());
        let delayed = response(&model)?.delayed(delay_ps)?;
        Ok(match self {
            Observed::Steps(scan) => {
                ExpectedNumbers::of_steps(&SecondMoments::new(&delayed)?, scan.has_totals)
            }
            Observed::Bins(recorded) => ExpectedNumbers {
                means: delayed.mean_bins(),
                scatter: Scatter::Bins {
                    dead_time: dead_time(sensor, recorded.detector)?,
                    periods: recorded.histogram.periods() as f64,
                },
            },
        })
    }
}

/// What a detector answers to its scene's light.
pub(super) fn response(model: &DetectorModel) -> Result<MeanResponse<'_>, FitError> {
    Ok(MeanResponse::of_tier(model, CountingTier::Sampled)?)
}

/// Means of all numbers, and how they scatter.
#[derive(Debug, Clone)]
pub(super) struct ExpectedNumbers {
    pub means: Vec<f64>,
    scatter: Scatter,
}

#[derive(Debug, Clone)]
enum Scatter {
    Steps { moments: Vec<CountMoments>, solved: SolvedPairs, has_totals: bool },
    Bins { dead_time: BinnedDetector, periods: f64 },
}

impl ExpectedNumbers {
    fn of_steps(second: &SecondMoments, has_totals: bool) -> ExpectedNumbers {
        let moments = second.of_scan();
        let mean = |moment: &CountMoments| [moment.signed_mean, moment.total_mean];
        ExpectedNumbers {
            means: moments.iter().flat_map(mean).collect(),
            scatter: Scatter::Steps { moments, solved: second.solved(), has_totals },
        }
    }

    /// The expectation of the same light with another delay, to which a detector answers so, counted for as
    /// long; without another solution for how counts scatter, which are second moments nearly.
    pub fn delayed(&self, answer: &MeanResponse, times: f64) -> Result<ExpectedNumbers, FitError> {
        Ok(match &self.scatter {
            Scatter::Steps { solved, has_totals, .. } => {
                let second = SecondMoments::of_delayed(solved, answer)?;
                ExpectedNumbers::of_steps(&second, *has_totals).in_times(times)
            }
            bins @ Scatter::Bins { .. } => {
                let means = answer.mean_bins().into_iter().map(|mean| mean * times);
                ExpectedNumbers { means: means.collect(), scatter: bins.clone() }
            }
        })
    }

    /// The same of a scan with or without totals.
    pub fn with_totals(mut self, has: bool) -> ExpectedNumbers {
        if let Scatter::Steps { has_totals, .. } = &mut self.scatter {
            *has_totals = has;
        }
        self
    }

    /// The same of so many times the integration time: every moment grows with it.
    pub fn in_times(mut self, times: f64) -> ExpectedNumbers {
        self.means.iter_mut().for_each(|mean| *mean *= times);
        match &mut self.scatter {
            Scatter::Steps { moments, .. } => {
                moments.iter_mut().for_each(|moment| *moment = moment.in_times(times));
            }
            Scatter::Bins { periods, .. } => *periods *= times,
        }
        self
    }

    /// Mean and standard deviation of every phase step's signed count, or of every bin.
    pub fn each(&self) -> Vec<[f64; 2]> {
        match &self.scatter {
            Scatter::Steps { moments, .. } => moments
                .iter()
                .map(|moment| [moment.signed_mean, moment.signed_variance.max(0.0).sqrt()])
                .collect(),
            Scatter::Bins { periods, .. } => with_std(&self.means, *periods),
        }
    }

    /// Hits of a phase step on average, or of the whole histogram.
    pub fn hits(&self) -> f64 {
        match &self.scatter {
            Scatter::Steps { moments, .. } => {
                let hits: f64 = moments.iter().map(|step| step.total_mean).sum();
                hits / moments.len().max(1) as f64
            }
            Scatter::Bins { .. } => self.means.iter().sum(),
        }
    }

    /// What whitens deviations from other means: second moments per detection change little.
    pub fn whitening(&self, means: &[f64]) -> Result<Whitening, FitError> {
        Ok(match &self.scatter {
            Scatter::Steps { moments, has_totals, .. } => {
                Whitening::Steps(weights(moments, *has_totals, means))
            }
            Scatter::Bins { dead_time, periods } => {
                Whitening::Bins(Innovations::new(*dead_time, means, *periods)?)
            }
        })
    }

    /// How well numbers agree with what is expected.
    pub fn judge(&self, values: &[f64]) -> Result<Agreement, FitError> {
        let deviations = differences(values, &self.means);
        match &self.scatter {
            Scatter::Steps { moments, has_totals, .. } => {
                let weights = weights(moments, *has_totals, &self.means);
                let whitened = weights.whitened(&pairs(&deviations).collect());
                let chi_square = whitened.iter().map(|z| z * z).sum();
                let fourth = moments.iter().map(|moment| fourth_cumulants(moment, *has_totals));
                Ok(Agreement {
                    chi_square,
                    numbers: whitened.len(),
                    excess_variance: fourth.sum(),
                    deviance: chi_square + weights.ln_determinant(),
                    whitened,
                })
            }
            Scatter::Bins { dead_time, periods } => {
                let innovations = Innovations::new(*dead_time, &self.means, *periods)?;
                of_bins(values, &deviations, &innovations)
            }
        }
    }
}

/// How well numbers agree with what is expected of them.
#[derive(Debug, Clone)]
pub(super) struct Agreement {
    /// Residuals in standard deviations: of each step one, or two with totals; of each bin one.
    pub whitened: Vec<f64>,
    pub chi_square: f64,
    /// Squares that it is the sum of.
    pub numbers: usize,
    /// What small counts add to its variance.
    excess_variance: f64,
    /// Twice the negative logarithm of the likelihood, less a constant.
    pub deviance: f64,
}

impl Agreement {
    /// Chance of a chi-square at least as large, with so many degrees of freedom.
    pub fn p_value(&self, degrees: usize) -> Option<f64> {
        tail(self.chi_square, degrees, self.excess_variance)
    }
}

/// Bins are Poisson numbers whose means follow from the bins before: this likelihood holds even if
/// hardly any bin counts at all. The chi-square is of sums of neighbours.
fn of_bins(
    values: &[f64],
    deviations: &[f64],
    innovations: &Innovations,
) -> Result<Agreement, FitError> {
    let expected = innovations.given(values, deviations)?.expected;
    let mut agreement = Agreement {
        whitened: innovations.whitened(deviations)?,
        chi_square: 0.0,
        numbers: 0,
        excess_variance: 0.0,
        deviance: deviance(values, &expected),
    };
    let (mut sum, mut hits) = (0.0, 0.0);
    for (z, mean) in agreement.whitened.iter().zip(innovations.means()) {
        let innovation = z * mean.sqrt();
        sum += innovation;
        hits += mean;
        if hits >= HITS_OF_A_SUM {
            agreement.chi_square += sum * sum / hits;
            agreement.numbers += 1;
            agreement.excess_variance += 1.0 / hits;
            (sum, hits) = (0.0, 0.0);
        }
    }
    Ok(agreement)
}

/// What makes deviations independent, of unit variance.
pub(super) enum Whitening {
    Steps(Weights),
    Bins(Innovations),
}

impl Whitening {
    pub fn whitened(&self, deviations: &[f64]) -> Result<Vec<f64>, FitError> {
        Ok(match self {
            Whitening::Steps(weights) => weights.whitened(&pairs(deviations).collect()),
            Whitening::Bins(innovations) => innovations.whitened(deviations)?,
        })
    }
}

/// Weights of steps that expect some means, from second moments at other means.
fn weights(moments: &[CountMoments], has_totals: bool, means: &[f64]) -> Weights {
    let scaled = moments.iter().zip(pairs(means));
    let scaled =
        scaled.map(|(known, mean)| StepMomentsPerDetection::from_moments(known).expecting(&mean));
    let scaled: Vec<CountMoments> = scaled.collect();
    match has_totals {
        true => Weights::of(&scaled),
        false => Weights::of_signed(&scaled),
    }
}

/// Signed and total counts, step by step.
fn pairs(values: &[f64]) -> impl Iterator<Item = MeanCount> {
    let pair = |pair: &[f64]| MeanCount { signed: pair[0], total: pair[1] };
    values.chunks_exact(2).map(pair)
}

pub(super) fn differences(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Chance of a chi-square at least this large, by a scaled chi-square distribution
/// with its mean and variance (Satterthwaite): squares of small counts scatter
/// more than those of normal numbers.
fn tail(chi_square: f64, degrees: usize, excess_variance: f64) -> Option<f64> {
    if degrees == 0 {
        return None;
    }
    let mean = degrees as f64;
    let variance = 2.0 * mean + excess_variance;
    let distribution = ChiSquared::new(2.0 * mean * mean / variance).ok()?;
    Some(distribution.sf(chi_square * 2.0 * mean / variance))
}

/// Sum of the fourth cumulants of a step's whitened counts that chi-square's variance
/// has beyond that of normal ones, as if hits up and hits down were Poisson numbers.
fn fourth_cumulants(moment: &CountMoments, has_totals: bool) -> f64 {
    let [a, b, c] = match moment.whitening() {
        [of_signed, ..] if !has_totals => [of_signed, 0.0, 0.0],
        of_both => of_both,
    };
    let up = 0.5 * (moment.total_mean + moment.signed_mean);
    let down = 0.5 * (moment.total_mean - moment.signed_mean);
    let of_hit = |sign: f64| (a * a + (b * sign + c) * (b * sign + c)).powi(2);
    up.max(0.0) * of_hit(1.0) + down.max(0.0) * of_hit(-1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn poisson(up: f64, down: f64) -> CountMoments {
        CountMoments {
            signed_mean: up - down,
            total_mean: up + down,
            signed_variance: up + down,
            total_variance: up + down,
            covariance: up - down,
        }
    }

    #[test]
    fn chi_square_has_its_tabulated_quantiles_where_counts_are_large() {
        // Abramowitz and Stegun, table 26.8: 18.307 for 10 degrees at 5 %.
        let excess_variance = 10.0 * fourth_cumulants(&poisson(1e9, 1e9), false);
        let p = tail(18.307, 10, excess_variance).unwrap();
        assert!((p - 0.05).abs() < 1e-5, "{p}");
        assert_eq!(tail(1.0, 0, excess_variance), None);
    }

    /// A Poisson number's squared deviation in variances has the variance 2 + 1/mean.
    #[test]
    fn small_counts_widen_chi_square_as_their_fourth_moment_says() {
        let mean = 0.7;
        // Only hits up, so that the signed count is the Poisson number.
        let signed = fourth_cumulants(&poisson(mean, 0.0), false);
        assert!((signed - 1.0 / mean).abs() < 1e-12);
        // Hits up and down apart: U and W each have theirs.
        let both = fourth_cumulants(&poisson(3.0, 3.0), true);
        // r and N with variance 6 each, uncorrelated; each hit has both squares 1/6.
        assert!((both - 6.0 * (2.0 / 6.0_f64).powi(2)).abs() < 1e-12);
    }
}
