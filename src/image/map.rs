//! Maps: a number for each pixel.

/// A number for each pixel, row by row; NaN where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// Pixels of a row.
    pub columns: usize,
    /// The numbers.
    pub values: Vec<f64>,
}

impl Map {
    /// From the numbers of all pixels, row by row.
    pub fn new(columns: u32, values: Vec<f64>) -> Map {
        Map { columns: columns as usize, values }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.columns.max(1)
    }

    /// Those that are numbers.
    pub fn known(&self) -> impl Iterator<Item = f64> + '_ {
        self.values.iter().copied().filter(|value| value.is_finite())
    }

    /// The number that this share of all does not exceed; none of an empty map.
    pub fn quantile(&self, share: f64) -> Option<f64> {
        let mut known: Vec<f64> = self.known().collect();
        known.sort_by(f64::total_cmp);
        let place = share * known.len().checked_sub(1)? as f64;
        known.get(place.round() as usize).copied()
    }

    /// Mean of those that are numbers; none of an empty map.
    pub fn mean(&self) -> Option<f64> {
        let (sum, count) =
            self.known().fold((0.0, 0_usize), |(sum, n), value| (sum + value, n + 1));
        (count > 0).then(|| sum / count as f64)
    }
}
