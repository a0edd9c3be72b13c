//! Quantities: a number and a unit.

use Quantity::*;
use Scale::*;

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
    /// The quantity with its article, and its SI unit as UDUNITS writes it.
    fn words(self) -> [&'static str; 2] {
        match self {
            Time => ["a time", "s"],
            Distance => ["a distance", "m"],
            Wavelength => ["a wavelength", "m"],
            Rate => ["a rate", "s-1"],
            Power => ["a power", "W"],
            Speed => ["a speed", "m s-1"],
            ClockOffset => ["a clock's offset", "1"],
            ClockDrift => ["a clock's drift", "s-1"],
            Angle => ["an angle", "rad"],
            Illuminance => ["an illuminance", "lx"],
            SpectralIrradiance => ["a spectral irradiance", "W m-2 nm-1"],
        }
    }

    /// The quantity with its article.
    pub(super) fn name(self) -> &'static str {
        self.words()[0]
    }

    /// Its SI unit, as UDUNITS writes it.
    pub(super) fn si_unit(self) -> &'static str {
        self.words()[1]
    }

    /// The quantity whose units it has.
    fn dimension(self) -> Quantity {
        match self {
            Quantity::Wavelength => Quantity::Distance,
            other => other,
        }
    }

    /// Power of ten of the unit that the quantity is converted to.
    fn base_exponent(self) -> i32 {
        match self {
            Quantity::Time => -12,
            Quantity::Wavelength => -9,
            _ => 0,
        }
    }
}

/// How a unit relates to the SI unit of its quantity.
enum Scale {
    /// 10 to this power.
    Decimal(i32),
    /// A multiple of it.
    Multiple(f64),
    /// Decibels above a milliwatt.
    Dbm,
}

/// A unit: its name, of what it is, and its scale.
type Unit = (&'static str, Quantity, Scale);

/// Every unit. Spellings that only repeat another one's meaning come last.
const UNITS: [Unit; 49] = [
    ("fs", Time, Decimal(-15)),
    ("ps", Time, Decimal(-12)),
    ("ns", Time, Decimal(-9)),
    ("us", Time, Decimal(-6)),
    ("ms", Time, Decimal(-3)),
    ("s", Time, Decimal(0)),
    ("min", Time, Multiple(60.0)),
    ("h", Time, Multiple(3600.0)),
    ("nm", Distance, Decimal(-9)),
    ("um", Distance, Decimal(-6)),
    ("mm", Distance, Decimal(-3)),
    ("cm", Distance, Decimal(-2)),
    ("m", Distance, Decimal(0)),
    ("km", Distance, Decimal(3)),
    ("cps", Rate, Decimal(0)),
    ("kcps", Rate, Decimal(3)),
    ("Mcps", Rate, Decimal(6)),
    ("Gcps", Rate, Decimal(9)),
    ("fW", Power, Decimal(-15)),
    ("pW", Power, Decimal(-12)),
    ("nW", Power, Decimal(-9)),
    ("uW", Power, Decimal(-6)),
    ("mW", Power, Decimal(-3)),
    ("W", Power, Decimal(0)),
    ("dBm", Power, Dbm),
    ("um/s", Speed, Decimal(-6)),
    ("mm/s", Speed, Decimal(-3)),
    ("m/s", Speed, Decimal(0)),
    ("km/s", Speed, Decimal(3)),
    ("km/h", Speed, Multiple(1.0 / 3.6)),
    ("ppb", ClockOffset, Decimal(-9)),
    ("ppm", ClockOffset, Decimal(-6)),
    ("ppb/s", ClockDrift, Decimal(-9)),
    ("ppm/s", ClockDrift, Decimal(-6)),
    ("urad", Angle, Decimal(-6)),
    ("mrad", Angle, Decimal(-3)),
    ("rad", Angle, Decimal(0)),
    ("deg", Angle, Multiple(std::f64::consts::PI / 180.0)),
    ("lux", Illuminance, Decimal(0)),
    ("klux", Illuminance, Decimal(3)),
    ("uW/m2/nm", SpectralIrradiance, Decimal(-6)),
    ("mW/m2/nm", SpectralIrradiance, Decimal(-3)),
    ("W/m2/nm", SpectralIrradiance, Decimal(0)),
    // The micro sign and the Greek letter.
    ("\u{b5}s", Time, Decimal(-6)),
    ("\u{3bc}s", Time, Decimal(-6)),
    ("\u{b5}m", Distance, Decimal(-6)),
    ("\u{3bc}m", Distance, Decimal(-6)),
    ("\u{b5}W", Power, Decimal(-6)),
    ("\u{3bc}W", Power, Decimal(-6)),
];

/// Reads `text` as `quantity`, in the quantity's unit. `example` is a right
/// value, for the error message.
///
/// The value is infinite where it is too large for a double.
///
/// Decimal units shift the decimal exponent before the number becomes binary,
/// so that "53.5 ps" and "0.0535 ns" are the same double.
pub(super) fn parse(text: &str, quantity: Quantity, example: &str) -> Result<f64, String> {
    converted(text, quantity, example, quantity.base_exponent())
}

/// The same in the SI unit of the quantity.
pub(super) fn in_si(text: &str, quantity: Quantity, example: &str) -> Result<f64, String> {
    converted(text, quantity, example, 0)
}

fn converted(
    text: &str,
    quantity: Quantity,
    example: &str,
    base_exponent: i32,
) -> Result<f64, String> {
    let (number, unit) = split_number(text.trim());
    let Ok(value) = number.parse::<f64>() else {
        return Err(format!(
            "\"{text}\" is not a number with a unit; write for example \"{example}\""
        ));
    };
    if unit.is_empty() {
        return Err(missing_unit(&format!("\"{text}\""), number, example));
    }
    let (_, found, scale) = find_unit(text, unit, quantity)?;
    if *found != quantity.dimension() {
        let found = match found {
            Distance => "a length",
            other => other.name(),
        };
        return Err(format!(
            "\"{text}\" is {found}, but {} is needed; write for example \"{example}\"",
            quantity.name()
        ));
    }
    Ok(match scale {
        Scale::Decimal(exponent) => shifted(number, exponent - base_exponent),
        Scale::Multiple(factor) => shifted(number, -base_exponent) * factor,
        Scale::Dbm => 1e-3 * 10f64.powf(value / 10.0),
    })
}

/// A number in the SI unit of `quantity` as a scene writes it: in the largest unit that is no larger,
/// by the digits that the number has, so that it is read as the same double.
pub(super) fn in_scene(value: f64, quantity: Quantity) -> String {
    let scientific = format!("{value:e}");
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let thousands = UNITS.iter().filter_map(|(name, of, scale)| match scale {
        Scale::Decimal(power) if *of == quantity.dimension() && power % 3 == 0 => {
            Some((*power, *name))
        }
        _ => None,
    });
    // Spellings that repeat another one's meaning come last.
    let (mut unit, mut smallest) = (None, None);
    for (power, name) in thousands.filter(|(_, name)| name.is_ascii()) {
        if power <= exponent && unit.is_none_or(|(larger, _)| power > larger) {
            unit = Some((power, name));
        }
        if smallest.is_none_or(|(smaller, _)| power < smaller) {
            smallest = Some((power, name));
        }
    }
    let (power, name) = unit.or(smallest).unwrap_or((0, ""));
    format!("{} {name}", placed(mantissa, exponent - power))
}

/// Digits with a point behind the first, times ten to `exponent`, without an exponent unless that
/// takes many zeros.
fn placed(mantissa: &str, exponent: i32) -> String {
    if !(-4..15).contains(&exponent) {
        return format!("{mantissa}e{exponent}");
    }
    let sign = if mantissa.starts_with('-') { "-" } else { "" };
    let mut digits = mantissa.replace(['-', '.'], "");
    if exponent < 0 {
        return format!("{sign}0.{}{digits}", "0".repeat((-exponent - 1) as usize));
    }
    let whole = exponent as usize + 1;
    if digits.len() > whole {
        digits.insert(whole, '.');
    }
    format!("{sign}{digits:0<whole$}")
}

/// The units of a quantity.
pub(super) fn names(quantity: Quantity) -> impl Iterator<Item = &'static str> {
    let is_own = move |(_, of, _): &&Unit| *of == quantity.dimension();
    UNITS.iter().filter(is_own).map(|(name, ..)| *name)
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
    if let Some(unit) = UNITS.iter().find(|(known, ..)| *known == name) {
        return Ok(unit);
    }
    let names: Vec<&str> = names(quantity).filter(|name| name.is_ascii()).collect();
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
