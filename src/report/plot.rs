//! Plots as SVG text.

use plotters::prelude::*;

/// Size of a plot in CSS pixels.
const SIZE: (u32, u32) = (860, 320);

/// A line plot of counts over a distance axis.
pub struct CountPlot<'a> {
    /// Title above the plot.
    pub title: &'a str,
    /// (distance in metres, count), in order of distance.
    pub points: &'a [(f64, f64)],
    /// Vertical lines: distance in metres, label.
    pub markers: &'a [(f64, String)],
    /// Draw every point as a dot.
    pub dots: bool,
}

/// The plot could not be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw the plot {title:?}: {reason}")]
pub struct PlotError {
    title: String,
    reason: String,
}

impl CountPlot<'_> {
    /// Draws it.
    ///
    /// # Errors
    /// When the drawing library gives up.
    pub fn svg(&self) -> Result<String, PlotError> {
        let mut text = String::new();
        self.draw(&mut text).map_err(|error| PlotError {
            title: self.title.to_owned(),
            reason: error.to_string(),
        })?;
        Ok(text)
    }

    fn draw(&self, text: &mut String) -> Result<(), Box<dyn std::error::Error + '_>> {
        let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let (x, y) = (self.x_range(), self.y_range());
        let mut chart = ChartBuilder::on(&root)
            .caption(self.title, ("sans-serif", 16))
            .margin(10)
            .x_label_area_size(40)
            .y_label_area_size(70)
            .build_cartesian_2d(x, y.clone())?;
        chart
            .configure_mesh()
            .x_desc("distance (m)")
            .y_desc("count")
            .light_line_style(BLACK.mix(0.05))
            .bold_line_style(BLACK.mix(0.15))
            .draw()?;
        chart.draw_series(LineSeries::new(
            decimate(self.points, SIZE.0 as usize),
            &RGBColor(31, 93, 153),
        ))?;
        if self.dots {
            let dot = |&(x, y): &(f64, f64)| Circle::new((x, y), 2, RGBColor(31, 93, 153).filled());
            chart.draw_series(self.points.iter().map(dot))?;
        }
        for (i, (distance, label)) in self.markers.iter().enumerate() {
            let colour = [RGBColor(190, 60, 40), RGBColor(60, 130, 60)][i % 2];
            chart
                .draw_series(LineSeries::new(
                    [(*distance, y.start), (*distance, y.end)],
                    colour.stroke_width(2 - i as u32 % 2),
                ))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour));
        }
        if !self.markers.is_empty() {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperRight)
                .background_style(WHITE.mix(0.85))
                .border_style(BLACK.mix(0.3))
                .draw()?;
        }
        root.present()?;
        drop(chart);
        Ok(())
    }

    fn x_range(&self) -> std::ops::Range<f64> {
        let first = self.points.first().map_or(0.0, |p| p.0);
        let last = self.points.last().map_or(1.0, |p| p.0);
        if last > first {
            first..last
        } else {
            first - 0.5..first + 0.5
        }
    }

    fn y_range(&self) -> std::ops::Range<f64> {
        let low = self.points.iter().map(|p| p.1).fold(0.0, f64::min);
        let high = self.points.iter().map(|p| p.1).fold(0.0, f64::max);
        let margin = ((high - low) * 0.05).max(1.0);
        low - margin..high + margin
    }
}

/// At most four points per pixel column: the first, lowest, highest and last of
/// those that fall into it, so that no peak is lost.
fn decimate(points: &[(f64, f64)], columns: usize) -> Vec<(f64, f64)> {
    if points.len() <= 4 * columns {
        return points.to_vec();
    }
    let per_column = points.len().div_ceil(columns);
    let mut kept = Vec::with_capacity(4 * columns);
    for column in points.chunks(per_column) {
        let by_count = |a: &usize, b: &usize| column[*a].1.total_cmp(&column[*b].1);
        let mut indices = vec![0, column.len() - 1];
        indices.extend((0..column.len()).min_by(by_count));
        indices.extend((0..column.len()).max_by(by_count));
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
        let kept = decimate(&points, 860);
        assert!(kept.len() <= 4 * 860);
        assert!(kept.contains(&(7_777.0, 100.0)));
        assert!(kept.contains(&(9_000.0, -50.0)));
    }

    #[test]
    fn a_plot_of_one_point_is_still_a_plot() {
        let plot = CountPlot {
            title: "one",
            points: &[(1.0, 2.0)],
            markers: &[(1.0, "here".to_owned())],
            dots: true,
        };
        assert!(plot.svg().is_ok_and(|svg| svg.ends_with("</svg>\n")));
    }
}
