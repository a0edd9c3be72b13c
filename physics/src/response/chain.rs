//! The chain of pending afterpulses.

use crate::photons::afterpulsing::Afterpulsing;

/// One value per number of pending afterpulses, 0..M; the last stands for "or
/// more".
pub type State<const M: usize> = [f64; M];

/// What happens between an avalanche and the end of its dead time.
#[derive(Debug, Clone)]
pub struct Chain<const M: usize> {
    /// Rate at which one pending afterpulse fires, per chip.
    release_per_chip: f64,
    /// `transition[j][m]`: probability that m are pending at the end of the
    /// dead time, if j were pending right after the avalanche.
    transition: [State<M>; M],
}

/// How many states a detector's afterpulses need.
///
/// Right after the dead time of a saturated detector the number pending is
/// about Poisson with mean mu / (1 - survival), mu new ones per avalanche. The
/// states are enough if more come up in less than one avalanche in 20,000: they
/// are still counted as pending, only not all of them.
pub fn states_needed(afterpulsing: Option<Afterpulsing>, dead_time_chips: f64) -> usize {
    let Some(afterpulsing) = afterpulsing else {
        return 1;
    };
    let survival = (-dead_time_chips / afterpulsing.time_constant_chips).exp();
    let mean = afterpulsing.mean_per_avalanche / (1.0 - survival).max(1e-9);
    let mut term = (-mean).exp();
    let mut below = 0.0;
    let mut states = 0;
    // Bounded, because for a very large mean the terms vanish from the start.
    while 1.0 - below > 5e-5 && states < 1_000 {
        below += term;
        states += 1;
        term *= mean / states as f64;
    }
    states
}

impl<const M: usize> Chain<M> {
    pub fn new(afterpulsing: Option<Afterpulsing>, dead_time_chips: f64) -> Chain<M> {
        let (release_per_chip, mean) = afterpulsing
            .map_or((0.0, 0.0), |a| (1.0 / a.time_constant_chips, a.mean_per_avalanche));
        let survival = (-dead_time_chips * release_per_chip).exp();
        let mut transition = [[0.0; M]; M];
        for (pending, row) in transition.iter_mut().enumerate() {
            let mut poisson = (-mean).exp();
            for new in 0..M {
                for survivors in 0..=pending {
                    let both = poisson * binomial(pending, survivors, survival);
                    row[(new + survivors).min(M - 1)] += both;
                }
                poisson *= mean / (new + 1) as f64;
            }
            // What the cut Poisson series lacks belongs to the last state.
            row[M - 1] += 1.0 - row.iter().sum::<f64>();
        }
        Chain { release_per_chip, transition }
    }

    /// Rate at which the ready state with `pending` afterpulses is left.
    pub fn exit_rate(&self, lambda: f64, pending: usize) -> f64 {
        lambda + pending as f64 * self.release_per_chip
    }

    /// `[i][m]`: rate at which avalanches out of ready state i lead to m pending
    /// when the dead time is over. A photon leaves i pending, an afterpulse one
    /// less. A row sums to the state's exit rate.
    pub fn passage_rates(&self, lambda: f64) -> [State<M>; M] {
        std::array::from_fn(|i| {
            std::array::from_fn(|m| {
                let released = match i {
                    0 => 0.0,
                    _ => i as f64 * self.release_per_chip * self.transition[i - 1][m],
                };
                lambda * self.transition[i][m] + released
            })
        })
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
        let chain = Chain::<6>::new(afterpulsing, 1.75);
        let new = -(0.863_f64.ln());
        let survival = (-14.0_f64 / 5.0).exp();
        for pending in 0..3 {
            let row = &chain.transition[pending];
            assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let mean: f64 = row.iter().enumerate().map(|(m, p)| m as f64 * p).sum();
            assert!((mean - new - pending as f64 * survival).abs() < 1e-6);
        }
        assert!((chain.transition[0][0] - 0.863).abs() < 1e-14);
        let passage = chain.passage_rates(0.3);
        for (pending, row) in passage.iter().enumerate() {
            let exit = chain.exit_rate(0.3, pending);
            assert!((row.iter().sum::<f64>() - exit).abs() < 1e-13);
        }
    }

    #[test]
    fn without_afterpulsing_nothing_is_pending() {
        let chain = Chain::<3>::new(None, 1.75);
        assert_eq!(chain.transition[0], [1.0, 0.0, 0.0]);
        assert_eq!(chain.exit_rate(0.3, 2), 0.3);
        assert_eq!(states_needed(None, 1.75), 1);
    }

    #[test]
    fn table_i_needs_few_states_and_stronger_afterpulsing_more() {
        let table_i = states_needed(Afterpulsing::new(0.137, 0.625), 1.75);
        assert!(table_i == 4, "{table_i}");
        let strong = states_needed(Afterpulsing::new(0.5, 0.625), 1.75);
        assert!((5..=8).contains(&strong), "{strong}");
        assert!(states_needed(Afterpulsing::new(0.999, 10.0), 0.1) > 16);
    }
}
