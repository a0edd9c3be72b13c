//! The ports of an AXI4-Lite slave: what a host drives, and what it sees.

use std::ops::Range;

use crate::sensor::port::Role;

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
    pub fn of(&self, role: Role) -> u64 {
        match role {
            Role::WriteAddress => self.write_address.into(),
            Role::WriteAddressValid => self.write_address_valid.into(),
            Role::WriteData => self.write_data.into(),
            Role::WriteStrobe => self.write_strobe.into(),
            Role::WriteValid => self.write_valid.into(),
            Role::WriteResponseReady => self.write_response_ready.into(),
            Role::ReadAddress => self.read_address.into(),
            Role::ReadAddressValid => self.read_address_valid.into(),
            Role::ReadReady => self.read_ready.into(),
            _ => 0,
        }
    }

    /// Changes what a port has; those that a host does not drive are passed over.
    pub fn set(&mut self, role: Role, value: u64) {
        let is_high = value & 1 == 1;
        match role {
            Role::WriteAddress => self.write_address = value as u16,
            Role::WriteAddressValid => self.write_address_valid = is_high,
            Role::WriteData => self.write_data = value as u32,
            Role::WriteStrobe => self.write_strobe = value as u8,
            Role::WriteValid => self.write_valid = is_high,
            Role::WriteResponseReady => self.write_response_ready = is_high,
            Role::ReadAddress => self.read_address = value as u16,
            Role::ReadAddressValid => self.read_address_valid = is_high,
            Role::ReadReady => self.read_ready = is_high,
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
