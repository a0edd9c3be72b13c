//! Values of options that have a form of their own.

/// The standard scenes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Like {
    /// The whole way in a second: degree 5
    Quick,
    /// One sensor with the parameters of Table I, degree 11
    PaperSingle,
    /// The same with square-wave modulation
    PaperSquare,
    /// The same with the code interleaved once
    PaperInterleaved,
    /// Two lasers with two codes of one Gold set
    DualView,
    /// One code over two paths, 1.5 chips apart
    Multipath,
    /// A histogram of arrival times in place of up/down counts
    Histogram,
    /// A target that drifts away and fluctuates
    Moving,
}

/// The smallest error that scans can show: it takes 2 10^8 of them.
const LEAST_ERROR: f64 = 1e-4;
const MOST_ERROR: f64 = 0.99;

/// Reads a relative error: "1%" or "0.01".
pub(super) fn parse_error(text: &str) -> Result<f64, String> {
    let (number, scale) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    match number.trim().parse::<f64>() {
        Ok(value) if (LEAST_ERROR..=MOST_ERROR).contains(&(value * scale)) => Ok(value * scale),
        _ => Err(format!(
            "\"{text}\" is no relative error from 0.01% to 99%; write for example 1% or 0.01"
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::parse_error;

    #[test]
    fn an_error_is_a_percentage_or_a_fraction() {
        assert_eq!(parse_error("1%"), Ok(0.01));
        assert_eq!(parse_error("0.25"), Ok(0.25));
        for wrong in [
            "", "%", "0", "-1%", "100%", "nan", "one", "1e-300", "0.001%",
        ] {
            assert!(parse_error(wrong).is_err(), "{wrong}");
        }
    }
}
