//! How much of the lasers' light comes back to a pixel.
//!
//! A laser lights a rectangle of angles as evenly as a wall that it faces: power P over the area
//! A = 4 tan(h / 2) tan(v / 2) of that wall at unit distance, so that a surface at distance d,
//! off the laser's axis by theta_l and lit at an angle a_l to its normal, has the irradiance
//! P cos(a_l) / (A cos^3(theta_l) d^2). A pixel of pitch p behind a lens of focal length f sees
//! R^2 (p / f)^2 cos^3(theta) / cos(a) of a surface at distance R, and of what that reflects the
//! aperture takes in the budget's share ([`Receiver::collected`]) times cos(a) cos(theta). With
//! the laser at the lens a wall that the array faces so comes out as cos^4(theta).

use super::surface::{Hit, Surface, Vector, dot, length, minus, passing};
use super::{Lens, MAX_PIXELS, Pose};
use crate::light::SPEED_OF_LIGHT_M_PER_S;
use crate::scene::budget::Receiver;
use crate::scene::declare::*;
use crate::scene::names::TableNames;
use crate::scene::{DetectorIndex, Path, SourceIndex};

/// Angles beyond a laser's edge that still count as lit: pixels at the array's own edge, rounded.
const EDGE: f64 = 1.0 + 1e-9;

/// What a pixel sees.
#[derive(Debug, Clone, PartialEq)]
pub struct PixelLight {
    /// Direction of its ray, one long along the axis: a depth times this is a point.
    pub ray: [f64; 3],
    /// Every way of light into it.
    pub paths: Vec<PixelPath>,
    /// From the lens to each surface that it sees, the nearest first.
    pub distances_m: Vec<f64>,
    /// Its background, in photons before the detection probability; none where the scene has one
    /// for all pixels.
    pub background_rate_cps: Option<f64>,
}

/// One way of light from a laser to a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PixelPath {
    /// Whose light it is.
    pub source: SourceIndex,
    /// Time from laser to pixel.
    pub delay_ps: f64,
    /// Share of the source's photons that arrive.
    pub transmission: f64,
}

impl PixelPath {
    pub(super) fn path(&self) -> Path {
        Path {
            source: self.source,
            detector: DetectorIndex(0),
            delay_ps: self.delay_ps,
            transmission: self.transmission,
            movement: None,
        }
    }
}

impl PixelLight {
    /// Share of a distance that is depth, along the optical axis.
    pub fn depth_per_distance(&self) -> f64 {
        1.0 / length(self.ray)
    }
}

impl Lens {
    pub(super) fn read(section: &Section) -> Option<Lens> {
        let lens = Lens::keys(section)?;
        let (rows, columns) = (lens.rows, lens.columns);
        if rows * columns > MAX_PIXELS {
            let message = format!(
                "{rows} rows of {columns} pixels are more than {MAX_PIXELS} pixels; use fewer of one"
            );
            section.report("rows", &message);
            return None;
        }
        Some(lens)
    }

    /// Number of pixels.
    pub fn pixels(&self) -> usize {
        self.rows as usize * self.columns as usize
    }

    /// Row and column of a pixel, counted row by row.
    pub fn place(&self, pixel: usize) -> [u32; 2] {
        let columns = self.columns as usize;
        [(pixel / columns) as u32, (pixel % columns) as u32]
    }

    /// Direction of the ray through a pixel's middle, one long along the axis.
    pub fn ray(&self, row: u32, column: u32) -> [f64; 3] {
        let tangent = self.pitch_m / self.focal_length_m;
        let off = |pixel: u32, pixels: u32| f64::from(pixel) + 0.5 - 0.5 * f64::from(pixels);
        [tangent * off(column, self.columns), tangent * off(row, self.rows), 1.0]
    }

    /// Tangents of half the angles that the array sees, from left to right and from top to
    /// bottom.
    pub(super) fn half_tangents(&self) -> [f64; 2] {
        let half = 0.5 * self.pitch_m / self.focal_length_m;
        [half * f64::from(self.columns), half * f64::from(self.rows)]
    }

    /// Area of a pixel on a wall at unit distance.
    fn pixel_area(&self) -> f64 {
        (self.pitch_m / self.focal_length_m).powi(2)
    }

    /// Share of the hemisphere in front of the aperture that a pixel sees, projected onto it.
    pub(super) fn projected_share(&self, row: u32, column: u32) -> f64 {
        let cosine = 1.0 / length(self.ray(row, column));
        self.pixel_area() * cosine.powi(4) / std::f64::consts::PI
    }

    /// What takes in light, of a target that reflects all of it.
    pub(super) fn receiver(&self) -> Receiver {
        Receiver {
            reflectance: 1.0,
            aperture_m: self.focal_length_m / self.f_number,
            optics: self.optics,
            fill_factor: self.fill_factor,
        }
    }
}

/// A laser in the room.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lit {
    source: usize,
    place: Vector,
    axes: [Vector; 3],
    half_tangents: [f64; 2],
}

/// Reads one.
pub(super) fn read(section: Section, names: &TableNames, lens: Option<&Lens>) -> Option<Lit> {
    let source = names.resolve(&section, "source");
    let pose = Pose::keys(&section);
    let angles = ["horizontal", "vertical"].map(|key| {
        let half = section.quantity(key).map(|angle| (0.5 * angle).tan());
        (section.get(key).is_some(), half)
    });
    section.finish();
    let (pose, lens) = (pose?, lens?);
    let [across, down] = lens.half_tangents();
    let or = |(given, half): (bool, Option<f64>), lens: f64| if given { half } else { Some(lens) };
    Some(Lit {
        source: source?,
        place: pose.place(),
        axes: pose.axes(),
        half_tangents: [or(angles[0], across)?, or(angles[1], down)?],
    })
}

impl Lit {
    /// The light of a source at the lens, of all that the array sees.
    pub fn at_lens(source: usize, lens: &Lens) -> Lit {
        let axes = Pose::default().axes();
        Lit { source, place: [0.0; 3], axes, half_tangents: lens.half_tangents() }
    }

    /// Whether it is that source's.
    pub fn is_of(&self, source: usize) -> bool {
        self.source == source
    }

    /// Its light off a point that a pixel sees, and past what stands in between.
    pub fn path(
        &self,
        lens: &Lens,
        [row, column]: [u32; 2],
        hit: &Hit,
        shadows: &[Surface],
    ) -> PixelPath {
        let to_point = minus(hit.point, self.place);
        let way_m = length(to_point);
        let delay_ps = (way_m + hit.distance_m) / SPEED_OF_LIGHT_M_PER_S * 1e12;
        let transmission = match self.irradiance_per_w(hit, to_point) {
            0.0 => 0.0,
            irradiance_per_w => {
                let cosine = 1.0 / length(lens.ray(row, column));
                let receiver = Receiver { reflectance: hit.reflectance, ..lens.receiver() };
                // The pixel's area on the surface times cos(a), which the aperture sees of it.
                let area = hit.distance_m.powi(2) * lens.pixel_area() * cosine.powi(3);
                let collected = receiver.collected(hit.distance_m) * cosine;
                irradiance_per_w
                    * area
                    * collected
                    * hit.through
                    * passing(shadows, self.place, hit.point)
            }
        };
        PixelPath {
            source: SourceIndex(self.source),
            delay_ps,
            transmission: transmission.min(1.0),
        }
    }

    /// Irradiance of a surface at a point, of a watt, per square metre.
    fn irradiance_per_w(&self, hit: &Hit, to_point: Vector) -> f64 {
        let [right, down, forward] = self.axes;
        let along = dot(to_point, forward);
        let is_lit = along > 0.0
            && dot(to_point, right).abs() <= along * self.half_tangents[0] * EDGE
            && dot(to_point, down).abs() <= along * self.half_tangents[1] * EDGE;
        let way_m = length(to_point);
        let incidence = -dot(to_point, hit.normal) / way_m;
        if !is_lit || incidence <= 0.0 {
            return 0.0;
        }
        let area = 4.0 * self.half_tangents[0] * self.half_tangents[1];
        incidence / (area * (along / way_m).powi(3) * way_m * way_m)
    }
}
