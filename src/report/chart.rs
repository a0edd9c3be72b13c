//! Charts: curves, dots and error bars over one pair of axes, on the report's page or side by
//! side in a drawing of their own.

pub use super::coordinate::{AxisScale, ChartAxis, ChartPoint};
use super::prelude::*;
pub use super::role::DrawingRole;
use super::role::{OF_A_KIND, colours};
use super::table::Table;

const LEFT: f64 = 62.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 10.0;
const BOTTOM: f64 = 44.0;
/// Height of a line of the legend.
const LEGEND_LINE: f64 = 19.0;
/// Width of a tick's character, at most, and of a legend's, on average.
const CHARACTER: f64 = 8.0;
const LEGEND_CHARACTER: f64 = 7.4;
/// Height of a drawing's title.
const TITLE: f64 = 30.0;
/// On a logarithmic axis the lower part of a bar is drawn at least down to this
/// share of its point, and further as far as the axis goes.
const SHORTEST_BAR_SHOWN: f64 = 0.3;
/// Marks that are nearer to one another than this are one.
const LEAST_BETWEEN_MARKS: f64 = 3.0;
/// A curve that is nearer to another than this, in most of its points, is dashed: both are seen.
const COVERED: f64 = 1.5;
const COVERED_SHARE: f64 = 0.5;
/// Panels side by side in a drawing.
const PANELS_IN_ROW: usize = 2;
/// Points of a series that tell their values, at most.
const MOST_TOLD: usize = 200;
/// Half the width of a bar's caps: wider than a dot, so that a bar shorter than the dot is
/// seen. In a series of more points caps would run into one another.
const HALF_CAP: f64 = 6.0;
const MOST_CAPPED: usize = 40;

/// Room for a panel, without its legend, and the most ticks of an axis.
struct Room {
    width: f64,
    height: f64,
    ticks: usize,
}

/// On the report's page, and in a drawing of its own.
const OF_PAGE: Room = Room { width: 480.0, height: 300.0, ticks: 6 };
const OF_DRAWING: Room = Room { width: 620.0, height: 410.0, ticks: 10 };

/// One or more panels, side by side.
#[derive(Debug, Clone)]
pub struct Chart {
    /// Title above all panels.
    pub title: String,
    /// The panels, from left to right.
    pub panels: Vec<Panel>,
}

/// One pair of axes with its series; their legend is below.
#[derive(Debug, Clone)]
pub struct Panel {
    x: ChartAxis,
    y: ChartAxis,
    /// What is drawn, the first at the back.
    series: Vec<Series>,
    /// Names of the curves, and what they mean.
    names: Vec<(String, DrawingRole)>,
    /// Vertical lines: where, what they mark, and its meaning.
    marks: Vec<(f64, &'static str, DrawingRole)>,
}

/// Points of one kind.
#[derive(Debug, Clone)]
struct Series {
    /// Name in the legend, where those of one name stand once; an empty one is not there.
    label: String,
    mark: Mark,
    role: DrawingRole,
    /// The points, in order of x.
    points: Vec<ChartPoint>,
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
    /// The area between the ends of the points' intervals.
    Band,
}

impl Mark {
    fn has_line(self) -> bool {
        matches!(self, Mark::Line | Mark::LineAndDots)
    }

    fn has_dots(self) -> bool {
        matches!(self, Mark::Dots | Mark::LineAndDots)
    }
}

impl Panel {
    /// A panel without series.
    pub fn new(x: ChartAxis, y: ChartAxis) -> Panel {
        Panel { x, y, series: Vec::new(), names: Vec::new(), marks: Vec::new() }
    }

    /// Adds a curve for each name in the first column of a table, over the columns of both
    /// axes; those of one name have one colour.
    pub fn curves(self, table: &Table, mark: Mark) -> Panel {
        let column = self.y.column.clone();
        self.curves_of(table, &column, mark)
    }

    /// The same of another column.
    pub fn curves_of(mut self, table: &Table, column: &str, mark: Mark) -> Panel {
        for name in table.names() {
            let mut points = table.points(&name, &self.x, (column, &self.y));
            if mark == Mark::Rings {
                // The dots that they are round have the bars.
                points.iter_mut().for_each(|point| point.interval = None);
            }
            let role = match (mark, self.names.iter().find(|(known, _)| *known == name)) {
                (Mark::Rings, _) => DrawingRole::Truth,
                (_, Some((_, role))) => *role,
                (_, None) => {
                    let role = self.free_role(&name);
                    self.names.push((name.clone(), role));
                    role
                }
            };
            self.series.push(Series { label: name, mark, role, points });
        }
        self
    }

    /// What a curve of a table means by its name, or else one of a kind; of those that no curve has.
    fn free_role(&self, name: &str) -> DrawingRole {
        let is_free = |role: &DrawingRole| {
            self.names.iter().all(|(_, other)| other.colour() != role.colour())
        };
        let of_a_kind = || (0..OF_A_KIND.len()).map(DrawingRole::Other).find(is_free);
        let role = DrawingRole::named(name).filter(is_free).or_else(of_a_kind);
        role.unwrap_or(DrawingRole::Other(self.names.len()))
    }

    /// Adds points of one kind.
    pub fn with(
        self,
        label: &str,
        role: DrawingRole,
        mark: Mark,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Panel {
        let points = points.into_iter().map(|(x, y)| ChartPoint { x, y, interval: None });
        self.with_points(label, role, mark, points.collect())
    }

    /// The same of points that have intervals.
    pub fn with_points(
        mut self,
        label: &str,
        role: DrawingRole,
        mark: Mark,
        points: Vec<ChartPoint>,
    ) -> Panel {
        self.series.push(Series { label: label.to_owned(), mark, role, points });
        self
    }

    /// Adds a level line over the range of the series so far.
    pub fn level(self, label: &str, y: f64) -> Panel {
        let places = || self.series.iter().flat_map(|s| &s.points).map(|point| point.x);
        let ends =
            [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)];
        self.with(label, DrawingRole::Truth, Mark::Line, ends.map(|x| (x, y)))
    }

    /// Adds level lines at plus and minus a limit.
    pub fn limits(self, limit: f64, unit: &str) -> Panel {
        let label = format!("±{limit} {unit}");
        self.level(&label, limit).level(&label, -limit)
    }

    /// Adds vertical lines: where, what they mark, and its meaning.
    pub fn marked(self, marks: Vec<(f64, &'static str, DrawingRole)>) -> Panel {
        Panel { marks, ..self }
    }

    /// On the report's page; `id` is unique there.
    pub(super) fn figure(&self, id: String, title: String, description: String) -> SvgFigure {
        let (height, content) = self.drawn(&OF_PAGE);
        SvgFigure { id, title, description, size: (OF_PAGE.width, height), wide: false, content }
    }

    /// Its height with the legend, and its shapes.
    fn drawn(&self, room: &Room) -> (f64, Markup) {
        let all = || self.series.iter().flat_map(|series| &series.points);
        let xs = all().map(|p| p.x).chain(self.marks.iter().map(|mark| mark.0));
        let ends = |p: &ChartPoint| {
            let (low, high) = p.interval.unwrap_or((p.y, p.y));
            // A bar that reaches towards zero must not stretch the axis over
            // decades without data.
            let low = match self.y.scale {
                AxisScale::Linear => low,
                AxisScale::Log => low.max(p.y * SHORTEST_BAR_SHOWN),
            };
            [low, p.y, high]
        };
        let x = Along {
            axis: Coordinate::of(self.x.scale, 0.02, xs),
            from: LEFT,
            to: room.width - RIGHT,
        };
        let y = Along {
            axis: Coordinate::of(self.y.scale, 0.06, all().flat_map(ends)),
            from: room.height - BOTTOM,
            to: TOP,
        };
        let marks = self.marks(&x);
        let dashed = self.covering(&x, &y);
        let legend = self.legend(&marks, &dashed);
        let widest = legend.iter().map(|entry| entry.name.chars().count()).max().unwrap_or(0);
        let half = (room.width - LEFT) / 2.0;
        let columns = if widest as f64 * LEGEND_CHARACTER + 26.0 <= half { 2 } else { 1 };
        let height = room.height + LEGEND_LINE * legend.len().div_ceil(columns) as f64;
        let content = html! {
            (self.grid(room, &x, &y))
            @for series in self.series.iter().filter(|series| series.mark == Mark::Band) {
                (series.band(&x, &y))
            }
            @for (at, _, role) in &marks {
                line class={ "mark " (role.class()) } x1=(coordinate(*at))
                    x2=(coordinate(*at)) y1=(coordinate(y.to)) y2=(coordinate(y.from)) {}
            }
            @for (series, is_dashed) in self.series.iter().zip(&dashed) {
                (series.drawn(&x, &y, [&self.x, &self.y], *is_dashed))
            }
            @for (number, entry) in legend.iter().enumerate() {
                (entry.drawn(
                    LEFT + (number % columns) as f64 * half,
                    room.height + LEGEND_LINE * (number / columns) as f64 + 8.0,
                ))
            }
        };
        (height, content)
    }

    /// Places of vertical lines, names and meaning; of those that would be one to the eye the names are
    /// together.
    fn marks(&self, x: &Along) -> Vec<(f64, String, DrawingRole)> {
        let mut marks: Vec<(f64, String, DrawingRole)> = Vec::new();
        for (at, name, role) in &self.marks {
            let at = x.place(*at);
            match marks.iter_mut().find(|mark| (mark.0 - at).abs() < LEAST_BETWEEN_MARKS) {
                Some(mark) => mark.1 += &format!(", {name}"),
                None => marks.push((at, (*name).to_owned(), *role)),
            }
        }
        marks
    }

    /// Whether each series is a line that hides one before it.
    fn covering(&self, x: &Along, y: &Along) -> Vec<bool> {
        let places = |series: &Series| series.places(x, y).1;
        let lines: Vec<Option<Vec<(f64, f64)>>> =
            self.series.iter().map(|s| s.mark.has_line().then(|| places(s))).collect();
        let hides = |number: usize| {
            let Some(line) = &lines[number] else { return false };
            let before = lines[..number].iter().flatten();
            before.into_iter().any(|other| {
                let near = line.iter().filter(|(x, y)| {
                    height_at(other, *x).is_some_and(|height| (height - y).abs() < COVERED)
                });
                near.count() as f64 > COVERED_SHARE * line.len() as f64
            })
        };
        (0..lines.len()).map(hides).collect()
    }

    fn legend<'p>(
        &'p self,
        marks: &'p [(f64, String, DrawingRole)],
        dashed: &[bool],
    ) -> Vec<Entry<'p>> {
        let mut entries: Vec<Entry> = Vec::new();
        // A band is of the line within it, which is named.
        let is_shown = |series: &&Series| {
            series.mark != Mark::Band && !series.label.is_empty() && !series.points.is_empty()
        };
        let dashed_of = self.series.iter().zip(dashed);
        for (series, is_dashed) in dashed_of.filter(|(series, _)| is_shown(series)) {
            let shown = match series.mark {
                mark if mark.has_line() => Shown::Line,
                Mark::Rings => Shown::Ring,
                _ => Shown::Dot,
            };
            let dashes = if *is_dashed { " dashed" } else { "" };
            let class = series.role.class() + dashes;
            match entries.iter_mut().find(|entry| entry.name == series.label) {
                Some(entry) if entry.shown != shown => entry.shown = Shown::LineAndDot,
                Some(_) => {}
                None => entries.push(Entry { class, name: &series.label, shown }),
            }
        }
        entries.extend(marks.iter().map(|(_, name, role)| Entry {
            class: role.class(),
            name,
            shown: Shown::Mark,
        }));
        entries
    }

    fn grid(&self, room: &Room, x: &Along, y: &Along) -> Markup {
        html! {
            @for tick in x.axis.ticks(room.ticks) {
                @let at = x.place(tick);
                line class="grid" x1=(coordinate(at)) x2=(coordinate(at)) y1=(coordinate(y.to))
                    y2=(coordinate(y.from)) {}
                @let shown = x.axis.shown(tick);
                (label(within(room.width, at, &shown), y.from + 16.0, "middle", &shown))
            }
            @for tick in y.axis.ticks(room.ticks) {
                @let at = y.place(tick);
                line class="grid" x1=(coordinate(x.from)) x2=(coordinate(x.to)) y1=(coordinate(at))
                    y2=(coordinate(at)) {}
                (label(x.from - 6.0, at + 4.0, "end", &y.axis.shown(tick)))
            }
            (label((x.from + x.to) / 2.0, room.height - 8.0, "middle strong", &self.x.label))
            g transform={ "translate(13 " (coordinate((y.from + y.to) / 2.0)) ") rotate(-90)" } {
                (label(0.0, 0.0, "middle strong", &self.y.label))
            }
        }
    }
}

/// An axis on the drawing.
struct Along {
    axis: Coordinate,
    from: f64,
    to: f64,
}

impl Along {
    fn place(&self, value: f64) -> f64 {
        self.from + self.axis.share(value) * (self.to - self.from)
    }
}

impl Series {
    /// The points that can be drawn, and where.
    fn places(&self, x: &Along, y: &Along) -> (Vec<&ChartPoint>, Vec<(f64, f64)>) {
        let holds = |p: &&ChartPoint| x.axis.holds(p.x) && y.axis.holds(p.y);
        let shown: Vec<&ChartPoint> = self.points.iter().filter(holds).collect();
        let places = shown.iter().map(|p| (x.place(p.x), y.place(p.y))).collect();
        (shown, places)
    }

    /// The area between the ends of its intervals.
    fn band(&self, x: &Along, y: &Along) -> Markup {
        let (shown, _) = self.places(x, y);
        let edge = |of: fn((f64, f64)) -> f64| {
            let ends = shown.iter().filter_map(move |point| Some((point.x, of(point.interval?))));
            ends.map(|(at, end)| (x.place(at), y.place(y.axis.clamp(end)))).collect::<Vec<_>>()
        };
        let back = edge(|interval| interval.0).into_iter().rev();
        let outline = edge(|interval| interval.1).into_iter().chain(back);
        html! { polygon class={ "band " (self.role.class()) } points=(points(outline)) {} }
    }

    fn drawn(
        &self,
        x_along: &Along,
        y_along: &Along,
        axes: [&ChartAxis; 2],
        is_dashed: bool,
    ) -> Markup {
        let (x, y) = (x_along, y_along);
        if self.mark == Mark::Band {
            return html! {};
        }
        let (shown, places) = self.places(x, y);
        let cap = if shown.len() <= MOST_CAPPED { HALF_CAP } else { 0.0 };
        let bars = shown.iter().zip(&places).filter_map(|(point, (x, _))| {
            let (low, high) = point.interval?;
            Some(bar(*x, [low, high].map(|end| y.place(y.axis.clamp(end))), cap))
        });
        let class = self.role.class();
        let dashes = if is_dashed { " dashed" } else { "" };
        let tells = shown.len() <= MOST_TOLD;
        html! {
            @if self.mark.has_line() {
                polyline class={ "curve " (class) (dashes) } points=(points(places.iter().copied())) {}
            }
            @if self.mark.has_dots() {
                @for (point, (x, y)) in shown.iter().zip(&places) {
                    circle class={ "dot " (class) } cx=(coordinate(*x)) cy=(coordinate(*y)) r="3" {
                        @if tells { title { (self.told(point, [(axes[0], x_along), (axes[1], y_along)])) } }
                    }
                }
            }
            @if self.mark == Mark::Rings {
                @for (x, y) in &places {
                    circle class={ "bar " (class) } cx=(coordinate(*x)) cy=(coordinate(*y)) r="7" {}
                }
            }
            @for bar in bars { path class={ "bar " (class) } d=(bar) {} }
        }
    }

    /// What a point is, in words: shown where one points at it.
    fn told(&self, point: &ChartPoint, [x, y]: [(&ChartAxis, &Along); 2]) -> String {
        let name = if self.label.is_empty() { "" } else { ": " };
        let shown = |(axis, along): (&ChartAxis, &Along), value: f64| {
            format!("{} {}", axis.label, along.axis.shown(value))
        };
        let mut told = format!("{}{name}{}, {}", self.label, shown(x, point.x), shown(y, point.y));
        if let Some((low, high)) = point.interval {
            told += &format!(" ({} to {})", y.1.axis.shown(low), y.1.axis.shown(high));
        }
        told
    }
}

/// Height of a line at `x`; none beside its ends.
fn height_at(line: &[(f64, f64)], x: f64) -> Option<f64> {
    let after = line.partition_point(|point| point.0 < x);
    let (&(x1, y1), before) = (line.get(after)?, after.checked_sub(1));
    match before.map(|before| line[before]) {
        None => (x1 - x < COVERED).then_some(y1),
        Some((x0, y0)) => Some(y0 + (y1 - y0) * (x - x0) / (x1 - x0).max(f64::MIN_POSITIVE)),
    }
}

/// An error bar with caps at both ends.
fn bar(x: f64, ends: [f64; 2], cap: f64) -> String {
    let [low, high] = ends.map(coordinate);
    let (left, width) = (coordinate(x - cap), coordinate(2.0 * cap));
    format!("M{},{low} V{high} M{left},{low} h{width} M{left},{high} h{width}", coordinate(x))
}

/// Where the middle of a label stands that is to be as near to `at` as the drawing has room.
fn within(width: f64, at: f64, text: &str) -> f64 {
    let half = text.chars().count() as f64 * CHARACTER / 2.0;
    at.clamp(half, (width - half).max(half))
}

/// A line of the legend.
struct Entry<'a> {
    class: String,
    name: &'a str,
    shown: Shown,
}

/// How something looks in the legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shown {
    Line,
    Dot,
    LineAndDot,
    Ring,
    Mark,
}

impl Entry<'_> {
    fn drawn(&self, x: f64, y: f64) -> Markup {
        let class = &self.class;
        let line = match self.shown {
            Shown::Line | Shown::LineAndDot => Some("curve"),
            Shown::Mark => Some("mark"),
            Shown::Dot | Shown::Ring => None,
        };
        let (dot, radius) = match self.shown {
            Shown::Ring => ("bar", "6"),
            _ => ("dot", "4"),
        };
        html! {
            @if let Some(line) = line {
                line class={ (line) " " (class) } x1=(coordinate(x)) x2=(coordinate(x + 20.0))
                    y1=(coordinate(y - 4.0)) y2=(coordinate(y - 4.0)) {}
            }
            @if line.is_none() || self.shown == Shown::LineAndDot {
                circle class={ (dot) " " (class) } cx=(coordinate(x + 10.0)) cy=(coordinate(y - 4.0)) r=(radius) {}
            }
            (label(x + 26.0, y, "start", self.name))
        }
    }
}

impl Chart {
    /// Draws it.
    pub fn svg(&self) -> String {
        let drawn: Vec<(f64, Markup)> =
            self.panels.iter().map(|panel| panel.drawn(&OF_DRAWING)).collect();
        let columns = drawn.len().clamp(1, PANELS_IN_ROW);
        let rows: Vec<&[(f64, Markup)]> = drawn.chunks(columns).collect();
        // Where each row begins, and the drawing ends.
        let mut tops = vec![TITLE];
        for row in &rows {
            tops.push(tops[tops.len() - 1] + row.iter().map(|panel| panel.0).fold(0.0, f64::max));
        }
        let height = tops[rows.len()];
        let width = OF_DRAWING.width * columns as f64;
        let [wide, high] = [width, height].map(coordinate);
        let svg = html! {
            svg xmlns="http://www.w3.org/2000/svg" width=(wide) height=(high)
                viewBox={ "0 0 " (wide) " " (high) } {
                style { (style()) }
                rect width="100%" height="100%" fill="#ffffff" {}
                (label(width / 2.0, 20.0, "middle title", &self.title))
                @for (row, top) in rows.iter().zip(&tops) {
                    @for (number, (_, content)) in row.iter().enumerate() {
                        g transform={
                            "translate(" (coordinate(number as f64 * OF_DRAWING.width)) " " (coordinate(*top)) ")"
                        } { (content) }
                    }
                }
            }
        };
        svg.into_string() + "\n"
    }
}

/// The looks of a drawing that stands alone: those of the report's page are in its own style.
fn style() -> String {
    "text{font-family:sans-serif;font-size:13px}.title{font-size:16px}.middle{text-anchor:middle}\
     .end{text-anchor:end}.grid{stroke:#dedede}.curve{fill:none;stroke-width:2}\
     .bar{fill:none;stroke-width:1}.mark{stroke-width:1.6}.mark,.dashed{stroke-dasharray:6 4}\
     .band{opacity:.25}"
        .to_owned()
        + &colours(false)
}

/// At most four points per column of a plot on the page: the first, lowest, highest and last
/// of those that fall into it, so that no peak is lost.
pub(super) fn decimate(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let columns = (OF_PAGE.width - LEFT - RIGHT) as usize;
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
    fn of_two_curves_in_one_place_the_second_is_dashed() {
        let line = |by: f64| (0..9).map(move |x| (f64::from(x), f64::from(x * x) + by));
        let panel = |by| {
            Panel::new(ChartAxis::linear("", "x"), ChartAxis::linear("", "y"))
                .with("one", DrawingRole::Counts, Mark::Line, line(0.0))
                .with("other", DrawingRole::Fit, Mark::Line, line(by))
        };
        for (by, is_dashed) in [(0.0, true), (0.1, true), (10.0, false)] {
            let drawn = panel(by).drawn(&OF_PAGE).1.into_string();
            // The curve, and its line of the legend.
            assert_eq!(drawn.matches("dashed").count(), 2 * usize::from(is_dashed), "{by}");
        }
    }

    #[test]
    fn marks_that_are_one_to_the_eye_have_one_name() {
        let panel = Panel::new(ChartAxis::linear("", "x"), ChartAxis::linear("", "y"))
            .with("", DrawingRole::Counts, Mark::Line, [(0.0, 0.0), (100.0, 1.0)])
            .marked(vec![
                (50.0, "truth", DrawingRole::Truth),
                (50.1, "phase", DrawingRole::Phase),
                (60.0, "fit", DrawingRole::Fit),
            ]);
        let drawn = panel.drawn(&OF_PAGE).1.into_string();
        assert!(drawn.contains(">truth, phase<") && drawn.contains(">fit<"), "{drawn}");
    }

    #[test]
    fn decimation_keeps_a_peak_of_one_point() {
        let mut points: Vec<_> = (0..16_376).map(|i| (f64::from(i), 0.0)).collect();
        points[7_777].1 = 100.0;
        points[9_000].1 = -50.0;
        let kept = decimate(&points);
        assert!(kept.len() <= 4 * OF_PAGE.width as usize);
        assert!(kept.contains(&(7_777.0, 100.0)));
        assert!(kept.contains(&(9_000.0, -50.0)));
    }

    #[test]
    fn labels_of_ticks_stay_in_the_drawing() {
        for (at, text) in [(LEFT, "0"), (468.0, "2500"), (480.0, "1000000")] {
            let middle = within(480.0, at, text);
            let half = text.len() as f64 * CHARACTER / 2.0;
            assert!(middle - half >= 0.0 && middle + half <= 480.0, "{text}");
        }
        assert_eq!(within(480.0, 200.0, "2500"), 200.0);
    }

    #[test]
    fn a_plot_of_one_point_is_still_a_plot() {
        let panel = Panel::new(ChartAxis::linear("", "x"), ChartAxis::log("", "y < 1"))
            .with("", DrawingRole::Counts, Mark::LineAndDots, [(1.0, 2.0), (2.0, f64::NAN)])
            .marked(vec![(1.0, "here", DrawingRole::Truth)]);
        let chart = Chart { title: "a < b & \"c\"".to_owned(), panels: vec![panel.clone()] };
        let figure = panel.figure("one".to_owned(), chart.title.clone(), String::new());
        for svg in [figure.markup().into_string(), chart.svg()] {
            assert!(svg.contains("a &lt; b &amp;") && !svg.contains("a < b"), "{svg}");
            assert!(!svg.contains("NaN") && svg.contains("<circle"), "{svg}");
            assert!(svg.contains("y &lt; 1") && roxmltree::Document::parse(&chart.svg()).is_ok());
        }
    }

    #[test]
    fn bars_have_caps_and_stay_on_the_axis() {
        assert_eq!(bar(10.0, [20.0, 5.5], 6.0), "M10,20 V5.5 M4,20 h12 M4,5.5 h12");
        let point = ChartPoint { x: 1.0, y: 10.0, interval: Some((0.0, 20.0)) };
        let mut panel = Panel::new(ChartAxis::linear("", "x"), ChartAxis::log("", "y"));
        let (mark, label) = (Mark::Dots, String::new());
        panel.series.push(Series { label, mark, role: DrawingRole::Counts, points: vec![point] });
        let (_, drawn) = panel.drawn(&OF_PAGE);
        // Down to the frame, not to the zero that has no logarithm.
        assert!(drawn.into_string().contains(&format!(",{} V", coordinate(300.0 - BOTTOM))));
    }
}
