//! How far the adversary may go.

/// Most clocks on the way to one cover point.
const MOST_CLOCKS_OF_RECIPE: u64 = 1 << 22;
/// Most where a host talks: its scans of long codes cannot be shortened.
const MOST_CLOCKS_OF_TALK: u64 = 1 << 23;
/// Clocks before the second reset, at least.
const CALM_CLOCKS: u64 = 10_000;

/// How far the adversary may go.
#[derive(Debug, Clone, Copy)]
pub struct Means {
    /// The scan's counters can be moved on ([`Skip`](crate::reference::predictor::Skip)).
    pub skips: bool,
    /// Most clocks on the way to one cover point.
    pub most_clocks_of_recipe: u64,
    /// The same where a host talks.
    pub most_clocks_of_talk: u64,
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
            most_clocks_of_talk: MOST_CLOCKS_OF_TALK,
            calm_clocks: CALM_CLOCKS,
            clocks_of_large_counts: MOST_CLOCKS_OF_RECIPE,
            clocks_of_close_counts: MOST_CLOCKS_OF_RECIPE,
        }
    }

    /// Most clocks on the way to one cover point, without a host and with one.
    pub(super) fn most_clocks(&self) -> [u64; 2] {
        [self.most_clocks_of_recipe, self.most_clocks_of_talk]
    }
}
