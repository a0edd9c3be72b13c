//! Quantities as people write them: a few digits and the unit that suits.

/// Digits grouped by threes from 10,000 on.
pub(super) fn number(number: u64) -> String {
    let digits = number.to_string();
    if number < 10_000 {
        return digits;
    }
    let mut text = String::new();
    for (place, digit) in digits.chars().enumerate() {
        if place > 0 && (digits.len() - place).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

/// A share in percent, rounded down: what is not whole is not shown as whole.
pub(crate) fn percent(share: f64) -> String {
    format!("{:.2} %", (share * 1e4).floor() / 1e2)
}

/// Seconds.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 172_800.0 => format!("{} days", digits(s / 86_400.0)),
        s if s >= 7200.0 => format!("{} h", digits(s / 3600.0)),
        s if s >= 120.0 => format!("{} min", digits(s / 60.0)),
        s => scaled(s, "s"),
    }
}

/// Metres.
pub(super) fn length(metres: f64) -> String {
    match metres.abs() {
        m if m >= 10_000.0 => format!("{} km", digits(metres / 1e3)),
        m if m >= 1.0 => format!("{} m", digits(metres)),
        _ => scaled(metres, "m"),
    }
}

/// Hertz.
pub(super) fn frequency(hertz: f64) -> String {
    scaled(hertz, "Hz")
}

/// Counts per second.
pub(super) fn rate(per_second: f64) -> String {
    scaled(per_second, "cps")
}

/// Bits per second.
pub(super) fn bit_rate(bits_per_s: f64) -> String {
    scaled(bits_per_s, "bit/s")
}

fn scaled(value: f64, unit: &str) -> String {
    const SCALES: [(f64, &str); 8] = [
        (1e9, "G"),
        (1e6, "M"),
        (1e3, "k"),
        (1.0, ""),
        (1e-3, "m"),
        (1e-6, "\u{b5}"),
        (1e-9, "n"),
        (1e-12, "p"),
    ];
    // 999.9999 of a unit is one of the next.
    let scale = SCALES.iter().find(|(scale, _)| value.abs() >= 0.999_95 * scale);
    match scale {
        Some((scale, prefix)) => format!("{} {prefix}{unit}", digits(value / scale)),
        None => format!("0 {unit}"),
    }
}

/// Four significant digits, without zeros at the end.
fn digits(value: f64) -> String {
    let before = (value.abs().max(1e-300).log10().floor() as i32 + 1).max(1);
    let text = format!("{value:.*}", (4 - before).max(0) as usize);
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_four_digits_and_the_unit_that_suits() {
        assert_eq!(number(9999), "9999");
        assert_eq!(number(214_525_612), "214,525,612");
        assert_eq!(time(8e-9), "8 ns");
        assert_eq!(time(104.8e-6), "104.8 \u{b5}s");
        assert_eq!(time(1.716_204_8), "1.716 s");
        assert_eq!(time(90.0 * 86_400.0), "90 days");
        assert_eq!(length(2454.52), "2455 m");
        assert_eq!(length(0.149_896), "149.9 mm");
        assert_eq!(length(-0.002), "-2 mm");
        assert_eq!(length(0.0), "0 m");
        assert_eq!(frequency(125e6), "125 MHz");
        assert_eq!(frequency(999.999_99e3), "1 MHz");
    }
}
