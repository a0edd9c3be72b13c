//! Files of time tags as a HydraHarp writes them (version 2, T2 mode): a writer of the tests' own.

/// Records of this kind.
pub const HYDRAHARP_2_T2: u64 = 0x0101_0204;

/// A tag of a PTU header.
fn header_tag(name: &str, kind: u32, value: u64) -> Vec<u8> {
    let mut tag = vec![0; 32];
    tag[..name.len()].copy_from_slice(name.as_bytes());
    tag.extend((-1_i32).to_le_bytes());
    tag.extend(kind.to_le_bytes());
    tag.extend(value.to_le_bytes());
    tag
}

/// A header.
pub fn header(record_type: u64, resolution_s: f64, records: u64) -> Vec<u8> {
    let mut bytes = b"PQTTTR\0\x001.0.00\0\0".to_vec();
    // A text of its own behind a tag, which readers pass over.
    bytes.extend(header_tag("File_Comment", 0x4001_FFFF, 16));
    bytes.extend(b"light of a test\0");
    bytes.extend(header_tag("MeasDesc_GlobalResolution", 0x2000_0008, resolution_s.to_bits()));
    bytes.extend(header_tag("TTResultFormat_TTTRRecType", 0x1000_0008, record_type));
    bytes.extend(header_tag("TTResult_NumberOfRecords", 0x1000_0008, records));
    bytes.extend(header_tag("Header_End", 0xFFFF_0008, 0));
    bytes
}

/// Records in ticks of a picosecond, and the overflows between them.
#[derive(Debug, Default)]
pub struct Hydraharp {
    bytes: Vec<u8>,
    overflows: u64,
}

impl Hydraharp {
    /// Puts a record, no earlier than the one before: of the inputs 0 and up, or of the marker -1, -2 ...
    pub fn put(&mut self, ticks: u64, channel: i32) {
        let more = (ticks >> 25) - self.overflows;
        if more > 0 {
            self.word(0xFE00_0000 | more as u32);
            self.overflows += more;
        }
        let low = (ticks & 0x01FF_FFFF) as u32;
        self.word(match channel {
            marker if marker < 0 => 0x8000_0000 | 1 << (24 - marker) as u32 | low,
            input => (input as u32) << 25 | low,
        });
    }

    fn word(&mut self, word: u32) {
        self.bytes.extend(word.to_le_bytes());
    }

    /// The file.
    pub fn file(self) -> Vec<u8> {
        [header(HYDRAHARP_2_T2, 1e-12, self.bytes.len() as u64 / 4), self.bytes].concat()
    }
}
