//! The comparison as a figure and a table.

use super::{Comparison, Point, Way};
use crate::files::{FileError, OutputFolder};
use crate::report::chart::{Axis, Chart, Mark, Panel, Role};
use crate::report::table::{Quoted, Table};
use crate::scene::EstimatorKind;

impl Comparison {
    /// Writes `architectures.svg` and `architectures.csv`; gives their names.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write_files(&self, folder: &OutputFolder) -> Result<Vec<&'static str>, FileError> {
        let table = self.table();
        let files =
            [("architectures.svg", self.chart(&table).svg()), ("architectures.csv", table.csv())];
        folder.write_all(files)
    }

    fn chart(&self, table: &Table) -> Chart {
        let panel = |column: &str, label: &str| {
            Panel::new(
                Axis::log("measuring_time_s", "measuring time (ms)"),
                Axis::log(column, label),
            )
        };
        let of = |kind: EstimatorKind| {
            let kind = kind.to_string();
            table.only(|table, row| table.value(row, "estimator").text() == kind)
        };
        let phase = of(EstimatorKind::Fft);
        let on_front = self.ways.iter().flat_map(|way| way.points.iter().filter(|p| p.pareto));
        let corner = |p: &Point| (p.measuring_time_s * 1e3, p.rms_error_m * 1e3);
        let mut front: Vec<(f64, f64)> = on_front.map(corner).collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        Chart {
            title: format!(
                "{}: {:.2} million detections per second, each in one sensor or another",
                self.scene,
                self.detected_rate_cps / 1e6
            ),
            panels: vec![
                panel("std_m", "standard deviation of the phase (mm)")
                    .curves(&phase, Mark::LineAndDots),
                panel("rms_error_m", "error of the phase, bias included (mm)")
                    .curves(&phase, Mark::LineAndDots),
                panel("rms_error_m", "error of the model fit (mm); line: Pareto front of both")
                    .with("Pareto front", Role::Truth, Mark::Line, front)
                    .curves(&of(EstimatorKind::Model), Mark::LineAndDots),
            ],
        }
    }

    fn table(&self) -> Table {
        let rows =
            self.ways.iter().flat_map(|way| way.points.iter().map(move |point| (way, point)));
        let rows: Vec<(&Way, &Point)> = rows.collect();
        let cells = |way: &Way| way.resources.as_ref().map(|resources| resources.cells);
        Table::of(&rows)
            .column("sensor", |(way, _)| Quoted(way.name))
            .column("estimator", |(_, p)| p.estimator.to_string())
            .column("measuring_time_s", |(_, p)| p.measuring_time_s)
            .column("frame_rate_hz", |(_, p)| p.frame_rate_hz)
            .column("bias_m", |(_, p)| p.bias_m)
            .column("std_m", |(_, p)| p.std_m)
            .column("rms_error_m", |(_, p)| p.rms_error_m)
            .column("coarse_failure_bound_fraction", |(_, p)| p.coarse_failure_bound_fraction)
            .column("pareto", |(_, p)| p.pareto)
            .column("phase_steps", |(way, _)| way.phase_steps)
            .column("parallel", |(way, _)| way.parallel)
            .column("luts", |(way, _)| cells(way).map(|cells| cells.luts))
            .column("flip_flops", |(way, _)| cells(way).map(|cells| cells.flip_flops))
            .column("memory_bits", |(way, _)| way.memory_bits)
            .table()
    }
}
