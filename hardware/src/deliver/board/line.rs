//! A scene's results on the line to the host: their bits, how many come, and what the device says of
//! itself.

use goldtof_wire::{Content, Identity, Layout, LineError, Load, Scans};

use super::error::BoardError;
use super::table::Board;
use crate::sensor::Sensor;
use crate::sensor::interface::{Counting, Interface};

/// A second field of `m_axis_tdata`, behind the count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct More {
    pub(super) first_bit: u32,
    pub(super) bits: u32,
}

/// The total count, where there is one.
pub(super) fn more(interface: &Interface) -> More {
    interface.total().map_or(More { first_bit: 0, bits: 0 }, |total| More {
        first_bit: total.first_bit,
        bits: total.bits,
    })
}

/// Bits of a count, or of a histogram's whole row.
pub(super) fn count_bits(interface: &Interface) -> u32 {
    match &interface.counting {
        Counting::Correlator(counts) => counts.count_bits,
        Counting::Histogram(plan) => plan.row_data_bits(),
    }
}

fn layout(interface: &Interface) -> Layout {
    let (count_bits, counts) = match &interface.counting {
        Counting::Correlator(counts) => (counts.count_bits, 1),
        Counting::Histogram(plan) => (plan.bin_data_bits(), plan.row_bins),
    };
    // At most 64, 16 and 64 (sensor::histogram, deliver::limits).
    Layout {
        count_bits: count_bits as u8,
        counts: counts as u8,
        more_bits: more(interface).bits as u8,
    }
}

/// Results of a scan: a count of each step, or a row of each chip, of all detectors.
fn steps(interface: &Interface) -> u64 {
    match &interface.counting {
        Counting::Correlator(_) => interface.timing.scan.steps,
        Counting::Histogram(plan) => plan.rows,
    }
}

/// What the results take of the board's line.
///
/// # Errors
/// When it is more than the line carries.
pub(super) fn load(sensor: &Sensor, board: &'static Board) -> Result<Load, BoardError> {
    let interface = sensor.interface();
    let timing = sensor.timing();
    let detectors = sensor.scene().detectors.len() as u64;
    let period_chips = match &interface.counting {
        Counting::Correlator(_) => timing.scan_pitch_chips() as f64,
        Counting::Histogram(_) => timing.scan.integration_chips as f64,
    };
    let scans = Scans {
        layout: layout(interface),
        results: steps(interface) * detectors,
        period_s: timing.clock.ps(period_chips) * 1e-12,
    };
    scans.load(board.baud).check().map_err(|LineError(load)| BoardError::Line {
        board: board.title,
        line: LineError(load).to_string(),
        integration_us: (sensor.timing().integration_ps() * load.stretch() / 1e6).ceil(),
    })
}

/// What the device says of itself.
pub(super) fn identity(sensor: &Sensor) -> Identity {
    let interface = sensor.interface();
    let timing = sensor.timing();
    let digest = sensor.scene().reference().origin.sha256;
    let byte = |nth: usize| {
        digest.get(2 * nth..2 * nth + 2).and_then(|digits| u8::from_str_radix(digits, 16).ok())
    };
    Identity {
        content: match interface.counting {
            Counting::Correlator(_) => Content::Counts,
            Counting::Histogram(_) => Content::Rows,
        },
        layout: layout(interface),
        detectors: sensor.scene().detectors.len() as u8,
        samples_per_chip: timing.clock.samples_per_chip as u8,
        chip_period_fs: (timing.clock.chip_period_ps * 1e3).round() as u32,
        first_step: timing.scan.first_step as u32,
        steps: steps(interface) as u32,
        code_chips: timing.code_chips() as u32,
        parallel: timing.parallel as u16,
        // Of a scene that was made in a program there is no text, and so no digest.
        scene: std::array::from_fn(|nth| byte(nth).unwrap_or(0)),
    }
}
