//! The ports of `sensor_top`: one table of what each is for, its width, what drives an input
//! and when an output counts. Who adds a port adds a row here.

use serde::Serialize;

use super::interface::Interface;
use super::registers::ADDRESS_BITS;

/// A port of `sensor_top`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, schemars::JsonSchema)]
pub struct Port {
    /// What it is for.
    #[serde(skip)]
    pub role: PortRole,
    /// Name in the Verilog.
    pub name: String,
    /// `input` or `output`.
    pub direction: Direction,
    /// Bits.
    #[serde(rename = "width_bits")]
    pub width: u32,
}

/// Direction of a port, seen from the hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Driven from outside.
    Input,
    /// Driven by the hardware.
    Output,
}

/// What a port is for. Of each role a sensor has one port or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PortRole {
    /// The chip clock.
    Clock,
    /// Synchronous reset.
    Reset,
    /// Chips of the sources' codes.
    Laser,
    /// First chip of the reference code's period.
    Epoch,
    /// Sampled levels of the inputs.
    Samples,
    /// The result on the stream.
    Data,
    /// A result is there.
    Valid,
    /// The receiver takes it.
    Ready,
    /// It is a scan's last.
    Last,
    /// A result was lost.
    Overrun,
    /// A count was saturated.
    Saturated,
    /// Phase step of a scan's largest count.
    PeakStep,
    /// A scan's largest count.
    PeakCount,
    /// A scan's peak has come.
    PeakValid,
    /// AXI4-Lite: address that is written to.
    WriteAddress,
    /// It is there.
    WriteAddressValid,
    /// It is taken.
    WriteAddressReady,
    /// Word that is written.
    WriteData,
    /// Which of its bytes.
    WriteStrobe,
    /// It is there.
    WriteValid,
    /// It is taken.
    WriteReady,
    /// What came of a write.
    WriteResponse,
    /// That is known.
    WriteResponseValid,
    /// The host takes it.
    WriteResponseReady,
    /// Address that is read.
    ReadAddress,
    /// It is there.
    ReadAddressValid,
    /// It is taken.
    ReadAddressReady,
    /// Word that was read.
    ReadData,
    /// What came of a read.
    ReadResponse,
    /// That is known.
    ReadValid,
    /// The host takes it.
    ReadReady,
}

/// What drives a port, or what it follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
    /// An input that toggles once a clock.
    Clock,
    /// An input with the detectors' pulses.
    Samples,
    /// An input that rests at a level; a stimulus says when it has the other one.
    Level {
        /// The level at which it rests, in all bits.
        rest: bool,
    },
    /// An input that a host drives: 0 but where the stimulus says otherwise.
    Host,
    /// An output that changes from chip to chip with a code, and is compared at every clock.
    Code,
    /// An output that changes with results, and is compared at every clock.
    Result,
    /// The same, of which the interface promises nothing while `m_axis_tvalid` is low.
    Payload,
}

/// A row of the table.
struct Declaration {
    role: PortRole,
    name: &'static str,
    usage: Use,
    /// Bits; none where a sensor has no such port.
    width: fn(&Interface) -> Option<u32>,
}

const fn row(
    role: PortRole,
    name: &'static str,
    usage: Use,
    width: fn(&Interface) -> Option<u32>,
) -> Declaration {
    Declaration { role, name, usage, width }
}

/// All ports, in the order of the Verilog, which is that of the roles.
const PORTS: [Declaration; 31] = [
    row(PortRole::Clock, "i_clk", Use::Clock, |_| Some(1)),
    row(PortRole::Reset, "i_rst", Use::Level { rest: false }, |_| Some(1)),
    row(PortRole::Laser, "o_laser", Use::Code, |of| Some(of.source_codes.len() as u32)),
    row(PortRole::Epoch, "o_epoch", Use::Code, |_| Some(1)),
    row(PortRole::Samples, "i_samples", Use::Samples, |of| Some(of.lanes() * of.inputs() as u32)),
    row(PortRole::Data, "m_axis_tdata", Use::Payload, |of| Some(of.tdata_bits)),
    row(PortRole::Valid, "m_axis_tvalid", Use::Result, |_| Some(1)),
    row(PortRole::Ready, "m_axis_tready", Use::Level { rest: true }, |_| Some(1)),
    row(PortRole::Last, "m_axis_tlast", Use::Payload, |_| Some(1)),
    row(PortRole::Overrun, "o_overrun", Use::Result, |_| Some(1)),
    row(PortRole::Saturated, "o_saturated", Use::Result, |of| of.saturates().then_some(1)),
    row(PortRole::PeakStep, "o_peak_step", Use::Result, |of| {
        of.peak().map(|peak| detectors(of) * peak.step_bits)
    }),
    row(PortRole::PeakCount, "o_peak_count", Use::Result, |of| {
        of.peak().map(|peak| detectors(of) * peak.count_bits)
    }),
    row(PortRole::PeakValid, "o_peak_valid", Use::Result, |of| of.peak().map(|_| 1)),
    row(PortRole::WriteAddress, "s_axil_awaddr", Use::Host, |of| of_registers(of, ADDRESS_BITS)),
    row(PortRole::WriteAddressValid, "s_axil_awvalid", Use::Host, |of| of_registers(of, 1)),
    row(PortRole::WriteAddressReady, "s_axil_awready", Use::Result, |of| of_registers(of, 1)),
    row(PortRole::WriteData, "s_axil_wdata", Use::Host, |of| of_registers(of, 32)),
    row(PortRole::WriteStrobe, "s_axil_wstrb", Use::Host, |of| of_registers(of, 4)),
    row(PortRole::WriteValid, "s_axil_wvalid", Use::Host, |of| of_registers(of, 1)),
    row(PortRole::WriteReady, "s_axil_wready", Use::Result, |of| of_registers(of, 1)),
    row(PortRole::WriteResponse, "s_axil_bresp", Use::Result, |of| of_registers(of, 2)),
    row(PortRole::WriteResponseValid, "s_axil_bvalid", Use::Result, |of| of_registers(of, 1)),
    row(PortRole::WriteResponseReady, "s_axil_bready", Use::Host, |of| of_registers(of, 1)),
    row(PortRole::ReadAddress, "s_axil_araddr", Use::Host, |of| of_registers(of, ADDRESS_BITS)),
    row(PortRole::ReadAddressValid, "s_axil_arvalid", Use::Host, |of| of_registers(of, 1)),
    row(PortRole::ReadAddressReady, "s_axil_arready", Use::Result, |of| of_registers(of, 1)),
    row(PortRole::ReadData, "s_axil_rdata", Use::Result, |of| of_registers(of, 32)),
    row(PortRole::ReadResponse, "s_axil_rresp", Use::Result, |of| of_registers(of, 2)),
    row(PortRole::ReadValid, "s_axil_rvalid", Use::Result, |of| of_registers(of, 1)),
    row(PortRole::ReadReady, "s_axil_rready", Use::Host, |of| of_registers(of, 1)),
];

/// Bits of a port of the registers.
fn of_registers(interface: &Interface, bits: u32) -> Option<u32> {
    interface.registers.as_ref().map(|_| bits)
}

fn detectors(interface: &Interface) -> u32 {
    interface.reference_codes.len() as u32
}

impl PortRole {
    /// That of a port of this name, whether or not a sensor at hand has it.
    pub fn of(name: &str) -> Option<PortRole> {
        PORTS.iter().find(|row| row.name == name).map(|row| row.role)
    }

    /// The port's name in the Verilog.
    pub const fn name(self) -> &'static str {
        PORTS[self as usize].name
    }

    /// What drives the port, or what it follows.
    pub const fn usage(self) -> Use {
        PORTS[self as usize].usage
    }

    /// Direction of the port.
    pub const fn direction(self) -> Direction {
        match self.usage() {
            Use::Clock | Use::Samples | Use::Level { .. } | Use::Host => Direction::Input,
            Use::Code | Use::Result | Use::Payload => Direction::Output,
        }
    }

    /// Whether the interface promises nothing of it while `m_axis_tvalid` is low.
    pub fn is_payload(self) -> bool {
        self.usage() == Use::Payload
    }

    /// The port, of so many bits.
    pub fn port(self, width: u32) -> Port {
        Port { role: self, name: self.name().to_owned(), direction: self.direction(), width }
    }
}

impl Interface {
    /// Ports of `sensor_top`, in the order of the Verilog.
    pub fn ports(&self) -> Vec<Port> {
        PORTS.iter().filter_map(|row| Some(row.role.port((row.width)(self)?))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_role_has_its_row() {
        for (number, row) in PORTS.iter().enumerate() {
            assert_eq!(row.role as usize, number, "{}", row.name);
            assert_eq!(PortRole::of(row.name), Some(row.role));
        }
        assert_eq!(PortRole::of("i_other"), None);
    }
}
