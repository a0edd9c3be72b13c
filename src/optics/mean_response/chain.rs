//! The chain of pending afterpulses.

use crate::optics::afterpulsing::Afterpulsing;

/// States 0..STATES of pending afterpulses; the last stands for "or more".
pub const STATES: usize = 6;

/// One value per state.
pub type State = [f64; STATES];

/// What happens between an avalanche and the end of its dead time.
#[derive(Debug, Clone)]
pub struct Chain {
    /// Rate at which one pending afterpulse fires, per chip.
    pub release_per_chip: f64,
    /// `transition[j][m]`: probability that m are pending at the end of the
    /// dead time, if j were pending right after the avalanche.
    pub transition: [State; STATES],
}

impl Chain {
    pub fn new(afterpulsing: Option<Afterpulsing>, dead_time_chips: f64) -> Chain {
        let (release_per_chip, mean) = afterpulsing.map_or((0.0, 0.0), |a| {
            (1.0 / a.time_constant_chips, a.mean_per_avalanche)
        });
        let survival = (-dead_time_chips * release_per_chip).exp();
        let mut transition = [[0.0; STATES]; STATES];
        for (pending, row) in transition.iter_mut().enumerate() {
            let mut poisson = (-mean).exp();
            for new in 0..STATES {
                for survivors in 0..=pending {
                    let both = poisson * binomial(pending, survivors, survival);
                    row[(new + survivors).min(STATES - 1)] += both;
                }
                poisson *= mean / (new + 1) as f64;
            }
            // What the cut Poisson series lacks belongs to the last state.
            row[STATES - 1] += 1.0 - row.iter().sum::<f64>();
        }
        Chain {
            release_per_chip,
            transition,
        }
    }

    /// Avalanche rates a_j from the probabilities of the ready states.
    pub fn avalanche_rates(&self, lambda: f64, ready: &State) -> State {
        std::array::from_fn(|j| {
            let released = ready.get(j + 1).map_or(0.0, |p| (j + 1) as f64 * p);
            lambda * ready[j] + self.release_per_chip * released
        })
    }

    /// Rate at which the ready state with `pending` afterpulses is left.
    pub fn exit_rate(&self, lambda: f64, pending: usize) -> f64 {
        lambda + pending as f64 * self.release_per_chip
    }
}

/// Probability of `k` successes in `n` trials.
fn binomial(n: usize, k: usize, success: f64) -> f64 {
    let ways = (0..k).fold(1.0, |ways, i| ways * (n - i) as f64 / (i + 1) as f64);
    ways * success.powi(k as i32) * (1.0 - success).powi((n - k) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_distributions_with_the_right_mean() {
        let afterpulsing = Afterpulsing::new(0.137, 0.625);
        let chain = Chain::new(afterpulsing, 1.75);
        let new = -(0.863_f64.ln());
        let survival = (-14.0_f64 / 5.0).exp();
        for pending in 0..3 {
            let row = &chain.transition[pending];
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let mean: f64 = row.iter().enumerate().map(|(m, p)| m as f64 * p).sum();
            assert!((mean - new - pending as f64 * survival).abs() < 1e-6);
        }
        assert!((chain.transition[0][0] - 0.863).abs() < 1e-14);
    }

    #[test]
    fn without_afterpulsing_nothing_is_pending() {
        let chain = Chain::new(None, 1.75);
        assert_eq!(chain.transition[0], [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(chain.exit_rate(0.3, 2), 0.3);
    }
}
