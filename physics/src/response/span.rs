//! Stretches of chips over which pairs of detections are summed.

use std::ops::Range;

use super::grid::Grid;

/// Chips in which pairs of detections are looked for.
pub struct Span {
    /// Chip of the code period with which it begins.
    pub first_chip: usize,
    /// Chips, from that one on, in which a pair may begin.
    pub begun: usize,
    /// Chips, from that one on, in which it may end.
    pub counted: Range<usize>,
}

impl Span {
    /// Pairs that begin within a code period and end whenever they do.
    pub fn of_period(grid: &Grid) -> Span {
        let period = grid.period_chips;
        Span { first_chip: 0, begun: period, counted: 0..period + grid.memory_chips }
    }

    /// Pairs that begin in the chips before chip `end` of the code period, and end after it.
    pub fn across(grid: &Grid, end: usize, reach: PairReach) -> Span {
        let whole_periods = reach.before.next_multiple_of(grid.period_chips);
        let first_chip = (end + whole_periods - reach.before) % grid.period_chips;
        let counted = reach.before..reach.before + reach.after;
        Span { first_chip, begun: reach.before, counted }
    }
}

/// Chips before and after the end of a step in which pairs of detections lie that it divides.
#[derive(Debug, Clone, Copy)]
pub struct PairReach {
    pub before: usize,
    pub after: usize,
}
