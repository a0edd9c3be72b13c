//! What every pixel sees.

use rand::Rng as _;
use rand::SeedableRng as _;
use rand_xoshiro::SplitMix64;
use rayon::prelude::*;

use super::{Map, PIXEL};
use crate::estimate::unwrap::fold;
use crate::light::photon_rate_hz;
use crate::scene::{Array, PixelLight};
use crate::sensor::Sensor;

/// A target that is a map, in place of the scene's surfaces: each point faces its pixel.
#[derive(Debug, Clone, PartialEq)]
pub struct MapTarget {
    /// Depth along the axis, in metres, row by row; nothing is there where it is not a number above 0.
    pub depth_m: Vec<f64>,
    /// Share of the light that comes back, 0 to 1.
    pub reflectance: Vec<f64>,
}

/// Each pixel's light, row by row.
#[derive(Debug, Clone)]
pub struct Seen {
    /// Pixels of a row.
    pub columns: u32,
    /// The light.
    pub lights: Vec<PixelLight>,
    /// Primary rate of the own source's first path in each pixel, at the detector; 0 in a pixel
    /// that gets none.
    pub own_primary_hz: Vec<f64>,
}

impl Seen {
    /// What an array sees of a target, or of the scene's surfaces.
    pub fn of(sensor: &Sensor, array: &Array, target: Option<&MapTarget>) -> Seen {
        let lens = &array.lens;
        let pixel_light = |pixel: usize| {
            let [row, column] = lens.place(pixel);
            match target {
                None => array.pixel(row, column),
                Some(map) => match (map.depth_m[pixel], map.reflectance[pixel]) {
                    (depth_m, share) if depth_m.is_finite() && depth_m > 0.0 => {
                        array.pixel_at(row, column, depth_m, share)
                    }
                    _ => PixelLight {
                        ray: lens.ray(row, column),
                        paths: Vec::new(),
                        distances_m: Vec::new(),
                        background_rate_cps: array.has_background().then_some(0.0),
                    },
                },
            }
        };
        let scene = sensor.scene();
        let of_lasers_that_shine = |pixel: usize| {
            let mut light = pixel_light(pixel);
            light.paths.retain(|path| scene.sources[path.source].emits());
            light
        };
        let pixels = (0..lens.pixels()).into_par_iter();
        let lights: Vec<PixelLight> = pixels.map(of_lasers_that_shine).collect();
        let spad = &scene.detectors[PIXEL];
        let source = &scene.sources[spad.reference];
        let emitted_hz = photon_rate_hz(source.mean_power_w, source.wavelength_nm);
        let own_primary_hz = |light: &PixelLight| {
            let own = light.paths.iter().find(|path| path.source == spad.reference);
            let share = own.map_or(0.0, |path| path.transmission);
            emitted_hz * share * spad.photon_detection_probability
        };
        let own_primary_hz = lights.iter().map(own_primary_hz).collect();
        Seen { columns: lens.columns, lights, own_primary_hz }
    }

    /// Pixels that get light of their own source.
    pub fn lit(&self) -> impl Iterator<Item = usize> + '_ {
        let lit = self.own_primary_hz.iter().enumerate().filter(|(_, rate)| **rate > 0.0);
        lit.map(|(pixel, _)| pixel)
    }

    /// How many pixels have several paths.
    pub fn with_several_paths(&self) -> usize {
        self.lit().filter(|&pixel| self.lights[pixel].paths.len() > 1).count()
    }

    /// The sensor of a pixel.
    pub fn sensor(&self, of_all: &Sensor, pixel: usize) -> Sensor {
        Sensor::new(&of_all.scene().of_pixel(&self.lights[pixel]))
    }

    /// A map of a number of every pixel.
    pub fn map(&self, value: impl Fn(usize) -> f64) -> Map {
        Map::new(self.columns, (0..self.lights.len()).map(value).collect())
    }

    /// Distance of a pixel's first surface; NaN where it sees none.
    pub fn true_distance_m(&self, pixel: usize) -> f64 {
        self.lights[pixel].distances_m.first().copied().unwrap_or(f64::NAN)
    }

    /// What a measured distance is off by, of the surfaces that a pixel sees the nearest to it.
    pub fn error_m(&self, pixel: usize, distance_m: f64, range_m: f64) -> Option<f64> {
        let errors = self.lights[pixel].distances_m.iter().map(|m| fold(distance_m - m, range_m));
        errors.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// Depth of that surface, along the axis.
    pub fn true_depth_m(&self, pixel: usize) -> f64 {
        self.true_distance_m(pixel) * self.lights[pixel].depth_per_distance()
    }
}

/// The seed of a pixel's random numbers.
pub(super) fn seed_of(seed: u64, pixel: usize) -> u64 {
    let of_image = SplitMix64::seed_from_u64(seed).next_u64();
    SplitMix64::seed_from_u64(of_image.wrapping_add(pixel as u64)).next_u64()
}
