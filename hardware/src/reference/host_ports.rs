//! The ports of an AXI4-Lite slave: what a host drives, and what it sees.

use std::ops::Range;

use crate::sensor::port::PortRole;

/// What a host drives at a clock.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct HostInputs {
    /// `s_axil_awvalid`, and the address that is there whether or not it is.
    pub write_address_valid: bool,
    /// `s_axil_awaddr`.
    pub write_address: u16,
    /// `s_axil_wvalid`.
    pub write_valid: bool,
    /// `s_axil_wdata`.
    pub write_data: u32,
    /// `s_axil_wstrb`.
    pub write_strobe: u8,
    /// `s_axil_bready`.
    pub write_response_ready: bool,
    /// `s_axil_arvalid`.
    pub read_address_valid: bool,
    /// `s_axil_araddr`.
    pub read_address: u16,
    /// `s_axil_rready`.
    pub read_ready: bool,
}

impl HostInputs {
    /// What a port has; 0 of those that a host does not drive.
    pub fn of(&self, role: PortRole) -> u64 {
        match role {
            PortRole::WriteAddress => self.write_address.into(),
            PortRole::WriteAddressValid => self.write_address_valid.into(),
            PortRole::WriteData => self.write_data.into(),
            PortRole::WriteStrobe => self.write_strobe.into(),
            PortRole::WriteValid => self.write_valid.into(),
            PortRole::WriteResponseReady => self.write_response_ready.into(),
            PortRole::ReadAddress => self.read_address.into(),
            PortRole::ReadAddressValid => self.read_address_valid.into(),
            PortRole::ReadReady => self.read_ready.into(),
            _ => 0,
        }
    }

    /// Changes what a port has; those that a host does not drive are passed over.
    pub fn set(&mut self, role: PortRole, value: u64) {
        let is_high = value & 1 == 1;
        match role {
            PortRole::WriteAddress => self.write_address = value as u16,
            PortRole::WriteAddressValid => self.write_address_valid = is_high,
            PortRole::WriteData => self.write_data = value as u32,
            PortRole::WriteStrobe => self.write_strobe = value as u8,
            PortRole::WriteValid => self.write_valid = is_high,
            PortRole::WriteResponseReady => self.write_response_ready = is_high,
            PortRole::ReadAddress => self.read_address = value as u16,
            PortRole::ReadAddressValid => self.read_address_valid = is_high,
            PortRole::ReadReady => self.read_ready = is_high,
            _ => {}
        }
    }
}

/// Clocks at which a host drives something, in order, disjoint; at all others it drives 0.
pub type HostClocks = Vec<(Range<u64>, HostInputs)>;

/// What the slave shows a host.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct HostOutputs {
    /// `s_axil_awready` and `s_axil_wready`.
    pub write_ready: bool,
    /// `s_axil_bvalid`.
    pub write_response_valid: bool,
    /// Whether `s_axil_bresp` is SLVERR.
    pub write_error: bool,
    /// `s_axil_arready`.
    pub read_address_ready: bool,
    /// `s_axil_rvalid`.
    pub read_valid: bool,
    /// Whether `s_axil_rresp` is SLVERR.
    pub read_error: bool,
    /// `s_axil_rdata`.
    pub read_data: u32,
}
