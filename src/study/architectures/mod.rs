//! Which sensor to build: the same light on hardware that counts one phase step after
//! another, sixteen at once, or by arrival time. The JSON of `goldtof compare-architectures`.

mod points;

use std::fmt::Write as _;

use serde::Serialize;

use crate::estimate::{NoEstimate, PredictionError, check_modulated};
use crate::files::{FileError, OutputFolder};
use crate::plan::resources::{Resources, resources};
use crate::report::chart::{Chart, ChartAxis, DrawingRole, Mark, Panel};
use crate::report::columns::Lines;
use crate::report::table::{Quoted, Table, fields};
use crate::scan::Step;
use crate::scene::{Architecture, DetectorIndex, EstimatorKind, PathIndex, Scene};
use crate::sensor::Sensor;

/// Phase steps at once of the hardware that correlates several.
const PARALLEL: u32 = 16;

/// What `goldtof compare-architectures` gives.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Comparison")]
pub struct ArchitectureComparison {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// The path that is ranged: the first of the first detector's own source.
    pub path: PathIndex,
    /// Its distance.
    pub true_distance_m: f64,
    /// Rate of counted detections, which is that of every architecture.
    pub detected_rate_cps: f64,
    /// Sensors that could be built.
    pub ways: Vec<Way>,
}

/// A sensor that could be built.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct Way {
    /// What it is called here.
    pub name: &'static str,
    /// `hardware.architecture`.
    pub architecture: &'static str,
    /// Phase steps that see the same light: all of a histogram's.
    pub parallel: u64,
    /// Phase steps of a scan.
    pub phase_steps: u64,
    /// Whether a scan covers the whole code period. If not, the distance has to be known
    /// to a chip beforehand.
    pub whole_range: bool,
    /// What it takes of the FPGA; null where nothing like it was synthesized.
    pub resources: Option<Resources>,
    /// Bits of memory: of two histograms that take turns, over the scene's integration time
    /// in whole code periods. What is measured for longer is their sum.
    pub memory_bits: u64,
    /// What is expected of it, by estimator and measuring time.
    pub points: Vec<ArchitecturePoint>,
    /// Why there are no points of an estimator, where that is so.
    pub remarks: Vec<String>,
}

/// What is expected of a sensor in some measuring time.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Point")]
pub struct ArchitecturePoint {
    /// How the distance is got.
    pub estimator: EstimatorKind,
    /// Time of a whole scan.
    pub measuring_time_s: f64,
    /// Scans in a second.
    pub frame_rate_hz: f64,
    /// Expected bias, which no measuring time removes.
    pub bias_m: f64,
    /// Expected standard deviation, as long as the peak is found.
    pub std_m: f64,
    /// Root of the sum of their squares.
    pub rms_error_m: f64,
    /// At most this share of scans takes a wrong peak; null where the place is known.
    pub coarse_failure_bound_fraction: Option<f64>,
    /// Whether no other sensor that covers the whole range has a smaller error in as
    /// little time; only of points that find the peak in 99 % of scans.
    pub pareto: bool,
}

/// Why architectures could not be compared.
#[derive(Debug, thiserror::Error)]
pub enum ComparisonError {
    /// No path of the detector's own source.
    #[error(
        "no path leads from the first detector's own source to it, so there is no distance to compare"
    )]
    NoPath,
    /// A scan over part of the code period.
    #[error(
        "the scan has {steps} of {steps_per_period} phase steps; architectures are compared over \
         the whole code period: write scan.steps = \"all\""
    )]
    NotWhole {
        /// Steps of the scan.
        steps: u64,
        /// Steps of the code period.
        steps_per_period: u64,
    },
    /// Nothing modulated reaches the detector.
    #[error(transparent)]
    NoEstimate(#[from] NoEstimate),
    /// Nothing can be expected.
    #[error(transparent)]
    Prediction(#[from] PredictionError),
}

/// One of the sensors, before it is worked out.
struct Plan {
    name: &'static str,
    architecture: Architecture,
    parallel: u32,
    /// The steps of a chip before and after the peak alone.
    near: bool,
}

const PLANS: [Plan; 5] = [
    Plan::updown("sequential", 1, false),
    Plan::updown("parallel 16", PARALLEL, false),
    Plan { name: "histogram", architecture: Architecture::Histogram, parallel: 1, near: false },
    Plan::updown("sequential, near the peak", 1, true),
    Plan::updown("parallel 16, near the peak", PARALLEL, true),
];

impl Plan {
    const fn updown(name: &'static str, parallel: u32, near: bool) -> Plan {
        Plan { name, architecture: Architecture::UpDown, parallel, near }
    }

    /// The scene with this sensor, round the phase step of the peak where it is near.
    fn scene(&self, scene: &Scene, peak_step: u64) -> Scene {
        let mut other = scene.clone();
        let all = scene.scan.steps_per_period;
        let samples = u64::from(scene.samples_per_chip);
        other.scan.first_step = 0;
        other.scan.steps = all;
        if self.near {
            other.scan.steps = (2 * samples).min(all);
            other.scan.first_step = (peak_step + all - samples.min(all)) % all;
        }
        other.hardware.architecture = self.architecture;
        if self.architecture == Architecture::Histogram {
            let code_chips = scene.timing().code_chips();
            let periods = (scene.scan.integration_chips + code_chips / 2) / code_chips;
            other.scan.integration_chips = periods.max(1) * code_chips;
        }
        other.hardware.parallel = self.parallel.min(other.scan.steps as u32);
        // What one architecture has and the other has not would be compared, too.
        other.hardware.counter_width = None;
        other.hardware.total_counts = None;
        other.hardware.peak_detector = false;
        other
    }
}

/// Compares the architectures on the first detector's first own path, over measuring times
/// up to that of the scene's own scan with one phase step after another.
///
/// # Errors
/// When nothing can be expected of the scene.
pub fn compare(scene: &Scene) -> Result<ArchitectureComparison, ComparisonError> {
    let path = scene.own_paths(DetectorIndex(0)).next().ok_or(ComparisonError::NoPath)?;
    if !scene.scan.is_full() {
        return Err(ComparisonError::NotWhole {
            steps: scene.scan.steps,
            steps_per_period: scene.scan.steps_per_period,
        });
    }
    check_modulated(&Sensor::new(scene), DetectorIndex(0))?;
    let sequential = PLANS[0].scene(scene, 0);
    let peak = points::peak(&sequential, path)?;
    let times = points::times_chips(&Sensor::new(&sequential));
    let mut ways: Vec<Way> = PLANS
        .iter()
        .map(|plan| {
            let scene = plan.scene(scene, peak.step);
            way(plan, &scene, path, &times)
        })
        .collect();
    points::mark_pareto(&mut ways);
    Ok(ArchitectureComparison {
        scene: scene.name.clone(),
        path,
        true_distance_m: scene.paths[path].distance_m(),
        detected_rate_cps: peak.detected_rate_cps,
        ways,
    })
}

fn way(plan: &Plan, scene: &Scene, path: PathIndex, times: &[u64]) -> Way {
    let sensor = Sensor::new(scene);
    let timing = sensor.timing();
    let group = timing.grouping().group_of(Step(0));
    let is_histogram = plan.architecture == Architecture::Histogram;
    let (points, remarks) = points::points(plan, scene, path, times);
    Way {
        name: plan.name,
        architecture: if is_histogram { "histogram" } else { "updown" },
        parallel: timing.grouping().steps_of(group).len() as u64,
        phase_steps: timing.scan.steps,
        whole_range: !plan.near,
        resources: resources(&sensor),
        memory_bits: match sensor.interface().histogram() {
            Some(plan) => plan.memory_bits(scene.detectors.len()) as u64,
            None => 0,
        },
        points,
        remarks,
    }
}

impl ArchitectureComparison {
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
                ChartAxis::log("measuring_time_s", "measuring time (ms)"),
                ChartAxis::log(column, label),
            )
        };
        let of = |kind: EstimatorKind| {
            let kind = kind.to_string();
            table.only(|table, row| table.value(row, "estimator").text() == kind)
        };
        let phase = of(EstimatorKind::Fft);
        let on_front = self.ways.iter().flat_map(|way| way.points.iter().filter(|p| p.pareto));
        let corner = |p: &ArchitecturePoint| (p.measuring_time_s * 1e3, p.rms_error_m * 1e3);
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
                    .with("Pareto front", DrawingRole::Truth, Mark::Line, front)
                    .curves(&of(EstimatorKind::Model), Mark::LineAndDots),
            ],
        }
    }

    fn table(&self) -> Table {
        let rows =
            self.ways.iter().flat_map(|way| way.points.iter().map(move |point| (way, point)));
        let rows: Vec<(&Way, &ArchitecturePoint)> = rows.collect();
        let cells = |way: &Way| way.resources.as_ref().map(|resources| resources.cells);
        let columns = Table::of(&rows)
            .column("sensor", |(way, _)| Quoted(way.name))
            .column("estimator", |(_, point)| point.estimator.to_string());
        let columns = fields!(
            columns, (_, point) => point;
            measuring_time_s, frame_rate_hz, bias_m, std_m, rms_error_m,
            coarse_failure_bound_fraction, pareto
        );
        fields!(columns, (way, _) => way; phase_steps, parallel)
            .column("luts", |(way, _)| cells(way).map(|cells| cells.luts))
            .column("flip_flops", |(way, _)| cells(way).map(|cells| cells.flip_flops))
            .column("memory_bits", |(way, _)| way.memory_bits)
            .table()
    }
}

impl ArchitectureComparison {
    /// The comparison as a table.
    pub fn to_text(&self) -> String {
        let mut text = format!(
            "{}, path {} at {:.4} m, {:.3} million detections per second\n",
            self.scene,
            self.path,
            self.true_distance_m,
            self.detected_rate_cps / 1e6
        );
        for way in &self.ways {
            way.write(&mut text);
        }
        text += "Pareto: no sensor over the whole range has a smaller error in as little time\n";
        text
    }
}

impl Way {
    fn write(&self, text: &mut String) {
        let cells = match &self.resources {
            Some(resources) => resources.in_short(),
            None => "LUTs unknown".to_owned(),
        };
        let _ = writeln!(
            text,
            "\n{}: {} phase steps, {} at once, {cells}, {} kbit of memory{}",
            self.name,
            self.phase_steps,
            self.parallel,
            self.memory_bits.div_ceil(1024),
            if self.whole_range { "" } else { "; for a distance known to a chip" },
        );
        if !self.points.is_empty() {
            *text += &Lines::of(&self.points, "  ")
                .left("estimator", 9, |point| point.estimator.to_string())
                .right("time ms", 12, |point| format!("{:.4}", point.measuring_time_s * 1e3))
                .right("frames per s", 14, |point| format!("{:.2}", point.frame_rate_hz))
                .right("bias mm", 9, |point| format!("{:.3}", point.bias_m * 1e3))
                .right("std mm", 9, |point| format!("{:.3}", point.std_m * 1e3))
                .right("error mm", 10, |point| format!("{:.3}", point.rms_error_m * 1e3))
                .right("missed below", 13, |point| {
                    let missed = point.coarse_failure_bound_fraction;
                    missed.map_or("-".to_owned(), |share| format!("{share:.1e}"))
                })
                .left("", 0, |point| if point.pareto { "  Pareto" } else { "" }.to_owned())
                .text();
        }
        for remark in &self.remarks {
            let _ = writeln!(text, "  {remark}");
        }
    }
}
