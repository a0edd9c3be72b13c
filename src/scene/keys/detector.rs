//! Detectors.

use super::{Form, Key, Kind, Table};
use crate::scene::units::Quantity;

pub(in crate::scene) static DETECTOR: Table = Table {
    path: "detector",
    keys: &[
        Key {
            name: "name",
            kind: Kind::Words("a text that is not empty", Form::Text),
            default: None,
            example: "\"spad\"",
            meaning: "what paths call it",
            why: "",
        },
        Key {
            name: "reference",
            kind: Kind::Words("the name of a source", Form::Text),
            default: None,
            example: "\"laser\"",
            meaning: "source whose code the sign follows",
            why: "",
        },
        Key {
            name: "photon_detection_probability",
            kind: Kind::Number { least: 0.0, most: 1.0 },
            default: Some("1"),
            example: "0.31",
            meaning: "chance that an incident photon fires a ready detector",
            why: "a probability",
        },
        Key {
            name: "dark_count_rate",
            kind: Kind::Quantity { quantity: Quantity::Rate, least: "0 cps", most: "1000000 Gcps" },
            default: Some("0 cps"),
            example: "71 kcps",
            meaning: "avalanches without light",
            why: "one in a femtosecond",
        },
        Key {
            name: "background_rate",
            kind: Kind::Quantity { quantity: Quantity::Rate, least: "0 cps", most: "1000000 Gcps" },
            default: Some("0 cps"),
            example: "1 Mcps",
            meaning: "background, in photons before the detection probability",
            why: "one in a femtosecond",
        },
        Key {
            name: "background",
            kind: Kind::Words("a table", Form::Table("detector.background")),
            default: Some("none: `background_rate` stands for it"),
            example: "{ illuminance = \"10 klux\", filter_width = \"10 nm\", reflectance = 0.5, aperture = \"20 mm\", field_of_view = \"10 mrad\" }",
            meaning: "in place of `background_rate` what it follows from",
            why: "",
        },
        Key {
            name: "dead_time",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "0 s", most: "10 ms" },
            default: Some("0 s"),
            example: "14 ns",
            meaning: "non-paralyzable dead time, from the avalanche",
            why: "a passively quenched detector with a slow counter has some microseconds; 10^5 \
                  dead times of warm-up are within 64 bits of chips",
        },
        Key {
            name: "afterpulsing",
            kind: Kind::Words("a table", Form::Table("detector.afterpulsing")),
            default: Some("none"),
            example: "{ probability = 0.137, time_constant = \"5 ns\" }",
            meaning: "avalanches that an avalanche causes later",
            why: "",
        },
        Key {
            name: "pulse_width",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "1 fs", most: "10 ms" },
            default: Some("half the dead time, but at least a phase step"),
            example: "7 ns",
            meaning: "width of the digital pulse that a detection makes",
            why: "as for `dead_time`",
        },
        Key {
            name: "delay",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "0 s", most: "1 ms" },
            default: Some("0 s"),
            example: "1.75 ns",
            meaning: "constant delay from avalanche to registered time",
            why: "200 km of cable",
        },
        Key {
            name: "jitter",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "0 s", most: "1 ms" },
            default: Some("none"),
            example: "53.5 ps",
            meaning: "list of the standard deviations of independent Gaussian jitters",
            why: "in all no more than 65,536 chips: detections of twenty of them are put in order",
        },
        Key {
            name: "jitter_tail",
            kind: Kind::Words("a table", Form::Table("detector.jitter_tail")),
            default: Some("none"),
            example: "{ share = 0.1, time_constant = \"200 ps\" }",
            meaning: "further delay of some detections, beside the Gaussian ones: the diffusion tail",
            why: "",
        },
        Key {
            name: "jitter_histogram",
            kind: Kind::Words(
                "rows of a time from 0 ps on and an amplitude, as CSV text",
                Form::Text,
            ),
            default: Some("none"),
            example: "\"0,0.9\\n100,0.07\\n200,0.03\"",
            meaning: "the same, as measured: the delay's distribution in equal steps",
            why: "",
        },
        Key {
            name: "counter",
            kind: Kind::Words("a table", Form::Table("detector.counter")),
            default: Some("none"),
            example: "{ rising_delay = \"340 ps\", falling_delay = \"390 ps\" }",
            meaning: "edges of the article's continuous-time counter",
            why: "",
        },
    ],
};

pub(in crate::scene) static AFTERPULSING: Table = Table {
    path: "detector.afterpulsing",
    keys: &[
        Key {
            name: "probability",
            kind: Kind::Number { least: 0.0, most: 0.999999 },
            default: None,
            example: "0.137",
            meaning: "chance that an avalanche causes at least one afterpulse",
            why: "fourteen afterpulses for every avalanche",
        },
        Key {
            name: "time_constant",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "1 fs", most: "10 ms" },
            default: None,
            example: "5 ns",
            meaning: "exponential time constant, from the dead time's end",
            why: "a simulation begins thirty of them early",
        },
    ],
};

pub(in crate::scene) static JITTER_TAIL: Table = Table {
    path: "detector.jitter_tail",
    keys: &[
        Key {
            name: "share",
            kind: Kind::Number { least: 0.0, most: 1.0 },
            default: None,
            example: "0.1",
            meaning: "share of the detections that come later",
            why: "a share",
        },
        Key {
            name: "time_constant",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "1 fs", most: "10 us" },
            default: None,
            example: "200 ps",
            meaning: "mean of these delays, which are exponential",
            why: "a simulation begins thirty of them early; no longer than jitter may be",
        },
    ],
};

/// What a counter's edge may be late.
const EDGE: Kind = Kind::Quantity { quantity: Quantity::Time, least: "0 s", most: "1 ms" };

pub(in crate::scene) static COUNTER: Table = Table {
    path: "detector.counter",
    keys: &[
        Key {
            name: "rising_delay",
            kind: EDGE,
            default: Some("0 s"),
            example: "340 ps",
            meaning: "how late the sign's rising edge comes",
            why: "no more than 65,536 chips: the sign looks back over the difference of the delays, \
                  chip by chip",
        },
        Key {
            name: "falling_delay",
            kind: EDGE,
            default: Some("0 s"),
            example: "390 ps",
            meaning: "how late the sign's falling edge comes",
            why: "as for `rising_delay`",
        },
        Key {
            name: "transition",
            kind: EDGE,
            default: Some("0 s"),
            example: "1.5 ps",
            meaning: "within this distance of an edge either sign is equally likely",
            why: "as for `rising_delay`",
        },
    ],
};
