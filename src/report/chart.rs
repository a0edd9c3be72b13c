//! Charts of several series: linear or logarithmic axes, error bars, legends.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::prelude::*;

/// Size of one panel in CSS pixels.
const PANEL: (u32, u32) = (620, 440);

/// Colours that people with any colour vision tell apart (Okabe and Ito).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(150, 110, 0),
    RGBColor(0, 0, 0),
];

/// On a logarithmic axis the lower part of a bar is drawn at least down to this
/// share of its point, and further as far as the axis goes.
const SHORTEST_BAR_SHOWN: f64 = 0.3;

/// Radius of a dot, in CSS pixels.
const DOT: i32 = 3;
/// Radius of a ring.
const RING: i32 = 7;
/// Width of the caps of an error bar: wider than a dot, so that a bar shorter than
/// the dot is seen.
const CAP: i32 = 12;
/// In a series of more points caps would run into one another.
const MOST_CAPPED: usize = 40;

/// One or more panels, side by side.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Title above all panels.
    pub title: String,
    /// The panels, from left to right.
    pub panels: Vec<Panel>,
}

/// One pair of axes with its series.
#[derive(Debug, Clone)]
pub struct Panel {
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// What is drawn, the first at the back.
    pub series: Vec<Series>,
    /// Where the legend stands.
    pub legend: Legend,
    /// Free space above the data, as a share of their height: for a legend that
    /// would hide some.
    pub headroom: f64,
}

/// Corner of the legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Legend {
    /// Upper left corner.
    UpperLeft,
    /// Upper right corner.
    UpperRight,
    /// Lower left corner.
    LowerLeft,
}

/// An axis; its range is that of the data.
#[derive(Debug, Clone)]
pub struct Axis {
    /// What it shows, and the unit.
    pub label: String,
    /// How values are spread.
    pub scale: Scale,
}

/// How values are spread over an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scale {
    /// Evenly.
    Linear,
    /// By their logarithm; what is not positive is not drawn.
    Log,
}

/// Points of one kind.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend; an empty one is not there.
    pub label: String,
    /// How the points are drawn.
    pub mark: Mark,
    /// Number of its colour; those of one number look alike.
    pub colour: usize,
    /// The points, in order of x.
    pub points: Vec<Point>,
}

/// How points are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// A line from point to point.
    Line,
    /// Dots.
    Dots,
    /// Both.
    LineAndDots,
    /// Wide rings, round the dots of another series.
    Rings,
}

/// A point, with an interval where its value is uncertain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Where it stands.
    pub x: f64,
    /// Its value.
    pub y: f64,
    /// Lower and upper end of the error bar.
    pub interval: Option<(f64, f64)>,
}

impl Point {
    /// A point without error bar.
    pub fn new(x: f64, y: f64) -> Point {
        Point {
            x,
            y,
            interval: None,
        }
    }
}

/// The chart could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the chart {title:?}: {reason}")]
pub struct ChartError {
    title: String,
    reason: String,
}

impl Chart {
    /// Draws it.
    ///
    /// # Errors
    /// When the drawing library gives up.
    pub fn svg(&self) -> Result<String, ChartError> {
        let mut text = String::new();
        self.draw(&mut text).map_err(|error| ChartError {
            title: self.title.clone(),
            reason: error.to_string(),
        })?;
        Ok(text)
    }

    fn draw(&self, text: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let columns = self.panels.len().max(1);
        let size = (PANEL.0 * columns as u32, PANEL.1 + 30);
        let root = SVGBackend::with_string(text, size).into_drawing_area();
        root.fill(&WHITE)?;
        let body = root.titled(&self.title, ("sans-serif", 17))?;
        for (area, panel) in body.split_evenly((1, columns)).iter().zip(&self.panels) {
            panel.draw(area)?;
        }
        root.present()?;
        Ok(())
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Panel {
    fn draw(&self, area: &Area<'_>) -> Result<(), Box<dyn std::error::Error>> {
        let points = || self.series.iter().flat_map(|series| &series.points);
        // A dot on the frame would be cut off.
        let has_dots = self.series.iter().any(|s| s.mark != Mark::Line);
        let beside = if has_dots { 0.04 } else { 0.02 };
        let x = Coordinate::of(self.x.scale, [beside; 2], points().map(|p| p.x));
        let ends = |p: &Point| {
            let (low, high) = p.interval.unwrap_or((p.y, p.y));
            // A bar that reaches towards zero must not stretch the axis over
            // decades without data.
            let low = match self.y.scale {
                Scale::Linear => low,
                Scale::Log => low.max(p.y * SHORTEST_BAR_SHOWN),
            };
            [low, p.y, high]
        };
        let y = Coordinate::of(self.y.scale, [0.06, self.headroom], points().flat_map(ends));
        let mut chart = ChartBuilder::on(area)
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(66)
            .build_cartesian_2d(x.clone(), y.clone())?;
        chart
            .configure_mesh()
            .x_desc(&self.x.label)
            .y_desc(&self.y.label)
            .axis_desc_style(("sans-serif", 15))
            .label_style(("sans-serif", 13))
            .light_line_style(TRANSPARENT)
            .bold_line_style(BLACK.mix(0.13))
            .draw()?;
        for series in self.series.iter().filter(|s| !s.points.is_empty()) {
            let colour = COLOURS[series.colour % COLOURS.len()];
            let shown: Vec<&Point> = series
                .points
                .iter()
                .filter(|p| x.holds(p.x) && y.holds(p.y))
                .collect();
            let (line, dots) = match series.mark {
                Mark::Line => (true, false),
                Mark::Dots => (false, true),
                Mark::LineAndDots => (true, true),
                Mark::Rings => (false, false),
            };
            let rings = series.mark == Mark::Rings;
            if rings {
                let ring = |p: &&Point| Circle::new((p.x, p.y), RING, colour.stroke_width(1));
                chart.draw_series(shown.iter().map(ring))?;
            }
            if line {
                let path = shown.iter().map(|p| (p.x, p.y));
                chart.draw_series(LineSeries::new(path, colour.stroke_width(2)))?;
            }
            if dots {
                let dot = |p: &&Point| Circle::new((p.x, p.y), DOT, colour.filled());
                chart.draw_series(shown.iter().map(dot))?;
            }
            let half_cap = if shown.len() <= MOST_CAPPED {
                CAP / 2
            } else {
                0
            };
            let caps = shown.iter().filter_map(|p| Some((p.x, p.interval?)));
            let caps = caps.flat_map(|(x, (low, high))| [(x, y.clamp(low)), (x, y.clamp(high))]);
            chart.draw_series(caps.map(|end| {
                let cap = vec![(-half_cap, 0), (half_cap, 0)];
                EmptyElement::at(end) + PathElement::new(cap, colour.stroke_width(1))
            }))?;
            let bars = shown.iter().filter_map(|p| {
                let (low, high) = p.interval?;
                let ends = vec![(p.x, y.clamp(low)), (p.x, y.clamp(high))];
                Some(PathElement::new(ends, colour.stroke_width(1)))
            });
            let drawn = chart.draw_series(bars)?;
            if series.label.is_empty() {
                continue;
            }
            drawn.label(&series.label).legend(move |(x, y)| {
                let half = if line { 8 } else { 0 };
                let ring = if rings { RING } else { 0 };
                EmptyElement::at((x + 8, y))
                    + PathElement::new([(-half, 0), (half, 0)], colour.stroke_width(2))
                    + Circle::new((0, 0), if dots { DOT } else { 0 }, colour.filled())
                    + Circle::new((0, 0), ring, colour.stroke_width(1))
            });
        }
        chart
            .configure_series_labels()
            .position(match self.legend {
                Legend::UpperLeft => SeriesLabelPosition::UpperLeft,
                Legend::UpperRight => SeriesLabelPosition::UpperRight,
                Legend::LowerLeft => SeriesLabelPosition::LowerLeft,
            })
            .label_font(("sans-serif", 13))
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.3))
            .draw()?;
        Ok(())
    }
}

/// An axis with ticks at 1, 2 or 5 times a power of ten.
#[derive(Debug, Clone, PartialEq)]
struct Coordinate {
    scale: Scale,
    low: f64,
    high: f64,
}

impl Coordinate {
    /// The range of `values`, and so many times as much below and above.
    fn of(scale: Scale, margins: [f64; 2], values: impl Iterator<Item = f64>) -> Coordinate {
        let drawn = values.filter(|&v| v.is_finite() && (scale == Scale::Linear || v > 0.0));
        let (low, high) = drawn.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        let (low, high) = if low > high { (1.0, 1.0) } else { (low, high) };
        let (from, to) = (place(scale, low), place(scale, high));
        // A single value still needs an axis round it.
        let extra = margins.map(|m| if to > from { (to - from) * m } else { 0.5 });
        Coordinate {
            scale,
            low: value(scale, from - extra[0]),
            high: value(scale, to + extra[1]),
        }
    }

    fn holds(&self, v: f64) -> bool {
        v.is_finite() && (self.scale == Scale::Linear || v > 0.0)
    }

    fn clamp(&self, v: f64) -> f64 {
        v.clamp(self.low, self.high)
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
        let factors: &[f64] = if 3.0 * (last - first) <= most as f64 + 4.0 {
            &[1.0, 2.0, 5.0]
        } else {
            &[1.0]
        };
        (first as i32..=last as i32)
            .flat_map(|decade| factors.iter().map(move |f| f * 10f64.powi(decade)))
            .filter(|&tick| tick >= self.low && tick <= self.high)
            .collect()
    }
}

fn place(scale: Scale, value: f64) -> f64 {
    match scale {
        Scale::Linear => value,
        Scale::Log => value.log10(),
    }
}

fn value(scale: Scale, place: f64) -> f64 {
    match scale {
        Scale::Linear => place,
        Scale::Log => 10f64.powf(place),
    }
}

impl Ranged for Coordinate {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, v: &f64, limit: (i32, i32)) -> i32 {
        let [low, high, at] = [self.low, self.high, *v].map(|v| place(self.scale, v));
        let share = (at - low) / (high - low);
        limit.0 + (share * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let most = hint.max_num_points().min(10);
        match self.scale {
            Scale::Linear => self.linear_ticks(most),
            Scale::Log => self.log_ticks(most),
        }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Coordinate {
    fn format_ext(&self, v: &f64) -> String {
        // Ticks have one significant digit beyond their step: drop what rounding
        // left behind.
        let rounded: f64 = format!("{v:.6e}").parse().unwrap_or(*v);
        rounded.to_string().replace('-', "\u{2212}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coordinate(scale: Scale, low: f64, high: f64) -> Coordinate {
        Coordinate { scale, low, high }
    }

    #[test]
    fn ticks_are_round_numbers_within_the_range() {
        let linear = coordinate(Scale::Linear, -0.3, 1.05);
        assert_eq!(linear.linear_ticks(5), [0.0, 0.5, 1.0]);
        let log = coordinate(Scale::Log, 0.4, 30.0);
        assert_eq!(log.log_ticks(10), [0.5, 1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(linear.format_ext(&(0.1 + 0.2)), "0.3");
    }

    #[test]
    fn a_decade_has_the_same_width_everywhere_on_a_log_axis() {
        let log = coordinate(Scale::Log, 0.1, 100.0);
        let at: Vec<i32> = [0.1, 1.0, 10.0, 100.0]
            .iter()
            .map(|v| log.map(v, (0, 300)))
            .collect();
        assert_eq!(at, [0, 100, 200, 300]);
    }

    #[test]
    fn values_without_logarithm_and_lone_values_still_give_an_axis() {
        let log = Coordinate::of(Scale::Log, [0.0; 2], [0.0, -1.0, 10.0].into_iter());
        assert!(log.low < 10.0 && log.high > 10.0 && !log.holds(0.0));
        let empty = Coordinate::of(Scale::Linear, [0.0; 2], std::iter::empty());
        assert!(empty.low < empty.high);
    }
}
