//! Polynomials and seeds as options write them.

use std::convert::Infallible;

/// A text that is not what a command line option takes.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "\"{0}\" is not a polynomial, nor a list of them; write exponents with commas and polynomials \
     with semicolons, as in \"11,2,0;11,8,5,2,0\""
)]
pub struct MalformedPolynomials(String);

/// Reads polynomials from text: "11,2,0;11,8,5,2,0".
pub fn parse_polynomials(text: &str) -> Result<Vec<Vec<u32>>, MalformedPolynomials> {
    let all: Result<Vec<_>, _> = text.split(';').map(parse_polynomial).collect();
    all.map_err(|_| MalformedPolynomials(text.to_owned()))
}

/// Reads one of them.
pub(super) fn parse_polynomial(text: &str) -> Result<Vec<u32>, MalformedPolynomials> {
    let exponents = text.split(',').map(|exponent| exponent.trim().parse().ok());
    exponents.collect::<Option<_>>().ok_or_else(|| MalformedPolynomials(text.to_owned()))
}

/// Reads seeds from text: "11111,10110".
pub fn parse_seeds(text: &str) -> Vec<String> {
    text.split(',').map(|seed| seed.trim().to_owned()).collect()
}

/// Reads one of them: whether it is one is known with the polynomials.
pub(super) fn parse_seed(text: &str) -> Result<String, Infallible> {
    Ok(text.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_read_from_text() {
        assert_eq!(
            parse_polynomials("11,2,0; 11,8,5,2,0"),
            Ok(vec![vec![11, 2, 0], vec![11, 8, 5, 2, 0]])
        );
        for wrong in ["", "11,2,0;", "11 2 0", "11,-2,0"] {
            let expected = MalformedPolynomials(wrong.to_owned());
            assert_eq!(parse_polynomials(wrong), Err(expected));
        }
    }
}
