//! What holds at the ports of the whole design, whatever is inside.

use super::harness::{Engine, Harness};
use crate::sensor::interface::{Direction, Interface};

/// AXI4-Stream's rules for a transmitter, and flags that stay.
pub(super) fn axis(interface: &Interface) -> Harness {
    let mut harness = Harness::new(
        interface,
        "axis",
        "In reset every output is 0. AXI4-Stream: a transfer on offer stays, unchanged, until it is taken\n\
         or reset. Flags stay until reset, the peak's ports until o_peak_valid.",
    )
    .engine(Engine::Reachability);
    harness.lines(
        "reg began = 1'b0;\n\
         reg reset_before;\n\
         reg waited;\n\
         reg held_last;\n\
         reg overran;\n\
         always @(posedge i_clk) begin\n    \
             began <= 1'b1;\n    \
             reset_before <= i_rst;\n    \
             waited <= m_axis_tvalid & ~m_axis_tready;\n    \
             held_last <= m_axis_tlast;\n    \
             overran <= o_overrun;\n\
         end\n\
         wire stays = began & ~reset_before;\n\
         always @* if (stays & waited) assert (m_axis_tvalid);\n\
         always @* if (stays & waited) assert (m_axis_tlast == held_last);\n\
         always @* if (stays & overran) assert (o_overrun);",
    );
    for port in interface.ports() {
        if port.direction == Direction::Output {
            harness.line(&format!("always @* if (~stays) assert ({} == 0);", port.name));
        }
    }
    harness.lines(&format!(
        "reg [{0}:0] held_data;\n\
         always @(posedge i_clk) held_data <= m_axis_tdata;\n\
         always @* if (stays & waited) assert (m_axis_tdata == held_data);",
        interface.tdata_bits - 1
    ));
    if interface.saturates() {
        harness.lines(
            "reg saturated;\n\
             always @(posedge i_clk) saturated <= o_saturated;\n\
             always @* if (stays & saturated) assert (o_saturated);",
        );
    }
    harness.reaches("stays & waited & overran");
    if let Some(peak) = interface.peak {
        let detectors = interface.reference_codes.len() as u32;
        harness.lines(&format!(
            "reg [{}:0] peak;\n\
             always @(posedge i_clk) peak <= {{o_peak_step, o_peak_count}};\n\
             always @* if (stays & ~o_peak_valid) assert ({{o_peak_step, o_peak_count}} == peak);",
            detectors * (peak.step_bits + peak.count_bits) - 1
        ));
    }
    harness
}

/// A clock of reset leaves nothing of what was before.
pub(super) fn reset(interface: &Interface) -> Harness {
    Harness::new(
        interface,
        "reset",
        "With i_rst high every register's next value is the one that the other proofs start from, whatever\n\
         the registers hold: one clock of reset leaves nothing of the state before, and no X. (The\n\
         assertions are those of registers.v, one for each register.)",
    )
    .engine(Engine::Reachability)
    .in_reset()
}
