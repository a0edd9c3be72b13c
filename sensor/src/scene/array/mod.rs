//! Table `[array]`: the pixels behind a lens, and the room that they look at.
//!
//! Axes: x to the right, y down, z along the optical axis, away from the lens, which is at the
//! origin. Row 0 is the uppermost, column 0 the leftmost of what is seen. Distances are measured
//! along a pixel's ray (radial); the depth of a point is its z.

mod light;
mod surface;

use std::sync::Arc;

use self::light::Lit;
pub use self::light::{PixelLight, PixelPath};
pub use self::surface::Hit;
use self::surface::Surface;
use super::budget::{self, Receiver};
use super::declare::*;
use super::detector::DETECTOR;
use super::names::TableNames;
use super::{Detector, Scene, Source};
use crate::light::photon_rate_hz;

/// Most pixels of an array.
pub const MAX_PIXELS: u32 = 1 << 20;
/// Most planes that let light through: a ray has paths to no more than one surface more.
pub(super) const MAX_PANES: usize = 3;

/// An angle by which something is turned.
pub(super) const TURN: KeyKind = quantity(Quantity::Angle, "-180 deg", "180 deg");
/// A coordinate of something in the room.
pub(super) const PLACE: KeyKind = quantity(Quantity::Distance, "-100 km", "100 km");

tables! {
    /// Pixels behind a lens.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Lens {}
    of ARRAY = "array" {
        rows => rows: u32 = integer(1, 4096), Needed, "192";
            "rows of pixels, counted from the top of what is seen"
            "with `columns` no more than 1,048,576 pixels, whose maps are kept in memory";
        columns => columns: u32 = integer(1, 4096), Needed, "256";
            "pixels of a row, counted from the left of what is seen"
            "as for `rows`";
        pitch => pitch_m: f64 = quantity(Distance, "100 nm", "100 mm"), Needed, "12 um";
            "from pixel to pixel, in either direction"
            "from below the wavelength to a detector of its own in each pixel";
        focal_length => focal_length_m: f64 = quantity(Distance, "10 um", "100 m"), Needed, "3 mm";
            "of the lens, which images without distortion (a pinhole's geometry)"
            "from microlenses to the longest telescopes";
        f_number => f_number: f64 = number(0.1, 1000.0), Needed, "1.4";
            "focal length over the diameter of the aperture"
            "no lens reaches below 0.5 in air";
        optics => optics: f64 = number(0.0, 1.0), Or("1"), "0.7";
            "transmission of lenses and filter at the source's wavelength"
            "a share";
        fill_factor => fill_factor: f64 = number(0.0, 1.0), Or("1"), "0.3";
            "share of the pixel's area that detects"
            "a share";
        row = integer(0, 4095), Otherwise("the middle one"), "96";
            "row of the pixel whose sensor commands other than `image` take"
            "less than `rows`";
        column = integer(0, 4095), Otherwise("the middle one"), "128";
            "column of that pixel"
            "less than `columns`";
        background = table("array.background"),
            Otherwise("none: every pixel has the detector's background"),
            "{ illuminance = \"1 klux\", filter_width = \"10 nm\" }";
            "light on all surfaces from no laser, each pixel's by its reflectance and place";
        plane = table("array.plane"), Otherwise("none"), "{ z = \"3 m\", reflectance = 0.5 }";
            "list of flat surfaces of the room";
        sphere = table("array.sphere"), Otherwise("none"),
            "{ z = \"2 m\", radius = \"30 cm\", reflectance = 0.5 }";
            "list of spheres in the room";
        light = table("array.light"),
            Otherwise("the detector's source, at the lens, and no other"),
            "{ source = \"laser\" }";
            "list of the lasers in the room: where each is, and what it lights";
    }

    AMBIENT = "array.background" and SUNLIGHT {}

    LIGHT = "array.light" and POSE {
        source = words("the name of a source", Form::Text), Needed, "\"laser\"";
            "whose light it is; all of its power goes into the angles below, as evenly as on a wall \
             that it faces";
        horizontal = quantity(Angle, "1e-3 urad", "3 rad"), Otherwise("that of the array"), "60 deg";
            "full angle that it lights from left to right"
            "lenses look forwards";
        vertical = quantity(Angle, "1e-3 urad", "3 rad"), Otherwise("that of the array"), "45 deg";
            "full angle that it lights from top to bottom"
            "as for `horizontal`";
    }

    /// Where something in the room is.
    #[derive(Debug, Clone, Copy, PartialEq)]
    pub struct Pose {}
    of POSE = "" {
        x => x_m: f64 = PLACE, Or("0 m"), "0.5 m";
            "place to the right of the lens"
            "doubles keep a tenth of a nanometre there";
        y => y_m: f64 = PLACE, Or("0 m"), "0.2 m";
            "place below the lens"
            "as for `x`";
        z => z_m: f64 = PLACE, Or("0 m"), "3 m";
            "place in front of the lens, along its axis"
            "as for `x`";
        turned => turned_rad: f64 = TURN, Or("0 deg: it looks along the axis, or faces the lens"), "20 deg";
            "by how much it looks to the right; of a plane, by how much its right edge comes nearer"
            "half a turn either way";
        tilted => tilted_rad: f64 = TURN, Or("0 deg"), "-10 deg";
            "by how much it looks up; of a plane, by how much its lower edge tilts away"
            "as for `turned`";
    }
}

pub(super) use super::budget::SUNLIGHT;
pub(super) use surface::{PLANE, SPHERE};

/// An array of pixels, each a sensor like the scene's, and the room that it looks at.
#[derive(Debug, Clone)]
pub struct Array {
    /// Pixels and lens.
    pub lens: Lens,
    /// Row of the pixel that the scene's paths are those of.
    pub row: u32,
    /// Its column.
    pub column: u32,
    surfaces: Vec<Surface>,
    lights: Vec<Lit>,
    /// Light on every surface within the filter, in W / m^2, and its photons' wavelength in nm.
    background: Option<(f64, f64)>,
}

impl Array {
    /// What a pixel gets from the scene's surfaces.
    pub fn pixel(&self, row: u32, column: u32) -> PixelLight {
        let hits = surface::hits(&self.surfaces, self.lens.ray(row, column));
        self.of_hits(row, column, &hits, &self.surfaces)
    }

    /// What a pixel gets from a surface at a depth (along the axis) that faces it, in place of the
    /// scene's surfaces: a point of a depth map. Nothing throws a shadow.
    pub fn pixel_at(&self, row: u32, column: u32, depth_m: f64, reflectance: f64) -> PixelLight {
        let hit = Hit::facing(self.lens.ray(row, column), depth_m, reflectance);
        self.of_hits(row, column, &[hit], &[])
    }

    /// Whether each pixel's background follows from what it sees.
    pub fn has_background(&self) -> bool {
        self.background.is_some()
    }

    fn of_hits(&self, row: u32, column: u32, hits: &[Hit], shadows: &[Surface]) -> PixelLight {
        let paths = self.lights.iter().flat_map(|light| {
            let share = |hit: &Hit| light.path(&self.lens, [row, column], hit, shadows);
            hits.iter().map(share).filter(|path| path.transmission > 0.0).collect::<Vec<_>>()
        });
        let background = self.background.map(|(irradiance, wavelength_nm)| {
            let power_w = |hit: &Hit| {
                let receiver = Receiver { reflectance: hit.reflectance, ..self.lens.receiver() };
                hit.through * receiver.power_w(irradiance, self.lens.projected_share(row, column))
            };
            photon_rate_hz(hits.iter().map(power_w).sum(), wavelength_nm)
        });
        PixelLight {
            ray: self.lens.ray(row, column),
            paths: paths.collect(),
            distances_m: hits.iter().map(|hit| hit.distance_m).collect(),
            background_rate_cps: background,
        }
    }
}

impl Scene {
    /// The scene of a pixel's sensor, with the light that it gets.
    pub fn of_pixel(&self, light: &PixelLight) -> Scene {
        let mut scene = self.clone();
        scene.take_pixel(light);
        scene
    }

    fn take_pixel(&mut self, light: &PixelLight) {
        self.paths = light.paths.iter().map(PixelPath::path).collect();
        if let Some(rate_cps) = light.background_rate_cps {
            self.detectors[0].background_rate_cps = rate_cps;
        }
    }

    /// The scene with its array's pixel in place of paths.
    pub(super) fn with_array(mut self, array: Option<Array>) -> Scene {
        if let Some(array) = array {
            self.take_pixel(&array.pixel(array.row, array.column));
            self.array = Some(Arc::new(array));
        }
        self
    }
}

/// Reads `[array]`, if there is one; of the scene's other tables it needs the sources, and its
/// only detector.
pub(super) fn read(
    root: &Section,
    names: &TableNames,
    sources: Option<&[Source]>,
    detectors: Option<&[Detector]>,
) -> Option<Option<Array>> {
    let Some(section) = root.table("array") else {
        // One that is not a table has been complained about.
        return root.get("array").is_none().then_some(None);
    };
    check_others(root, &section, detectors);
    let own = detectors.and_then(<[Detector]>::first).map(|detector| detector.reference.0);
    let wavelength_nm = sources.zip(own).map(|(sources, own)| sources[own].wavelength_nm);
    let lens = Lens::read(&section);
    let middle = |pixels: u32| pixels / 2;
    let row = pixel(&section, "row", lens.as_ref().map(|lens| lens.rows), middle);
    let column = pixel(&section, "column", lens.as_ref().map(|lens| lens.columns), middle);
    let background = read_background(root, &section, lens.as_ref(), wavelength_nm);
    let planes = section.all("plane", surface::read_plane);
    let spheres = section.all("sphere", surface::read_sphere);
    let lights = section.all("light", |light| light::read(light, names, lens.as_ref()));
    let panes = planes.iter().flatten().filter(|plane| plane.transmission > 0.0);
    if panes.count() > MAX_PANES {
        let message = format!(
            "more than {MAX_PANES} planes let light through; every ray would have a path to each of \
             them; give some of them transmission = 0"
        );
        section.report("plane", &message);
    }
    section.finish();
    let (lens, mut lights) = (lens?, lights?);
    if let Some(own) = own.filter(|own| !lights.iter().any(|light| light.is_of(*own))) {
        lights.insert(0, Lit::at_lens(own, &lens));
    }
    let surfaces = planes?.into_iter().map(Surface::Plane);
    Some(Some(Array {
        row: row?,
        column: column?,
        surfaces: surfaces.chain(spheres?.into_iter().map(Surface::Sphere)).collect(),
        lights,
        background: background?,
        lens,
    }))
}

/// What a scene with an array has no more of.
fn check_others(root: &Section, section: &Section, detectors: Option<&[Detector]>) {
    if root.get("path").is_some() {
        let message = "the paths of a scene with [array] follow from what its pixels see; leave out \
                       [[path]], or [array]";
        root.report("path", message);
    }
    if detectors.is_some_and(|detectors| detectors.len() > 1) {
        section.complain(
            "every pixel is a sensor like the scene's one [[detector]], and there are several; leave \
             one of them",
        );
    }
}

/// Row or column of the pixel that other commands take.
fn pixel(
    section: &Section,
    key: &'static str,
    pixels: Option<u32>,
    middle: impl Fn(u32) -> u32,
) -> Option<u32> {
    let given = section.get(key).is_some();
    let number: Option<u32> = section.count(key);
    let pixels = pixels?;
    match number {
        Some(number) if number >= pixels => {
            let message = format!("the array has {key}s 0 to {}; {number} is none", pixels - 1);
            section.report(key, &message);
            None
        }
        None if !given => Some(middle(pixels)),
        number => number,
    }
}

/// The light on all surfaces; the outer `None` if it is wrong.
fn read_background(
    root: &Section,
    array: &Section,
    lens: Option<&Lens>,
    wavelength_nm: Option<f64>,
) -> Option<Option<(f64, f64)>> {
    let Some(section) = array.section("background") else {
        return array.get("background").is_none().then_some(None);
    };
    let given = |detector: &Section| {
        ["background", "background_rate"].into_iter().find(|key| detector.get(key).is_some())
    };
    for detector in root.sections("detector", 1) {
        if let Some(key) = given(&detector) {
            let message =
                "every pixel's background follows from array.background; leave one of them out";
            detector.report(key, message);
        }
    }
    let irradiance = budget::read_irradiance(&section, wavelength_nm);
    section.finish();
    let (irradiance, wavelength_nm, lens) = (irradiance?, wavelength_nm?, lens?);
    let [row, column] = [lens.rows / 2, lens.columns / 2];
    let receiver = Receiver { reflectance: 1.0, ..lens.receiver() };
    let power_w = receiver.power_w(irradiance, lens.projected_share(row, column));
    let limit = DETECTOR.key("background_rate");
    budget::check_background(array, limit, photon_rate_hz(power_w, wavelength_nm))?;
    Some(Some((irradiance, wavelength_nm)))
}

#[cfg(test)]
mod tests;
