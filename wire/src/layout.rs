/// Bits of a result on the line, least significant first: its counts, then what is sent with them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Layout {
    /// Bits of a count, 1 to 64.
    pub count_bits: u8,
    /// Counts of a result, 1 or more: a histogram's row has one for each sample of the chip.
    pub counts: u8,
    /// Bits of what is sent with them, 0 to 64: a total count, a peak's phase step; 0: nothing.
    pub more_bits: u8,
}

impl Layout {
    /// Whether it is one that the bridge can have, and a result here can hold: 128 bits at most.
    pub fn is_possible(self) -> bool {
        (1..=64).contains(&self.count_bits)
            && self.counts > 0
            && self.more_bits <= 64
            && self.result_bits() <= 128
    }

    /// Bits of a result.
    pub fn result_bits(self) -> usize {
        usize::from(self.count_bits) * usize::from(self.counts) + usize::from(self.more_bits)
    }

    /// Bytes of so many results, packed bit by bit.
    pub fn payload_bytes(self, results: usize) -> usize {
        (results * self.result_bits()).div_ceil(8)
    }

    /// A result's count `k`, signed.
    pub fn count(self, result: u128, k: u8) -> i64 {
        let unused = 64 - u32::from(self.count_bits);
        (self.unsigned_count(result, k) as i64) << unused >> unused
    }

    /// A result's count `k`, which has no sign: a bin of a histogram.
    pub fn unsigned_count(self, result: u128, k: u8) -> u64 {
        field(result, u32::from(k) * u32::from(self.count_bits), self.count_bits)
    }

    /// What is sent behind the counts.
    pub fn more(self, result: u128) -> u64 {
        field(result, u32::from(self.counts) * u32::from(self.count_bits), self.more_bits)
    }
}

/// `bits` bits of a result from `first` on.
fn field(result: u128, first: u32, bits: u8) -> u64 {
    let above = result.checked_shr(first).unwrap_or(0);
    (above & ((1 << bits) - 1)) as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_where_their_bits_are() {
        let layout = Layout { count_bits: 5, counts: 3, more_bits: 7 };
        let result = 85 << 15 | 1 << 10 | 31 << 5 | 16;
        assert_eq!([0, 1, 2].map(|k| layout.count(result, k)), [-16, -1, 1]);
        assert_eq!([0, 1, 2].map(|k| layout.unsigned_count(result, k)), [16, 31, 1]);
        assert_eq!(layout.more(result), 85);
        let whole = Layout { count_bits: 64, counts: 1, more_bits: 64 };
        assert_eq!((whole.count(u128::MAX, 0), whole.more(u128::MAX)), (-1, u64::MAX));
    }

    #[test]
    fn payloads_fill_whole_bytes() {
        let layout = Layout { count_bits: 18, counts: 1, more_bits: 0 };
        assert_eq!([1, 4, 255].map(|results| layout.payload_bytes(results)), [3, 9, 574]);
    }
}
