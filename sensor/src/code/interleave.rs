//! Interleaving (eq. 23).

/// Interleaves one code period to depth `nu` (eq. 23): chip i of the result is chip
/// floor(i / 2^nu) of `chips`, inverted where i is odd. The result has 2^nu
/// times as many chips. Depth 0 means no interleaving: the chips as they are,
/// without eq. 23's inversion, which would not be periodic for an odd length.
pub fn interleave(chips: &[u8], nu: u32) -> Vec<u8> {
    if nu == 0 {
        return chips.to_vec();
    }
    let copies = 1usize << nu;
    chips.iter().flat_map(|&chip| (0..copies).map(move |i| chip ^ (i & 1) as u8)).collect()
}

#[cfg(test)]
mod tests {
    use super::interleave;

    #[test]
    fn every_chip_becomes_a_square_wave_whose_sign_it_carries() {
        assert_eq!(interleave(&[1, 0, 0], 1), [1, 0, 0, 1, 0, 1]);
        assert_eq!(interleave(&[1, 0], 2), [1, 0, 1, 0, 0, 1, 0, 1]);
        assert_eq!(interleave(&[1, 0, 0], 0), [1, 0, 0]);
    }
}
