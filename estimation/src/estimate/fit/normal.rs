//! Normal equations of least squares, for unknowns of any scale.

use nalgebra::{Cholesky, DMatrix, DVector};

use crate::response::dot;

/// What is added to the information of each unknown, as a share of it, where some cannot be
/// told apart: far less than what tells those that can.
const DAMPING: f64 = 1e-8;

/// Normal equations, ready to solve.
#[derive(Debug, Clone)]
pub struct Normal {
    /// Scale of every unknown: one over the root of its information.
    scales: Vec<f64>,
    /// Scaled information matrix, and its inverse.
    information: DMatrix<f64>,
    inverse: DMatrix<f64>,
    /// Scaled gradient.
    gradient: DVector<f64>,
}

impl Normal {
    /// From whitened derivatives and residuals; `None` if they are singular, or not finite.
    pub fn of_whitened(columns: &[Vec<f64>], residuals: &[f64]) -> Option<Normal> {
        Normal::of_damped(columns, residuals, 0.0)
    }

    /// The same where unknowns may be indistinguishable: a little is added to the information of each.
    pub fn damped(columns: &[Vec<f64>], residuals: &[f64]) -> Option<Normal> {
        Normal::of_damped(columns, residuals, DAMPING)
    }

    /// The same with so much added to the information of each unknown, as a share of it.
    fn of_damped(columns: &[Vec<f64>], residuals: &[f64], damping: f64) -> Option<Normal> {
        let scales: Vec<f64> = columns.iter().map(|c| 1.0 / dot(c, c).sqrt()).collect();
        let information =
            |i: usize, j: usize| dot(&columns[i], &columns[j]) * scales[i] * scales[j];
        let size = columns.len();
        let mut matrix = DMatrix::zeros(size, size);
        for column in 0..size {
            for row in column..size {
                matrix[(row, column)] = information(row, column);
            }
            matrix[(column, column)] += damping;
        }
        matrix.fill_upper_triangle_with_lower_triangle();
        let normal = Normal {
            gradient: DVector::from_fn(size, |i, _| dot(&columns[i], residuals) * scales[i]),
            inverse: inverse(matrix.clone())?,
            information: matrix,
            scales,
        };
        normal.is_finite().then_some(normal)
    }

    fn is_finite(&self) -> bool {
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        finite(self.inverse.as_slice())
            && finite(self.gradient.as_slice())
            && finite(&self.standard_deviations())
    }

    /// The step to where the squares of linear residuals are least, wherever that is.
    pub fn solution(&self) -> Vec<f64> {
        let step = &self.inverse * &self.gradient;
        step.iter().zip(&self.scales).map(|(s, scale)| s * scale).collect()
    }

    /// The best step of those that leave every unknown between two limits, nearly: one
    /// unknown after another that goes beyond is held at its limit.
    pub fn solution_within(&self, limits: &[[f64; 2]]) -> Vec<f64> {
        let mut inverse = self.inverse.clone();
        let mut step = &inverse * &self.gradient;
        for _ in limits {
            let over = |i: usize| {
                let [least, most] = limits[i].map(|limit| limit / self.scales[i]);
                let by = step[i] - step[i].clamp(least, most);
                (by != 0.0 && inverse[(i, i)] > 0.0).then_some((by, i))
            };
            let farthest = (0..limits.len()).filter_map(over);
            let Some((by, held)) = farthest.max_by(|a, b| a.0.abs().total_cmp(&b.0.abs())) else {
                break;
            };
            let shared = inverse.column(held).clone_owned();
            let variance = shared[held];
            step -= &shared * (by / variance);
            inverse -= &shared * shared.transpose() / variance;
            inverse.row_mut(held).fill(0.0);
            inverse.column_mut(held).fill(0.0);
        }
        let pairs = step.iter().zip(&self.scales).zip(limits);
        pairs.map(|((step, scale), [least, most])| (step * scale).clamp(*least, *most)).collect()
    }

    /// Standard deviation of each unknown, the others unknown too.
    pub fn standard_deviations(&self) -> Vec<f64> {
        (0..self.scales.len()).map(|i| self.inverse[(i, i)].sqrt() * self.scales[i]).collect()
    }

    /// Standard deviation of a combination of the unknowns.
    pub fn standard_deviation_of(&self, combination: &[f64]) -> f64 {
        let direction = self.scaled(combination);
        direction.dot(&(&self.inverse * &direction)).sqrt()
    }

    /// Directions of some unknowns, of a standard deviation each, whose sum of squares is their covariance.
    pub fn directions(&self, of: &[usize]) -> Vec<Vec<f64>> {
        let covariance = |i: usize, j: usize| {
            self.inverse[(of[i], of[j])] * self.scales[of[i]] * self.scales[of[j]]
        };
        let axes = DMatrix::from_fn(of.len(), of.len(), covariance).symmetric_eigen();
        let stds = axes.eigenvalues.iter().map(|variance| variance.max(0.0).sqrt());
        let columns = axes.eigenvectors.column_iter().zip(stds);
        columns.map(|(axis, std)| axis.iter().map(|part| part * std).collect()).collect()
    }

    /// The same where a combination of the unknowns is held as it is.
    pub fn holding(&self, combination: &[f64]) -> Normal {
        let direction = self.scaled(combination);
        let moved = &self.inverse * &direction;
        let mut left = &self.inverse - &moved * moved.transpose() / direction.dot(&moved);
        // What is held has no variance, rounding or not.
        for entry in 0..left.nrows() {
            left[(entry, entry)] = left[(entry, entry)].max(0.0);
        }
        Normal { inverse: left, ..self.clone() }
    }

    fn scaled(&self, combination: &[f64]) -> DVector<f64> {
        let pairs = combination.iter().zip(&self.scales);
        DVector::from_iterator(self.scales.len(), pairs.map(|(c, scale)| c * scale))
    }

    /// By how much a step lowers the sum of squared residuals, if these are linear.
    pub fn fall(&self, step: &[f64]) -> f64 {
        let pairs = step.iter().zip(&self.scales);
        let step =
            DVector::from_iterator(self.scales.len(), pairs.map(|(step, scale)| step / scale));
        2.0 * self.gradient.dot(&step) - step.dot(&(&self.information * &step))
    }
}

/// Inverse of a symmetric positive definite matrix with a unit diagonal; `None` if
/// it is singular to ten digits.
fn inverse(matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let factor = Cholesky::new(matrix)?;
    // A squared entry is what the unknowns before it leave of this one's variance.
    let left = factor.l_dirty().diagonal().map(|entry| entry * entry);
    (left.min() >= 1e-10).then(|| factor.inverse())
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    #[test]
    fn an_inverse_times_its_matrix_is_one() {
        let matrix = dmatrix![1.0, 0.5, -0.25; 0.5, 1.0, 0.125; -0.25, 0.125, 1.0];
        let inverse = inverse(matrix.clone()).expect("it is regular");
        assert!((matrix * inverse - DMatrix::identity(3, 3)).amax() < 1e-12);
        assert!(super::inverse(dmatrix![1.0, 1.0; 1.0, 1.0]).is_none());
        assert!(super::inverse(dmatrix![1.0, f64::NAN; f64::NAN, 1.0]).is_none());
    }

    /// Of two unknowns that do the same a fit takes half each.
    #[test]
    fn damped_equations_have_a_solution_where_unknowns_are_alike() {
        let column = vec![1.0, 2.0];
        let columns = [column.clone(), column];
        assert!(Normal::of_whitened(&columns, &[3.0, 6.0]).is_none());
        let damped = Normal::damped(&columns, &[3.0, 6.0]).expect("it is damped");
        let found = damped.solution();
        assert!(found.iter().all(|half| (half - 1.5).abs() < 1e-6), "{found:?}");
    }
}
