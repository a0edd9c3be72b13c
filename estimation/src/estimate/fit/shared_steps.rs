//! The counts of phase steps that share their light.

use crate::response::{GroupMoments, MeanCount};

/// Steps of a problem that count the same light.
#[derive(Debug, Clone)]
pub struct SharedSteps {
    /// Their places among the problem's steps.
    pub places: Vec<usize>,
    /// Moments of their counts.
    pub moments: GroupMoments,
}

impl SharedSteps {
    /// The same steps where they expect other counts: covariances go with the
    /// detections, and those with the total with the signed counts as its variance goes
    /// with it.
    pub fn expecting(&self, means: &[MeanCount]) -> SharedSteps {
        let there = &self.moments;
        let signed_means: Vec<f64> = self.places.iter().map(|&p| means[p].signed).collect();
        let total_mean = self.places.first().map_or(0.0, |&p| means[p].total);
        let share = total_mean / there.total_mean.max(f64::MIN_POSITIVE);
        let mut covariance = there.covariance.clone();
        covariance.iter_mut().flatten().for_each(|c| *c *= share);
        let total = self.places.len();
        let total_variance =
            there.covariance[total][total] / there.total_mean.max(f64::MIN_POSITIVE);
        for (lane, (here, there)) in signed_means.iter().zip(&there.signed_means).enumerate() {
            let with_total = covariance[lane][total] + total_variance * (here - there * share);
            covariance[lane][total] = with_total;
            covariance[total][lane] = with_total;
        }
        SharedSteps {
            places: self.places.clone(),
            moments: GroupMoments { signed_means, total_mean, covariance },
        }
    }
}
