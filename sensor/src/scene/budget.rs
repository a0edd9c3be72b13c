//! Photon budgets: what comes back of a source's light, and how much of the background does.
//!
//! The target is Lambertian. Of the light that falls on a point of it at distance R, the share
//! sin^2 a = r^2 / (R^2 + r^2) of what it reflects enters an aperture of radius r that looks at
//! it (the view factor of a disc on the axis, J. R. Howell, *A Catalog of Radiation Heat
//! Transfer Configuration Factors*, B-12). Background of spectral irradiance E on the
//! target makes it shine with radiance rho E / pi, of which an aperture of area A takes in
//! A pi sin^2 (theta / 2) rho E / pi from a field of view of full angle theta: no distance is
//! in it, as long as the target fills the field of view.

use std::f64::consts::PI;

use super::declare::*;
use super::sunlight;
use crate::light::photon_rate_hz;

/// A full angle.
const ANGLE: KeyKind = quantity(Quantity::Angle, "1e-3 urad", "3 rad");

tables! {
    /// What lies between a target and the counted photon, whatever the light is.
    #[derive(Debug)]
    pub(super) struct Receiver {}
    of RECEIVER = "" {
        reflectance => reflectance: f64 = number(0.0, 1.0), Needed, "0.5";
            "share of the light that the target sends back, in all directions (Lambertian)"
            "a share";
        aperture => aperture_m: f64 = quantity(Distance, "1 um", "10 m"), Needed, "20 mm";
            "diameter of the receiving lens"
            "from a bare detector to the largest telescope";
        optics => optics: f64 = number(0.0, 1.0), Or("1"), "0.7";
            "transmission of lenses and filter at the source's wavelength"
            "a share";
        fill_factor => fill_factor: f64 = number(0.0, 1.0), Or("1"), "0.3";
            "share of the detector's area that detects"
            "a share";
    }

    LINK = "path.link" and RECEIVER {
        divergence = ANGLE, Otherwise("none: the spot is in the field of view"), "20 mrad";
            "full angle of the source's cone, evenly lit"
            "lenses look forwards";
        field_of_view = ANGLE, Otherwise("none: the spot is in the field of view"), "10 mrad";
            "full angle of the detector's cone; of a larger spot the part within it counts"
            "as for `divergence`";
    }

    SUNLIGHT = "" {
        illuminance = quantity(Illuminance, "0 lux", "1000 klux"),
            Otherwise("none: `irradiance` stands for it"), "10 klux";
            "sunlight on the target, whose spectrum is known from 350 nm to 1700 nm, for filters of 1 nm and more"
            "nine suns at noon";
        irradiance = quantity(SpectralIrradiance, "0 W/m2/nm", "1000 W/m2/nm"),
            Otherwise("none: `illuminance` stands for it"), "100 mW/m2/nm";
            "light on the target near the source's wavelength"
            "the sun has less than two";
        filter_width = quantity(Wavelength, "1e-6 nm", "10 um"), Needed, "10 nm";
            "width of the filter that passes the source's wavelength"
            "from a laser's line to no filter at all";
    }

    BACKGROUND = "detector.background" and SUNLIGHT and RECEIVER {
        field_of_view = ANGLE, Needed, "10 mrad";
            "full angle of the cone that the detector sees, filled by the target"
            "as for `divergence`";
    }
}

impl Receiver {
    /// Transmission of lens and filter times the fill factor.
    fn throughput(&self) -> f64 {
        self.optics * self.fill_factor
    }

    /// Share of the light on a point of the target, `distance_m` away, that is counted.
    pub(super) fn collected(&self, distance_m: f64) -> f64 {
        let radius_squared = (0.5 * self.aperture_m).powi(2);
        let view = radius_squared / (distance_m * distance_m + radius_squared);
        self.reflectance * self.throughput() * view
    }

    /// Power that is counted of light that the target lies in, from a share of the hemisphere
    /// in front of the aperture, projected onto it.
    pub(super) fn power_w(&self, irradiance_w_per_m2: f64, projected_share: f64) -> f64 {
        let area_m2 = PI * (0.5 * self.aperture_m).powi(2);
        irradiance_w_per_m2 * self.reflectance * self.throughput() * area_m2 * projected_share
    }
}

/// Share of the source's photons that a path lets through by its table `link`, at a
/// distance; `None` if there is no such table.
pub(super) fn read_link(path: &Section, distance_m: Option<f64>) -> Option<f64> {
    let section = path.section("link")?;
    if path.get("transmission").is_some() {
        path.report("transmission", "it follows from the table `link`; leave one of them out");
    }
    let receiver = Receiver::keys(&section);
    let divergence_rad = section.quantity("divergence");
    let field_of_view_rad = section.quantity("field_of_view");
    let given = ["divergence", "field_of_view"].map(|key| section.get(key).is_some());
    if given[0] != given[1] {
        section.complain(
            "`divergence` and `field_of_view` go together; give both, or none where all of the \
             spot is in the field of view",
        );
    }
    section.finish();
    let seen = match (divergence_rad, field_of_view_rad) {
        (Some(divergence), Some(field_of_view)) => spot_seen(divergence, field_of_view),
        _ => 1.0,
    };
    Some(seen * receiver?.collected(distance_m?))
}

/// Share of the hemisphere that a cone of some full angle has, projected onto its base.
fn cone_share(full_angle_rad: f64) -> f64 {
    (0.5 * full_angle_rad).sin().powi(2)
}

/// Share of an evenly lit round spot within a round field of view, by their full angles.
fn spot_seen(divergence_rad: f64, field_of_view_rad: f64) -> f64 {
    let ratio = (0.5 * field_of_view_rad).tan() / (0.5 * divergence_rad).tan();
    (ratio * ratio).min(1.0)
}

/// Photons per second of the table `background` of a detector whose laser has a
/// wavelength; `None` if there is no such table.
pub(super) fn read_background(detector: &Section, wavelength_nm: Option<f64>) -> Option<f64> {
    let section = detector.section("background")?;
    if detector.get("background_rate").is_some() {
        let message = "it follows from the table `background`; leave one of them out";
        detector.report("background_rate", message);
    }
    let receiver = Receiver::keys(&section);
    let field_of_view_rad = section.quantity("field_of_view");
    let irradiance = read_irradiance(&section, wavelength_nm);
    section.finish();
    let power_w = receiver?.power_w(irradiance?, cone_share(field_of_view_rad?));
    let rate_cps = photon_rate_hz(power_w, wavelength_nm?);
    check_background(detector, detector.key("background_rate"), rate_cps);
    Some(rate_cps)
}

/// Complains of more background than `background_rate` may be, that follows from the table
/// `background`.
pub(super) fn check_background(section: &Section, limit: &Key, rate_cps: f64) -> Option<()> {
    if limit.holds(rate_cps) {
        return Some(());
    }
    let message = format!(
        "{rate_cps:.3e} cps follow from this, more than a `background_rate` may be ({}); take less \
         light, or a narrower filter or field of view",
        limit.range().split(" to ").last().unwrap_or_default()
    );
    section.report("background", &message);
    None
}

/// Background on the target that a filter lets through, in W / m^2.
pub(super) fn read_irradiance(section: &Section, wavelength_nm: Option<f64>) -> Option<f64> {
    let filter_nm = section.quantity("filter_width");
    let illuminance_lux = section.quantity("illuminance");
    let irradiance = section.quantity("irradiance");
    let given = ["illuminance", "irradiance"].map(|key| section.get(key).is_some());
    if given[0] == given[1] {
        section.complain(&format!(
            "one of `illuminance` and `irradiance` is needed; write for example illuminance = \"{}\"",
            SUNLIGHT.key("illuminance").example
        ));
    }
    if !given[0] {
        return Some(irradiance? * filter_nm?);
    }
    let (wavelength_nm, filter_nm) = (wavelength_nm?, filter_nm?);
    let per_lux = sunlight::band_per_lux(wavelength_nm, filter_nm);
    if per_lux.is_none() {
        let is_narrow = filter_nm < sunlight::RESOLUTION_NM;
        let message = format!(
            "how much sunlight a filter of {filter_nm} nm at {wavelength_nm} nm lets through is known \
             only within {} nm to {} nm, for filters of {} nm and more; give `irradiance`, or a {} \
             filter",
            sunlight::KNOWN_NM.start(),
            sunlight::KNOWN_NM.end(),
            sunlight::RESOLUTION_NM,
            if is_narrow { "wider" } else { "narrower" }
        );
        section.report("illuminance", &message);
    }
    Some(illuminance_lux? * per_lux?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, SceneErrors, parse};

    const LINK: &str = "reflectance = 0.4, aperture = \"20 mm\", optics = 0.5, fill_factor = 0.25, \
                        divergence = \"20 mrad\", field_of_view = \"10 mrad\"";
    const SUNLIT: &str = "irradiance = \"0.5 W/m2/nm\", filter_width = \"10 nm\", \
                              reflectance = 0.4, aperture = \"20 mm\", field_of_view = \"10 mrad\", \
                              optics = 0.5";

    fn read(link: &str, background: &str) -> Result<Scene, SceneErrors> {
        let text = format!(
            r#"
            clock = {{ chip_period = "8 ns" }}
            scan = {{ integration = "20 us" }}
            [[source]]
            name = "laser"
            code = {{ family = "gold", degree = 5 }}
            wavelength = "900 nm"
            [[detector]]
            name = "spad"
            reference = "laser"
            background = {{ {background} }}
            [[path]]
            source = "laser"
            detector = "spad"
            distance = "10 m"
            link = {{ {link} }}
        "#
        );
        parse("x.toml", &text)
    }

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
            let receiver = Receiver { reflectance: 1.0, aperture_m, optics: 1.0, fill_factor: 1.0 };
            let found = receiver.collected(distance_m);
            assert!((found / sum - 1.0).abs() < 1e-6, "{found} {sum}");
        }
        assert_eq!(spot_seen(0.01, 0.02), 1.0);
        assert!((spot_seen(0.02, 0.01) - 0.25).abs() < 1e-4);
    }

    /// Light of the whole half space that shines on a white target comes back as it fell on
    /// it: a detector without a lens that looks at nothing else gets E A.
    #[test]
    fn a_detector_that_sees_only_the_target_is_lit_as_it_is() {
        let bare = Receiver {
            reflectance: 1.0,
            aperture_m: 2.0 / PI.sqrt(),
            optics: 1.0,
            fill_factor: 1.0,
        };
        assert!((bare.power_w(3.0, cone_share(PI)) - 3.0).abs() < 1e-12);
    }

    /// A scene with a link and background: what the formulas of the guide give, by hand.
    #[test]
    fn a_scene_with_budgets_has_their_transmission_and_background() {
        let scene = read(LINK, SUNLIT).expect("it is sound");
        // 0.4 x 0.5 x 0.25, a quarter of the spot, (10 mm / 10 m)^2.
        let transmission = scene.paths[0].transmission;
        assert!((transmission / 1.25e-8 - 1.0).abs() < 1e-4, "{transmission:e}");
        // 0.5 x 10 x 0.4 / pi W / (m^2 sr) x 3.1416e-4 m^2 x 7.854e-5 sr x 0.5 =
        // 7.854e-9 W, and 2.2072e-19 J a photon of 900 nm.
        let rate = scene.detectors[0].background_rate_cps;
        assert!((rate / 3.5584e10 - 1.0).abs() < 1e-3, "{rate:e}");
        // A third of the standard spectrum's light, whose mean over 895 nm to 905 nm is 0.705
        // W / (m^2 nm) by the trapezoidal rule on the standard's entries.
        let sunny = SUNLIT.replace("irradiance = \"0.5 W/m2/nm\"", "illuminance = \"36.498 klux\"");
        let rate = read(LINK, &sunny).expect("it is sound").detectors[0].background_rate_cps;
        assert!((rate / 3.5584e10 * 0.5 / 0.2351 - 1.0).abs() < 1e-2, "{rate:e}");
    }

    #[test]
    fn budgets_that_say_too_much_or_too_little_are_refused() {
        for (link, background, complaint) in [
            (LINK.replace(", field_of_view = \"10 mrad\"", ""), SUNLIT.to_owned(), "go together"),
            (
                LINK.replace("reflectance = 0.4, ", ""),
                SUNLIT.to_owned(),
                "`reflectance` is missing",
            ),
            (LINK.to_owned(), format!("{SUNLIT}, illuminance = \"1 lux\""), "one of `illuminance`"),
            (
                LINK.to_owned(),
                SUNLIT.replace("irradiance = \"0.5 W/m2/nm\", ", ""),
                "one of `illuminance`",
            ),
            (
                LINK.to_owned(),
                SUNLIT
                    .replace("irradiance = \"0.5 W/m2/nm\"", "illuminance = \"1 klux\"")
                    .replace("10 nm", "1.2 um"),
                "350 nm to 1700 nm",
            ),
            (
                LINK.to_owned(),
                SUNLIT
                    .replace("irradiance = \"0.5 W/m2/nm\"", "illuminance = \"1 klux\"")
                    .replace("10 nm", "0.5 nm"),
                "for filters of 1 nm and more; give `irradiance`, or a wider filter",
            ),
            (
                LINK.to_owned(),
                SUNLIT.replace("20 mm", "10 m").replace("10 mrad", "3 rad"),
                "cps follow",
            ),
        ] {
            let error = read(&link, &background).expect_err(complaint).to_string();
            assert!(error.contains(complaint), "{error}");
        }
        let twice = read(&format!("{LINK} }}\ntransmission = 0.5 # {{"), SUNLIT);
        let error = twice.expect_err("given twice").to_string();
        assert!(error.contains("it follows from the table `link`"), "{error}");
        let twice = read(LINK, &format!("{SUNLIT} }}\nbackground_rate = \"1 kcps\" # {{"));
        let error = twice.expect_err("given twice").to_string();
        assert!(error.contains("it follows from the table `background`"), "{error}");
    }
}
