//! Run-length words for `$readmemh`: values that hold for many clocks are short.

/// Values of consecutive clocks, run by run; all of as many words.
#[derive(Debug, Clone, Default)]
pub struct Runs {
    /// Clocks of each run.
    clocks: Vec<u64>,
    /// Words of one value after those of another.
    values: Vec<u64>,
}

/// Words `{value, repeats}`: `value` holds for `repeats` + 1 clocks. `repeats`
/// fills whole hexadecimal digits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RunLengthWords {
    /// Number of words.
    pub count: u64,
    /// Bits of `repeats`.
    pub repeat_bits: u32,
    /// The words in hexadecimal, several to a line.
    pub text: String,
}

/// Words are put on a line until it is at least this long.
const LINE_CHARACTERS: usize = 90;

impl Runs {
    /// None so far, with memory for so many, whose values have so many words.
    pub fn with_room(runs: usize, words: usize) -> Runs {
        Runs { clocks: Vec::with_capacity(runs), values: Vec::with_capacity(runs * words) }
    }

    /// Adds a value for some clocks, least significant word first.
    pub fn push(&mut self, value: &[u64], clocks: u64) {
        match self.clocks.last_mut() {
            Some(before) if self.values.ends_with(value) => *before += clocks,
            _ if clocks == 0 => {}
            _ => self.begin(value.len(), clocks).copy_from_slice(value),
        }
    }

    /// The same of a value that is known to be another than the one before it: of so many words,
    /// zero until they are written.
    pub fn begin(&mut self, words: usize, clocks: u64) -> &mut [u64] {
        self.clocks.push(clocks);
        let start = self.values.len();
        self.values.resize(start + words, 0);
        &mut self.values[start..]
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.clocks.is_empty()
    }

    /// Adds the last value for some more clocks, if there is one.
    pub fn prolong(&mut self, more: u64) {
        if let Some(clocks) = self.clocks.last_mut() {
            *clocks += more;
        }
    }

    /// Encodes values of `bits` bits, with `repeats` as wide as makes the text
    /// shortest.
    pub fn encode(&self, bits: u32) -> RunLengthWords {
        let value_digits = bits.div_ceil(4);
        // Words, with one digit of repeats and with more.
        let mut counts = [0; 4];
        for clocks in &self.clocks {
            for (bits, count) in (4..).step_by(4).zip(&mut counts) {
                *count += ((clocks - 1) >> bits) + 1;
            }
        }
        let characters = |&(repeat_digits, count): &(u32, u64)| {
            count * u64::from(repeat_digits + value_digits + 1)
        };
        let shortest = (1..).zip(counts).min_by_key(characters);
        let (repeat_digits, count) = shortest.unwrap_or((1, 0));
        let longest = 1u64 << (4 * repeat_digits);
        let mut text =
            Vec::with_capacity(count as usize * (value_digits + repeat_digits + 1) as usize);
        // Where the line begins.
        let mut line = 0;
        let words = self.values.len() / self.clocks.len().max(1);
        for (run, &clocks) in self.clocks.iter().enumerate() {
            let value = &self.values[run * words..][..words];
            let mut left = clocks;
            while left > 0 {
                let run = left.min(longest);
                left -= run;
                if text.len() > line {
                    text.push(b' ');
                }
                put_hexadecimal(&mut text, value, value_digits);
                put_hexadecimal(&mut text, &[run - 1], repeat_digits);
                if text.len() - line >= LINE_CHARACTERS {
                    text.push(b'\n');
                    line = text.len();
                }
            }
        }
        if text.len() > line {
            text.push(b'\n');
        }
        let text = String::from_utf8(text).expect("digits, spaces and line ends are ASCII");
        RunLengthWords { count, repeat_bits: 4 * repeat_digits, text }
    }
}

/// The lowest `digits` hexadecimal digits of a number, the first word lowest.
fn put_hexadecimal(text: &mut Vec<u8>, words: &[u64], digits: u32) {
    let start = text.len();
    text.resize(start + digits as usize, b'0');
    for (digits, &word) in text[start..].rchunks_mut(16).zip(words) {
        for (shift, digit) in (0..).step_by(4).zip(digits.iter_mut().rev()) {
            *digit = b"0123456789abcdef"[(word >> shift & 15) as usize];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn runs(values: &[(u64, u64)]) -> Runs {
        let mut runs = Runs::default();
        for &(clocks, value) in values {
            runs.push(&[value], clocks);
        }
        runs
    }

    #[test]
    fn a_word_is_the_repeats_and_the_value() {
        let words = runs(&[(1, 0x2a), (16, 0x3)]).encode(7);
        assert_eq!(words.text, "2a0 03f\n");
        assert_eq!((words.count, words.repeat_bits), (2, 4));
    }

    #[test]
    fn long_runs_get_wider_repeats() {
        let words = runs(&[(4096, 1), (300, 0)]).encode(1);
        assert_eq!(words.text, "1fff 012b\n");
    }

    #[test]
    fn values_wider_than_a_word_keep_their_order() {
        let mut runs = Runs::default();
        runs.push(&[0x0123_4567_89ab_cdef, 0x5], 1);
        let words = runs.encode(68);
        assert_eq!(words.text, "50123456789abcdef0\n");
    }
}
