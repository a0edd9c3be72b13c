//! Plots of lines and points, in the page's colours.

use maud::{Markup, html};

use super::chart::Scale;
use super::coordinate::Coordinate;
use super::figure::{Figure, coordinate, label, points};

const WIDTH: f64 = 480.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 10.0;
const BOTTOM: f64 = 44.0;
/// Height of a line of the legend.
const LEGEND_LINE: f64 = 19.0;
/// Width of a character of a label, at most.
const CHARACTER: f64 = 8.0;
/// Ticks of an axis, at most.
const TICKS: usize = 6;

/// A plot with one horizontal and one vertical axis.
pub(super) struct LinePlot {
    /// Unique on the page.
    pub id: String,
    /// What it is.
    pub title: String,
    /// What it shows, in words.
    pub description: String,
    /// Label and scale of the horizontal axis.
    pub x: (&'static str, Scale),
    /// Of the vertical one.
    pub y: (&'static str, Scale),
    /// What is drawn.
    pub series: Vec<Series>,
    /// Vertical lines: where, and what they mark.
    pub marks: Vec<(f64, &'static str)>,
}

/// Points of one kind.
pub(super) struct Series {
    /// In the legend; without one where it is empty.
    pub name: &'static str,
    /// Class of its colour: `s0` to `s3`.
    pub class: &'static str,
    /// The points, in order of x.
    pub points: Vec<(f64, f64)>,
    /// Whether a line joins them.
    pub line: bool,
    /// Whether each is a dot.
    pub dots: bool,
}

/// Classes of marks, in turn.
const MARKS: [&str; 3] = ["m0", "m1", "m2"];

impl LinePlot {
    /// Draws it.
    pub fn figure(&self) -> Figure {
        let legend = self.legend();
        let height = HEIGHT + LEGEND_LINE * legend.len().div_ceil(2) as f64;
        let all = || self.series.iter().flat_map(|series| &series.points);
        let xs = all().map(|p| p.0).chain(self.marks.iter().map(|mark| mark.0));
        let x =
            Axis { axis: Coordinate::of(self.x.1, [0.02; 2], xs), from: LEFT, to: WIDTH - RIGHT };
        let y = Axis {
            axis: Coordinate::of(self.y.1, [0.06; 2], all().map(|p| p.1)),
            from: HEIGHT - BOTTOM,
            to: TOP,
        };
        Figure {
            id: self.id.clone(),
            title: self.title.clone(),
            description: self.description.clone(),
            size: (WIDTH, height),
            wide: false,
            content: html! {
                (self.grid(&x, &y))
                @for (number, (at, _)) in self.marks.iter().enumerate() {
                    line class={ "mark " (MARKS[number % MARKS.len()]) } x1=(coordinate(x.place(*at)))
                        x2=(coordinate(x.place(*at))) y1=(coordinate(y.to)) y2=(coordinate(y.from)) {}
                }
                @for series in &self.series { (series.drawn(&x, &y)) }
                @for (number, (class, name, shown)) in legend.iter().enumerate() {
                    (legend_entry(number, class, name, *shown))
                }
            },
        }
    }

    fn legend(&self) -> Vec<(&'static str, &'static str, Shown)> {
        let series = self.series.iter().filter(|series| !series.name.is_empty());
        let series = series.map(|series| {
            (series.class, series.name, if series.line { Shown::Line } else { Shown::Dot })
        });
        let marks = self.marks.iter().enumerate();
        let marks =
            marks.map(|(number, (_, name))| (MARKS[number % MARKS.len()], *name, Shown::Mark));
        series.chain(marks).collect()
    }

    fn grid(&self, x: &Axis, y: &Axis) -> Markup {
        html! {
            @for tick in x.axis.ticks(TICKS) {
                @let at = x.place(tick);
                line class="grid" x1=(coordinate(at)) x2=(coordinate(at)) y1=(coordinate(y.to))
                    y2=(coordinate(y.from)) {}
                @let shown = x.axis.shown(tick);
                (label(within(at, &shown), y.from + 16.0, "middle", &shown))
            }
            @for tick in y.axis.ticks(TICKS) {
                @let at = y.place(tick);
                line class="grid" x1=(coordinate(x.from)) x2=(coordinate(x.to)) y1=(coordinate(at))
                    y2=(coordinate(at)) {}
                (label(x.from - 6.0, at + 4.0, "end", &y.axis.shown(tick)))
            }
            (label((x.from + x.to) / 2.0, HEIGHT - 8.0, "middle strong", self.x.0))
            g transform={ "translate(13 " (coordinate((y.from + y.to) / 2.0)) ") rotate(-90)" } {
                (label(0.0, 0.0, "middle strong", self.y.0))
            }
        }
    }
}

/// An axis on the page.
struct Axis {
    axis: Coordinate,
    from: f64,
    to: f64,
}

impl Axis {
    fn place(&self, value: f64) -> f64 {
        self.from + self.axis.share(value) * (self.to - self.from)
    }
}

impl Series {
    fn drawn(&self, x: &Axis, y: &Axis) -> Markup {
        let shown = self.points.iter().filter(|p| x.axis.holds(p.0) && y.axis.holds(p.1));
        let places: Vec<(f64, f64)> = shown.map(|p| (x.place(p.0), y.place(p.1))).collect();
        html! {
            @if self.line {
                polyline class={ "curve " (self.class) } points=(points(places.iter().copied())) {}
            }
            @if self.dots {
                @for (x, y) in &places {
                    circle class={ "dot " (self.class) } cx=(coordinate(*x)) cy=(coordinate(*y)) r="3" {}
                }
            }
        }
    }
}

/// Where the middle of a label stands that is to be as near to `at` as the drawing has room.
fn within(at: f64, text: &str) -> f64 {
    let half = text.chars().count() as f64 * CHARACTER / 2.0;
    at.clamp(half, (WIDTH - half).max(half))
}

/// How something looks in the legend.
#[derive(Debug, Clone, Copy)]
enum Shown {
    Line,
    Dot,
    Mark,
}

fn legend_entry(number: usize, class: &str, name: &str, shown: Shown) -> Markup {
    let x = LEFT + (number % 2) as f64 * (WIDTH - LEFT) / 2.0;
    let y = HEIGHT + LEGEND_LINE * (number / 2) as f64 + 8.0;
    let line = match shown {
        Shown::Line => Some("curve"),
        Shown::Mark => Some("mark"),
        Shown::Dot => None,
    };
    html! {
        @if let Some(line) = line {
            line class={ (line) " " (class) } x1=(coordinate(x)) x2=(coordinate(x + 20.0))
                y1=(coordinate(y - 4.0)) y2=(coordinate(y - 4.0)) {}
        } @else {
            circle class={ "dot " (class) } cx=(coordinate(x + 10.0)) cy=(coordinate(y - 4.0)) r="4" {}
        }
        (label(x + 26.0, y, "start", name))
    }
}

/// At most four points per column of a plot: the first, lowest, highest and last of
/// those that fall into it, so that no peak is lost.
pub(super) fn decimate(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let columns = (WIDTH - LEFT - RIGHT) as usize;
    if points.len() <= 4 * columns {
        return points.to_vec();
    }
    let per_column = points.len().div_ceil(columns);
    let mut kept = Vec::with_capacity(4 * columns);
    for column in points.chunks(per_column) {
        let by_value = |a: &usize, b: &usize| column[*a].1.total_cmp(&column[*b].1);
        let mut indices = vec![0, column.len() - 1];
        indices.extend((0..column.len()).min_by(by_value));
        indices.extend((0..column.len()).max_by(by_value));
        indices.sort_unstable();
        indices.dedup();
        kept.extend(indices.into_iter().map(|i| column[i]));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decimation_keeps_a_peak_of_one_point() {
        let mut points: Vec<_> = (0..16_376).map(|i| (f64::from(i), 0.0)).collect();
        points[7_777].1 = 100.0;
        points[9_000].1 = -50.0;
        let kept = decimate(&points);
        assert!(kept.len() <= 4 * WIDTH as usize);
        assert!(kept.contains(&(7_777.0, 100.0)));
        assert!(kept.contains(&(9_000.0, -50.0)));
    }

    #[test]
    fn labels_of_ticks_stay_in_the_drawing() {
        for (at, text) in [(LEFT, "0"), (WIDTH - RIGHT, "2500"), (WIDTH, "1000000")] {
            let middle = within(at, text);
            let half = text.len() as f64 * CHARACTER / 2.0;
            assert!(middle - half >= 0.0 && middle + half <= WIDTH, "{text}");
        }
        assert_eq!(within(200.0, "2500"), 200.0);
    }

    #[test]
    fn a_plot_of_one_point_is_still_a_plot() {
        let plot = LinePlot {
            id: "one".to_owned(),
            title: "a < b & \"c\"".to_owned(),
            description: String::new(),
            x: ("x", Scale::Linear),
            y: ("y", Scale::Log),
            series: vec![Series {
                name: "",
                class: "s0",
                points: vec![(1.0, 2.0), (2.0, f64::NAN)],
                line: true,
                dots: true,
            }],
            marks: vec![(1.0, "here")],
        };
        let svg = plot.figure().markup().into_string();
        assert!(svg.contains("a &lt; b &amp;") && !svg.contains("a < b"), "{svg}");
        assert!(!svg.contains("NaN") && svg.contains("<circle"), "{svg}");
    }
}
