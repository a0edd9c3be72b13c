//! The report page of `goldtof run`.

use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::DetectorCounts;
use super::estimates::BothEstimates;
use super::plot::{CountPlot, PlotError};
use crate::cosim;
use crate::deliver::Emission;
use crate::estimate::report::EstimateReport;
use crate::plan::{Part, Plan};
use crate::sensor::Sensor;

/// What the page shows.
pub struct Page<'a> {
    /// The scene.
    pub sensor: &'a Sensor,
    /// Seed of the photons.
    pub seed: u64,
    /// What was kept and left out.
    pub plan: &'a Plan,
    /// The Verilog.
    pub emission: &'a Emission,
    /// The co-simulation.
    pub cosim: &'a cosim::Report,
    /// Counts of the scan's steps, one entry per detector.
    pub counts: &'a [DetectorCounts],
    /// What the counts say by the scene's estimator.
    pub estimates: &'a [EstimateReport],
    /// And by the other one.
    pub other_estimates: &'a [EstimateReport],
}

const STYLE: &str = "
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 900px; margin: 2em auto; \
padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: 0.25em 0.8em 0.25em 0; \
border-bottom: 1px solid #ddd; }
td.kept { white-space: nowrap; }
tr.left-out { color: #777; }
.verdict { font-weight: bold; padding: 0.1em 0.5em; border-radius: 0.3em; color: white; }
.match { background: #2e7d32; } .mismatch { background: #b3261e; } .inconclusive { background: #8a5a00; }
svg { width: 100%; height: auto; }
";

impl Page<'_> {
    /// The whole page.
    ///
    /// # Errors
    /// When a plot cannot be drawn.
    pub fn html(&self) -> Result<String, PlotError> {
        let title = format!("goldtof: {}", self.sensor.scene().name);
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    title { (title) }
                    style { (PreEscaped(STYLE)) }
                }
                body {
                    h1 { (title) }
                    p {
                        "Verilog and reference model: "
                        span class={ "verdict " (self.cosim.verdict.to_string()) } {
                            (self.cosim.verdict.to_string())
                        }
                        ". Seed " (self.seed) "."
                    }
                    h2 { "Distance" }
                    (self.distance())
                    h2 { "Correlation" }
                    @for counts in self.counts {
                        @if self.counts.len() > 1 {
                            h3 { (self.sensor.scene().detectors[counts.detector].name) }
                        }
                        (self.correlation(counts)?)
                    }
                    h2 { "Co-simulation" }
                    (self.cosimulation())
                    h2 { "Hardware: kept and left out" }
                    (parts(&self.plan.hardware))
                    h2 { "Simulation: kept and left out" }
                    (parts(&self.plan.simulation))
                    h2 { "Files" }
                    p { "Top module " code { (self.emission.top) } ", in " code { "rtl/" } ":" }
                    ul {
                        @for file in &self.emission.files { li { code { (file.name) } } }
                    }
                    p { "All counts: " code { "counts.csv" } "." }
                }
            }
        };
        Ok(page.into_string())
    }

    fn distance(&self) -> Markup {
        html! {
            @for (own, other) in self.estimates.iter().zip(self.other_estimates) {
                @let both = BothEstimates { own, other };
                table {
                    tr {
                        @for heading in ["estimator", "distance", "error", "expected error", "off by (std)"] {
                            th { (heading) }
                        }
                    }
                    @for row in both.rows() {
                        tr {
                            th { (row.name) }
                            @for cell in [row.distance, row.error, row.expected, row.off] {
                                td { (cell) }
                            }
                        }
                    }
                }
                @for note in both.notes() { p { (note) } }
            }
        }
    }

    fn correlation(&self, counts: &DetectorCounts) -> Result<Markup, PlotError> {
        let points = points(counts);
        let estimate = self.estimates[counts.detector].distance_m;
        let paths = self.sensor.scene().paths.iter();
        let true_distances = paths
            .filter(|path| path.detector == counts.detector)
            .map(|path| (path.distance_m(), "true distance".to_owned()));
        let markers: Vec<(f64, String)> = estimate
            .map(|distance_m| (distance_m, "estimate".to_owned()))
            .into_iter()
            .chain(true_distances)
            .collect();
        let whole = CountPlot {
            title: "All phase steps",
            points: &points,
            markers: &[],
            dots: false,
        };
        let near = self.near_peak(&points);
        let peak = CountPlot {
            title: "Round the peak",
            points: near,
            markers: &markers
                .into_iter()
                .filter(|(d, _)| {
                    near.first().is_some_and(|first| first.0 <= *d)
                        && near.last().is_some_and(|last| *d <= last.0)
                })
                .collect::<Vec<_>>(),
            dots: true,
        };
        Ok(html! {
            (PreEscaped(whole.svg()?))
            (PreEscaped(peak.svg()?))
        })
    }

    /// Four chips on either side of the largest count.
    fn near_peak<'p>(&self, points: &'p [(f64, f64)]) -> &'p [(f64, f64)] {
        let Some(peak) = (0..points.len()).max_by(|&a, &b| points[a].1.total_cmp(&points[b].1))
        else {
            return points;
        };
        let half = 4 * self.sensor.clock().samples_per_chip as usize;
        &points[peak.saturating_sub(half)..(peak + half + 1).min(points.len())]
    }

    fn cosimulation(&self) -> Markup {
        let report = self.cosim;
        html! {
            table {
                tr { th { "clocks compared" } td { (report.cycles) } }
                @for missing in &report.missing {
                    tr { th { "inconclusive" } td { (missing) } }
                }
                tr { th { "exercised" } td { (report.exercised.text()) } }
                @if !report.not_exercised.is_empty() {
                    tr { th { "not exercised" } td { (report.not_exercised.join(", ")) } }
                }
                tr { th { "ports compared at every clock" } td { (report.compared_ports.join(", ")) } }
                tr {
                    th { "million clocks per second" }
                    td { (format!("{:.1}", report.cycles_per_second / 1e6)) }
                }
                @if let Some(first) = &report.first_mismatch {
                    tr {
                        th { "first mismatch" }
                        td {
                            "clock " (first.cycle) ", port " (first.port) ": expected "
                            (first.expected.to_string()) ", got " (first.got.to_string())
                        }
                    }
                }
            }
        }
    }
}

/// (distance, count) in order of distance, also for a window that wraps round the
/// code period.
fn points(counts: &DetectorCounts) -> Vec<(f64, f64)> {
    let values = counts.counts.iter().map(|&count| count as f64);
    let mut points: Vec<(f64, f64)> = counts.distances_m.iter().copied().zip(values).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

fn parts(parts: &[Part]) -> Markup {
    html! {
        table {
            tr { th { "part" } th { "" } th { "why" } }
            @for part in parts {
                tr class=[(!part.kept).then_some("left-out")] {
                    td { (part.part) }
                    td.kept { @if part.kept { "kept" } @else { "left out" } }
                    td { (part.reason) }
                }
            }
        }
    }
}
