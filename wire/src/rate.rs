use thiserror::Error;

use crate::{CRC_BYTES, Layout, RESULTS_HEADER_BYTES};

/// Most results of a frame.
pub const MOST_RESULTS_OF_A_FRAME: u64 = 255;

/// Share of the line that results may take: the rest is for answers, and for clocks that differ.
const MOST_SHARE: f64 = 0.95;

/// Bits of a byte on the line: start, eight of data, stop.
const BITS_OF_A_BYTE: f64 = 10.0;

/// Clocks of the line's side in which the bridge finds a frame's next result (`hdl/bridge/framer.v`).
const CLOCKS_OF_A_RESULT: f64 = 3.0;

/// Bits for which a line rests before a full frame of so many results: the bridge looks for them while the CRC of the
/// frame before is sent.
pub fn rest_bits(results: u64, clocks_per_bit: u32) -> f64 {
    let found = CLOCKS_OF_A_RESULT * results as f64 / f64::from(clocks_per_bit);
    (found - CRC_BYTES as f64 * BITS_OF_A_BYTE).max(0.0)
}

/// A line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// Bits per second.
    pub baud: u32,
    /// Clocks in a bit.
    pub clocks_per_bit: u32,
}

/// The results of a sensor that measures without a pause.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scans {
    /// Bits of a result.
    pub layout: Layout,
    /// Results of a scan, or of a histogram's frame, all detectors together.
    pub results: u64,
    /// Time of a scan in seconds.
    pub period_s: f64,
}

/// What results take of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Load {
    /// Results per second.
    pub results_per_s: f64,
    /// Bits per second on the line, start and stop bits and the rest between frames included.
    pub line_bits_per_s: f64,
    /// Bits per second that the line has.
    pub baud: u32,
}

/// Results come faster than the line carries them.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "{:.0} results per second take {:.0} bits per second of the serial line, start and stop bits included; \
     {} baud carry {:.0} (95 %)",
    .0.results_per_s, .0.line_bits_per_s, .0.baud, MOST_SHARE * f64::from(.0.baud)
)]
pub struct LineError(pub Load);

impl Scans {
    /// Bits of a scan on a line where frames are as full as they become: a frame ends with its scan.
    pub fn line_bits(&self, pace: Pace) -> f64 {
        let bits = |results: u64| {
            let payload = self.layout.payload_bytes(results as usize);
            let bytes = RESULTS_HEADER_BYTES + payload + CRC_BYTES;
            bytes as f64 * BITS_OF_A_BYTE + rest_bits(results, pace.clocks_per_bit)
        };
        let rest = self.results % MOST_RESULTS_OF_A_FRAME;
        let full = (self.results / MOST_RESULTS_OF_A_FRAME) as f64 * bits(MOST_RESULTS_OF_A_FRAME);
        if rest > 0 { full + bits(rest) } else { full }
    }

    /// What the results take of a line.
    pub fn load(&self, pace: Pace) -> Load {
        Load {
            results_per_s: self.results as f64 / self.period_s,
            line_bits_per_s: self.line_bits(pace) / self.period_s,
            baud: pace.baud,
        }
    }
}

impl Load {
    /// Share of the line, 1 for all of it.
    pub fn share(&self) -> f64 {
        self.line_bits_per_s / f64::from(self.baud)
    }

    /// Whether the line carries the results, with 5 % to spare.
    ///
    /// # Errors
    ///
    /// It does not.
    pub fn check(self) -> Result<Load, LineError> {
        if self.share() <= MOST_SHARE { Ok(self) } else { Err(LineError(self)) }
    }

    /// The least baud rate that would do.
    pub fn least_baud(&self) -> f64 {
        self.line_bits_per_s / MOST_SHARE
    }

    /// How much longer a scan would have to take.
    pub fn stretch(&self) -> f64 {
        (self.share() / MOST_SHARE).max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With so many clocks in a bit that the line never rests.
    const LINE: Pace = Pace { baud: 3_000_000, clocks_per_bit: 30 };

    fn scans(count_bits: u8, results: u64, period_s: f64) -> Scans {
        Scans { layout: Layout { count_bits, counts: 1, more_bits: 0 }, results, period_s }
    }

    #[test]
    fn a_scan_of_table_i_takes_six_percent_of_three_megabaud() {
        // 16,376 results of 17 bits, each after 104.8 us: 64 frames of 255 (542 + 14 bytes) and one of 56
        // (119 + 14): 35,717 bytes in 1.7162 s.
        let scans = scans(17, 16_376, 16_376.0 * 104.8e-6);
        assert_eq!(scans.line_bits(LINE), 10.0 * (64.0 * 556.0 + 133.0));
        let load = scans.load(LINE).check().unwrap();
        assert!((load.share() - 35_717.0 * 10.0 / 1.716_205 / 3e6).abs() < 1e-6, "{load:?}");
    }

    #[test]
    fn sixteen_steps_at_once_are_too_many_and_the_message_says_what_the_line_has() {
        let error = scans(17, 16_376, 16_376.0 * 104.8e-6 / 16.0).load(LINE).check().unwrap_err();
        assert_eq!(
            error.to_string(),
            "152672 results per second take 3329859 bits per second of the serial line, start and stop bits \
             included; 3000000 baud carry 2850000 (95 %)"
        );
        assert!((error.0.least_baud() - 3_505_115.0).abs() < 1.0, "{}", error.0.least_baud());
        assert!((error.0.stretch() - 3_329_859.0 / 2_850_000.0).abs() < 1e-6);
    }

    #[test]
    fn short_scans_pay_for_their_headers() {
        // A peak of 17 and 14 bits for each scan: 14 + 4 bytes.
        let scans = Scans {
            layout: Layout { count_bits: 17, counts: 1, more_bits: 14 },
            results: 1,
            period_s: 1e-3,
        };
        assert_eq!(scans.line_bits(LINE), 180.0);
    }

    #[test]
    fn a_line_of_few_clocks_in_a_bit_rests_between_frames() {
        // 255 results of 4 bits: 142 bytes. They are found in 765 clocks, 191.25 bits, 40 of which are the CRC's.
        let scans = scans(4, 255, 1.0);
        let bits = |clocks_per_bit| scans.line_bits(Pace { clocks_per_bit, ..LINE });
        assert_eq!(bits(4), 1_420.0 + 151.25);
        assert_eq!(bits(9), 1_420.0 + 45.0);
        assert_eq!(bits(20), 1_420.0);
    }
}
