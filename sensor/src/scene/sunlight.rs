//! The spectrum of sunlight on the ground, for background light that is given in lux.

use std::ops::RangeInclusive;

/// Wavelength of the spectrum's first entry; one nanometre lies between one and the next.
const FIRST_NM: f64 = 350.0;

/// Spectral irradiance in 0.1 mW / (m^2 nm) at 350 nm to 1700 nm, a nanometre apart: the global
/// tilted reference spectrum of ASTM G173-03, as NREL publishes it.
const SPECTRUM: [u16; 1351] = include!("sunlight/astm-g173-tilted.in");

/// Illuminance of that spectrum, by the CIE's photopic luminous efficiency of 1924.
const ILLUMINANCE_LUX: f64 = 109_495.0;

/// Wavelengths whose sunlight is known.
pub(super) const KNOWN_NM: RangeInclusive<f64> = 350.0..=1700.0;

/// Narrowest band whose sunlight is known: the spectrum has an entry every nanometre, and
/// the atmosphere's lines are narrower.
pub(super) const RESOLUTION_NM: f64 = 1.0;

/// Irradiance in W / m^2 that a lux of sunlight has in a band of wavelengths; `None` for
/// one that is not all [`KNOWN_NM`], or narrower than [`RESOLUTION_NM`].
pub(super) fn band_per_lux(middle_nm: f64, width_nm: f64) -> Option<f64> {
    let ends = [-0.5, 0.5].map(|side| middle_nm + side * width_nm);
    let is_known = width_nm >= RESOLUTION_NM && ends.iter().all(|end| KNOWN_NM.contains(end));
    is_known.then(|| 1e-4 * (below(ends[1]) - below(ends[0])) / ILLUMINANCE_LUX)
}

/// Light between the first entry and a wavelength in 0.1 mW / m^2, straight between entries.
fn below(wavelength_nm: f64) -> f64 {
    let place = wavelength_nm - FIRST_NM;
    let whole = (place.floor() as usize).min(SPECTRUM.len() - 2);
    let between = |entry: usize, share: f64| {
        let [start, end] = [entry, entry + 1].map(|entry| f64::from(SPECTRUM[entry]));
        share * (start + 0.5 * share * (end - start))
    };
    let before: f64 = (0..whole).map(|entry| between(entry, 1.0)).sum();
    before + between(whole, place - whole as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In mW / (m^2 nm), mean over 10 nm.
    fn at(wavelength_nm: f64) -> f64 {
        100.0 * ILLUMINANCE_LUX * band_per_lux(wavelength_nm, 10.0).expect("it is known")
    }

    /// What the eye makes of the spectrum: 683 lumens a watt at 555 nm, and a Gaussian
    /// that is nearly its sensitivity elsewhere.
    #[test]
    fn the_spectrum_is_as_bright_as_it_says() {
        let efficiency = |nm: f64| 1.019 * (-285.4 * (nm / 1000.0 - 0.559).powi(2)).exp();
        let lux: f64 =
            (380..780).map(f64::from).map(|nm| 683.0 * efficiency(nm) * 1e-3 * at(nm)).sum();
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
        assert!(at(940.0) / (scale * black(940.0)) < 0.5 && at(1380.0) < 1.0);
    }

    /// Narrow bands by hand, from the standard's entries in W / (m^2 nm) at their ends and
    /// middle: 0.84457, 0.81709, 0.77558 from 904 nm on, and from 759 nm on 1.1945, 0.26604,
    /// 0.15396, where oxygen takes the light.
    #[test]
    fn a_narrow_band_has_the_light_within_it() {
        let mean = |middle_nm, width_nm| {
            band_per_lux(middle_nm, width_nm).expect("it is known") * ILLUMINANCE_LUX / width_nm
        };
        for (middle_nm, entries) in
            [(905.0, [0.84457, 0.81709, 0.77558]), (760.0, [1.1945, 0.26604, 0.15396])]
        {
            let by_hand = 0.25 * entries[0] + 0.5 * entries[1] + 0.25 * entries[2];
            let found = mean(middle_nm, 2.0);
            assert!((found / by_hand - 1.0_f64).abs() < 2e-4, "{middle_nm} nm: {found} {by_hand}");
        }
        // Half a nanometre of either side of 760 nm.
        let by_hand = (0.375 * 0.26604 + 0.125 * 1.1945) + (0.375 * 0.26604 + 0.125 * 0.15396);
        assert!((mean(760.0, 1.0) / by_hand - 1.0_f64).abs() < 2e-4, "{}", mean(760.0, 1.0));
    }

    #[test]
    fn bands_add_up_and_what_is_not_known_is_none() {
        let band = |from: f64, to: f64| band_per_lux(0.5 * (from + to), to - from);
        let parts = [(350.0, 700.25), (700.25, 951.5), (951.5, 1700.0)];
        let sum: f64 = parts.iter().map(|&(from, to)| band(from, to).expect("it is known")).sum();
        assert!((band(350.0, 1700.0).expect("all of it") / sum - 1.0).abs() < 1e-12);
        assert!(band_per_lux(350.0, 1.0).is_none() && band_per_lux(1699.0, 3.0).is_none());
        assert!(band_per_lux(905.0, 0.99).is_none() && band_per_lux(905.0, 1.0).is_some());
    }
}
