//! Quantities: a number and a unit.

/// What a quantity measures, and the unit that it is converted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// In picoseconds.
    Time,
    /// In metres.
    Distance,
    /// In nanometres.
    Wavelength,
    /// In counts per second.
    Rate,
    /// In watts.
    Power,
    /// In metres per second.
    Speed,
    /// A share of a frequency.
    ClockOffset,
    /// Its change per second.
    ClockDrift,
    /// In radians.
    Angle,
    /// In lux.
    Illuminance,
    /// In watts per square metre and nanometre.
    SpectralIrradiance,
}

impl Quantity {
    /// The quantity with its article.
    pub(super) fn name(self) -> &'static str {
        match self {
            Quantity::Time => "a time",
            Quantity::Distance => "a distance",
            Quantity::Wavelength => "a wavelength",
            Quantity::Rate => "a rate",
            Quantity::Power => "a power",
            Quantity::Speed => "a speed",
            Quantity::ClockOffset => "a clock's offset",
            Quantity::ClockDrift => "a clock's drift",
            Quantity::Angle => "an angle",
            Quantity::Illuminance => "an illuminance",
            Quantity::SpectralIrradiance => "a spectral irradiance",
        }
    }

    fn dimension(self) -> Dimension {
        match self {
            Quantity::Time => Dimension::Time,
            Quantity::Distance | Quantity::Wavelength => Dimension::Length,
            Quantity::Rate => Dimension::Rate,
            Quantity::Power => Dimension::Power,
            Quantity::Speed => Dimension::Speed,
            Quantity::ClockOffset => Dimension::ClockOffset,
            Quantity::ClockDrift => Dimension::ClockDrift,
            Quantity::Angle => Dimension::Angle,
            Quantity::Illuminance => Dimension::Illuminance,
            Quantity::SpectralIrradiance => Dimension::SpectralIrradiance,
        }
    }

    /// Power of ten of the unit that the quantity is converted to.
    fn base_exponent(self) -> i32 {
        match self {
            Quantity::Time => -12,
            Quantity::Wavelength => -9,
            Quantity::Distance
            | Quantity::Rate
            | Quantity::Power
            | Quantity::Speed
            | Quantity::ClockOffset
            | Quantity::ClockDrift
            | Quantity::Angle
            | Quantity::Illuminance
            | Quantity::SpectralIrradiance => 0,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Dimension {
    Time,
    Length,
    Rate,
    Power,
    Speed,
    ClockOffset,
    ClockDrift,
    Angle,
    Illuminance,
    SpectralIrradiance,
}

impl Dimension {
    fn name(self) -> &'static str {
        match self {
            Dimension::Time => "a time",
            Dimension::Length => "a length",
            Dimension::Rate => "a rate",
            Dimension::Power => "a power",
            Dimension::Speed => "a speed",
            Dimension::ClockOffset => "a clock's offset",
            Dimension::ClockDrift => "a clock's drift",
            Dimension::Angle => "an angle",
            Dimension::Illuminance => "an illuminance",
            Dimension::SpectralIrradiance => "a spectral irradiance",
        }
    }
}

/// How a unit relates to the SI unit of its dimension.
enum Scale {
    /// 10 to this power.
    Decimal(i32),
    /// A multiple of it.
    Multiple(f64),
    /// Decibels above a milliwatt.
    Dbm,
}

struct Unit {
    name: &'static str,
    dimension: Dimension,
    scale: Scale,
}

const fn decimal(name: &'static str, dimension: Dimension, exponent: i32) -> Unit {
    Unit { name, dimension, scale: Scale::Decimal(exponent) }
}

/// Every unit. Spellings that only repeat another one's meaning come last.
const UNITS: [Unit; 49] = [
    decimal("fs", Dimension::Time, -15),
    decimal("ps", Dimension::Time, -12),
    decimal("ns", Dimension::Time, -9),
    decimal("us", Dimension::Time, -6),
    decimal("ms", Dimension::Time, -3),
    decimal("s", Dimension::Time, 0),
    Unit { name: "min", dimension: Dimension::Time, scale: Scale::Multiple(60.0) },
    Unit { name: "h", dimension: Dimension::Time, scale: Scale::Multiple(3600.0) },
    decimal("nm", Dimension::Length, -9),
    decimal("um", Dimension::Length, -6),
    decimal("mm", Dimension::Length, -3),
    decimal("cm", Dimension::Length, -2),
    decimal("m", Dimension::Length, 0),
    decimal("km", Dimension::Length, 3),
    decimal("cps", Dimension::Rate, 0),
    decimal("kcps", Dimension::Rate, 3),
    decimal("Mcps", Dimension::Rate, 6),
    decimal("Gcps", Dimension::Rate, 9),
    decimal("fW", Dimension::Power, -15),
    decimal("pW", Dimension::Power, -12),
    decimal("nW", Dimension::Power, -9),
    decimal("uW", Dimension::Power, -6),
    decimal("mW", Dimension::Power, -3),
    decimal("W", Dimension::Power, 0),
    Unit { name: "dBm", dimension: Dimension::Power, scale: Scale::Dbm },
    decimal("um/s", Dimension::Speed, -6),
    decimal("mm/s", Dimension::Speed, -3),
    decimal("m/s", Dimension::Speed, 0),
    decimal("km/s", Dimension::Speed, 3),
    Unit { name: "km/h", dimension: Dimension::Speed, scale: Scale::Multiple(1.0 / 3.6) },
    decimal("ppb", Dimension::ClockOffset, -9),
    decimal("ppm", Dimension::ClockOffset, -6),
    decimal("ppb/s", Dimension::ClockDrift, -9),
    decimal("ppm/s", Dimension::ClockDrift, -6),
    decimal("urad", Dimension::Angle, -6),
    decimal("mrad", Dimension::Angle, -3),
    decimal("rad", Dimension::Angle, 0),
    Unit {
        name: "deg",
        dimension: Dimension::Angle,
        scale: Scale::Multiple(std::f64::consts::PI / 180.0),
    },
    decimal("lux", Dimension::Illuminance, 0),
    decimal("klux", Dimension::Illuminance, 3),
    decimal("uW/m2/nm", Dimension::SpectralIrradiance, -6),
    decimal("mW/m2/nm", Dimension::SpectralIrradiance, -3),
    decimal("W/m2/nm", Dimension::SpectralIrradiance, 0),
    // The micro sign and the Greek letter.
    decimal("\u{b5}s", Dimension::Time, -6),
    decimal("\u{3bc}s", Dimension::Time, -6),
    decimal("\u{b5}m", Dimension::Length, -6),
    decimal("\u{3bc}m", Dimension::Length, -6),
    decimal("\u{b5}W", Dimension::Power, -6),
    decimal("\u{3bc}W", Dimension::Power, -6),
];

/// Reads `text` as `quantity`, in the quantity's unit. `example` is a right
/// value, for the error message.
///
/// The value is infinite where it is too large for a double.
///
/// Decimal units shift the decimal exponent before the number becomes binary,
/// so that "53.5 ps" and "0.0535 ns" are the same double.
pub(super) fn parse(text: &str, quantity: Quantity, example: &str) -> Result<f64, String> {
    let (number, unit) = split_number(text.trim());
    let Ok(value) = number.parse::<f64>() else {
        return Err(format!(
            "\"{text}\" is not a number with a unit; write for example \"{example}\""
        ));
    };
    if unit.is_empty() {
        return Err(missing_unit(&format!("\"{text}\""), number, example));
    }
    let unit = find_unit(text, unit, quantity)?;
    if unit.dimension != quantity.dimension() {
        return Err(format!(
            "\"{text}\" is {}, but {} is needed; write for example \"{example}\"",
            unit.dimension.name(),
            quantity.name()
        ));
    }
    let base = quantity.base_exponent();
    let converted = match unit.scale {
        Scale::Decimal(exponent) => shifted(number, exponent - base),
        Scale::Multiple(factor) => shifted(number, -base) * factor,
        Scale::Dbm => 1e-3 * 10f64.powf(value / 10.0),
    };
    Ok(converted)
}

/// The units of a quantity.
pub(super) fn names(quantity: Quantity) -> impl Iterator<Item = &'static str> {
    let is_own = move |unit: &&Unit| unit.dimension == quantity.dimension();
    UNITS.iter().filter(is_own).map(|unit| unit.name)
}

/// The complaint about a number without a unit; `shown` is how it was written.
pub(super) fn missing_unit(shown: &str, number: &str, example: &str) -> String {
    let (_, unit) = split_number(example);
    format!("{shown} has no unit; write for example \"{number} {unit}\"")
}

/// Splits a quantity where its number ends.
fn split_number(text: &str) -> (&str, &str) {
    let end = text
        .char_indices()
        .find(|&(at, c)| {
            let exponent = matches!(c, 'e' | 'E')
                && text[at + 1..]
                    .starts_with(|next: char| next.is_ascii_digit() || matches!(next, '+' | '-'));
            !(c.is_ascii_digit() || matches!(c, '.' | '+' | '-') || exponent)
        })
        .map_or(text.len(), |(at, _)| at);
    (&text[..end], text[end..].trim_start())
}

/// `number`, which can be read, times 10^`shift`, correctly rounded: infinite, or
/// zero, where a double ends.
fn shifted(number: &str, shift: i32) -> f64 {
    // No number of this length makes up for such an exponent.
    const MOST: i64 = 1 << 40;
    let (mantissa, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let limit = if exponent.starts_with('-') { -MOST } else { MOST };
    let exponent = exponent.parse().unwrap_or(limit).clamp(-MOST, MOST);
    let shifted = format!("{mantissa}e{}", exponent + i64::from(shift));
    shifted.parse().unwrap_or(f64::NAN)
}

fn find_unit(text: &str, name: &str, quantity: Quantity) -> Result<&'static Unit, String> {
    if let Some(unit) = UNITS.iter().find(|unit| unit.name == name) {
        return Ok(unit);
    }
    let names: Vec<&str> = UNITS
        .iter()
        .filter(|unit| unit.dimension == quantity.dimension() && unit.name.is_ascii())
        .map(|unit| unit.name)
        .collect();
    Err(format!(
        "\"{text}\" has the unknown unit \"{name}\"; {} takes {}",
        quantity.name(),
        super::wording::alternatives(&names)
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str, quantity: Quantity) -> f64 {
        parse(text, quantity, "1 s").unwrap()
    }

    #[test]
    fn every_unit_converts_to_the_unit_of_its_quantity() {
        let times = [
            ("1500 fs", 1.5),
            ("53.5 ps", 53.5),
            ("8 ns", 8e3),
            ("104.8 us", 104.8e6),
            ("104.8 \u{b5}s", 104.8e6),
            ("104.8 \u{3bc}s", 104.8e6),
            ("1.04ms", 1.04e9),
            ("2 s", 2e12),
            ("3 min", 180e12),
            ("1 h", 3600e12),
            ("2e-3 us", 2e3),
            ("1E3 ns", 1e6),
        ];
        for (text, picoseconds) in times {
            assert_eq!(value(text, Quantity::Time), picoseconds, "{text}");
        }
        for (text, metres) in
            [("12 um", 12e-6), ("5 mm", 5e-3), ("3.5 cm", 3.5e-2), ("2.45 km", 2450.0)]
        {
            assert_eq!(value(text, Quantity::Distance), metres, "{text}");
        }
        for (text, metres_per_second) in [
            ("1.5 m/s", 1.5),
            ("-3 mm/s", -3e-3),
            ("12 um/s", 12e-6),
            ("0.2 km/s", 200.0),
            ("36 km/h", 10.0),
        ] {
            assert_eq!(value(text, Quantity::Speed), metres_per_second, "{text}");
        }
        assert_eq!(value("783 nm", Quantity::Wavelength), 783.0);
        assert_eq!(value("1.55 um", Quantity::Wavelength), 1550.0);
        for (text, cps) in [("7 cps", 7.0), ("71 kcps", 71e3), ("1.5 Mcps", 1.5e6), ("2 Gcps", 2e9)]
        {
            assert_eq!(value(text, Quantity::Rate), cps, "{text}");
        }
        for (text, watts) in [
            ("9 fW", 9e-15),
            ("4 pW", 4e-12),
            ("4 nW", 4e-9),
            ("1 uW", 1e-6),
            ("6 mW", 6e-3),
            ("2 W", 2.0),
        ] {
            assert_eq!(value(text, Quantity::Power), watts, "{text}");
        }
    }

    #[test]
    fn decibels_are_above_a_milliwatt() {
        for (text, watts) in [("0 dBm", 1e-3), ("-60 dBm", 1e-9), ("10 dBm", 1e-2)] {
            let relative_error = value(text, Quantity::Power) / watts - 1.0;
            assert!(relative_error.abs() < 1e-14, "{text}: {relative_error}");
        }
    }

    #[test]
    fn equal_quantities_in_different_units_are_the_same_double() {
        for (a, b) in [("53.5 ps", "0.0535 ns"), ("0.34 ns", "340 ps"), ("104.8 us", "104800 ns")] {
            assert_eq!(value(a, Quantity::Time), value(b, Quantity::Time), "{a} {b}");
        }
    }
}
