//! What goes with the Verilog into an FPGA team's flow: a self-checking testbench
//! with its vectors, clock constraints, a file list and a FuseSoC core.

mod constraints;
mod core;
mod header;
mod run_length;
mod stimulus;
mod testbench;
mod vhdl;

pub(crate) use stimulus::adversary as testbench_adversary;

use serde::Serialize;

use super::emission::{Design, EmittedFile};
use super::error::HdlError;
use super::formal::Formal;
use crate::reference::cover_report::Coverage;

/// Files round the design, by role. In JSON a file is its name.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Flow {
    /// The testbench that compares every output port at every clock.
    pub testbench: Testbench,
    /// The clock, in the languages of the tools.
    pub constraints: Constraints,
    /// The widths of the ports as macros, for Verilog round the design.
    pub header: EmittedFile,
    /// The top module as a component, for VHDL round the design.
    pub vhdl: EmittedFile,
    /// The design's files, for `-f` of simulators and linters.
    pub file_list: EmittedFile,
    /// FuseSoC core description (CAPI2).
    pub core: EmittedFile,
}

/// The testbench and how much it covers.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Testbench {
    /// Its top module.
    pub top: String,
    /// Its Verilog.
    pub files: Vec<EmittedFile>,
    /// The design's files and the testbench's, for `-f`.
    pub file_list: EmittedFile,
    /// What its Verilog reads at run time, from the folder it runs in.
    pub vectors: Vec<EmittedFile>,
    /// Clocks that it runs and compares.
    pub clocks: u64,
    /// Phase steps whose integration ends within these clocks.
    pub phase_steps: u64,
    /// Scans whose last phase step ends within these clocks.
    pub scans: u64,
    /// Hits that count up in the results that come to the stream, each once for
    /// every phase step that sees it.
    pub hits_up: u64,
    /// Hits that count down.
    pub hits_down: u64,
    /// How much of what the sensor can be made to do it covers.
    pub coverage: Coverage,
}

/// Clock constraints.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Constraints {
    /// Synopsys Design Constraints.
    pub sdc: EmittedFile,
    /// Lattice preference file, as nextpnr-ecp5 reads it.
    pub lpf: EmittedFile,
    /// Xilinx Design Constraints.
    pub xdc: EmittedFile,
}

impl Flow {
    /// All that goes with a design.
    ///
    /// # Errors
    /// When the reference model cannot predict the ports of this interface.
    pub(super) fn of(design: &Design, formal: &Formal) -> Result<Flow, HdlError> {
        let testbench = testbench::testbench(design)?;
        let constraints = constraints::constraints(design);
        let header = header::header(design);
        let file_list = core::file_list(design);
        let parts = core::Parts {
            header: &header,
            testbench: &testbench,
            constraints: &constraints,
            formal,
        };
        let core = core::core(design, &parts);
        Ok(Flow {
            testbench,
            constraints,
            header,
            vhdl: vhdl::package(design),
            file_list,
            core,
        })
    }

    /// Every file, in no order that matters.
    pub fn files(&self) -> impl Iterator<Item = &EmittedFile> {
        let constraints = &self.constraints;
        self.testbench
            .files
            .iter()
            .chain(&self.testbench.vectors)
            .chain([&constraints.sdc, &constraints.lpf, &constraints.xdc])
            .chain([&self.header, &self.vhdl, &self.file_list])
            .chain([&self.testbench.file_list, &self.core])
    }
}
