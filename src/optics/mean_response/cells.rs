//! A solution, cell by cell, readable at any place inside.

use super::chain::State;

/// Values and slopes at the borders of one cell.
#[derive(Debug, Clone)]
pub struct SolvedCell {
    pub start: State,
    pub end: State,
    pub start_slope: State,
    pub end_slope: State,
    pub width: f64,
}

impl SolvedCell {
    /// Value at a position 0..=1, by the cubic that fits values and slopes.
    pub fn at(&self, position: f64) -> State {
        let x = position;
        let end = x * x * (3.0 - 2.0 * x);
        let start_slope = x * (1.0 - x) * (1.0 - x) * self.width;
        let end_slope = x * x * (x - 1.0) * self.width;
        std::array::from_fn(|m| {
            self.start[m] * (1.0 - end)
                + self.end[m] * end
                + self.start_slope[m] * start_slope
                + self.end_slope[m] * end_slope
        })
    }
}

/// Solved cells in the order of solving, of which only the last chips are kept
/// where no more is needed than one dead time.
#[derive(Debug, Clone)]
pub struct History {
    cells: Vec<SolvedCell>,
    cells_per_chip: usize,
    reach_chips: usize,
    dropped_chips: usize,
}

impl History {
    /// Nothing solved yet; `reach_chips` is how far back it will be read.
    pub fn new(cells_per_chip: usize, reach_chips: usize) -> History {
        History {
            cells: Vec::new(),
            cells_per_chip,
            reach_chips,
            dropped_chips: 0,
        }
    }

    pub fn push(&mut self, cell: SolvedCell) {
        self.cells.push(cell);
    }

    /// The cell that was solved as number `cell` of chip `chip`.
    pub fn get(&self, chip: usize, cell: usize) -> &SolvedCell {
        &self.cells[(chip - self.dropped_chips) * self.cells_per_chip + cell]
    }

    /// Drops chips beyond reach, once they are as many as those within; to be
    /// called between chips.
    pub fn forget(&mut self) {
        let chips = self.cells.len() / self.cells_per_chip;
        if chips > 2 * self.reach_chips {
            self.drop_chips(chips - self.reach_chips);
        }
    }

    /// The cells from chip `first` on.
    pub fn into_cells_from(mut self, first: usize) -> Vec<SolvedCell> {
        self.drop_chips(first - self.dropped_chips);
        self.cells
    }

    fn drop_chips(&mut self, chips: usize) {
        self.cells.drain(..chips * self.cells_per_chip);
        self.dropped_chips += chips;
    }
}

#[cfg(test)]
mod tests {
    use super::super::chain::STATES;
    use super::*;

    #[test]
    fn a_cubic_is_reproduced() {
        let cubic = |t: f64| 2.0 - t + 3.0 * t * t - 0.5 * t * t * t;
        let slope = |t: f64| -1.0 + 6.0 * t - 1.5 * t * t;
        let cell = SolvedCell {
            start: [cubic(1.0); STATES],
            end: [cubic(1.5); STATES],
            start_slope: [slope(1.0); STATES],
            end_slope: [slope(1.5); STATES],
            width: 0.5,
        };
        for x in [0.0, 0.3, 0.5, 1.0] {
            assert!((cell.at(x)[0] - cubic(1.0 + 0.5 * x)).abs() < 1e-14);
        }
    }

    #[test]
    fn forgetting_leaves_the_last_chips_in_place() {
        let cell = |value: usize| SolvedCell {
            start: [value as f64; STATES],
            end: [0.0; STATES],
            start_slope: [0.0; STATES],
            end_slope: [0.0; STATES],
            width: 1.0,
        };
        let mut history = History::new(2, 3);
        for chip in 0..20 {
            history.forget();
            history.push(cell(2 * chip));
            history.push(cell(2 * chip + 1));
            for back in 0..=chip.min(3) {
                let found = history.get(chip - back, 1).start[0];
                assert_eq!(found, (2 * (chip - back) + 1) as f64);
            }
        }
        assert!(history.cells.len() <= 2 * 7);
        let rest = history.into_cells_from(18);
        assert_eq!(rest.len(), 4);
        assert_eq!(rest[0].start[0], 36.0);
    }
}
