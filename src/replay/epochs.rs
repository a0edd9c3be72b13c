//! Where a recording is in the code: epochs that were recorded, and a clock of one's own between them.

use serde::Serialize;

use crate::scan::Sampler;

/// Epochs that are fitted by one straight line: long enough to average their jitter, short enough to
/// follow a clock that drifts.
pub(super) const EPOCHS_OF_A_LINE: usize = 4096;
/// A mark farther from a whole period than this share of one is not an epoch.
const FARTHEST: f64 = 0.25;
/// More missing epochs than these are a pause of the recording.
const MOST_MISSING: u64 = 64;
/// The clock of the recording is within this share of the scene's.
pub(super) const MOST_OFFSET: f64 = 2e-3;

/// Doubles from here to its double are whole numbers: adding it rounds to one, and the sum's lowest bits are that
/// number.
const WHOLE: f64 = (1_u64 << 52) as f64;

/// What the epochs of a recording say of it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, schemars::JsonSchema)]
pub struct Epochs {
    /// Marks that are epochs.
    pub epochs: u64,
    /// Epochs that are missing between two marks.
    pub missing: u64,
    /// Marks that are none, too near to another one or anywhere.
    pub stray: u64,
    /// Pauses: more missing epochs than would be told from them.
    pub pauses: u64,
    /// Code periods between the first and the last epoch, pauses left out.
    pub periods: u64,
    /// By how much the recorded code period is longer than the scene's.
    pub period_error_fraction: f64,
    /// Scatter of the marks about straight lines, root mean square.
    pub jitter_std_s: f64,
}

/// Photons whose places are found together.
pub(super) const TOGETHER: usize = 256;

/// What samples show of some photons.
pub(super) struct Sampled {
    /// The first sample that is taken at a photon's time or later, from the line's first epoch on.
    pub since_line: [u64; TOGETHER],
    /// The same from the photon's own epoch on.
    pub of_epoch: [u64; TOGETHER],
    /// Samples that its pulse is high for.
    pub high: [u64; TOGETHER],
}

impl Default for Sampled {
    fn default() -> Sampled {
        Sampled { since_line: [0; TOGETHER], of_epoch: [0; TOGETHER], high: [0; TOGETHER] }
    }
}

/// A straight stretch of the recording: what its ticks are in code periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EpochLine {
    /// Ticks at its first epoch, as recorded.
    origin: u64,
    /// The line's own beginning, in ticks from there.
    offset: f64,
    /// Periods of an epoch in a tick.
    per_tick: f64,
    /// Number of its first epoch since the recording's, pauses left out.
    first: u64,
    /// First and last of its epochs, in ticks.
    pub from: u64,
    pub until: u64,
    /// Whether it begins behind a pause, or the recording.
    pub begins: bool,
}

impl EpochLine {
    /// Number of its first epoch since the recording's first, pauses left out.
    pub fn first(&self) -> u64 {
        self.first
    }

    /// Where a time is, in epochs' periods since the line's first epoch.
    #[inline]
    pub fn place(&self, ticks: u64) -> f64 {
        let since = (ticks as i64 - self.origin as i64) as f64 - self.offset;
        since * self.per_tick
    }

    /// Where samples show photons whose pulses are `pulse` samples wide. What is earlier than the line, or
    /// later, gets any place.
    #[inline(always)]
    pub fn sample(
        &self,
        photons: &[u64],
        samples_of_epoch: u64,
        sampler: &Sampler,
        pulse: f64,
        sampled: &mut Sampled,
    ) {
        let span = (self.until - self.origin) as f64;
        let most = span.max((span * self.per_tick + 2.0) * samples_of_epoch as f64 + pulse);
        if sampler.is_even() && most < WHOLE {
            return self.sample_in_loops(photons, samples_of_epoch as f64, pulse, sampled);
        }
        for (k, &ticks) in photons.iter().enumerate() {
            // The line's own jitter may put its first photon before its first epoch.
            let more = self.place(ticks.min(self.until)).max(0.0);
            let whole = more as u64;
            let within = (more - whole as f64) * samples_of_epoch as f64;
            let of_epoch = sampler.first_from(within);
            sampled.since_line[k] = whole * samples_of_epoch + of_epoch;
            sampled.of_epoch[k] = of_epoch;
            sampled.high[k] = sampler.first_from(within + pulse) - of_epoch;
        }
    }

    /// The same of samples that are equally far apart, in loops without branches and conversions, of which a
    /// compiler makes vectors, and short ones, so that it does not wait: the numbers are those of [`EpochLine::place`] and [`Sampler::first_from`] to the last bit.
    #[inline(always)]
    fn sample_in_loops(&self, photons: &[u64], of_epoch: f64, pulse: f64, sampled: &mut Sampled) {
        const BITS: u64 = (1 << 52) - 1;
        let nearest = |number: f64| (number + WHOLE) - WHOLE;
        let whole_of = |number: f64| (number + WHOLE).to_bits() & BITS;
        let floor = |number: f64| nearest(number) - f64::from(u8::from(nearest(number) > number));
        let ceil = |number: f64| nearest(number) + f64::from(u8::from(nearest(number) < number));
        let (mut bases, mut places) = ([0.0; TOGETHER], [0.0; TOGETHER]);
        for ((ticks, base), place) in photons.iter().zip(&mut bases).zip(&mut places) {
            let since = ticks.wrapping_sub(self.origin) & BITS;
            let since = f64::from_bits(since | WHOLE.to_bits()) - WHOLE - self.offset;
            let more = (since * self.per_tick).max(0.0);
            *base = floor(more) * of_epoch;
            *place = (more - floor(more)) * of_epoch;
        }
        let Sampled { since_line, of_epoch, high } = sampled;
        for ((place, of_epoch), high) in places.iter_mut().zip(of_epoch).zip(high) {
            let first = ceil(*place);
            *of_epoch = whole_of(first);
            *high = whole_of(ceil(*place + pulse) - first);
            *place = first;
        }
        for ((base, first), since_line) in bases.iter().zip(&places).zip(since_line) {
            *since_line = whole_of(base + first);
        }
    }
}

/// Takes marks in order and makes lines of them.
#[derive(Debug)]
pub(super) struct EpochClock {
    /// Ticks of an epoch's period by the scene, and as found so far.
    nominal: f64,
    period: f64,
    tick_s: f64,
    /// Ticks, and number since the line's first.
    line: Vec<(u64, u64)>,
    first: u64,
    begins: bool,
    found: Epochs,
    squares: f64,
    fitted: u64,
    /// Of all lines, without pauses.
    ticks: f64,
}

impl EpochClock {
    /// For epochs that are `nominal` ticks apart, of `tick_s` each.
    pub fn new(nominal: f64, tick_s: f64) -> EpochClock {
        EpochClock {
            nominal,
            period: nominal,
            tick_s,
            line: Vec::new(),
            first: 0,
            begins: true,
            found: Epochs::default(),
            squares: 0.0,
            fitted: 0,
            ticks: 0.0,
        }
    }

    /// Takes a mark; gives a line that ends with it, or with the one before.
    pub fn mark(&mut self, ticks: u64) -> Option<EpochLine> {
        let Some(&(last, number)) = self.line.last() else {
            self.line.push((ticks, 0));
            self.found.epochs += 1;
            return None;
        };
        let periods = ticks.saturating_sub(last) as f64 / self.period;
        let whole = periods.round();
        // The first ones may be farther off than a period that was found: a share of all that passed.
        let allowed = FARTHEST.min(0.02 + MOST_OFFSET * whole + self.jitter_share());
        if whole < 1.0 || (periods - whole).abs() > allowed.max(0.05) {
            self.found.stray += 1;
            return None;
        }
        let whole = whole as u64;
        if whole > MOST_MISSING {
            let line = self.end();
            self.found.pauses += 1;
            self.found.epochs += 1;
            self.begins = true;
            self.line.push((ticks, 0));
            return line;
        }
        self.found.missing += whole - 1;
        self.found.epochs += 1;
        self.line.push((ticks, number + whole));
        if self.line.len() <= EPOCHS_OF_A_LINE {
            return None;
        }
        let line = self.end();
        // The next line begins where this one ends.
        self.line.push((ticks, 0));
        line
    }

    /// Scatter of the marks, in periods, so far.
    fn jitter_share(&self) -> f64 {
        let std = (self.squares / self.fitted.max(1) as f64).sqrt();
        6.0 * std / self.period
    }

    /// The line of what has come, by least squares; none of a single epoch.
    pub fn end(&mut self) -> Option<EpochLine> {
        let marks = std::mem::take(&mut self.line);
        let begins = std::mem::replace(&mut self.begins, false);
        let (&(origin, _), &(until, periods)) = marks.first().zip(marks.last())?;
        if marks.len() < 2 {
            self.begins = begins;
            return None;
        }
        let n = marks.len() as f64;
        let at = |ticks: u64| (ticks - origin) as f64;
        let (mean_k, mean_t) = marks
            .iter()
            .fold((0.0, 0.0), |(k, t), mark| (k + mark.1 as f64 / n, t + at(mark.0) / n));
        let (kk, kt) = marks.iter().fold((0.0, 0.0), |(kk, kt), mark| {
            let k = mark.1 as f64 - mean_k;
            (kk + k * k, kt + k * (at(mark.0) - mean_t))
        });
        let period = kt / kk;
        let offset = mean_t - period * mean_k;
        let residual = |mark: &(u64, u64)| at(mark.0) - offset - period * mark.1 as f64;
        if marks.len() > 2 {
            self.squares += marks.iter().map(|mark| residual(mark).powi(2)).sum::<f64>();
            self.fitted += marks.len() as u64 - 2;
        }
        self.period = period;
        self.ticks += period * periods as f64;
        let first = self.first;
        self.first += periods;
        self.found.periods += periods;
        let per_tick = 1.0 / period;
        Some(EpochLine { origin, offset, per_tick, first, from: origin, until, begins })
    }

    /// What was found; `periods` are code periods of an epoch.
    pub fn found(&self, code_periods: u64) -> Epochs {
        let periods = self.found.periods.max(1) as f64;
        Epochs {
            periods: self.found.periods * code_periods,
            period_error_fraction: match self.found.periods {
                0 => 0.0,
                _ => self.ticks / periods / self.nominal - 1.0,
            },
            jitter_std_s: (self.squares / self.fitted.max(1) as f64).sqrt() * self.tick_s,
            ..self.found
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scan::Sample;

    /// Quick places are those of plain arithmetic, at borders of samples and epochs, too.
    #[test]
    fn equal_samples_are_found_to_the_last_bit() {
        let (origin, until) = (1 << 50, (1 << 50) + 4_000_000_000);
        for (offset, period, epoch, pulse) in [
            (0.0, 16_000.0, 16_000, 7.0),
            (-3.25, 16_376_000.4, 16_376, 0.4),
            (2.5, 999.9, 248, 20.5),
        ] {
            let per_tick = 1.0 / period;
            let line =
                EpochLine { origin, offset, per_tick, first: 5, from: origin, until, begins: true };
            let mut random = 1_u64;
            let photons: Vec<u64> = (0..TOGETHER as u64)
                .map(|k| {
                    random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                    let places =
                        [k, k * 1000, k * period as u64, (random >> 33) % (until - origin)];
                    origin + places[(k % 4) as usize]
                })
                .collect();
            let mut sampled = Sampled::default();
            line.sample(&photons, epoch, &Sampler::default(), pulse, &mut sampled);
            for (k, &ticks) in photons.iter().enumerate() {
                let more = line.place(ticks).max(0.0);
                let within = (more - more.floor()) * epoch as f64;
                let first = Sample(more.floor() as u64 * epoch + within.ceil() as u64);
                assert_eq!(Sample(sampled.since_line[k]), first, "{ticks}");
                assert_eq!(sampled.of_epoch[k], within.ceil() as u64, "{ticks}");
                let high = (within + pulse).ceil() - within.ceil();
                assert_eq!(sampled.high[k], high as u64, "{ticks}");
            }
        }
    }

    /// Epochs of 100,000.25 ticks with jitter of +-3 ticks, of which some are missing, one comes twice
    /// and there is a pause: every place is found again within the jitter's average.
    #[test]
    fn lines_follow_epochs_over_gaps_and_pauses() {
        let (period, nominal) = (100_000.25, 100_000.0);
        let mut clock = EpochClock::new(nominal, 1e-12);
        let mut lines = Vec::new();
        let mut random = 1_u64;
        let mut jitter = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (random >> 33) as f64 / f64::from(1_u32 << 31) * 6.0 - 3.0
        };
        let of = |number: f64| 7_000.0 + number * period;
        for number in (0..20_000_u64).filter(|number| number % 97 != 5) {
            let number = if number < 10_000 { number } else { number + 1_000_000 };
            let ticks = (of(number as f64) + jitter()).round() as u64;
            lines.extend(clock.mark(ticks));
            if number == 300 {
                lines.extend(clock.mark(ticks + 40_000));
            }
        }
        lines.extend(clock.end());
        let found = clock.found(1);
        assert_eq!((found.stray, found.pauses), (1, 1));
        assert_eq!(found.epochs + found.missing, 20_000);
        assert_eq!(found.periods, 9_999 + 9_999);
        assert!((found.period_error_fraction / 2.5e-6 - 1.0).abs() < 0.01, "{found:?}");
        // Even from -3 to 3, and rounded: the root of (36 + 1) / 12.
        assert!((found.jitter_std_s * 1e12 - (37.0_f64 / 12.0).sqrt()).abs() < 0.1, "{found:?}");
        assert_eq!(lines.iter().filter(|line| line.begins).count(), 2);
        for number in [0.5, 4_500.25, 9_000.75] {
            let ticks = of(number).round() as u64;
            let line = lines.iter().find(|line| (line.from..line.until).contains(&ticks)).unwrap();
            let place = line.first() as f64 + line.place(ticks);
            assert!((place - number).abs() < 1e-5, "{number}: {place}");
        }
    }
}
