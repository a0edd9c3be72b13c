//! What was recorded of one detector, and what a scene lets one expect of it: counts of
//! phase steps, or bins of a histogram.

use super::expected::with_std;
use super::no_fit::NoFit;
use super::weights::{Whitening, tail};
use super::{RecordedHistogram, RecordedScan};
use crate::estimate::CountingTier;
use crate::estimate::histogram::dead_time;
use crate::estimate::report::{EstimateReport, estimate_histogram, estimate_scan};
use crate::histogram::correction::DeadTime;
use crate::histogram::correlation::Correlator;
use crate::histogram::innovations::{Innovations, deviance};
use crate::photons::{DetectorModel, StepCount};
use crate::response::{CountMoments, MeanCount, MeanResponse, SecondMoments};
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
                let code = sensor.reference(recorded.detector);
                let correlator = Correlator::new(code, sensor.clock().samples_per_chip);
                let total = recorded.histogram.total();
                let signed = correlator.signed_counts(&recorded.histogram).into_iter();
                signed.map(|signed| StepCount { signed, total }).collect()
            }
        }
    }

    /// What the sensor's estimator says of it.
    pub fn estimate(self, sensor: &Sensor) -> EstimateReport {
        match self {
            Observed::Steps(scan) => estimate_scan(sensor, scan.detector, &scan.counts),
            Observed::Bins(recorded) => {
                estimate_histogram(sensor, recorded.detector, &recorded.histogram)
            }
        }
    }

    /// Means of all numbers, of light that comes later by a delay.
    pub fn means(self, sensor: &Sensor, delay_ps: f64) -> Result<Vec<f64>, NoFit> {
        let model = DetectorModel::new(sensor, self.detector());
        let response = MeanResponse::of_tier(&model, CountingTier::Sampled)?;
        let delayed = response.delayed(delay_ps)?;
        Ok(match self {
            Observed::Steps(_) => flat(&delayed.mean_counts()),
            Observed::Bins(_) => delayed.mean_bins(),
        })
    }

    /// What a sensor lets one expect of light that comes later by a delay.
    pub fn expected(self, sensor: &Sensor, delay_ps: f64) -> Result<Expected, NoFit> {
        let model = DetectorModel::new(sensor, self.detector());
        let response = MeanResponse::of_tier(&model, CountingTier::Sampled)?;
        let delayed = response.delayed(delay_ps)?;
        Ok(match self {
            Observed::Steps(scan) => {
                let moments = SecondMoments::new(&delayed)?.of_scan();
                let mean = |moment: &CountMoments| [moment.signed_mean, moment.total_mean];
                Expected {
                    means: moments.iter().flat_map(mean).collect(),
                    scatter: Scatter::Steps { moments, has_totals: scan.has_totals },
                }
            }
            Observed::Bins(recorded) => Expected {
                means: delayed.mean_bins(),
                scatter: Scatter::Bins {
                    dead_time: dead_time(sensor, recorded.detector)?,
                    periods: recorded.histogram.periods() as f64,
                },
            },
        })
    }
}

fn flat(counts: &[MeanCount]) -> Vec<f64> {
    let pair = |count: &MeanCount| [count.signed, count.total];
    counts.iter().flat_map(pair).collect()
}

/// Means of all numbers, and how they scatter.
#[derive(Debug, Clone)]
pub(super) struct Expected {
    pub means: Vec<f64>,
    scatter: Scatter,
}

#[derive(Debug, Clone)]
enum Scatter {
    Steps { moments: Vec<CountMoments>, has_totals: bool },
    Bins { dead_time: DeadTime, periods: f64 },
}

impl Expected {
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

    /// Weights for other means: second moments that are known, of which those per detection
    /// change little.
    pub fn weights(&self, means: &[f64]) -> Result<Weights, NoFit> {
        Ok(match &self.scatter {
            Scatter::Steps { moments, has_totals } => {
                Weights::Steps(Whitening::of(&scaled(moments, means), *has_totals))
            }
            Scatter::Bins { dead_time, periods } => {
                Weights::Bins(Innovations::new(*dead_time, means, *periods)?)
            }
        })
    }

    /// How well numbers agree with what is expected.
    pub fn judge(&self, values: &[f64]) -> Result<Agreement, NoFit> {
        let deviations = differences(values, &self.means);
        Ok(match self.weights(&self.means)? {
            Weights::Steps(whitening) => {
                let whitened = whitening.whitened(pairs(&deviations));
                let chi_square = whitened.iter().map(|z| z * z).sum();
                Agreement {
                    chi_square,
                    numbers: whitened.len(),
                    excess_variance: whitening.excess_variance,
                    deviance: chi_square + whitening.ln_determinant,
                    whitened,
                }
            }
            Weights::Bins(innovations) => of_bins(values, &deviations, &innovations)?,
        })
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

/// Bins are Poisson numbers of the means that those before let one expect: their likelihood
/// holds where hardly any bin counts at all. The chi-square is of sums of neighbours.
fn of_bins(
    values: &[f64],
    deviations: &[f64],
    innovations: &Innovations,
) -> Result<Agreement, NoFit> {
    let expected = innovations.expected(values, deviations)?;
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
pub(super) enum Weights {
    Steps(Whitening),
    Bins(Innovations),
}

impl Weights {
    pub fn whitened(&self, deviations: &[f64]) -> Result<Vec<f64>, NoFit> {
        Ok(match self {
            Weights::Steps(whitening) => whitening.whitened(pairs(deviations)),
            Weights::Bins(innovations) => innovations.whitened(deviations)?,
        })
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

/// Second moments that are known, for other means.
fn scaled(known: &[CountMoments], means: &[f64]) -> Vec<CountMoments> {
    let scaled = known.iter().zip(pairs(means)).map(|(known, mean)| {
        let more = mean.total / known.total_mean.max(f64::MIN_POSITIVE);
        CountMoments {
            signed_mean: mean.signed,
            total_mean: mean.total,
            signed_variance: known.signed_variance * more,
            total_variance: known.total_variance * more,
            covariance: (known.covariance - known.signed_mean) * more + mean.signed,
        }
    });
    scaled.collect()
}
