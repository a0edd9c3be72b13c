//! Cells as sums over what the hardware has: least squares over all builds.

use nalgebra::{DMatrix, DVector};

use super::measured::Build;
use super::{Basis, Size};
use crate::parts::cells::FpgaCells;
use crate::sensor::cells::Gates;

/// What decides the cells of an architecture's hardware.
pub(super) trait Terms: Copy {
    /// What cells are proportional to: as many numbers for each sensor.
    fn terms(&self) -> Vec<f64>;
}

/// Cells of each term.
pub(super) struct Fit {
    luts: DVector<f64>,
    flip_flops: DVector<f64>,
}

impl Terms for Size {
    fn terms(&self) -> Vec<f64> {
        let size = self;
        let when = |condition: bool, number: u32| if condition { f64::from(number) } else { 0.0 };
        let of_detectors = size.detectors * size.samples_per_chip;
        let counts = size.detectors * size.parallel;
        let saturates = size.count_bits < size.exact_bits;
        let (cells, gates) = (size.input_cells, size.input_cells.gates());
        let counts_cells = matches!(gates, Some(Gates::AtLeast(_)));
        vec![
            1.0,
            f64::from(size.detectors),
            f64::from(size.lfsr_bits),
            f64::from(size.interleaving),
            f64::from(of_detectors),
            f64::from(counts * size.exact_bits),
            when(size.segmented, counts * size.exact_bits),
            // Results that wait behind the first.
            when(counts > 1, counts * size.count_bits),
            when(size.realigns, 1),
            when(saturates, counts * size.count_bits),
            when(size.peak_detector, counts * size.count_bits),
            when(size.peak_detector, size.detectors * size.count_bits),
            when(size.total_counts, size.detectors * size.exact_bits),
            when(size.total_counts && size.segmented, size.detectors * size.exact_bits),
            // Total counts that wait behind the first.
            when(size.total_counts && size.detectors > 1, size.detectors * size.exact_bits),
            // Gates of two inputs, adders of a bit, and detectors of edges more than one.
            when(gates.is_some() && !counts_cells, of_detectors * (cells.count - 1)),
            when(counts_cells, of_detectors * cells.count.saturating_sub(2)),
            when(cells.edges() > 1, of_detectors * (cells.edges() - 1)),
        ]
    }
}

impl Fit {
    /// Least squares of relative errors.
    pub fn of<S: Terms>(builds: &[Build<S>]) -> Fit {
        let rows: Vec<Vec<f64>> = builds.iter().map(|build| build.size.terms()).collect();
        let terms = rows.first().map_or(0, Vec::len);
        let solve = |cells: &dyn Fn(&Build<S>) -> u64| {
            let found = |row: usize| cells(&builds[row]) as f64;
            let matrix =
                DMatrix::from_fn(builds.len(), terms, |row, term| rows[row][term] / found(row));
            let ones = DVector::from_element(builds.len(), 1.0);
            let pseudo_inverse = matrix.svd(true, true).solve(&ones, 1e-9);
            // Both factors were asked for.
            pseudo_inverse.unwrap_or_else(|_| DVector::zeros(terms))
        };
        Fit {
            luts: solve(&|build| build.cells.luts),
            flip_flops: solve(&|build| build.cells.flip_flops),
        }
    }

    /// What a sensor takes.
    pub fn cells<S: Terms>(&self, size: &S) -> FpgaCells {
        let terms = DVector::from_vec(size.terms());
        let of = |cells_of_term: &DVector<f64>| cells_of_term.dot(&terms).max(0.0).round() as u64;
        FpgaCells { luts: of(&self.luts), flip_flops: of(&self.flip_flops) }
    }

    /// How well it holds.
    pub fn basis<S: Terms>(&self, builds: &[Build<S>]) -> Basis {
        let errors = builds.iter().flat_map(|build| self.errors_at(build));
        let others = (0..builds.len()).flat_map(|index| {
            let (mut others, build) = (builds.to_vec(), &builds[index]);
            others.remove(index);
            let own = build.size.terms();
            let is_alone = |term: usize| others.iter().all(|b| b.size.terms()[term] == 0.0);
            let missing = (0..own.len()).any(|term| own[term] != 0.0 && is_alone(term));
            // Without its only build a term is not known at all.
            match missing {
                true => Vec::new(),
                false => Fit::of(&others).errors_at(build).to_vec(),
            }
        });
        let others: Vec<f64> = others.collect();
        let squares: f64 = others.iter().map(|error| error * error).sum();
        Basis::Fitted {
            builds: builds.len(),
            largest_relative_error: errors.map(f64::abs).fold(0.0, f64::max),
            cross_validation_relative_error: (squares / others.len().max(1) as f64).sqrt(),
        }
    }

    fn errors_at<S: Terms>(&self, build: &Build<S>) -> [f64; 2] {
        let fitted = self.cells(&build.size);
        let error = |fitted: u64, found: u64| fitted as f64 / found as f64 - 1.0;
        [error(fitted.luts, build.cells.luts), error(fitted.flip_flops, build.cells.flip_flops)]
    }
}

#[cfg(test)]
mod tests {
    use super::super::measured::builds;
    use super::*;
    use crate::scene::FpgaTarget;

    #[test]
    fn the_fit_holds_at_every_build_and_for_those_that_it_has_not_seen() {
        for target in [FpgaTarget::Ecp525k6, FpgaTarget::Ice40Hx8k, FpgaTarget::Xc7] {
            let builds = builds(target);
            let Basis::Fitted { largest_relative_error, cross_validation_relative_error, .. } =
                Fit::of(&builds).basis(&builds)
            else {
                unreachable!()
            };
            assert!(largest_relative_error < 0.12, "{target:?}: {largest_relative_error}");
            assert!(
                cross_validation_relative_error < 0.08,
                "{target:?}: {cross_validation_relative_error}"
            );
        }
    }
}
