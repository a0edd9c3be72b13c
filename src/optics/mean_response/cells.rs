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
}
