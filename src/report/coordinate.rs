//! Axes of charts: where a value stands, and which ticks there are.

/// How values are spread over an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisScale {
    /// Evenly.
    Linear,
    /// By their logarithm; what is not positive is not drawn.
    Log,
}

/// An axis; its range is that of the data.
#[derive(Debug, Clone)]
pub struct ChartAxis {
    /// The column of a table that it shows.
    pub column: String,
    /// What it shows, and in brackets the unit, into which the column's is converted.
    pub label: String,
    /// How values are spread.
    pub scale: AxisScale,
}

impl ChartAxis {
    /// An axis that is divided evenly.
    pub fn linear(column: impl Into<String>, label: impl Into<String>) -> ChartAxis {
        ChartAxis { column: column.into(), label: label.into(), scale: AxisScale::Linear }
    }

    /// An axis that is divided by ratios, which shows sizes without sign.
    pub fn log(column: impl Into<String>, label: impl Into<String>) -> ChartAxis {
        ChartAxis { scale: AxisScale::Log, ..ChartAxis::linear(column, label) }
    }
}

/// A point, with an interval where its value is uncertain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChartPoint {
    /// Where it stands.
    pub x: f64,
    /// Its value.
    pub y: f64,
    /// Lower and upper end of the error bar.
    pub interval: Option<(f64, f64)>,
}

/// Where values stand along an axis, which has ticks at 1, 2 or 5 times a power of ten.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coordinate {
    scale: AxisScale,
    low: f64,
    high: f64,
}

impl Coordinate {
    /// The range of `values`, and `margin` times as much below and above.
    pub fn of(scale: AxisScale, margin: f64, values: impl Iterator<Item = f64>) -> Coordinate {
        let drawn = values.filter(|&v| v.is_finite() && (scale == AxisScale::Linear || v > 0.0));
        let (low, high) = drawn
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low > high { (1.0, 1.0) } else { (low, high) };
        let (from, to) = (place(scale, low), place(scale, high));
        // A single value still needs an axis round it.
        let extra = if to > from { (to - from) * margin } else { 0.5 };
        Coordinate { scale, low: value(scale, from - extra), high: value(scale, to + extra) }
    }

    pub fn holds(&self, v: f64) -> bool {
        v.is_finite() && (self.scale == AxisScale::Linear || v > 0.0)
    }

    pub fn clamp(&self, v: f64) -> f64 {
        v.clamp(self.low, self.high)
    }

    /// Ticks, at most about so many.
    pub fn ticks(&self, most: usize) -> Vec<f64> {
        match self.scale {
            AxisScale::Linear => self.linear_ticks(most),
            AxisScale::Log => self.log_ticks(most),
        }
    }

    /// Where a value stands, from 0 at the lower end to 1 at the upper.
    pub fn share(&self, v: f64) -> f64 {
        let [low, high, at] = [self.low, self.high, v].map(|v| place(self.scale, v));
        (at - low) / (high - low)
    }

    /// A tick's text.
    pub fn shown(&self, tick: f64) -> String {
        // Ticks have one significant digit beyond their step: drop what rounding
        // left behind.
        let rounded: f64 = format!("{tick:.6e}").parse().unwrap_or(tick);
        rounded.to_string().replace('-', "\u{2212}")
    }

    /// Ticks of a step of 1, 2 or 5 times a power of ten, at most `most`.
    fn linear_ticks(&self, most: usize) -> Vec<f64> {
        let least = (self.high - self.low) / most.max(1) as f64;
        let decade = 10f64.powf(least.log10().floor());
        let factor = [1.0, 2.0, 5.0, 10.0]
            .into_iter()
            .find(|factor| factor * decade >= least)
            .unwrap_or(10.0);
        let step = factor * decade;
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        (first..=last).map(|tick| tick as f64 * step).collect()
    }

    /// 1, 2 and 5 times each power of ten, or fewer of them where decades are
    /// many.
    fn log_ticks(&self, most: usize) -> Vec<f64> {
        let (first, last) = (self.low.log10().floor(), self.high.log10().ceil());
        let factors: &[f64] =
            if 3.0 * (last - first) <= most as f64 + 4.0 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        (first as i32..=last as i32)
            .flat_map(|decade| factors.iter().map(move |f| f * 10f64.powi(decade)))
            .filter(|&tick| tick >= self.low && tick <= self.high)
            .collect()
    }
}

fn place(scale: AxisScale, value: f64) -> f64 {
    match scale {
        AxisScale::Linear => value,
        AxisScale::Log => value.log10(),
    }
}

fn value(scale: AxisScale, place: f64) -> f64 {
    match scale {
        AxisScale::Linear => place,
        AxisScale::Log => 10f64.powf(place),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinate(scale: AxisScale, low: f64, high: f64) -> Coordinate {
        Coordinate { scale, low, high }
    }

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let linear = coordinate(AxisScale::Linear, -0.3, 1.05);
        assert_eq!(linear.linear_ticks(5), [0.0, 0.5, 1.0]);
        let log = coordinate(AxisScale::Log, 0.4, 30.0);
        assert_eq!(log.log_ticks(10), [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(linear.shown(0.1 + 0.2), "0.3");
    }

    #[test]
    fn a_decade_has_the_same_width_everywhere_on_a_log_axis() {
        let log = coordinate(AxisScale::Log, 0.1, 100.0);
        let at = [0.1, 1.0, 10.0, 100.0].map(|v| (300.0 * log.share(v)).round());
        assert_eq!(at, [0.0, 100.0, 200.0, 300.0]);
    }

    #[test]
    fn values_without_logarithm_and_lone_values_still_give_an_axis() {
        let log = Coordinate::of(AxisScale::Log, 0.0, [0.0, -1.0, 10.0].into_iter());
        assert!(log.low < 10.0 && log.high > 10.0 && !log.holds(0.0));
        let empty = Coordinate::of(AxisScale::Linear, 0.0, std::iter::empty());
        assert!(empty.low < empty.high);
    }
}
