//! Charts of several series: linear or logarithmic axes, error bars, legends.

use plotters::coord::Shift;
use plotters::prelude::*;

use super::coordinate::Coordinate;
pub use super::coordinate::Scale;

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
        Point { x, y, interval: None }
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
        self.draw(&mut text)
            .map_err(|error| ChartError { title: self.title.clone(), reason: error.to_string() })?;
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
            series.draw(&mut chart, &x, &y)?;
        }
        // A legend without a name would be an empty box.
        if self.series.iter().all(|series| series.label.is_empty()) {
            return Ok(());
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

type Plot<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<Coordinate, Coordinate>>;

impl Series {
    fn draw<'a, 'b: 'a>(
        &self,
        chart: &mut Plot<'a, 'b>,
        x: &Coordinate,
        y: &Coordinate,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let colour = COLOURS[self.colour % COLOURS.len()];
        let shown: Vec<&Point> =
            self.points.iter().filter(|p| x.holds(p.x) && y.holds(p.y)).collect();
        let (line, dots) = match self.mark {
            Mark::Line => (true, false),
            Mark::Dots => (false, true),
            Mark::LineAndDots => (true, true),
            Mark::Rings => (false, false),
        };
        let rings = self.mark == Mark::Rings;
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
        let half_cap = if shown.len() <= MOST_CAPPED { CAP / 2 } else { 0 };
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
        if self.label.is_empty() {
            return Ok(());
        }
        drawn.label(&self.label).legend(move |(x, y)| {
            let half = if line { 8 } else { 0 };
            let ring = if rings { RING } else { 0 };
            EmptyElement::at((x + 8, y))
                + PathElement::new([(-half, 0), (half, 0)], colour.stroke_width(2))
                + Circle::new((0, 0), if dots { DOT } else { 0 }, colour.filled())
                + Circle::new((0, 0), ring, colour.stroke_width(1))
        });
        Ok(())
    }
}
