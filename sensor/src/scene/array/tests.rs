//! Pixels of small arrays, against closed forms.

use super::*;
use crate::light::{SPEED_OF_LIGHT_M_PER_S, round_trip_ps};
use crate::scene::{PathIndex, SourceIndex, parse};

/// 9 x 11 pixels of 0.1 mm behind 1 mm: 48 degrees to either side.
const SCENE: &str = r#"
clock = { chip_period = "8 ns" }
scan = { integration = "20 us" }
[[source]]
name = "laser"
code = { family = "gold", degree = 5 }
wavelength = "940 nm"
mean_power = "1 W"
[[source]]
name = "other"
code = { family = "gold", degree = 5, index = 2 }
wavelength = "940 nm"
mean_power = "1 W"
[[detector]]
name = "spad"
reference = "laser"
[array]
rows = 9
columns = 11
pitch = "0.2 mm"
focal_length = "1 mm"
f_number = 2
optics = 0.5
fill_factor = 0.25
"#;

const WALL: &str = "[[array.plane]]\nz = \"3 m\"\nreflectance = 0.4\n";

fn scene(more: &str) -> Scene {
    parse("array.toml", &format!("{SCENE}{more}")).unwrap_or_else(|errors| panic!("{errors}"))
}

fn array(more: &str) -> Arc<Array> {
    scene(more).array.expect("there is one")
}

fn complaint(more: &str) -> String {
    parse("array.toml", &format!("{SCENE}{more}")).expect_err(more).to_string()
}

fn close(found: f64, expected: f64) {
    assert!((found / expected - 1.0).abs() < 1e-6, "{found} for {expected}");
}

/// A wall that is evenly lit and seen by a lens: the fourth power of the cosine, and on the axis
/// rho eta r^2 / R^2 of the pixel's share of the light.
#[test]
fn a_wall_falls_off_as_the_fourth_power_of_the_cosine() {
    let array = array(WALL);
    let middle = array.pixel(4, 5).paths[0].transmission;
    let radius_m: f64 = 0.25e-3;
    close(middle, 0.4 * 0.5 * 0.25 * (radius_m / 3.0).powi(2) / 99.0);
    for (row, column) in [(0, 0), (4, 0), (8, 10), (2, 7)] {
        let light = array.pixel(row, column);
        let (x, y) = (0.2 * (f64::from(column) - 5.0), 0.2 * (f64::from(row) - 4.0));
        let cosine = 1.0 / (1.0 + x * x + y * y).sqrt();
        close(light.paths[0].transmission, middle * cosine.powi(4));
        close(light.paths[0].delay_ps, round_trip_ps(3.0 / cosine));
        close(light.distances_m[0] * light.depth_per_distance(), 3.0);
        assert_eq!(light.background_rate_cps, None);
    }
}

/// What all pixels together get of a laser at the lens is all that falls on the wall, whatever
/// the wall's tilt: here seen by an aperture that is as bright from everywhere.
#[test]
fn light_that_falls_on_the_pixels_patches_is_that_of_the_laser() {
    for tilt in ["", "turned = \"30 deg\"\n", "tilted = \"-20 deg\"\nx = \"1 m\"\n"] {
        let array = array(&format!("{WALL}{tilt}"));
        let receiver = array.lens.receiver();
        let mut power = 0.0;
        for pixel in 0..array.lens.pixels() {
            let [row, column] = array.lens.place(pixel);
            let hit = surface::hits(&array.surfaces, array.lens.ray(row, column))[0];
            let cosines = surface::dot(hit.normal, hit.point).abs() / hit.distance_m
                * array.pixel(row, column).depth_per_distance();
            let share = Receiver { reflectance: 0.4, ..receiver }.collected(hit.distance_m);
            power += array.pixel(row, column).paths[0].transmission / share / cosines;
        }
        close(power, 1.0);
    }
}

/// A laser beside the lens, by the sum over fine patches of the wall that a pixel sees.
#[test]
fn a_laser_elsewhere_lights_what_it_sees() {
    let light = "[[array.light]]\nsource = \"other\"\nx = \"1 m\"\nz = \"0.5 m\"\n\
                 turned = \"-20 deg\"\nhorizontal = \"80 deg\"\nvertical = \"60 deg\"\n";
    let array = array(&format!("{WALL}{light}"));
    let (row, column): (u32, u32) = (3, 4);
    let seen = array.pixel(row, column);
    assert_eq!(seen.paths.len(), 2);
    let other = seen.paths.iter().find(|path| path.source == SourceIndex(1)).expect("it is lit");
    // The patch on the wall, and where it is from the laser, in the laser's own axes.
    let (width, turn) = (3.0 * 0.2, (-20.0_f64).to_radians());
    let (x, y) = (width * (f64::from(column) - 5.0), width * (f64::from(row) - 4.0));
    let (dx, dy, dz) = (x - 1.0, y, 2.5);
    let way = (dx * dx + dy * dy + dz * dz).sqrt();
    let along = dx * turn.sin() + dz * turn.cos();
    let tangents = 40.0_f64.to_radians().tan() * 30.0_f64.to_radians().tan();
    // Power per solid angle of a rectangle that a facing wall gets evenly.
    let intensity = 1.0 / (4.0 * tangents * (along / way).powi(3));
    let power = intensity * (dz / way) / (way * way) * width * width;
    let distance = (x * x + y * y + 9.0).sqrt();
    let cosine = 3.0 / distance;
    let collected = 0.4 * 0.5 * 0.25 * (0.25e-3 / distance).powi(2) * cosine * cosine;
    close(other.transmission, power * collected);
    close(other.delay_ps, (way + distance) / SPEED_OF_LIGHT_M_PER_S * 1e12);
    // It looks to the left, so that the right of the wall is dark.
    let dark = array.pixel(4, 10);
    assert!(dark.paths.iter().all(|path| path.source == SourceIndex(0)), "{dark:?}");
}

#[test]
fn a_sphere_hides_the_wall_and_throws_a_shadow() {
    let ball = "[[array.sphere]]\nz = \"2 m\"\nradius = \"30 cm\"\nreflectance = 0.9\n";
    let light = "[[array.light]]\nsource = \"other\"\nx = \"-2 m\"\nhorizontal = \"120 deg\"\n\
                 vertical = \"60 deg\"\n";
    let array = array(&format!("{WALL}{ball}{light}"));
    close(array.pixel(4, 5).distances_m[0], 1.7);
    assert_eq!(array.pixel(4, 5).distances_m.len(), 1);
    // From (-2, 0, 0) past the ball's middle to the wall at x = 1, z = 3: about column 7.
    let sources = |column| {
        let light = array.pixel(4, column);
        light.paths.iter().map(|path| path.source.0).collect::<Vec<_>>()
    };
    close(array.pixel(4, 7).distances_m[0] * array.pixel(4, 7).depth_per_distance(), 3.0);
    assert_eq!(sources(7), [0]);
    assert_eq!(sources(9), [0, 1]);
}

#[test]
fn a_pane_shows_itself_and_what_is_behind() {
    let pane = "[[array.plane]]\nz = \"1 m\"\nreflectance = 0.1\ntransmission = 0.8\n";
    let (through, alone) = (array(&format!("{WALL}{pane}")), array(WALL));
    let (seen, wall) = (through.pixel(4, 5), alone.pixel(4, 5));
    assert_eq!(seen.paths.len(), 2);
    close(seen.paths[0].delay_ps, round_trip_ps(1.0));
    close(seen.paths[1].transmission, 0.8 * 0.8 * wall.paths[0].transmission);
    close(seen.paths[0].transmission / wall.paths[0].transmission, 0.1 / 0.4 * 9.0);
    let edge = array(&format!("{WALL}{pane}width = \"0.5 m\"\n"));
    assert_eq!([edge.pixel(4, 6), edge.pixel(4, 7)].map(|light| light.paths.len()), [2, 1]);
}

/// Against the budget of a lone detector that sees as much.
#[test]
fn background_is_that_of_a_detector_with_the_pixels_view() {
    let ambient = "[array.background]\nirradiance = \"0.5 W/m2/nm\"\nfilter_width = \"10 nm\"\n";
    let array = array(&format!("{ambient}{WALL}"));
    // A cone of the pixel's projected solid angle: pi sin^2 (theta / 2) = 0.04.
    let angle_rad = 2.0 * (0.04 / std::f64::consts::PI).sqrt().asin();
    let lone = SCENE.split("[array]").next().unwrap_or_default().to_owned()
        + &format!(
            "background = {{ irradiance = \"0.5 W/m2/nm\", filter_width = \"10 nm\", reflectance = \
             0.4, aperture = \"0.5 mm\", optics = 0.5, fill_factor = 0.25, field_of_view = \
             \"{angle_rad} rad\" }}"
        );
    let lone = parse("lone.toml", &lone).unwrap_or_else(|errors| panic!("{errors}"));
    let rate_cps = array.pixel(4, 5).background_rate_cps.expect("there is some");
    close(rate_cps, lone.detectors[0].background_rate_cps);
    let edge_cps = array.pixel(4, 10).background_rate_cps.expect("there is some");
    close(edge_cps, rate_cps * 0.25);
}

#[test]
fn the_paths_are_those_of_a_pixel() {
    let scene = scene(&format!("row = 0\ncolumn = 3\n{WALL}"));
    let seen = array(WALL).pixel(0, 3);
    assert_eq!(scene.paths.len(), 1);
    assert_eq!(scene.paths[PathIndex(0)].delay_ps, seen.paths[0].delay_ps);
    let middle = self::scene(WALL);
    assert_eq!(middle.paths[PathIndex(0)].delay_ps, array(WALL).pixel(4, 5).paths[0].delay_ps);
    let other = middle.of_pixel(&seen);
    assert_eq!(other.paths[PathIndex(0)].transmission, seen.paths[0].transmission);
    // A map's point faces the pixel: a wall that does would have no cosine of its own.
    let point = array(WALL).pixel_at(0, 3, 3.0, 0.4);
    close(point.paths[0].delay_ps, seen.paths[0].delay_ps);
    let cosine = seen.depth_per_distance();
    close(point.paths[0].transmission, seen.paths[0].transmission / cosine);
}

#[test]
fn mistakes_are_told_with_their_place() {
    let path = "[[path]]\nsource = \"laser\"\ndetector = \"spad\"\ndistance = \"3 m\"\n";
    let glass = "[[array.plane]]\nz = \"1 m\"\nreflectance = 0.1\ntransmission = 0.5\n";
    for (more, told) in [
        (path.to_owned(), "path: the paths of a scene with [array] follow"),
        (
            "row = 9\n".to_owned(),
            "array.toml:25:7: array.row: the array has rows 0 to 8; 9 is none",
        ),
        ("column = 11\n".to_owned(), "array.column: the array has columns 0 to 10; 11 is none"),
        (glass.repeat(4), "array.plane: more than 3 planes let light through"),
        (
            WALL.replace("reflectance = 0.4", "reflectance = 0.4\ntransmission = 0.7"),
            "array.plane.transmission: with the reflectance that is 1.1",
        ),
        (
            "[[array.sphere]]\nz = \"1 m\"\nradius = \"2 m\"\nreflectance = 0.5\n".to_owned(),
            "array.sphere.radius: the lens would be inside",
        ),
        (
            "[[array.light]]\nsource = \"lasr\"\n".to_owned(),
            "no source is named \"lasr\"; did you mean \"laser\"?",
        ),
        ("[array.background]\nfilter_width = \"10 nm\"\n".to_owned(), "one of `illuminance`"),
        ("[[array.plan]]\n".to_owned(), "has no key `plan`; did you mean `plane`?"),
    ] {
        let error = complaint(&more);
        assert!(error.contains(told), "{told}: {error}");
    }
    let many = SCENE.replace("rows = 9", "rows = 4096").replace("columns = 11", "columns = 4096");
    let error = parse("array.toml", &many).expect_err("too many").to_string();
    assert!(error.contains("4096 rows of 4096 pixels are more than 1048576 pixels"), "{error}");
    let two =
        SCENE.replace("[array]", "[[detector]]\nname = \"b\"\nreference = \"laser\"\n[array]");
    let error = parse("array.toml", &two).expect_err("two detectors").to_string();
    assert!(error.contains("every pixel is a sensor like the scene's one [[detector]]"), "{error}");
    let twice = SCENE.replace("[array]", "background_rate = \"1 kcps\"\n[array]")
        + "[array.background]\nirradiance = \"1 W/m2/nm\"\nfilter_width = \"1 nm\"\n";
    let error = parse("array.toml", &twice).expect_err("given twice").to_string();
    assert!(error.contains("follows from array.background; leave one"), "{error}");
}
