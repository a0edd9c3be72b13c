//! Probability that the angle of a normal vector in the plane is in a range.

use std::f64::consts::PI;

use crate::math::normal_cdf;

/// A normal vector in the plane.
#[derive(Debug, Clone, Copy, Default)]
pub struct Planar {
    pub mean: [f64; 2],
    /// Variances of x and y, and their covariance.
    pub covariance: [f64; 3],
}

/// Intervals between two places where the integrand may bend.
const INTERVALS: u32 = 64;

impl Planar {
    /// P(angle in `from`..`to`), both within a turn of each other.
    ///
    /// Along a direction u the density's radial integral is known; the rest is
    /// Simpson's rule over the angle, closer where the mean points to.
    pub fn angle_within(&self, from: f64, to: f64) -> f64 {
        let [x, y] = self.mean;
        let [xx, yy, xy] = self.covariance;
        let determinant = xx * yy - xy * xy;
        // So little scatter that there is a direction only.
        if determinant <= 1e-24 * (xx + yy + x * x + y * y).powi(2) {
            let middle = 0.5 * (from + to);
            let turns = (y.atan2(x) - middle) / (2.0 * PI);
            return f64::from((turns - turns.round()).abs() * 4.0 * PI <= to - from);
        }
        let precision = [yy / determinant, xx / determinant, -xy / determinant];
        let form = |a: [f64; 2], b: [f64; 2]| {
            precision[0] * a[0] * b[0]
                + precision[1] * a[1] * b[1]
                + precision[2] * (a[0] * b[1] + a[1] * b[0])
        };
        let of_mean = form(self.mean, self.mean);
        let density = |angle: f64| {
            let u = [angle.cos(), angle.sin()];
            let (q, p) = (form(u, u), form(u, self.mean));
            let ahead = (p * p / q - of_mean).min(0.0);
            ((-0.5 * of_mean).exp() / q
                + p / q.powf(1.5)
                    * (2.0 * PI).sqrt()
                    * (0.5 * ahead).exp()
                    * normal_cdf(p / q.sqrt()))
                / (2.0 * PI * determinant.sqrt())
        };
        let centre = y.atan2(x);
        let width = ((xx + yy).sqrt() / x.hypot(y).max(1e-300)).min(0.5);
        let mut cuts = vec![from, to];
        for turn in [-2.0 * PI, 0.0, 2.0 * PI] {
            for off in [-8.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 8.0] {
                let cut = centre + turn + off * width;
                if cut > from && cut < to {
                    cuts.push(cut);
                }
            }
        }
        cuts.sort_by(f64::total_cmp);
        let pieces = cuts.windows(2).map(|ends| simpson(&density, ends[0], ends[1]));
        pieces.sum::<f64>().clamp(0.0, 1.0)
    }
}

fn simpson(f: &impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let h = (to - from) / f64::from(INTERVALS);
    let inner = (1..INTERVALS).map(|i| {
        let weight = if i % 2 == 1 { 4.0 } else { 2.0 };
        weight * f(from + f64::from(i) * h)
    });
    (f(from) + f(to) + inner.sum::<f64>()) * h / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_planes_are_the_normal_distribution() {
        for (mean, std) in [([0.3, 0.0], 1.0), ([2.0, 0.0], 0.5), ([-0.7, 0.2], 0.3)] {
            let planar = Planar { mean, covariance: [std * std, 4.0, 0.0] };
            let right = planar.angle_within(-0.5 * PI, 0.5 * PI);
            assert!((right - normal_cdf(mean[0] / std)).abs() < 1e-6, "{right}");
            assert!((planar.angle_within(-PI, PI) - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn without_a_mean_angles_are_uniform_and_correlation_turns_them() {
        let round = Planar { mean: [0.0; 2], covariance: [2.0, 2.0, 0.0] };
        assert!((round.angle_within(0.3, 1.3) - 0.5 / PI).abs() < 1e-7);
        // Sheppard 1899: P(x > 0, y > 0) = 1/4 + asin(rho) / (2 pi).
        let along = Planar { mean: [0.0; 2], covariance: [4.0, 1.0, 1.2] };
        let expected = 0.25 + 0.6_f64.asin() / (2.0 * PI);
        assert!((along.angle_within(0.0, 0.5 * PI) - expected).abs() < 1e-6);
    }

    #[test]
    fn without_scatter_the_angle_is_inside_or_not() {
        let sure = Planar { mean: [-1.0, -0.1], covariance: [0.0; 3] };
        assert_eq!(sure.angle_within(PI - 0.01, PI + 0.2), 1.0);
        assert_eq!(sure.angle_within(-1.0, 1.0), 0.0);
    }
}
