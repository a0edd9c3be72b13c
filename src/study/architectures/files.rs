//! The comparison as a figure and a table.

use std::fmt::Write as _;

use super::{Comparison, Point, Way};
use crate::files::{FileError, OutputFolder};
use crate::report::chart::{self, Axis, Chart, ChartError, Legend, Mark, Panel, Scale, Series};
use crate::scene::EstimatorKind;

/// Colour of the Pareto front: the last, black.
const FRONT_COLOUR: usize = 6;

/// Why a comparison could not be written.
#[derive(Debug, thiserror::Error)]
pub enum FilesError {
    /// The figure could not be drawn.
    #[error(transparent)]
    Plot(#[from] ChartError),
    /// A file could not be written.
    #[error(transparent)]
    File(#[from] FileError),
}

impl Comparison {
    /// Writes `architectures.svg` and `architectures.csv`; gives their names.
    ///
    /// # Errors
    /// When a file cannot be written, or the figure not be drawn.
    pub fn write_files(&self, folder: &OutputFolder) -> Result<Vec<&'static str>, FilesError> {
        let files = [("architectures.svg", self.chart().svg()?), ("architectures.csv", self.csv())];
        let mut written = Vec::new();
        for (name, text) in files {
            folder.write(name, &text)?;
            written.push(name);
        }
        Ok(written)
    }

    fn chart(&self) -> Chart {
        let panel = |label: &str, series| Panel {
            x: axis("measuring time (ms)"),
            y: axis(label),
            series,
            legend: Legend::UpperRight,
            headroom: 0.9,
        };
        let mut errors = self.series(EstimatorKind::Model, &|point| point.rms_error_m);
        errors.insert(0, self.front());
        Chart {
            title: format!(
                "{}: {:.2} million detections per second, each in one sensor or another",
                self.scene,
                self.detected_rate_cps / 1e6
            ),
            panels: vec![
                panel(
                    "standard deviation of the phase (mm)",
                    self.series(EstimatorKind::Fft, &|point| point.std_m),
                ),
                panel(
                    "error of the phase, bias included (mm)",
                    self.series(EstimatorKind::Fft, &|point| point.rms_error_m),
                ),
                panel("error of the model fit (mm); line: Pareto front of both", errors),
            ],
        }
    }

    fn series(&self, estimator: EstimatorKind, value: &dyn Fn(&Point) -> f64) -> Vec<Series> {
        let series = |(colour, way): (usize, &Way)| Series {
            label: way.name.to_owned(),
            mark: Mark::LineAndDots,
            colour,
            points: way
                .points
                .iter()
                .filter(|point| point.estimator == estimator)
                .map(|point| chart::Point::new(point.measuring_time_s * 1e3, value(point) * 1e3))
                .collect(),
        };
        let all = self.ways.iter().enumerate().map(series);
        all.filter(|series| !series.points.is_empty()).collect()
    }

    fn front(&self) -> Series {
        let on_front = self.ways.iter().flat_map(|way| way.points.iter().filter(|p| p.pareto));
        let mut points: Vec<chart::Point> = on_front
            .map(|p| chart::Point::new(p.measuring_time_s * 1e3, p.rms_error_m * 1e3))
            .collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        Series { label: "Pareto front".to_owned(), mark: Mark::Line, colour: FRONT_COLOUR, points }
    }

    fn csv(&self) -> String {
        let mut text = "sensor,estimator,measuring_time_s,frame_rate_hz,bias_m,std_m,rms_error_m,\
                        coarse_failure_bound_fraction,pareto,phase_steps,parallel,luts,flip_flops,\
                        memory_bits\n"
            .to_owned();
        for way in &self.ways {
            let cells = way.resources.as_ref().map(|resources| resources.cells);
            for p in &way.points {
                let _ = writeln!(
                    text,
                    "\"{}\",{},{},{},{},{},{},{},{},{},{},{},{},{}",
                    way.name,
                    p.estimator,
                    p.measuring_time_s,
                    p.frame_rate_hz,
                    p.bias_m,
                    p.std_m,
                    p.rms_error_m,
                    p.coarse_failure_bound_fraction.map_or(String::new(), |f| f.to_string()),
                    p.pareto,
                    way.phase_steps,
                    way.parallel,
                    cells.map_or(String::new(), |cells| cells.luts.to_string()),
                    cells.map_or(String::new(), |cells| cells.flip_flops.to_string()),
                    way.memory_bits,
                );
            }
        }
        text
    }
}

fn axis(label: &str) -> Axis {
    Axis { label: label.to_owned(), scale: Scale::Log }
}
