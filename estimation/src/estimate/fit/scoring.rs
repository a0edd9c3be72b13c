//! The loop of every fit: Fisher scoring of a quasi-likelihood.
//!
//! The unknowns determine the expected counts, and these the covariances. A step solves the
//! normal equations of the counts' deviations from their means, with the covariances of the current
//! point; where the whole step does not improve the fit, a shorter one is taken. Steps of a scan,
//! alone or in groups, bins of a histogram, and scenes with changed keys each implement
//! [`Counts`].

use super::normal::Normal;

/// Shares of a step that are tried where the whole one does not improve the fit.
const SHARES: [f64; 5] = [1.0, 0.4, 0.16, 0.064, 0.0256];

/// Measured counts, and their expectation as a function of unknowns.
pub trait Counts {
    /// Values of the unknowns, with the means that follow from them.
    type Point;
    /// Why there is no expectation at some values.
    type Error;

    /// Deviations of the counts from the means at a point, whitened to unit covariance.
    ///
    /// # Errors
    /// If the covariances do not allow it.
    fn residuals(&self, place: &Self::Point) -> Result<Vec<f64>, Self::Error>;

    /// What a fit minimises, at a point with some deviations: -2 ln(likelihood), less a constant.
    fn misfit(&self, _place: &Self::Point, residuals: &[f64]) -> f64 {
        residuals.iter().map(|residual| residual * residual).sum()
    }

    /// Derivatives of the means by every unknown, whitened as the deviations are. They may be those of a
    /// point nearby, unless they are asked for `anew`.
    ///
    /// # Errors
    /// If there is no expectation nearby.
    fn slopes(&mut self, place: &Self::Point, anew: bool) -> Result<Slopes, Self::Error>;

    /// The normal equations; `None` if they are singular, or not finite.
    fn normal(&self, columns: &[Vec<f64>], residuals: &[f64]) -> Option<Normal> {
        Normal::of_whitened(columns, residuals)
    }

    /// The solution of the normal equations, with every unknown within its limits.
    fn step(&self, place: &Self::Point, normal: &Normal) -> Vec<f64>;

    /// The point one step further.
    ///
    /// # Errors
    /// If there is no expectation there.
    fn moved(&self, place: &Self::Point, step: &[f64]) -> Result<Self::Point, Self::Error>;

    /// Adopts the covariances of a point, reached by a step that promised to lower the sum of squares
    /// by `fall`; returns whether it did: those in use may be of that point, or good enough.
    ///
    /// # Errors
    /// If there are none.
    fn weigh(&mut self, place: &Self::Point, fall: f64) -> Result<bool, Self::Error>;

    /// The error for counts that do not determine the unknowns.
    fn undetermined(&self, place: &Self::Point) -> Self::Error;
}

/// Derivatives of means by unknowns, with unit covariance of the counts.
pub struct Slopes {
    pub columns: Vec<Vec<f64>>,
    /// Whether they are as good as they get.
    pub are_best: bool,
}

/// The rule of convergence: a fit has settled when a step lowers the misfit by less than the square of
/// so many standard deviations, by the normal equations or in fact. (A gradient need not vanish: a
/// correlation has corners.)
#[derive(Debug, Clone, Copy)]
pub struct Settling {
    sigmas: f64,
    most_steps: usize,
}

impl Settling {
    /// For an estimate.
    pub const FINE: Settling = Settling { sigmas: 0.03, most_steps: 50 };
    /// For a comparison of hypotheses.
    pub const ROUGH: Settling = Settling { sigmas: 0.15, most_steps: 12 };
}

/// Where a fit has ended.
pub struct Settled<P> {
    pub place: P,
    /// From there to the least squares: too short to make a difference.
    pub step: Vec<f64>,
    pub normal: Normal,
    /// The least misfit found.
    pub misfit: f64,
    /// Steps taken.
    pub steps: usize,
    /// Whether it settled within the most steps.
    pub has_settled: bool,
}

/// Descends from `start` to the best fit.
///
/// # Errors
/// If there is no expectation at the start, or the counts do not determine the unknowns.
pub fn settle<C: Counts>(
    counts: &mut C,
    start: C::Point,
    settling: Settling,
) -> Result<Settled<C::Point>, C::Error> {
    let enough = settling.sigmas * settling.sigmas;
    let mut here = Standing::at(counts, start)?;
    let mut anew = false;
    let mut steps = 0;
    loop {
        let slopes = counts.slopes(&here.place, anew)?;
        let normal = counts.normal(&slopes.columns, &here.residuals);
        let normal = normal.ok_or_else(|| counts.undetermined(&here.place))?;
        let step = counts.step(&here.place, &normal);
        let promised = normal.fall(&step);
        let next = match promised < enough {
            true => None,
            false => downhill(counts, &here, &step),
        };
        let Some(lower) = next else {
            if promised >= enough && !slopes.are_best {
                // No share of the step lowers the misfit, perhaps for derivatives from elsewhere.
                anew = true;
                continue;
            }
            if !counts.weigh(&here.place, 0.0)? {
                let step = if promised < enough { step } else { vec![0.0; step.len()] };
                let Standing { place, misfit, .. } = here;
                return Ok(Settled { place, step, normal, misfit, steps, has_settled: true });
            }
            here = Standing::at(counts, here.place)?;
            anew = false;
            continue;
        };
        steps += 1;
        anew = false;
        let is_weighed_anew = counts.weigh(&lower.place, promised)?;
        let has_settled = !is_weighed_anew && here.misfit - lower.misfit < enough;
        if has_settled || steps == settling.most_steps {
            let Standing { place, misfit, .. } = lower;
            let step = vec![0.0; step.len()];
            return Ok(Settled { place, step, normal, misfit, steps, has_settled });
        }
        here = if is_weighed_anew { Standing::at(counts, lower.place)? } else { lower };
    }
}

/// A point, and how well it fits.
struct Standing<P> {
    place: P,
    residuals: Vec<f64>,
    misfit: f64,
}

impl<P> Standing<P> {
    fn at<C: Counts<Point = P>>(counts: &C, place: P) -> Result<Standing<P>, C::Error> {
        let residuals = counts.residuals(&place)?;
        Ok(Standing { misfit: counts.misfit(&place, &residuals), residuals, place })
    }
}

/// The point one step further, or a share of it; `None` if none lowers the misfit.
fn downhill<C: Counts>(
    counts: &C,
    here: &Standing<C::Point>,
    step: &[f64],
) -> Option<Standing<C::Point>> {
    SHARES.iter().find_map(|&share| {
        let step: Vec<f64> = step.iter().map(|by| share * by).collect();
        // A step of few counts may lead to light that has no response.
        let place = counts.moved(&here.place, &step).ok()?;
        let there = Standing::at(counts, place).ok()?;
        (there.misfit < here.misfit).then_some(there)
    })
}

/// The fit with the least misfit, of a first one and others; failed ones are passed over.
pub fn likeliest_of<F, E>(
    first: Result<F, E>,
    others: impl IntoIterator<Item = Result<F, E>>,
    misfit: impl Fn(&F) -> f64,
) -> Result<F, E> {
    others.into_iter().flatten().fold(first, |best, other| match &best {
        Err(_) => Ok(other),
        Ok(known) if misfit(&other) < misfit(known) => Ok(other),
        Ok(_) => best,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Poisson numbers of one mean, whose logarithm is the unknown.
    struct OneRate {
        counts: Vec<f64>,
        weight: f64,
    }

    impl Counts for OneRate {
        type Point = f64;
        type Error = ();

        fn residuals(&self, ln_rate: &f64) -> Result<Vec<f64>, ()> {
            Ok(self.counts.iter().map(|count| (count - ln_rate.exp()) * self.weight).collect())
        }

        fn slopes(&mut self, ln_rate: &f64, _anew: bool) -> Result<Slopes, ()> {
            let column = vec![ln_rate.exp() * self.weight; self.counts.len()];
            Ok(Slopes { columns: vec![column], are_best: true })
        }

        fn step(&self, _ln_rate: &f64, normal: &Normal) -> Vec<f64> {
            normal.solution_within(&[[-8.0, 8.0]])
        }

        fn moved(&self, ln_rate: &f64, step: &[f64]) -> Result<f64, ()> {
            Ok(ln_rate + step[0])
        }

        fn weigh(&mut self, ln_rate: &f64, _fall: f64) -> Result<bool, ()> {
            let weight = (-0.5 * ln_rate).exp();
            let is_new = weight != self.weight;
            self.weight = weight;
            Ok(is_new)
        }

        fn undetermined(&self, _ln_rate: &f64) {}
    }

    /// The likeliest rate is the mean of the counts, known to a part in the root of their sum,
    /// wherever the fit starts: from far below, the whole first step leads e^8 times too high.
    #[test]
    fn the_rate_of_poisson_numbers_is_their_mean() {
        for start in [-3.0_f64, 0.0, 6.0] {
            let counts = vec![3.0, 5.0, 7.0, 9.0];
            let mut counts = OneRate { counts, weight: (-0.5 * start).exp() };
            let settled = settle(&mut counts, start, Settling::FINE).expect("rates have means");
            assert!(settled.has_settled, "{start}");
            let ln_rate = settled.place + settled.step[0];
            assert!((ln_rate - 6.0_f64.ln()).abs() < 1e-3, "{start}: {ln_rate}");
            let std = settled.normal.standard_deviations()[0];
            assert!((std - 24.0_f64.powf(-0.5)).abs() < 1e-2, "{start}: {std}");
        }
    }

    /// Two unknowns that go together: where one is held at a limit, the other is the best beside
    /// it, by hand, and the squares fall by what these say.
    #[test]
    fn a_step_stays_within_limits_and_is_the_best_there() {
        let columns = [vec![1.0, 1.0, 0.0], vec![0.0, 1.0, 1.0]];
        let residuals = [3.0, 5.0, 4.0];
        let normal = Normal::of_whitened(&columns, &residuals).expect("it is regular");
        let free = normal.solution_within(&[[-9.0, 9.0]; 2]);
        // 2 a + b = 8, a + 2 b = 9.
        assert!((free[0] - 7.0 / 3.0).abs() < 1e-12 && (free[1] - 10.0 / 3.0).abs() < 1e-12);
        let held = normal.solution_within(&[[-9.0, 9.0], [-2.0, 2.0]]);
        // 2 a = 8 - 2.
        assert!((held[0] - 3.0).abs() < 1e-12 && held[1] == 2.0, "{held:?}");
        // From 9 + 25 + 16 to (0, 0, 2).
        assert!((normal.fall(&held) - 46.0).abs() < 1e-9, "{}", normal.fall(&held));
    }
}
