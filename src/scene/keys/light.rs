//! Sources, their codes, and the paths of their light.

use super::{Form, Key, Kind, Table};
use crate::code::{MAX_DEGREE, MAX_INTERLEAVE, MIN_DEGREE};
use crate::scene::units::Quantity;

pub(in crate::scene) static SOURCE: Table = Table {
    path: "source",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Words("a text that is not empty", Form::Text),
            default: None,
            example: "\"laser\"",
            meaning: "what paths and detectors call it",
            why: "",
        },
        Key {
            name: "code",
            kind: Kind::Words("a table", Form::Table("source.code")),
            default: None,
            example: "{ family = \"gold\", degree = 11 }",
            meaning: "the code that it repeats without end",
            why: "",
        },
        Key {
            name: "wavelength",
            kind: Kind::Quantity { quantity: Quantity::Wavelength, least: "1 nm", most: "1 mm" },
            default: Some("783 nm"),
            example: "783 nm",
            meaning: "vacuum wavelength",
            why: "soft X-rays to far infrared: what photon counters exist for",
        },
        Key {
            name: "mean_power",
            kind: Kind::Quantity { quantity: Quantity::Power, least: "0 W", most: "1000 W" },
            default: Some("0 W: a source without light, for work on the hardware alone"),
            example: "4 pW",
            meaning: "optical power averaged over the code, at the source",
            why: "no laser is keyed chip by chip at more",
        },
        Key {
            name: "extinction_ratio",
            kind: Kind::Number { least: 1.0, most: 1e15 },
            default: Some("\"inf\": no light in the off-state"),
            example: "10",
            meaning: "on-rate over off-rate, or \"inf\"",
            why: "1 is light without a code; beyond 10^15 a double no longer tells the off-light \
                  from none: write \"inf\"",
        },
        Key {
            name: "clock_offset",
            kind: Kind::Quantity {
                quantity: Quantity::ClockOffset,
                least: "-1000 ppm",
                most: "1000 ppm",
            },
            default: Some("0 ppm: it shares the detectors' clock"),
            example: "20 ppm",
            meaning: "how much faster than the detectors' its clock is; none for a reference",
            why: "ten times what the cheapest quartz may be off",
        },
        Key {
            name: "clock_drift",
            kind: Kind::Quantity {
                quantity: Quantity::ClockDrift,
                least: "-10 ppm/s",
                most: "10 ppm/s",
            },
            default: Some("0 ppm/s"),
            example: "0.1 ppm/s",
            meaning: "how much faster it gets",
            why: "a quartz that is heated by some degrees a second",
        },
        Key {
            name: "rise_time",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "0 s", most: "1 ms" },
            default: Some("0 s"),
            example: "300 ps",
            meaning: "from 10 to 90 % of the light when it turns on, in a straight line, half of it at \
                      the chip's edge",
            why: "no more than 80 % of a chip: an edge ends before the next one begins",
        },
        Key {
            name: "fall_time",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "0 s", most: "1 ms" },
            default: Some("0 s"),
            example: "500 ps",
            meaning: "from 90 to 10 % when it turns off",
            why: "as for `rise_time`",
        },
        Key {
            name: "impulse_response",
            kind: Kind::Words("rows of a time in ps and an amplitude, as CSV text", Form::Text),
            default: Some("none"),
            example: "\"0,0.1\\n100,0.6\\n200,0.3\"",
            meaning: "in place of edges what a flash without width becomes, as measured, in equal \
                      steps; its mean time is the chip's",
            why: "",
        },
    ],
};

pub(in crate::scene) static CODE: Table = Table {
    path: "source.code",
    keys: &[
        Key {
            name: "family",
            kind: Kind::Words(
                "\"gold\", \"m-sequence\", \"square\" or \"chips\"",
                Form::Choice(&["gold", "m-sequence", "square", "chips"]),
            ),
            default: None,
            example: "\"gold\"",
            meaning: "family of the code",
            why: "",
        },
        Key {
            name: "degree",
            kind: Kind::Integer { least: MIN_DEGREE as i64, most: MAX_DEGREE as i64 },
            default: Some("none: Gold codes and m-sequences need it"),
            example: "11",
            meaning: "degree n of the polynomials: 2^n - 1 chips",
            why: "shorter ones make no Gold code; codes are kept in memory, chip by chip",
        },
        Key {
            name: "index",
            kind: Kind::Integer { least: -2, most: (1 << MAX_DEGREE) - 2 },
            default: Some("0"),
            example: "0",
            meaning: "code of the Gold set, -2 to 2^n - 2",
            why: "codes of the largest set",
        },
        Key {
            name: "interleave",
            kind: Kind::Integer { least: 0, most: MAX_INTERLEAVE as i64 },
            default: Some("0"),
            example: "1",
            meaning: "interleaving depth nu: 2^nu times as many chips",
            why: "codes are kept in memory, chip by chip",
        },
        Key {
            name: "polynomials",
            kind: Kind::Integer { least: 0, most: MAX_DEGREE as i64 },
            default: Some("a preferred pair; for an m-sequence its first polynomial"),
            example: "2",
            meaning: "lists of exponents, [[11, 2, 0], [11, 8, 5, 2, 0]]",
            why: "as for `degree`",
        },
        Key {
            name: "seeds",
            kind: Kind::Words("a list of texts of n digits 0 and 1", Form::Texts),
            default: Some("all ones"),
            example: "[\"11111\", \"11111\"]",
            meaning: "first n chips of each m-sequence",
            why: "",
        },
        Key {
            name: "allow_non_preferred",
            kind: Kind::Words("true or false", Form::Boolean),
            default: Some("false"),
            example: "true",
            meaning: "whether a pair that is not preferred may make a Gold set",
            why: "",
        },
        Key {
            name: "chips",
            kind: Kind::Words("a text of digits 0 and 1", Form::Digits),
            default: Some("none: family \"chips\" needs it"),
            example: "\"0110\"",
            meaning: "one period of the code, first chip first",
            why: "",
        },
    ],
};

pub(in crate::scene) static PATH: Table = Table {
    path: "path",
    keys: &[
        Key {
            name: "source",
            kind: Kind::Words("the name of a source", Form::Text),
            default: None,
            example: "\"laser\"",
            meaning: "where the light comes from",
            why: "",
        },
        Key {
            name: "detector",
            kind: Kind::Words("the name of a detector", Form::Text),
            default: None,
            example: "\"spad\"",
            meaning: "where it arrives",
            why: "",
        },
        Key {
            name: "distance",
            kind: Kind::Quantity { quantity: Quantity::Distance, least: "0 m", most: "1500000 km" },
            default: Some("none: `delay` stands for it"),
            example: "3.2 m",
            meaning: "half the optical path",
            why: "four times as far as the moon; as for `delay`",
        },
        Key {
            name: "delay",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "0 s", most: "10.01 s" },
            default: Some("none: `distance` stands for it"),
            example: "21.35 ns",
            meaning: "time of flight",
            why: "a double keeps 2 fs there, 0.3 um of distance",
        },
        Key {
            name: "transmission",
            kind: Kind::Number { least: 0.0, most: 1.0 },
            default: Some("1"),
            example: "0.5",
            meaning: "share of the source's photons that arrive",
            why: "a share",
        },
        Key {
            name: "link",
            kind: Kind::Words("a table", Form::Table("path.link")),
            default: Some("none: `transmission` stands for it"),
            example: "{ reflectance = 0.5, aperture = \"20 mm\" }",
            meaning: "in place of `transmission` what it follows from, at the path's distance",
            why: "",
        },
        Key {
            name: "velocity",
            kind: Kind::Quantity {
                quantity: Quantity::Speed,
                least: "-299 km/s",
                most: "299 km/s",
            },
            default: Some("0 m/s: the path stands still"),
            example: "1.5 m/s",
            meaning: "change of the distance; positive is away from the sensor",
            why: "a thousandth of the speed of light: no relativity is modelled",
        },
        Key {
            name: "fluctuation",
            kind: Kind::Words("a table", Form::Table("path.fluctuation")),
            default: Some("none"),
            example: "{ std = \"2 mm\", correlation_time = \"1 ms\" }",
            meaning: "what the distance does at random beside that",
            why: "",
        },
    ],
};

pub(in crate::scene) static LINK: Table = Table {
    path: "path.link",
    keys: &[
        REFLECTANCE,
        APERTURE,
        OPTICS,
        FILL_FACTOR,
        Key {
            name: "divergence",
            kind: ANGLE,
            default: Some("none: the spot is in the field of view"),
            example: "20 mrad",
            meaning: "full angle of the source's cone, evenly lit",
            why: "lenses look forwards",
        },
        Key {
            name: "field_of_view",
            kind: ANGLE,
            default: Some("none: the spot is in the field of view"),
            example: "10 mrad",
            meaning: "full angle of the detector's cone; of a larger spot the part within it counts",
            why: "as for `divergence`",
        },
    ],
};

pub(in crate::scene) static BACKGROUND: Table = Table {
    path: "detector.background",
    keys: &[
        Key {
            name: "illuminance",
            kind: Kind::Quantity {
                quantity: Quantity::Illuminance,
                least: "0 lux",
                most: "1000 klux",
            },
            default: Some("none: `irradiance` stands for it"),
            example: "10 klux",
            meaning: "sunlight on the target, whose spectrum is known from 350 nm to 1700 nm",
            why: "nine suns at noon",
        },
        Key {
            name: "irradiance",
            kind: Kind::Quantity {
                quantity: Quantity::SpectralIrradiance,
                least: "0 W/m2/nm",
                most: "1000 W/m2/nm",
            },
            default: Some("none: `illuminance` stands for it"),
            example: "100 mW/m2/nm",
            meaning: "light on the target near the source's wavelength",
            why: "the sun has less than two",
        },
        Key {
            name: "filter_width",
            kind: Kind::Quantity {
                quantity: Quantity::Wavelength,
                least: "1e-6 nm",
                most: "10 um",
            },
            default: None,
            example: "10 nm",
            meaning: "width of the filter that passes the source's wavelength",
            why: "from a laser's line to no filter at all",
        },
        Key {
            name: "field_of_view",
            kind: ANGLE,
            default: None,
            example: "10 mrad",
            meaning: "full angle of the cone that the detector sees, filled by the target",
            why: "as for `divergence`",
        },
        REFLECTANCE,
        APERTURE,
        OPTICS,
        FILL_FACTOR,
    ],
};

/// A full angle.
const ANGLE: Kind = Kind::Quantity { quantity: Quantity::Angle, least: "1e-3 urad", most: "3 rad" };

const REFLECTANCE: Key = Key {
    name: "reflectance",
    kind: Kind::Number { least: 0.0, most: 1.0 },
    default: None,
    example: "0.5",
    meaning: "share of the light that the target sends back, in all directions (Lambertian)",
    why: "a share",
};

const APERTURE: Key = Key {
    name: "aperture",
    kind: Kind::Quantity { quantity: Quantity::Distance, least: "1 um", most: "10 m" },
    default: None,
    example: "20 mm",
    meaning: "diameter of the receiving lens",
    why: "from a bare detector to the largest telescope",
};

const OPTICS: Key = Key {
    name: "optics",
    kind: Kind::Number { least: 0.0, most: 1.0 },
    default: Some("1"),
    example: "0.7",
    meaning: "transmission of lenses and filter at the source's wavelength",
    why: "a share",
};

const FILL_FACTOR: Key = Key {
    name: "fill_factor",
    kind: Kind::Number { least: 0.0, most: 1.0 },
    default: Some("1"),
    example: "0.3",
    meaning: "share of the detector's area that detects",
    why: "a share",
};

pub(in crate::scene) static FLUCTUATION: Table = Table {
    path: "path.fluctuation",
    keys: &[
        Key {
            name: "std",
            kind: Kind::Quantity { quantity: Quantity::Distance, least: "0 m", most: "1000 km" },
            default: None,
            example: "2 mm",
            meaning: "standard deviation of the distance",
            why: "light must not overtake itself: see what depends on several keys",
        },
        Key {
            name: "correlation_time",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "16 ps", most: "10000 h" },
            default: None,
            example: "1 ms",
            meaning: "time after which the correlation is 1/e",
            why: "16 of the shortest chips; a year",
        },
    ],
};
