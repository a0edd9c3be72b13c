//! How far the adversary may go.

/// Most clocks on the way to one cover point.
const MOST_CLOCKS_OF_RECIPE: u64 = 1 << 22;
/// Clocks before the second reset, at least.
const CALM_CLOCKS: u64 = 10_000;

/// How far the adversary may go.
#[derive(Debug, Clone, Copy)]
pub struct Means {
    /// The scan's counters can be moved on ([`Skip`](crate::reference::predictor::Skip)).
    pub skips: bool,
    /// Most clocks on the way to one cover point.
    pub most_clocks_of_recipe: u64,
    /// Clocks in peace at the beginning, at least.
    pub calm_clocks: u64,
    /// Clocks behind them, at most, of counts that are as large as they get.
    pub clocks_of_large_counts: u64,
    /// Clocks behind these, at most, of totals that hardly differ, and as many of peaks.
    pub clocks_of_close_counts: u64,
}

impl Means {
    /// Of a co-simulation.
    pub fn cosim(skips: bool) -> Means {
        Means {
            skips,
            most_clocks_of_recipe: MOST_CLOCKS_OF_RECIPE,
            calm_clocks: CALM_CLOCKS,
            clocks_of_large_counts: MOST_CLOCKS_OF_RECIPE,
            clocks_of_close_counts: MOST_CLOCKS_OF_RECIPE,
        }
    }
}
