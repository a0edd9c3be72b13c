//! A sensor's results on the serial line of `hdl/bridge/` (docs/wire.md): their bits, how much of the line they
//! take, and what the bridge has to know of the scene.

use goldtof_sensor::sensor::block_ram::BlockRam;
use goldtof_sensor::sensor::interface::{Counting, Interface};
use goldtof_wire::{Content, Identity, Layout, Load, MOST_RESULTS_OF_A_FRAME, Pace, Scans};
use thiserror::Error;

/// What of a sensor goes to the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sent {
    /// The result stream, `m_axis_*`.
    Results,
    /// The peak of each scan, `o_peak_*`: its step above its count, without padding. One detector.
    Peaks,
}

/// Results come faster than the line carries them.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{error}. What would fit: {advice}")]
pub struct SlowLine {
    /// How much faster.
    pub error: goldtof_wire::LineError,
    /// Keys of the scene, and the line, that would do.
    pub advice: String,
}

/// Scans whose results are added up between core and bridge (`hdl/bridge/result_accumulator.v`), and the
/// memory that this takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ScanSums {
    /// Scans of a sum, 2 or more.
    pub scans: u32,
    /// Results of a scan, all detectors together.
    pub results: u64,
    /// Bits of a result of one scan, `MORE_BITS` and `COUNT_BITS`.
    one: Layout,
    /// Bits of a sum.
    pub sum: Layout,
    /// The FIFO behind holds 2^n sums: they come in one scan, and leave in all.
    pub fifo_address_bits: u32,
}

/// Fewest and most results of a scan that can be added up.
const RESULTS_OF_SUMS: std::ops::RangeInclusive<u64> = 4..=1 << MOST_ADDRESS_BITS;
/// Most bits of an address of the bridge's memories.
const MOST_ADDRESS_BITS: u32 = 14;
/// Bits of an address of the bridge's FIFO.
const ADDRESS_BITS: u32 = 10;

/// What a bridge has at its other end, and in its device.
#[derive(Debug, Clone, Copy)]
pub struct SerialLine {
    /// How fast it is.
    pub pace: Pace,
    /// The device's block RAM.
    pub block_ram: BlockRam,
}

impl ScanSums {
    /// Those of a scene, if it has some that the bridge can make.
    pub fn of(interface: &Interface, pace: Pace) -> Option<ScanSums> {
        let one = Interface { accumulate: 1, ..interface.clone() };
        let scan = scans(&one, Sent::Results)?;
        if interface.accumulate < 2 || !RESULTS_OF_SUMS.contains(&scan.results) {
            return None;
        }
        let sum = layout(interface, Sent::Results)?;
        // What of a scan of sums has not left when its last one comes, and frames that fill meanwhile.
        let left = 1.0 / Scans { layout: sum, ..scan }.load(pace).share();
        let waiting = scan.results as f64 * (1.0 - left).max(0.0);
        let held = waiting as u64 + 2 * MOST_RESULTS_OF_A_FRAME;
        Some(ScanSums {
            scans: interface.accumulate,
            results: scan.results,
            one: scan.layout,
            sum,
            fifo_address_bits: address_bits(held).clamp(ADDRESS_BITS, MOST_ADDRESS_BITS),
        })
    }

    /// Bits that a sum has more than a count.
    fn scans_bits(&self) -> u32 {
        address_bits(self.scans.into())
    }

    /// Blocks of RAM for the sums and the FIFO, whose words have two flags.
    pub fn blocks(&self, block_ram: &BlockRam) -> u64 {
        let bits = self.sum.result_bits() as u32;
        block_ram.blocks_of(1 << address_bits(self.results), bits)
            + block_ram.blocks_of(1 << self.fifo_address_bits, bits + 2)
    }

    /// The accumulator's parameters, but for the stream that goes in.
    pub fn parameters(&self) -> Vec<(&'static str, u64)> {
        vec![
            ("ACCUMULATE", self.scans.into()),
            ("ACCUMULATE_BITS", self.scans_bits().into()),
            ("ACCUMULATE_RESULTS", self.results),
            ("ACCUMULATE_RESULTS_BITS", address_bits(self.results).into()),
            ("ACCUMULATE_COUNT_BITS", self.one.count_bits.into()),
            ("ACCUMULATE_MORE_BITS", self.one.more_bits.into()),
            ("ACCUMULATE_SUM_BITS", self.sum.result_bits() as u64),
            ("FIFO_ADDRESS_BITS", self.fifo_address_bits.into()),
        ]
    }
}

/// Bits of the numbers below `count`.
fn address_bits(count: u64) -> u32 {
    count.next_power_of_two().trailing_zeros()
}

/// Bits of a result; `None` if there is no such result: peaks without a peak detector, or of several
/// detectors.
pub fn layout(interface: &Interface, sent: Sent) -> Option<Layout> {
    let layout = |count_bits: u32, counts: u32, more_bits: u32| {
        let bits = |bits: u32| u8::try_from(bits).ok();
        let layout = Layout {
            count_bits: bits(count_bits)?,
            counts: bits(counts)?,
            more_bits: bits(more_bits)?,
        };
        layout.is_possible().then_some(layout)
    };
    match (sent, &interface.counting) {
        (Sent::Results, Counting::Correlator(correlator)) => {
            let more = address_bits(interface.accumulate.into());
            let total_bits = correlator.total.map_or(0, |total| total.bits + more);
            layout(correlator.count_bits + more, 1, total_bits)
        }
        (Sent::Results, Counting::Histogram(plan)) => layout(plan.bin_bits, plan.row_bins, 0),
        (Sent::Peaks, _) => {
            let peak = interface.peak().filter(|_| interface.reference_codes.len() == 1)?;
            layout(peak.count_bits, 1, peak.step_bits)
        }
    }
}

/// The results of scans, or of sums of scans, that follow one another without a pause; `None` as of [`layout`].
pub fn scans(interface: &Interface, sent: Sent) -> Option<Scans> {
    let layout = layout(interface, sent)?;
    let timing = &interface.timing;
    let chip_s = timing.clock.chip_period_ps * 1e-12;
    let detectors = interface.reference_codes.len() as u64;
    let (results, chips) = match &interface.counting {
        Counting::Correlator(_) => {
            let chips = interface.groups() as f64 * timing.scan.integration_chips as f64;
            let scans = if sent == Sent::Results { interface.accumulate } else { 1 };
            (timing.scan.steps, chips * f64::from(scans))
        }
        Counting::Histogram(plan) => (plan.rows, (plan.rows * plan.periods) as f64),
    };
    let results = match sent {
        Sent::Results => results * detectors,
        Sent::Peaks => 1,
    };
    Some(Scans { layout, results, period_s: chips * chip_s })
}

/// What the results take of a line.
///
/// # Errors
///
/// They come faster than the line carries them; the error says what would fit.
pub fn check_line(
    interface: &Interface,
    sent: Sent,
    line: &SerialLine,
) -> Result<Option<Load>, SlowLine> {
    let Some(scans) = scans(interface, sent) else { return Ok(None) };
    scans
        .load(line.pace)
        .check()
        .map(Some)
        .map_err(|error| SlowLine { advice: advice(interface, error.0, line), error })
}

/// The fewest scans whose sums the line carries and the device has memory for; `None` where there are none,
/// or where the scene has no place for the key.
fn accumulated(interface: &Interface, line: &SerialLine) -> Option<u32> {
    let correlator = interface.correlator()?;
    if interface.registers.is_some() || correlator.saturates() {
        return None;
    }
    let mut summed = interface.clone();
    let timing = &mut summed.timing;
    timing.scan = timing.scan.in_whole_periods(timing.code_chips());
    (2..=u8::MAX.into()).find(|&scans_of_sum| {
        summed.accumulate = scans_of_sum;
        let fits = scans(&summed, Sent::Results)
            .is_some_and(|scans| scans.load(line.pace).check().is_ok());
        fits && ScanSums::of(&summed, line.pace)
            .is_some_and(|sums| sums.blocks(&line.block_ram) <= line.block_ram.blocks)
    })
}

/// What would fit into a line that is too slow.
fn advice(interface: &Interface, load: Load, line: &SerialLine) -> String {
    let stretch = load.stretch();
    let timing = &interface.timing;
    let integration_us = timing.integration_ps() * 1e-6 * stretch;
    let mut advice = match interface.counting {
        Counting::Correlator(_) => {
            vec![format!("integration = \"{:.1} us\"", (integration_us * 10.0).ceil() / 10.0)]
        }
        // More code periods in each histogram, which the FPGA adds up.
        Counting::Histogram(plan) => {
            vec![format!("a histogram of {} code periods", (plan.periods as f64 * stretch).ceil())]
        }
    };
    if let Some(scans) = accumulated(interface, line) {
        advice.push(format!("accumulate = {scans} (sums of so many scans)"));
    }
    let parallel = (f64::from(timing.parallel) / stretch) as u32;
    if parallel > 0 && interface.correlator().is_some() {
        advice.push(format!("parallel = {parallel}"));
    }
    let peaks = scans(interface, Sent::Peaks).map(|scans| scans.load(line.pace).check().is_ok());
    match peaks {
        Some(true) => advice.push("peaks alone".to_owned()),
        None if interface.correlator().is_some() && interface.reference_codes.len() == 1 => {
            advice.push("peaks alone (peak_detector = true)".to_owned());
        }
        Some(false) | None => {}
    }
    advice.push(format!("a line of {:.0} baud", load.least_baud().ceil()));
    advice.join(", or ")
}

/// What the device says of itself. `chip_period_fs` is that of the board's clock, `scene_sha256` the digest in
/// hexadecimal digits. `None` as of [`layout`], or where a number does not fit.
pub fn identity(
    interface: &Interface,
    sent: Sent,
    chip_period_fs: u32,
    scene_sha256: &str,
) -> Option<Identity> {
    let scan = &interface.timing.scan;
    let small = |number: u64| u32::try_from(number).ok().filter(|number| *number < 1 << 24);
    let byte = |k: usize| u8::from_str_radix(scene_sha256.get(2 * k..2 * k + 2)?, 16).ok();
    let mut scene = [0; 8];
    for (k, place) in scene.iter_mut().enumerate() {
        *place = byte(k)?;
    }
    let (content, steps, first_step) = match (sent, &interface.counting) {
        (Sent::Results, Counting::Correlator(_)) => (Content::Counts, scan.steps, scan.first_step),
        (Sent::Results, Counting::Histogram(plan)) => (Content::Rows, plan.rows, 0),
        (Sent::Peaks, _) => (Content::Peaks, scan.steps, scan.first_step),
    };
    Some(Identity {
        content,
        layout: layout(interface, sent)?,
        detectors: u8::try_from(interface.reference_codes.len()).ok()?,
        samples_per_chip: u8::try_from(interface.lanes()).ok()?,
        chip_period_fs,
        first_step: small(first_step)?,
        steps: small(steps)?,
        code_chips: small(interface.timing.code_chips())?,
        parallel: u16::try_from(interface.parallel()).ok()?,
        accumulate: match sent {
            Sent::Results => u8::try_from(interface.accumulate).ok()?,
            Sent::Peaks => 1,
        },
        text_blocks: 0,
        counts_samples: false,
        scene,
    })
}

/// How results lie in `m_axis_tdata`, and what of them goes to the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packing {
    /// Bits of a result on the line.
    pub layout: Layout,
    /// Width of the stream.
    pub tdata_bits: u32,
    /// Bits from one count to the next.
    pub stride: u32,
    /// First bit of what is sent behind the counts.
    pub more_first_bit: u32,
    /// Whether the source can wait, so that none is dropped.
    pub waits: bool,
}

impl Packing {
    /// That of a scene's stream before the bridge; `None` as of [`layout`].
    pub fn of(interface: &Interface, sent: Sent) -> Option<Packing> {
        let layout = layout(interface, sent)?;
        let packed = layout.result_bits() as u32;
        let tdata_bits = interface.tdata_bits;
        let (tdata_bits, stride, more_first_bit, waits) = match (sent, &interface.counting) {
            // Sums are packed.
            (Sent::Results, Counting::Correlator(_)) if interface.accumulate > 1 => {
                (packed, packed, layout.count_bits.into(), false)
            }
            (Sent::Results, Counting::Correlator(correlator)) => {
                let first = correlator.total.map_or(0, |total| total.first_bit);
                (tdata_bits, tdata_bits, first, false)
            }
            (Sent::Results, Counting::Histogram(plan)) => {
                (tdata_bits, plan.bin_data_bits(), 0, true)
            }
            (Sent::Peaks, _) => (packed, packed, layout.count_bits.into(), false),
        };
        Some(Packing { layout, tdata_bits, stride, more_first_bit, waits })
    }

    /// The bits of a word of the stream that go to the line, of which the lowest 32 come first.
    pub fn packed(&self, tdata: &[u32]) -> u128 {
        let Layout { count_bits, counts, more_bits } = self.layout;
        let counts = (0..counts).map(|k| (u32::from(k) * self.stride, count_bits));
        let fields = counts.chain([(self.more_first_bit, more_bits)]);
        let bits = fields.flat_map(|(first, bits)| first..first + u32::from(bits));
        bits.zip(0..).fold(0, |packed, (bit, place)| {
            packed | u128::from(tdata[bit as usize / 32] >> (bit % 32) & 1) << place
        })
    }
}

/// The bridge's parameters that follow from the scene, as Verilog writes them; `None` as of [`layout`].
pub fn bridge_parameters(
    interface: &Interface,
    sent: Sent,
    identity: &Identity,
) -> Option<Vec<(&'static str, String)>> {
    let packing = Packing::of(interface, sent)?;
    let layout = packing.layout;
    let parameter = |name, value: u32| (name, value.to_string());
    Some(vec![
        parameter("TDATA_BITS", packing.tdata_bits),
        parameter("COUNT_BITS", layout.count_bits.into()),
        parameter("COUNTS", layout.counts.into()),
        parameter("COUNT_STRIDE", packing.stride),
        parameter("MORE_FIRST_BIT", packing.more_first_bit),
        parameter("MORE_BITS", layout.more_bits.into()),
        parameter("BACK_PRESSURE", packing.waits.into()),
        ("IDENTITY", identity.to_verilog()),
    ])
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use goldtof_sensor::scene::FpgaTarget;
    use goldtof_sensor::sensor::block_ram::block_ram;

    use super::*;

    const LINE: SerialLine = SerialLine {
        pace: Pace { baud: 3_000_000, clocks_per_bit: 30 },
        block_ram: block_ram(FpgaTarget::Ecp525k6),
    };

    /// The interface of a standard scene with other keys.
    fn interface(scene: &str, set: &[(&str, &str)]) -> Interface {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(scene);
        let mut text = std::fs::read_to_string(path).expect("the scene is there");
        for (from, to) in set {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        let scene = goldtof_sensor::scene::parse(scene, &text).expect("the scene is fine");
        Interface::of(&scene)
    }

    #[test]
    fn table_i_fits_three_megabaud_and_sixteen_steps_at_once_do_not() {
        let one = interface("paper-single.toml", &[]);
        let load =
            check_line(&one, Sent::Results, &LINE).expect("it fits").expect("there are results");
        assert!((load.results_per_s - 1.0 / 104.8e-6).abs() < 1e-6, "{load:?}");

        let sixteen = interface("paper-single.toml", &[("parallel = 1 ", "parallel = 16 ")]);
        let error = check_line(&sixteen, Sent::Results, &LINE).unwrap_err();
        // 13 steps at once fit, 14 do not; as little as a step of 13/16 of the time.
        assert!(error.advice.contains(", or parallel = 13, or "), "{error}");
        for (parallel, fits) in [(13, true), (14, false)] {
            let other = interface(
                "paper-single.toml",
                &[("parallel = 1 ", &format!("parallel = {parallel} "))],
            );
            assert_eq!(check_line(&other, Sent::Results, &LINE).is_ok(), fits, "{parallel}");
        }
        // Nor do they alone, but their peaks do.
        assert!(error.advice.contains("peaks alone (peak_detector = true)"), "{error}");
    }

    #[test]
    fn the_fewest_scans_that_fit_are_told_and_fit() {
        let sixteen = [("parallel = 1 ", "parallel = 16 ")];
        let error = check_line(&interface("paper-single.toml", &sixteen), Sent::Results, &LINE)
            .unwrap_err();
        assert!(error.advice.contains(", or accumulate = 2 (sums"), "{error}");
        let summed =
            interface("paper-single.toml", &[("parallel = 1 ", "accumulate = 2\nparallel = 16 ")]);
        let load = check_line(&summed, Sent::Results, &LINE).expect("it fits").expect("results");
        // Frames of 255 sums of 18 bits have 588 bytes; 16 steps take 6 code periods of 2,047 chips, twice.
        let results_per_s = 16.0 / (2.0 * 12_282.0 * 8e-9);
        assert!((load.share() - results_per_s / 255.0 * 5_880.0 / 3e6).abs() < 0.001, "{load:?}");
        let sums = ScanSums::of(&summed, LINE.pace).expect("there are sums");
        // |count| <= 2 x 49,128 < 2^17, and a sign.
        assert_eq!((sums.sum.count_bits, sums.results), (18, 16_376));
        // Of a scan's 16,376 sums the line carries 80 % while they come: 3,290 and two frames wait, in 4,096.
        assert_eq!(sums.fifo_address_bits, 12);
        // 18 blocks of 16,384 x 1, five of 4,096 x 4.
        assert_eq!(sums.blocks(&LINE.block_ram), 18 + 5);
        // Where the device has fewer, the key is not named.
        let small = SerialLine { block_ram: LINE.block_ram.of_device("DP16KD", 22), ..LINE };
        let error = check_line(&interface("paper-single.toml", &sixteen), Sent::Results, &small)
            .unwrap_err();
        assert!(!error.advice.contains("accumulate"), "{error}");
    }

    #[test]
    fn what_the_bridge_is_told_follows_from_the_scene() {
        let totals = interface(
            "paper-single.toml",
            &[("parallel = 1 ", "total_counts = true\nparallel = 1 ")],
        );
        let digest = "6a9fd89c785b0ba22a3b03795e3fb35817b5682c9389afb69fa6f8f812888df5";
        let identity = identity(&totals, Sent::Results, 8_000_000, digest).expect("it is small");
        assert_eq!(identity.scene, [0x6a, 0x9f, 0xd8, 0x9c, 0x78, 0x5b, 0x0b, 0xa2]);
        assert_eq!((identity.steps, identity.code_chips, identity.parallel), (16_376, 2047, 1));
        // |count| <= 13,100 * 4 = 52,400: 17 bits and 16, in 24 and 16 of m_axis_tdata.
        let parameters =
            bridge_parameters(&totals, Sent::Results, &identity).expect("there are results");
        for (name, value) in [
            ("TDATA_BITS", "40"),
            ("COUNT_BITS", "17"),
            ("MORE_FIRST_BIT", "24"),
            ("MORE_BITS", "16"),
        ] {
            assert!(parameters.contains(&(name, value.to_owned())), "{name} {parameters:?}");
        }
    }

    #[test]
    fn a_histograms_rows_are_too_many_for_a_frame_of_115_us() {
        let histogram = interface("histogram.toml", &[]);
        let error = check_line(&histogram, Sent::Results, &LINE).unwrap_err();
        assert!(error.advice.contains("a histogram of "), "{error}");
        // The advice holds: so many code periods fit, and one fewer does not.
        let periods: f64 =
            error.advice.split(' ').nth(3).expect("a number").parse().expect("a number");
        let scans = scans(&histogram, Sent::Results).expect("there are rows");
        let plan = histogram.histogram().expect("it is one");
        let share = |periods: f64| {
            Scans { period_s: scans.period_s * periods / plan.periods as f64, ..scans }
                .load(LINE.pace)
                .check()
                .is_ok()
        };
        assert!(share(periods) && !share(periods - 1.0), "{error}");
    }
}
