//! Linear recurrences of bits (Berlekamp and Massey): what an LFSR's output, or a
//! counter's bit of short period, will be.

/// Samples that a recurrence has to explain beyond twice its length, and a period beyond itself; by
/// chance it does once in 2^12.
pub(super) const SPARE_SAMPLES: usize = 12;
/// Most samples in which another recurrence than a period is looked for.
const MOST_SAMPLES: usize = 600;

/// A sequence of bits, each the XOR of some before it.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) struct Recurrence {
    /// Bit i of this list is set if the bit i + 1 places before takes part.
    taps: Vec<u64>,
    /// Bits that take part at most.
    length: usize,
    /// The first bits, at least `length`.
    first: Vec<bool>,
}

impl Recurrence {
    /// The shortest recurrence of a sequence; none if the sequence is too short to tell.
    pub(super) fn of(bits: &[bool]) -> Option<Recurrence> {
        let (connection, length) = shortest(&bits[..bits.len().min(MOST_SAMPLES)]);
        if 2 * length + SPARE_SAMPLES > bits.len().min(MOST_SAMPLES) {
            return None;
        }
        let mut taps = vec![0; length.div_ceil(64)];
        for (i, &tap) in connection.iter().enumerate().take(length + 1).skip(1) {
            taps[(i - 1) / 64] |= u64::from(tap) << ((i - 1) % 64);
        }
        Some(Recurrence { taps, length, first: bits[..length].to_vec() })
    }

    /// The shortest period of a sequence that comes twice; none if the sequence is too short to
    /// tell.
    pub(super) fn periodic(bits: &[bool]) -> Option<Recurrence> {
        let longest = bits.len().checked_sub(SPARE_SAMPLES)?.min(bits.len() / 2);
        let length = (1..=longest).find(|&length| bits[length..] == bits[..bits.len() - length])?;
        let mut taps = vec![0; length.div_ceil(64)];
        taps[(length - 1) / 64] = 1 << ((length - 1) % 64);
        Some(Recurrence { taps, length, first: bits[..length].to_vec() })
    }

    /// The values at some places, which are in order.
    pub(super) fn at(&self, places: &[u64]) -> Vec<bool> {
        match self.repeats() {
            true => {
                let of_place = |place: u64| place.checked_rem(self.length as u64);
                let value = |&place: &u64| of_place(place).map(|place| self.first[place as usize]);
                places.iter().map(|place| value(place).unwrap_or(false)).collect()
            }
            false => self.step_by_step(places),
        }
    }

    /// Whether it has no bits but the first ones, again and again; of none all are 0.
    fn repeats(&self) -> bool {
        let ones: u32 = self.taps.iter().map(|word| word.count_ones()).sum();
        let last = self.length.wrapping_sub(1);
        let is_last = |word: &u64| word >> (last % 64) & 1 == 1;
        ones == 0 && self.length == 0 || ones == 1 && self.taps.last().is_some_and(is_last)
    }

    fn step_by_step(&self, places: &[u64]) -> Vec<bool> {
        // Bit i: the value i + 1 places before the present one.
        let mut before = vec![0u64; self.taps.len()];
        let mut values = Vec::with_capacity(places.len());
        let mut place = 0;
        for &wanted in places {
            loop {
                let ones = before.iter().zip(&self.taps);
                let value = match self.first.get(place as usize) {
                    Some(&first) => first,
                    None => ones.fold(0, |sum, (b, t)| sum ^ (b & t)).count_ones() % 2 == 1,
                };
                if place == wanted {
                    values.push(value);
                    break;
                }
                let mut carry = u64::from(value);
                for word in &mut before {
                    let next = *word >> 63;
                    *word = *word << 1 | carry;
                    carry = next;
                }
                place += 1;
            }
        }
        values
    }
}

/// Connection polynomial, and its length.
fn shortest(bits: &[bool]) -> (Vec<bool>, usize) {
    let mut connection = vec![true];
    let mut previous = vec![true];
    let (mut length, mut since) = (0usize, 1usize);
    for n in 0..bits.len() {
        let discrepancy = (1..=length.min(connection.len() - 1))
            .fold(bits[n], |sum, i| sum ^ (connection[i] & bits[n - i]));
        if !discrepancy {
            since += 1;
            continue;
        }
        let before = connection.clone();
        let needed = previous.len() + since;
        if connection.len() < needed {
            connection.resize(needed, false);
        }
        for (i, &bit) in previous.iter().enumerate() {
            connection[i + since] ^= bit;
        }
        if 2 * length <= n {
            length = n + 1 - length;
            previous = before;
            since = 1;
        } else {
            since += 1;
        }
    }
    (connection, length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_lfsr_is_continued_from_a_short_piece() {
        // x^11 + x^2 + 1, as a Fibonacci register.
        let mut state: u32 = 0x5a5;
        let mut next = || {
            let bit = (state ^ state >> 9) & 1;
            state = state >> 1 | bit << 10;
            bit == 1
        };
        let bits: Vec<bool> = (0..3000).map(|_| next()).collect();
        let recurrence = Recurrence::of(&bits[..60]).unwrap();
        assert_eq!(recurrence.length, 11);
        let places: Vec<u64> = (0..3000).step_by(7).collect();
        let expected: Vec<bool> = places.iter().map(|&p| bits[p as usize]).collect();
        assert_eq!(recurrence.at(&places), expected);
    }

    #[test]
    fn constants_and_short_periods_are_recurrences_and_noise_is_none() {
        for period in [1u32, 2, 8, 13] {
            let bits: Vec<bool> = (0..80).map(|i| i % period < period.div_ceil(2)).collect();
            let recurrence = Recurrence::of(&bits).unwrap();
            let all: Vec<u64> = (0..80).collect();
            assert_eq!(recurrence.at(&all), bits, "period {period}");
            let periodic = Recurrence::periodic(&bits).unwrap();
            assert_eq!(periodic.length, period as usize);
            assert_eq!(periodic.at(&all), bits, "period {period}");
        }
        let mut state = 1u64;
        let noise: Vec<bool> = (0..200)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                state >> 63 == 1
            })
            .collect();
        assert!(Recurrence::of(&noise).is_none());
        assert!(Recurrence::of(&[false; 10]).is_none());
        assert_eq!(Recurrence::of(&[false; 40]).unwrap().at(&[0, 9]), [false; 2]);
    }
}
