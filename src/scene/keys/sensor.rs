//! Clock, scan, estimate and hardware.

use super::{Form, Key, Kind, Table};
use crate::scene::units::Quantity;

/// Most phase steps of a code period: the longest code, with the most samples.
const MOST_PHASE_STEPS: i64 = (crate::code::MAX_CODE_CHIPS * 64) as i64;

pub(in crate::scene) static CLOCK: Table = Table {
    path: "clock",
    keys: &[
        Key {
            name: "chip_period",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "1 ps", most: "10 ms" },
            default: None,
            example: "8 ns",
            meaning: "chip period T_c; one clock of the hardware",
            why: "1 THz is beyond any hardware, and a delay of 10 s still counts in chips to \
                  0.002; slower than 100 Hz nothing is sampled",
        },
        Key {
            name: "samples_per_chip",
            kind: Kind::Integer { least: 1, most: 64 },
            default: Some("8"),
            example: "8",
            meaning: "samples, and phase steps, per chip S; a power of two",
            why: "a clock's samples of a detector are one word of 64 bits",
        },
    ],
};

pub(in crate::scene) static SCAN: Table = Table {
    path: "scan",
    keys: &[
        Key {
            name: "integration",
            kind: Kind::Quantity { quantity: Quantity::Time, least: "1 ps", most: "1000000 s" },
            default: None,
            example: "100 us",
            meaning: "integration time of a phase step, rounded to whole chips; of a histogram, to \
                      whole code periods",
            why: "the shortest chip period; eleven days, in which the number of samples stays within 64 \
                  bits",
        },
        Key {
            name: "steps",
            kind: Kind::Words("\"all\" or a table of phase steps", Form::AllOr("scan.steps")),
            default: Some("\"all\""),
            example: "\"all\"",
            meaning: "which phase steps are measured",
            why: "",
        },
    ],
};

pub(in crate::scene) static STEPS: Table = Table {
    path: "scan.steps",
    keys: &[
        Key {
            name: "first",
            kind: Kind::Integer { least: 0, most: MOST_PHASE_STEPS - 1 },
            default: Some("none: the window is given with `around`"),
            example: "0",
            meaning: "first phase step, less than those of a code period",
            why: "phase steps of the longest code, 2^24 chips, with 64 samples per chip",
        },
        Key {
            name: "count",
            kind: Kind::Integer { least: 1, most: MOST_PHASE_STEPS },
            default: Some("none: the window is given with `around`"),
            example: "64",
            meaning: "number of phase steps, no more than those of a code period",
            why: "as for `first`",
        },
        Key {
            name: "around",
            kind: Kind::Quantity { quantity: Quantity::Distance, least: "0 m", most: "1500000 km" },
            default: Some("none: the window is given with `first`"),
            example: "3.2 m",
            meaning: "distance (or time of flight, 0 s to 10 s) in the middle of the window",
            why: "as for `path.distance` and `path.delay`",
        },
        Key {
            name: "halfwidth",
            kind: Kind::Integer { least: 0, most: MOST_PHASE_STEPS / 2 },
            default: Some("none: the window is given with `first`"),
            example: "16",
            meaning: "phase steps on either side of the middle",
            why: "as for `first`",
        },
    ],
};

pub(in crate::scene) static ESTIMATE: Table = Table {
    path: "estimate",
    keys: &[
        Key {
            name: "estimator",
            kind: Kind::Words("\"fft\" or \"model\"", Form::Choice(&["fft", "model"])),
            default: Some("\"fft\""),
            example: "\"fft\"",
            meaning: "how counts become distances",
            why: "",
        },
        Key {
            name: "other_light",
            kind: Kind::Words(
                "\"given\", \"search\" or \"none\"",
                Form::Choice(&["given", "search", "none"]),
            ),
            default: Some("\"given\""),
            example: "\"given\"",
            meaning: "which light besides the strongest path the model estimator looks for",
            why: "",
        },
    ],
};

pub(in crate::scene) static HARDWARE: Table = Table {
    path: "hardware",
    keys: &[
        Key {
            name: "target",
            kind: Kind::Words(
                "\"ecp5-25k-6\", \"ice40-hx8k\" or \"xc7\"",
                Form::Choice(&["ecp5-25k-6", "ice40-hx8k", "xc7"]),
            ),
            default: Some("\"ecp5-25k-6\""),
            example: "\"ecp5-25k-6\"",
            meaning: "device that the hardware is built for",
            why: "",
        },
        Key {
            name: "architecture",
            kind: Kind::Words(
                "\"updown\" or \"histogram\"",
                Form::Choice(&["updown", "histogram"]),
            ),
            default: Some("\"updown\""),
            example: "\"histogram\"",
            meaning: "whether hits are counted up and down, one phase step after another, or by \
                      their time in the code period, for all phase steps at once",
            why: "",
        },
        Key {
            name: "parallel",
            kind: Kind::Integer { least: 1, most: 64 },
            default: Some("1"),
            example: "8",
            meaning: "phase steps correlated at once, no more than the scan has",
            why: "what fits into the targets",
        },
        Key {
            name: "counter_width",
            kind: Kind::Integer { least: 2, most: 64 },
            default: Some("as wide as no stimulus can overflow"),
            example: "20",
            meaning: "bits of a count in the results, or of a histogram's bin",
            why: "a sign and a bit; the reference model's counts have 64 bits",
        },
        Key {
            name: "total_counts",
            kind: Kind::Words("true or false", Form::Boolean),
            default: Some("true with estimator \"model\", else false"),
            example: "true",
            meaning: "whether results carry the total count of a step beside the signed one",
            why: "",
        },
        Key {
            name: "peak_detector",
            kind: Kind::Words("true or false", Form::Boolean),
            default: Some("false"),
            example: "true",
            meaning: "whether the hardware finds the largest count of a scan",
            why: "",
        },
        Key {
            name: "buffers",
            kind: Kind::Integer { least: 1, most: 2 },
            default: Some("2"),
            example: "1",
            meaning: "histograms that each detector has memory for: with 2 one counts while the \
                      other is read, as slowly as the receiver likes; with 1 a row leaves at each \
                      clock of the next frame's first code period, and the receiver has to take it",
            why: "a third would wait for nothing",
        },
    ],
};
