//! Polynomials over GF(2), as bit masks: bit i is the coefficient of x^i.

/// Product of `a` and `b` modulo `modulus` of degree `degree` (at most 31).
/// Both factors have a degree below `degree`.
pub(super) fn multiply_mod(mut a: u64, mut b: u64, modulus: u64, degree: u32) -> u64 {
    let mut product = 0;
    while b != 0 {
        if b & 1 == 1 {
            product ^= a;
        }
        b >>= 1;
        a <<= 1;
        if a >> degree & 1 == 1 {
            a ^= modulus;
        }
    }
    product
}

/// x^`exponent` modulo `modulus` of degree `degree` (at least 2).
pub(super) fn power_of_x_mod(mut exponent: u64, modulus: u64, degree: u32) -> u64 {
    let mut power = 1;
    let mut square = 0b10;
    while exponent != 0 {
        if exponent & 1 == 1 {
            power = multiply_mod(power, square, modulus, degree);
        }
        square = multiply_mod(square, square, modulus, degree);
        exponent >>= 1;
    }
    power
}

/// Whether x has order 2^`degree` - 1 modulo `polynomial`.
///
/// No further test of irreducibility is needed: modulo a reducible polynomial
/// of the same degree the order of x is smaller or even.
pub(super) fn is_primitive(polynomial: u64, degree: u32) -> bool {
    if polynomial & 1 == 0 {
        return false;
    }
    let order = (1 << degree) - 1;
    power_of_x_mod(order, polynomial, degree) == 1
        && prime_factors(order)
            .into_iter()
            .all(|prime| power_of_x_mod(order / prime, polynomial, degree) != 1)
}

/// The distinct prime factors of `number`, by trial division.
fn prime_factors(mut number: u64) -> Vec<u64> {
    let mut factors = Vec::new();
    let mut candidate = 2;
    while candidate * candidate <= number {
        if number.is_multiple_of(candidate) {
            factors.push(candidate);
            while number.is_multiple_of(candidate) {
                number /= candidate;
            }
        }
        candidate += 1;
    }
    if number > 1 {
        factors.push(number);
    }
    factors
}

/// Bit mask of a polynomial given by its exponents.
pub(super) fn mask(exponents: &[u32]) -> u64 {
    exponents.iter().fold(0, |mask, &e| mask | 1 << e)
}

/// Exponents of a bit mask in descending order.
pub(super) fn exponents(mask: u64) -> Vec<u32> {
    (0..u64::BITS).rev().filter(|e| mask >> e & 1 == 1).collect()
}

/// The primitive polynomial of `degree` with the fewest terms, and among those
/// the smallest as a binary number. Exponents in descending order.
///
/// Three or five terms suffice for every degree up to 20 (a primitive
/// polynomial has an odd number of terms).
pub(super) fn first_primitive(degree: u32) -> Option<Vec<u32>> {
    let ends = 1u64 << degree | 1;
    let trinomials = (1..degree).map(|a| ends | 1 << a);
    let pentanomials = (3..degree).flat_map(move |a| {
        (2..a).flat_map(move |b| (1..b).map(move |c| ends | 1 << a | 1 << b | 1 << c))
    });
    trinomials
        .chain(pentanomials)
        .find(|&polynomial| is_primitive(polynomial, degree))
        .map(exponents)
}

/// The shortest recurrence c\[t\] = XOR over e > 0 of c\[t - e\] that makes
/// `sequence` (Berlekamp and Massey), as exponents in descending order with 0
/// last. It is unique once the sequence has twice as many chips as its order.
pub(super) fn shortest_recurrence(sequence: &[u8]) -> Vec<u32> {
    let mut connection: u64 = 1;
    let mut previous: u64 = 1;
    let mut order = 0;
    let mut shift = 1;
    for t in 0..sequence.len() {
        let discrepancy = (0..=order.min(t))
            .filter(|&e| connection >> e & 1 == 1)
            .fold(0, |sum, e| sum ^ sequence[t - e]);
        if discrepancy == 0 {
            shift += 1;
        } else if 2 * order <= t {
            let before = connection;
            connection ^= previous << shift;
            order = t + 1 - order;
            previous = before;
            shift = 1;
        } else {
            connection ^= previous << shift;
            shift += 1;
        }
    }
    exponents(connection)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Euler's totient of 2^n - 1, divided by n, counts them (Golomb).
    #[test]
    fn the_number_of_primitive_polynomials_is_the_published_one() {
        let published =
            [(3, 2), (4, 2), (5, 6), (6, 6), (7, 18), (8, 16), (9, 48), (10, 60), (11, 176)];
        for (degree, count) in published {
            let found =
                (1u64 << degree..1 << (degree + 1)).filter(|&p| is_primitive(p, degree)).count();
            assert_eq!(found, count, "degree {degree}");
        }
    }

    #[test]
    fn an_irreducible_polynomial_of_smaller_order_is_not_primitive() {
        // x has order 5 modulo x^4 + x^3 + x^2 + x + 1.
        assert!(!is_primitive(mask(&[4, 3, 2, 1, 0]), 4));
        assert!(!is_primitive(mask(&[9, 1, 0]), 9));
    }

    #[test]
    fn the_recurrence_of_the_fibonacci_numbers_modulo_2_is_found() {
        assert_eq!(shortest_recurrence(&[1, 1, 0, 1, 1, 0]), [2, 1, 0]);
    }

    #[test]
    fn prime_factors_of_mersenne_numbers_are_the_known_ones() {
        assert_eq!(prime_factors((1 << 11) - 1), [23, 89]);
        assert_eq!(prime_factors((1 << 12) - 1), [3, 5, 7, 13]);
        assert_eq!(prime_factors((1 << 19) - 1), [524_287]);
    }
}
