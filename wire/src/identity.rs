use thiserror::Error;

use crate::Layout;

/// Version of the protocol in docs/wire.md.
const VERSION: u8 = 1;

/// What the results of a device are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// Counts of phase steps, in the order of `m_axis_tdata` (docs/conventions.md).
    Counts,
    /// Rows of a histogram.
    Rows,
    /// The peak of each scan: its count, and behind it its phase step.
    Peaks,
}

/// What a device says of itself when it is asked: the 32 bytes of the bridge's parameter `IDENTITY`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identity {
    /// What the results are.
    pub content: Content,
    /// Their bits.
    pub layout: Layout,
    /// Detectors, 1 to 255.
    pub detectors: u8,
    /// Samples per chip, S.
    pub samples_per_chip: u8,
    /// Period of the chip clock in femtoseconds, as the board's clock makes it.
    pub chip_period_fs: u32,
    /// First phase step of a scan, less than 2^24.
    pub first_step: u32,
    /// Phase steps of a scan, or rows of a histogram; less than 2^24.
    pub steps: u32,
    /// Chips of the code period, less than 2^24.
    pub code_chips: u32,
    /// Phase steps that are correlated at once.
    pub parallel: u16,
    /// Scans whose counts are added up before they leave, at least 1.
    pub accumulate: u8,
    /// Blocks of [`crate::BLOCK_BYTES`] of the scene's text that the device holds; 0: none.
    pub text_blocks: u8,
    /// Whether it counts hits by sample of the chip.
    pub counts_samples: bool,
    /// The first eight bytes of the scene's SHA-256 (`scene.sha256` of the manifest).
    pub scene: [u8; 8],
}

/// Why 32 bytes are no identity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum IdentityError {
    /// Another protocol.
    #[error("the device speaks version {0} of the protocol, and this program version {VERSION}")]
    Version(u8),
    /// Something that this version does not have.
    #[error("the device's identity is not one that a bridge can have: {0}")]
    Impossible(&'static str),
}

impl Identity {
    /// The bytes as the device sends them, and as the parameter `IDENTITY` holds them, byte 0 in its
    /// lowest bits.
    pub fn to_bytes(&self) -> [u8; 32] {
        let mut bytes = [0; 32];
        bytes[0] = VERSION;
        bytes[1] = match self.content {
            Content::Counts => 0,
            Content::Rows => 1,
            Content::Peaks => 2,
        };
        bytes[2] = self.layout.count_bits;
        bytes[3] = self.layout.counts;
        bytes[4] = self.layout.more_bits;
        bytes[5] = self.detectors;
        bytes[6] = self.samples_per_chip;
        // 0 as of before there were sums.
        bytes[7] = if self.accumulate == 1 { 0 } else { self.accumulate };
        bytes[8..12].copy_from_slice(&self.chip_period_fs.to_le_bytes());
        for (first, number) in [(12, self.first_step), (15, self.steps), (18, self.code_chips)] {
            bytes[first..first + 3].copy_from_slice(&number.to_le_bytes()[..3]);
        }
        bytes[21] = self.text_blocks & 0x7f | u8::from(self.counts_samples) << 7;
        bytes[22..24].copy_from_slice(&self.parallel.to_le_bytes());
        bytes[24..].copy_from_slice(&self.scene);
        bytes
    }

    /// The parameter `IDENTITY` in Verilog: `256'h...`.
    pub fn to_verilog(&self) -> String {
        let digits = self.to_bytes().into_iter().rev().map(|byte| format!("{byte:02x}"));
        format!("256'h{}", digits.collect::<String>())
    }

    /// What a device said.
    ///
    /// # Errors
    ///
    /// Another version of the protocol, or numbers that no bridge can have.
    pub fn from_bytes(bytes: &[u8; 32]) -> Result<Identity, IdentityError> {
        if bytes[0] != VERSION {
            return Err(IdentityError::Version(bytes[0]));
        }
        let content = match bytes[1] {
            0 => Content::Counts,
            1 => Content::Rows,
            2 => Content::Peaks,
            _ => return Err(IdentityError::Impossible("what its results are is not known")),
        };
        let number = |first: usize, count: usize| {
            (0..count).rev().fold(0, |sum, k| sum << 8 | u32::from(bytes[first + k]))
        };
        let identity = Identity {
            content,
            layout: Layout { count_bits: bytes[2], counts: bytes[3], more_bits: bytes[4] },
            detectors: bytes[5],
            samples_per_chip: bytes[6],
            chip_period_fs: number(8, 4),
            first_step: number(12, 3),
            steps: number(15, 3),
            code_chips: number(18, 3),
            parallel: number(22, 2) as u16,
            accumulate: bytes[7].max(1),
            text_blocks: bytes[21] & 0x7f,
            counts_samples: bytes[21] >> 7 == 1,
            scene: std::array::from_fn(|k| bytes[24 + k]),
        };
        identity.check()?;
        Ok(identity)
    }

    /// Whether a bridge can have these numbers.
    fn check(&self) -> Result<(), IdentityError> {
        if !self.layout.is_possible() {
            return Err(IdentityError::Impossible("bits of a result"));
        }
        let at_least_one = [
            (u32::from(self.detectors), "no detector"),
            (u32::from(self.samples_per_chip), "no samples in a chip"),
            (self.chip_period_fs, "no chip period"),
            (self.steps, "no phase steps"),
            (self.code_chips, "no code"),
            (u32::from(self.parallel), "no phase steps at once"),
        ];
        match at_least_one.iter().find(|(number, _)| *number == 0) {
            Some((_, what)) => Err(IdentityError::Impossible(what)),
            None => Ok(()),
        }
    }

    /// Results of a scan, all detectors together; of peaks one.
    pub fn results_of_scan(&self) -> u64 {
        match self.content {
            Content::Counts | Content::Rows => u64::from(self.steps) * u64::from(self.detectors),
            Content::Peaks => 1,
        }
    }

    /// Detector and step (both from 0, the step within the scan) of a scan's result `index`. Within a
    /// group of `parallel` steps come detector 0's, then detector 1's, ...; of histograms detector 0's rows,
    /// then detector 1's.
    pub fn place(&self, index: u64) -> (u64, u64) {
        let (steps, detectors) = (u64::from(self.steps), u64::from(self.detectors));
        let group = match self.content {
            Content::Rows => steps,
            Content::Counts | Content::Peaks => u64::from(self.parallel).min(steps),
        };
        let first = index / (group * detectors) * group;
        // The last group may have fewer.
        let of_group = group.min(steps.saturating_sub(first)).max(1);
        let within = index - first * detectors;
        (within / of_group, first + within % of_group)
    }

    /// Phase step k of a scan's step: a scan that comes to the code period's end goes on at its beginning.
    pub fn phase_step(&self, step: u64) -> u64 {
        (u64::from(self.first_step) + step)
            % (u64::from(self.samples_per_chip) * u64::from(self.code_chips))
    }

    /// Distance of phase step k, half the optical path, in metres.
    pub fn distance_m(&self, phase_step: f64) -> f64 {
        const LIGHT_M_PER_S: f64 = 299_792_458.0;
        let sample_period_s =
            f64::from(self.chip_period_fs) * 1e-15 / f64::from(self.samples_per_chip);
        phase_step * sample_period_s * LIGHT_M_PER_S / 2.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn paper_single() -> Identity {
        Identity {
            content: Content::Counts,
            layout: Layout { count_bits: 17, counts: 1, more_bits: 0 },
            detectors: 1,
            samples_per_chip: 8,
            chip_period_fs: 8_000_000,
            first_step: 0,
            steps: 16_376,
            code_chips: 2047,
            parallel: 1,
            accumulate: 1,
            text_blocks: 0,
            counts_samples: false,
            scene: [0x6a, 0x9f, 0xd8, 0x9c, 0x78, 0x5b, 0x0b, 0xa2],
        }
    }

    #[test]
    fn bytes_are_those_of_the_protocol() {
        let identity = paper_single();
        let bytes = identity.to_bytes();
        // docs/wire.md, "Identity".
        let expected = [
            1, 0, 17, 1, 0, 1, 8, 0, 0x00, 0x12, 0x7a, 0x00, 0, 0, 0, 0xf8, 0x3f, 0, 0xff, 0x07, 0,
            0, 1, 0, 0x6a, 0x9f, 0xd8, 0x9c, 0x78, 0x5b, 0x0b, 0xa2,
        ];
        assert_eq!(bytes, expected);
        assert_eq!(Identity::from_bytes(&bytes), Ok(identity));
        // Sums of 20 scans are told in byte 7, in which one scan is 0; blocks of text in byte 21, and counts by sample in its highest bit.
        let sums = Identity { accumulate: 20, text_blocks: 64, counts_samples: true, ..identity };
        let mut expected_sums = expected;
        (expected_sums[7], expected_sums[21]) = (20, 64 + 128);
        assert_eq!(sums.to_bytes(), expected_sums);
        assert_eq!(Identity::from_bytes(&expected_sums), Ok(sums));
        let verilog = identity.to_verilog();
        assert_eq!(verilog.len(), "256'h".len() + 64);
        assert!(
            verilog.starts_with("256'ha20b5b789cd89f6a0001") && verilog.ends_with("08010001110001"),
            "{verilog}"
        );
    }

    #[test]
    fn what_no_bridge_can_have_is_refused() {
        let good = paper_single().to_bytes();
        for (byte, value) in
            [(0, 2), (1, 3), (2, 0), (2, 65), (3, 0), (4, 65), (5, 0), (6, 0), (22, 0)]
        {
            let mut bytes = good;
            bytes[byte] = value;
            assert!(Identity::from_bytes(&bytes).is_err(), "byte {byte} = {value}");
        }
    }

    #[test]
    fn a_peak_at_the_scenes_distance_is_at_that_distance() {
        // 3.2 m and back are 21.35 ns: 21.35 steps of 1 ns.
        let distance = paper_single().distance_m(3.2 * 2.0 / 0.299_792_458);
        assert!((distance - 3.2).abs() < 1e-12, "{distance}");
    }

    #[test]
    fn places_follow_the_groups() {
        let identity = Identity { detectors: 2, steps: 5, parallel: 2, ..paper_single() };
        let places: Vec<_> = (0..identity.results_of_scan()).map(|k| identity.place(k)).collect();
        // Groups of steps 0 1, 2 3, 4; in each of them detector 0, then detector 1.
        let expected =
            [(0, 0), (0, 1), (1, 0), (1, 1), (0, 2), (0, 3), (1, 2), (1, 3), (0, 4), (1, 4)];
        assert_eq!(places, expected);
        let rows = Identity { content: Content::Rows, ..identity };
        assert_eq!([4, 5, 9].map(|k| rows.place(k)), [(0, 4), (1, 0), (1, 4)]);
    }
}
