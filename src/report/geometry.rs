//! Lasers, targets, detectors and the paths between them, drawn.

use maud::{Markup, html};

use super::figure::{Figure, coordinate, label, points};
use super::quantities::length;
use crate::scene::{Path, Scene};

const WIDTH: f64 = 480.0;
const BOX: (f64, f64) = (118.0, 30.0);
const PITCH: f64 = 46.0;
/// Where the nearest and the farthest target stand.
const TARGETS: (f64, f64) = (220.0, 370.0);
/// More paths than this are told, not drawn.
const MOST_PATHS: usize = 12;
/// Longest name that is shown whole.
const LONGEST: usize = 16;

/// Draws the light of a scene.
pub(super) fn figure(scene: &Scene) -> Figure {
    let paths = &scene.paths[..scene.paths.len().min(MOST_PATHS)];
    let boxes = scene.sources.len() + scene.detectors.len();
    let rows = boxes.max(paths.len() + 1) as f64;
    let height = rows * PITCH + 10.0;
    Figure {
        id: "geometry".to_owned(),
        title: "Light: lasers, targets, detectors".to_owned(),
        description: description(scene),
        size: (WIDTH, height),
        wide: true,
        content: html! {
            @for (number, path) in paths.iter().enumerate() {
                (way(scene, path, number, height))
            }
            @for (number, source) in scene.sources.iter().enumerate() {
                (device(source_y(scene, number, height), &source.name, "laser", number))
            }
            @for (number, detector) in scene.detectors.iter().enumerate() {
                (device(detector_y(scene, number, height), &detector.name, "SPAD", detector.reference.0))
            }
            @if scene.paths.len() > MOST_PATHS {
                (label(WIDTH - 8.0, height - 6.0, "end tiny", &not_drawn(scene)))
            }
        },
    }
}

/// Boxes share the height, lasers above.
fn place(scene: &Scene, number: usize, height: f64) -> f64 {
    let boxes = (scene.sources.len() + scene.detectors.len()) as f64;
    height * (number as f64 + 0.5) / boxes
}

fn source_y(scene: &Scene, number: usize, height: f64) -> f64 {
    place(scene, number, height)
}

fn detector_y(scene: &Scene, number: usize, height: f64) -> f64 {
    place(scene, scene.sources.len() + number, height)
}

fn shortened(name: &str) -> String {
    match name.chars().count() > LONGEST {
        true => name.chars().take(LONGEST - 1).chain(['\u{2026}']).collect(),
        false => name.to_owned(),
    }
}

fn device(y: f64, name: &str, what: &str, source: usize) -> Markup {
    html! {
        rect class={ "block s" (source % 4) } x="4" y=(coordinate(y - BOX.1 / 2.0))
            width=(coordinate(BOX.0)) height=(coordinate(BOX.1)) rx="5" {}
        (label(4.0 + BOX.0 / 2.0, y - 1.0, "middle strong", &shortened(name)))
        (label(4.0 + BOX.0 / 2.0, y + 11.0, "middle tiny", what))
    }
}

/// From the laser to the target and back to the detector.
fn way(scene: &Scene, path: &Path, number: usize, height: f64) -> Markup {
    let (nearest, farthest) = scene
        .paths
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(low, high), path| {
            (low.min(path.distance_m()), high.max(path.distance_m()))
        });
    let spread = farthest - nearest;
    let share = match spread > 0.0 {
        true => (path.distance_m() - nearest) / spread,
        false => 0.5,
    };
    let x = TARGETS.0 + share * (TARGETS.1 - TARGETS.0);
    let drawn = scene.paths.len().min(MOST_PATHS) as f64;
    let y = height * (number as f64 + 0.5) / drawn;
    let from = (4.0 + BOX.0, source_y(scene, path.source.0, height));
    let to = (4.0 + BOX.0, detector_y(scene, path.detector.0, height));
    let class = format!("curve s{}", path.source.0 % 4);
    html! {
        polyline class=(class) points=(points([from, (x, y - 3.0)])) {}
        polyline class={ (class) " back" } points=(points([(x, y + 3.0), to])) {}
        rect class="target" x=(coordinate(x)) y=(coordinate(y - 13.0)) width="7" height="26" {}
        // To the right, where no light goes.
        (label(x + 13.0, y - 1.0, "start", &length(path.distance_m())))
        (label(x + 13.0, y + 12.0, "start tiny", &remarks(path)))
    }
}

fn remarks(path: &Path) -> String {
    let mut remarks = Vec::new();
    if path.transmission != 1.0 {
        // Rounded to thousandths, and no more digits than that needs.
        let percent = (path.transmission * 1e5).round() / 1e3;
        remarks.push(format!("{percent} % arrive"));
    }
    if path.movement.is_some_and(|movement| !movement.is_neutral()) {
        remarks.push("moves".to_owned());
    }
    remarks.join(", ")
}

fn description(scene: &Scene) -> String {
    let told = scene.paths.iter().take(MOST_PATHS).map(|path| {
        format!(
            "light of {} reaches {} off a target at {}",
            scene.sources[path.source].name,
            scene.detectors[path.detector].name,
            length(path.distance_m())
        )
    });
    let mut text = told.collect::<Vec<_>>().join("; ");
    if scene.paths.len() > MOST_PATHS {
        text += "; ";
        text += &not_drawn(scene);
    }
    text
}

fn not_drawn(scene: &Scene) -> String {
    let more = scene.paths.len() - MOST_PATHS;
    let plural = if more == 1 { " is" } else { "s are" };
    format!("{more} more path{plural} not drawn")
}
