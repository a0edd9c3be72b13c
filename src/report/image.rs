//! An image as text, and its page.

use super::columns::row;
use super::page::document;
use super::plan::row;
use super::prelude::*;
use crate::image::{ImageReport, MapSummary, PixelReport};
use crate::simulate::Tier;

/// An image in lines of no more than `width` characters where that is given.
pub(crate) fn text(report: &ImageReport, width: Option<usize>) -> String {
    let mut text = paragraph(title(report), width);
    text += &columns(&rows(report), 2, width);
    let told = report.pixels.iter().map(of_pixel).chain(report.remarks.iter().cloned());
    text + &told.map(|told| paragraph(told, width)).collect::<String>()
}

fn title(report: &ImageReport) -> String {
    let frames = match (report.fidelity, report.frames) {
        (Tier::Expected, _) => "a frame drawn from theory".to_owned(),
        (tier, 1) => format!("a frame of the tier {tier}"),
        (tier, frames) => format!("{frames} frames of the tier {tier}"),
    };
    let ImageReport { scene, columns, rows, .. } = report;
    let lit = number(report.lit_pixels as u64);
    let estimator = estimator_name(report.estimator);
    format!("{scene}: {columns} x {rows} pixels, {lit} of them lit, {estimator}, {frames}")
}

/// What there is to say, each with its name.
fn rows(report: &ImageReport) -> Vec<Vec<String>> {
    let mut rows: Vec<Vec<String>> =
        report.maps.iter().filter_map(|map| Some(row(map.map, of_map(map)?))).collect();
    if let Some(table) = &report.interpolation {
        rows.push(row!(
            "theory",
            "interpolated from {} points of light and delay; at {} pixels off by {:.3} standard \
                 deviations at most",
            number(table.nodes as u64),
            table.checked_pixels,
            table.worst_error_in_std
        ));
    }
    if let Some(check) = &report.check {
        let z = match (check.mean_deviation_in_std, check.rms_deviation_in_std) {
            (Some(mean), Some(rms)) => format!("z {mean:+.3} on average, {rms:.3} rms; "),
            _ => String::new(),
        };
        rows.push(row!(
            "check",
            "{} pixels simulated ({}): {z}{} missed their path, {:.1} were expected to",
            number(check.pixels as u64),
            check.fidelity,
            check.missed,
            check.expected_missed_fraction * check.pixels as f64
        ));
    }
    rows
}

/// A map's numbers, in words.
fn of_map(map: &MapSummary) -> Option<String> {
    let (low, median, high) = (map.low?, map.median?, map.high?);
    let shown = |value: f64| match map.map.rsplit('_').next() {
        Some("m") if map.map.ends_with("depth_m") => length(value),
        Some("m") => millimetres(value, value < 0.0),
        Some("cps") => rate(value),
        _ => percent(value),
    };
    let [low, median, high] = [low, median, high].map(shown);
    let meaning = map.meaning;
    Some(format!("{meaning}: median {median}, 1st and 99th percentile {low} and {high}"))
}

fn of_pixel(pixel: &PixelReport) -> String {
    let list = |distances: &[f64]| {
        distances.iter().map(|m| format!("{m:.4} m")).collect::<Vec<_>>().join(" and ")
    };
    let seen = match pixel.true_distances_m.is_empty() {
        true => "sees nothing".to_owned(),
        false => format!("sees {}", list(&pixel.true_distances_m)),
    };
    let shown = match pixel.distances_m.is_empty() {
        true => "shows no distance".to_owned(),
        false => format!("shows {}", list(&pixel.distances_m)),
    };
    let PixelReport { row, column, fidelity, .. } = pixel;
    let [own, background] = [pixel.own_primary_hz, pixel.background_hz].map(rate);
    let mut text = format!(
        "pixel {row},{column} {seen}: {own} of its light would fire it, {background} of the background; \
         its scan ({fidelity}) {shown}"
    );
    if let Some((bias_m, std_m)) = pixel.expected_bias_m.zip(pixel.expected_std_m) {
        text +=
            &format!("; expected {} +- {}", millimetres(bias_m, true), millimetres(std_m, false));
    }
    if let Some(z) = pixel.deviation_in_std {
        text += &format!(", off by {z:+.2} std");
    }
    text
}

/// A page of the maps, whose pictures lie beside it.
pub(crate) fn page(report: &ImageReport, command: &str) -> String {
    let picture = |map: &MapSummary| -> Markup {
        html! {
            figure {
                figcaption { (map.map) }
                a href={ (map.map) ".png" } {
                    img src={ (map.map) ".png" } alt=(map.meaning) style="width: 100%; height: auto";
                }
                p.soft { (of_map(map).unwrap_or_else(|| format!("{}: no pixel has one", map.meaning))) }
            }
        }
    };
    let more =
        rows(report).split_off(report.maps.iter().filter(|map| map.median.is_some()).count());
    document(
        &report.scene,
        &html! {
            div.head { h1 { (report.scene) } }
            p.lead { (title(report)) }
            @for row in &more { p { (row.join(": ")) } }
            @for pixel in &report.pixels { p { (of_pixel(pixel)) } }
            @for remark in &report.remarks { p { (remark) } }
            section { h2 { "Maps" } div.figures { @for map in &report.maps { (picture(map)) } } }
            section {
                h2 { "Where this comes from" }
                p { "Each map is a NPY file of the same name, 32-bit floating point, row by row, NaN where \
                     there is no number; " code { "points.ply" } " has the measured points." }
                pre { (command) }
            }
        },
    )
}
