//! The `counts` tier: counts drawn from their moments, without photons.

use rand_distr::{Binomial, Distribution, Gamma, Poisson, StandardNormal};
use rayon::prelude::*;

use super::MeanResponseError;
use super::group_counts::{GroupLaw, MOST_COUNTS};
use super::moments::{CountMoments, SecondMoments};
use crate::photons::counter::StepCount;
use crate::photons::detector::DetectorModel;
use crate::photons::random::{RandomStream, StreamRng};
use crate::scan::Group;

/// Up and down counts whose means are this many standard deviations above zero
/// are drawn as a pair of normal values: less than one in a million would have
/// been negative.
const NORMAL_FROM_SIGMAS: f64 = 5.0;

/// Draws the counts of phase steps from their means, variances and covariance.
///
/// The counts upwards and downwards, U = (N + r) / 2 and W = (N - r) / 2, are
/// drawn, so that r and N are always possible together. Where both means are at
/// least five standard deviations, (U, W) is normal, rounded to whole numbers,
/// with variances less the 1/12 that rounding adds. Elsewhere U and W are sums of
/// a common Poisson number, whose mean is their covariance if that is positive
/// (afterpulses of one direction in the other), and of numbers of their own:
/// binomial, Poisson or negative binomial by whether the variance is below, at or
/// above the mean. Means and variances of U and W are kept, a negative covariance is
/// not.
///
/// Phase steps that are correlated at once share their detections: their counts
/// are drawn together, always as normal numbers.
#[derive(Debug, Clone)]
pub struct CountSampler<'m> {
    model: &'m DetectorModel,
    laws: Laws,
}

/// The distributions of a scan's counts.
#[derive(Debug, Clone)]
enum Laws {
    Steps(Vec<Law>),
    Groups(Vec<GroupLaw>),
}

/// The distribution of one step's counts.
#[derive(Debug, Clone)]
enum Law {
    /// U = mean + a z1, W = mean + b z1 + c z2 with normal z1, z2.
    Normal {
        up: f64,
        down: f64,
        factor: [f64; 3],
    },
    Small(Box<SmallLaw>),
}

/// U = common + up, W = common + down.
#[derive(Debug, Clone, Copy)]
struct SmallLaw {
    common: Single,
    up: Single,
    down: Single,
}

/// The distribution of one whole number.
#[derive(Debug, Clone, Copy)]
enum Single {
    Never,
    Poisson(Poisson<f64>),
    Binomial(Binomial),
    /// A Poisson number whose mean is gamma-distributed.
    NegativeBinomial(Gamma<f64>),
}

impl<'m> CountSampler<'m> {
    /// A sampler for scans with these moments, one per step of the scan, each
    /// step with light of its own.
    ///
    /// # Errors
    /// When moments are no finite numbers.
    pub fn new(
        model: &'m DetectorModel,
        moments: &[CountMoments],
    ) -> Result<CountSampler<'m>, MeanResponseError> {
        let laws = moments.iter().map(Law::of).collect::<Result<_, _>>()?;
        Ok(CountSampler { model, laws: Laws::Steps(laws) })
    }

    /// A sampler for scans with these moments, whatever the number of phase steps
    /// at once.
    ///
    /// # Errors
    /// When moments are no finite numbers.
    pub fn of(
        model: &'m DetectorModel,
        moments: &SecondMoments,
    ) -> Result<CountSampler<'m>, MeanResponseError> {
        if model.timing.parallel == 1 {
            return CountSampler::new(model, &moments.of_scan());
        }
        let groups = (0..model.timing.groups())
            .into_par_iter()
            .map(|group| GroupLaw::of(&moments.of_group(Group(group))))
            .collect::<Result<_, _>>()?;
        Ok(CountSampler { model, laws: Laws::Groups(groups) })
    }

    /// Counts of all steps of scan number `repetition`. They depend on the
    /// arguments alone.
    pub fn scan(&self, seed: u64, repetition: u64) -> Vec<StepCount> {
        let stream = |group| {
            let key = self.model.key(seed, repetition, Group(group));
            key.stream(RandomStream::Counts)
        };
        match &self.laws {
            Laws::Steps(laws) => {
                // One step at a time: each is a group.
                let draw = |(law, group): (&Law, u64)| law.draw(&mut stream(group)).into();
                laws.iter().zip(0..).map(draw).collect()
            }
            Laws::Groups(laws) => {
                let draw = |(law, group): (&GroupLaw, u64)| law.draw(&mut stream(group));
                laws.iter().zip(0..).flat_map(draw).collect()
            }
        }
    }
}

impl Law {
    fn of(moments: &CountMoments) -> Result<Law, MeanResponseError> {
        let CountMoments { total_mean, signed_variance, total_variance, covariance, .. } = *moments;
        if !(total_mean < MOST_COUNTS
            && (moments.signed_mean + signed_variance + total_variance + covariance).is_finite())
        {
            return Err(MeanResponseError::NotDrawn);
        }
        let up = 0.5 * (moments.total_mean + moments.signed_mean);
        let down = 0.5 * (moments.total_mean - moments.signed_mean);
        let both = 0.25 * (moments.total_variance + moments.signed_variance);
        let up_variance = both + 0.5 * moments.covariance;
        let down_variance = both - 0.5 * moments.covariance;
        let between = 0.25 * (moments.total_variance - moments.signed_variance);
        let rounding = 1.0 / 12.0;
        let (a, b) = (up_variance - rounding, down_variance - rounding);
        let is_normal = up > NORMAL_FROM_SIGMAS * up_variance.max(1.0).sqrt()
            && down > NORMAL_FROM_SIGMAS * down_variance.max(1.0).sqrt()
            && a > 0.0
            && a * b > between * between;
        Ok(if is_normal {
            let first = a.sqrt();
            let second = between / first;
            Law::Normal { up, down, factor: [first, second, (b - second * second).sqrt()] }
        } else {
            let common = between.clamp(0.0, up.min(down).max(0.0));
            Law::Small(Box::new(SmallLaw {
                common: Single::of(common, common),
                up: Single::of(up - common, up_variance - common),
                down: Single::of(down - common, down_variance - common),
            }))
        })
    }

    fn draw(&self, rng: &mut StreamRng) -> (u64, u64) {
        match self {
            Law::Normal { up, down, factor } => {
                let first: f64 = StandardNormal.sample(rng);
                let second: f64 = StandardNormal.sample(rng);
                // The cast takes what is negative to zero.
                (
                    (up + factor[0] * first).round() as u64,
                    (down + factor[1] * first + factor[2] * second).round() as u64,
                )
            }
            Law::Small(small) => {
                let common = small.common.draw(rng);
                (common + small.up.draw(rng), common + small.down.draw(rng))
            }
        }
    }
}

impl From<(u64, u64)> for StepCount {
    /// From counts upwards and downwards.
    fn from((up, down): (u64, u64)) -> StepCount {
        StepCount { signed: up as i64 - down as i64, total: up + down }
    }
}

impl Single {
    fn of(mean: f64, variance: f64) -> Single {
        let chosen = if mean <= 0.0 {
            None
        } else if variance < 0.999 * mean {
            // n p = mean, 1 - p = variance / mean; n is whole, the mean kept.
            let trials = (mean / (1.0 - (variance / mean).max(0.0))).round().max(1.0);
            let success = (mean / trials).min(1.0);
            Binomial::new(trials as u64, success).ok().map(Single::Binomial)
        } else if variance > 1.001 * mean {
            let scale = variance / mean - 1.0;
            Gamma::new(mean / scale, scale).ok().map(Single::NegativeBinomial)
        } else {
            Poisson::new(mean).ok().map(Single::Poisson)
        };
        chosen.unwrap_or(Single::Never)
    }

    fn draw(&self, rng: &mut StreamRng) -> u64 {
        match self {
            Single::Never => 0,
            Single::Poisson(poisson) => poisson.sample(rng) as u64,
            Single::Binomial(binomial) => binomial.sample(rng),
            Single::NegativeBinomial(gamma) => {
                let mean: f64 = gamma.sample(rng);
                // A gamma number of tiny shape may round to zero.
                Poisson::new(mean).map_or(0, |poisson| poisson.sample(rng) as u64)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photons::random::StreamKey;

    /// Mean, variance and covariance of draws, within five standard errors.
    fn check(moments: CountMoments, is_normal: bool) {
        let law = Law::of(&moments).expect("a law");
        assert_eq!(matches!(law, Law::Normal { .. }), is_normal);
        let key = StreamKey { seed: 5, detector: 0, group: Group(0), repetition: 0 };
        let mut rng = key.stream(RandomStream::Counts);
        let draws = 200_000;
        let mut sums = [0.0; 5];
        for _ in 0..draws {
            let (up, down) = law.draw(&mut rng);
            let r = up as f64 - down as f64 - moments.signed_mean;
            let n = (up + down) as f64 - moments.total_mean;
            for (sum, value) in sums.iter_mut().zip([r, n, r * r, n * n, r * n]) {
                *sum += value / f64::from(draws);
            }
        }
        let error = |variance: f64| 5.0 * (variance / f64::from(draws)).sqrt();
        assert!(sums[0].abs() < error(moments.signed_variance), "{sums:?}");
        assert!(sums[1].abs() < error(moments.total_variance), "{sums:?}");
        // Fourth moments of skew small numbers may be several times the normal's.
        let fourth = if is_normal { 2.0 } else { 8.0 };
        let scale = moments.signed_variance.max(moments.total_variance);
        let limit = error(fourth * scale * scale);
        assert!((sums[2] - moments.signed_variance).abs() < limit, "{sums:?}");
        assert!((sums[3] - moments.total_variance).abs() < limit, "{sums:?}");
        assert!((sums[4] - moments.covariance).abs() < limit, "{sums:?}");
    }

    #[test]
    fn large_counts_have_the_asked_moments() {
        check(
            CountMoments {
                signed_mean: 300.0,
                total_mean: 1000.0,
                signed_variance: 850.0,
                total_variance: 600.0,
                covariance: 150.0,
            },
            true,
        );
    }

    #[test]
    fn small_counts_keep_means_variances_and_what_they_share() {
        for (up, up_variance, down, down_variance, between) in [
            (3.0, 3.9, 1.0, 1.3, 0.0),
            (4.0, 3.0, 2.0, 1.5, 0.0),
            (0.5, 0.5, 0.0, 0.0, 0.0),
            (18.0, 21.0, 9.0, 10.0, 2.5),
            (8.0, 7.0, 4.0, 4.2, 1.0),
        ] {
            let variance = up_variance + down_variance;
            check(
                CountMoments {
                    signed_mean: up - down,
                    total_mean: up + down,
                    signed_variance: variance - 2.0 * between,
                    total_variance: variance + 2.0 * between,
                    covariance: up_variance - down_variance,
                },
                false,
            );
        }
    }
}
