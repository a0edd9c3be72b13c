//! Lasers, targets, detectors and the paths between them, drawn.

use super::figure::shortened;
use super::prelude::*;
use crate::scene::{Path, Scene, SourceIndex};

const WIDTH: f64 = 480.0;
const BOX: (f64, f64) = (140.0, 30.0);
const PITCH: f64 = 46.0;
/// Where the nearest and the farthest target stand.
const TARGETS: (f64, f64) = (240.0, 340.0);
/// More paths than this are told, not drawn, and so is what only they lead to.
const MOST_PATHS: usize = 16;
/// Longest name that is shown whole.
const LONGEST: usize = 16;

/// Draws the light of a scene.
pub(super) fn figure(scene: &Scene) -> SvgFigure {
    let paths = drawn(scene);
    let boxes = Boxes::of(scene);
    let height = boxes.number().max(paths.len() + 1) as f64 * PITCH + 10.0;
    SvgFigure {
        id: "geometry".to_owned(),
        title: "Light: lasers, targets, detectors".to_owned(),
        description: description(scene),
        size: (WIDTH, height),
        wide: true,
        content: html! {
            @for (number, path) in paths.iter().enumerate() {
                (way(scene, path, number, &boxes, height))
            }
            @for &source in &boxes.sources {
                (device(boxes.source_y(source, height), &scene.sources[source].name, "laser", source.0))
            }
            @for &detector in &boxes.detectors {
                @let y = boxes.detector_y(detector, height);
                @let detector = &scene.detectors[detector];
                (device(y, &detector.name, "SPAD", detector.reference.0))
            }
            @if scene.paths.len() > MOST_PATHS {
                (label(WIDTH - 8.0, height - 6.0, "end tiny", &not_drawn(scene)))
            }
        },
    }
}

/// The paths that are drawn.
fn drawn(scene: &Scene) -> &[Path] {
    &scene.paths[..scene.paths.len().min(MOST_PATHS)]
}

/// The lasers and detectors that are drawn: all but those that only the paths beyond lead to.
struct Boxes {
    sources: Vec<SourceIndex>,
    detectors: Vec<DetectorIndex>,
}

impl Boxes {
    fn of(scene: &Scene) -> Boxes {
        let beyond = &scene.paths[drawn(scene).len()..];
        let is_left_out = |touches: &dyn Fn(&Path) -> bool| {
            beyond.iter().any(touches) && !drawn(scene).iter().any(touches)
        };
        Boxes {
            sources: SourceIndex::of(&scene.sources)
                .filter(|&source| !is_left_out(&|path| path.source == source))
                .collect(),
            detectors: DetectorIndex::of(&scene.detectors)
                .filter(|&detector| !is_left_out(&|path| path.detector == detector))
                .collect(),
        }
    }

    fn number(&self) -> usize {
        self.sources.len() + self.detectors.len()
    }

    /// They share the height, lasers above.
    fn y(&self, place: usize, height: f64) -> f64 {
        height * (place as f64 + 0.5) / self.number() as f64
    }

    fn source_y(&self, source: SourceIndex, height: f64) -> f64 {
        let place = self.sources.iter().position(|&other| other == source);
        self.y(place.unwrap_or(0), height)
    }

    fn detector_y(&self, detector: DetectorIndex, height: f64) -> f64 {
        let place = self.detectors.iter().position(|&other| other == detector);
        self.y(self.sources.len() + place.unwrap_or(0), height)
    }
}

fn device(y: f64, name: &str, what: &str, source: usize) -> Markup {
    html! {
        rect class={ "block s" (source % 4) } x="4" y=(coordinate(y - BOX.1 / 2.0))
            width=(coordinate(BOX.0)) height=(coordinate(BOX.1)) rx="5" {}
        (label(4.0 + BOX.0 / 2.0, y - 1.0, "middle strong", &shortened(name, LONGEST)))
        (label(4.0 + BOX.0 / 2.0, y + 11.0, "middle tiny", what))
    }
}

/// From the laser to the target and back to the detector.
fn way(scene: &Scene, path: &Path, number: usize, boxes: &Boxes, height: f64) -> Markup {
    let (nearest, farthest) =
        scene.paths.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), path| {
            (low.min(path.distance_m()), high.max(path.distance_m()))
        });
    let spread = farthest - nearest;
    let share = match spread > 0.0 {
        true => (path.distance_m() - nearest) / spread,
        false => 0.5,
    };
    let x = TARGETS.0 + share * (TARGETS.1 - TARGETS.0);
    let y = height * (number as f64 + 0.5) / drawn(scene).len() as f64;
    let from = (4.0 + BOX.0, boxes.source_y(path.source, height));
    let to = (4.0 + BOX.0, boxes.detector_y(path.detector, height));
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
    let told = drawn(scene).iter().map(|path| {
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
    let boxes = Boxes::of(scene);
    let devices = scene.sources.len() + scene.detectors.len() - boxes.number();
    match (more, devices) {
        (1, 0) => "1 more path is not drawn".to_owned(),
        (_, 0) => format!("{more} more paths are not drawn"),
        _ => format!("{more} more paths and what only they lead to are not drawn"),
    }
}
