//! Bias and standard deviation over the first axis, a series for each value of the
//! others and each path.

use super::axis::Axis;
use super::table::Table;
use crate::report::chart::{Axis as ChartAxis, Chart, ChartError, Legend, Mark, Panel};
use crate::report::chart::{Point, Scale, Series};

/// Most series: there are no more colours that people tell apart.
const MOST_SERIES: usize = 7;

impl Table {
    /// The plot, and how many series it has no room for.
    ///
    /// # Errors
    /// When the drawing library gives up.
    pub fn plot(&self, title: &str, axes: &[Axis]) -> Result<(String, usize), ChartError> {
        let series = self.series_names(axes);
        let left_out = series.len().saturating_sub(MOST_SERIES);
        let shown = &series[..series.len() - left_out];
        let x = ChartAxis {
            label: axes.first().map_or_else(String::new, Axis::column),
            scale: match axes.first().is_some_and(|axis| axis.by_ratio) {
                true => Scale::Log,
                false => Scale::Linear,
            },
        };
        let panel = |label: &str, [value, error, expected]: [&str; 3]| Panel {
            x: x.clone(),
            y: ChartAxis { label: label.to_owned(), scale: Scale::Linear },
            series: shown
                .iter()
                .enumerate()
                .flat_map(|(colour, name)| {
                    [
                        Series {
                            label: String::new(),
                            mark: Mark::Line,
                            colour,
                            points: self.points(axes, name, expected, None),
                        },
                        Series {
                            label: name.clone(),
                            mark: Mark::Dots,
                            colour,
                            points: self.points(axes, name, value, Some(error)),
                        },
                    ]
                })
                .collect(),
            legend: Legend::UpperRight,
            headroom: 0.3,
        };
        let bias = ["bias_m", "bias_std_error_m", "expected_bias_m"];
        let std = ["std_m", "std_std_error_m", "expected_std_m"];
        let chart = Chart {
            title: format!("{title} (dots: simulated, with 95 % intervals; lines: expected)"),
            panels: vec![panel("bias (mm)", bias), panel("standard deviation (mm)", std)],
        };
        Ok((chart.svg()?, left_out))
    }

    /// What a row's series is called: the values of all axes but the first, and
    /// detector and path.
    fn series_name(&self, axes: &[Axis], row: &[String]) -> String {
        let others =
            (1..axes.len()).map(|i| format!("{} {}", self.columns[i + 1].name, row[i + 1]));
        let place = |name: &str| self.place(name).map_or("", |at| row[at].as_str());
        let path = format!("{}, path {}", place("detector"), place("path"));
        others.chain([path]).collect::<Vec<_>>().join(", ")
    }

    /// The series, in the order of the table.
    fn series_names(&self, axes: &[Axis]) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        let ranged = self.rows.iter().filter(|row| !self.is_refused(row));
        for name in ranged.map(|row| self.series_name(axes, row)) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    fn is_refused(&self, row: &[String]) -> bool {
        self.place("detector").is_none_or(|at| row[at].is_empty())
    }

    /// The points of a series, in millimetres; values that are no numbers stand side by
    /// side.
    fn points(&self, axes: &[Axis], name: &str, column: &str, error: Option<&str>) -> Vec<Point> {
        let number =
            |row: &[String], column: &str| -> Option<f64> { row[self.place(column)?].parse().ok() };
        let rows = self.rows.iter().filter(|row| !self.is_refused(row));
        let own = rows.filter(|row| self.series_name(axes, row) == name);
        let point = |row: &Vec<String>| {
            let axis = axes.first()?;
            let x = match axis.unit() {
                Some(_) => row[1].parse().ok()?,
                None => axis.values.iter().position(|value| value.text == row[1])? as f64,
            };
            let y = 1e3 * number(row, column)?;
            let error = error.and_then(|error| number(row, error));
            let half = error.map(|error| 1e3 * crate::math::NORMAL_95 * error);
            Some(Point { x, y, interval: half.map(|half| (y - half, y + half)) })
        };
        let mut points: Vec<Point> = own.filter_map(point).collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        points
    }
}
