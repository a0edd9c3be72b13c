//! Photon budgets: what comes back of a source's light, and how much ambient light does.
//!
//! The target is Lambertian. Of the light that falls on a point of it at distance R, the share
//! sin^2 a = r^2 / (R^2 + r^2) of what it reflects enters an aperture of radius r that looks at
//! it (the view factor of a disc on the axis, J. R. Howell, *A Catalog of Radiation Heat
//! Transfer Configuration Factors*, B-12). Ambient light of spectral irradiance E on
//! the target makes it shine with radiance rho E / pi, of which an aperture of area A takes in
//! A pi sin^2 (theta / 2) rho E / pi from a field of view of full angle theta: no distance is
//! in it, as long as the target fills the field of view.

use std::f64::consts::PI;

use super::reader::Section;
use crate::light::SPEED_OF_LIGHT_M_PER_S;

/// Planck and Boltzmann constants (exact, SI).
const PLANCK_J_S: f64 = 6.626_070_15e-34;
const BOLTZMANN_J_PER_K: f64 = 1.380_649e-23;
/// Effective temperature of the sun (IAU 2015 nominal value, 5772 K).
const SUN_K: f64 = 5772.0;
/// Largest luminous efficacy, lumens per watt at 555 nm (SI).
const LUMENS_PER_WATT: f64 = 683.0;
/// Wavelengths at which illuminance says how much light there is.
const SUNLIGHT_NM: std::ops::RangeInclusive<f64> = 350.0..=2500.0;

/// What lies between a target and the counted photon, whatever the light is.
struct Receiver {
    reflectance: f64,
    aperture_m: f64,
    /// Transmission of lens and filter times the fill factor.
    throughput: f64,
}

impl Receiver {
    fn read(section: &Section) -> Option<Receiver> {
        section.require("reflectance");
        section.require("aperture");
        let share = |key| match section.get(key) {
            None => Some(1.0),
            Some(_) => section.number(key),
        };
        let (optics, fill_factor) = (share("optics"), share("fill_factor"));
        Some(Receiver {
            reflectance: section.number("reflectance")?,
            aperture_m: section.quantity("aperture")?,
            throughput: optics? * fill_factor?,
        })
    }
}

/// Share of the source's photons that a path lets through by its table `link`, at a
/// distance; `None` if there is no such table.
pub(super) fn read_link(path: &Section, distance_m: Option<f64>) -> Option<f64> {
    const EXAMPLE: &str = "{ reflectance = 0.5, aperture = \"20 mm\" }";
    let section = path.section("link", EXAMPLE)?;
    if path.get("transmission").is_some() {
        path.report(
            "transmission",
            "it follows from the table `link`; leave one of them out",
        );
    }
    let receiver = Receiver::read(&section);
    let divergence = section.quantity("divergence");
    let field_of_view = section.quantity("field_of_view");
    if section.get("divergence").is_some() != section.get("field_of_view").is_some() {
        section.complain(
            "`divergence` and `field_of_view` go together: without them the spot is in the field \
             of view",
        );
    }
    section.finish();
    let receiver = receiver?;
    let seen = match (divergence, field_of_view) {
        (Some(divergence), Some(field_of_view)) => spot_seen(divergence, field_of_view),
        _ => 1.0,
    };
    let collected = collected(receiver.aperture_m, distance_m?);
    Some(receiver.reflectance * receiver.throughput * seen * collected)
}

/// Share of the light of a Lambertian point that enters an aperture of some diameter.
fn collected(aperture_m: f64, distance_m: f64) -> f64 {
    let radius_squared = (0.5 * aperture_m).powi(2);
    radius_squared / (distance_m * distance_m + radius_squared)
}

/// Share of an evenly lit round spot within a round field of view, by their full angles.
fn spot_seen(divergence_rad: f64, field_of_view_rad: f64) -> f64 {
    let ratio = (0.5 * field_of_view_rad).tan() / (0.5 * divergence_rad).tan();
    (ratio * ratio).min(1.0)
}

/// Photons per second of the table `ambient` of a detector whose laser has a wavelength;
/// `None` if there is no such table.
pub(super) fn read_ambient(detector: &Section, wavelength_nm: Option<f64>) -> Option<f64> {
    const EXAMPLE: &str = "{ illuminance = \"10 klux\", filter_width = \"10 nm\", reflectance = 0.5, \
                           aperture = \"20 mm\", field_of_view = \"10 mrad\" }";
    let section = detector.section("ambient", EXAMPLE)?;
    if detector.get("background_rate").is_some() {
        let message = "it follows from the table `ambient`; leave one of them out";
        detector.report("background_rate", message);
    }
    section.require("filter_width");
    section.require("field_of_view");
    let receiver = Receiver::read(&section);
    let filter_nm = section.quantity("filter_width");
    let field_of_view_rad = section.quantity("field_of_view");
    let illuminance_lux = section.quantity("illuminance");
    let irradiance = section.quantity("irradiance");
    let given = ["illuminance", "irradiance"].map(|key| section.get(key).is_some());
    if given[0] == given[1] {
        section.complain(
            "one of `illuminance` and `irradiance` is needed; write for example illuminance = \
             \"10 klux\"",
        );
    }
    let spectral = irradiance.or_else(|| {
        let wavelength_nm = wavelength_nm?;
        if !SUNLIGHT_NM.contains(&wavelength_nm) {
            let message = format!(
                "sunlight of {wavelength_nm} nm does not follow from it; give `irradiance`, or a \
                 wavelength of 350 nm to 2500 nm"
            );
            section.report("illuminance", &message);
        }
        Some(illuminance_lux? * sunlight_per_lux(wavelength_nm))
    });
    section.finish();
    let receiver = receiver?;
    let area_m2 = PI * (0.5 * receiver.aperture_m).powi(2);
    let cone = (0.5 * field_of_view_rad?).sin().powi(2);
    let power_w =
        spectral? * filter_nm? * receiver.reflectance * area_m2 * cone * receiver.throughput;
    let photon_j = PLANCK_J_S * SPEED_OF_LIGHT_M_PER_S / (wavelength_nm? * 1e-9);
    Some(power_w / photon_j)
}

/// Spectral irradiance of sunlight in W / (m^2 nm) for each lux: that of a black body as
/// hot as the sun, without the bands of the atmosphere.
fn sunlight_per_lux(wavelength_nm: f64) -> f64 {
    let lumens: f64 = (380..780)
        .map(|nm| f64::from(nm) + 0.5)
        .map(|nm| black_body(nm) * luminous_efficiency(nm))
        .sum();
    black_body(wavelength_nm) / (LUMENS_PER_WATT * lumens)
}

/// Planck's law, in any unit.
fn black_body(wavelength_nm: f64) -> f64 {
    let wavelength_m = wavelength_nm * 1e-9;
    let exponent = PLANCK_J_S * SPEED_OF_LIGHT_M_PER_S / (wavelength_m * BOLTZMANN_J_PER_K * SUN_K);
    (wavelength_nm / 1000.0).powi(-5) / exponent.exp_m1()
}

/// The eye's by day, V(lambda), as a Gaussian: of sunlight it makes 93 lumens per watt, as
/// the tabulated one does.
fn luminous_efficiency(wavelength_nm: f64) -> f64 {
    1.019 * (-285.4 * (wavelength_nm / 1000.0 - 0.559).powi(2)).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Light of a Lambertian point, added up ray by ray over the aperture's solid angle.
    #[test]
    fn an_aperture_collects_what_its_rays_carry() {
        for (aperture_m, distance_m) in [(0.02_f64, 3.2_f64), (0.5, 1.0)] {
            let edge = (0.5 * aperture_m / distance_m).atan();
            let rays = 10_000;
            // cos(a) / pi per solid angle 2 pi sin(a) da.
            let sum: f64 = (0..rays)
                .map(|n| (f64::from(n) + 0.5) / f64::from(rays) * edge)
                .map(|angle| 2.0 * angle.cos() * angle.sin() * edge / f64::from(rays))
                .sum();
            let found = collected(aperture_m, distance_m);
            assert!((found / sum - 1.0).abs() < 1e-6, "{found} {sum}");
        }
        assert_eq!(spot_seen(0.01, 0.02), 1.0);
        assert!((spot_seen(0.02, 0.01) - 0.25).abs() < 1e-4);
    }

    /// The standard spectrum at sea level (ASTM G173-03, global tilt) has 1.2 W/m^2/nm near
    /// 780 nm and 1.5 at 550 nm, with some 110 klux.
    #[test]
    fn sunlight_is_nearly_that_of_the_standard_spectrum() {
        for (wavelength_nm, irradiance) in [(780.0, 1.2), (550.0, 1.5)] {
            let found = 110e3 * sunlight_per_lux(wavelength_nm);
            assert!((0.8..1.2).contains(&(found / irradiance)), "{found}");
        }
        // 555 nm alone would be 683 lumens per watt; sunlight has about 93 in all.
        let all: f64 = (100..10_000).map(|nm| black_body(f64::from(nm))).sum();
        let lumens_per_watt = 1.0 / (sunlight_per_lux(780.0) / black_body(780.0) * all);
        assert!((88.0..98.0).contains(&lumens_per_watt), "{lumens_per_watt}");
    }

    /// A scene with a link and ambient light: what the formulas of the guide give, by hand.
    #[test]
    fn a_scene_with_budgets_has_their_transmission_and_background() {
        let text = r#"
            clock = { chip_period = "8 ns" }
            scan = { integration = "20 us" }
            [[source]]
            name = "laser"
            code = { family = "gold", degree = 5 }
            wavelength = "900 nm"
            [[detector]]
            name = "spad"
            reference = "laser"
            ambient = { irradiance = "0.5 W/m2/nm", filter_width = "10 nm", reflectance = 0.4, aperture = "20 mm", field_of_view = "10 mrad", optics = 0.5 }
            [[path]]
            source = "laser"
            detector = "spad"
            distance = "10 m"
            link = { reflectance = 0.4, aperture = "20 mm", optics = 0.5, fill_factor = 0.25, divergence = "20 mrad", field_of_view = "10 mrad" }
        "#;
        let scene = crate::scene::parse("x.toml", text).expect("it is sound");
        // 0.4 x 0.5 x 0.25, a quarter of the spot, (10 mm / 10 m)^2.
        let transmission = scene.paths[0].transmission;
        assert!(
            (transmission / 1.25e-8 - 1.0).abs() < 1e-4,
            "{transmission:e}"
        );
        // 0.5 x 10 x 0.4 / pi W / (m^2 sr) x 3.1416e-4 m^2 x 7.854e-5 sr x 0.5, and
        // 2.2072e-19 J a photon of 900 nm.
        let rate = scene.detectors[0].background_rate_cps;
        assert!((rate / 3.5588e10 - 1.0).abs() < 1e-3, "{rate:e}");
        for (change, complaint) in [
            ("distance = \"10 m\"", "it follows from the table `link`"),
            ("name = \"spad\"", "it follows from the table `ambient`"),
        ] {
            let twice = match change.starts_with("distance") {
                true => format!("{change}\ntransmission = 0.5"),
                false => format!("{change}\nbackground_rate = \"1 kcps\""),
            };
            let error = crate::scene::parse("x.toml", &text.replace(change, &twice));
            let error = error.expect_err("given twice").to_string();
            assert!(error.contains(complaint), "{error}");
        }
    }
}
