//! Weights of counts in least squares: from a 2 x 2 covariance per step, or one covariance per group
//! of steps that count the same light.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::normal::Normal;
use super::parameters::DerivativeColumn;
use crate::response::{CountMoments, GroupMoments, MeanCount, ROUNDING};

/// Factors W of the counts' inverse covariance, W^T W = C^-1.
#[derive(Debug, Clone)]
pub struct Weights {
    /// Of each step that goes with no other: a r and b r + c N have unit covariance.
    factors: Vec<[f64; 3]>,
    /// Numbers of such a step that count: both, or the first alone.
    numbers_of_step: usize,
    /// In place of these, of numbers that go together.
    together: Vec<Together>,
    /// Covariance of a signed count with that of the step so many behind it, on average.
    beside: Vec<f64>,
    /// Largest [correlation](CountMoments::correlation) of the signed and the total count of a step that goes with no other.
    pub most_correlated: f64,
}

/// Factor of the inverse covariance of some counts.
#[derive(Debug, Clone)]
struct Together {
    /// The place of each one's step, and whether it is the total count.
    numbers: Vec<(usize, bool)>,
    /// Lower triangle.
    whitening: DMatrix<f64>,
}

impl Weights {
    /// Of steps that go with no others.
    pub fn of(moments: &[CountMoments]) -> Weights {
        let variances = moments.iter().map(|m| m.signed_variance.max(ROUNDING));
        let variance = variances.sum::<f64>() / moments.len() as f64;
        Weights {
            factors: moments.iter().map(CountMoments::whitening).collect(),
            numbers_of_step: 2,
            together: Vec::new(),
            beside: vec![variance],
            most_correlated: moments.iter().map(|m| m.correlation().abs()).fold(0.0, f64::max),
        }
    }

    /// The same of signed counts alone.
    pub fn of_signed(moments: &[CountMoments]) -> Weights {
        let mut weights = Weights::of(moments);
        weights.factors.iter_mut().for_each(|[_, b, c]| (*b, *c) = (0.0, 1.0));
        Weights { numbers_of_step: 1, ..weights }
    }

    /// Of steps that count light of their own, and whose signed counts have a
    /// covariance beside what that light gives them.
    pub fn of_steps_together(
        moments: &[CountMoments],
        signed: impl Fn(usize, usize) -> f64,
    ) -> Weights {
        let steps = moments.len();
        let mut covariance = vec![vec![0.0; 2 * steps]; 2 * steps];
        for (r, of_step) in moments.iter().enumerate() {
            let n = steps + r;
            (0..steps).for_each(|other| covariance[r][other] = signed(r, other));
            covariance[r][r] += of_step.signed_variance.max(ROUNDING);
            covariance[n][n] = of_step.total_variance.max(ROUNDING);
            covariance[r][n] = of_step.covariance;
            covariance[n][r] = of_step.covariance;
        }
        let places: Vec<usize> = (0..steps).collect();
        Weights::of_blocks([(&places[..], &places[..], &covariance)].into_iter())
    }

    /// Of groups of steps at some places that count the same light, whose total is one.
    pub fn of_groups(groups: &[(Vec<usize>, GroupMoments)]) -> Weights {
        let blocks = groups.iter();
        Weights::of_blocks(blocks.map(|(steps, of)| (&steps[..], &steps[..1], &of.covariance)))
    }

    /// The same where signed counts have a covariance beside what their light gives them: all of them, or, of groups that are
    /// taken for far apart, those of each group.
    pub fn of_groups_together(
        mut groups: Vec<(Vec<usize>, GroupMoments)>,
        signed: impl Fn(usize, usize) -> f64,
        are_far_apart: bool,
    ) -> Weights {
        if are_far_apart {
            for (steps, of) in &mut groups {
                for (a, row) in steps.iter().zip(&mut of.covariance) {
                    steps.iter().zip(row).for_each(|(b, entry)| *entry += signed(*a, *b));
                }
            }
            return Weights::of_groups(&groups);
        }
        let steps: Vec<usize> = groups.iter().flat_map(|(steps, _)| steps).copied().collect();
        let totals: Vec<usize> = groups.iter().map(|(steps, _)| steps[0]).collect();
        let numbers = steps.len() + totals.len();
        let mut covariance = vec![vec![0.0; numbers]; numbers];
        for (row, a) in covariance.iter_mut().zip(&steps) {
            row.iter_mut().zip(&steps).for_each(|(entry, b)| *entry = signed(*a, *b));
        }
        let mut first = 0;
        for (number, (of_group, of)) in groups.iter().enumerate() {
            let lanes = of_group.len();
            let place =
                |lane: usize| if lane < lanes { first + lane } else { steps.len() + number };
            for (a, row) in of.covariance.iter().enumerate() {
                for (b, entry) in row.iter().enumerate() {
                    covariance[place(a)][place(b)] += entry;
                }
            }
            first += lanes;
        }
        Weights::of_blocks([(&steps[..], &totals[..], &covariance)].into_iter())
    }

    /// Of blocks of counts that go together: the places whose signed counts are in it, then those
    /// whose total ones are, and the covariance of all. Blocks know nothing of each other.
    fn of_blocks<'b>(
        blocks: impl Iterator<Item = (&'b [usize], &'b [usize], &'b Vec<Vec<f64>>)>,
    ) -> Weights {
        let mut weights = Weights {
            factors: Vec::new(),
            numbers_of_step: 2,
            together: Vec::new(),
            beside: Vec::new(),
            most_correlated: 0.0,
        };
        let mut steps = 0;
        for (signed, totals, covariance) in blocks {
            let lanes = signed.len();
            steps += lanes;
            weights.beside.resize(weights.beside.len().max(lanes), 0.0);
            for (apart, sum) in weights.beside.iter_mut().enumerate().take(lanes) {
                *sum += (apart..lanes).map(|lane| covariance[lane - apart][lane]).sum::<f64>();
            }
            let signed = signed.iter().map(|&place| (place, false));
            let numbers = signed.chain(totals.iter().map(|&place| (place, true))).collect();
            weights.together.push(Together { numbers, whitening: whitening(covariance) });
        }
        weights.beside.iter_mut().for_each(|sum| *sum /= steps as f64);
        weights
    }

    /// How many numbers the counts are, those that are one and the same taken once.
    pub fn values(&self) -> usize {
        let together = self.together.iter().map(|together| together.numbers.len());
        self.numbers_of_step * self.factors.len() + together.sum::<usize>()
    }

    /// Logarithm of the determinant of the counts' covariance.
    pub fn ln_determinant(&self) -> f64 {
        let alone = self.factors.iter().map(|[a, _, c]| a.ln() + c.ln()).sum::<f64>();
        let of_diagonal = |together: &Together| -> f64 {
            together.whitening.diagonal().iter().map(|entry| entry.ln()).sum()
        };
        -2.0 * (alone + self.together.iter().map(of_diagonal).sum::<f64>())
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
        let differences: DerivativeColumn = pairs
            .map(|(m, e)| MeanCount { signed: m.signed - e.signed, total: m.total - e.total })
            .collect();
        self.whitened(&differences)
    }

    /// Derivatives, whitened.
    pub fn whitened_columns(&self, jacobian: &[DerivativeColumn]) -> Vec<Vec<f64>> {
        jacobian.iter().map(|column| self.whitened(column)).collect()
    }

    /// Information of the counts about the unknowns, without any data.
    pub fn information(&self, jacobian: &[DerivativeColumn]) -> Option<Normal> {
        Normal::of_whitened(&self.whitened_columns(jacobian), &vec![0.0; self.values()])
    }

    /// Numbers of unit covariance that counts stand for.
    pub fn whitened(&self, column: &DerivativeColumn) -> Vec<f64> {
        let alone = column.iter().zip(&self.factors);
        let mut whitened: Vec<f64> = if self.numbers_of_step == 2 {
            let both = |(count, [a, b, c]): (&MeanCount, &[f64; 3])| {
                [a * count.signed, b * count.signed + c * count.total]
            };
            alone.map(both).collect::<Vec<_>>().into_flattened()
        } else {
            alone.map(|(count, [a, ..])| a * count.signed).collect()
        };
        whitened.extend(self.together.iter().flat_map(|together| together.whitened(column)));
        whitened
    }
}

impl Together {
    fn whitened(&self, column: &DerivativeColumn) -> Vec<f64> {
        let number = |&(place, is_total): &(usize, bool)| match is_total {
            true => column[place].total,
            false => column[place].signed,
        };
        let values = DVector::from_iterator(self.numbers.len(), self.numbers.iter().map(number));
        (&self.whitening * values).as_slice().to_vec()
    }
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
        let weights = Weights::of(&moments);
        let normal = |jacobian: &[DerivativeColumn]| {
            let residuals = weights.residuals(&measured, &expected);
            Normal::of_whitened(&weights.whitened_columns(jacobian), &residuals)
                .expect("it is regular")
        };
        let held = normal(&[1, 0].map(|unknown: usize| jacobian[unknown].clone()))
            .solution_within(&[[-f64::INFINITY, f64::INFINITY], [0.0, 0.0]]);
        let normal = normal(&jacobian);
        let found = normal.solution();
        assert!((found[0] - 2.0).abs() < 1e-12 && (found[1] - 3.0).abs() < 1e-12);
        // Through the origin's constant held at 0: sum of x y over sum of x x.
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

    /// Two groups, of two steps and of one, whose signed counts go together beside, with C written out; and of groups that are
    /// taken for far apart, those of each.
    #[test]
    fn whitened_groups_together_have_unit_covariance() {
        let group = |covariance| GroupMoments { covariance, ..GroupMoments::default() };
        let groups = vec![
            (
                vec![0, 1],
                group(vec![vec![5.0, 1.0, 2.0], vec![1.0, 6.0, 1.5], vec![2.0, 1.5, 4.0]]),
            ),
            (vec![2], group(vec![vec![7.0, -1.0], vec![-1.0, 3.0]])),
        ];
        let added = |a: usize, b: usize| 2.0 - 0.5 * a.abs_diff(b) as f64;
        let count = |signed, total| MeanCount { signed, total };
        // A total is its group's, told with any of its steps.
        let [none, signed] = [count(0.0, 0.0), count(1.0, 0.0)];
        let units = [
            [signed, none, none],
            [none, signed, none],
            [count(0.0, 1.0), count(0.0, 1.0), none],
            [none, none, signed],
            [none, none, count(0.0, 1.0)],
        ];
        for (are_far_apart, beside) in [(false, [1.0, 1.5]), (true, [0.0, 0.0])] {
            let weights = Weights::of_groups_together(groups.clone(), added, are_far_apart);
            let columns: Vec<f64> =
                units.iter().flat_map(|unit| weights.whitened(&unit.to_vec())).collect();
            let [far, near] = beside;
            let covariance = dmatrix![
                7.0, 2.5, 2.0, far, 0.0;
                2.5, 8.0, 1.5, near, 0.0;
                2.0, 1.5, 4.0, 0.0, 0.0;
                far, near, 0.0, 9.0, -1.0;
                0.0, 0.0, 0.0, -1.0, 3.0
            ];
            let whitening = DMatrix::from_vec(5, 5, columns);
            let one = &whitening * covariance * whitening.transpose();
            assert!((one - DMatrix::identity(5, 5)).amax() < 1e-3 / 12.0, "{are_far_apart}");
        }
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
        let weights = Weights::of(&[moments]);
        let [a, b, c] = weights.factors[0];
        let (v, s, n) = (5.0, 2.0, 3.0);
        assert!((a * a * v - 1.0).abs() < 1e-12);
        assert!((b * b * v + 2.0 * b * c * s + c * c * n - 1.0).abs() < 1e-12);
        assert!((a * (b * v + c * s)).abs() < 1e-12);
        // 5 x 3 - 2 x 2.
        assert!((weights.ln_determinant() - 11.0_f64.ln()).abs() < 1e-12);
        let signed = Weights::of_signed(&[moments]);
        assert!((signed.ln_determinant() - 5.0_f64.ln()).abs() < 1e-12);
        let count = MeanCount { signed: 3.0, total: 7.0 };
        assert_eq!(signed.whitened(&vec![count]), [3.0 * a]);
        assert_eq!((weights.values(), signed.values()), (2, 1));
    }
}
