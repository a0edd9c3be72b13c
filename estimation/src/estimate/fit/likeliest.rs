//! How the maximum-likelihood delay scatters where the information about a delay changes with it.
//!
//! The inverse of the Fisher information is the variance of the maximum-likelihood delay as long as
//! the information is the same wherever the estimate may fall. An edge of the light at a
//! bin's end breaks this: a little earlier it moves photons between other bins than a little later.
//! A corner of a code's correlation, one at each phase step, does the same to the signed counts.
//!
//! Then the likelihood itself is needed. Poisson counts n_i of the means m_i make a delay h, of the
//! means m_i(h), likelier than the true one by the sum of n_i l_i(h) - (m_i(h) - m_i), with
//! l_i(h) = ln(m_i(h) / m_i). As a sum over many counts this is a normal process over h, with the mean
//! sum of m_i l_i(h) - (m_i(h) - m_i) and the covariances sum of m_i l_i(g) l_i(h). Normal counts of unit
//! variance have m_i(h) - m_i in place of l_i(h), and the mean -|m(h) - m|^2 / 2. The process' maximum is drawn.
//! At each delay the strength is the likeliest there, with the likelihood's second order in it: a peak of noise as far as a chip from the
//! path is as high as the noise, however bright the path is. Unknowns beside, and the strength of few photons, of which bins
//! without light tell all, take their directions out of m(h) - m.

use std::iter;

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, Poisson, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::error::FitError;
use crate::math::NormalLaw;
use crate::photons::fast::{InstructionSet, Runner};

/// Delays at which the likelihood is looked at: to so many standard deviations on either side, so many
/// to each.
const REACH: i32 = 9;
const DELAYS_PER_STD: i32 = 3;
/// All of them, about: of one round.
pub const DELAYS: i32 = 2 * REACH * DELAYS_PER_STD + 1;
/// Delays are chosen anew if the estimates scatter so many times as far as was thought.
const WIDER: f64 = 1.3;
/// So often, at most.
const ROUNDS: usize = 4;
/// Draws of normal sums, and of photons, which take longer. The draws' own error is 0.6 % of the standard deviation, and less the
/// more of it is linear in the errors.
const DRAWS: usize = 16_000;
const DRAWS_OF_PHOTONS: usize = 4_000;
/// As many as one product of matrices gives.
const DRAWS_AT_ONCE: usize = 250;
/// What normal sums may lack of the variance of each: a thousandth of its standard deviation.
const LEFT_OUT: f64 = 1e-6;
/// Of draws one of so many at least has to find the path, for its statistics.
const LEAST_FOUND: usize = 10;
/// Sums over fewer photons that tell of the delay are not taken as normal. Of 1.7 million detections a second in 126 bins the
/// likeliest delay scatters by 41 mm in 151 us, where normal sums have 52, and by 20 in 605 us, where they have 22 (a test).
const FEW_PHOTONS: f64 = 1_000.0;
/// As many photons or bins as may be drawn, each some 60 us of all draws.
const MOST_DRAWN: f64 = 4_000.0;
const SEED: u64 = 0x6c69_6b65;
/// Means that directions are taken out of are at least this share of the true ones.
const LEAST_MEAN_SHARE: f64 = 1e-6;
/// As far as drawn scatter may be from the inverse of the information where this is a bound: the draws'
/// own error is less, and fits have scattered by 1 to 2 % less than drawn.
const MOST_OFF_INFORMATION: f64 = 0.03;

/// How the likeliest delay scatters.
#[derive(Debug, Clone, Copy)]
pub struct Likeliest {
    /// It less the true one.
    pub law: NormalLaw,
    /// Its standard deviation if the information were the same at every delay: the Cramer-Rao bound.
    pub std_of_information: f64,
}

impl Likeliest {
    /// Whether the information changes so much that its inverse does not bound the scatter.
    pub fn is_uneven(&self) -> bool {
        is_off_information(self.law.std, self.std_of_information)
    }
}

/// Whether the inverse of the information does not bound a scatter.
pub fn is_off_information(std: f64, of_information: f64) -> bool {
    (std / of_information - 1.0).abs() > MOST_OFF_INFORMATION
}

/// Derivatives of the means, in standard deviations of each count.
pub struct PathSlopes {
    pub by_delay: Vec<f64>,
    /// By the logarithm of the strength; `None` of a known one.
    pub by_strength: Option<Vec<f64>>,
    pub by_others: Vec<Vec<f64>>,
}

impl PathSlopes {
    /// Of a path, where each has a delay and a strength, one after the other.
    pub fn of_path(mut columns: Vec<Vec<f64>>, path: usize) -> PathSlopes {
        let by_others = columns.split_off(2 * path + 2);
        let mut of_path = columns.split_off(2 * path);
        let by_strength = of_path.pop();
        let by_delay = of_path.pop().unwrap_or_default();
        columns.extend(by_others);
        PathSlopes { by_delay, by_strength, by_others: columns }
    }
}

/// How counts scatter.
pub enum Scatter<'a> {
    /// As Poisson numbers of these means.
    Poisson(&'a [f64]),
    /// As normal ones that go with no others.
    Normal,
}

impl Scatter<'_> {
    /// Whether sums over the photons that tell of the delay, of these slopes, are not normal.
    fn is_of_few(&self, slopes: &[f64]) -> bool {
        match self {
            Scatter::Poisson(means) => photons_that_tell(slopes, means) < FEW_PHOTONS,
            Scatter::Normal => false,
        }
    }

    /// What the likelihood of means so far `apart`, in standard deviations of each count, depends on: the errors'
    /// factors, and its mean.
    fn likelihood(&self, mut apart: DVector<f64>) -> (DVector<f64>, f64) {
        let Scatter::Poisson(means) = *self else {
            let gain = -0.5 * apart.norm_squared();
            return (apart, gain);
        };
        let mut gain = 0.0;
        for (apart, mean) in apart.iter_mut().zip(means) {
            let share = (*apart / mean.sqrt()).max(LEAST_MEAN_SHARE - 1.0);
            gain += mean * (share.ln_1p() - share);
            *apart = mean.sqrt() * share.ln_1p();
        }
        (apart, gain)
    }

    /// What errors tell of more light, where the means are so far `apart` from the true ones: they count as parts of
    /// the means there.
    fn tells(&self, mut light: DVector<f64>, apart: &DVector<f64>) -> DVector<f64> {
        if let Scatter::Poisson(means) = *self {
            for ((light, apart), mean) in light.iter_mut().zip(apart).zip(means) {
                *light /= (1.0 + apart / mean.sqrt()).max(LEAST_MEAN_SHARE);
            }
        }
        light
    }
}

/// The likeliest delay less the true one.
///
/// In standard deviations of each count, `apart` is how far the means of a later delay are from the true ones. Scans
/// whose likeliest delay is `found_within` or farther off have [missed](crate::estimate::missed) the path, and do not count.
/// `None` where these are no finite numbers, or do not tell the delay, or hardly any scan finds it.
///
/// # Errors
/// As `apart`.
pub fn likeliest(
    scatter: &Scatter,
    slopes: PathSlopes,
    found_within: f64,
    apart: impl Fn(f64) -> Result<Vec<f64>, FitError>,
) -> Result<Option<Likeliest>, FitError> {
    let others: Vec<_> = slopes.by_others.into_iter().map(DVector::from_vec).collect();
    let others = (!others.is_empty()).then(|| DMatrix::from_columns(&others).qr().q());
    let own = |of: Vec<f64>| {
        let of = DVector::from_vec(of);
        match &others {
            Some(others) => &of - others * others.tr_mul(&of),
            None => of,
        }
    };
    let (slope, strength) = (own(slopes.by_delay), slopes.by_strength.map(own));
    let beside_strength = |of: DVector<f64>| match &strength {
        Some(strength) => &of - strength * (of.dot(strength) / strength.norm_squared()),
        None => of,
    };
    let slope = beside_strength(slope);
    let are_few = scatter.is_of_few(slope.as_slice());
    let std_of_information = slope.norm().recip();
    let mut law = NormalLaw { mean: 0.0, std: std_of_information };
    if !law.std.is_finite() {
        return Ok(None);
    }
    for _ in 0..ROUNDS {
        let scale = law.std;
        let delays: Vec<f64> = (-DELAYS / 2..=DELAYS / 2)
            .map(|at| f64::from(at) * scale / f64::from(DELAYS_PER_STD))
            .collect();
        let mut places = vec![slope.clone()];
        let mut likelier = Vec::new();
        for &delay in &delays {
            let apart = own(apart(delay)?);
            let apart = if are_few { beside_strength(apart) } else { apart };
            let light = strength.as_ref().filter(|_| !are_few).map(|here| {
                let light = scatter.tells(here + &apart, &apart);
                let height = light.norm();
                let light = light / height.max(f64::MIN_POSITIVE);
                (StrengthThere { along: apart.dot(&light), height }, light)
            });
            let (place, gain) = scatter.likelihood(apart);
            places.push(place);
            let strength = light.map(|(strength, light)| {
                places.push(light);
                strength
            });
            likelier.push(Likelier { gain, strength });
        }
        let next = drawn(scatter, &delays, found_within, &places, &likelier);
        let Some(next) = next else { return Ok(None) };
        law = next;
        if law.std < WIDER * scale {
            break;
        }
    }
    Ok(Some(Likeliest { law, std_of_information }))
}

/// How much likelier a delay is than the true one.
struct Likelier {
    /// On average, with the true strength.
    gain: f64,
    /// Of a strength that is found with the delay.
    strength: Option<StrengthThere>,
}

/// The direction in which the means move with the strength.
struct StrengthThere {
    /// How far the means are from the true ones along it.
    along: f64,
    /// How far light is from none.
    height: f64,
}

/// Of each draw the largest likelihood of the delays that have been looked at, in their order, and those of the two delays
/// beside it.
struct Maxima {
    largest: OfDraws,
    /// Number of the delay.
    at: OfDraws,
    before: OfDraws,
    after: OfDraws,
    last: OfDraws,
}

/// A number of each draw.
type OfDraws = [f64; DRAWS_AT_ONCE];

impl Maxima {
    const NONE: OfDraws = [f64::NEG_INFINITY; DRAWS_AT_ONCE];

    /// Of draws with what their errors add to the likelihood of each delay and, next, in the direction of its strength,
    /// which is the likeliest.
    fn of(likelier: &[Likelier], errors: &[OfDraws]) -> Maxima {
        let mut maxima = Maxima {
            largest: Maxima::NONE,
            at: [0.0; DRAWS_AT_ONCE],
            before: Maxima::NONE,
            after: Maxima::NONE,
            last: Maxima::NONE,
        };
        InstructionSet::best().run(&mut Look { likelier, errors, maxima: &mut maxima });
        maxima
    }

    #[inline(always)]
    fn look_at(&mut self, at: f64, likelihood: &OfDraws) {
        // Choices, of which vector instructions are made, and no branches.
        for (draw, &here) in likelihood.iter().enumerate() {
            let is_after = self.at[draw] + 1.0 == at;
            let is_larger = here > self.largest[draw];
            self.after[draw] = if is_after { here } else { self.after[draw] };
            self.before[draw] = if is_larger { self.last[draw] } else { self.before[draw] };
            self.at[draw] = if is_larger { at } else { self.at[draw] };
            self.largest[draw] = if is_larger { here } else { self.largest[draw] };
            self.last[draw] = here;
        }
    }

    /// Where they are: between delays by the parabola through three of them.
    fn delays(&self, delays: &[f64]) -> impl Iterator<Item = f64> {
        self.at.iter().enumerate().map(|(draw, &at)| {
            let at = at as usize;
            if at == 0 || at + 1 == delays.len() {
                return delays[at];
            }
            let (before, after) = (self.before[draw], self.after[draw]);
            let bend = 2.0 * self.largest[draw] - before - after;
            let share = if bend > 0.0 { 0.5 * (after - before) / bend } else { 0.0 };
            delays[at] + share * (delays[at + 1] - delays[at])
        })
    }
}

/// A look at every delay.
struct Look<'a> {
    likelier: &'a [Likelier],
    /// Of delay after delay.
    errors: &'a [OfDraws],
    maxima: &'a mut Maxima,
}

impl Runner for Look<'_> {
    #[inline(always)]
    fn run(&mut self) {
        let mut errors = self.errors;
        let mut likelihood = Maxima::NONE;
        for at in 0..self.likelier.len() {
            let Likelier { gain, strength } = &self.likelier[at];
            let Some((of_delay, rest)) = errors.split_first() else { return };
            errors = rest;
            match strength {
                None => {
                    for draw in 0..DRAWS_AT_ONCE {
                        likelihood[draw] = gain + of_delay[draw];
                    }
                }
                Some(StrengthThere { along, height }) => {
                    let Some((of_strength, rest)) = errors.split_first() else { return };
                    errors = rest;
                    for draw in 0..DRAWS_AT_ONCE {
                        let more = of_strength[draw] - along;
                        let higher = more.max(-height);
                        likelihood[draw] = gain + of_delay[draw] + (more - 0.5 * higher) * higher;
                    }
                }
            }
            self.maxima.look_at(at as f64, &likelihood);
        }
    }
}

/// From the slope, and how the likelihood of each delay depends on the counts' errors, and on those in the direction of its
/// strength. What is linear in the errors is known, and drawn only to take its part of the draws' own
/// errors out.
fn drawn(
    scatter: &Scatter,
    delays: &[f64],
    found_within: f64,
    places: &[DVector<f64>],
    likelier: &[Likelier],
) -> Option<NormalLaw> {
    let information = places[0].norm_squared();
    let errors = Errors::new(scatter, places)?;
    let [mut linear, mut likeliest] = [const { Vec::new() }; 2];
    errors.draw(&mut Xoshiro256PlusPlus::seed_from_u64(SEED), |sums| {
        let Some((of_slope, of_delays)) = sums.split_first() else { return };
        linear.extend(of_slope.iter().map(|sum| sum / information));
        likeliest.extend(Maxima::of(likelier, of_delays).delays(delays));
    });
    let least_found = linear.len() / LEAST_FOUND;
    likeliest.retain(|delay| delay.abs() < found_within);
    if likeliest.len() < least_found {
        return None;
    }
    let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
    let variance = |of: &[f64]| {
        let mean = mean(of);
        of.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / of.len() as f64
    };
    let std = information.powf(-0.5) * (variance(&likeliest) / variance(&linear)).sqrt();
    let mean = mean(&likeliest) - mean(&linear);
    (mean.is_finite() && std.is_finite()).then_some(NormalLaw { mean, std })
}

/// What errors of the counts add to the slope and to each likelihood.
enum Errors {
    /// Sums of so many errors that they are normal: a factor of their covariance, transposed.
    Normal(DMatrix<f64>),
    /// Of few photons: what one in each bin adds, bin by bin, and the mean of it all.
    Photons { fall: Fall, each: DMatrix<f64>, mean: DVector<f64> },
}

/// Sums of independent normal numbers, each with factors of its own.
struct Combined<'a> {
    normal: &'a [OfDraws],
    /// Those of one sum after those of another.
    factor: &'a [f64],
    sums: &'a mut [OfDraws],
}

impl Runner for Combined<'_> {
    #[inline(always)]
    fn run(&mut self) {
        let of_sums = self.factor.chunks_exact(self.normal.len());
        for (sum, factors) in self.sums.iter_mut().zip(of_sums) {
            *sum = [0.0; DRAWS_AT_ONCE];
            for (normal, factor) in self.normal.iter().zip(factors) {
                for (sum, normal) in sum.iter_mut().zip(normal) {
                    *sum += normal * factor;
                }
            }
        }
    }
}

/// How photons fall into bins.
enum Fall {
    /// One by one: their number, and running sums of the bins' means.
    OneByOne(Poisson<f64>, Vec<f64>),
    /// So many into each bin, none into one without light.
    IntoEach(Vec<Option<Poisson<f64>>>),
}

impl Errors {
    fn new(scatter: &Scatter, places: &[DVector<f64>]) -> Option<Errors> {
        if let Scatter::Poisson(means) = *scatter
            && scatter.is_of_few(places[0].as_slice())
            && let Some(fall) = Fall::of(means)
        {
            let roots = DVector::from_iterator(means.len(), means.iter().map(|mean| mean.sqrt()));
            let mut each = DMatrix::from_columns(places).transpose();
            let mean = &each * &roots;
            each.column_iter_mut().zip(&roots).for_each(|(mut column, root)| column /= *root);
            return Some(Errors::Photons { fall, each, mean });
        }
        Some(Errors::Normal(few_columns(places, LEFT_OUT)?.transpose()))
    }

    /// Gives `each_block` the sums of the errors of as many scans as are drawn at once: place by place those of all scans.
    fn draw(&self, rng: &mut Xoshiro256PlusPlus, mut each_block: impl FnMut(&[OfDraws])) {
        match self {
            Errors::Normal(factor) => {
                let mut normal = vec![Maxima::NONE; factor.nrows()];
                let mut sums = vec![Maxima::NONE; factor.ncols()];
                for _ in 0..DRAWS / DRAWS_AT_ONCE {
                    normal.as_flattened_mut().fill_with(|| StandardNormal.sample(rng));
                    let (factor, sums) = (factor.as_slice(), &mut sums);
                    InstructionSet::best().run(&mut Combined { normal: &normal, factor, sums });
                    each_block(sums);
                }
            }
            Errors::Photons { fall, each, mean } => {
                let places = mean.len();
                for _ in 0..DRAWS_OF_PHOTONS / DRAWS_AT_ONCE {
                    let scans: Vec<_> = iter::repeat_with(|| {
                        let mut sums = -mean;
                        fall.draw(rng, |bin, photons| {
                            let one = &each.as_slice()[bin * places..][..places];
                            sums.iter_mut().zip(one).for_each(|(sum, one)| *sum += photons * one);
                        });
                        sums.transpose()
                    })
                    .take(DRAWS_AT_ONCE)
                    .collect();
                    each_block(DMatrix::from_rows(&scans).as_slice().as_chunks().0);
                }
            }
        }
    }
}

/// F of few columns: F F^T is the covariance of some numbers, each with factors of errors that go with no others, but for at
/// most the share `left_out` of the variance of each, so that F z has it if z is of independent standard normal numbers. By
/// Cholesky's method, of the number of which the largest share is left: no other covariances are asked for. `None` where a
/// variance is not finite, or nothing varies.
fn few_columns(factors: &[DVector<f64>], left_out: f64) -> Option<DMatrix<f64>> {
    let of_all = |of: &dyn Fn(&DVector<f64>) -> f64| {
        DVector::from_iterator(factors.len(), factors.iter().map(of))
    };
    let variances = of_all(&|factors| factors.dot(factors));
    if !variances.iter().all(|variance| variance.is_finite()) {
        return None;
    }
    let varying: Vec<usize> = (0..variances.len()).filter(|&at| variances[at] > 0.0).collect();
    let mut left = variances.clone();
    let mut columns: Vec<DVector<f64>> = Vec::new();
    while columns.len() < varying.len() {
        let share = |at: usize| left[at] / variances[at];
        let most = varying.iter().copied().max_by(|&a, &b| share(a).total_cmp(&share(b)))?;
        if share(most) <= left_out {
            break;
        }
        let mut column = of_all(&|other| other.dot(&factors[most]));
        for before in &columns {
            column.axpy(-before[most], before, 1.0);
        }
        column /= left[most].sqrt();
        left -= column.component_mul(&column);
        left[most] = 0.0;
        columns.push(column);
    }
    (!columns.is_empty()).then(|| DMatrix::from_columns(&columns))
}

impl Fall {
    /// Whichever takes less time; `None` where either takes too long.
    fn of(means: &[f64]) -> Option<Fall> {
        let photons: f64 = means.iter().sum();
        let bins = means.len() as f64;
        if photons.min(bins) > MOST_DRAWN {
            return None;
        }
        if photons > bins {
            return Some(Fall::IntoEach(
                means.iter().map(|&mean| Poisson::new(mean).ok()).collect(),
            ));
        }
        let mut sum = 0.0;
        let sums = means.iter().map(|mean| {
            sum += mean;
            sum
        });
        Some(Fall::OneByOne(Poisson::new(photons).ok()?, sums.collect()))
    }

    /// Calls `into` with bins, and how many photons fall into each.
    fn draw(&self, rng: &mut Xoshiro256PlusPlus, mut into: impl FnMut(usize, f64)) {
        match self {
            Fall::OneByOne(number, sums) => {
                let all = sums[sums.len() - 1];
                for _ in 0..number.sample(rng) as u64 {
                    let at = rng.random_range(0.0..all);
                    into(sums.partition_point(|&sum| sum <= at).min(sums.len() - 1), 1.0);
                }
            }
            Fall::IntoEach(bins) => {
                for (bin, number) in bins.iter().enumerate() {
                    let photons = number.map_or(0.0, |number| number.sample(rng));
                    if photons > 0.0 {
                        into(bin, photons);
                    }
                }
            }
        }
    }
}

/// How many photons tell of the delay, where `slopes` are the derivatives of the bins' `means` in standard deviations of each. A
/// photon tells (slope / mean)^2 of its bin, and what all tell is as even as a Poisson number of this mean.
pub fn photons_that_tell(slopes: &[f64], means: &[f64]) -> f64 {
    let lit = || slopes.iter().zip(means).filter(|(_, mean)| **mean > 0.0);
    let told: f64 = lit().map(|(slope, _)| slope * slope).sum();
    told * told / lit().map(|(slope, mean)| slope.powi(4) / mean).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{normal_cdf, normal_density};

    /// Of normal counts, and of Poisson ones that are so large that their errors are normal.
    fn law(slopes: &[&[f64]], apart: impl Fn(f64) -> Vec<f64>) -> NormalLaw {
        let means = vec![1e12; slopes[0].len()];
        let of = |scatter: Scatter| {
            let [delay, others @ ..] = slopes else { panic!("a slope") };
            let slopes = PathSlopes {
                by_delay: delay.to_vec(),
                by_strength: None,
                by_others: others.iter().map(|slope| slope.to_vec()).collect(),
            };
            likeliest(&scatter, slopes, f64::INFINITY, |h| Ok(apart(h)))
                .unwrap()
                .expect("they are finite")
                .law
        };
        let (normal, poisson) = (of(Scatter::Normal), of(Scatter::Poisson(&means)));
        assert!((normal.std / poisson.std - 1.0).abs() < 1e-3, "{normal:?} {poisson:?}");
        assert!((normal.mean - poisson.mean).abs() < 1e-3, "{normal:?} {poisson:?}");
        normal
    }

    /// Where the means are linear, the normal equations say it all; of an unknown beside, half of
    /// the information is gone.
    #[test]
    fn of_linear_means_it_is_the_inverse_of_the_information() {
        let found = law(&[&[2.0, 0.0]], |h| vec![2.0 * h, 0.0]);
        assert!(found.mean.abs() < 1e-4 && (found.std - 0.5).abs() < 1e-4, "{found:?}");
        let beside = law(&[&[1.0, 1.0], &[1.0, 0.0]], |h| vec![h, h]);
        assert!(beside.mean.abs() < 1e-4 && (beside.std - 1.0).abs() < 1e-4, "{beside:?}");
    }

    /// A delay h moves 60 h of 60 counts from one bin to the other, which has a tenth of them: the likeliest h
    /// is the share of the first less 0.1, a binomial's, without bias, although its few counts are skew.
    #[test]
    fn of_counts_that_a_delay_parts_it_is_the_binomials_law() {
        let (number, share) = (60.0_f64, 0.1);
        let means = [number * share, number * (1.0 - share)];
        let [slope, other] = means.map(|mean| number / mean.sqrt());
        let scatter = Scatter::Poisson(&means);
        let slopes =
            PathSlopes { by_delay: vec![slope, -other], by_strength: None, by_others: Vec::new() };
        let found = likeliest(&scatter, slopes, f64::INFINITY, |h| Ok(vec![slope * h, -other * h]));
        let found = found.unwrap().expect("they are finite").law;
        let std = f64::sqrt(share * (1.0 - share) / number);
        assert!((found.std / std - 1.0).abs() < 0.03, "{found:?} {std}");
        assert!(found.mean.abs() < 0.03 * std, "{found:?} {std}");
    }

    /// Earlier delays move one count, later ones another, by a half of it: the likelier of the two
    /// maxima is taken. Of earlier ones x = max(0, e_1), of later ones y = max(0, e_2 / 2) in
    /// units of d^2 / 2: the estimate is -e_1 where e_1 > max(0, e_2), and 2 e_2 where e_2 is
    /// larger. With density 2 phi(x) Phi(x) of the larger of two, cut at 0: means by quadrature.
    #[test]
    fn at_a_corner_the_likelier_side_is_taken() {
        let slope = [-0.5_f64.hypot(0.25), 0.0];
        let found = law(&[&slope], |h| match h < 0.0 {
            true => vec![-h, 0.0],
            false => vec![0.0, 0.5 * h],
        });
        let step = 1e-3;
        let larger = |power: i32| -> f64 {
            let of = |x: f64| x.powi(power) * normal_density(x) * normal_cdf(x) * step;
            (0..8_000).map(|at| of((f64::from(at) + 0.5) * step)).sum()
        };
        let mean = 2.0 * larger(1) - larger(1);
        let std = (4.0 * larger(2) + larger(2) - mean * mean).sqrt();
        assert!((found.mean - mean).abs() < 0.06, "{found:?} {mean}");
        assert!((found.std / std - 1.0).abs() < 0.06, "{found:?} {std}");
    }

    /// Numbers that three others determine have three columns, of which one has hardly any of its own, two.
    #[test]
    fn numbers_that_a_few_determine_have_as_many_columns() {
        let of = |least: f64| {
            let made = DMatrix::from_fn(40, 3, |row, column| {
                let row = row as f64;
                [row.cos(), 5.0 * row.sin(), least * (2.0 * row).cos()][column]
            });
            let covariance = &made * made.transpose();
            let factors: Vec<_> = made.row_iter().map(|row| row.transpose()).collect();
            let few = few_columns(&factors, 1e-6).expect("numbers that vary");
            let missing = (&few * few.transpose() - &covariance).diagonal();
            (few.ncols(), missing.component_div(&covariance.diagonal()).amax())
        };
        let (columns, missing) = of(1.0);
        assert!(columns == 3 && missing < 1e-12, "{columns} {missing}");
        let (columns, missing) = of(1e-4);
        assert!(columns == 2 && missing < 1e-6, "{columns} {missing}");
        assert!(few_columns(&[DVector::zeros(2), DVector::zeros(2)], 1e-6).is_none());
    }
}
