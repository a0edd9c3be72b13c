//! The spectrum of sunlight on the ground, for background light that is given in lux.

use std::ops::RangeInclusive;

/// Wavelengths of the first entry and from one to the next.
const FIRST_NM: f64 = 350.0;
const STEP_NM: f64 = 10.0;

/// Spectral irradiance in mW / (m^2 nm), means over 10 nm: the global tilted reference
/// spectrum of ASTM G173-03, in which the atmosphere's bands are.
const SPECTRUM: [u16; 136] = [
    518, 539, 671, 662, 674, 995, 1165, 1222, 1127, 1347, 1499, 1564, 1554, 1598, 1511, 1543, 1559,
    1489, 1532, 1534, 1542, 1513, 1493, 1504, 1447, 1466, 1471, 1443, 1409, 1447, 1401, 1354, 1414,
    1394, 1208, 1291, 1306, 1099, 1116, 1220, 1238, 786, 1082, 1167, 1116, 1083, 1034, 876, 931,
    1001, 961, 984, 940, 938, 904, 705, 675, 702, 465, 305, 336, 414, 611, 652, 742, 735, 718, 700,
    688, 673, 654, 633, 612, 596, 563, 499, 388, 146, 129, 210, 189, 345, 420, 430, 442, 427, 440,
    454, 462, 462, 454, 418, 381, 414, 414, 371, 333, 290, 213, 159, 22, 0, 0, 0, 0, 1, 3, 17, 31,
    38, 66, 109, 69, 100, 154, 208, 243, 262, 269, 271, 271, 267, 248, 242, 250, 237, 232, 238,
    238, 222, 220, 222, 212, 207, 207, 201,
];

/// Illuminance of that spectrum, by the CIE's photopic luminous efficiency of 1924.
const ILLUMINANCE_LUX: f64 = 109_495.0;

/// Points of a band: nearer to each other than entries are, however wide it is.
const POINTS: u32 = 512;

/// Wavelengths whose sunlight is known.
pub(super) const KNOWN_NM: RangeInclusive<f64> = 350.0..=1700.0;

/// Irradiance in W / m^2 that a lux of sunlight has in a band of wavelengths; `None` for
/// one that is not all [`KNOWN_NM`].
pub(super) fn band_per_lux(middle_nm: f64, width_nm: f64) -> Option<f64> {
    let ends = [-0.5, 0.5].map(|side| middle_nm + side * width_nm);
    if !ends.iter().all(|end| KNOWN_NM.contains(end)) {
        return None;
    }
    let sum: f64 = (0..POINTS)
        .map(|point| (f64::from(point) + 0.5) / f64::from(POINTS))
        .map(|share| at(ends[0] + share * width_nm))
        .sum();
    Some(1e-3 * width_nm * sum / f64::from(POINTS) / ILLUMINANCE_LUX)
}

/// Between the means of the spectrum, straight, in mW / (m^2 nm).
fn at(wavelength_nm: f64) -> f64 {
    let place = (wavelength_nm - FIRST_NM) / STEP_NM;
    let before = (place.floor().max(0.0) as usize).min(SPECTRUM.len() - 2);
    let share = place - before as f64;
    let [before, after] = [before, before + 1].map(|entry| f64::from(SPECTRUM[entry]));
    before + share * (after - before)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the eye makes of the spectrum: 683 lumens a watt at 555 nm, and a Gaussian
    /// that is nearly its sensitivity elsewhere.
    #[test]
    fn the_spectrum_is_as_bright_as_it_says() {
        let efficiency = |nm: f64| 1.019 * (-285.4 * (nm / 1000.0 - 0.559).powi(2)).exp();
        let lux: f64 = (380..780)
            .map(|nm| f64::from(nm) + 0.5)
            .map(|nm| 683.0 * efficiency(nm) * 1e-3 * at(nm))
            .sum();
        assert!((lux / ILLUMINANCE_LUX - 1.0).abs() < 0.005, "{lux}");
    }

    /// Away from the atmosphere's bands that of a black body as hot as the sun (5772 K) of the
    /// same illuminance, but for haze in the blue.
    #[test]
    fn the_spectrum_is_nearly_a_black_bodys() {
        // Planck's law, with h c / k in nm K.
        let black = |nm: f64| (nm / 1000.0).powi(-5) / (1.438_777e7 / (nm * 5772.0)).exp_m1();
        let scale = at(550.0) / black(550.0);
        for nm in [450.0, 500.0, 600.0, 650.0, 700.0, 780.0, 850.0, 1050.0] {
            let ratio = at(nm) / (scale * black(nm));
            assert!((0.85..1.15).contains(&ratio), "{nm} nm: {ratio}");
        }
        // Water at 940 nm takes more than half, and at 1380 nm all.
        assert!(at(940.0) / (scale * black(940.0)) < 0.5 && at(1380.0) == 0.0);
    }

    #[test]
    fn a_band_has_the_light_within_it() {
        // Means over 10 nm round each entry, so a band of 20 nm has half of its two
        // neighbours each.
        let band = band_per_lux(850.0, 20.0).expect("it is known") * ILLUMINANCE_LUX;
        let by_hand = 1e-3 * (5.0 * (1001.0 + 961.0) / 2.0 + 5.0 * (961.0 + 984.0) / 2.0) * 2.0;
        assert!((band / by_hand - 1.0).abs() < 0.01, "{band} {by_hand}");
        assert!(band_per_lux(350.0, 1.0).is_none() && band_per_lux(1699.0, 3.0).is_none());
        assert!(band_per_lux(1025.0, 1350.0).is_some());
    }
}
