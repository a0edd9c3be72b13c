/// CRC-32 of IEEE 802.3 (reveng: CRC-32/ISO-HDLC), as of zlib and as `hdl/bridge/crc32.v` computes it.
pub fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, byte| {
        let mixed = crc ^ u32::from(*byte);
        (crc_of_byte(mixed)) ^ (crc >> 8)
    })
}

/// What the lowest byte of a CRC register becomes.
fn crc_of_byte(register: u32) -> u32 {
    TABLE[(register & 0xff) as usize]
}

const TABLE: [u32; 256] = table();

const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut crc = byte as u32;
        let mut bit = 0;
        while bit < 8 {
            crc = (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_catalogues_check_values_come_out() {
        // reveng's catalogue of CRC algorithms: CRC-32/ISO-HDLC, check; the empty text and zlib's of "a".
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
        assert_eq!(crc32(b""), 0);
        assert_eq!(crc32(b"a"), 0xe8b7_be43);
    }
}
