//! Paths and detectors by name, so that the order of a scene's tables decides
//! nothing: neither which random numbers a part draws, nor how sums round.

use super::random::scatter;
use crate::scene::{DetectorIndex, Path, PathIndex};
use crate::sensor::Sensor;

/// A path that leads to a detector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NumberedPath {
    /// Its index in the scene.
    pub index: PathIndex,
    /// What its random streams are told apart by.
    pub number: u64,
}

/// The paths to a detector: by the name of their source, those of one source
/// from the shortest to the longest. A path's number follows from both names
/// and its place among the paths between the two.
pub fn paths_to(sensor: &Sensor, detector: DetectorIndex) -> Vec<NumberedPath> {
    let source_name = |path: &Path| &sensor.scene().sources[path.source].name[..];
    let mut indices: Vec<PathIndex> = PathIndex::of(&sensor.scene().paths)
        .filter(|&index| sensor.scene().paths[index].detector == detector)
        .collect();
    // Those that carry nothing come last, so that they shift no number. Paths that
    // agree in all of this are alike but for their fluctuation, and keep the
    // order of the file.
    indices.sort_by(|&a, &b| {
        let (a, b) = (&sensor.scene().paths[a], &sensor.scene().paths[b]);
        source_name(a)
            .cmp(source_name(b))
            .then((a.transmission <= 0.0).cmp(&(b.transmission <= 0.0)))
            .then(a.delay_ps.total_cmp(&b.delay_ps))
            .then(a.transmission.total_cmp(&b.transmission))
            .then(a.delay_rate().total_cmp(&b.delay_rate()))
    });
    let of_detector = number_of(&sensor.scene().detectors[detector].name);
    let mut place = 0;
    let mut before: Option<&str> = None;
    indices
        .into_iter()
        .map(|index| {
            let source = source_name(&sensor.scene().paths[index]);
            place = if before == Some(source) { place + 1 } else { 0 };
            before = Some(source);
            NumberedPath { index, number: scatter(scatter(of_detector, number_of(source)), place) }
        })
        .collect()
}

/// A number for a name, as good as random.
pub fn number_of(name: &str) -> u64 {
    name.bytes().map(u64::from).fold(name.len() as u64, scatter)
}

#[cfg(test)]
mod tests {
    use std::path::Path as FilePath;

    use super::*;
    use crate::scene::SourceIndex;
    use crate::scene::{self, Scene};

    fn scene() -> Scene {
        let file = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/multipath.toml");
        scene::load(&file).expect("the scene is sound")
    }

    #[test]
    fn numbers_follow_the_path_and_not_its_place_in_the_file() {
        let forwards = scene();
        let mut backwards = forwards.clone();
        backwards.paths.reverse();
        let last = forwards.paths.len() - 1;
        let there = paths_to(&Sensor::new(&forwards), DetectorIndex(0));
        let back: Vec<NumberedPath> = paths_to(&Sensor::new(&backwards), DetectorIndex(0))
            .into_iter()
            .map(|path| NumberedPath { index: PathIndex(last - path.index.0), ..path })
            .collect();
        assert!(there.len() > 1);
        assert_eq!(there, back);
        assert_ne!(there[0].number, there[1].number);
    }

    #[test]
    fn another_source_does_not_change_the_numbers() {
        let alone = scene();
        let mut with_another = alone.clone();
        let mut another = alone.sources[0].clone();
        another.name = "a-source-that-comes-first".to_owned();
        with_another.sources.push(another);
        let mut path = alone.paths[0].clone();
        path.source = SourceIndex(1);
        with_another.paths.insert(0, path);
        let numbers = |scene: &Scene| -> Vec<u64> {
            paths_to(&Sensor::new(scene), DetectorIndex(0)).iter().map(|path| path.number).collect()
        };
        assert_eq!(numbers(&with_another)[1..], numbers(&alone));
    }
}
