//! Where a recording is in the code: epochs that were recorded, and a clock of one's own between them.

use serde::Serialize;

/// Epochs that are fitted by one straight line: long enough to average their jitter, short enough to
/// follow a clock that drifts.
const EPOCHS_OF_A_LINE: usize = 4096;
/// A mark farther from a whole period than this share of one is no epoch.
const FARTHEST: f64 = 0.25;
/// More missing epochs than these are a pause of the recording.
const MOST_MISSING: u64 = 64;
/// The clock of the recording is within this share of the scene's.
pub(super) const MOST_OFFSET: f64 = 2e-3;

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

/// A straight stretch of the recording: what its ticks are in code periods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
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

impl Line {
    /// Number of its first epoch since the recording's first, pauses left out.
    pub fn first(&self) -> u64 {
        self.first
    }

    /// Where a time is, in epochs' periods since the first epoch: whole ones, and a share.
    #[inline]
    pub fn place(&self, ticks: u64) -> (u64, f64) {
        let since = (ticks as i64 - self.origin as i64) as f64 - self.offset;
        (self.first, since * self.per_tick)
    }
}

/// Takes marks in order and makes lines of them.
#[derive(Debug)]
pub(super) struct Clock {
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

impl Clock {
    /// For epochs that are `nominal` ticks apart, of `tick_s` each.
    pub fn new(nominal: f64, tick_s: f64) -> Clock {
        Clock {
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
    pub fn mark(&mut self, ticks: u64) -> Option<Line> {
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
    pub fn end(&mut self) -> Option<Line> {
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
        Some(Line { origin, offset, per_tick, first, from: origin, until, begins })
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

    /// Epochs of 100,000.25 ticks with jitter of +-3 ticks, of which some are missing, one comes twice
    /// and there is a pause: every place is found again within the jitter's average.
    #[test]
    fn lines_follow_epochs_over_gaps_and_pauses() {
        let (period, nominal) = (100_000.25, 100_000.0);
        let mut clock = Clock::new(nominal, 1e-12);
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
            let (first, more) = line.place(ticks);
            assert!((first as f64 + more - number).abs() < 1e-5, "{number}: {first} {more}");
        }
    }
}
