//! The light behind a histogram: dead time and afterpulses taken out, without a model of
//! light or code.
//!
//! With h\[a\] = H\[a\] / K the mean detections of bin a in a code period, and everything
//! periodic:
//!
//! - A detection blinds the detector for the dead time. It lies anywhere in its bin, so the
//!   share of periods in which the detector is ready in bin a is
//!   q\[a\] = 1 - sum over m of w\[m\] h\[a - m\], w\[m\] the mean share of bin a that the
//!   dead time of a detection m bins before covers.
//! - A ready detector fires at the rate h / q, by light or by an afterpulse. Let n be the mean
//!   number of afterpulses that are pending while it is ready. They are released at the rate
//!   n / tau, they end with the detector's being ready, and a dead time after an avalanche
//!   its new ones (mu on average) and what is left of those that were pending come:
//!   n' = -(h / q + 1 / tau) n + (mu h + exp(-D / tau) (h / q) n) one dead time before.
//!   That a detector with more pending fires sooner is left out between the two factors h / q
//!   and n, which is of the order of n squared.
//! - The light is what is left: lambda\[a\] = (h\[a\] - n\[a\] / tau) / q\[a\].
//!
//! Constant delays only shift the bins. Jitter is left out, and so is how light and dead times
//! vary within a bin. Every detection has to have a rising edge of its own: pulses as long
//! as a sample, that do not merge.

use super::Histogram;
use crate::photons::fast::{InstructionSet, Runner};

/// What a detector does beside registering light, in bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BinnedDetector {
    /// Not paralyzable, in bins (sample periods).
    pub bins: f64,
    /// Afterpulses from the end of the dead time on; none if nothing is trapped.
    pub afterpulses: Option<BinnedAfterpulses>,
}

/// Afterpulses of one detector, in bins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BinnedAfterpulses {
    /// Mean number that an avalanche traps.
    pub mean_per_avalanche: f64,
    /// Mean delay from the end of the dead time, in bins.
    pub time_constant_bins: f64,
}

/// The light behind a histogram, bin by bin.
#[derive(Debug, Clone, PartialEq)]
pub struct PrimaryLight {
    /// Mean primary detections that a detector without dead time and afterpulses would have
    /// in a code period. Noise may take them below zero.
    pub per_period: Vec<f64>,
    /// Variance of each. What dead time correlates is apart again: as far as bins resolve
    /// dead times, no two bins go together.
    pub variance: Vec<f64>,
    /// Share of code periods in which the detector is ready.
    pub ready: Vec<f64>,
}

/// Why the light behind a histogram cannot be told.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum CorrectionError {
    /// Not a dead time.
    #[error("the dead time is {bins} bins; a correction needs a number from 0 on")]
    NoDeadTime {
        /// What was given.
        bins: f64,
    },
    /// Not a time constant or number of afterpulses.
    #[error(
        "{mean_per_avalanche} afterpulses per avalanche with a time constant of \
         {time_constant_bins} bins; a correction needs a number from 0 on, and a time above 0"
    )]
    NoAfterpulses {
        /// Mean number per avalanche.
        mean_per_avalanche: f64,
        /// Time constant.
        time_constant_bins: f64,
    },
    /// Afterpulses would follow within the same bin.
    #[error(
        "the dead time is {bins} bins; afterpulses are taken out from a dead time of one bin on: \
         take more samples per chip"
    )]
    DeadTimeBelowBin {
        /// The dead time.
        bins: f64,
    },
    /// More was detected than the dead time lets through.
    #[error(
        "by the histogram a detector with a dead time of {dead_time_bins} bins is ready in \
         {ready:.4} of the code periods at bin {bin}, which is too seldom to take the dead time \
         out; it is too long for these counts, or there are too few periods for light so bright"
    )]
    NeverReady {
        /// The first such bin.
        bin: usize,
        /// Its ready share.
        ready: f64,
        /// The dead time.
        dead_time_bins: f64,
    },
    /// Afterpulses pile up.
    #[error(
        "the afterpulses still pending do not settle over {turns} code periods: \
         {mean_per_avalanche} of them per avalanche do not die out"
    )]
    NotSettled {
        /// Periods gone through.
        turns: u32,
        /// Mean number per avalanche.
        mean_per_avalanche: f64,
    },
}

/// A detector that is ready in a smaller share of periods than this is as good as never.
const LEAST_READY: f64 = 1e-6;

/// A bin in which the detector was ready in fewer periods than this is not measured, and a
/// histogram with a larger share of such bins says nothing.
const LEAST_PERIODS: f64 = 1.0;
const MOST_UNMEASURED: f64 = 0.1;

/// Bins that are summed before they are added to what was before.
const SUMMED_AT_ONCE: usize = 16;

/// Code periods after which the pending afterpulses have to repeat, and how nearly.
const MOST_TURNS: u32 = 1_000;
const SETTLED: f64 = 1e-12;

impl BinnedDetector {
    /// The light behind a histogram, with its variances.
    ///
    /// Without bias however few the periods: of two detections in a bin one has blinded the
    /// detector for the other, half of the bin on average, but none blinds it for itself. In
    /// bins in which it was ready in less than one period, nothing was measured; they are
    /// taken to be as bright as the nearest that were.
    ///
    /// # Errors
    /// When the histogram cannot be of such a detector, or does not measure a tenth of its
    /// bins.
    pub fn correct(&self, histogram: &Histogram) -> Result<PrimaryLight, CorrectionError> {
        self.check()?;
        let per_period = histogram.per_period();
        let periods = histogram.periods() as f64;
        let own = (triangular(self.bins) - 0.5) / periods;
        let blind = self.blind(&per_period).into_iter().zip(histogram.bins());
        let ready: Vec<f64> =
            blind.map(|(blind, &count)| 1.0 - blind + if count > 0 { own } else { 0.0 }).collect();
        let is_measured = |ready: f64| ready * periods >= LEAST_PERIODS;
        let measured: Vec<bool> = ready.iter().map(|&ready| is_measured(ready)).collect();
        let unmeasured = measured.iter().filter(|measured| !*measured).count();
        if let Some(bin) = measured.iter().position(|measured| !measured)
            && unmeasured as f64 > MOST_UNMEASURED * measured.len() as f64
        {
            return Err(self.never_ready(bin, ready[bin]));
        }
        let hazard = filled(quotients(&per_period, &ready), &measured);
        let released = self.released(&per_period, &hazard)?;
        let light = per_period.iter().zip(&released).zip(&ready);
        let light = light.map(|((h, released), q)| (h - released) / q).collect();
        let variance = per_period.iter().zip(&ready).map(|(h, q)| h / (q * q * periods));
        Ok(PrimaryLight {
            per_period: filled(light, &measured),
            variance: filled(variance.collect(), &measured),
            ready: ready.iter().map(|ready| ready.clamp(0.0, 1.0)).collect(),
        })
    }

    /// The same from mean detections of each bin in a code period, such as expected ones;
    /// `periods` of them are measured.
    ///
    /// # Errors
    /// When they cannot be of such a detector.
    pub fn correct_means(
        &self,
        per_period: &[f64],
        periods: f64,
    ) -> Result<PrimaryLight, CorrectionError> {
        self.check()?;
        let ready = self.ready(per_period)?;
        let hazard = quotients(per_period, &ready);
        let released = self.released(per_period, &hazard)?;
        let light = per_period.iter().zip(&released).zip(&ready);
        // A ready detector's detections are Poisson: what a period has beyond rate x ready
        // does not go with what came before, nor with what comes.
        let variance = per_period.iter().zip(&ready);
        Ok(PrimaryLight {
            per_period: light.map(|((h, released), q)| (h - released) / q).collect(),
            variance: variance.map(|(h, q)| h / (q * q * periods)).collect(),
            ready,
        })
    }

    pub(super) fn check(&self) -> Result<(), CorrectionError> {
        let bins = self.bins;
        if !(bins.is_finite() && bins >= 0.0) {
            return Err(CorrectionError::NoDeadTime { bins });
        }
        let Some(BinnedAfterpulses { mean_per_avalanche, time_constant_bins }) = self.afterpulses
        else {
            return Ok(());
        };
        let is_number = mean_per_avalanche.is_finite() && mean_per_avalanche >= 0.0;
        if !(is_number && time_constant_bins.is_finite() && time_constant_bins > 0.0) {
            return Err(CorrectionError::NoAfterpulses { mean_per_avalanche, time_constant_bins });
        }
        if bins < 1.0 {
            return Err(CorrectionError::DeadTimeBelowBin { bins });
        }
        Ok(())
    }

    /// Share of periods in which the detector is ready, bin by bin.
    pub(super) fn ready(&self, per_period: &[f64]) -> Result<Vec<f64>, CorrectionError> {
        let blind = self.blind(per_period);
        let ready: Vec<f64> = blind.iter().map(|blind| 1.0 - blind).collect();
        match ready.iter().position(|&ready| ready < LEAST_READY) {
            None => Ok(ready),
            Some(bin) => Err(self.never_ready(bin, ready[bin])),
        }
    }

    fn never_ready(&self, bin: usize, ready: f64) -> CorrectionError {
        CorrectionError::NeverReady { bin, ready, dead_time_bins: self.bins }
    }

    /// What of each bin the dead times of detections cover.
    pub(super) fn blind(&self, detections: &[f64]) -> Vec<f64> {
        let count = detections.len();
        let Shares { first, whole, last, after } = self.shares();
        let mut sums = Vec::with_capacity(count + 1);
        let mut sum = 0.0;
        sums.push(sum);
        // Some at a time: one sum would wait for each of its additions.
        for bins in detections.chunks(SUMMED_AT_ONCE) {
            let mut within = 0.0;
            for bin in bins {
                within += bin;
                sums.push(sum + within);
            }
            sum += within;
        }
        // A dead time may last any number of code periods.
        let covered = whole.saturating_sub(1);
        let (periods, rest) = ((covered / count) as f64, covered % count);
        let (last_back, after_back) = (whole % count, (whole + 1) % count);
        let mut cuts = [0, rest, last_back, after_back, count];
        cuts.sort_unstable();
        let mut blind = Vec::with_capacity(count);
        // Between two cuts, whatever is some bins earlier is in one period.
        for part in cuts.windows(2) {
            let (start, length) = (part[0], part[1] - part[0]);
            let earlier = |by: usize| {
                let place = if by <= start { start - by } else { count + start - by };
                place..place + length
            };
            let turned = if rest <= start { periods } else { periods + 1.0 };
            let covered = sums[earlier(0)].iter().zip(&sums[earlier(rest)]);
            let beside =
                detections[earlier(last_back)].iter().zip(&detections[earlier(after_back)]);
            let of_bins = detections[earlier(0)].iter().zip(covered).zip(beside);
            blind.extend(of_bins.map(|((here, (until, from)), (of_last, of_after))| {
                let end = match whole {
                    0 => 0.0,
                    _ => until - from + turned * sum + last * of_last,
                };
                first * here + end + after * of_after
            }));
        }
        blind
    }

    /// w\[m\] = F(D - m) - F(-m), F the distribution of the time from one place anywhere in
    /// a bin to another, in bins.
    pub(super) fn shares(&self) -> Shares {
        let whole = self.bins.floor();
        let part = self.bins - whole;
        Shares {
            first: triangular(self.bins) - 0.5,
            whole: whole as usize,
            last: triangular(part),
            after: triangular(part - 1.0),
        }
    }

    /// Mean afterpulses that detections release in each bin of a code period, where a ready
    /// detector fires at the rates `hazard` per bin.
    fn released(&self, per_period: &[f64], hazard: &[f64]) -> Result<Vec<f64>, CorrectionError> {
        match self.afterpulses {
            None => Ok(vec![0.0; per_period.len()]),
            Some(afterpulses) => Releases::new(self.bins, afterpulses, hazard).of(per_period),
        }
    }
}

/// The mean shares of later bins that the dead time of a detection covers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Shares {
    /// Of its own bin.
    pub(super) first: f64,
    /// Whole bins of the dead time. Those before the bin so many later are covered.
    pub(super) whole: usize,
    /// Of the bin so many later, if that is not its own.
    pub(super) last: f64,
    /// Of the bin after that.
    pub(super) after: f64,
}

/// How afterpulses that are pending go through the bins of a code period.
#[derive(Debug, Clone)]
pub(super) struct Releases {
    afterpulses: BinnedAfterpulses,
    dead_time_bins: f64,
    /// Share of those pending that a dead time outlasts.
    survival: f64,
    /// Rate per bin at which a ready detector fires.
    hazard: Vec<f64>,
    /// Of the part of each bin before the place of its start one dead time later, and after: its width, and
    /// [`seconds`] of every bin.
    widths: [f64; 2],
    seconds: [Vec<f64>; 2],
}

impl Releases {
    pub(super) fn new(
        dead_time_bins: f64,
        afterpulses: BinnedAfterpulses,
        hazard: &[f64],
    ) -> Releases {
        let part = dead_time_bins.fract();
        let rate = 1.0 / afterpulses.time_constant_bins;
        let rates: Vec<f64> = hazard.iter().map(|hazard| hazard + rate).collect();
        let widths = [part, 1.0 - part];
        Releases {
            afterpulses,
            dead_time_bins,
            survival: (-dead_time_bins * rate).exp(),
            hazard: hazard.to_vec(),
            seconds: widths.map(|width| seconds(&rates, width)),
            widths,
        }
    }

    /// Mean afterpulses that detections release in each bin. Linear in the detections.
    pub(super) fn of(&self, detections: &[f64]) -> Result<Vec<f64>, CorrectionError> {
        let count = detections.len();
        let whole = self.dead_time_bins.floor() as usize;
        // Pending ones while ready, on average over each bin.
        let mut pending = vec![0.0; count];
        let (mut now, mut largest) = (0.0, 0.0_f64);
        // What is pending follows from that of the last dead time and a bin: where it has been
        // the same in the code period before for so long, it stays so.
        let memory = (whole + 2).min(count);
        let mut same = 0;
        for turn in 0..MOST_TURNS {
            // The bins from which avalanches come back in this one: in its first part, and
            // in its second.
            let early = (count - (whole + 1) % count) % count;
            let mut late = early;
            let mut early = self.back(early, detections[early], pending[early]);
            for a in 0..count {
                late = if late + 1 == count { 0 } else { late + 1 };
                let back = [early, self.back(late, detections[late], pending[late])];
                let sum = self.through(a, back, &mut now);
                largest = largest.max(sum.abs());
                let is_same = turn > 0 && (sum - pending[a]).abs() <= SETTLED * largest;
                same = if is_same { same + 1 } else { 0 };
                pending[a] = sum;
                early = back[1];
                if same >= memory {
                    return Ok(pending.iter().map(|p| p * self.rate()).collect());
                }
            }
            if !largest.is_finite() {
                break;
            }
        }
        Err(CorrectionError::NotSettled {
            turns: MOST_TURNS,
            mean_per_avalanche: self.afterpulses.mean_per_avalanche,
        })
    }

    /// Releases of each pending afterpulse, per bin.
    pub(super) fn rate(&self) -> f64 {
        1.0 / self.afterpulses.time_constant_bins
    }

    /// What comes back one dead time after the detections of bin `bin`, in which so many
    /// are pending.
    pub(super) fn back(&self, bin: usize, detections: f64, pending: f64) -> f64 {
        self.afterpulses.mean_per_avalanche * detections
            + self.survival * self.hazard[bin] * pending
    }

    /// Takes what is pending `now` through bin `bin`, with what comes back in its first
    /// part and in its second; gives its average there.
    #[inline(always)]
    pub(super) fn through(&self, bin: usize, back: [f64; 2], now: &mut f64) -> f64 {
        let rate = self.hazard[bin] + self.rate();
        let decay = |part: usize| Decay::new(rate, self.widths[part], self.seconds[part][bin]);
        let (first, second) = (decay(0), decay(1));
        // What comes back by itself: what is pending waits for nothing but a product and a sum.
        let of_back = [first.once * back[0], second.once * back[1]];
        let sum = (first.once + second.once * first.stays) * *now
            + (first.twice * back[0] + second.once * of_back[0])
            + second.twice * back[1];
        *now = first.stays * second.stays * *now + (second.stays * of_back[0] + of_back[1]);
        sum
    }
}

/// Values with those that were not measured halfway between the nearest on both sides, all
/// round.
fn filled(mut values: Vec<f64>, measured: &[bool]) -> Vec<f64> {
    let count = values.len();
    let nearest = |from: usize, step: usize| {
        let places = (1..count).map(|times| (from + times * step) % count);
        places.into_iter().find(|&place| measured[place])
    };
    for place in 0..count {
        if !measured[place] {
            let [before, after] = [count - 1, 1].map(|step| nearest(place, step));
            values[place] = match (before, after) {
                (Some(before), Some(after)) => 0.5 * (values[before] + values[after]),
                _ => 0.0,
            };
        }
    }
    values
}

pub(super) fn quotients(per_period: &[f64], ready: &[f64]) -> Vec<f64> {
    per_period.iter().zip(ready).map(|(h, q)| h / q).collect()
}

/// 1 / (k + 2)!, of as many k as there are digits at x = 1/2.
const SERIES: [f64; 13] = {
    let mut series = [0.5; 13];
    let mut k = 1;
    while k < series.len() {
        series[k] = series[k - 1] / (k + 2) as f64;
        k += 1;
    }
    series
};

/// (x - 1 + exp(-x)) / x^2, whose difference cancels where x is small, of x = rate width for each of some rates.
fn seconds(rates: &[f64], width: f64) -> Vec<f64> {
    let mut seconds: Vec<f64> = rates.iter().map(|rate| rate * width).collect();
    InstructionSet::best().run(&mut OfSmall(&mut seconds));
    for (second, x) in seconds.iter_mut().zip(rates.iter().map(|rate| rate * width)) {
        if x >= 0.5 {
            *second = (x + (-x).exp_m1()) / (x * x);
        }
    }
    seconds
}

/// Numbers to be replaced by their series.
struct OfSmall<'a>(&'a mut [f64]);

impl Runner for OfSmall<'_> {
    #[inline(always)]
    fn run(&mut self) {
        for x in &mut *self.0 {
            let mut sum = 0.0;
            for term in SERIES.iter().rev() {
                sum = term - *x * sum;
            }
            *x = sum;
        }
    }
}

/// n' = -rate n + inflow over part of a bin.
#[derive(Debug, Clone, Copy)]
struct Decay {
    stays: f64,
    /// Integral of exp(-rate t) over the width, and that integrated once more.
    once: f64,
    twice: f64,
}

impl Decay {
    #[inline(always)]
    fn new(rate: f64, width: f64, second: f64) -> Decay {
        let once = width * (1.0 - rate * width * second);
        Decay { stays: 1.0 - rate * once, once, twice: width * width * second }
    }
}

/// P(v - u < x) for independent u and v, anywhere in 0..1.
fn triangular(x: f64) -> f64 {
    if x < 0.0 { 0.5 * (1.0 + x).max(0.0).powi(2) } else { 1.0 - 0.5 * (1.0 - x).max(0.0).powi(2) }
}
