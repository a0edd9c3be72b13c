//! What the hardware promises at its ports: widths, latency, order of results.
//!
//! Both sides build on this and on nothing else in common: the emitter makes
//! Verilog that keeps it, the reference model predicts ports from it.

use std::sync::Arc;

use serde::Serialize;

use crate::code::Code;
use crate::scene::{Scan, Scene};

/// The hardware that a scene needs, as seen from outside.
#[derive(Debug, Clone)]
pub struct Contract {
    /// Samples per clock and detector, S.
    pub lanes: u32,
    /// Code of each source; bit m of `o_laser` carries source m's chips.
    pub source_codes: Vec<Arc<Code>>,
    /// Code of each detector's reference; lanes d S .. (d + 1) S of
    /// `i_samples` belong to detector d.
    pub reference_codes: Vec<Arc<Code>>,
    /// Phase steps and integration time.
    pub scan: Scan,
    /// Phase steps correlated at once.
    pub parallel: u32,
    /// Bits of a signed count that no stimulus can overflow:
    /// |count| <= D max(1, S / 2), because a rising edge needs a low sample.
    pub exact_count_bits: u32,
    /// Bits of the signed count in a result; less than `exact_count_bits` means
    /// that it saturates.
    pub count_bits: u32,
    /// Bits of `m_axis_tdata`: the count, sign-extended to whole bytes.
    pub tdata_bits: u32,
    /// Clocks from the one at which a step's last sample word is on
    /// `i_samples` to the one after which `m_axis_tvalid` shows its count.
    pub result_latency_clocks: u32,
}

/// A port of `sensor_top`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Port {
    /// Name in the Verilog.
    pub name: String,
    /// `input` or `output`.
    pub direction: Direction,
    /// Bits.
    pub width: u32,
}

/// Direction of a port, seen from the hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Driven from outside.
    Input,
    /// Driven by the hardware.
    Output,
}

impl Contract {
    /// Derives the contract from a scene.
    pub fn of(scene: &Scene) -> Contract {
        let lanes = scene.samples_per_chip;
        let most_hits = u128::from(scene.scan.integration_chips) * u128::from((lanes / 2).max(1));
        let exact_count_bits = signed_bits(most_hits);
        let count_bits = scene
            .hardware
            .counter_width
            .map_or(exact_count_bits, |bits| bits.min(exact_count_bits));
        Contract {
            lanes,
            source_codes: scene.sources.iter().map(|s| s.code.clone()).collect(),
            reference_codes: scene
                .detectors
                .iter()
                .map(|d| scene.sources[d.reference].code.clone())
                .collect(),
            scan: scene.scan,
            parallel: scene.hardware.parallel,
            exact_count_bits,
            count_bits,
            tdata_bits: count_bits.div_ceil(8) * 8,
            result_latency_clocks: Self::result_latency(lanes, count_bits < exact_count_bits),
        }
    }

    /// The pipeline, stage by stage: hits, lane pairs, one adder level per
    /// halving of the pairs, total, result, and the clamp where it exists.
    fn result_latency(lanes: u32, saturates: bool) -> u32 {
        let pairs = lanes.div_ceil(2);
        let adder_levels = pairs.next_power_of_two().trailing_zeros();
        let (hits, lane_pairs, total, result) = (1, 1, 1, 1);
        hits + lane_pairs + adder_levels + total + result + u32::from(saturates) - 1
    }

    /// Whether counts can saturate, so that the clamp and its flag exist.
    pub fn saturates(&self) -> bool {
        self.count_bits < self.exact_count_bits
    }

    /// Whether a scan is followed by a pause until the next epoch. Only scans
    /// over the whole period end where they began.
    pub fn realigns(&self) -> bool {
        !self.scan.is_full()
    }

    /// Ports of `sensor_top`, in the order of the Verilog.
    pub fn ports(&self) -> Vec<Port> {
        use Direction::{Input, Output};
        let port = |name: &str, direction, width| Port {
            name: name.to_owned(),
            direction,
            width,
        };
        let mut ports = vec![
            port("i_clk", Input, 1),
            port("i_rst", Input, 1),
            port("o_laser", Output, self.source_codes.len() as u32),
            port("o_epoch", Output, 1),
            port(
                "i_samples",
                Input,
                self.lanes * self.reference_codes.len() as u32,
            ),
            port("m_axis_tdata", Output, self.tdata_bits),
            port("m_axis_tvalid", Output, 1),
            port("m_axis_tready", Input, 1),
            port("m_axis_tlast", Output, 1),
            port("o_overrun", Output, 1),
        ];
        if self.saturates() {
            ports.push(port("o_saturated", Output, 1));
        }
        ports
    }
}

/// Bits of a two's complement number that holds -magnitude..=magnitude.
fn signed_bits(magnitude: u128) -> u32 {
    129 - magnitude.leading_zeros()
}
