//! The distribution of one step's signed count.

use std::f64::consts::PI;

use crate::optics::fast::normal::cumulative;

/// A whole number with a given mean and variance: the difference of two Poisson
/// numbers where there is one with these moments (which a count without dead time
/// is), a rounded normal number elsewhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CountLaw {
    pub mean: f64,
    pub variance: f64,
}

impl CountLaw {
    pub fn std(&self) -> f64 {
        self.variance.sqrt()
    }

    /// P(count < y) for y half-way between two whole numbers; between those the
    /// smooth curve through them.
    ///
    /// The difference of Poisson numbers of means a and b by the saddlepoint of
    /// K(s) = a (e^s - 1) + b (e^-s - 1), K'(s) = y, with the lattice's correction
    /// (Lugannani and Rice 1980; Daniels 1987): within some 10^-3 of the smaller tail
    /// from a variance of 1 on.
    pub fn below(&self, y: f64) -> f64 {
        let CountLaw { mean, variance } = *self;
        if variance <= 0.0 {
            return f64::from(y > mean);
        }
        let z = (y - mean) / variance.sqrt();
        let (a, b) = (0.5 * (variance + mean), 0.5 * (variance - mean));
        let is_poissonian = a.min(b) > 0.0;
        if !is_poissonian || z.abs() > 30.0 {
            return cumulative(z);
        }
        let curvature = (y * y + 4.0 * a * b).sqrt();
        // a e^s and b e^-s, the smaller of the two without cancellation.
        let (up, down) = if y > 0.0 {
            let up = 0.5 * (curvature + y);
            (up, a * b / up)
        } else {
            let down = 0.5 * (curvature - y);
            (a * b / down, down)
        };
        let s = (up / a).ln();
        let w = (2.0 * (s * y - (up - a) - (down - b))).max(0.0).sqrt() * s.signum();
        let correction = if w.abs() < 1e-3 {
            mean / variance.powf(1.5) / 6.0
        } else {
            1.0 / w - 1.0 / (2.0 * (0.5 * s).sinh() * curvature.sqrt())
        };
        let density = (-0.5 * w * w).exp() / (2.0 * PI).sqrt();
        (cumulative(w) + density * correction).clamp(0.0, 1.0)
    }

    /// Mean and variance of the count if it is known to be below `y`, for a normal
    /// one.
    pub fn given_below(&self, y: f64) -> (f64, f64) {
        let std = self.std();
        let z = (y - self.mean) / std;
        if z > 8.0 {
            return (self.mean, self.variance);
        }
        if z < -8.0 {
            // The tail is exponential, of slope |z|.
            return (y + std / z, (std / z).powi(2));
        }
        let ratio = (-0.5 * z * z).exp() / (2.0 * PI).sqrt() / cumulative(z);
        let variance = self.variance * (1.0 - z * ratio - ratio * ratio).max(0.0);
        (self.mean - std * ratio, variance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P(U - W <= x) of Poisson numbers, term by term.
    fn difference_at_most(x: i64, a: f64, b: f64) -> f64 {
        let poisson = |mean: f64| -> Vec<f64> {
            let mut terms = vec![(-mean).exp()];
            for n in 1..400 {
                terms.push(terms[n - 1] * mean / n as f64);
            }
            terms
        };
        let (up, down) = (poisson(a), poisson(b));
        let mut sum = 0.0;
        for (w, down) in (0_i64..).zip(&down) {
            let most = x + w;
            if most >= 0 {
                sum += down * up.iter().take(most as usize + 1).sum::<f64>();
            }
        }
        sum
    }

    #[test]
    fn differences_of_poisson_numbers_have_their_exact_tails() {
        for (a, b, limit) in [(1.5, 1.5, 0.02), (6.0, 4.0, 0.004), (60.0, 50.0, 1e-3)] {
            let law = CountLaw {
                mean: a - b,
                variance: a + b,
            };
            for z in -4..=5 {
                let x = (law.mean + f64::from(z) * law.std()).round() as i64;
                let exact = difference_at_most(x, a, b);
                let found = law.below(x as f64 + 0.5);
                let tail = exact.min(1.0 - exact);
                if tail > 1e-9 {
                    assert!((found - exact).abs() < limit * tail, "{a} {b} {x}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn a_count_known_to_be_below_its_mean_is_half_a_normal_one() {
        let law = CountLaw {
            mean: 10.0,
            variance: 9.0,
        };
        let (mean, variance) = law.given_below(10.0);
        // Half-normal: sqrt(2 / pi) and 1 - 2 / pi.
        assert!((mean - (10.0 - 3.0 * (2.0 / PI).sqrt())).abs() < 1e-9);
        assert!((variance - 9.0 * (1.0 - 2.0 / PI)).abs() < 1e-9);
        assert_eq!(law.given_below(100.0), (10.0, 9.0));
        let (mean, variance) = law.given_below(-30.0);
        assert!(mean < -30.0 && mean > -30.5 && variance < 0.1);
    }
}
