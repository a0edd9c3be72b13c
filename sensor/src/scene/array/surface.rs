//! What a pixel's ray meets.

use super::{PLACE, POSE, Pose};
use crate::scene::declare::*;

/// Surfaces nearer than this to where a ray begins or ends are that place itself.
const SAME_M: f64 = 1e-9;
/// What is farther off, of surfaces without end, is not seen: delays are as precise as those of paths.
const FARTHEST_M: f64 = 1e9;

/// A place or a direction, in metres: to the right, down, away from the lens.
pub(super) type Vector = [f64; 3];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn times(factor: f64, a: Vector) -> Vector {
    a.map(|coordinate| factor * coordinate)
}

pub(super) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

tables! {
    /// A flat surface: its middle, and how it is turned.
    #[derive(Debug, Clone, Copy)]
    pub struct Plane {
        /// Where its middle is.
        pose: Option<Pose>,
        /// Full width and height in metres.
        size_m: [f64; 2],
    }
    of PLANE = "array.plane" and POSE {
        width = quantity(Distance, "1 um", "100 km"), Otherwise("without end"), "1 m";
            "from its left to its right edge, its place in the middle"
            "as far as places";
        height = quantity(Distance, "1 um", "100 km"), Otherwise("without end"), "1 m";
            "from its upper to its lower edge"
            "as far as places";
        reflectance => reflectance: f64 = number(0.0, 1.0), Needed, "0.5";
            "share of the light that it sends back, in all directions (Lambertian)"
            "a share";
        transmission => transmission: f64 = number(0.0, 1.0), Or("0"), "0.5";
            "share of the light that goes straight through, each way"
            "with `reflectance` no more than 1";
    }

    /// A sphere, seen from outside.
    #[derive(Debug, Clone, Copy)]
    pub struct Sphere {}
    of SPHERE = "array.sphere" {
        x => x_m: f64 = PLACE, Or("0 m"), "0.5 m";
            "middle, to the right of the lens"
            "doubles keep a tenth of a nanometre there";
        y => y_m: f64 = PLACE, Or("0 m"), "0.2 m";
            "middle, below the lens"
            "as for `x`";
        z => z_m: f64 = PLACE, Needed, "2 m";
            "middle, in front of the lens"
            "as for `x`";
        radius => radius_m: f64 = quantity(Distance, "1 um", "100 km"), Needed, "30 cm";
            "its radius; the lens is outside of it"
            "as far as places";
        reflectance => reflectance: f64 = number(0.0, 1.0), Needed, "0.5";
            "share of the light that it sends back, in all directions (Lambertian)"
            "a share";
    }
}

/// Reads a plane.
pub(super) fn read_plane(section: Section) -> Option<Plane> {
    let keys = Plane::keys(&section);
    let pose = Pose::keys(&section);
    let side = |key: &'static str| {
        let side = section.quantity(key);
        side.or_else(|| section.get(key).is_none().then_some(f64::INFINITY))
    };
    let size = (side("width"), side("height"));
    if let Some(keys) = &keys
        && keys.reflectance + keys.transmission > 1.0
    {
        let message = format!(
            "with the reflectance that is {}: more light than falls on it; the two are 1 at most",
            keys.reflectance + keys.transmission
        );
        section.report("transmission", &message);
    }
    section.finish();
    Some(Plane { pose: Some(pose?), size_m: [size.0?, size.1?], ..keys? })
}

/// Reads a sphere.
pub(super) fn read_sphere(section: Section) -> Option<Sphere> {
    let sphere = Sphere::keys(&section);
    if let Some(sphere) = &sphere
        && length(sphere.middle()) <= sphere.radius_m
    {
        section.report("radius", "the lens would be inside of it; take a smaller one, or move it");
    }
    section.finish();
    sphere
}

impl Pose {
    /// Where it is.
    pub(super) fn place(&self) -> Vector {
        [self.x_m, self.y_m, self.z_m]
    }

    /// Unit vectors to its right, down, and to where it looks; a plane faces the other way.
    pub(super) fn axes(&self) -> [Vector; 3] {
        let ((sin_t, cos_t), (sin_p, cos_p)) =
            (self.turned_rad.sin_cos(), self.tilted_rad.sin_cos());
        let forward = [sin_t * cos_p, -sin_p, cos_t * cos_p];
        let down = [sin_t * sin_p, cos_p, cos_t * sin_p];
        [[cos_t, 0.0, -sin_t], down, forward]
    }
}

impl Sphere {
    fn middle(&self) -> Vector {
        [self.x_m, self.y_m, self.z_m]
    }
}

/// Something in the room.
#[derive(Debug, Clone, Copy)]
pub(super) enum Surface {
    Plane(Plane),
    Sphere(Sphere),
}

/// A point of a surface that a pixel sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Where it is.
    pub(super) point: Vector,
    /// Unit vector across the surface, to the lens's side.
    pub(super) normal: Vector,
    /// From the lens.
    pub distance_m: f64,
    /// Share of the light that the surface sends back.
    pub reflectance: f64,
    /// Share of the light that comes to it, or from it, through what stands in front.
    pub through: f64,
}

impl Hit {
    /// A point at a depth, of a surface that faces the pixel whose ray is given.
    pub(super) fn facing(ray: Vector, depth_m: f64, reflectance: f64) -> Hit {
        let point = times(depth_m, ray);
        let distance_m = length(point);
        let normal = times(-1.0 / length(ray), ray);
        Hit { point, normal, distance_m, reflectance, through: 1.0 }
    }
}

impl Surface {
    /// Where a ray meets it first, in lengths of `direction`, and the normal there.
    fn meets(&self, from: Vector, direction: Vector) -> Option<(f64, Vector)> {
        match self {
            Surface::Plane(plane) => {
                let pose = plane.pose?;
                let [right, down, forward] = pose.axes();
                let slope = dot(direction, forward);
                let at = dot(minus(pose.place(), from), forward) / slope;
                let point = minus(from, times(-at, direction));
                let beside = minus(point, pose.place());
                let within = 2.0 * dot(beside, right).abs() <= plane.size_m[0]
                    && 2.0 * dot(beside, down).abs() <= plane.size_m[1];
                let normal = times(-slope.signum(), forward);
                (slope.abs() > f64::EPSILON * length(direction) && within).then_some((at, normal))
            }
            Surface::Sphere(sphere) => {
                let middle = minus(sphere.middle(), from);
                let squared = dot(direction, direction);
                let along = dot(middle, direction) / squared;
                let beside = minus(middle, times(along, direction));
                let half = (sphere.radius_m.powi(2) - dot(beside, beside)) / squared;
                let at = along - half.max(0.0).sqrt();
                let point = minus(from, times(-at, direction));
                let normal = times(1.0 / sphere.radius_m, minus(point, sphere.middle()));
                (half > 0.0).then_some((at, normal))
            }
        }
    }

    fn reflectance(&self) -> f64 {
        match self {
            Surface::Plane(plane) => plane.reflectance,
            Surface::Sphere(sphere) => sphere.reflectance,
        }
    }

    fn transmission(&self) -> f64 {
        match self {
            Surface::Plane(plane) => plane.transmission,
            Surface::Sphere(_) => 0.0,
        }
    }
}

/// What a ray from the lens meets, the nearest first, as far as light comes.
pub(super) fn hits(surfaces: &[Surface], ray: Vector) -> Vec<Hit> {
    let met = |surface: &Surface| {
        let (at, normal) = surface.meets([0.0; 3], ray)?;
        let point = times(at, ray);
        let distance_m = length(point);
        let reflectance = surface.reflectance();
        (at > 0.0 && (SAME_M..FARTHEST_M).contains(&distance_m)).then_some((
            Hit { point, normal, distance_m, reflectance, through: 1.0 },
            surface.transmission(),
        ))
    };
    let mut met: Vec<(Hit, f64)> = surfaces.iter().filter_map(met).collect();
    met.sort_by(|(a, _), (b, _)| a.distance_m.total_cmp(&b.distance_m));
    let mut through = 1.0;
    let mut seen = Vec::new();
    for (hit, transmission) in met {
        seen.push(Hit { through, ..hit });
        through *= transmission;
        if through == 0.0 {
            break;
        }
    }
    seen
}

/// Share of the light that goes from one place to another past what stands between.
pub(super) fn passing(surfaces: &[Surface], from: Vector, to: Vector) -> f64 {
    let direction = minus(to, from);
    let same = SAME_M / length(direction);
    let between = |surface: &&Surface| {
        let met = surface.meets(from, direction);
        met.is_some_and(|(at, _)| at > same && at < 1.0 - same)
    };
    surfaces.iter().filter(between).map(Surface::transmission).product()
}
