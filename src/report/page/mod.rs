//! The report page of `goldtof run`: one file, without scripts and without links out of it.

mod hardware;
mod light;

use maud::{DOCTYPE, PreEscaped};

use super::DetectorCounts;
use super::columns::row;
use super::curves::IntegrationCurves;
use super::estimates::Notes;
use super::plan::{about, row, saving, spelled};
use super::prelude::*;
use super::provenance::Provenance;
use super::role::colours;
use super::timing::Wave;
use crate::cosim;
use crate::deliver::Emission;
use crate::grade::Grade;
use crate::plan::figures::Figures;
use crate::plan::resources::Resources;
use crate::plan::{Part, Plan};
use crate::printable::{printable, printable_lines};
use crate::recorded::{AsItIs, RecordedHistogram};
use crate::reference::cover_report::Missed;

/// Titles that links lead to.
const COSIMULATION: &str = "Co-simulation";
const HARDWARE: &str = "Hardware";
const STRENGTH: &str = "How strong the check is";
const WAVES: &str = "Ports, clock by clock";

/// A page of its own, about a scene.
pub(super) fn document(scene: &str, content: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "goldtof: " (scene) }
                style { (PreEscaped(include_str!("style.css"))) (PreEscaped(colours(true))) }
            }
            body { main { (content) } }
        }
    };
    page.into_string()
}

/// What a title is linked by.
fn id_of(title: &str) -> String {
    let words = title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    words.map(str::to_lowercase).collect::<Vec<_>>().join("-")
}

/// What the page shows.
pub struct Page<'a> {
    /// The sensor and its scene.
    pub sensor: &'a Sensor,
    /// Seed of the photons.
    pub seed: u64,
    /// Where the report comes from.
    pub provenance: &'a Provenance,
    /// What was kept and left out.
    pub plan: &'a Plan,
    /// The sensor in numbers.
    pub figures: &'a Figures,
    /// What it takes of an FPGA.
    pub resources: Option<&'a Resources>,
    /// The Verilog.
    pub emission: &'a Emission,
    /// The ports clock by clock.
    pub waves: &'a [Wave],
    /// What theory expects at other integration times; what is missing is worked out.
    pub curves: &'a [IntegrationCurves],
    /// What the scene expects of each detector's counts.
    pub as_it_is: &'a [AsItIs],
    /// The co-simulation.
    pub cosim: &'a cosim::Report,
    /// Counts of the scan's steps, one entry per detector.
    pub counts: &'a [DetectorCounts],
    /// The histograms that they are of; none of a sensor that counts up and down.
    pub histograms: &'a [RecordedHistogram],
    /// What the counts say by the scene's estimator.
    pub estimates: &'a [EstimateReport],
    /// And by the other one.
    pub other_estimates: &'a [EstimateReport],
    /// What the adversarial stimulus is worth, if that was asked for.
    pub grade: Option<&'a Grade>,
}

impl Page<'_> {
    /// The whole page.
    pub fn html(&self) -> String {
        let name = &self.sensor.scene().name;
        let mut sections = vec![
            ("Distance", self.distance()),
            ("Light and counts", light::section(self)),
            ("What longer integration and longer simulation gain", light::trades(self)),
            (HARDWARE, hardware::section(self)),
            (COSIMULATION, self.cosimulation()),
        ];
        let strength = self.grade.map(hardware::strength);
        sections.extend(strength.map(|section| (STRENGTH, section)));
        sections.extend([
            ("Left out, and kept", self.parts()),
            ("Where this comes from", self.origin()),
        ]);
        document(
            name,
            &html! {
                (self.head(name))
                @for (title, content) in &sections {
                    section id=(id_of(title)) { h2 { (title) } (content) }
                }
            },
        )
    }

    fn head(&self, name: &str) -> Markup {
        let verdict = self.cosim.verdict.to_string();
        html! {
            header {
                div.head {
                    h1 { (name) }
                    span class={ "verdict " (verdict) } { a href={ "#" (id_of(COSIMULATION)) } { (verdict) } }
                }
                p.lead { "Verilog against its reference model, over " (number(self.cosim.clocks)) " clocks" }
                dl.tiles { @for (name, value, remark) in self.tiles() {
                    div { dt { (name) } dd { (value) @if !remark.is_empty() { small { (remark) } } } }
                } }
            }
        }
    }

    /// What people look for first.
    fn tiles(&self) -> Vec<(String, String, String)> {
        let tile = |name: &str, value: String, remark: String| (name.to_owned(), value, remark);
        let mut tiles = Vec::new();
        for both in self.both().take(2) {
            for estimate in both.in_order() {
                let Some(distance_m) = estimate.distance_m else {
                    continue;
                };
                let error = estimate.error_m.map(|m| format!("error {}", millimetres(m, true)));
                let whose =
                    format!("{}, {}", estimate.detector, estimator_name(estimate.estimator));
                tiles.push(tile(&whose, format!("{distance_m:.4} m"), error.unwrap_or_default()));
            }
        }
        let figures = self.figures;
        tiles.push(tile(
            "Frame time",
            time(figures.frame_time_s),
            match figures.at_once {
                true => format!("{} steps at once", number(figures.phase_steps)),
                false => format!(
                    "{} steps of {}",
                    number(figures.phase_steps),
                    time(figures.integration_s)
                ),
            },
        ));
        tiles.push(tile(
            "Unambiguous range",
            length(figures.unambiguous_range_m),
            format!("steps of {}", length(figures.phase_step_distance_m)),
        ));
        tiles.push(tile(
            "Clock",
            frequency(figures.clock_hz),
            format!("latency {} clocks", figures.result_latency_clocks),
        ));
        tiles.extend(self.resources.map(fpga_tile));
        tiles
    }

    /// Both estimates, detector by detector.
    fn both(&self) -> impl Iterator<Item = BothEstimates<'_>> {
        let pairs = self.estimates.iter().zip(self.other_estimates);
        pairs.map(|(own, other)| BothEstimates { own, other })
    }

    fn distance(&self) -> Markup {
        let all: Vec<BothEstimates> = self.both().collect();
        let notes = Notes::of(&all);
        html! {
            @for (both, own_notes) in all.iter().zip(&notes.own) {
                @let truth = both.own.true_distance_m;
                h3 {
                    (both.own.detector) " ranging " (both.own.source)
                    @if let Some(truth) = truth { ", true distance " (format!("{truth:.4}")) " m" }
                }
                (table(
                    &["estimator", "distance", "error", "expected error", "off by, in standard deviations"],
                    &both.rows().map(|row| row.to_vec()),
                ))
                @for note in own_notes { p.soft { (capitalized(note)) } }
                (details_of(both))
            }
            @for (whose, note) in &notes.shared { p.soft { strong { (whose) } ": " (note) } }
        }
    }

    fn cosimulation(&self) -> Markup {
        let report = self.cosim;
        let mut rows = vec![
            row("verdict", report.verdict.to_string()),
            row("clocks compared", number(report.clocks)),
            row("clocked", report.engines_text()),
            row("ports compared at every clock", report.compared_ports.join(", ")),
            row("exercised", report.exercised.text()),
            row("covered", report.coverage.summary()),
        ];
        rows.extend(report.missing.iter().map(|missing| row("inconclusive", missing)));
        if !report.not_exercised.is_empty() {
            rows.push(row("not exercised", report.not_exercised.join(", ")));
        }
        if let Some(first) = &report.first_mismatch {
            rows.push(row!("first mismatch", "clock {}: {}", first.clock, first.text()));
        }
        if !self.provenance.reproducible {
            let speed = report.clocks_per_s / 1e6;
            rows.push(row!("speed", "{speed:.1} million clocks per second"));
        }
        let coverage = &report.coverage;
        let missed = |points: &[Missed]| -> Vec<Vec<String>> {
            let row = |missed: &Missed| {
                vec![missed.point.clone(), missed.reason.clone().unwrap_or_default()]
            };
            points.iter().map(row).collect()
        };
        let lists =
            [("Not covered", &coverage.not_covered), ("Cannot be covered", &coverage.unreachable)];
        html! {
            (values(&rows))
            @for (title, points) in lists.into_iter().filter(|(_, points)| !points.is_empty()) {
                details {
                    summary { (title) ": " (points.len()) " cover points" }
                    (table(&["cover point", "why"], &missed(points)))
                }
            }
            p.soft {
                "The ports that are compared: " a href={ "#" (id_of(WAVES)) } { "clock by clock" }
                @if self.grade.is_some() {
                    "; what the check would have found: " a href={ "#" (id_of(STRENGTH)) } { "faults and mutants" }
                }
                "."
            }
        }
    }

    fn parts(&self) -> Markup {
        let of = |parts: &[Part], kept: bool| -> Vec<Vec<String>> {
            let parts = parts.iter().filter(|part| part.kept == kept);
            let row = |part: &Part| {
                let name = spelled(&part.part);
                match kept {
                    true => vec![name, part.reason.clone()],
                    false => vec![name, part.reason.clone(), saving(part).unwrap_or_default()],
                }
            };
            let mut rows: Vec<Vec<String>> = parts.map(row).collect();
            // Without the last column where there is nothing in it.
            if rows.iter().all(|row| row.get(2).is_none_or(String::is_empty)) {
                rows.iter_mut().for_each(|row| row.truncate(2));
            }
            rows
        };
        let headings = |rows: &[Vec<String>]| match rows.iter().any(|row| row.len() > 2) {
            true => vec!["part", "why", "saves"],
            false => vec!["part", "why"],
        };
        html! {
            @for (title, parts) in [("hardware", &self.plan.hardware), ("simulation", &self.plan.simulation)] {
                h3 { "Left out of the " (title) }
                @let left_out = of(parts, false);
                (table(&headings(&left_out), &left_out))
                details {
                    summary { "Kept in the " (title) }
                    (table(&["part", "why"], &of(parts, true)))
                }
            }
        }
    }

    fn origin(&self) -> Markup {
        let Provenance { version, command, date, scene_text, .. } = self.provenance;
        let rows = [
            row("made by", printable(version)),
            row("command", printable(command)),
            row("date", printable(date)),
            row("seed", self.seed.to_string()),
        ];
        html! {
            (values(&rows))
            details {
                summary { "The scene file" }
                pre { (printable_lines(scene_text)) }
            }
            p { "Beside this file: " code { "counts.csv" } ", all counts; "
                @if self.figures.at_once { code { "bins.csv" } ", all bins; " }
                code { "rtl/" } ", top module " code { (self.emission.top) } ":" }
            p.soft {
                @for (index, file) in self.emission.files.iter().enumerate() {
                    @if index > 0 { ", " }
                    code { (file.name) }
                }
            }
        }
    }
}

/// What the sensor takes of an FPGA.
fn fpga_tile(resources: &Resources) -> (String, String, String) {
    let block_rams = match resources.block_rams {
        0 => "no block RAM".to_owned(),
        1 => "1 block RAM".to_owned(),
        blocks => format!("{blocks} block RAMs"),
    };
    (
        "FPGA".to_owned(),
        format!("{}{} LUTs", about(resources), resources.cells.luts),
        format!("{} flip-flops, {block_rams}", resources.cells.flip_flops),
    )
}

/// What few people want to know of an estimate.
fn details_of(both: &BothEstimates) -> Markup {
    let own = both.own;
    let mut rows = Vec::new();
    for estimate in both.in_order() {
        rows.extend(
            estimate
                .coarse_phase_step
                .map(|step| row("phase step of the largest count", step.to_string())),
        );
        let Some(fit) = &estimate.fit else { continue };
        let alarm = if fit.alarm { ": alarm" } else { "" };
        let chi_square = format!(
            "{:.1} for {} degrees of freedom{alarm}",
            fit.chi_square, fit.degrees_of_freedom
        );
        rows.push(row("chi-square of the fit", chi_square));
        for path in &fit.paths[1..] {
            let name = path.source.as_deref().unwrap_or("a code of the set");
            let value = format!(
                "{name} at {:.4} m, +- {}",
                path.distance_m,
                millimetres(path.distance_std_m, false)
            );
            rows.push(row("other light", value));
        }
    }
    rows.push(row!("calibration offset", "{:.1} ps", own.calibration_offset_ps));
    rows.push(row!("unambiguous range", "{:.4} m", own.unambiguous_range_m));
    if let Some(at_s) = own.true_distance_at_s {
        let value = format!("{:.4} ms after the start of the scan", at_s * 1e3);
        rows.push(row("true distance is that of", value));
    }
    html! { details { summary { "More of these estimates" } (values(&rows)) } }
}

fn capitalized(text: &str) -> String {
    let mut characters = text.chars();
    characters
        .next()
        .map_or(String::new(), |first| first.to_uppercase().chain(characters).collect())
}

/// Headings and rows; the first cell of a row is its name.
pub(super) fn table(headings: &[&str], rows: &[Vec<String>]) -> Markup {
    html! {
        table.rows {
            thead { tr { @for heading in headings { th scope="col" { (heading) } } } }
            tbody {
                @for row in rows {
                    tr {
                        @for (column, cell) in row.iter().enumerate() {
                            @if column == 0 {
                                th scope="row" { (cell) }
                            } @else {
                                td data-name=[headings.get(column).filter(|name| !name.is_empty())] {
                                    (cell)
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Names and values, without headings.
pub(super) fn values(rows: &[Vec<String>]) -> Markup {
    html! {
        table.rows {
            tbody {
                @for row in rows {
                    tr {
                        @if let [name, values @ ..] = row.as_slice() {
                            th scope="row" { (name) }
                            @for value in values { td { (value) } }
                        }
                    }
                }
            }
        }
    }
}
