//! A sensor's results on the serial line of `hdl/bridge/` (docs/wire.md): their bits, how much of the line they
//! take, and what the bridge has to know of the scene.

use goldtof_sensor::sensor::interface::{Counting, Interface};
use goldtof_wire::{Content, Identity, Layout, Load, Scans};
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
            layout(correlator.count_bits, 1, correlator.total.map_or(0, |total| total.bits))
        }
        (Sent::Results, Counting::Histogram(plan)) => layout(plan.bin_bits, plan.row_bins, 0),
        (Sent::Peaks, _) => {
            let peak = interface.peak().filter(|_| interface.reference_codes.len() == 1)?;
            layout(peak.count_bits, 1, peak.step_bits)
        }
    }
}

/// The results of scans that follow one another without a pause; `None` as of [`layout`].
pub fn scans(interface: &Interface, sent: Sent) -> Option<Scans> {
    let layout = layout(interface, sent)?;
    let timing = &interface.timing;
    let chip_s = timing.clock.chip_period_ps * 1e-12;
    let detectors = interface.reference_codes.len() as u64;
    let (results, chips) = match &interface.counting {
        Counting::Correlator(_) => {
            (timing.scan.steps, interface.groups() as f64 * timing.scan.integration_chips as f64)
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
pub fn check_line(interface: &Interface, sent: Sent, baud: u32) -> Result<Option<Load>, SlowLine> {
    let Some(scans) = scans(interface, sent) else { return Ok(None) };
    scans
        .load(baud)
        .check()
        .map(Some)
        .map_err(|error| SlowLine { advice: advice(interface, error.0), error })
}

/// What would fit into a line that is too slow.
fn advice(interface: &Interface, load: Load) -> String {
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
    let parallel = (f64::from(timing.parallel) / stretch) as u32;
    if parallel > 0 && interface.correlator().is_some() {
        advice.push(format!("parallel = {parallel}"));
    }
    let peaks = scans(interface, Sent::Peaks).map(|scans| scans.load(load.baud).check().is_ok());
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
        scene,
    })
}

/// The bridge's parameters that follow from the scene, as Verilog writes them; `None` as of [`layout`].
pub fn bridge_parameters(
    interface: &Interface,
    sent: Sent,
    identity: &Identity,
) -> Option<Vec<(&'static str, String)>> {
    let layout = layout(interface, sent)?;
    let (tdata_bits, stride, more_first_bit, waits) = match (sent, &interface.counting) {
        (Sent::Results, Counting::Correlator(correlator)) => {
            let first = correlator.total.map_or(0, |total| total.first_bit);
            (interface.tdata_bits, interface.tdata_bits, first, false)
        }
        (Sent::Results, Counting::Histogram(plan)) => {
            (interface.tdata_bits, plan.bin_data_bits(), 0, true)
        }
        (Sent::Peaks, _) => {
            let bits = layout.result_bits() as u32;
            (bits, bits, layout.count_bits.into(), false)
        }
    };
    let parameter = |name, value: u32| (name, value.to_string());
    Some(vec![
        parameter("TDATA_BITS", tdata_bits),
        parameter("COUNT_BITS", layout.count_bits.into()),
        parameter("COUNTS", layout.counts.into()),
        parameter("COUNT_STRIDE", stride),
        parameter("MORE_FIRST_BIT", more_first_bit),
        parameter("MORE_BITS", layout.more_bits.into()),
        parameter("BACK_PRESSURE", waits.into()),
        ("IDENTITY", identity.to_verilog()),
    ])
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

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
        let load = check_line(&one, Sent::Results, 3_000_000)
            .expect("it fits")
            .expect("there are results");
        assert!((load.results_per_s - 1.0 / 104.8e-6).abs() < 1e-6, "{load:?}");

        let sixteen = interface("paper-single.toml", &[("parallel = 1 ", "parallel = 16 ")]);
        let error = check_line(&sixteen, Sent::Results, 3_000_000).unwrap_err();
        // 13 steps at once fit, 14 do not; as little as a step of 13/16 of the time.
        assert!(error.advice.contains(", or parallel = 13, or "), "{error}");
        for (parallel, fits) in [(13, true), (14, false)] {
            let other = interface(
                "paper-single.toml",
                &[("parallel = 1 ", &format!("parallel = {parallel} "))],
            );
            assert_eq!(check_line(&other, Sent::Results, 3_000_000).is_ok(), fits, "{parallel}");
        }
        // Nor do they alone, but their peaks do.
        assert!(error.advice.contains("peaks alone (peak_detector = true)"), "{error}");
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
        let error = check_line(&histogram, Sent::Results, 3_000_000).unwrap_err();
        assert!(error.advice.contains("a histogram of "), "{error}");
        // The advice holds: so many code periods fit, and one fewer does not.
        let periods: f64 =
            error.advice.split(' ').nth(3).expect("a number").parse().expect("a number");
        let scans = scans(&histogram, Sent::Results).expect("there are rows");
        let plan = histogram.histogram().expect("it is one");
        let share = |periods: f64| {
            Scans { period_s: scans.period_s * periods / plan.periods as f64, ..scans }
                .load(3_000_000)
                .check()
                .is_ok()
        };
        assert!(share(periods) && !share(periods - 1.0), "{error}");
    }
}
