//! Values whose width is known at run time.

use std::cmp::Ordering;
use std::ops::{Add, BitAnd, BitOr, BitXor, Not, Shl, Shr, Sub};

/// An unsigned number of `width` bits, at most 128.
///
/// Width 0 marks a bare literal, which takes the width of what it meets.
/// Operands of unequal widths give the wider one here; the back end refuses
/// them, so no hardware comes of it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Word {
    value: u128,
    width: u32,
}

/// A signed number that takes the width of its context: what
/// [`signed_cast`] makes of a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SignedWord(i128);

impl Word {
    /// The low `width` bits of `value`.
    pub fn new(value: u128, width: u32) -> Word {
        let value = if width == 0 { value } else { value & mask(width) };
        Word { value, width }
    }

    /// The number.
    pub fn value(self) -> u128 {
        self.value
    }

    /// The width in bits; the name and type that rust-hdl's casts ask for.
    pub fn bits(self) -> usize {
        self.width as usize
    }

    /// The bit at `index`; 0 beyond the width.
    pub fn get_bit(self, index: usize) -> bool {
        index < 128 && (self.value >> index) & 1 == 1
    }

    /// `width` bits from `low` on.
    pub fn slice(self, low: usize, width: usize) -> Word {
        Word::new((self >> low).value, width as u32)
    }

    /// The word with one bit replaced.
    pub fn replace_bit(self, index: usize, bit: bool) -> Word {
        let cleared = self.value & !(1 << index);
        Word::new(cleared | (u128::from(bit) << index), self.width)
    }

    /// The word moved up by one bit, with `bit` below.
    pub fn shifted_in(self, bit: bool) -> Word {
        (self << 1).replace_bit(0, bit)
    }

    /// The next state of an LFSR of `width` bits that shifts down, with the parity of `taps` on top.
    pub fn advanced(self, width: usize, taps: Word) -> Word {
        (self >> 1).replace_bit(width - 1, (self & taps).xor())
    }

    /// Whether any bit is 1.
    pub fn any(self) -> bool {
        self.value != 0
    }

    /// Whether every bit is 1.
    pub fn all(self) -> bool {
        self.value == mask(self.width)
    }

    /// Parity: the XOR of all bits.
    pub fn xor(self) -> bool {
        self.value.count_ones() % 2 == 1
    }

    fn with(self, other: Word, f: impl Fn(u128, u128) -> u128) -> Word {
        Word::new(f(self.value, other.value), self.width.max(other.width))
    }
}

/// All ones in `width` bits.
fn mask(width: u32) -> u128 {
    u128::MAX.checked_shr(128 - width.min(128)).unwrap_or(0)
}

impl PartialEq for Word {
    fn eq(&self, other: &Word) -> bool {
        self.value == other.value
    }
}

impl PartialOrd for Word {
    /// Unsigned, as the back end writes it.
    fn partial_cmp(&self, other: &Word) -> Option<Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

/// With a number that is settled at elaboration.
impl PartialEq<usize> for Word {
    fn eq(&self, other: &usize) -> bool {
        self.value == (*other as u128)
    }
}

impl PartialOrd<usize> for Word {
    fn partial_cmp(&self, other: &usize) -> Option<Ordering> {
        self.value.partial_cmp(&(*other as u128))
    }
}

impl From<bool> for Word {
    fn from(bit: bool) -> Word {
        Word::new(u128::from(bit), 1)
    }
}

impl From<i32> for Word {
    fn from(literal: i32) -> Word {
        Word::new(literal as u128, 0)
    }
}

impl From<SignedWord> for Word {
    fn from(signed: SignedWord) -> Word {
        Word::new(signed.0 as u128, 0)
    }
}

/// `width` bits side by side, the first one lowest.
pub fn gather(width: usize, bit: impl Fn(usize) -> bool) -> Word {
    (0..width).fold(Word::new(0, width as u32), |word, place| word.replace_bit(place, bit(place)))
}

/// `word` in `width` bits: zero-extended, or its low bits.
pub fn bit_cast(word: impl Into<Word>, width: usize) -> Word {
    Word::new(word.into().value, width as u32)
}

/// `word` as a two's complement number that extends to its context's width.
pub fn signed_cast(word: impl Into<Word>) -> SignedWord {
    let word = word.into();
    let unused = 128 - word.width.clamp(1, 128);
    SignedWord(((word.value << unused) as i128) >> unused)
}

macro_rules! word_operators {
    ($($trait:ident :: $method:ident = $f:expr;)+) => {$(
        impl<T: Into<Word>> $trait<T> for Word {
            type Output = Word;
            fn $method(self, other: T) -> Word {
                self.with(other.into(), $f)
            }
        }
    )+};
}

word_operators! {
    Add::add = u128::wrapping_add;
    Sub::sub = u128::wrapping_sub;
    BitAnd::bitand = |a, b| a & b;
    BitOr::bitor = |a, b| a | b;
    BitXor::bitxor = |a, b| a ^ b;
}

impl Not for Word {
    type Output = Word;
    fn not(self) -> Word {
        Word::new(!self.value, self.width)
    }
}

impl Shl<usize> for Word {
    type Output = Word;
    fn shl(self, bits: usize) -> Word {
        Word::new(self.value.checked_shl(bits as u32).unwrap_or(0), self.width)
    }
}

impl Shr<usize> for Word {
    type Output = Word;
    fn shr(self, bits: usize) -> Word {
        Word::new(self.value.checked_shr(bits as u32).unwrap_or(0), self.width)
    }
}

impl Add for SignedWord {
    type Output = SignedWord;
    fn add(self, other: SignedWord) -> SignedWord {
        SignedWord(self.0.wrapping_add(other.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_wraps_at_the_width() {
        assert_eq!((Word::new(7, 3) + 1).value(), 0);
        assert_eq!((Word::new(0, 5) - 1).value(), 31);
        assert_eq!((!Word::new(0b0101, 4)).value(), 0b1010);
        assert_eq!((Word::new(0b1001, 4) << 1).value(), 0b0010);
    }

    #[test]
    fn signed_words_extend_to_their_context() {
        let minus_one = Word::new(0b11, 2);
        assert_eq!((Word::new(5, 8) + signed_cast(minus_one)).value(), 4);
        assert_eq!((Word::new(0xa5, 8) & signed_cast(true)).value(), 0xa5, "one bit replicates");
        assert_eq!(
            Word::from(signed_cast(minus_one) + signed_cast(minus_one)).value(),
            (-2i128) as u128
        );
    }

    #[test]
    fn reductions_look_at_the_width_only() {
        assert!(Word::new(0b111, 3).all());
        assert!(!Word::new(0b111, 4).all());
        assert!(Word::new(0b0111, 4).xor());
        assert!(!Word::new(0, 4).any());
    }

    #[test]
    fn full_width_words_keep_every_bit() {
        assert_eq!(Word::new(u128::MAX, 128).value(), u128::MAX);
        assert!(Word::new(u128::MAX, 128).all());
    }
}
