//! The first difference of a co-simulation: bits as they stand at the port, and the
//! numbers that they hold.

use serde::Serialize;

use crate::sensor::Sensor;
use crate::sensor::interface::{Counting, Interface};
use crate::sensor::layout::Field;
use crate::sensor::port::PortRole;

/// A difference as it was found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// Clock, counted from the start of the run; outputs are compared after its
    /// rising edge, and before the next one.
    pub clock: u64,
    /// In what way it differs.
    pub kind: MismatchKind,
    /// Index of the port in [`Layout::outputs`](crate::sensor::layout::Layout::outputs).
    pub field: usize,
    /// The reference model's value, least significant word first.
    pub expected: Vec<u64>,
    /// The Verilog's value.
    pub got: Vec<u64>,
    /// Which of its bits are undefined; empty where none is.
    pub undefined: Vec<u64>,
}

/// The first difference between Verilog and reference model.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct FirstMismatch {
    /// Clock since the start of the run, reset included.
    pub clock: u64,
    /// Time of that clock's start.
    pub time_ps: f64,
    /// In what way the port differs.
    pub kind: MismatchKind,
    /// Port that differs; the first one when several do.
    pub port: String,
    /// The port's bits by the reference model, in hexadecimal digits behind `0x`.
    pub expected: String,
    /// The Verilog's bits; x where four of them hold an undefined one.
    pub got: String,
    /// The numbers that they hold; empty for ports that hold none, and of undefined bits.
    pub numbers: Vec<PortNumber>,
}

/// In what way an output is not what the reference model has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MismatchKind {
    /// It has another value after the clock's rising edge.
    Value,
    /// It has the value after the clock's rising edge, and another one before the next.
    Moved,
    /// It rests on what Verilog leaves undefined: a register before a reset, or an x.
    Undefined,
}

/// A number that some bits of a port hold.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct PortNumber {
    /// What it is: `count`, `total_count` or `phase_step`.
    pub name: &'static str,
    /// The detector that it belongs to, where the port's bits say so.
    pub detector: Option<String>,
    /// By the reference model.
    pub expected: WholeNumber,
    /// By the Verilog.
    pub got: WholeNumber,
}

/// A whole number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(untagged)]
#[schemars(rename = "Number")]
pub enum WholeNumber {
    /// Of a port's bits in two's complement.
    Signed(i64),
    /// Of bits without a sign.
    Unsigned(u64),
}

impl std::fmt::Display for WholeNumber {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            WholeNumber::Signed(number) => number.fmt(f),
            WholeNumber::Unsigned(number) => number.fmt(f),
        }
    }
}

impl FirstMismatch {
    /// The first mismatch of an outcome, of the port `field`.
    pub(crate) fn new(sensor: &Sensor, field: &Field, mismatch: &Mismatch) -> FirstMismatch {
        let Mismatch { clock, kind, expected, got, undefined, .. } = mismatch;
        // The words begin with the port's first bit.
        let alone = Field { word: 0, shift: 0, ..field.clone() };
        let mut numbers = held_by(field.port.role, sensor.interface());
        if !undefined.is_empty() {
            numbers.clear();
        }
        let numbers = numbers.into_iter().map(|held| PortNumber {
            name: held.name,
            detector: held.detector.map(|detector| sensor.scene().detectors[detector].name.clone()),
            expected: held.read(&alone, expected),
            got: held.read(&alone, got),
        });
        FirstMismatch {
            clock: *clock,
            time_ps: sensor.clock().ps(*clock as f64),
            kind: *kind,
            port: field.port.name.clone(),
            expected: hexadecimal(expected, &[]),
            got: hexadecimal(got, undefined),
            numbers: numbers.collect(),
        }
    }

    /// What should be at the port and what is, in words.
    pub fn text(&self) -> String {
        let words = |bits: &str, number: fn(&PortNumber) -> WholeNumber| {
            let numbers: Vec<String> = self
                .numbers
                .iter()
                .filter(|held| held.expected != held.got)
                .map(|held| {
                    let of = held.detector.as_ref().map(|name| format!(" of {name}"));
                    let what = held.name.replace('_', " ") + &of.unwrap_or_default();
                    format!("{what} {}", number(held))
                })
                .collect();
            match numbers.is_empty() {
                true => bits.to_owned(),
                false => format!("{bits} ({})", numbers.join(", ")),
            }
        };
        let expected = words(&self.expected, |held| held.expected);
        let got = words(&self.got, |held| held.got);
        let port = &self.port;
        match self.kind {
            MismatchKind::Value => format!("port {port} should be {expected} and is {got}"),
            MismatchKind::Undefined => format!(
                "port {port} should be {expected} and is {got}: it rests on an x, or on a register \
                 before its reset"
            ),
            MismatchKind::Moved => format!(
                "port {port} should be {expected} until the next rising edge and is {got} by then: \
                 it has moved in between"
            ),
        }
    }
}

/// Where a port holds a number.
struct Held {
    name: &'static str,
    detector: Option<usize>,
    first_bit: u32,
    bits: u32,
    is_signed: bool,
}

impl Held {
    fn read(&self, field: &Field, words: &[u64]) -> WholeNumber {
        let value = field.bits(words, self.first_bit, self.bits);
        match self.is_signed {
            true => {
                let unused = u64::BITS - self.bits;
                WholeNumber::Signed((value << unused).cast_signed() >> unused)
            }
            false => WholeNumber::Unsigned(value),
        }
    }
}

/// The numbers that a port holds, from its lowest bits up.
fn held_by(port: PortRole, interface: &Interface) -> Vec<Held> {
    let of_detectors = |name, bits: u32, is_signed| {
        let detectors = 0..interface.reference_codes.len();
        let held = detectors.map(move |detector| Held {
            name,
            detector: Some(detector),
            first_bit: detector as u32 * bits,
            bits,
            is_signed,
        });
        held.collect()
    };
    let count = |first_bit, bits, is_signed| {
        let (name, detector) = ("count", None);
        Held { name, detector, first_bit, bits, is_signed }
    };
    let correlator = match &interface.counting {
        Counting::Correlator(correlator) => correlator,
        Counting::Histogram(plan) if port == PortRole::Data => {
            let bits = plan.bin_data_bits();
            return (0..plan.row_bins).map(|bin| count(bin * bits, bits, false)).collect();
        }
        Counting::Histogram(_) => return Vec::new(),
    };
    match (port, &correlator.peak) {
        (PortRole::Data, _) => {
            let total = correlator.total.map(|total| Held {
                name: "total_count",
                ..count(total.first_bit, interface.tdata_bits - total.first_bit, false)
            });
            let signed = count(0, correlator.signed_data_bits(), true);
            std::iter::once(signed).chain(total).collect()
        }
        (PortRole::PeakStep, Some(peak)) => of_detectors("phase_step", peak.step_bits, false),
        (PortRole::PeakCount, Some(peak)) => of_detectors("count", peak.count_bits, true),
        _ => Vec::new(),
    }
}

/// Words of a port, the lowest first, as digits: x for one with a bit of `undefined`.
fn hexadecimal(words: &[u64], undefined: &[u64]) -> String {
    let digits = |words: &[u64]| match words {
        [word] => format!("{word:x}"),
        _ => words.iter().rev().map(|word| format!("{word:016x}")).collect(),
    };
    let (digits, undefined) = (digits(words), digits(undefined));
    let length = digits.len().max(undefined.len());
    let digits = format!("{digits:0>length$}").into_bytes();
    let undefined = format!("{undefined:0>length$}").into_bytes();
    let digits = digits.iter().zip(undefined);
    let digits = digits.map(|(&digit, undefined)| if undefined == b'0' { digit } else { b'x' });
    "0x".chars().chain(digits.map(char::from)).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene;
    use crate::sensor::layout::Layout;

    /// Quick's counts have 14 bits in two bytes; with totals of 13 in the two above them.
    #[test]
    fn a_result_is_shown_as_the_signed_number_that_it_is() {
        let mut scene = scene::load(Path::new("../scenes/quick.toml")).unwrap();
        scene.hardware.total_counts = Some(true);
        let sensor = Sensor::new(&scene);
        let total_at = sensor.interface().total().unwrap().first_bit;
        assert_eq!(total_at, sensor.interface().correlator().unwrap().signed_data_bits());
        let layout = Layout::of(sensor.interface());
        let field = layout.outputs.field(PortRole::Data);
        let minus_two = (1u64 << total_at) - 2;
        let expected = [minus_two | 7 << total_at];
        let got = [3 | 7 << total_at];
        let mismatch = Mismatch {
            clock: 5,
            kind: MismatchKind::Value,
            field: 0,
            expected: expected.to_vec(),
            got: got.to_vec(),
            undefined: Vec::new(),
        };
        let mismatch = FirstMismatch::new(&sensor, field, &mismatch);
        assert_eq!(mismatch.time_ps, 40_000.0);
        assert_eq!(mismatch.numbers[0].expected, WholeNumber::Signed(-2));
        assert_eq!(mismatch.numbers[0].got, WholeNumber::Signed(3));
        assert_eq!(mismatch.numbers[1].expected, WholeNumber::Unsigned(7));
        let text = mismatch.text();
        // The totals agree, so they are not spoken of.
        assert!(text.contains("(count -2) and is") && text.ends_with("(count 3)"), "{text}");
    }

    #[test]
    fn words_beyond_the_first_come_before_it() {
        assert_eq!(hexadecimal(&[0x1f], &[]), "0x1f");
        assert_eq!(hexadecimal(&[1, 2], &[]), "0x00000000000000020000000000000001");
    }

    #[test]
    fn a_digit_with_an_undefined_bit_is_x() {
        assert_eq!(hexadecimal(&[0], &[1]), "0xx");
        assert_eq!(hexadecimal(&[0x1f], &[0x400]), "0xx1f");
        assert_eq!(hexadecimal(&[0x21f], &[0x10]), "0x2xf");
        assert_eq!(hexadecimal(&[1, 2], &[0, 1]), "0x000000000000000x0000000000000001");
    }
}
