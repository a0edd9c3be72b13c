//! The last chips of a solution, as far back as one dead time reads.

use super::grid::GridInterpolation;
use super::several::Number;

/// Values and slopes at the borders of one cell: value at start and end, slope
/// at start and end.
pub type Borders<const M: usize, V> = [[V; M]; 4];

/// A ring of solved cells, in the order of solving; a power of two of chips, so
/// that going round it is a mask and no division.
#[derive(Debug, Clone)]
pub struct History<const M: usize, V> {
    cells: Vec<Borders<M, V>>,
    cells_per_chip: usize,
    chip_mask: usize,
}

impl<const M: usize, V: Number> History<M, V> {
    /// Nothing solved yet; `reach_chips` is how far back it will be read.
    pub fn new(cells_per_chip: usize, reach_chips: usize) -> History<M, V> {
        let chips = (reach_chips + 2).next_power_of_two();
        History {
            cells: vec![[[V::default(); M]; 4]; chips * cells_per_chip],
            cells_per_chip,
            chip_mask: chips - 1,
        }
    }

    /// Keeps cell `cell` of chip `chip`, in place of the oldest.
    #[inline(always)]
    pub fn put(&mut self, chip: usize, cell: usize, borders: Borders<M, V>) {
        let index = (chip & self.chip_mask) * self.cells_per_chip + cell;
        self.cells[index] = borders;
    }

    /// The cells of chip `chip`.
    pub fn of_chip(&self, chip: usize) -> &[Borders<M, V>] {
        let first = (chip & self.chip_mask) * self.cells_per_chip;
        &self.cells[first..first + self.cells_per_chip]
    }

    /// The same, to be changed.
    pub fn of_chip_mut(&mut self, chip: usize) -> &mut [Borders<M, V>] {
        let first = (chip & self.chip_mask) * self.cells_per_chip;
        &mut self.cells[first..first + self.cells_per_chip]
    }

    /// The value at a place of chip `chip`.
    #[inline(always)]
    pub fn read(&self, chip: usize, place: &GridInterpolation) -> [V; M] {
        let index = (chip & self.chip_mask) * self.cells_per_chip + place.cell;
        let borders = &self.cells[index];
        if let Some(border) = place.border {
            return borders[border];
        }
        let [start, end, start_slope, end_slope] = borders;
        let [a, b, c, d] = place.weights;
        let mut value = [V::default(); M];
        for m in 0..M {
            value[m] = start[m] * a + end[m] * b + start_slope[m] * c + end_slope[m] * d;
        }
        value
    }
}
