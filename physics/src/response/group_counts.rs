//! Counts of phase steps that see the same light, drawn together.

use rand_distr::{Distribution, StandardNormal};

use super::MeanResponseError;
use super::moments::GroupMoments;
use crate::math::correlating;
use crate::photons::counter::StepCount;
use crate::photons::random::StreamRng;

/// Counts that a double tells from the next: 2^53.
pub(super) const MOST_COUNTS: f64 = 9_007_199_254_740_992.0;

/// The distribution of the counts of one group: the number of all detections,
/// and for each step those of them that count upwards, as correlated normal
/// numbers, rounded.
#[derive(Debug, Clone)]
pub struct GroupLaw {
    /// Means of the counts upwards of each step and, last, of all detections.
    means: Vec<f64>,
    /// Rows of the lower triangle L of covariance = L L^T.
    factor: Vec<Vec<f64>>,
}

impl GroupLaw {
    /// # Errors
    /// When the moments are no finite numbers, or no counts have them.
    pub fn of(moments: &GroupMoments) -> Result<GroupLaw, MeanResponseError> {
        let count = moments.signed_means.len();
        let r = &moments.covariance;
        let total = r[count][count];
        let mut covariance = vec![vec![0.0; count + 1]; count + 1];
        for a in 0..=count {
            for b in 0..=a {
                covariance[a][b] = match (a == count, b == count) {
                    (true, true) => total,
                    (true, false) => 0.5 * (r[count][b] + total),
                    _ => 0.25 * (r[a][b] + r[a][count] + r[b][count] + total),
                };
            }
        }
        let mut means: Vec<f64> =
            moments.signed_means.iter().map(|signed| 0.5 * (moments.total_mean + signed)).collect();
        means.push(moments.total_mean);
        if !means.iter().all(|mean| mean.abs() < MOST_COUNTS) {
            return Err(MeanResponseError::NotDrawn);
        }
        // Rounding to whole numbers adds 1/12.
        let factor = correlating(&covariance, 1.0 / 12.0).ok_or(MeanResponseError::NotDrawn)?;
        Ok(GroupLaw { means, factor })
    }

    /// Counts of every step of the group.
    pub fn draw(&self, rng: &mut StreamRng) -> Vec<StepCount> {
        let normal: Vec<f64> = (0..self.means.len()).map(|_| StandardNormal.sample(rng)).collect();
        let values: Vec<f64> = self
            .means
            .iter()
            .zip(&self.factor)
            .map(|(mean, row)| mean + row.iter().zip(&normal).map(|(f, z)| f * z).sum::<f64>())
            .collect();
        let (total, ups) = match values.split_last() {
            Some((total, ups)) => (total.round().clamp(0.0, MOST_COUNTS), ups),
            None => (0.0, &values[..]),
        };
        ups.iter()
            .map(|up| {
                let up = up.round().clamp(0.0, total);
                StepCount { signed: (2.0 * up - total) as i64, total: total as u64 }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photons::random::{RandomStream, StreamKey};
    use crate::scan::Group;

    #[test]
    fn a_group_draws_the_asked_means_and_covariances() {
        // Detections of three kinds, 400, 500 and 900 on average, which count in
        // two steps as ++, +- and --: Poisson, so covariances are signed sums.
        let kinds = [(400.0, [1.0, 1.0]), (500.0, [1.0, -1.0]), (900.0, [-1.0, -1.0])];
        let sum = |f: &dyn Fn([f64; 3]) -> f64| -> f64 {
            kinds.iter().map(|(n, [a, b])| n * f([*a, *b, 1.0])).sum()
        };
        let covariance: Vec<Vec<f64>> =
            (0..3).map(|i| (0..3).map(|j| sum(&|s| s[i] * s[j])).collect()).collect();
        let means: Vec<f64> = (0..3).map(|i| sum(&|s| s[i])).collect();
        let law = GroupLaw::of(&GroupMoments {
            signed_means: means[..2].to_vec(),
            total_mean: means[2],
            covariance: covariance.clone(),
        })
        .expect("a law");
        let key = StreamKey { seed: 8, detector: 0, group: Group(0), repetition: 0 };
        let mut rng = key.stream(RandomStream::Counts);
        let draws = 100_000;
        let mut products = [[0.0; 3]; 3];
        let mut sums = [0.0; 3];
        for _ in 0..draws {
            let counts = law.draw(&mut rng);
            assert_eq!(counts[0].total, counts[1].total);
            let values = [counts[0].signed, counts[1].signed, counts[0].total as i64];
            let off: [f64; 3] = std::array::from_fn(|i| values[i] as f64 - means[i]);
            for i in 0..3 {
                sums[i] += off[i];
                for j in 0..3 {
                    products[i][j] += off[i] * off[j];
                }
            }
        }
        let n = f64::from(draws);
        for i in 0..3 {
            let error = 5.0 * (covariance[i][i] / n).sqrt();
            assert!((sums[i] / n).abs() < error, "{sums:?}");
            for j in 0..3 {
                // Variance of a product of normal numbers; rounding of the counts
                // upwards adds 4/12 to r, of which 1/12 each was taken off.
                let spread = covariance[i][i] * covariance[j][j] + covariance[i][j].powi(2);
                let limit = 5.0 * (spread / n).sqrt() + 0.5;
                let found = products[i][j] / n;
                assert!((found - covariance[i][j]).abs() < limit, "{i} {j}: {found}");
            }
        }
    }
}
