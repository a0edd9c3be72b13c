//! An image in numbers: the JSON of `goldtof image`.

use serde::Serialize;

use super::{Check, ExpectedPixel, Image, Map, PixelReport, ScanMaps, TableInterpolation};
use crate::scene::EstimatorKind;
use crate::simulate::Tier;

/// What `goldtof image` tells of an image.
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct ImageReport {
    /// The scene's name.
    #[serde(skip)]
    pub scene: String,
    /// Rows of pixels.
    pub rows: u32,
    /// Pixels of a row.
    pub columns: u32,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Where the pixels' errors come from.
    pub fidelity: Tier,
    /// How distances were got from counts.
    pub estimator: EstimatorKind,
    /// Frames of the array; one that is drawn where they come from theory.
    pub frames: u32,
    /// Pixels that get light of their own laser.
    pub lit_pixels: usize,
    /// How theory was interpolated; none where pixels have several paths.
    pub interpolation: Option<TableInterpolation>,
    /// Pixels simulated photon by photon beside theory.
    pub check: Option<Check>,
    /// Pixels that were asked for.
    pub pixels: Vec<PixelReport>,
    /// The maps, each a NPY file and a picture.
    pub maps: Vec<MapSummary>,
    /// What there is to say.
    pub remarks: Vec<String>,
}

/// A map in numbers.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct MapSummary {
    /// Its files are NAME.npy and NAME.png; the name ends in the unit.
    pub map: &'static str,
    /// What it shows.
    pub meaning: &'static str,
    /// Pixels that have a number.
    pub known_pixels: usize,
    /// The number that one of a hundred pixels is below, in the map's unit.
    pub low: Option<f64>,
    /// That half of them are below.
    pub median: Option<f64>,
    /// That one of a hundred is above.
    pub high: Option<f64>,
}

/// How a map is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapScale {
    /// From the least to the most.
    Range,
    /// As much below zero as above.
    Signed,
    /// A share, 0 to 1.
    Share,
    /// By orders of magnitude.
    Logarithmic,
}

/// A map with its name.
#[derive(Debug, Clone)]
pub struct NamedMap {
    /// Name of its files.
    pub name: &'static str,
    /// What it shows.
    pub meaning: &'static str,
    /// How.
    pub scale: MapScale,
    /// The numbers.
    pub map: Map,
}

impl Image {
    /// All of its maps.
    pub fn maps(&self) -> Vec<NamedMap> {
        use MapScale::{Logarithmic, Range, Share, Signed};
        let seen = &self.seen;
        let along = |map: &Map| {
            seen.map(|pixel| map.values[pixel] * seen.lights[pixel].depth_per_distance())
        };
        let mut maps = Vec::new();
        let mut add = |name, meaning, scale, map: Option<&Map>| {
            maps.extend(map.map(|map| NamedMap { name, meaning, scale, map: map.clone() }));
        };
        let ScanMaps { distance_m, error_m, bias_m, std_m, found_fraction, .. } = &self.measured;
        add("depth_m", "measured depth, along the axis", Range, Some(&along(distance_m)));
        add("true_depth_m", "true depth", Range, Some(&seen.map(|p| seen.true_depth_m(p))));
        add("error_m", "measured less true distance", Signed, Some(error_m));
        let is_drawn = self.options.fidelity == Tier::Expected;
        let if_known = |map| (is_drawn || self.measured.frames > 1).then_some(map);
        add("bias_m", "mean error of the distance", Signed, if_known(bias_m));
        add("std_m", "standard deviation of the distance", Logarithmic, if_known(std_m));
        if let (false, Some(theory)) = (is_drawn, &self.theory) {
            let map = |value: fn(&ExpectedPixel) -> f64| theory.map(seen.columns, value);
            let (bias_m, std_m) = (map(|e| e.bias_m), map(|e| e.std_m));
            add("expected_bias_m", "mean error that theory expects", Signed, Some(&bias_m));
            let meaning = "standard deviation that theory expects";
            add("expected_std_m", meaning, Logarithmic, Some(&std_m));
        }
        add(
            "confidence",
            "share of frames that find the pixel's path",
            Share,
            Some(found_fraction),
        );
        let rate_cps = &self.measured.detected_rate_cps;
        add("intensity_cps", "detections per second", Logarithmic, Some(rate_cps));
        let second = self.measured.second_distance_m.as_ref().map(along);
        add("second_depth_m", "measured depth of the second path", Range, second.as_ref());
        let untold = self.measured.untold_fraction.as_ref();
        add("untold", "share of frames that do not tell all paths apart", Share, untold);
        maps
    }

    /// The image in numbers.
    pub fn report(&self, scene: &str, estimator: EstimatorKind) -> ImageReport {
        let summary = |named: NamedMap| MapSummary {
            map: named.name,
            meaning: named.meaning,
            known_pixels: named.map.known().count(),
            low: named.map.quantile(0.01),
            median: named.map.quantile(0.5),
            high: named.map.quantile(0.99),
        };
        ImageReport {
            scene: scene.to_owned(),
            rows: self.lens.rows,
            columns: self.lens.columns,
            seed: self.options.seed,
            fidelity: self.options.fidelity,
            estimator,
            frames: self.measured.frames,
            lit_pixels: self.seen.lit().count(),
            interpolation: self.theory.as_ref().map(|theory| theory.interpolation.clone()),
            check: self.check.clone(),
            pixels: self.pixels.clone(),
            maps: self.maps().into_iter().map(summary).collect(),
            remarks: self.remarks.clone(),
        }
    }
}
