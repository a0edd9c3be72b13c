//! What counts weigh in least squares: a 2 x 2 covariance per step, or one of each group of
//! steps that count the same light.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::normal::Normal;
use super::parameters::Column;
use super::shared_steps::SharedSteps;
use crate::response::{CountMoments, MeanCount, ROUNDING};

/// Factors W of each step's inverse covariance, W^T W = C^-1.
#[derive(Debug, Clone)]
pub struct Weights {
    /// Whitened: a r, b r + c N.
    factors: Vec<[f64; 3]>,
    /// In place of these, for steps that count the same light.
    groups: Vec<GroupFactor>,
    /// In place of these, for steps whose signed counts go together: the factor of all
    /// counts, signed and total by turns.
    together: Option<DMatrix<f64>>,
    /// Covariance of a signed count with that of the step so many behind it, on average.
    beside: Vec<f64>,
}

/// Factor of the inverse covariance of a group's signed counts and its total.
#[derive(Debug, Clone)]
struct GroupFactor {
    /// Places of its steps.
    places: Vec<usize>,
    /// Lower triangle.
    whitening: DMatrix<f64>,
}

impl Weights {
    pub fn of(moments: &[CountMoments]) -> Weights {
        let variances = moments.iter().map(|m| m.signed_variance.max(ROUNDING));
        let variance = variances.sum::<f64>() / moments.len() as f64;
        Weights {
            factors: moments.iter().map(CountMoments::whitening).collect(),
            groups: Vec::new(),
            together: None,
            beside: vec![variance],
        }
    }

    /// Weights of steps that count light of their own, and whose signed counts have a
    /// covariance beside what that light gives them.
    pub fn of_steps_together(
        moments: &[CountMoments],
        signed: impl Fn(usize, usize) -> f64,
    ) -> Weights {
        let steps = moments.len();
        let mut covariance = vec![vec![0.0; 2 * steps]; 2 * steps];
        for (place, of_step) in moments.iter().enumerate() {
            for other in 0..steps {
                covariance[2 * place][2 * other] = signed(place, other);
            }
            let (r, n) = (2 * place, 2 * place + 1);
            covariance[r][r] += of_step.signed_variance.max(ROUNDING);
            covariance[n][n] = of_step.total_variance.max(ROUNDING);
            covariance[r][n] = of_step.covariance;
            covariance[n][r] = of_step.covariance;
        }
        let beside = |apart: usize| {
            let pairs = (apart..steps).map(|place| covariance[2 * (place - apart)][2 * place]);
            pairs.sum::<f64>() / steps as f64
        };
        Weights {
            beside: (0..steps).map(beside).collect(),
            together: Some(whitening(&covariance)),
            ..Weights::of(moments)
        }
    }

    /// Weights of steps that count the same light, group by group.
    pub fn of_groups(groups: &[SharedSteps]) -> Weights {
        let factor = |group: &SharedSteps| GroupFactor {
            places: group.places.clone(),
            whitening: whitening(&group.moments.covariance),
        };
        Weights {
            factors: Vec::new(),
            groups: groups.iter().map(factor).collect(),
            together: None,
            beside: covariances_beside(groups),
        }
    }

    /// How many numbers the counts are, those that are one and the same taken once.
    pub fn values(&self) -> usize {
        let of_groups = self.groups.iter().map(|group| group.places.len() + 1);
        2 * self.factors.len() + of_groups.sum::<usize>()
    }

    /// Logarithm of the determinant of the counts' covariance.
    pub fn ln_determinant(&self) -> f64 {
        let of_diagonal = |matrix: &DMatrix<f64>| -> f64 {
            matrix.diagonal().iter().map(|entry| entry.ln()).sum()
        };
        let alone: f64 = match &self.together {
            Some(together) => of_diagonal(together),
            None => self.factors.iter().map(|[a, _, c]| a.ln() + c.ln()).sum(),
        };
        let groups = self.groups.iter().map(|group| of_diagonal(&group.whitening));
        -2.0 * (alone + groups.sum::<f64>())
    }

    /// Steps that are weighed.
    fn steps(&self) -> usize {
        let of_groups = self.groups.iter().map(|group| group.places.len());
        self.factors.len() + of_groups.sum::<usize>()
    }

    /// As if detections had no memory: both variances are the mean of N, the
    /// covariance is the mean of r.
    pub fn of_poisson(means: &[MeanCount]) -> Weights {
        let moments: Vec<CountMoments> = means
            .iter()
            .map(|mean| CountMoments {
                signed_mean: mean.signed,
                total_mean: mean.total,
                signed_variance: mean.total,
                total_variance: mean.total,
                covariance: mean.signed,
            })
            .collect();
        Weights::of(&moments)
    }

    /// Standard deviation of a signed count, about: that of a sum over a peak of the
    /// steps' counts, each weighed with the peak's height there, over the root of the sum
    /// of these squared. It is that of a step alone, unless neighbours go together.
    pub fn signed_sigma(&self, samples_per_chip: f64) -> f64 {
        let reach = samples_per_chip as i64;
        let height = |offset: i64| (1.0 - offset.abs() as f64 / samples_per_chip).max(0.0);
        let products = |apart: i64| -> f64 {
            let offsets = -reach..=reach;
            offsets.map(|offset| height(offset) * height(offset + apart)).sum()
        };
        let sides = |apart: usize| if apart == 0 { 1.0 } else { 2.0 };
        let beside = self.beside.iter().enumerate();
        let variance: f64 = beside
            .map(|(apart, covariance)| sides(apart) * covariance * products(apart as i64))
            .sum();
        (variance / products(0)).max(ROUNDING).sqrt()
    }

    /// Differences of counts, whitened.
    pub fn residuals(&self, measured: &[MeanCount], expected: &[MeanCount]) -> Vec<f64> {
        let pairs = measured.iter().zip(expected);
        let differences: Column = pairs
            .map(|(m, e)| MeanCount { signed: m.signed - e.signed, total: m.total - e.total })
            .collect();
        self.whitened(&differences)
    }

    /// The normal equations; `None` if they are singular, or say nothing finite.
    pub fn normal(
        &self,
        jacobian: &[Column],
        measured: &[MeanCount],
        expected: &[MeanCount],
    ) -> Option<Normal> {
        Normal::of_whitened(&self.whitened_columns(jacobian), &self.residuals(measured, expected))
    }

    /// Derivatives, whitened.
    pub fn whitened_columns(&self, jacobian: &[Column]) -> Vec<Vec<f64>> {
        jacobian.iter().map(|column| self.whitened(column)).collect()
    }

    /// Information of the counts about the unknowns, without any data.
    pub fn information(&self, jacobian: &[Column]) -> Option<Normal> {
        let nothing = vec![MeanCount { signed: 0.0, total: 0.0 }; self.steps()];
        self.normal(jacobian, &nothing, &nothing)
    }

    fn whitened(&self, column: &Column) -> Vec<f64> {
        if !self.groups.is_empty() {
            let groups = self.groups.iter();
            return groups.flat_map(|group| group.whitened(column)).collect();
        }
        if let Some(together) = &self.together {
            let values = column.iter().flat_map(|count| [count.signed, count.total]);
            let values = DVector::from_iterator(together.ncols(), values);
            return (together * values).as_slice().to_vec();
        }
        let pairs = column.iter().zip(&self.factors);
        pairs.flat_map(|(d, factor)| whiten(factor, d)).collect()
    }
}

impl GroupFactor {
    fn whitened(&self, column: &Column) -> Vec<f64> {
        let signed = self.places.iter().map(|&place| column[place].signed);
        let total = self.places.first().map(|&place| column[place].total);
        let values: Vec<f64> = signed.chain(total).collect();
        (&self.whitening * DVector::from_vec(values)).as_slice().to_vec()
    }
}

/// Covariance of a step's signed count with those of 0, 1, .. steps on, on average over
/// all steps: those of other groups know nothing of it.
fn covariances_beside(groups: &[SharedSteps]) -> Vec<f64> {
    let most = groups.iter().map(|group| group.places.len()).max();
    let mut sums = vec![0.0; most.unwrap_or(0)];
    let mut steps = 0;
    for group in groups {
        let lanes = group.places.len();
        steps += lanes;
        for (apart, sum) in sums.iter_mut().enumerate().take(lanes) {
            let pairs = (apart..lanes).map(|lane| group.moments.covariance[lane - apart][lane]);
            *sum += pairs.sum::<f64>();
        }
    }
    sums.iter().map(|sum| sum / steps as f64).collect()
}

/// Inverse of the lower triangle L of covariance = L L^T. Where numbers that are nearly
/// the same round to no covariance they are taken for as much less precise as it takes.
fn whitening(covariance: &[Vec<f64>]) -> DMatrix<f64> {
    let size = covariance.len();
    let mut ridge = ROUNDING * 1e-3;
    loop {
        let known = |a: usize, b: usize| covariance[a][b] + if a == b { ridge } else { 0.0 };
        let factor = Cholesky::new(DMatrix::from_fn(size, size, known));
        let one = DMatrix::identity(size, size);
        if let Some(inverse) = factor.and_then(|factor| factor.l().solve_lower_triangular(&one)) {
            return inverse;
        }
        if !ridge.is_finite() {
            // Covariances that are no numbers tell nothing.
            return DMatrix::zeros(size, size);
        }
        ridge *= 10.0;
    }
}

fn whiten(factor: &[f64; 3], count: &MeanCount) -> [f64; 2] {
    [factor[0] * count.signed, factor[1] * count.signed + factor[2] * count.total]
}

#[cfg(test)]
mod tests {
    use nalgebra::dmatrix;

    use super::*;

    /// A straight line through N, with r of no use: the textbook formulas.
    #[test]
    fn a_straight_line_is_fitted_with_the_textbook_errors() {
        let x = [-1.0, 0.0, 1.0, 4.0];
        let moments = x.map(|_| CountMoments {
            signed_mean: 0.0,
            total_mean: 0.0,
            signed_variance: 3.0,
            total_variance: 4.0,
            covariance: 0.0,
        });
        let count = |total| MeanCount { signed: 0.0, total };
        let jacobian = [x.map(|_| count(1.0)).to_vec(), x.map(count).to_vec()];
        let measured = x.map(|x| count(2.0 + 3.0 * x));
        let expected = x.map(|_| count(0.0));
        let normal =
            Weights::of(&moments).normal(&jacobian, &measured, &expected).expect("it is regular");
        let found = normal.solution();
        assert!((found[0] - 2.0).abs() < 1e-12 && (found[1] - 3.0).abs() < 1e-12);
        // Through the origin's constant held at 0: sum of x y over sum of x x.
        let swapped = [jacobian[1].clone(), jacobian[0].clone()];
        let held = Weights::of(&moments)
            .normal(&swapped, &measured, &expected)
            .expect("it is regular")
            .solution_within(&[[-f64::INFINITY, f64::INFINITY], [0.0, 0.0]]);
        let slope = (2.0 * 4.0 + 3.0 * 18.0) / 18.0;
        assert!((held[0] - slope).abs() < 1e-12 && held[1] == 0.0, "{held:?}");
        let sum = normal.holding(&[1.0, 1.0]);
        let [a, b] = [0, 1].map(|i| sum.solution()[i]);
        // a + b = 0: y on b (x - 1), whose squares are 4 + 1 + 0 + 9.
        let through_one: f64 =
            [-2.0, -1.0, 0.0, 3.0].iter().map(|x| x * (2.0 + 3.0 * (x + 1.0))).sum();
        assert!((a + b).abs() < 1e-12 && (b - through_one / 14.0).abs() < 1e-12);
        assert!((sum.standard_deviations()[1] - (4.0_f64 / 14.0).sqrt()).abs() < 1e-12);
        assert!(sum.standard_deviation_of(&[1.0, 1.0]).abs() < 1e-7);
        // Var(a + b) is that of the line at x = 1, the mean.
        assert!((normal.standard_deviation_of(&[1.0, 1.0]) - 1.0).abs() < 1e-12);
        // Mean of x is 1, sum of squares round it 14.
        let std = normal.standard_deviations();
        assert!((std[1] - (4.0_f64 / 14.0).sqrt()).abs() < 1e-12);
        assert!((std[0] - (4.0_f64 * (0.25 + 1.0 / 14.0)).sqrt()).abs() < 1e-12);
    }

    /// W C W^T of counts that go together is one, with C written out.
    #[test]
    fn whitened_steps_together_have_unit_covariance() {
        let moments = [(5.0, 3.0, 2.0), (7.0, 4.0, -1.0)].map(|(v, n, c)| CountMoments {
            signed_mean: 0.0,
            total_mean: 0.0,
            signed_variance: v,
            total_variance: n,
            covariance: c,
        });
        let added = [[2.0, 1.5], [1.5, 2.0]];
        let weights = Weights::of_steps_together(&moments, |a, b| added[a][b]);
        let covariance = dmatrix![
            7.0, 2.0, 1.5, 0.0;
            2.0, 3.0, 0.0, 0.0;
            1.5, 0.0, 9.0, -1.0;
            0.0, 0.0, -1.0, 4.0
        ];
        let count = |signed, total| MeanCount { signed, total };
        let units = [
            [count(1.0, 0.0), count(0.0, 0.0)],
            [count(0.0, 1.0), count(0.0, 0.0)],
            [count(0.0, 0.0), count(1.0, 0.0)],
            [count(0.0, 0.0), count(0.0, 1.0)],
        ];
        let columns: Vec<f64> =
            units.iter().flat_map(|unit| weights.whitened(&unit.to_vec())).collect();
        let whitening = DMatrix::from_vec(4, 4, columns);
        let one = &whitening * covariance * whitening.transpose();
        // Up to the ridge of a thousandth of the variance of rounding.
        assert!((one - DMatrix::identity(4, 4)).amax() < 1e-3 / 12.0);
    }

    #[test]
    fn whitened_counts_have_unit_covariance() {
        let moments = CountMoments {
            signed_mean: 0.0,
            total_mean: 0.0,
            signed_variance: 5.0,
            total_variance: 3.0,
            covariance: 2.0,
        };
        let [a, b, c] = Weights::of(&[moments]).factors[0];
        let (v, s, n) = (5.0, 2.0, 3.0);
        assert!((a * a * v - 1.0).abs() < 1e-12);
        assert!((b * b * v + 2.0 * b * c * s + c * c * n - 1.0).abs() < 1e-12);
        assert!((a * (b * v + c * s)).abs() < 1e-12);
    }
}
